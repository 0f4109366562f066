//! The table of shading options. Each option is declared only here.

use super::numbers::{whole, within};
use super::option::{Json, Panel, Slider, Spec, Techniques, Text, Value, headings, on_off};
use super::shading::{BaseFrame, DiffuseLights, FresnelForm, GridLod, LodBias, PixelKernel, Probes, Quadrature};
use super::technique::Technique;
use super::terms::Terms;
use crate::frame::Layer;
use crate::named;
use leadr_gpu::SpecValue;
use leadr_maps::tonemap::Tonemap;
use leadr_reflectance::integrals::slope_nodes::NodePlacement;
use leadr_reflectance::masking::occlusion::{ConeAxis, ConeEdge, ConeLobe, Hidden};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::materials::diffuse_models::DiffuseModel;

named! {
    Technique: Self::ALL;
    Tonemap: Self::ALL;
    Layer: Self::ALL;
    DiffuseModel: Self::ALL;
    NodePlacement: Self::ALL;
    Hidden: Self::ALL;
    ConeEdge: Self::ALL;
    ConeLobe: Self::ALL;
    ConeAxis: Self::ALL;
    Shadowing: [Self::NormalMap, Self::None, Self::SmithSeparable, Self::Smith, Self::Correlated, Self::VGroove];
}

/// What a scene must contain for an option to have an effect.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Subject {
    /// The scene may contain anything.
    Anything,
    /// The scene must contain objects, not only a sea.
    Objects,
    /// The scene must contain relief that is displaced by heights.
    Relief,
}

/// A shading option, which is a row of [`ShadingOptions::ALL`].
pub struct ShadingOption {
    /// The description of the option.
    pub spec: Spec,
    /// The accessor of the value.
    pub value: Value<ShadingOptions>,
    /// The techniques that have the option.
    pub techniques: Techniques,
    /// What the scene must contain for the option to have an effect.
    pub subject: Subject,
    /// The neutral value. Techniques without the option accept this value, because it changes nothing.
    pub neutral: Option<&'static str>,
    /// The specialisation constant of `passes/shade/settings.glsl` that the option sets: whether a switch is on, or the index of a name.
    pub(super) constant: Option<&'static str>,
    /// The JSON value for techniques without the option, if it is not the default.
    json_without: Option<&'static str>,
}

const fn row(spec: Spec, value: Value<ShadingOptions>, techniques: Techniques) -> ShadingOption {
    let (subject, neutral, constant, json_without) = (Subject::Anything, None, None, None);
    ShadingOption { spec, value, techniques, subject, neutral, constant, json_without }
}

const fn shading(name: &'static str, value_name: &'static str, help: &'static str) -> Spec {
    Spec::new(headings::SHADING, name, value_name, help)
}

#[rustfmt::skip]
impl ShadingOption {
    const fn about(self, subject: Subject) -> Self { Self { subject, ..self } }
    const fn constant(self, name: &'static str) -> Self { Self { constant: Some(name), ..self } }
    const fn neutral(self, value: &'static str) -> Self { Self { neutral: Some(value), ..self } }
}

impl ShadingOption {
    /// Whether a technique has this option.
    pub fn applies_to(&self, technique: Technique) -> bool {
        (self.techniques.has)(technique)
    }

    /// Returns the specialisation constant that the option sets, with its value for a technique.
    pub(super) fn spec(&self, technique: Technique, options: ShadingOptions) -> Option<(&'static str, SpecValue)> {
        let index = |name| self.value.names(options).iter().position(|&(known, _)| known == name);
        let value = match self.json(technique, options) {
            Some(Json::Name(name)) => SpecValue::I32(index(name)? as i32),
            value => SpecValue::Bool(value == Some(Json::Bool(true))),
        };
        Some((self.constant?, value))
    }

    /// Returns the value as JSON. For techniques without the option, switches are off, and other values are at their defaults.
    pub fn json(&self, technique: Technique, options: ShadingOptions) -> Option<Json> {
        match (&self.value, self.json_without) {
            _ if self.applies_to(technique) => self.value.json(options),
            (Value::Switch(_) | Value::Flag(..), _) => Some(Json::Bool(false)),
            (_, Some(name)) => Some(Json::Name(name)),
            _ => self.value.json(ShadingOptions::default()),
        }
    }
}

const LIT: Techniques = Techniques { has: Technique::is_lit };
const INTEGRALS: Techniques = Techniques { has: Technique::integrates };
const BECKMANN: Techniques = Techniques { has: Technique::has_base_frame };
const KERNEL: Techniques = Techniques { has: Technique::has_pixel_kernel };
const COVARIANCE: Techniques = Techniques { has: Technique::has_relief_color };
const BASE: Techniques = Techniques { has: Technique::has_diffuse_model };
const CONES: Techniques = Techniques { has: Technique::has_cones };
const FILTERING: Techniques = Techniques { has: |technique| !technique.is_reference() };
const RAYS: Techniques = Techniques { has: Technique::has_relief_shadows };

/// Declares each field once, with its type, its default and its flags.
macro_rules! shading_options {
    ($($(#[$doc:meta])* $field:ident: $type:ty = $default:expr => [$($row:expr),+ $(,)?];)*) => {
        /// The options of all techniques. Each technique uses the options that apply to it ([`Technique::with`]).
        #[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
        pub struct ShadingOptions {
            $($(#[$doc])* pub $field: $type,)*
        }

        impl Default for ShadingOptions {
            fn default() -> Self {
                Self { $($field: $default,)* }
            }
        }

        impl ShadingOptions {
            /// All options, in the order of the help.
            pub const ALL: &[ShadingOption] = &[$($($row,)+)*];

            /// Returns the options that `technique` has. All other options are at their defaults.
            pub(super) fn of(self, technique: Technique) -> Self {
                let default = Self::default();
                $(let [row, ..] = const { &[$($row),+] };
                let $field = if row.applies_to(technique) { self.$field } else { default.$field };)*
                Self { $($field,)* }
            }
        }
    };
}

shading_options! {
    /// The rule that places the samples of the integrals over visible slopes.
    quadrature: Quadrature = Quadrature::VisibleSlopes(Probes::Sixteen) => [
        row(shading("rule", "grid|visible", "Sample the integrals over slopes on the paper's grid, or where the viewer sees (--probes)")
                .default("grid with --grid, else visible").panel(Panel::Own),
            Value::Text(Text {
                read: |options, text| {
                    let rules = [Quadrature::PAPER, Quadrature::VisibleSlopes(Probes::Sixteen)];
                    let rule = rules.into_iter().find(|rule| rule.name() == text).ok_or("use grid or visible")?;
                    options.quadrature = rule;
                    Ok(())
                },
                write: |_| None,
                json: |options| Some(Json::Name(options.quadrature.name())),
            }), INTEGRALS),
        row(shading("grid", "N", "Sample N by N slopes per pixel, 1 to 128").default("5 with --rule grid").panel(Panel::Own),
            Value::Text(Text {
                read: |options, text| whole(text, 1, Quadrature::MAX_GRID).map(|side| options.quadrature = Quadrature::Grid(side)),
                write: |options| options.quadrature.side().map(|side| side.to_string()),
                json: |options| options.quadrature.side().map(Json::Count),
            }), INTEGRALS),
        row(shading("probes", "N", "Look the environment up 5, 9 or 16 times per pixel").common().panel(Panel::Own),
            Value::Text(Text {
                read: |options, text| {
                    let probes = text.parse().ok().and_then(Probes::of).ok_or("use 5, 9 or 16 probes")?;
                    options.quadrature = Quadrature::VisibleSlopes(probes);
                    Ok(())
                },
                write: |options| options.quadrature.probes().map(|probes| probes.count().to_string()),
                json: |options| options.quadrature.probes().map(|probes| Json::Count(probes.count())),
            }), INTEGRALS),
    ];
    /// The level of detail of the environment at the nodes of a grid.
    grid_lod: GridLod = GridLod::Matched => [
        row(shading("grid-lod", "KIND", "Choose how blurred the nodes of --grid see the environment").called("blur of grid nodes"),
            Value::Name(|options| &mut options.grid_lod), INTEGRALS),
    ];
    /// The placement of the samples of a grid.
    grid_nodes: NodePlacement = NodePlacement::Grid => [
        row(shading("grid-nodes", "KIND", "Choose where the N by N samples of --grid lie").called("grid samples"),
            Value::Name(|options| &mut options.grid_nodes), INTEGRALS).constant("GRID_NODES"),
    ];
    /// The model of the shadowing of visible facets.
    shadowing: Shadowing = Shadowing::Correlated => [
        row(shading("shadowing", "MODEL", "Choose how facets below a pixel shadow each other").called("facet shadows").common()
                .default("correlated; normal-map for a material of normals without heights").formerly("masking").key("masking"),
            Value::Name(|options| &mut options.shadowing), INTEGRALS),
    ];
    /// The light terms that are on.
    terms: Terms = Terms::ALL => [
        row(shading("terms", "all|TERM,...",
                "Include only some of the light: specular-lights, diffuse-lights, specular-environment, diffuse-environment")
                .panel(Panel::Own),
            Value::Text(Text {
                read: |options, text| Terms::named(text).map(|terms| options.terms = terms),
                write: |options| Some(options.terms.to_string()),
                json: |options| Some(Json::Names(options.terms.names().collect())),
            }), LIT).neutral("all"),
    ];
    /// How the diffuse term of the sun and of point lights is integrated.
    diffuse_lights: DiffuseLights = DiffuseLights::Cosine => [
        row(shading("diffuse-lights", "KIND", "Choose how diffuse facets reflect the sun and point lights").called("matte sunlight"),
            Value::Name(|options| &mut options.diffuse_lights), INTEGRALS),
    ];
    /// The frame in which the base roughness applies.
    base_frame: BaseFrame = BaseFrame::Facet => [
        ShadingOption { json_without: Some("macro"), ..row(
            shading("base-frame", "KIND", "Choose the frame in which the base material is rough").called("roughness follows"),
            Value::Name(|options| &mut options.base_frame), BECKMANN) },
    ];
    /// The Fresnel term of facets and coats.
    fresnel: FresnelForm = FresnelForm::Schlick => [
        row(shading("fresnel", "FORM", "Choose the Fresnel term of the facets").called("Fresnel term"),
            Value::Name(|options| &mut options.fresnel), LIT).constant("FRESNEL"),
    ];
    /// How to add the variation of the macrosurface's normal across a pixel to the roughness (Tokuyoshi & Kaplanyan 2019, on
    /// meshes only). The option also widens slopes that face away from the viewer, towards the viewer (`tilt_to_edge`). The LEADR
    /// paper does neither. All other integrating techniques always widen slopes.
    pixel_kernel: PixelKernel = PixelKernel::Normal => [
        row(shading("pixel-kernel", "KIND", "Choose how the curvature of the smooth surface under a pixel adds roughness").called("curvature adds roughness"),
            Value::Name(|options| &mut options.pixel_kernel), KERNEL).about(Subject::Objects),
    ];
    /// Whether bumps larger than a pixel occlude the environment and the lights ([`leadr_reflectance::visible::horizon`]). This
    /// effect is not in the LEADR paper.
    relief_occlusion: bool = true => [
        row(shading("relief-occlusion", "on|off", "Let bumps larger than a pixel occlude the environment and the lights").called("bumps block light"),
            Value::Switch(|options| &mut options.relief_occlusion), INTEGRALS).about(Subject::Relief),
    ];
    /// Whether colours that follow the heights or slopes of the relief separate classes of facets, so that they are weighted by what is
    /// visible and lit. Scenes pass this option to [`Object::with_relief_color`](crate::scene::Object::with_relief_color), before the
    /// classes are found; the renderer does not read it. Materials with charts keep the mean colour.
    /// This effect is not in the LEADR paper.
    relief_color: bool = false => [
        row(shading("relief-color", "on|off", "Weight colours that follow heights or slopes by what is visible and lit").called("colours follow bumps"),
            Value::Switch(|options| &mut options.relief_color), COVARIANCE).about(Subject::Relief),
    ];
    /// Whether relief with several classes of facets, such as tops, walls and bottoms, is shaded class by class instead of as one
    /// Gaussian of slopes ([`leadr_maps::derive::classes`]). This effect is not in the LEADR paper.
    classes: bool = true => [
        row(shading("classes", "on|off", "Shade the tops, walls and bottoms of hard-edged relief as classes of their own").called("classes of facets").common(),
            Value::Switch(|options| &mut options.classes), COVARIANCE).about(Subject::Relief),
    ];
    /// Whether the facets of the relief send light to each other ([`leadr_reflectance::integrals::interreflection`]). This effect is not
    /// in the LEADR paper.
    interreflection: bool = false => [
        row(shading("interreflection", "on|off", "Add light that bumps reflect to each other").called("light between bumps").common(),
            Value::Switch(|options| &mut options.interreflection), COVARIANCE).about(Subject::Relief).constant("INTERREFLECTION"),
    ];
    /// The reflection of the diffuse base, and whether light scatters more than once between the facets of the base
    /// ([`leadr_reflectance::materials::diffuse_models`]). The LEADR paper has Lambertian facets only.
    diffuse_model: DiffuseModel = DiffuseModel::Lambert => [
        row(shading("diffuse-model", "MODEL", "Choose how the rough base below the specular term reflects light").called("diffuse base").common(),
            Value::Name(|options| &mut options.diffuse_model), BASE).constant("DIFFUSE_MODEL"),
        row(shading("multiscattering", "on|off", "on: the same as --diffuse-model multiscattering").default("off")
                .panel(Panel::Without("the diffuse base has the choice")),
            Value::Text(Text {
                read: |options, text| {
                    if on_off(text)? {
                        options.diffuse_model = DiffuseModel::Multiscattering;
                    }
                    Ok(())
                },
                write: |_| None,
                json: |options| Some(Json::Bool(options.diffuse_model == DiffuseModel::Multiscattering)),
            }), BASE).neutral("off"),
    ];
    /// The light of the directions that a material's occlusion cones hide.
    cone_occluders: Hidden = Hidden::SameRadiance => [
        row(shading("cone-occluders", "LIGHT", "Choose the light from the directions that occlusion cones hide").called("hidden by cones"),
            Value::Name(|options| &mut options.cone_occluders), CONES).constant("CONE_OCCLUDERS"),
    ];
    /// How suns and lamps fade outside a material's occlusion cones.
    cone_edge: ConeEdge = ConeEdge::Soft => [
        row(shading("cone-edge", "EDGE", "Choose how lights fade outside occlusion cones").called("edge of cones"),
            Value::Name(|options| &mut options.cone_edge), CONES).constant("CONE_EDGE"),
    ];
    /// The axis of the cone that shadows suns and lamps.
    cone_axis: ConeAxis = ConeAxis::Bent => [
        row(shading("cone-axis", "AXIS", "Choose the axis of the cone that shadows lights").called("axis of cones"),
            Value::Name(|options| &mut options.cone_axis), CONES).constant("CONE_AXIS"),
    ];
    /// The cone that hides the specular reflection of the environment.
    cone_lobe: ConeLobe = ConeLobe::Bent => [
        row(shading("cone-lobe", "CONE", "Choose the cone that hides the specular reflection of the environment").called("cone for reflections"),
            Value::Name(|options| &mut options.cone_lobe), CONES).constant("CONE_LOBE"),
    ];
    /// Whether large shapes occlude the environment (`render::light::sky_visibility`), if shadows are drawn. This effect is not in
    /// the LEADR paper.
    sky_occlusion: bool = false => [
        row(shading("sky-occlusion", "on|off", "Let large shapes occlude the environment").called("large shapes block the sky").default("on; off with --relief-shadows"),
            Value::Switch(|options| &mut options.sky_occlusion), LIT)
            .about(Subject::Objects).neutral("off").constant("SKY_OCCLUSION"),
    ];
    /// Whether the relief casts shadows under every light and under the environment (`render::passes::reference`), instead of the
    /// sun's coarse shadow map alone. Relief shadows are slow.
    relief_shadows: bool = false => [
        row(shading("relief-shadows", "", "Let bumps cast shadows on each other; slow, needs many samples").called("bumps cast shadows (slow)"),
            Value::Flag(|options| &mut options.relief_shadows, true), RAYS).about(Subject::Relief),
    ];
    /// The number of edge samples per sample, from 1 (none) to [`MAX_EDGE_SAMPLES`](Self::MAX_EDGE_SAMPLES). The geometry is
    /// sampled again at these positions. Samples on a different surface from the pixel's own are shaded too, which smooths
    /// silhouettes like the same number of samples per pixel. The inside of a surface does not change (`render::passes::edges`).
    /// Multiples of 16 are fastest. The samples per pixel of the reference already smooth silhouettes.
    edge_samples: u32 = 1 => [
        row(Spec::new(headings::QUALITY, "edge-samples", "N",
                "Sample the geometry N times per sample for smooth silhouettes; each surface in a pixel is shaded once. \
                 Fastest: 16, 64, 256").called("edge samples").common(),
            Value::Count(|options| &mut options.edge_samples, [1, ShadingOptions::MAX_EDGE_SAMPLES],
                Slider { ends: [1.0, 64.0], decimals: 0, unit: "" }), FILTERING).neutral("1"),
    ];
    /// The number of levels by which maps are read coarser than the pixels require. The footprint of a pixel becomes wider by a factor
    /// of `2^X`, so the moments of the relief include more slopes. The displaced geometry does not change.
    lod_bias: LodBias = LodBias(0.0) => [
        row(Spec::new(headings::QUALITY, "lod-bias", "X", "Read the maps X levels coarser than pixels require, or finer if X is below 0"),
            Value::Number(|options| &mut options.lod_bias.0, |text| within(text, -LodBias::MOST, LodBias::MOST),
                Slider { ends: [-2.0, 8.0], decimals: 1, unit: " levels" }), FILTERING)
            .about(Subject::Objects).neutral("0"),
    ];
}

impl ShadingOptions {
    /// The maximum number of edge samples.
    pub const MAX_EDGE_SAMPLES: u32 = 256;
}
