//! Image targets of a frame.

use std::sync::Arc;

use crate::passes::targets::{JoinedEdges, MultisampleTargets, RADIANCE_FORMAT, SampleTargets};
use leadr_gpu::{Gpu, Image, ImageDesc, Result};

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

/// What decides the images of a frame.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct TargetShape {
    /// Pixels across and down.
    pub size: (u32, u32),
    /// Edge samples along a side of a pixel in one image, if there are any.
    pub grid: Option<u32>,
    /// Samples of the geometry in each pixel.
    pub msaa: u32,
    /// Whether anything goes through the G-buffer.
    pub gbuffer: bool,
    /// Suns with shadows.
    pub sun_maps: u32,
}

/// The images of a frame. Clones share them.
#[derive(Clone)]
pub struct Targets {
    shape: TargetShape,
    /// The samples that the pixels' own surfaces are shaded by.
    pub pixels: SampleTargets,
    /// Where the geometry is multisampled.
    pub multisample: Option<MultisampleTargets>,
    /// Where there are edge samples.
    pub edges: Option<EdgeTargets>,
    /// The mean of the samples.
    pub mean: Image,
}

impl EdgeTargets {
    fn new(gpu: &Arc<Gpu>, size: (u32, u32), grid: u32, sun_maps: u32) -> Result<Self> {
        let samples = SampleTargets::new(gpu, (grid * size.0, grid * size.1), true)?;
        Ok(Self { samples, joined: JoinedEdges::new(gpu, size, sun_maps)?, grid })
    }
}

impl Targets {
    /// Images of a shape. `mean`: that of another frame, which may be kept.
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

    /// Whether they serve frames of a shape.
    pub fn suit(&self, shape: TargetShape) -> bool {
        let TargetShape { size, sun_maps, .. } = shape;
        (TargetShape { sun_maps, ..self.shape }) == shape
            && self.edges.as_ref().is_none_or(|edges| edges.joined.suit(size, sun_maps))
    }
}
