//! A pinhole camera with reversed, infinite depth.

use super::surfaces::tessellation::Lens;
use glam::{Mat4, Quat, Vec2, Vec3};

/// A pinhole camera in a z-up world with lengths in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Camera {
    /// The position of the camera.
    pub position: Vec3,
    /// The point at the centre of the image, moved by `shift`.
    pub target: Vec3,
    /// The up direction, which need not be perpendicular to the line of sight.
    pub up: Vec3,
    /// The vertical field of view in radians, between 0 and π.
    pub fov_y: f32,
    /// The distance of the near plane, which must be above 0.
    pub near: f32,
    /// Offset of the image from the centre, in halves of its width and height, positive to the right and down. Zero puts the target
    /// at the centre.
    pub shift: Vec2,
}

impl Camera {
    /// Returns a camera at `position` that looks at `target`, with z up and a vertical field of view in degrees.
    pub fn looking_at(position: Vec3, target: Vec3, fov_degrees: f32) -> Self {
        let near = (position.distance(target) * 0.02).clamp(1e-3, 0.1);
        Self { position, target, up: Vec3::Z, fov_y: fov_degrees.to_radians(), near, shift: Vec2::ZERO }
    }

    /// Moves the camera along its line of sight, so that the target is at another distance.
    pub fn at_distance(&self, distance: f32) -> Self {
        let direction = (self.position - self.target).normalize_or(Vec3::X);
        let near = (distance * 0.02).clamp(1e-3, 0.1);
        Self { position: self.target + direction * distance, near, ..*self }
    }

    /// Orbits the camera about the vertical axis through its target. The angle is in degrees, counter-clockwise seen from above.
    pub fn rotated(&self, degrees: f32) -> Self {
        let rotation = Quat::from_rotation_z(degrees.to_radians());
        Self { position: self.target + rotation * (self.position - self.target), up: rotation * self.up, ..*self }
    }

    /// Returns the matrix from world to Vulkan clip space for an image of `size` pixels. In clip space, y points down, and depth is
    /// 1 at the near plane and 0 at infinity. `jitter` is the offset of the sample in pixels, in `[-½, ½]²`, positive to the right
    /// and down.
    pub fn clip_from_world(&self, size: (u32, u32), jitter: Vec2) -> Mat4 {
        let aspect = size.0 as f32 / size.1 as f32;
        let (forward, up) = self.axes();
        let projection = glam::camera::rh::proj::vulkan::perspective_infinite_reverse(self.fov_y, aspect, self.near);
        let view = glam::camera::rh::view::look_to_mat4(self.position, forward, up);
        let shift = self.shift - 2.0 * jitter / Vec2::new(size.0 as f32, size.1 as f32);
        Mat4::from_translation(shift.extend(0.0)) * projection * view
    }

    /// Returns the rays through the image as three vectors `[x, y, z]`. A point at `ndc` has the world direction `z + ndc.x · x +
    /// ndc.y · y`, whose component along the line of sight is 1. A point of depth `d` lies at `near / d` times this direction from
    /// the camera. The arguments are those of [`clip_from_world`](Self::clip_from_world).
    pub fn rays(&self, size: (u32, u32), jitter: Vec2) -> [Vec3; 3] {
        let (forward, up) = self.axes();
        let right = forward.cross(up).normalize();
        let down = forward.cross(right);
        let tangent = (self.fov_y * 0.5).tan();
        let x = right * (tangent * size.0 as f32 / size.1 as f32);
        let y = down * tangent;
        // The jitter and the shift move the image; the ray through a pixel moves in the opposite direction.
        let moved = 2.0 * jitter / Vec2::new(size.0 as f32, size.1 as f32) - self.shift;
        [x, y, forward + x * moved.x + y * moved.y]
    }

    /// Returns the line of sight, and an up direction that is not parallel to it.
    fn axes(&self) -> (Vec3, Vec3) {
        let forward = (self.target - self.position).normalize_or(Vec3::X);
        let level = forward.cross(self.up).length_squared() < 1e-8;
        (forward, if level { forward.any_orthogonal_vector() } else { self.up })
    }

    /// Returns the factor from lengths at unit distance to pixels, in an image that is `height` pixels high.
    pub fn lens(&self, height: u32) -> Lens {
        let focal_pixels = height as f32 / (2.0 * (self.fov_y * 0.5).tan());
        Lens { eye: self.position, focal_pixels, near: self.near }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn orbiting_keeps_distance_height_and_horizon() {
        let tilted = Vec3::new(0.3, 0.0, 1.0);
        let camera =
            Camera { up: tilted, ..Camera::looking_at(Vec3::new(4.0, 2.0, 3.0), Vec3::new(1.0, 2.0, 0.5), 30.0) };
        assert_eq!(camera.rotated(0.0), camera);
        let quarter = camera.rotated(90.0);
        assert!((quarter.position - Vec3::new(1.0, 5.0, 3.0)).length() < 1e-5, "{quarter:?}");
        assert!((quarter.up - Vec3::new(0.0, 0.3, 1.0)).length() < 1e-6, "{quarter:?}");
        assert_eq!((quarter.target, quarter.fov_y, quarter.near), (camera.target, camera.fov_y, camera.near));
    }

    #[test]
    fn clip_space_is_reversed_and_y_points_down() {
        let camera = Camera::looking_at(Vec3::new(-5.0, 0.0, 0.0), Vec3::ZERO, 60.0);
        let clip = camera.clip_from_world((200, 100), Vec2::ZERO);
        let ndc = |p: Vec3| clip.project_point3(p);
        assert!(ndc(Vec3::ZERO).truncate().length() < 1e-6);
        assert!(ndc(Vec3::Z).y < 0.0, "up is toward the top");
        assert!(ndc(-Vec3::Y).x > 0.0, "looking along +x, -y is to the right");
        assert!(ndc(Vec3::new(-4.0, 0.0, 0.0)).z > ndc(Vec3::ZERO).z, "nearer is larger");
    }

    #[test]
    fn rays_lead_back_to_the_points_they_came_from() {
        let camera =
            Camera { up: Vec3::new(0.1, 0.2, 1.0), ..Camera::looking_at(Vec3::new(-5.0, 1.0, 2.0), Vec3::ZERO, 60.0) };
        let camera = Camera { shift: Vec2::new(0.4, -0.1), ..camera };
        let (size, jitter) = ((200, 100), Vec2::new(0.3, -0.4));
        let [x, y, z] = camera.rays(size, jitter);
        for p in [Vec3::new(0.3, 0.2, 0.1), Vec3::new(2.0, -1.0, 0.5), Vec3::new(-3.0, 1.0, 1.0)] {
            let ndc = camera.clip_from_world(size, jitter).project_point3(p);
            let back = camera.position + (z + x * ndc.x + y * ndc.y) * (camera.near / ndc.z);
            assert!(back.distance(p) < 1e-4, "{p} came back as {back}");
        }
    }

    #[test]
    fn shift_moves_the_image_by_halves_of_its_size() {
        let camera = Camera::looking_at(Vec3::new(-5.0, 1.0, 2.0), Vec3::ZERO, 60.0);
        let shifted = Camera { shift: Vec2::new(0.5, -0.25), ..camera };
        for p in [Vec3::ZERO, Vec3::new(0.3, 0.2, 0.1)] {
            let at = |camera: &Camera| camera.clip_from_world((200, 100), Vec2::ZERO).project_point3(p);
            let moved = at(&shifted) - at(&camera);
            assert!(moved.distance(Vec3::new(0.5, -0.25, 0.0)) < 1e-6, "{moved}");
        }
    }

    #[test]
    fn jitter_moves_the_image_by_pixels() {
        let camera = Camera::looking_at(Vec3::new(-5.0, 1.0, 2.0), Vec3::ZERO, 60.0);
        let size = (200, 100);
        let at = |jitter| camera.clip_from_world(size, jitter).project_point3(Vec3::new(0.3, 0.2, 0.1));
        let moved = at(Vec2::ZERO) - at(Vec2::new(0.5, 0.25));
        assert!((moved.x * 100.0 - 0.5).abs() < 1e-4 && (moved.y * 50.0 - 0.25).abs() < 1e-4, "{moved}");
    }
}
