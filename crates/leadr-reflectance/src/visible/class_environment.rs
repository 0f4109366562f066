//! The environment that the visible facets of a class see, from a few directions.
//!
//! Without shadows, a class reflects the irradiance about its visible normals. Other facets, and the mesosurface, which blocks the light
//! from below, leave the part `Σ lit c L / (Σ c L + G)`, over directions of the sky with the mean cosine `c` of the visible facets and the
//! radiance `L`. The directions decide only this part, so that small lights between them are not lost.
//!
//! `G` is the light from below in the same sums. Facets face what is just below the mesosurface most, so six directions are near it. For
//! the rest, the mean radiance is enough.

use std::f64::consts::TAU;

use glam::DVec3;

use crate::frame::{Frame, frame_about};
use crate::integrals::diffuse::NormalMoments;

/// The number of directions of the sky.
pub const SKY_DIRECTIONS: usize = 15;
/// The number of directions from below.
pub const GROUND_DIRECTIONS: usize = 6;
/// A ring of directions of the sky.
struct Ring {
    count: usize,
    /// The first azimuth as a part of the step.
    offset: f64,
    height: f64,
    /// The weight of the ring. The weights sum to one.
    weight: f64,
}

/// The rings of the sky, at the heights of Gauss's rule with three points.
const RINGS: [Ring; 3] = [
    Ring { count: 6, offset: 0.0, height: 0.112_701_665_379_258_3, weight: 5.0 / 18.0 },
    Ring { count: 6, offset: 0.5, height: 0.5, weight: 8.0 / 18.0 },
    Ring { count: 3, offset: 0.0, height: 0.887_298_334_620_741_7, weight: 5.0 / 18.0 },
];
/// The rings of directions from below. The rest of the weight has the mean radiance from below.
const GROUND_RINGS: [Ring; 2] = [
    Ring { count: 3, offset: 0.5, height: -0.1, weight: 0.25 },
    Ring { count: 3, offset: 0.5, height: -0.4, weight: 0.4 },
];

/// Returns the frame of the directions. `up` is the normal of the mesosurface.
pub fn sky_frame(up: DVec3, wo: DVec3) -> Frame {
    let x = wo - wo.dot(up) * up;
    if x.length_squared() < 1e-8 {
        return frame_about(up);
    }
    let x = x.normalize();
    Frame { x, y: up.cross(x), z: up }
}

/// Returns direction `i` of the sky in the [`sky_frame`]. The directions lie on three rings, at the heights of Gauss's rule. The first
/// direction has the azimuth of the viewer.
///
/// # Panics
/// Panics unless `i` is less than [`SKY_DIRECTIONS`].
pub fn sky_direction(i: usize) -> DVec3 {
    direction(&RINGS, i)
}

/// Returns the weight of direction `i` of the sky. The mean weight is 1.
///
/// # Panics
/// Panics unless `i` is less than [`SKY_DIRECTIONS`].
pub fn sky_weight(i: usize) -> f64 {
    weight(&RINGS, i)
}

fn direction(rings: &[Ring], i: usize) -> DVec3 {
    let (ring, i) = ring_of(rings, i);
    let (y, x) = (TAU * (i as f64 + ring.offset) / ring.count as f64).sin_cos();
    (1.0 - ring.height * ring.height).sqrt() * DVec3::new(x, y, 0.0) + ring.height * DVec3::Z
}

fn weight(rings: &[Ring], i: usize) -> f64 {
    let (ring, _) = ring_of(rings, i);
    SKY_DIRECTIONS as f64 * ring.weight / ring.count as f64
}

/// Returns the ring of a direction, and the number of the direction in it.
fn ring_of(rings: &[Ring], i: usize) -> (&Ring, usize) {
    let mut first = 0;
    for ring in rings {
        if i < first + ring.count {
            return (ring, i - first);
        }
        first += ring.count;
    }
    panic!("there are {first} directions")
}

/// Returns direction `i` from below the mesosurface in the [`sky_frame`], on two rings.
///
/// # Panics
/// Panics unless `i` is less than [`GROUND_DIRECTIONS`].
pub fn ground_direction(i: usize) -> DVec3 {
    direction(&GROUND_RINGS, i)
}

/// Returns the weight of direction `i` from below, for the weights of [`sky_weight`].
///
/// # Panics
/// Panics unless `i` is less than [`GROUND_DIRECTIONS`].
pub fn ground_weight(i: usize) -> f64 {
    weight(&GROUND_RINGS, i)
}

/// Returns `E[max(0, x)]` of a normal variable with this mean and variance, without an exponential. The error is less than 0.006 standard
/// deviations.
fn near_clamped_mean(mean: f64, variance: f64) -> f64 {
    let deviation = variance.max(1e-12).sqrt();
    mean.max(0.0) + 0.39894228 * deviation * (1.0 - mean.abs() / (3.1 * deviation)).max(0.0).powi(4)
}

/// Returns the mean of the clamped cosine towards `wi` over facets with these moments of the normals.
pub fn mean_cosine(normals: &NormalMoments, wi: DVec3) -> f64 {
    let mean = wi.dot(normals.mean);
    let mixed = DVec3::new(wi.y * wi.z, wi.x * wi.z, wi.x * wi.y);
    let square = (wi * wi).dot(normals.diag) + 2.0 * mixed.dot(normals.off);
    near_clamped_mean(mean, (square - mean * mean).max(0.0))
}

/// Returns the fraction of the hemisphere, weighted by the cosine, in which facets see the sky above the mesosurface of unit normal `up`. In
/// the rest, they see other facets. `lit` is the fraction of the facets that sees each direction of the sky.
pub fn sky_seen(visible: &NormalMoments, up: DVec3, directions: &[DVec3], lit: &[f64]) -> f64 {
    let (mut seen, mut all) = (0.0, 0.0);
    for (i, (wi, lit)) in directions.iter().zip(lit).enumerate() {
        let cosine = sky_weight(i) * mean_cosine(visible, *wi);
        (seen, all) = (seen + lit * cosine, all + cosine);
    }
    (0.5 + 0.5 * visible.mean.dot(up)) * seen / all.max(1e-9)
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::frame::from_frame;
    use crate::visible::diffuse::{clamped_mean, visible_diffuse_moments};

    #[test]
    fn near_clamped_mean_is_near() {
        let worst =
            (-400..=400).map(|i| 0.01 * f64::from(i)).map(|x| (near_clamped_mean(x, 1.0) - clamped_mean(x, 1.0)).abs());
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < 0.006, "{worst}");
    }

    #[test]
    fn directions_follow_the_viewer() {
        let (up, wo) = (DVec3::new(0.36, 0.48, 0.8), DVec3::new(0.0, 0.96, 0.28));
        let frame = sky_frame(up, wo);
        assert!((from_frame(&frame, sky_direction(0)).dot(up.cross(wo))).abs() < 1e-12);
        assert!((from_frame(&frame, sky_direction(0)).dot(up) - 0.1127).abs() < 1e-4);
        assert!((0..GROUND_DIRECTIONS).all(|i| from_frame(&frame, ground_direction(i)).dot(up) < -0.09));
        assert!((from_frame(&sky_frame(up, up), DVec3::Z) - up).length() < 1e-12);
    }

    #[test]
    fn facets_see_what_is_lit() {
        let directions: Vec<DVec3> = (0..SKY_DIRECTIONS).map(sky_direction).collect();
        // The rule integrates the cosine over the hemisphere.
        let sum: f64 = (0..SKY_DIRECTIONS).map(|i| sky_weight(i) * directions[i].z).sum();
        assert!((2.0 * sum / SKY_DIRECTIONS as f64 - 1.0).abs() < 1e-12);
        let slope = DVec2::new(-1.0, 0.0);
        let moments = |m, s| visible_diffuse_moments(DVec3::new(0.0, 0.6, 0.8), m, s, 3);
        let (flat, wall) = (moments(DVec2::ZERO, DVec3::ZERO), moments(slope, DVec3::ZERO));
        let seen = |normals, lit: fn(&DVec3) -> bool| {
            let lit: Vec<f64> = directions.iter().map(|w| if lit(w) { 1.0 } else { 0.0 }).collect();
            sky_seen(normals, DVec3::Z, &directions, &lit)
        };
        assert!((seen(&flat, |_| true) - 1.0).abs() < 1e-6);
        assert!((seen(&wall, |_| true) - (0.5 + 0.125f64.sqrt())).abs() < 1e-3);
        // What lies in front of a wall hides more of its sky than what lies behind it.
        let (no_front, no_back) = (seen(&wall, |w| w.x < 0.0 || w.z > 0.5), seen(&wall, |w| w.x > 0.0 || w.z > 0.5));
        assert!(no_front < no_back - 0.1 && seen(&flat, |w| w.z > 0.5) < 0.9, "{no_front} {no_back}");
    }
}
