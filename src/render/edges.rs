//! Edge samples: outlines as smooth as of many samples, at one shaded sample per pixel.
//!
//! The geometry is drawn again with a grid of samples in every pixel, as often as it takes, each time moved by a part of the
//! grid's cell. Where such an edge sample sees the surface that the pixel's own sample sees (the same object, in one plane with it), the pixel's shading is used again: it is that of the
//! pixel's whole footprint anyway. What sees another surface, across an outline, is filtered and shaded, each with the
//! footprint of a whole pixel. So the inside of a surface is shaded once, bit for bit as without edge samples.

use std::sync::Arc;

use bytemuck::{Pod, Zeroable};
use glam::Vec3;

use super::geometry::VisibleSurface;
use crate::gpu::{Commands, ComputePipeline, Descriptor, Filter, Gpu, Result, Sampler, Use, Wrap};

/// Alpha of the radiance of an edge sample that sees its pixel's own surface (`passes/edges.glsl`).
pub const OF_THE_PIXEL: f32 = -1.0;

/// Edge samples across a pixel in one drawing, at most.
pub const MAX_GRID: u32 = 4;
/// Edge samples in one drawing, at most: they take 116 bytes each.
const MAX_DRAWN: u64 = 1 << 22;

/// The largest grid, up to `finest`, that makes up `samples` edge samples of a picture of `size` in several drawings: 1, 2 or 4
/// samples across a pixel.
#[must_use]
pub fn edge_grid(samples: u32, size: (u32, u32), finest: u32) -> u32 {
    let pixels = u64::from(size.0) * u64::from(size.1);
    let fits = |&grid: &u32| samples.is_multiple_of(grid * grid) && u64::from(grid * grid) * pixels <= MAX_DRAWN;
    [4, 2].into_iter().filter(|&grid| grid <= finest).find(fits).unwrap_or(1)
}

/// Rays through a pixel's own sample and an edge sample (`EdgeRays` in `passes/edges.comp`).
#[repr(C)]
#[derive(Clone, Copy, Debug, Pod, Zeroable)]
pub struct EdgeRays {
    /// See [`Camera::rays`](super::camera::Camera::rays).
    pub x: [f32; 4],
    /// As `x`.
    pub y: [f32; 4],
    /// The last ray of the pixel's own sample; w: near plane.
    pub pixel: [f32; 4],
    /// Of the edge sample.
    pub edge: [f32; 4],
}

impl EdgeRays {
    /// Of two samples' rays, which differ in the last alone.
    #[must_use]
    pub fn new([x, y, pixel]: [Vec3; 3], [_, _, edge]: [Vec3; 3], near: f32) -> Self {
        let [x, y, edge] = [x, y, edge].map(|v| v.extend(0.0).to_array());
        Self { x, y, pixel: pixel.extend(near).to_array(), edge }
    }
}

/// The pass that marks what need not be shaded again.
pub struct EdgePass {
    pipeline: ComputePipeline,
    nearest: Sampler,
}

impl EdgePass {
    /// The pass.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        Ok(Self {
            pipeline: ComputePipeline::new(gpu, "passes/edges.comp", &[])?,
            nearest: Sampler::new(gpu, "edges", Filter::Nearest, Wrap::Clamp)?,
        })
    }

    /// Marks where the samples of `edge` see the surface that their `pixel` sees, and leaves them readable.
    pub fn record(&self, cmd: &mut Commands, pixel: &VisibleSurface, edge: &VisibleSurface, rays: &EdgeRays) {
        cmd.transition(&edge.surface, Use::ComputeReadWrite);
        cmd.bind(
            &self.pipeline,
            &[
                (0, Descriptor::Sampled(pixel.surface.whole(), &self.nearest)),
                (1, Descriptor::Sampled(pixel.tangent.whole(), &self.nearest)),
                (2, Descriptor::Sampled(pixel.depth.whole(), &self.nearest)),
                (3, Descriptor::StorageImage(edge.surface.whole())),
                (4, Descriptor::Sampled(edge.tangent.whole(), &self.nearest)),
                (5, Descriptor::Sampled(edge.depth.whole(), &self.nearest)),
            ],
        );
        cmd.push_constants(rays);
        let [width, height] = edge.surface.mip_extent(0);
        cmd.dispatch_invocations(&self.pipeline, [width, height, 1]);
        cmd.transition(&edge.surface, Use::Sampled);
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grids_divide_the_samples_and_fit_into_memory() {
        for (samples, size, finest, grid) in [
            (64, (128, 128), 4, 4),
            (64, (128, 128), 1, 1),
            (8, (128, 128), 4, 2),
            (6, (128, 128), 4, 1),
            (64, (1280, 720), 4, 2),
            (64, (4096, 2160), 4, 1),
        ] {
            assert_eq!(edge_grid(samples, size, finest), grid, "{samples} of {size:?}");
        }
    }
}
