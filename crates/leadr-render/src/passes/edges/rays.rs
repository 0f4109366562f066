//! The positions of the edge samples in an image, in the form that the passes read.

use crate::pixel_area::PixelArea;
use crate::view::View;
use leadr_gpu::shared_struct;

shared_struct! {
    /// The rays through the pixel's own sample and through an edge sample (`EdgeRays` in `passes/edges/edges.glsl`).
    pub struct EdgeRays for "EdgeRays" {
        /// The x axis of [`Camera::rays`](crate::camera::Camera::rays). The number of edge samples per pixel is in w.
        pub x: [f32; 4],
        /// The y axis of the rays. The component w is unused.
        pub y: [f32; 4],
        /// The z axis of the rays through the pixel's own sample. The near distance is in w.
        pub pixel: [f32; 4],
        /// The z axis of the rays through the edge sample. The number of edge samples per pixel in earlier images is in w.
        pub edge: [f32; 4],
        /// The left, top, right and bottom of the [`PixelArea`] to draw.
        pub area: [i32; 4],
    }
}

impl EdgeRays {
    /// Returns the rays for two views: `edge` shows an image of edge samples, and `pixel` shows the pixels' own samples. Each pixel
    /// has `samples` edge samples, of which `before` are in earlier images.
    pub fn new(pixel: &View, edge: &View, before: u32, samples: u32, area: PixelArea) -> Self {
        // The rays of the two images differ only in z.
        let ([x, y, through_pixel], [_, _, through_edge]) = (pixel.rays(), edge.rays());
        let PixelArea { left, top, right, bottom } = area;
        Self {
            x: x.extend(samples as f32).to_array(),
            y: y.extend(0.0).to_array(),
            pixel: through_pixel.extend(pixel.camera.near).to_array(),
            edge: through_edge.extend(before as f32).to_array(),
            area: [left, top, right, bottom].map(u32::cast_signed),
        }
    }
}
