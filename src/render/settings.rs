//! What a picture is made with.

use glam::Vec2;
use serde::{Serialize, Serializer};

use super::sampling::jitter;
use super::surfaces::tessellation::TessellationSettings;
use crate::reflectance::masking::shadowing::Shadowing;

/// How a surface is filtered and shaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Technique {
    /// Albedo alone, without light: what geometry and filtering of the colour cost.
    Constant,
    /// Mipmapped normals under a normalised Blinn-Phong lobe.
    BlinnPhong,
    /// Mipmapped normals with LEADR's BRDF: the mean slope alone.
    NormalMip,
    /// Mipmapped normals whose length gives the roughness (Toksvig 2005).
    Toksvig,
    /// One slope variance for all directions (CLEAN mapping, Baker 2011).
    Clean,
    /// Slope covariance under a Beckmann lobe, without projected areas (LEAN mapping, Olano & Baker 2010).
    Lean,
    /// LEADR mapping: mean slope and slope covariance of the pixel.
    Leadr,
    /// LEADR mapping of a GGX base: two lobes.
    LeadrGgx,
    /// The finest level of the maps and no statistics: correct with enough samples per pixel.
    Reference,
}

impl Technique {
    /// Every technique, the simplest first.
    pub const ALL: [Self; 9] = [
        Self::Constant,
        Self::BlinnPhong,
        Self::NormalMip,
        Self::Toksvig,
        Self::Clean,
        Self::Lean,
        Self::Leadr,
        Self::LeadrGgx,
        Self::Reference,
    ];

    /// `TECHNIQUE_` value of `passes/technique.glsl`.
    #[must_use]
    pub fn code(self) -> i32 {
        self as i32
    }

    /// Whether it integrates over the visible slopes, so that [`Quadrature`], [`Shadowing`] and [`DiffuseLights`] matter.
    #[must_use]
    pub fn integrates(self) -> bool {
        matches!(self, Self::NormalMip | Self::Leadr | Self::LeadrGgx | Self::Reference)
    }

    /// Whether the turn of the macrosurface under a pixel widens its distribution: `USES_CURVATURE` of
    /// `passes/technique.glsl`.
    #[must_use]
    pub fn has_pixel_kernel(self) -> bool {
        matches!(self, Self::Leadr | Self::LeadrGgx)
    }

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Constant => "constant",
            Self::BlinnPhong => "blinn-phong",
            Self::NormalMip => "normal-mip",
            Self::Toksvig => "toksvig",
            Self::Clean => "clean",
            Self::Lean => "lean",
            Self::Leadr => "leadr",
            Self::LeadrGgx => "leadr-ggx",
            Self::Reference => "reference",
        }
    }
}

/// Where the integrals over visible slopes are sampled.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Quadrature {
    /// The paper's `N × N` grid of slopes, 1 to 128.
    Grid(u32),
    /// The visible-slope rules, with so many environment probes: one of [`PROBES`](Self::PROBES).
    VisibleSlopes(u32),
}

impl Quadrature {
    /// Numbers of probes there is a rule for.
    pub const PROBES: [u32; 3] = [5, 9, 16];
    /// Most slopes along a side of the grid.
    pub const MAX_GRID: u32 = 128;

    /// What is wrong with it, if anything.
    #[must_use]
    pub fn fault(self) -> Option<String> {
        match self {
            Self::Grid(n) if !(1..=Self::MAX_GRID).contains(&n) => Some(format!("a grid of {n} is not 1 to 128")),
            Self::VisibleSlopes(n) if !Self::PROBES.contains(&n) => {
                Some(format!("{n} probes are not one of {:?}", Self::PROBES))
            }
            _ => None,
        }
    }
}

/// How lights reach a diffuse surface under [`Quadrature::Grid`].
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum DiffuseLights {
    /// The clamped cosine at every slope sample.
    Cosine,
    /// Order-2 harmonics (Algorithm 2): up to 9 % off.
    Sh,
}

impl DiffuseLights {
    /// Every form.
    pub const ALL: [Self; 2] = [Self::Cosine, Self::Sh];

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Cosine => "cosine",
            Self::Sh => "sh",
        }
    }
}

/// The light transport a picture contains: a set.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct Terms(u8);

impl Terms {
    /// Sun and point lights in mirrors.
    pub const SPECULAR_LIGHTS: Self = Self(1);
    /// Sun and point lights on the diffuse surface.
    pub const DIFFUSE_LIGHTS: Self = Self(2);
    /// The environment in mirrors.
    pub const SPECULAR_ENVIRONMENT: Self = Self(4);
    /// The environment on the diffuse surface.
    pub const DIFFUSE_ENVIRONMENT: Self = Self(8);
    /// Everything.
    pub const ALL: Self = Self(15);
    /// Nothing: black.
    pub const NONE: Self = Self(0);

    /// Each term with its name on the command line.
    pub const NAMES: [(Self, &str); 4] = [
        (Self::SPECULAR_LIGHTS, "specular-lights"),
        (Self::DIFFUSE_LIGHTS, "diffuse-lights"),
        (Self::SPECULAR_ENVIRONMENT, "specular-environment"),
        (Self::DIFFUSE_ENVIRONMENT, "diffuse-environment"),
    ];

    /// Whether all of `other` is in it.
    #[must_use]
    pub fn contains(self, other: Self) -> bool {
        self.0 & other.0 == other.0
    }

    /// Without `other`.
    #[must_use]
    pub fn without(self, other: Self) -> Self {
        Self(self.0 & !other.0)
    }

    /// `TERM_` bits of the shading pass.
    #[must_use]
    pub fn bits(self) -> i32 {
        i32::from(self.0)
    }

    /// Names of its members.
    pub fn names(self) -> impl Iterator<Item = &'static str> {
        Self::NAMES.into_iter().filter(move |(term, _)| self.contains(*term)).map(|(_, name)| name)
    }
}

impl std::ops::BitOr for Terms {
    type Output = Self;

    fn bitor(self, other: Self) -> Self {
        Self(self.0 | other.0)
    }
}

/// Settings that choose pipelines: changing one builds new pipelines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ShadingSettings {
    /// How surfaces are filtered and shaded.
    pub technique: Technique,
    /// Where the integrals are sampled.
    pub quadrature: Quadrature,
    /// Which of the visible facets are lit.
    pub shadowing: Shadowing,
    /// Which light counts.
    pub terms: Terms,
    /// Diffuse light of sun and point lights.
    pub diffuse_lights: DiffuseLights,
    /// Whether the turn of the macrosurface under a pixel counts as roughness (Tokuyoshi & Kaplanyan 2019), and slopes that
    /// face away from their pixel widen toward it (`tilt_to_edge`), neither of which the LEADR paper does. For the LEADR
    /// techniques; the first on meshes alone.
    pub pixel_kernel: bool,
}

impl ShadingSettings {
    /// Whether a picture can be made like this.
    ///
    /// # Errors
    /// A sentence about what is wrong.
    pub fn check(&self) -> Result<(), String> {
        self.quadrature.fault().map_or(Ok(()), Err)
    }
}

impl std::fmt::Display for ShadingSettings {
    /// The technique, and how it integrates if it does.
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}", self.technique.name())?;
        if self.technique.integrates() {
            match self.quadrature {
                Quadrature::Grid(n) => write!(f, " · {n}×{n}")?,
                Quadrature::VisibleSlopes(n) => write!(f, " · {n} probes")?,
            }
            write!(f, ", {}", self.shadowing.name())?;
        }
        Ok(())
    }
}

/// Settings under the names of their flags.
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
    pixel_kernel: bool,
}

impl Serialize for ShadingSettings {
    /// Under the names of the flags that choose them.
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        let (rule, grid, probes) = match self.quadrature {
            Quadrature::Grid(n) => ("grid", Some(n), None),
            Quadrature::VisibleSlopes(n) => ("visible", None, Some(n)),
        };
        Named {
            technique: self.technique.name(),
            rule,
            grid,
            probes,
            masking: self.shadowing.name(),
            terms: self.terms.names().collect(),
            diffuse_lights: self.diffuse_lights.name(),
            pixel_kernel: self.pixel_kernel && self.technique.has_pixel_kernel(),
        }
        .serialize(serializer)
    }
}

impl Default for ShadingSettings {
    fn default() -> Self {
        Self {
            technique: Technique::Leadr,
            quadrature: Quadrature::VisibleSlopes(16),
            shadowing: Shadowing::Correlated,
            terms: Terms::ALL,
            diffuse_lights: DiffuseLights::Cosine,
            pixel_kernel: true,
        }
    }
}

/// Everything about a picture that is not the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSettings {
    /// Pixels across and down.
    pub size: (u32, u32),
    /// Samples per pixel, each a whole frame with its own offset inside the pixel; at least 1.
    pub samples: u32,
    /// Seed of the offsets. One sample lies in the pixel's centre whatever the seed.
    pub seed: u64,
    /// Edge samples per sample, 1 (none) to [`MAX_EDGE_SAMPLES`](Self::MAX_EDGE_SAMPLES): places in the pixel where the geometry
    /// is looked at again. Those that see another surface than the pixel's sample are shaded too, so outlines are as smooth
    /// as of that many samples, and the inside of a surface stays the same (`render::passes::edges`). Multiples of 16 are drawn the
    /// fastest. [`Technique::Reference`] has none: its samples do the same.
    pub edge_samples: u32,
    /// Shading.
    pub shading: ShadingSettings,
    /// Tessellation.
    pub tessellation: TessellationSettings,
    /// Whether the sun throws shadows.
    pub shadows: bool,
    /// Whether heights move the surface. Without, the geometry stays smooth and the slopes of the maps shade it all the
    /// same: with [`Technique::Reference`] the truth of normal mapping (LEADR Figure 8).
    pub displacement: bool,
    /// With [`Technique::Reference`]: the relief throws shadows on itself, from every light and from the environment
    /// (`render::passes::reference`), instead of the sun's coarse ones only. Slow.
    pub relief_shadows: bool,
    /// Paints the inside of surfaces in a marker colour: a closed surface shows none.
    pub mark_inside: bool,
}

impl RenderSettings {
    /// Most edge samples.
    pub const MAX_EDGE_SAMPLES: u32 = 256;

    /// Whether a picture can be made like this.
    ///
    /// # Errors
    /// A sentence about what is wrong.
    pub fn check(&self) -> Result<(), String> {
        let most = Self::MAX_EDGE_SAMPLES;
        if !(1..=most).contains(&self.edge_samples) {
            return Err(format!("{} edge samples are not 1 to {most}", self.edge_samples));
        }
        self.shading.check()
    }

    /// [`edge_samples`](Self::edge_samples) of this technique; none where there are no more than the shaded sample.
    #[must_use]
    pub fn edges(&self) -> Option<u32> {
        (self.edge_samples > 1 && self.shading.technique != Technique::Reference).then_some(self.edge_samples)
    }

    /// Offset of sample `index` from the middle of its pixel, pixels.
    #[must_use]
    pub fn sample_offset(&self, index: u32) -> Vec2 {
        jitter(index, self.samples.max(1), self.seed)
    }

    /// What the heights of the geometry are multiplied by where those of the maps are by `height_scale`.
    #[must_use]
    pub fn geometry_scale(&self, height_scale: f32) -> f32 {
        if self.displacement { height_scale } else { 0.0 }
    }

    /// Whether the relief throws shadows on itself.
    #[must_use]
    pub fn shadows_of_relief(&self) -> bool {
        self.relief_shadows && self.shading.technique == Technique::Reference
    }
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            size: (1024, 1024),
            samples: 1,
            seed: 0,
            edge_samples: 1,
            shading: ShadingSettings::default(),
            tessellation: TessellationSettings::default(),
            shadows: true,
            displacement: true,
            relief_shadows: false,
            mark_inside: false,
        }
    }
}
