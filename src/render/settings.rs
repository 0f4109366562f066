//! What a picture is made with.

use super::tessellation::TessellationSettings;

/// How a surface is filtered and shaded.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Technique {
    /// LEADR mapping: mean slope and slope covariance of the pixel.
    Leadr,
    /// Mipmapped normals with the same BRDF: the mean slope alone.
    NormalMip,
    /// The finest level of the maps and no statistics: correct with enough samples per pixel.
    Reference,
}

impl Technique {
    /// `TECHNIQUE_` value of `passes/filter/filter.frag`.
    #[must_use]
    pub fn filter_code(self) -> i32 {
        match self {
            Self::Leadr => 0,
            Self::NormalMip => 1,
            Self::Reference => 2,
        }
    }

    /// The name on the command line.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Leadr => "leadr",
            Self::NormalMip => "normal-mip",
            Self::Reference => "reference",
        }
    }
}

/// Settings that choose pipelines: changing one builds new pipelines.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ShadingSettings {
    /// How surfaces are filtered.
    pub technique: Technique,
    /// `N` of the `N × N` slope samples, 1 to 128.
    pub grid: u32,
    /// Masking and shadowing, or masking alone.
    pub shadowing: bool,
    /// Diffuse lights through order-2 SH (Algorithm 2) instead of the exact clamped cosine.
    pub lights_by_sh: bool,
}

impl Default for ShadingSettings {
    fn default() -> Self {
        Self { technique: Technique::Leadr, grid: 5, shadowing: true, lights_by_sh: false }
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
    /// Shading.
    pub shading: ShadingSettings,
    /// Tessellation.
    pub tessellation: TessellationSettings,
    /// Whether the sun throws shadows.
    pub shadows: bool,
    /// With [`Technique::Reference`]: the relief throws shadows on itself, from every light and from the environment
    /// ([`super::reference`]), instead of the sun's coarse ones only. Slow.
    pub relief_shadows: bool,
    /// Paints the inside of surfaces in a marker colour: a closed surface shows none.
    pub mark_inside: bool,
}

impl RenderSettings {
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
            shading: ShadingSettings::default(),
            tessellation: TessellationSettings::default(),
            shadows: true,
            relief_shadows: false,
            mark_inside: false,
        }
    }
}
