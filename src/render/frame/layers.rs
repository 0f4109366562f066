//! What of the G-buffer can be read back.

use glam::Vec4;

use super::renderer::Renderer;
use crate::gpu::Result;
use crate::render::passes::targets::FilteredPixel;

/// What else of the G-buffer can be read back: the last sample's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// Distance along the view axis, metres; infinity where nothing is.
    Depth,
    /// World displacement direction.
    Normal,
    /// Mean slope in the frame about it.
    MeanSlope,
    /// Slope covariance `sxx, syy, sxy`.
    Covariance,
    /// Level of detail of the maps.
    Lod,
    /// Linear albedo.
    Albedo,
    /// Beckmann roughness of the base material.
    Roughness,
}

impl Renderer {
    /// Reads a layer of the last sample's G-buffer; unused channels are zero. Empty before the first sample.
    ///
    /// # Errors
    /// A lost device, or memory that is short.
    pub fn layer(&self, layer: Layer) -> Result<Vec<[f32; 4]>> {
        let (Some(targets), Some(near)) = (&self.targets, self.near) else { return Ok(Vec::new()) };
        let channels: fn(&FilteredPixel) -> Vec4 = match layer {
            Layer::Depth => {
                let depth: Vec<f32> = targets.pixels.visible.depth.read(0, 0)?;
                let distance = |z: f32| if z > 0.0 { near / z } else { f32::INFINITY };
                return Ok(depth.iter().map(|&z| [distance(z), 0.0, 0.0, 0.0]).collect());
            }
            Layer::Normal => |pixel| pixel.normal.as_vec3().extend(0.0),
            Layer::MeanSlope => |pixel| pixel.mean_slope.extend(0.0).extend(0.0),
            Layer::Covariance => |pixel| pixel.slope_covariance.extend(0.0),
            Layer::Lod => |pixel| Vec4::X * pixel.lod,
            Layer::Albedo => |pixel| pixel.albedo.extend(0.0),
            Layer::Roughness => |pixel| Vec4::X * pixel.roughness,
        };
        Ok(targets.pixels.gbuffer.read()?.iter().map(|pixel| channels(pixel).to_array()).collect())
    }
}
