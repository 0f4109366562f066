//! How surfaces are shaded: a technique together with exactly the settings that it has.

use std::fmt;

use serde::{Serialize, Serializer};

use super::technique::{Needs, Technique};
use super::terms::Terms;
use leadr_gpu::SpecValue;
use leadr_reflectance::masking::shadowing::Shadowing;

/// Where the integrals over visible slopes are sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quadrature {
    /// The paper's `N × N` grid of slopes, `N` from 1 to [`MAX_GRID`](Self::MAX_GRID).
    Grid(u32),
    /// The visible-slope rules, with this many environment probes.
    VisibleSlopes(Probes),
}

impl Quadrature {
    /// Most slopes along a side of the grid.
    pub const MAX_GRID: u32 = 128;

    /// Number of environment lookups per pixel: one for each slope or probe.
    #[must_use]
    pub const fn samples(self) -> u32 {
        match self {
            Self::Grid(n) => n * n,
            Self::VisibleSlopes(probes) => probes.count(),
        }
    }

    /// The name of the rule on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Grid(_) => "grid",
            Self::VisibleSlopes(_) => "visible",
        }
    }
}

/// Number of probes that look the environment up; rules exist for these numbers only.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Probes {
    /// 5.
    Five,
    /// 9.
    Nine,
    /// 16.
    Sixteen,
}

impl Probes {
    /// Every number, the smallest first.
    pub const ALL: [Self; 3] = [Self::Five, Self::Nine, Self::Sixteen];

    /// The number.
    #[must_use]
    pub const fn count(self) -> u32 {
        match self {
            Self::Five => 5,
            Self::Nine => 9,
            Self::Sixteen => 16,
        }
    }

    /// The rule of `count` probes, if there is one.
    #[must_use]
    pub fn of(count: u32) -> Option<Self> {
        Self::ALL.into_iter().find(|probes| probes.count() == count)
    }
}

/// How the light of the sun and of point lights on a diffuse surface is integrated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DiffuseLights {
    /// With the clamped cosine of each slope.
    Cosine,
    /// With order-2 harmonics (Algorithm 2 of the LEADR paper): up to 9 % off.
    Sh,
}

impl DiffuseLights {
    /// Every form.
    pub const ALL: [Self; 2] = [Self::Cosine, Self::Sh];

    /// The name on the command line.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Cosine => "cosine",
            Self::Sh => "sh",
        }
    }

    /// A one-line description.
    #[must_use]
    pub const fn help(self) -> &'static str {
        match self {
            Self::Cosine => "The clamped cosine of each slope",
            Self::Sh => "Order-2 spherical harmonics, as in the LEADR paper; up to 9 % off",
        }
    }
}

/// The frame in which the base material is rough.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum BaseFrame {
    /// That of each facet, which a material has (`reflectance::facets::base_roughness`).
    Facet,
    /// That of the macrosurface, as in the LEADR paper: steep relief is up to 25 % too dark seen from above, and too bright
    /// at grazing angles.
    Macro,
}

impl BaseFrame {
    /// Both.
    pub const ALL: [Self; 2] = [Self::Facet, Self::Macro];

    /// The name on the command line and in JSON.
    #[must_use]
    pub const fn name(self) -> &'static str {
        match self {
            Self::Facet => "facet",
            Self::Macro => "macro",
        }
    }

    /// A one-line description.
    #[must_use]
    pub const fn help(self) -> &'static str {
        match self {
            Self::Facet => "Each facet's own, as a material has it",
            Self::Macro => "The smooth surface's, as in the LEADR paper; darker on steep relief",
        }
    }
}

/// The options for whichever technique is drawn; each technique takes the settings that it has ([`Technique::with`]).
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ShadingOptions {
    /// Which light counts. For techniques with light.
    pub terms: Terms,
    /// Where the integrals are sampled. For techniques that integrate, like the next two.
    pub quadrature: Quadrature,
    /// Which of the visible facets are lit.
    pub shadowing: Shadowing,
    /// How the diffuse light of sun and point lights is integrated.
    pub diffuse_lights: DiffuseLights,
    /// The frame in which the base is rough. For techniques that integrate over a Beckmann base.
    pub base_frame: BaseFrame,
    /// Whether the change of the macrosurface's normal across a pixel counts as roughness (Tokuyoshi & Kaplanyan 2019; on
    /// meshes only), and slopes that face away from the pixel's viewer are widened toward it (`tilt_to_edge`). The LEADR
    /// paper does neither. For the LEADR techniques; the other techniques that integrate always widen slopes.
    pub pixel_kernel: bool,
    /// Whether bumps that are larger than a pixel hide the environment and the lights from each other
    /// ([`leadr_reflectance::visible::horizon`]). The LEADR paper leaves it out. For techniques that integrate.
    pub relief_occlusion: bool,
    /// Whether colours that follow the heights or slopes of the relief are those of what is seen and lit
    /// ([`leadr_reflectance::visible::relief_color`]), instead of the mean. The LEADR paper leaves it out. For techniques that
    /// integrate over a covariance, and objects that [keep what it takes](crate::scene::Object::with_relief_color).
    pub relief_color: bool,
    /// Whether facets of the base light each other: their mirrors lose nothing, and their diffuse body scatters as rough bodies do
    /// ([`leadr_reflectance::materials::energy`], [`leadr_reflectance::materials::multiscattering`]). The LEADR paper leaves it out.
    /// For techniques that integrate over a Beckmann base, and `gloss`.
    pub multiscattering: bool,
    /// Whether large shapes hide the environment (`render::light::sky_visibility`), where shadows are drawn. The LEADR paper
    /// leaves it out. For techniques with light.
    pub sky_occlusion: bool,
    /// Edge samples per sample, 1 (none) to [`MAX_EDGE_SAMPLES`](Self::MAX_EDGE_SAMPLES): places in the pixel where the
    /// geometry is sampled again. Those that see another surface than the pixel's own sample are shaded too, so silhouettes
    /// are as smooth as with that many samples per pixel, while the inside of a surface stays the same
    /// (`render::passes::edges`). Multiples of 16 are the fastest. For all techniques but the reference, whose samples per
    /// pixel smooth silhouettes already.
    pub edge_samples: u32,
    /// Whether the relief casts shadows on itself, from every light and from the environment (`render::passes::reference`),
    /// instead of the sun's coarse shadow map alone. Slow. For the reference of a Beckmann base.
    pub relief_shadows: bool,
}

impl ShadingOptions {
    /// Largest number of edge samples.
    pub const MAX_EDGE_SAMPLES: u32 = 256;
}

impl Default for ShadingOptions {
    fn default() -> Self {
        Self {
            terms: Terms::ALL,
            quadrature: Quadrature::VisibleSlopes(Probes::Sixteen),
            shadowing: Shadowing::Correlated,
            diffuse_lights: DiffuseLights::Cosine,
            base_frame: BaseFrame::Facet,
            pixel_kernel: true,
            relief_occlusion: true,
            relief_color: false,
            multiscattering: false,
            sky_occlusion: false,
            edge_samples: 1,
            relief_shadows: false,
        }
    }
}

/// The settings of a technique that integrates over visible slopes.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Integral {
    /// Where the integrals are sampled.
    pub quadrature: Quadrature,
    /// Which of the visible facets are lit.
    pub shadowing: Shadowing,
    /// How the diffuse light of sun and point lights is integrated.
    pub diffuse_lights: DiffuseLights,
    /// [`ShadingOptions::base_frame`], where the base is Beckmann's.
    pub base_frame: Option<BaseFrame>,
    /// [`ShadingOptions::pixel_kernel`], where the technique has it.
    pub pixel_kernel: Option<bool>,
    /// [`ShadingOptions::relief_occlusion`].
    pub relief_occlusion: bool,
    /// [`ShadingOptions::relief_color`], where the technique has it.
    pub relief_color: Option<bool>,
}

/// How a technique reflects light.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Reflection {
    /// Not at all: only the albedo is shown.
    Unlit,
    /// By a lobe about the mean normal.
    Lobe(Terms),
    /// By integrals over the visible slopes.
    Integral(Terms, Integral),
}

/// How detail smaller than a pixel is filtered.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Filtering {
    /// Beforehand, in the maps; silhouettes are smoothed by edge samples.
    Prefiltered {
        /// [`ShadingOptions::edge_samples`].
        edge_samples: u32,
    },
    /// By the samples per pixel alone: the reference.
    Supersampled {
        /// [`ShadingOptions::relief_shadows`].
        relief_shadows: bool,
    },
}

/// A technique together with exactly the settings that it has. [`Technique::with`] makes it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Shading {
    technique: Technique,
    reflection: Reflection,
    /// [`ShadingOptions::multiscattering`], where the technique has it.
    multiscattering: Option<bool>,
    filtering: Filtering,
    sky_occlusion: bool,
}

impl Technique {
    /// The technique with those of the `options` that apply to it.
    #[must_use]
    pub fn with(self, options: ShadingOptions) -> Shading {
        let ShadingOptions { terms, quadrature, shadowing, diffuse_lights, relief_occlusion, .. } = options;
        let pixel_kernel = self.has_pixel_kernel().then_some(options.pixel_kernel);
        let base_frame = self.has_base_frame().then_some(options.base_frame);
        let multiscattering = self.has_multiscattering().then_some(options.multiscattering);
        let relief_color = self.has_relief_color().then_some(options.relief_color);
        let reflection = if !self.is_lit() {
            Reflection::Unlit
        } else if self.integrates() {
            let integral = Integral {
                quadrature,
                shadowing,
                diffuse_lights,
                base_frame,
                pixel_kernel,
                relief_occlusion,
                relief_color,
            };
            Reflection::Integral(terms, integral)
        } else {
            Reflection::Lobe(terms)
        };
        let filtering = if self.is_reference() {
            Filtering::Supersampled { relief_shadows: options.relief_shadows && self.has_relief_shadows() }
        } else {
            Filtering::Prefiltered { edge_samples: options.edge_samples }
        };
        let sky_occlusion = options.sky_occlusion && self.is_lit();
        Shading { technique: self, reflection, multiscattering, filtering, sky_occlusion }
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
    /// The technique.
    #[must_use]
    pub fn technique(&self) -> Technique {
        self.technique
    }

    /// How light is reflected.
    #[must_use]
    pub fn reflection(&self) -> Reflection {
        self.reflection
    }

    /// Which light counts: none for techniques without light.
    #[must_use]
    pub fn terms(&self) -> Terms {
        match self.reflection {
            Reflection::Unlit => Terms::NONE,
            Reflection::Lobe(terms) | Reflection::Integral(terms, _) => terms,
        }
    }

    /// How the technique integrates over visible slopes; `None` if it does not.
    #[must_use]
    pub fn integral(&self) -> Option<Integral> {
        match self.reflection {
            Reflection::Integral(_, integral) => Some(integral),
            Reflection::Unlit | Reflection::Lobe(_) => None,
        }
    }

    /// Edge samples per sample; `None` where there is only the sample itself.
    #[must_use]
    pub fn edge_samples(&self) -> Option<u32> {
        match self.filtering {
            Filtering::Prefiltered { edge_samples } => (edge_samples > 1).then_some(edge_samples),
            Filtering::Supersampled { .. } => None,
        }
    }

    /// Whether the relief casts shadows on itself.
    #[must_use]
    pub fn relief_shadows(&self) -> bool {
        self.filtering == Filtering::Supersampled { relief_shadows: true }
    }

    /// Whether large shapes hide the environment.
    #[must_use]
    pub fn sky_occlusion(&self) -> bool {
        self.sky_occlusion
    }

    /// Whether the base is rough in the frame of the facets.
    #[must_use]
    pub fn facet_frame(&self) -> bool {
        self.integral().is_some_and(|integral| integral.base_frame == Some(BaseFrame::Facet))
    }

    /// The inputs that the technique needs from the passes.
    #[must_use]
    pub fn needs(&self) -> Needs {
        let integral = self.integral();
        let kernel = integral.and_then(|integral| integral.pixel_kernel);
        let occlusion = integral.is_some_and(|integral| integral.relief_occlusion);
        let color = integral.and_then(|integral| integral.relief_color);
        self.technique.needs(kernel.unwrap_or(false), occlusion, color.unwrap_or(false))
    }

    /// The specialization constants of the shading pass that depend on it.
    #[must_use]
    pub fn spec(&self) -> Vec<(&'static str, SpecValue)> {
        let mut spec = self.needs().spec();
        spec.push(("TERMS", SpecValue::I32(self.terms().bits())));
        spec.push(("MULTISCATTERING", SpecValue::Bool(self.multiscattering == Some(true))));
        spec.push(("SKY_OCCLUSION", SpecValue::Bool(self.sky_occlusion)));
        if let Some(Integral { quadrature, shadowing, diffuse_lights, .. }) = self.integral() {
            let (visible, samples) = match quadrature {
                Quadrature::Grid(side) => (false, side),
                Quadrature::VisibleSlopes(probes) => (true, probes.count()),
            };
            spec.extend([
                ("VISIBLE_SLOPES", SpecValue::Bool(visible)),
                ("SAMPLES", SpecValue::I32(samples as i32)),
                ("SHADOWING_MODEL", SpecValue::I32(shadowing.code())),
                ("LIGHTS_BY_SH", SpecValue::Bool(diffuse_lights == DiffuseLights::Sh)),
                ("FACET_FRAME", SpecValue::Bool(self.facet_frame())),
                // Few fixed probes would show in the mean of many samples, however many.
                ("DRAWN_MIRRORS", SpecValue::Bool(visible && self.technique.is_reference())),
            ]);
        }
        spec
    }

    /// The same shading with one edge sample and no relief shadows: the key under which the pipelines that shade pixels are
    /// cached.
    #[must_use]
    pub fn plain(self) -> Self {
        self.adjusted(|options| ShadingOptions { edge_samples: 1, relief_shadows: false, ..options })
    }

    /// The options that it was made with; settings that the technique does not have are at their defaults.
    #[must_use]
    pub fn options(&self) -> ShadingOptions {
        let mut options = ShadingOptions::default();
        if let Reflection::Lobe(terms) | Reflection::Integral(terms, _) = self.reflection {
            options.terms = terms;
            options.sky_occlusion = self.sky_occlusion;
        }
        if let Some(integral) = self.integral() {
            let Integral {
                quadrature,
                shadowing,
                diffuse_lights,
                base_frame,
                pixel_kernel,
                relief_occlusion,
                relief_color,
            } = integral;
            options = ShadingOptions {
                quadrature,
                shadowing,
                diffuse_lights,
                base_frame: base_frame.unwrap_or(options.base_frame),
                pixel_kernel: pixel_kernel.unwrap_or(options.pixel_kernel),
                relief_occlusion,
                relief_color: relief_color.unwrap_or(options.relief_color),
                ..options
            };
        }
        options.multiscattering = self.multiscattering.unwrap_or(options.multiscattering);
        match self.filtering {
            Filtering::Prefiltered { edge_samples } => ShadingOptions { edge_samples, ..options },
            Filtering::Supersampled { relief_shadows } => ShadingOptions { relief_shadows, ..options },
        }
    }

    /// The same technique with other options.
    #[must_use]
    pub fn adjusted(self, change: impl FnOnce(ShadingOptions) -> ShadingOptions) -> Self {
        self.technique.with(change(self.options()))
    }

    /// Checks whether a picture can be made with this shading.
    ///
    /// # Errors
    /// A sentence about what is wrong.
    pub fn check(&self) -> Result<(), String> {
        if let Some(Integral { quadrature: Quadrature::Grid(n), .. }) = self.integral()
            && !(1..=Quadrature::MAX_GRID).contains(&n)
        {
            return Err(format!("a grid of {n} is not 1 to {}", Quadrature::MAX_GRID));
        }
        let most = ShadingOptions::MAX_EDGE_SAMPLES;
        match self.filtering {
            Filtering::Prefiltered { edge_samples: n } if !(1..=most).contains(&n) => {
                Err(format!("{n} edge samples are not 1 to {most}"))
            }
            _ => Ok(()),
        }
    }
}

impl fmt::Display for Shading {
    /// The technique and, where it integrates, how.
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}", self.technique.name())?;
        let Some(integral) = self.integral() else { return Ok(()) };
        match integral.quadrature {
            Quadrature::Grid(n) => write!(f, " · {n}×{n}")?,
            Quadrature::VisibleSlopes(probes) => write!(f, " · {} probes", probes.count())?,
        }
        write!(f, ", {}", integral.shadowing.name())
    }
}

/// Settings under the names of their flags. Scripts find every key with every technique; a setting that the technique does
/// not have is at its default.
#[derive(Serialize)]
struct Named {
    technique: &'static str,
    rule: &'static str,
    #[serde(skip_serializing_if = "Option::is_none")]
    grid: Option<u32>,
    #[serde(skip_serializing_if = "Option::is_none")]
    probes: Option<u32>,
    masking: &'static str,
    terms: Vec<&'static str>,
    diffuse_lights: &'static str,
    base_frame: &'static str,
    pixel_kernel: bool,
    relief_occlusion: bool,
    relief_color: bool,
    multiscattering: bool,
    sky_occlusion: bool,
    relief_shadows: bool,
    edge_samples: u32,
}

impl Serialize for Shading {
    /// Under the names of the flags that choose them.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let options = self.options();
        let (grid, probes) = match options.quadrature {
            Quadrature::Grid(n) => (Some(n), None),
            Quadrature::VisibleSlopes(probes) => (None, Some(probes.count())),
        };
        Named {
            technique: self.technique.name(),
            rule: options.quadrature.name(),
            grid,
            probes,
            masking: options.shadowing.name(),
            terms: options.terms.names().collect(),
            diffuse_lights: options.diffuse_lights.name(),
            base_frame: if self.technique.has_base_frame() { options.base_frame } else { BaseFrame::Macro }.name(),
            pixel_kernel: options.pixel_kernel && self.technique.has_pixel_kernel(),
            relief_occlusion: self.integral().is_some_and(|integral| integral.relief_occlusion),
            relief_color: self.integral().and_then(|integral| integral.relief_color).unwrap_or(false),
            multiscattering: options.multiscattering,
            sky_occlusion: self.sky_occlusion,
            relief_shadows: options.relief_shadows,
            edge_samples: options.edge_samples,
        }
        .serialize(serializer)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// None of these is a default.
    const OPTIONS: ShadingOptions = ShadingOptions {
        terms: Terms::DIFFUSE_LIGHTS,
        quadrature: Quadrature::Grid(7),
        shadowing: Shadowing::Smith,
        diffuse_lights: DiffuseLights::Sh,
        base_frame: BaseFrame::Macro,
        pixel_kernel: false,
        relief_occlusion: false,
        relief_color: true,
        multiscattering: true,
        sky_occlusion: true,
        edge_samples: 16,
        relief_shadows: true,
    };

    #[test]
    fn techniques_take_the_options_that_they_have_and_no_others() {
        for technique in Technique::ALL {
            let shading = technique.with(OPTIONS);
            assert_eq!(shading.integral().is_some(), technique.integrates());
            let kernel = shading.integral().and_then(|integral| integral.pixel_kernel);
            assert_eq!(kernel, technique.has_pixel_kernel().then_some(false));
            let frame = shading.integral().and_then(|integral| integral.base_frame);
            assert_eq!(frame, technique.has_base_frame().then_some(BaseFrame::Macro));
            assert_eq!(shading.options().multiscattering, technique.has_multiscattering());
            assert_eq!(shading.relief_shadows(), technique.has_relief_shadows());
            assert_eq!(shading.edge_samples(), (!technique.is_reference()).then_some(16));
            assert_eq!(shading.terms() == Terms::NONE, !technique.is_lit());
        }
        assert_eq!(
            Technique::Lean.with(OPTIONS),
            Technique::Lean.with(ShadingOptions {
                terms: OPTIONS.terms,
                sky_occlusion: true,
                edge_samples: 16,
                ..Default::default()
            })
        );
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
