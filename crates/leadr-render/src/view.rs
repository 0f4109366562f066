//! One image of a scene, and how the samples of the image map to pixels.

use glam::{Mat4, Vec2, Vec3};

use super::camera::Camera;
use super::surfaces::tessellation::Lens;

/// How the samples of an image map to pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Samples {
    /// There is one sample per pixel, which selects the surface that the pixel shades.
    Pixels,
    /// The geometry is multisampled. Each surface that covers a sample of the pixel is shaded once.
    Multisampled {
        /// The number of geometry samples per pixel, which is a power of two.
        count: u32,
    },
    /// There is a grid of edge samples in every pixel.
    Edges {
        /// The number of edge samples along one side of a pixel.
        grid: u32,
    },
}

/// One image of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The camera.
    pub camera: Camera,
    /// The width and height in pixels.
    pub picture: (u32, u32),
    /// How the samples map to the pixels of the image.
    pub samples: Samples,
    /// The offset of each sample from the centre of its grid cell, in units of cells, in `[-½, ½)²`.
    pub offset: Vec2,
    /// The number of levels by which the maps are read coarser than the pixels require.
    pub lod_bias: f32,
}

impl View {
    /// Returns the number of samples along one side of a pixel.
    pub fn grid(&self) -> u32 {
        match self.samples {
            Samples::Pixels | Samples::Multisampled { .. } => 1,
            Samples::Edges { grid } => grid,
        }
    }

    /// Returns the numbers of samples across and down the image.
    pub fn size(&self) -> (u32, u32) {
        let (width, height) = self.picture;
        (self.grid() * width, self.grid() * height)
    }

    /// Returns the matrix of [`Camera::clip_from_world`] for this image.
    pub fn clip_from_world(&self) -> Mat4 {
        self.camera.clip_from_world(self.size(), self.offset)
    }

    /// Returns the rays through the image, as in [`Camera::rays`].
    pub fn rays(&self) -> [Vec3; 3] {
        self.camera.rays(self.size(), self.offset)
    }

    /// Returns the factor from lengths at unit distance to pixels, independent of the number of samples per pixel.
    pub fn lens(&self) -> Lens {
        self.camera.lens(self.picture.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn grid_refines_image_and_keeps_lens() {
        let camera = Camera::looking_at(Vec3::new(-5.0, 1.0, 2.0), Vec3::ZERO, 60.0);
        let pixels = View { camera, picture: (20, 10), samples: Samples::Pixels, offset: Vec2::ZERO, lod_bias: 0.0 };
        let edges = View { samples: Samples::Edges { grid: 4 }, ..pixels };
        assert_eq!((pixels.size(), edges.size()), ((20, 10), (80, 40)));
        assert_eq!(pixels.lens().focal_pixels, edges.lens().focal_pixels);
    }
}
