//! The rectangle of an image that contains a set of objects.

use glam::Vec2;

use super::camera::Camera;
use super::surfaces::sphere::Sphere;

/// A rectangle of an image, in pixels.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct PixelArea {
    /// The first column.
    pub left: u32,
    /// The first row.
    pub top: u32,
    /// The column after the last column.
    pub right: u32,
    /// The row after the last row.
    pub bottom: u32,
}

impl PixelArea {
    /// Returns all pixels of an image.
    pub fn whole(size: (u32, u32)) -> Self {
        Self { left: 0, top: 0, right: size.0, bottom: size.1 }
    }

    /// Returns the pixels that can show any part of the spheres, or all pixels if a sphere reaches the camera.
    pub fn of_spheres(spheres: &[Sphere], camera: &Camera, size: (u32, u32)) -> Self {
        let [x, y, forward] = Camera { shift: Vec2::ZERO, ..*camera }.rays(size, Vec2::ZERO);
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
                // Lengths are in units of half the image, on the plane at depth 1.
                let (middle, radius_here) = (to.dot(ray) / ray.length_squared(), radius / ray.length());
                // The nearest point of the sphere is projected farthest outwards.
                let seen =
                    |edge: f32, outward: f32| edge / if edge * outward > 0.0 { depth - radius } else { depth + radius };
                low[axis] = low[axis].min(seen(middle - radius_here, -1.0));
                high[axis] = high[axis].max(seen(middle + radius_here, 1.0));
            }
        }
        let most = Vec2::new(size.0 as f32, size.1 as f32);
        // A sample lies up to half a pixel from its pixel centre.
        let pixel =
            |ndc: Vec2, margin: f32| (((ndc + camera.shift) * 0.5 + 0.5) * most + margin).clamp(Vec2::ZERO, most);
        let (first, last) = (pixel(low, -1.0).floor().as_uvec2(), pixel(high, 1.0).ceil().as_uvec2());
        let last = last.max(first);
        Self { left: first.x, top: first.y, right: last.x, bottom: last.y }
    }

    /// Returns the numbers of columns and rows.
    pub fn size(&self) -> [u32; 2] {
        [self.right - self.left, self.bottom - self.top]
    }

    /// Returns the scissor rectangle (x, y, width and height) for these pixels, in an image with `grid` × `grid` samples per pixel.
    pub fn scissor(&self, grid: u32) -> [u32; 4] {
        let [width, height] = self.size();
        [self.left, self.top, width, height].map(|v| v * grid)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    #[test]
    fn the_area_holds_every_point_of_the_spheres_and_little_more() {
        let camera = Camera::looking_at(Vec3::new(-20.0, 3.0, 2.0), Vec3::new(1.0, 2.0, 0.0), 40.0);
        let size = (200, 120);
        let shifted = Camera { shift: Vec2::new(0.6, -0.3), ..camera };
        for (camera, centre, radius) in [
            (camera, Vec3::ZERO, 1.0),
            (camera, Vec3::new(5.0, 9.0, 3.0), 2.0),
            (camera, Vec3::new(-15.0, 2.0, 1.0), 0.7),
            (shifted, Vec3::ZERO, 1.0),
            (shifted, Vec3::new(-15.0, 2.0, 1.0), 0.7),
        ] {
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
            // The tolerance covers sample offsets of half a pixel, rounding to whole pixels, and the perspective of a near sphere.
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
}
