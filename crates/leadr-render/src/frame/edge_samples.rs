//! The edge samples of a frame, which are drawn in addition to the pixels.

use super::targets::EdgeTargets;
use crate::passes::edges::{EdgeRays, JoinPass};
use crate::passes::shade::ShadePass;
use crate::pixel_area::PixelArea;
use crate::sampling::edge_jitter;
use crate::view::{Samples, View};

/// The edge samples that belong to each sample of a frame. Clones share targets and pipelines.
#[derive(Clone)]
pub struct EdgeSamples {
    /// The number of edge samples per pixel.
    pub samples: u32,
    /// The pixels that can contain surfaces.
    pub area: PixelArea,
    /// The render targets.
    pub targets: EdgeTargets,
    /// The pass that shades edge samples that lie on a different surface from the pixel's surface.
    pub shade: ShadePass,
    /// The pass that joins the edge samples of each pixel.
    pub join: JoinPass,
}

/// An image of edge samples.
pub struct EdgeImage {
    /// The view of the samples.
    pub view: View,
    /// The rays through the edge samples and the pixels.
    pub rays: EdgeRays,
    /// The scissor rectangle: x, y, width, height.
    pub scissor: [u32; 4],
}

impl EdgeSamples {
    /// Returns the images whose samples are the edge samples of the pixels in `pixels`.
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
