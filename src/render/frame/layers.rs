//! What of the G-buffer can be read back.

use glam::DVec2;

use super::Renderer;
use crate::gpu::Result;
use crate::reflectance::frame::octahedral_decode;

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
    /// Reads a layer of the last sample's G-buffer; unused channels are zero.
    ///
    /// # Errors
    /// A lost device, or memory that is short.
    pub fn layer(&self, layer: Layer) -> Result<Vec<[f32; 4]>> {
        let Some(targets) = &self.targets else { return Ok(Vec::new()) };
        let gbuffer = &targets.pixel.gbuffer;
        Ok(match layer {
            Layer::Depth => {
                let depth: Vec<f32> = targets.pixel.visible.depth.read(0, 0)?;
                let distance = |z: f32| if z > 0.0 { self.near / z } else { f32::INFINITY };
                depth.iter().map(|&z| [distance(z), 0.0, 0.0, 0.0]).collect()
            }
            Layer::Normal => {
                let frame: Vec<[f32; 4]> = gbuffer.frame.read(0, 0)?;
                frame
                    .iter()
                    .map(|f| {
                        let n = octahedral_decode(DVec2::new(f64::from(f[0]), f64::from(f[1])));
                        n.as_vec3().extend(0.0).to_array()
                    })
                    .collect()
            }
            Layer::MeanSlope => {
                let frame: Vec<[f32; 4]> = gbuffer.frame.read(0, 0)?;
                frame.iter().map(|f| [f[2], f[3], 0.0, 0.0]).collect()
            }
            Layer::Covariance => {
                let covariance: Vec<[f32; 4]> = gbuffer.covariance.read(0, 0)?;
                covariance.iter().map(|c| [c[0], c[1], c[2], 0.0]).collect()
            }
            Layer::Lod => {
                let covariance: Vec<[f32; 4]> = gbuffer.covariance.read(0, 0)?;
                covariance.iter().map(|c| [c[3], 0.0, 0.0, 0.0]).collect()
            }
            Layer::Albedo | Layer::Roughness => {
                let material: Vec<[half::f16; 4]> = gbuffer.material.read(0, 0)?;
                material
                    .iter()
                    .map(|m| {
                        let m = m.map(f32::from);
                        if layer == Layer::Albedo { [m[0], m[1], m[2], 0.0] } else { [m[3], 0.0, 0.0, 0.0] }
                    })
                    .collect()
            }
        })
    }
}
