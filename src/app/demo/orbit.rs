//! The orbit camera, which the mouse moves in the window.

use glam::Vec3;

use leadr_scenes::view::CameraPose;

/// The largest elevation in degrees. At 90 degrees, the azimuth is undefined.
const MAX_ELEVATION: f32 = 89.0;
/// The rotation per dragged pixel in degrees.
const DEGREES_PER_PIXEL: f32 = 0.3;
/// The factor on the distance for each zoom step (one wheel notch).
const ZOOM_STEP: f32 = 0.9;
/// The smallest and the largest distance between the eye and the target, in metres.
const DISTANCES: (f32, f32) = (0.2, 2000.0);

/// The state of the orbit camera, with z up.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Orbit {
    target: Vec3,
    /// The azimuth of the eye around the target, in degrees counter-clockwise from +x.
    azimuth: f32,
    /// The elevation of the eye above the target in degrees.
    elevation: f32,
    distance: f32,
    fov_degrees: f32,
}

impl Orbit {
    /// Starts the orbit at `pose`, with z as the up direction.
    pub fn new(pose: &CameraPose) -> Self {
        let target = Vec3::from_array(pose.target);
        let offset = Vec3::from_array(pose.position) - target;
        let distance = offset.length().clamp(DISTANCES.0, DISTANCES.1);
        let elevation = offset.z.atan2(offset.truncate().length()).to_degrees();
        Self {
            target,
            azimuth: offset.y.atan2(offset.x).to_degrees(),
            elevation: elevation.clamp(-MAX_ELEVATION, MAX_ELEVATION),
            distance,
            fov_degrees: pose.fov_degrees,
        }
    }

    /// Returns the point that the camera orbits, in metres.
    pub fn target(&self) -> Vec3 {
        self.target
    }

    /// Rotates the eye around the target, as if the scene were dragged by this number of pixels to the right and down.
    pub fn rotate(&mut self, right: f32, down: f32) {
        self.azimuth = (self.azimuth - right * DEGREES_PER_PIXEL).rem_euclid(360.0);
        self.elevation = (self.elevation + down * DEGREES_PER_PIXEL).clamp(-MAX_ELEVATION, MAX_ELEVATION);
    }

    /// Moves the eye closer by `steps` wheel notches. Negative steps move the eye away.
    pub fn zoom(&mut self, steps: f32) {
        self.distance = (self.distance * ZOOM_STEP.powf(steps)).clamp(DISTANCES.0, DISTANCES.1);
    }

    /// Moves the target as if the scene were dragged by this number of pixels to the right and down. The window is `height` pixels high.
    pub fn pan(&mut self, right: f32, down: f32, height: f32) {
        let eye = self.offset() / self.distance;
        let side = Vec3::Z.cross(eye).normalize_or_zero();
        let up = eye.cross(side);
        let metres = 2.0 * self.distance * (self.fov_degrees.to_radians() / 2.0).tan() / height.max(1.0);
        self.target += (up * down - side * right) * metres;
    }

    /// Returns the distance from the eye to the target in metres.
    pub fn distance(&self) -> f32 {
        self.distance
    }

    /// Moves the eye along the line of sight to this distance from the target in metres.
    pub fn set_distance(&mut self, metres: f32) {
        self.distance = metres.clamp(DISTANCES.0, DISTANCES.1);
    }

    /// Rotates the view about the eye, as if the scene were dragged by this number of pixels to the right and down.
    pub fn look(&mut self, right: f32, down: f32) {
        let eye = self.target + self.offset();
        self.rotate(-right, -down);
        self.target = eye - self.offset();
    }

    /// Moves the eye and the target to the right, forward and up by these distances in metres.
    pub fn fly(&mut self, metres: Vec3) {
        let eye = self.offset() / self.distance;
        let right = Vec3::Z.cross(eye).normalize_or_zero();
        self.target += right * metres.x - eye * metres.y + Vec3::Z * metres.z;
    }

    fn offset(&self) -> Vec3 {
        let (azimuth, elevation) = (self.azimuth.to_radians(), self.elevation.to_radians());
        Vec3::new(azimuth.cos() * elevation.cos(), azimuth.sin() * elevation.cos(), elevation.sin()) * self.distance
    }

    /// Returns the current camera pose.
    pub fn pose(&self) -> CameraPose {
        CameraPose {
            position: (self.target + self.offset()).to_array(),
            target: self.target.to_array(),
            up: [0.0, 0.0, 1.0],
            fov_degrees: self.fov_degrees,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn start() -> (CameraPose, Orbit) {
        let pose =
            CameraPose { position: [6.0, -8.0, 5.0], target: [0.0, 0.0, 2.0], up: [0.0, 0.0, 1.0], fov_degrees: 40.0 };
        (pose, Orbit::new(&pose))
    }

    fn near(a: [f32; 3], b: [f32; 3]) -> bool {
        (Vec3::from_array(a) - Vec3::from_array(b)).length() < 1e-4
    }

    #[test]
    fn it_starts_at_the_pose_given() {
        let (pose, orbit) = start();
        assert!(near(orbit.pose().position, pose.position) && orbit.pose().target == pose.target);
    }

    #[test]
    fn rotating_keeps_the_distance_and_never_passes_the_poles() {
        let (_, mut orbit) = start();
        let before = orbit.distance;
        orbit.rotate(250.0, 1e6);
        let pose = orbit.pose();
        let offset = Vec3::from_array(pose.position) - Vec3::from_array(pose.target);
        assert!((offset.length() - before).abs() < 1e-3 && offset.truncate().length() > 0.1);
        orbit.rotate(0.0, -2e6);
        assert!(orbit.pose().position[2] < 0.0 && orbit.elevation >= -MAX_ELEVATION);
    }

    #[test]
    fn dragging_right_moves_the_scene_right() {
        // The eye is at −y. If it moves to −x, a point in front of the target moves to +x.
        let mut orbit = Orbit::new(&CameraPose {
            position: [0.0, -10.0, 0.0],
            target: [0.0; 3],
            up: [0.0, 0.0, 1.0],
            fov_degrees: 40.0,
        });
        orbit.rotate(10.0, 0.0);
        assert!(orbit.pose().position[0] < 0.0);
    }

    #[test]
    fn zoom_reverses_and_is_bounded() {
        let (_, mut orbit) = start();
        let before = orbit.distance;
        orbit.zoom(3.0);
        assert!(orbit.distance < before);
        orbit.zoom(-3.0);
        assert!((orbit.distance - before).abs() < 1e-3);
        orbit.zoom(1e9);
        assert_eq!(orbit.distance, DISTANCES.0);
        orbit.zoom(-1e9);
        assert_eq!(orbit.distance, DISTANCES.1);
    }

    #[test]
    fn pan_across_window_moves_by_its_extent() {
        let (_, mut orbit) = start();
        let (before, distance) = (orbit.target, orbit.distance);
        orbit.pan(0.0, 100.0, 100.0);
        let shown = 2.0 * distance * 20f32.to_radians().tan();
        assert!(((orbit.target - before).length() - shown).abs() < 1e-3);
        assert!(orbit.target.z > before.z, "the scene must follow the mouse down");
    }
}
