//! The settings of an image.

pub mod numbers;
mod option;
mod shading;
mod shading_options;
mod technique;
mod terms;

use glam::Vec2;

pub use self::option::{Json, Named, Panel, Slider, Spec, Techniques, Text, Value, headings, on_off};
pub use self::shading::{
    BaseFrame, DiffuseLights, FresnelForm, GridLod, LodBias, PixelKernel, Probes, Quadrature, Shading,
};
pub use self::shading_options::{ShadingOption, ShadingOptions, Subject};
pub use self::technique::{Needs, Technique};
pub use self::terms::Terms;
use super::constants::MOST_MULTISAMPLES;
use super::sampling::jitter;
use super::surfaces::tessellation::TessellationSettings;
use super::view::Samples;

/// All settings of an image, without the scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RenderSettings {
    /// The width and height in pixels.
    pub size: (u32, u32),
    /// The number of samples per pixel, at least 1. Each sample is a full frame with its own offset in the pixel.
    pub samples: u32,
    /// The number of geometry samples per pixel, which is 1, 2, 4 or 8. More than one sample smooths outlines, and each surface in
    /// a pixel is still shaded once. Edge samples and the reference also smooth outlines, so the number is 1 with them.
    pub msaa: u32,
    /// The seed of the sample offsets. A single sample always lies at the centre of the pixel.
    pub seed: u64,
    /// The technique and its settings.
    pub shading: Shading,
    /// The tessellation settings.
    pub tessellation: TessellationSettings,
    /// Whether the sun casts shadows.
    pub shadows: bool,
    /// Whether heights displace the surface. Without displacement, the slopes of the maps still shade the smooth geometry. With
    /// [`Technique::Reference`], the result is the ground truth of normal mapping (LEADR Figure 8).
    pub displacement: bool,
    /// Whether to paint the inside of surfaces in a marker colour. Closed surfaces never show their inside.
    pub mark_inside: bool,
}

impl RenderSettings {
    /// Checks whether these settings can produce an image.
    ///
    /// # Errors
    /// Returns a description of the invalid setting.
    pub fn check(&self) -> Result<(), String> {
        self.shading.check()?;
        let msaa = self.msaa;
        if !msaa.is_power_of_two() || msaa > MOST_MULTISAMPLES {
            return Err(format!("{msaa} geometry samples per pixel are not supported: use 1, 2, 4 or 8"));
        }
        Ok(())
    }

    /// Returns these settings with a different shading. For the reference, the samples per pixel smooth the outlines, and the
    /// geometry has a vertex at every texel.
    pub fn shaded_by(&self, shading: Shading) -> Self {
        let reference = shading.technique().is_reference();
        Self {
            msaa: if reference { 1 } else { self.msaa },
            shading,
            tessellation: TessellationSettings { to_texels: reference, ..self.tessellation },
            ..*self
        }
    }

    /// Returns how the geometry samples map to the pixels.
    pub fn pixel_samples(&self) -> Samples {
        if self.msaa > 1 { Samples::Multisampled { count: self.msaa } } else { Samples::Pixels }
    }

    /// Returns the number of edge samples per sample, or `None` without edge samples.
    pub fn edges(&self) -> Option<u32> {
        Some(self.shading.options().edge_samples).filter(|samples| *samples > 1)
    }

    /// Whether the relief casts shadows on itself.
    pub fn shadows_of_relief(&self) -> bool {
        self.shading.options().relief_shadows
    }

    /// Returns the offset of sample `index` from its pixel centre, in pixels.
    pub fn sample_offset(&self, index: u32) -> Vec2 {
        jitter(index, self.samples.max(1), self.seed)
    }

    /// Returns the height scale of the geometry. `height_scale` is that of the maps.
    pub fn geometry_scale(&self, height_scale: f32) -> f32 {
        if self.displacement { height_scale } else { 0.0 }
    }
}

impl Default for RenderSettings {
    fn default() -> Self {
        Self {
            size: (1024, 1024),
            samples: 1,
            msaa: 1,
            seed: 0,
            shading: Shading::default(),
            tessellation: TessellationSettings::default(),
            shadows: true,
            displacement: true,
            mark_inside: false,
        }
    }
}
