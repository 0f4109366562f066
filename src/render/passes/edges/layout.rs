//! Layout of edge samples: their grid, the pixels that need them, and how finely objects are divided for them.

use glam::Vec2;

use crate::render::camera::Camera;
use crate::render::surfaces::sphere::Sphere;
use crate::render::surfaces::tessellation::{Lens, TessellationSettings};

/// Largest number of edge samples along a side of a pixel in one image.
pub const MAX_GRID: u32 = 16;
/// Largest number of vertices along a side of a pixel when edge samples are drawn, up to one per texel. With more,
/// silhouettes come closer to those of the relief but the shading moves away from it, since the visible part of a single
/// bump has other statistics than the whole bump (docs/measurements/samples.md).
const VERTICES_PER_PIXEL: f32 = 6.0;
/// Largest number of vertices across an object that is divided more finely. Larger objects are not: their silhouette is a
/// smaller part of them, and the geometry of whole pixels already shows its bumps.
const VERTICES_ACROSS: f32 = 360.0;
/// Largest number of edge samples in one image; each takes 84 bytes.
const MAX_DRAWN: u64 = 1 << 22;

/// The largest grid, up to `finest`, with which whole images make up `samples` edge samples in each pixel of a picture of
/// `size`: 1, 2, 4, 8 or 16 samples along a side of a pixel.
#[must_use]
pub fn edge_grid(samples: u32, size: (u32, u32), finest: u32) -> u32 {
    let pixels = u64::from(size.0) * u64::from(size.1);
    let fits = |&grid: &u32| samples.is_multiple_of(grid * grid) && u64::from(grid * grid) * pixels <= MAX_DRAWN;
    [16, 8, 4, 2].into_iter().filter(|&grid| grid <= finest).find(fits).unwrap_or(1)
}

/// A rectangle of a picture, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelArea {
    /// First column.
    pub left: u32,
    /// First row.
    pub top: u32,
    /// One past the last column.
    pub right: u32,
    /// One past the last row.
    pub bottom: u32,
}

impl PixelArea {
    /// All pixels of a picture.
    #[must_use]
    pub fn whole(size: (u32, u32)) -> Self {
        Self { left: 0, top: 0, right: size.0, bottom: size.1 }
    }

    /// The pixels that can see any part of some spheres; all pixels where a sphere reaches the camera.
    #[must_use]
    pub fn of_spheres(spheres: &[Sphere], camera: &Camera, size: (u32, u32)) -> Self {
        let [x, y, forward] = camera.rays(size, Vec2::ZERO);
        let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
        for &Sphere { centre, radius } in spheres {
            let to = centre - camera.position;
            let depth = to.dot(forward);
            if depth + radius <= camera.near {
                continue;
            }
            if depth - radius <= camera.near {
                return Self::whole(size);
            }
            for (axis, ray) in [x, y].into_iter().enumerate() {
                // In units of half the picture, at depth 1.
                let (place, radius_here) = (to.dot(ray) / ray.length_squared(), radius / ray.length());
                // The nearer the sphere, the farther out its image reaches.
                let seen =
                    |edge: f32, outward: f32| edge / if edge * outward > 0.0 { depth - radius } else { depth + radius };
                low[axis] = low[axis].min(seen(place - radius_here, -1.0));
                high[axis] = high[axis].max(seen(place + radius_here, 1.0));
            }
        }
        let most = Vec2::new(size.0 as f32, size.1 as f32);
        // A sample lies up to half a pixel from the middle of its pixel.
        let pixel = |ndc: Vec2, margin: f32| ((ndc * 0.5 + 0.5) * most + margin).clamp(Vec2::ZERO, most);
        let (first, last) = (pixel(low, -1.0).floor().as_uvec2(), pixel(high, 1.0).ceil().as_uvec2());
        let last = last.max(first);
        Self { left: first.x, top: first.y, right: last.x, bottom: last.y }
    }

    /// Number of columns and rows.
    #[must_use]
    pub fn size(&self) -> [u32; 2] {
        [self.right - self.left, self.bottom - self.top]
    }

    /// The scissor of these pixels, x, y, width, height, in an image with a grid of samples in each pixel.
    #[must_use]
    pub fn scissor(&self, grid: u32) -> [u32; 4] {
        let [width, height] = self.size();
        [self.left, self.top, width, height].map(|v| v * grid)
    }
}

/// How finely an object with this bounding sphere is divided when edge samples are drawn: large objects as `usual`, small
/// ones more finely.
#[must_use]
pub fn edge_tessellation(usual: TessellationSettings, bounds: Sphere, lens: &Lens) -> TessellationSettings {
    let Sphere { centre, radius } = bounds;
    let pixels = lens.pixels(centre, 2.0 * radius).max(1e-3);
    let vertices_per_pixel = (VERTICES_ACROSS / pixels).min(VERTICES_PER_PIXEL);
    TessellationSettings { to_texels: true, vertices_per_pixel, ..usual }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn the_area_holds_every_point_of_the_spheres_and_little_more() {
        let camera = Camera::looking_at(Vec3::new(-20.0, 3.0, 2.0), Vec3::new(1.0, 2.0, 0.0), 40.0);
        let size = (200, 120);
        for (centre, radius) in [(Vec3::ZERO, 1.0), (Vec3::new(5.0, 9.0, 3.0), 2.0), (Vec3::new(-15.0, 2.0, 1.0), 0.7)]
        {
            let area = PixelArea::of_spheres(&[Sphere { centre, radius }], &camera, size);
            let [left, top, right, bottom] = [area.left, area.top, area.right, area.bottom].map(|v| v as f32);
            let clip = camera.clip_from_world(size, Vec2::ZERO);
            let (mut low, mut high) = (Vec2::INFINITY, Vec2::NEG_INFINITY);
            for k in 0..2000 {
                let z = 1.0 - (2 * k + 1) as f32 / 2000.0;
                let (sine, cosine) = (k as f32 * 2.399_963).sin_cos();
                let point = centre + radius * Vec3::new(cosine * (1.0 - z * z).sqrt(), sine * (1.0 - z * z).sqrt(), z);
                let ndc = clip.project_point3(point).truncate();
                let pixel = ((ndc * 0.5 + 0.5) * Vec2::new(200.0, 120.0)).clamp(Vec2::ZERO, Vec2::new(200.0, 120.0));
                (low, high) = (low.min(pixel), high.max(pixel));
            }
            // Samples lie up to half a pixel away and bounds are whole pixels; perspective enlarges a near sphere.
            assert!(left <= low.x && top <= low.y && right >= high.x && bottom >= high.y, "{low} {high}");
            let room = Vec2::new(low.x - left, low.y - top).max(Vec2::new(right - high.x, bottom - high.y));
            assert!(
                room.max_element() < 2.5 + 0.2 * (high - low).max_element(),
                "{low} {high} in {left} {top} {right} {bottom}"
            );
        }
        let around = Sphere { centre: camera.position, radius: 1.0 };
        assert_eq!(PixelArea::of_spheres(&[around], &camera, size), PixelArea::whole(size), "around the camera");
        for hidden in [Vec3::new(0.0, 300.0, 0.0), Vec3::new(0.0, -300.0, 0.0), Vec3::new(-30.0, 3.0, 2.0)] {
            let [columns, rows] =
                PixelArea::of_spheres(&[Sphere { centre: hidden, radius: 1.0 }], &camera, size).size();
            assert_eq!(columns * rows, 0, "{hidden} is out of sight");
        }
        let [columns, rows] = PixelArea::of_spheres(&[], &camera, size).size();
        assert_eq!(columns * rows, 0, "nothing");
    }

    #[test]
    fn large_objects_are_divided_as_always() {
        let lens = Lens { eye: Vec3::ZERO, focal_pixels: 1000.0, near: 0.1 };
        let usual = TessellationSettings::default();
        let per_pixel = |distance: f32| {
            let sphere = Sphere { centre: Vec3::X * (distance + 1.0), radius: 1.0 };
            edge_tessellation(usual, sphere, &lens).vertices_per_pixel
        };
        // 2 metres are 20 pixels at 100 m, 200 at 10 m.
        assert_eq!(per_pixel(100.0), VERTICES_PER_PIXEL);
        assert!((per_pixel(10.0) - VERTICES_ACROSS / 200.0).abs() < 0.02, "{}", per_pixel(10.0));
        // By default triangles have a vertex every 2.8 pixels, and settings that ask for less are not refined.
        assert!(per_pixel(1.0) < (2.0 * usual.pixels_per_triangle).sqrt().recip());
        assert!(per_pixel(-0.5) < 0.1, "around the camera");
        let far = edge_tessellation(usual, Sphere { centre: Vec3::X * 50.0, radius: 1.0 }, &lens);
        assert!(far.to_texels && far.pixels_per_triangle == usual.pixels_per_triangle);
    }

    #[test]
    fn grids_divide_the_samples_and_fit_into_memory() {
        for (samples, size, finest, grid) in [
            (256, (128, 128), MAX_GRID, 16),
            (64, (128, 128), MAX_GRID, 8),
            (64, (128, 128), 4, 4),
            (64, (128, 128), 1, 1),
            (8, (128, 128), 4, 2),
            (6, (128, 128), 4, 1),
            (64, (1280, 720), 4, 2),
            (64, (4096, 2160), 4, 1),
        ] {
            assert_eq!(edge_grid(samples, size, finest), grid, "{samples} of {size:?}");
        }
    }
}
