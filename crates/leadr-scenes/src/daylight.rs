//! The sun's orbit on a day in late spring at 40° north. World +y is north and +x is east.

use glam::{Quat, Vec3};

use leadr_render::scene::FrameState;

/// The latitude and the declination of the sun, in radians. The sun rises at about half past five, and is 60° high at noon.
const LATITUDE: f32 = 0.698;
const DECLINATION: f32 = 0.175;

/// Returns the unit vector toward the sun at a solar time in hours (12 is noon).
pub fn at_hour(hour: f64) -> Vec3 {
    let (sd, cd) = DECLINATION.sin_cos();
    let (sl, cl) = LATITUDE.sin_cos();
    let noon = Vec3::new(0.0, sd * cl - cd * sl, sd * sl + cd * cl);
    after(noon, hour - 12.0)
}

/// Returns the direction of the sun `hours` after it was in `direction`. The function rotates `direction` about the celestial pole.
pub fn after(direction: Vec3, hours: f64) -> Vec3 {
    let (sl, cl) = LATITUDE.sin_cos();
    let angle = -std::f64::consts::TAU * (hours / 24.0).rem_euclid(1.0);
    Quat::from_axis_angle(Vec3::new(0.0, cl, sl), angle as f32) * direction
}

/// Advances the sky of a frame by `hours`. A frame that is lit by an image does not change.
pub fn pass(state: &mut FrameState, hours: f64) {
    if let Some(sky) = state.sky.as_mut().filter(|_| hours != 0.0) {
        sky.sun_direction = after(sky.sun_direction, hours);
        // The sun of a model does not move with the sky.
        state.sun = None;
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_sun_rises_in_the_east_and_is_highest_in_the_south() {
        let (morning, noon, evening) = (at_hour(6.0), at_hour(12.0), at_hour(18.0));
        assert!(morning.x > 0.9 && evening.x < -0.9 && noon.x.abs() < 1e-6 && noon.y < 0.0);
        assert!((noon.z.asin().to_degrees() - 60.0).abs() < 0.2, "{noon}");
        assert!((0..240).all(|i| at_hour(f64::from(i) / 10.0).z <= noon.z + 1e-6));
        assert!(at_hour(5.3).z < 0.0 && at_hour(5.6).z > 0.0 && at_hour(0.0).z < -0.6);
        assert!(at_hour(31.25).distance(at_hour(7.25)) < 1e-6);
    }

    #[test]
    fn hours_add_up() {
        let direction = at_hour(9.0);
        assert!(after(direction, 4.5).distance(at_hour(13.5)) < 1e-6);
        assert!((after(Vec3::new(0.6, 0.0, 0.8), 3.0).length() - 1.0).abs() < 1e-6);
        assert_eq!(after(direction, 0.0), direction);
    }
}
