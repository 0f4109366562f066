//! The environment that the visible facets of a class see, from twelve directions.
//!
//! Without shadows, a class reflects the irradiance about its visible normals, less the light from below, which the mesosurface blocks.
//! Other facets leave the part `Σ lit c L / Σ c L`, over directions of the sky with the mean cosine `c` of the visible facets and the
//! radiance `L`. The directions decide only this part, so that small lights between them are not lost.
//!
//! Directions of the sky need only the simple form of the correlation of viewer and light
//! ([`Shadowing::CorrelatedSimple`](crate::masking::shadowing::Shadowing::CorrelatedSimple)).

use glam::DVec3;

use crate::integrals::diffuse::NormalMoments;

/// The number of directions.
pub const SKY_DIRECTIONS: usize = 12;
/// The directions on each of two rings.
const ON_RING: usize = SKY_DIRECTIONS / 2;

/// Returns direction `i` in a frame whose z axis is the normal of the mesosurface. Each direction stands for a twelfth of the hemisphere. The
/// directions lie on two rings, at the heights of Gauss's rule.
pub fn sky_direction(i: usize) -> DVec3 {
    let upper = if i < ON_RING { 0.0 } else { 1.0 };
    let z = 0.5 + (upper - 0.5) / 3.0f64.sqrt();
    let (y, x) = (std::f64::consts::TAU * ((i % ON_RING) as f64 + 0.25 + 0.5 * upper) / ON_RING as f64).sin_cos();
    (1.0 - z * z).sqrt() * DVec3::new(x, y, 0.0) + z * DVec3::Z
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
/// the rest, they see other facets. `lit` is the fraction of the facets that sees each direction.
pub fn sky_seen(visible: &NormalMoments, up: DVec3, directions: &[DVec3], lit: &[f64]) -> f64 {
    let (mut seen, mut all) = (0.0, 0.0);
    for (wi, lit) in directions.iter().zip(lit) {
        let cosine = mean_cosine(visible, *wi);
        (seen, all) = (seen + lit * cosine, all + cosine);
    }
    (0.5 + 0.5 * visible.mean.dot(up)) * seen / all.max(1e-9)
}

#[cfg(test)]
mod tests {
    use glam::{DVec2, DVec3};

    use super::*;
    use crate::visible::diffuse::{clamped_mean, visible_diffuse_moments};

    #[test]
    fn near_clamped_mean_is_near() {
        let worst =
            (-400..=400).map(|i| 0.01 * f64::from(i)).map(|x| (near_clamped_mean(x, 1.0) - clamped_mean(x, 1.0)).abs());
        let worst = worst.fold(0.0, f64::max);
        assert!(worst < 0.006, "{worst}");
    }

    #[test]
    fn facets_see_what_is_lit() {
        let directions: Vec<DVec3> = (0..SKY_DIRECTIONS).map(sky_direction).collect();
        // The rule integrates the cosine over the hemisphere.
        assert!((directions.iter().map(|w| w.z).sum::<f64>() / 6.0 - 1.0).abs() < 1e-12);
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
