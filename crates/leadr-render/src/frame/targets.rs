//! Render targets of a frame.

use std::sync::Arc;

use crate::passes::targets::{JoinedEdges, MultisampleTargets, RADIANCE_FORMAT, SampleTargets};
use leadr_gpu::{Gpu, Image, ImageDesc, Result};

/// Render targets of edge samples and their sums. Clones share the images.
#[derive(Clone)]
pub struct EdgeTargets {
    /// An image of edge samples.
    pub samples: SampleTargets,
    /// The joined sums of each pixel's edge samples.
    pub joined: JoinedEdges,
    /// Edge samples along one side of a pixel, in one image.
    pub grid: u32,
}

/// The parameters that determine a frame's images.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TargetShape {
    /// Width and height in pixels.
    pub size: (u32, u32),
    /// Edge samples along one side of a pixel in one image, if any.
    pub grid: Option<u32>,
    /// Geometry samples per pixel.
    pub msaa: u32,
    /// Whether the G-buffer is used.
    pub gbuffer: bool,
    /// Number of shadow-casting suns.
    pub sun_maps: u32,
}

/// The images of a frame, shared by clones.
#[derive(Clone)]
pub struct Targets {
    shape: TargetShape,
    /// Targets for the samples of the pixels' own surfaces.
    pub pixels: SampleTargets,
    /// Targets for multisampled geometry, if enabled.
    pub multisample: Option<MultisampleTargets>,
    /// Targets for edge samples, if enabled.
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
    /// Makes images of a shape. `mean` is an earlier frame's mean image, which is reused if it fits.
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

    /// Whether the targets fit frames of this shape.
    pub fn fits(&self, shape: TargetShape) -> bool {
        let TargetShape { size, sun_maps, .. } = shape;
        (TargetShape { sun_maps, ..self.shape }) == shape
            && self.edges.as_ref().is_none_or(|edges| edges.joined.fits(size, sun_maps))
    }
}
