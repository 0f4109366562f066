//! The edge samples of a frame: sub-frames of their own beside that of the pixels.

use super::targets::EdgeTargets;
use crate::passes::edges::{EdgeRays, JoinPass};
use crate::passes::shade::ShadePass;
use crate::pixel_area::PixelArea;
use crate::sampling::edge_jitter;
use crate::view::{Samples, View};

/// The edge samples of every sample of a frame. Clones share targets and pipelines.
#[derive(Clone)]
pub struct EdgeSamples {
    /// Edge samples of each pixel.
    pub samples: u32,
    /// Where they can see anything.
    pub area: PixelArea,
    /// What they are drawn into.
    pub targets: EdgeTargets,
    /// Shades those that see another surface than their pixel.
    pub shade: ShadePass,
    /// Joins those of each pixel.
    pub join: JoinPass,
}

/// One image of edge samples.
pub struct EdgeImage {
    /// The samples.
    pub view: View,
    /// Their places beside those of the pixels.
    pub rays: EdgeRays,
    /// Where they are drawn: x, y, width, height.
    pub scissor: [u32; 4],
}

impl EdgeSamples {
    /// The images that make up the edge samples beside the pixels' own samples.
    pub fn images(&self, pixels: &View) -> Vec<EdgeImage> {
        let grid = self.targets.grid;
        let count = self.samples / (grid * grid);
        let image = |k| {
            let offset = edge_jitter(pixels.offset, k, count);
            let view = View { samples: Samples::Edges { grid }, offset, ..*pixels };
            let before = k * grid * grid;
            let rays = EdgeRays::new(pixels, &view, before, self.samples, self.area);
            EdgeImage { view, rays, scissor: self.area.scissor(grid) }
        };
        (0..count).map(image).collect()
    }
}
