//! The two truths of the LEADR paper's Figure 8, and a third truth with all shadows of the bumps.

use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr_render::surfaces::tessellation::TessellationSettings;

/// The reference picture of a comparison.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Truth {
    /// A supersampled picture of the displaced surface.
    Displacement,
    /// A supersampled picture of the displaced surface. Bumps shadow each other from every light and the environment.
    Shadowed,
    /// A supersampled picture of the smooth surface with the slopes of the displaced surface.
    NormalMap,
}

impl Truth {
    /// Returns the name that files and data use.
    pub fn name(self) -> &'static str {
        match self {
            Self::Displacement => "displacement",
            Self::Shadowed => "shadowed",
            Self::NormalMap => "normal-map",
        }
    }

    /// Returns the name that the page shows.
    pub fn title(self) -> &'static str {
        match self {
            Self::Displacement => "displacement-map truth",
            Self::Shadowed => "displacement-map truth with all shadows of the bumps",
            Self::NormalMap => "normal-map truth",
        }
    }

    /// Returns the settings of a picture of this truth for surfaces with a Beckmann base.
    pub fn settings(self, size: (u32, u32), samples: u32, seed: u64) -> RenderSettings {
        self.settings_for(Technique::Leadr, size, samples, seed)
    }

    /// Returns the settings of a picture of this truth for comparison with `technique`, with the same base material.
    pub fn settings_for(self, technique: Technique, size: (u32, u32), samples: u32, seed: u64) -> RenderSettings {
        let default = ShadingOptions::default();
        RenderSettings {
            size,
            samples,
            seed,
            shading: technique.reference().with(ShadingOptions {
                relief_shadows: self == Self::Shadowed,
                shadowing: if self == Self::NormalMap { Shadowing::NormalMap } else { default.shadowing },
                sky_occlusion: false,
                // An estimate of occlusion is not needed. The `Shadowed` truth has all shadows, and the other truths have
                // none.
                relief_occlusion: false,
                ..default
            }),
            // A smooth surface does not need a vertex per texel.
            tessellation: TessellationSettings { to_texels: self != Self::NormalMap, ..Default::default() },
            displacement: self != Self::NormalMap,
            ..Default::default()
        }
    }
}
