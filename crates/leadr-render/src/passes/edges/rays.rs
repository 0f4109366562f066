//! Positions of the edge samples in an image, as the passes read them.

use crate::pixel_area::PixelArea;
use crate::view::View;
use leadr_gpu::shared_struct;

shared_struct! {
    /// Rays through a pixel's own sample and an edge sample (`EdgeRays` in `passes/edges/edges.glsl`).
    pub struct EdgeRays for "EdgeRays" {
        /// The x axis of [`Camera::rays`](crate::camera::Camera::rays); w: edge samples per pixel.
        pub x: [f32; 4],
        /// The y axis of the rays; w is unused.
        pub y: [f32; 4],
        /// The z axis of the rays of the pixel's own sample; w: near plane.
        pub pixel: [f32; 4],
        /// The z axis of the rays of the edge sample; w: edge samples per pixel in earlier images.
        pub edge: [f32; 4],
        /// The [`PixelArea`] to draw: left, top, right, bottom.
        pub area: [i32; 4],
    }
}

impl EdgeRays {
    /// Returns the rays of `edge`, an image of edge samples, and of `pixel`, the pixels' own samples. Each pixel has `samples` edge
    /// samples, `before` of them in earlier images.
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
