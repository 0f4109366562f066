//! Image targets of a frame.

use std::sync::Arc;

use crate::gpu::{Gpu, Image, ImageDesc, Result};
use crate::render::passes::targets::{JoinedEdges, RADIANCE_FORMAT, SampleTargets};

/// Edge samples and what they add up to. Clones share the images.
#[derive(Clone)]
pub struct EdgeTargets {
    /// An image of edge samples.
    pub samples: SampleTargets,
    /// What the edge samples of each pixel add up to.
    pub joined: JoinedEdges,
    /// Edge samples along a side of a pixel in one image.
    pub grid: u32,
}

/// The images of a frame. Clones share them.
#[derive(Clone)]
pub struct Targets {
    /// Pixels across and down.
    pub size: (u32, u32),
    /// The samples that the pixels' own surfaces are shaded by.
    pub pixels: SampleTargets,
    /// Where there are edge samples.
    pub edges: Option<EdgeTargets>,
    /// The mean of the samples.
    pub mean: Image,
}

impl EdgeTargets {
    fn new(gpu: &Arc<Gpu>, size: (u32, u32), grid: u32, shadow_maps: u32) -> Result<Self> {
        let samples = SampleTargets::new(gpu, (grid * size.0, grid * size.1))?;
        Ok(Self { samples, joined: JoinedEdges::new(gpu, size, shadow_maps)?, grid })
    }
}

impl Targets {
    /// For a picture of `size` pixels, with such a grid of edge samples or without any, and so many shadow maps.
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32), grid: Option<u32>, shadow_maps: u32) -> Result<Self> {
        let mean = ImageDesc::new(RADIANCE_FORMAT, size.0, size.1).storage();
        Ok(Self {
            size,
            pixels: SampleTargets::new(gpu, size)?,
            edges: grid.map(|grid| EdgeTargets::new(gpu, size, grid, shadow_maps)).transpose()?,
            mean: Image::new(gpu, "mean", mean)?,
        })
    }

    /// Whether they serve a frame of this size, with such a grid of edge samples or without any, and so many shadow maps.
    pub fn suit(&self, size: (u32, u32), grid: Option<u32>, shadow_maps: u32) -> bool {
        let edges = self.edges.as_ref();
        self.size == size
            && edges.map(|edges| edges.grid) == grid
            && edges.is_none_or(|edges| edges.joined.suit(size, shadow_maps))
    }
}
