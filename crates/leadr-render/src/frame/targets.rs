//! The render targets of a frame.

use std::sync::Arc;

use crate::passes::targets::{JoinedEdges, MultisampleTargets, RADIANCE_FORMAT, SampleTargets};
use leadr_gpu::{Gpu, Image, ImageDesc, Result};

/// The render targets of edge samples and of their sums. Clones share the images.
#[derive(Clone)]
pub struct EdgeTargets {
    /// The targets of one image of edge samples.
    pub samples: SampleTargets,
    /// The sums over the edge samples of each pixel.
    pub joined: JoinedEdges,
    /// The number of edge samples along one side of a pixel, in one image.
    pub grid: u32,
}

/// The parameters that determine which images a frame needs.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TargetShape {
    /// The width and height in pixels.
    pub size: (u32, u32),
    /// The number of edge samples along one side of a pixel in one image, if any.
    pub grid: Option<u32>,
    /// The number of geometry samples per pixel.
    pub msaa: u32,
    /// Whether the frame uses a G-buffer.
    pub gbuffer: bool,
    /// The number of shadow-casting suns.
    pub sun_maps: u32,
}

/// The images of a frame. Clones share the images.
#[derive(Clone)]
pub struct Targets {
    shape: TargetShape,
    /// The targets for the pixels' own samples.
    pub pixels: SampleTargets,
    /// The targets for multisampled geometry, if multisampling is on.
    pub multisample: Option<MultisampleTargets>,
    /// The targets for edge samples, if any.
    pub edges: Option<EdgeTargets>,
    /// The image with the mean of the samples.
    pub mean: Image,
}

impl EdgeTargets {
    fn new(gpu: &Arc<Gpu>, size: (u32, u32), grid: u32, sun_maps: u32) -> Result<Self> {
        let samples = SampleTargets::new(gpu, (grid * size.0, grid * size.1), true)?;
        Ok(Self { samples, joined: JoinedEdges::new(gpu, size, sun_maps)?, grid })
    }
}

impl Targets {
    /// Makes the images for a shape. `mean` is the mean image of an earlier frame, which is reused if its size fits.
    pub fn new(gpu: &Arc<Gpu>, shape: TargetShape, mean: Option<Image>) -> Result<Self> {
        let TargetShape { size, grid, msaa, gbuffer, sun_maps } = shape;
        let multisample = (msaa > 1).then(|| MultisampleTargets::new(gpu, size, msaa)).transpose()?;
        let pixels = match multisample {
            Some(_) => SampleTargets::with_slots(gpu, size)?,
            None => SampleTargets::new(gpu, size, gbuffer)?,
        };
        let mean = match mean.filter(|mean| mean.mip_extent(0) == [size.0, size.1]) {
            Some(mean) => mean,
            None => Image::new(gpu, "mean", ImageDesc::new(RADIANCE_FORMAT, size.0, size.1).storage())?,
        };
        let edges = grid.map(|grid| EdgeTargets::new(gpu, size, grid, sun_maps)).transpose()?;
        Ok(Self { shape, pixels, multisample, edges, mean })
    }

    /// Whether the targets can be used for frames of this shape.
    pub fn fits(&self, shape: TargetShape) -> bool {
        let TargetShape { size, sun_maps, .. } = shape;
        (TargetShape { sun_maps, ..self.shape }) == shape
            && self.edges.as_ref().is_none_or(|edges| edges.joined.fits(size, sun_maps))
    }
}
