//! Image targets of a frame.

use std::sync::Arc;

use crate::gpu::{Gpu, Image, ImageDesc, Result};
use crate::render::passes::targets::{GBuffer, JoinedEdges, RADIANCE_FORMAT, VisibleSurface};

/// What a sample of every pixel sees, and its radiance.
pub struct SampleTargets {
    pub visible: VisibleSurface,
    pub gbuffer: GBuffer,
    pub radiance: Image,
}

impl SampleTargets {
    fn new(gpu: &Arc<Gpu>, size: (u32, u32)) -> Result<Self> {
        let radiance = ImageDesc::new(RADIANCE_FORMAT, size.0, size.1).color_target();
        Ok(Self {
            visible: VisibleSurface::new(gpu, size)?,
            gbuffer: GBuffer::new(gpu, size)?,
            radiance: Image::new(gpu, "sample", radiance)?,
        })
    }
}

/// Edge samples and what they add up to.
pub struct EdgeTargets {
    pub samples: SampleTargets,
    pub joined: JoinedEdges,
    /// Edge samples across a pixel in one drawing.
    pub grid: u32,
}

/// Image targets of one size.
pub struct Targets {
    pub size: (u32, u32),
    /// The sample that a pixel's surface is shaded by.
    pub pixel: SampleTargets,
    /// Where there are edge samples.
    pub edges: Option<EdgeTargets>,
    /// The mean of the samples.
    pub mean: Image,
}

impl EdgeTargets {
    fn new(gpu: &Arc<Gpu>, size: (u32, u32), grid: u32) -> Result<Self> {
        let samples = SampleTargets::new(gpu, (grid * size.0, grid * size.1))?;
        Ok(Self { samples, joined: JoinedEdges::new(gpu, size)?, grid })
    }
}

impl Targets {
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32), grid: Option<u32>) -> Result<Self> {
        let mean = ImageDesc::new(RADIANCE_FORMAT, size.0, size.1).storage();
        Ok(Self {
            size,
            pixel: SampleTargets::new(gpu, size)?,
            edges: grid.map(|grid| EdgeTargets::new(gpu, size, grid)).transpose()?,
            mean: Image::new(gpu, "mean", mean)?,
        })
    }

    /// Whether they serve a frame of this size, with such a grid of edge samples or without any.
    pub fn suit(&self, size: (u32, u32), grid: Option<u32>) -> bool {
        self.size == size && self.edges.as_ref().map(|edges| edges.grid) == grid
    }
}
