//! The shading of surfaces: a technique with exactly the settings that apply to it.

use std::fmt;
use std::hash::{Hash, Hasher};

use serde::{Serialize, Serializer};

use super::option::Json;
use super::shading_options::ShadingOptions;
use super::technique::{Needs, Technique};
use super::terms::Terms;
use crate::named_enum;
use leadr_gpu::SpecValue;
use leadr_maps::limits::MAX_SIDE;
use leadr_reflectance::integrals::slope_nodes::NodePlacement;
use leadr_reflectance::integrals::specular::{
    LOD_ALGORITHM_1, LOD_MATCHED, LOD_SUPPLEMENT, LOD_SUPPLEMENT_5, LOD_SUPPLEMENT_32,
};
use leadr_reflectance::masking::shadowing::Shadowing;

/// The rule that places the samples of the integrals over visible slopes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quadrature {
    /// The paper's grid of `N × N` slopes. `N` is from 1 to [`MAX_GRID`](Self::MAX_GRID).
    Grid(u32),
    /// The rules for visible slopes, with this many probes of the environment.
    VisibleSlopes(Probes),
}

impl Quadrature {
    /// The grid of 5×5 slopes, with which the paper's pictures are drawn.
    pub const PAPER: Self = Self::Grid(5);

    /// The maximum number of slopes along one side of the grid.
    pub const MAX_GRID: u32 = 128;

    /// Returns the number of environment lookups per pixel. There is one lookup for each slope or probe.
    pub const fn samples(self) -> u32 {
        match self {
            Self::Grid(n) => n * n,
            Self::VisibleSlopes(probes) => probes.count(),
        }
    }

    /// Returns the number of slopes along one side of the grid, or `None` for other rules.
    #[must_use]
    pub const fn side(self) -> Option<u32> {
        if let Self::Grid(side) = self { Some(side) } else { None }
    }

    /// Returns the number of probes of a rule for visible slopes, or `None` for a grid.
    #[must_use]
    pub const fn probes(self) -> Option<Probes> {
        if let Self::VisibleSlopes(probes) = self { Some(probes) } else { None }
    }

    /// Returns the name of the rule on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Grid(_) => "grid",
            Self::VisibleSlopes(_) => "visible",
        }
    }
}

/// The number of environment probes. Rules exist for these numbers only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Probes {
    /// The rule has five probes.
    Five = 5,
    /// The rule has nine probes.
    Nine = 9,
    /// The rule has sixteen probes.
    Sixteen = 16,
}

impl Probes {
    /// All numbers of probes, smallest first.
    pub const ALL: [Self; 3] = [Self::Five, Self::Nine, Self::Sixteen];

    /// Returns the number of probes.
    pub const fn count(self) -> u32 {
        self as u32
    }

    /// Returns the rule with `count` probes, if there is such a rule.
    pub fn of(count: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|probes| probes.count() == count)
    }
}

named_enum! {
    /// How the light of the sun and of point lights is integrated on the diffuse base.
    pub enum DiffuseLights {
        /// The integral uses the clamped cosine of each slope.
        Cosine = "cosine", "The clamped cosine of each slope";
        /// The integral uses order-2 spherical harmonics (Algorithm 2 of the LEADR paper), with errors of up to 9 %.
        Sh = "sh", "Order-2 spherical harmonics, as in the LEADR paper; up to 9 % off";
    }
}

named_enum! {
    /// The frame in which the base roughness applies.
    pub enum BaseFrame {
        /// The roughness applies in the frame of each facet, as on a real material (`reflectance::facets::base_roughness`).
        Facet = "facet", "The frame of each facet, as on a real material";
        /// The roughness applies in the frame of the macrosurface, as in the LEADR paper. Steep relief is then up to 25 % too dark
        /// seen from above, and too bright at grazing angles.
        Macro = "macro", "The frame of the smooth surface, as in the LEADR paper; darker on steep relief";
    }
}

named_enum! {
    /// The Fresnel term of facets and coats. Measured materials have terms of their own.
    pub enum FresnelForm {
        /// Schlick's approximation, minus the edge tint of metals.
        Schlick = "schlick", "Schlick's approximation, with the edge tint of metals";
        /// The Fresnel equations, for the index of refraction that the reflectance and the edge tint give
        /// ([`leadr_reflectance::facets::complex_index`]).
        Exact = "exact", "The Fresnel equations of dielectrics and metals (thesis Table 2.I)";
    }
}

named_enum! {
    /// The additive constant of the level of detail at which the nodes of a grid look the environment up
    /// ([`leadr_reflectance::integrals::specular::env_lod`]).
    pub enum GridLod {
        /// The level's texels have the solid angle of the node.
        Matched = "matched", "-0.53: texels as large as the solid angle of a node";
        /// The constant that section 3.5 of LEADR's supplement derives.
        Derivation = "derivation", "-1.48: the derivation in section 3.5 of LEADR's supplement";
        /// The supplement's constant against banding with a grid of 32×32.
        Banding32 = "banding-32", "-0.5: the supplement's choice against banding on 32x32 nodes";
        /// The supplement's constant against banding with a grid of 5×5.
        Banding5 = "banding-5", "0.5: the supplement's choice against banding on 5x5 nodes";
        /// The constant of the supplement's simplified Algorithm 1.
        Algorithm1 = "algorithm-1", "-1.83: the supplement's simplified Algorithm 1";
    }
}

impl GridLod {
    /// Returns the constant.
    pub const fn constant(self) -> f64 {
        match self {
            Self::Matched => LOD_MATCHED,
            Self::Derivation => LOD_SUPPLEMENT,
            Self::Banding32 => LOD_SUPPLEMENT_32,
            Self::Banding5 => LOD_SUPPLEMENT_5,
            Self::Algorithm1 => LOD_ALGORITHM_1,
        }
    }
}

named_enum! {
    /// How the rotation of the macrosurface under a pixel becomes roughness
    /// ([`leadr_reflectance::slopes::geometric_antialiasing`]).
    pub enum PixelKernel {
        /// The kernel of the normal, at the mean slope, for all light. It narrows over rough slopes.
        Normal = "on", "The rotation of the normal, for all light";
        /// Lights have the kernel of the half vector, one for each light (Tokuyoshi & Kaplanyan 2019). All other light has the kernel
        /// of the normal.
        HalfVector = "half-vector", "The change of the half vector, one kernel per light (IGSA); other light as with on";
        /// No kernel, as in the LEADR paper.
        Off = "off", "None, as in the LEADR paper";
    }
}

/// The number of levels by which the maps are read coarser than the pixels require. Negative numbers read finer levels.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LodBias(pub f32);

impl LodBias {
    /// The largest bias in either direction, which is the number of levels of the largest map.
    pub const MOST: f32 = MAX_SIDE.ilog2() as f32;
}

// The command line accepts no NaN.
impl Eq for LodBias {}

impl Hash for LodBias {
    fn hash<H: Hasher>(&self, state: &mut H) {
        // Zero has two representations.
        (self.0 + 0.0).to_bits().hash(state);
    }
}

/// A technique with its options. [`Technique::with`] makes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Shading {
    technique: Technique,
    /// The options. Those that the technique does not have are at their defaults.
    options: ShadingOptions,
}

impl Technique {
    /// Returns the technique with the `options` that apply to it.
    #[must_use]
    pub fn with(self, options: ShadingOptions) -> Shading {
        Shading { technique: self, options: options.of(self).consistent() }
    }
}

impl ShadingOptions {
    /// Returns the options that the shadowing model and the pixel kernel support. V-grooves shadow each facet by itself, which only sums
    /// over a grid include. Like separable Smith shadowing, they have no classes. Kernels per light need filtering and shading in one pass,
    /// which edge samples divide.
    fn consistent(mut self) -> Self {
        if self.pixel_kernel == PixelKernel::HalfVector {
            self.edge_samples = 1;
        }
        match (self.shadowing, self.quadrature) {
            (Shadowing::VGroove, quadrature) => Self {
                quadrature: if quadrature.side().is_some() { quadrature } else { Quadrature::PAPER },
                grid_nodes: NodePlacement::Grid,
                diffuse_lights: DiffuseLights::Cosine,
                classes: false,
                ..self
            },
            (Shadowing::SmithSeparable, _) => Self { classes: false, ..self },
            _ => self,
        }
    }
}

impl From<Technique> for Shading {
    fn from(technique: Technique) -> Self {
        technique.with(ShadingOptions::default())
    }
}

impl Default for Shading {
    fn default() -> Self {
        Technique::Leadr.into()
    }
}

impl Shading {
    /// Returns the technique.
    pub fn technique(&self) -> Technique {
        self.technique
    }

    /// Returns the options. Options that the technique does not have are at their defaults.
    pub fn options(&self) -> ShadingOptions {
        self.options
    }

    /// Returns the light terms that are on. Unlit techniques have none.
    pub fn terms(&self) -> Terms {
        if self.technique.is_lit() { self.options.terms } else { Terms::NONE }
    }

    /// Returns the sampling rule of the integrals, or `None` for techniques without integrals.
    pub fn quadrature(&self) -> Option<Quadrature> {
        self.technique.integrates().then_some(self.options.quadrature)
    }

    /// Whether the base roughness applies in the frame of the facets.
    pub fn facet_frame(&self) -> bool {
        self.technique.has_base_frame() && self.options.base_frame == BaseFrame::Facet
    }

    /// Whether relief is shaded by classes of facets.
    pub fn has_classes(&self) -> bool {
        self.technique.has_relief_color() && self.options.classes
    }

    /// Returns the inputs that the technique needs from the passes.
    pub fn needs(&self) -> Needs {
        self.technique.needs(self.options)
    }

    /// Returns the specialisation constants of the shading pass for this shading.
    pub fn spec(&self) -> Vec<(&'static str, SpecValue)> {
        let ShadingOptions { shadowing, diffuse_lights, grid_lod, .. } = self.options;
        let mut spec = self.needs().spec();
        spec.push(("TERMS", SpecValue::I32(self.terms().bits())));
        spec.extend(ShadingOptions::ALL.iter().filter_map(|option| option.spec(self.technique, self.options)));
        if let Some(quadrature) = self.quadrature() {
            let (visible, samples) = match quadrature {
                Quadrature::Grid(side) => (false, side),
                Quadrature::VisibleSlopes(probes) => (true, probes.count()),
            };
            spec.extend([
                ("VISIBLE_SLOPES", SpecValue::Bool(visible)),
                ("SAMPLES", SpecValue::I32(samples as i32)),
                ("GRID_LOD", SpecValue::F32(grid_lod.constant() as f32)),
                ("SHADOWING_MODEL", SpecValue::I32(shadowing.code())),
                ("LIGHTS_BY_SH", SpecValue::Bool(diffuse_lights == DiffuseLights::Sh)),
                ("FACET_FRAME", SpecValue::Bool(self.facet_frame())),
                // The errors of a few fixed probes would stay visible, even in the mean of many samples.
                ("DRAWN_SPECULAR", SpecValue::Bool(visible && self.technique.is_reference())),
            ]);
        }
        spec
    }

    /// Returns the same shading with one edge sample and without relief shadows and relief colours, which is the cache key of the
    /// pipelines that shade pixels.
    #[must_use]
    pub fn plain(self) -> Self {
        self.adjusted(|options| ShadingOptions {
            edge_samples: 1,
            relief_shadows: false,
            relief_color: false,
            ..options
        })
    }

    /// Returns the same technique with different options.
    #[must_use]
    pub fn adjusted(self, change: impl FnOnce(ShadingOptions) -> ShadingOptions) -> Self {
        self.technique.with(change(self.options))
    }

    /// Checks whether this shading can produce an image.
    ///
    /// # Errors
    /// Returns a description of the invalid setting.
    pub fn check(&self) -> Result<(), String> {
        let ShadingOptions { quadrature, edge_samples, .. } = self.options;
        if let Quadrature::Grid(n) = quadrature
            && !(1..=Quadrature::MAX_GRID).contains(&n)
        {
            return Err(format!("a grid of {n} is outside the range of 1 to {}", Quadrature::MAX_GRID));
        }
        let most = ShadingOptions::MAX_EDGE_SAMPLES;
        if (1..=most).contains(&edge_samples) {
            Ok(())
        } else {
            Err(format!("{edge_samples} edge samples are outside the range of 1 to {most}"))
        }
    }
}

impl fmt::Display for Shading {
    /// Formats the technique and, if the technique integrates, the quadrature.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.technique.name())?;
        match self.quadrature() {
            None => return Ok(()),
            Some(Quadrature::Grid(n)) => write!(f, " · {n}×{n}")?,
            Some(Quadrature::VisibleSlopes(probes)) => write!(f, " · {} probes", probes.count())?,
        }
        write!(f, ", {}", self.options.shadowing.name())
    }
}

impl Serialize for Shading {
    /// Serialises the settings under the names of the flags. Every key exists for every technique.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let rows = ShadingOptions::ALL.iter();
        let values = rows.filter_map(|row| Some((row.spec.json_key(), row.json(self.technique, self.options)?)));
        serializer
            .collect_map(std::iter::once(("technique".to_owned(), Json::Name(self.technique.name()))).chain(values))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_reflectance::masking::occlusion::{ConeAxis, ConeEdge, ConeLobe, Hidden};
    use leadr_reflectance::materials::diffuse_models::DiffuseModel;

    /// Returns options that all differ from their defaults.
    const OPTIONS: ShadingOptions = ShadingOptions {
        terms: Terms::DIFFUSE_LIGHTS,
        quadrature: Quadrature::Grid(7),
        grid_lod: GridLod::Banding5,
        grid_nodes: NodePlacement::Pruned,
        shadowing: Shadowing::Smith,
        diffuse_lights: DiffuseLights::Sh,
        base_frame: BaseFrame::Macro,
        fresnel: FresnelForm::Exact,
        pixel_kernel: PixelKernel::Off,
        relief_occlusion: false,
        relief_color: true,
        classes: false,
        interreflection: true,
        diffuse_model: DiffuseModel::Disney,
        cone_occluders: Hidden::Black,
        cone_edge: ConeEdge::Hard,
        cone_axis: ConeAxis::Normal,
        cone_lobe: ConeLobe::Adjusted,
        sky_occlusion: true,
        edge_samples: 16,
        lod_bias: LodBias(0.5),
        relief_shadows: true,
    };

    #[test]
    fn techniques_take_the_options_that_they_have_and_no_others() {
        for technique in Technique::ALL {
            let shading = technique.with(OPTIONS);
            let options = shading.options();
            assert_eq!(shading.quadrature().is_some(), technique.integrates());
            assert_eq!(options.pixel_kernel == PixelKernel::Off, technique.has_pixel_kernel());
            assert_eq!(options.base_frame == BaseFrame::Macro, technique.has_base_frame());
            assert_eq!(options.diffuse_model == DiffuseModel::Disney, technique.has_diffuse_model());
            assert_eq!(options.cone_edge == ConeEdge::Hard, technique.has_cones());
            assert_eq!(options.relief_shadows, technique.has_relief_shadows());
            assert_eq!(options.edge_samples, if technique.is_reference() { 1 } else { 16 });
            assert_eq!(shading.terms() == Terms::NONE, !technique.is_lit());
        }
        assert_eq!(
            Technique::Lean.with(OPTIONS),
            Technique::Lean.with(ShadingOptions {
                terms: OPTIONS.terms,
                fresnel: FresnelForm::Exact,
                sky_occlusion: true,
                edge_samples: 16,
                lod_bias: OPTIONS.lod_bias,
                ..Default::default()
            })
        );
    }

    #[test]
    fn v_grooves_have_a_grid_and_no_classes() {
        let groove = ShadingOptions { shadowing: Shadowing::VGroove, ..Default::default() };
        let shading = Technique::Leadr.with(groove);
        assert_eq!((shading.quadrature(), shading.has_classes()), (Some(Quadrature::PAPER), false));
        let finer = Technique::Leadr.with(ShadingOptions { quadrature: Quadrature::Grid(9), ..groove });
        assert_eq!(finer.quadrature(), Some(Quadrature::Grid(9)));
        let separable = ShadingOptions { shadowing: Shadowing::SmithSeparable, ..Default::default() };
        let shading = Technique::Leadr.with(separable);
        assert_eq!((shading.quadrature(), shading.has_classes()), (Some(separable.quadrature), false));
    }

    /// Constants of named options are indices, so their order is that of the shader's constants.
    #[test]
    fn names_become_constants() {
        let value = |shading: Shading, name| {
            shading.spec().into_iter().find_map(|(known, value)| (known == name).then_some(value)).unwrap()
        };
        let shading = Technique::Leadr.with(OPTIONS);
        for (name, code) in [
            ("DIFFUSE_MODEL", DiffuseModel::Disney as i32),
            ("CONE_OCCLUDERS", Hidden::Black as i32),
            ("CONE_EDGE", ConeEdge::Hard as i32),
            ("CONE_AXIS", ConeAxis::Normal as i32),
            ("CONE_LOBE", ConeLobe::Adjusted as i32),
            ("FRESNEL", FresnelForm::Exact as i32),
            ("GRID_NODES", NodePlacement::Pruned as i32),
        ] {
            assert_eq!(value(shading, name), SpecValue::I32(code), "{name}");
        }
        assert_eq!(value(Technique::Lean.with(OPTIONS), "DIFFUSE_MODEL"), SpecValue::I32(0));
        assert_eq!(value(Technique::Lean.into(), "CONE_OCCLUDERS"), SpecValue::I32(Hidden::SameRadiance as i32));
        assert_eq!(value(shading, "INTERREFLECTION"), SpecValue::Bool(true));
    }

    #[test]
    fn options_come_back() {
        assert_eq!(Technique::Leadr.with(OPTIONS).options(), ShadingOptions { relief_shadows: false, ..OPTIONS });
        for technique in Technique::ALL {
            let shading = technique.with(OPTIONS);
            assert_eq!(technique.with(shading.options()), shading);
            assert_eq!(shading.plain().options().edge_samples, 1);
        }
    }

    #[test]
    fn grids_and_edge_samples_have_a_range() {
        for (options, word) in [
            (ShadingOptions { quadrature: Quadrature::Grid(0), ..Default::default() }, "128"),
            (ShadingOptions { quadrature: Quadrature::Grid(129), ..Default::default() }, "128"),
            (ShadingOptions { edge_samples: 0, ..Default::default() }, "256"),
            (ShadingOptions { edge_samples: 257, ..Default::default() }, "256"),
        ] {
            let fault = Technique::Leadr.with(options).check().expect_err(word);
            assert!(fault.contains(word), "{fault}");
        }
        assert_eq!(
            Technique::Lean.with(ShadingOptions { quadrature: Quadrature::Grid(0), ..Default::default() }).check(),
            Ok(())
        );
    }

    #[test]
    fn every_technique_writes_the_same_keys() {
        let keys = |technique: Technique| -> Vec<String> {
            let json = serde_json::to_value(Shading::from(technique)).unwrap();
            json.as_object().unwrap().keys().cloned().collect()
        };
        for technique in Technique::ALL {
            assert_eq!(keys(technique), keys(Technique::Leadr));
        }
        let json = serde_json::to_value(Technique::Leadr.with(OPTIONS)).unwrap();
        assert_eq!((&json["rule"], &json["grid"], &json["masking"]), (&"grid".into(), &7.into(), &"smith".into()));
    }
}
