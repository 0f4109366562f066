//! The layout of edge samples: their grid in each pixel, and the tessellation of objects.

use crate::surfaces::sphere::Sphere;
use crate::surfaces::tessellation::{Lens, TessellationSettings};

/// The maximum number of edge samples along one side of a pixel, in one image.
pub const MAX_GRID: u32 = 16;
/// The maximum number of vertices along one side of a pixel for edge samples, with at most one per texel. More vertices improve
/// silhouettes but worsen the shading, because the slope statistics of a whole bump differ from those of its visible part
/// (docs/measurements/samples.md).
const VERTICES_PER_PIXEL: f32 = 6.0;
/// The maximum number of vertices across an object that is refined. On larger objects, the silhouette matters less, and the
/// tessellation for whole pixels already resolves the bumps.
const VERTICES_ACROSS: f32 = 360.0;
/// The maximum number of edge samples in one image. Each sample takes 84 bytes.
const MAX_DRAWN: u64 = 1 << 22;

/// Returns the number of edge samples along one side of a pixel in one image: 1, 2, 4, 8 or 16. The result is the largest number up
/// to `finest` that divides `samples` edge samples per pixel into whole images that fit a picture of `size`.
pub fn edge_grid(samples: u32, size: (u32, u32), finest: u32) -> u32 {
    let pixels = u64::from(size.0) * u64::from(size.1);
    let fits = |&grid: &u32| samples.is_multiple_of(grid * grid) && u64::from(grid * grid) * pixels <= MAX_DRAWN;
    [16, 8, 4, 2].into_iter().filter(|&grid| grid <= finest).find(fits).unwrap_or(1)
}

/// Returns the tessellation of an object with this bounding sphere for edge samples. Large objects keep the `usual` tessellation,
/// and small objects are tessellated more finely.
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
    fn large_objects_are_divided_as_always() {
        let lens = Lens { eye: Vec3::ZERO, focal_pixels: 1000.0, near: 0.1 };
        let usual = TessellationSettings::default();
        let per_pixel = |distance: f32| {
            let sphere = Sphere { centre: Vec3::X * (distance + 1.0), radius: 1.0 };
            edge_tessellation(usual, sphere, &lens).vertices_per_pixel
        };
        // An object of 2 m spans 20 pixels at 100 m and 200 pixels at 10 m.
        assert_eq!(per_pixel(100.0), VERTICES_PER_PIXEL);
        assert!((per_pixel(10.0) - VERTICES_ACROSS / 200.0).abs() < 0.02, "{}", per_pixel(10.0));
        // The default is a vertex every 2.8 pixels. Coarser settings are not refined.
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
