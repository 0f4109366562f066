//! One image of a scene, and how its samples relate to the pixels of the picture.

use glam::{Mat4, Vec2, Vec3};

use super::camera::Camera;
use super::surfaces::tessellation::Lens;

/// How the samples of an image relate to the pixels of the picture.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Samples {
    /// One sample per pixel, which decides how the pixel's surface is shaded.
    Pixels,
    /// The same, and the geometry is multisampled: each surface that one of so many samples sees is shaded once.
    Multisampled {
        /// Samples of the geometry in each pixel, a power of two.
        count: u32,
    },
    /// A grid of edge samples in every pixel, with this many along a side.
    Edges {
        /// Edge samples along a side of a pixel.
        grid: u32,
    },
}

/// One image of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct View {
    /// The viewer.
    pub camera: Camera,
    /// Pixels of the picture, across and down.
    pub picture: (u32, u32),
    /// How the samples relate to these pixels.
    pub samples: Samples,
    /// Position of each sample relative to the middle of its cell of the grid, in cells, `[-½, ½)²`.
    pub offset: Vec2,
}

impl View {
    /// Number of samples along a side of a pixel.
    pub fn grid(&self) -> u32 {
        match self.samples {
            Samples::Pixels | Samples::Multisampled { .. } => 1,
            Samples::Edges { grid } => grid,
        }
    }

    /// Number of samples across and down the image.
    pub fn size(&self) -> (u32, u32) {
        let (width, height) = self.picture;
        (self.grid() * width, self.grid() * height)
    }

    /// See [`Camera::clip_from_world`].
    pub fn clip_from_world(&self) -> Mat4 {
        self.camera.clip_from_world(self.size(), self.offset)
    }

    /// Rays through the image, see [`Camera::rays`].
    pub fn rays(&self) -> [Vec3; 3] {
        self.camera.rays(self.size(), self.offset)
    }

    /// How lengths convert to pixels of the picture, however many samples each pixel has.
    pub fn lens(&self) -> Lens {
        self.camera.lens(self.picture.1)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_grid_refines_the_image_and_keeps_the_lens() {
        let camera = Camera::looking_at(Vec3::new(-5.0, 1.0, 2.0), Vec3::ZERO, 60.0);
        let pixels = View { camera, picture: (20, 10), samples: Samples::Pixels, offset: Vec2::ZERO };
        let edges = View { samples: Samples::Edges { grid: 4 }, ..pixels };
        assert_eq!((pixels.size(), edges.size()), ((20, 10), (80, 40)));
        assert_eq!(pixels.lens().focal_pixels, edges.lens().focal_pixels);
    }
}
