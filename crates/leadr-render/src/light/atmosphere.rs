//! The atmosphere, with its scattering and absorption, and their integrals along rays. [`super::sky`] builds the sky from these
//! integrals. `shaders-glsl/passes/light/sky.glsl` and `sky_tables.comp` compute the same integrals in 32 bits.
//!
//! Altitudes and lengths are in km. `mu` is the cosine of an angle from the zenith, and `nu` is the cosine of the angle to the sun.

use std::f64::consts::PI;

use glam::DVec3;

use super::constants::{
    AIR, AIR_HEIGHT, ATMOSPHERE, EARTH, HAZE, HAZE_ALBEDO, HAZE_ASYMMETRY, HAZE_HEIGHT, OZONE, OZONE_CENTRE,
    OZONE_HALF_WIDTH, SPHERE_STEPS, SUN_RADIUS, SUN_STEPS, VIEW_STEPS,
};

/// The vertical optical thickness of air at 550 nm, which is the unit of turbidity.
pub(super) const AIR_THICKNESS: f64 = AIR.y * AIR_HEIGHT;

/// Returns the altitude in km after `t` km along a ray from altitude `h` with zenith cosine `mu`. The formula avoids the difference
/// of two radii, which would have an error of half a metre in 32 bits.
fn altitude_along(h: f64, mu: f64, t: f64) -> f64 {
    let r = EARTH + h;
    let excess = h * (2.0 * EARTH + h) + t * t + 2.0 * r * t * mu;
    excess / ((EARTH * EARTH + excess).max(0.0).sqrt() + EARTH)
}

/// Returns the distance in km from altitude `h` to the top of the atmosphere.
pub(super) fn distance_to_top(h: f64, mu: f64) -> f64 {
    let r = EARTH + h;
    let gap = (ATMOSPHERE - h) * (2.0 * EARTH + ATMOSPHERE + h);
    let b = r * mu;
    let root = (b * b + gap.max(0.0)).sqrt();
    if b > 0.0 { gap / (root + b) } else { root - b }
}

/// Returns the distance in km from altitude `h` to the ground, or a negative number if the ray misses the ground.
fn distance_to_ground(h: f64, mu: f64) -> f64 {
    let r = EARTH + h;
    let gap = h * (2.0 * EARTH + h);
    let discriminant = r * r * mu * mu - gap;
    if mu >= 0.0 || discriminant < 0.0 { -1.0 } else { gap / (discriminant.sqrt() - r * mu) }
}

/// Returns the densities of air, aerosol and ozone at an altitude, relative to the altitudes at which the coefficients are given.
fn densities(h: f64) -> DVec3 {
    let h = h.max(0.0);
    let ozone = (1.0 - (h - OZONE_CENTRE).abs() / OZONE_HALF_WIDTH).max(0.0);
    DVec3::new((-h / AIR_HEIGHT).exp(), (-h / HAZE_HEIGHT).exp(), ozone)
}

fn extinction(density: DVec3, haze: f64) -> DVec3 {
    AIR * density.x + HAZE * (haze * density.y) + OZONE * density.z
}

fn scattering_of_haze(density: DVec3, haze: f64) -> DVec3 {
    HAZE * (HAZE_ALBEDO * haze * density.y)
}

/// Returns `(1 − exp(−x)) / x`. The result is accurate near 0.
fn share_within(x: DVec3) -> DVec3 {
    x.map(|x| if x < 1e-2 { 1.0 - x * (0.5 - x / 6.0) } else { (1.0 - (-x).exp()) / x })
}

/// Returns the transmittance of sunlight to altitude `h` at zenith cosine `mu`. The transmittance is the attenuation by the air,
/// times the visible fraction of the sun's disk at sunset.
pub(super) fn sun_transmittance(h: f64, mu: f64, haze: f64) -> DVec3 {
    let ratio = EARTH / (EARTH + h);
    let horizon = -(1.0 - ratio * ratio).max(0.0).sqrt();
    let risen = ((mu - horizon) / (2.0 * SUN_RADIUS) + 0.5).clamp(0.0, 1.0);
    if risen == 0.0 {
        return DVec3::ZERO;
    }
    // With t = length·s³, the steps are short at low altitude, where the aerosol is.
    let length = distance_to_top(h, mu);
    let mut depth = DVec3::ZERO;
    for i in 0..SUN_STEPS {
        let s = (i as f64 + 0.5) / SUN_STEPS as f64;
        let dt = 3.0 * s * s * length / SUN_STEPS as f64;
        depth += dt * densities(altitude_along(h, mu, length * s * s * s));
    }
    risen * risen * (3.0 - 2.0 * risen) * (-extinction(depth, haze)).exp()
}

/// The scattering integrals along a ray, per unit of sunlight and without phase functions.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Scattered {
    pub(super) air: DVec3,
    pub(super) haze: DVec3,
    /// Along a view ray, this is the light that is scattered more than once. For multiple scattering, this is the scattered
    /// fraction of isotropic light.
    pub(super) multiple: DVec3,
    pub(super) transmittance: DVec3,
}

/// Marches along a ray from altitude `h` over `length` km. `mu` and `mu_sun` are the zenith cosines of the ray and the sun, and
/// `nu` is the cosine of the angle between the ray and the sun.
pub(super) fn march(
    h: f64,
    mu: f64,
    mu_sun: f64,
    nu: f64,
    length: f64,
    haze: f64,
    multiple: impl Fn(f64) -> DVec3,
) -> Scattered {
    let mut sum = Scattered { transmittance: DVec3::ONE, ..Scattered::default() };
    let r = EARTH + h;
    for i in 0..VIEW_STEPS {
        // Steps end at t = length·s² with s = i/n. Each step uses the density at its midpoint.
        let (s0, s1) = (i as f64 / VIEW_STEPS as f64, (i as f64 + 1.0) / VIEW_STEPS as f64);
        let (t0, t1) = (length * s0 * s0, length * s1 * s1);
        let (t, dt) = (0.5 * (t0 + t1), t1 - t0);
        let height = altitude_along(h, mu, t).max(0.0);
        let density = densities(height);
        let sigma = extinction(density, haze);
        let step = (-sigma * dt).exp();
        // The integral is exact for a constant density. A step therefore never scatters more light than enters it.
        let weight = sum.transmittance * share_within(sigma * dt) * dt;
        let sun = sun_transmittance(height, (r * mu_sun + t * nu) / (EARTH + height), haze);
        let air = AIR * density.x;
        let aerosol = scattering_of_haze(density, haze);
        sum.air += weight * sun * air;
        sum.haze += weight * sun * aerosol;
        sum.multiple += weight * (air + aerosol) * multiple(height);
        sum.transmittance *= step;
    }
    sum
}

/// Returns the Rayleigh phase function, per steradian.
pub(super) fn phase_of_air(nu: f64) -> f64 {
    3.0 / (16.0 * PI) * (1.0 + nu * nu)
}

/// Returns the Cornette–Shanks phase function of the aerosol, per steradian.
pub(super) fn phase_of_haze(nu: f64) -> f64 {
    let g = HAZE_ASYMMETRY;
    let g2 = g * g;
    let base = (1.0 + g2 - 2.0 * g * nu).max(1e-6);
    3.0 / (8.0 * PI) * (1.0 - g2) * (1.0 + nu * nu) / ((2.0 + g2) * base * base.sqrt())
}

/// Returns the isotropic radiance of all scattering orders above the first, at an altitude. The result is the second order, divided
/// by one minus the fraction of light that each further order keeps (Hillaire 2020, eq. 5–10).
pub(super) fn multiple_at(h: f64, mu_sun: f64, haze: f64, albedo: DVec3) -> DVec3 {
    let mut second = DVec3::ZERO;
    let mut kept = DVec3::ZERO;
    let isotropic = 1.0 / (4.0 * PI);
    let level_sun = (1.0 - mu_sun * mu_sun).max(0.0).sqrt();
    for i in 0..SPHERE_STEPS {
        for j in 0..SPHERE_STEPS {
            let mu = (2.0 * i as f64 + 1.0) / SPHERE_STEPS as f64 - 1.0;
            let phi = PI * (j as f64 + 0.5) / SPHERE_STEPS as f64;
            let nu = mu * mu_sun + (1.0 - mu * mu).sqrt() * level_sun * phi.cos();
            let ground = distance_to_ground(h, mu);
            let length = if ground >= 0.0 { ground } else { distance_to_top(h, mu) };
            let ray = march(h, mu, mu_sun, nu, length, haze, |_| DVec3::ONE);
            second += isotropic * (ray.air + ray.haze);
            kept += isotropic * ray.multiple;
            if ground >= 0.0 {
                let mu_there = ((EARTH + h) * mu_sun + length * nu) / EARTH;
                let lit = sun_transmittance(0.0, mu_there, haze) * mu_there.max(0.0);
                second += ray.transmittance * lit * albedo / PI;
            }
        }
    }
    // Each direction represents a solid angle of 4π/64 sr.
    let weight = 4.0 * PI / (SPHERE_STEPS * SPHERE_STEPS) as f64;
    (second * weight * isotropic) / (DVec3::ONE - kept * weight)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn optical_depths_match_closed_forms_and_fine_integration() {
        // The vertical depth is the scale height of an exponential atmosphere. The depth of ozone is half the width of its
        // triangular profile.
        let depth = |n: usize, h: f64, mu: f64| {
            let length = distance_to_top(h, mu);
            (0..n).fold(DVec3::ZERO, |sum, i| {
                let s = (i as f64 + 0.5) / n as f64;
                sum + 3.0 * s * s * length / n as f64 * densities(altitude_along(h, mu, length * s * s * s))
            })
        };
        let up = depth(SUN_STEPS as usize, 0.0, 1.0);
        assert!((up.x / AIR_HEIGHT - 1.0).abs() < 1e-4 && (up.y / HAZE_HEIGHT - 1.0).abs() < 1e-4, "{up}");
        for (h, mu) in [(0.0, 0.0), (0.0, 0.1), (1.0, 0.02), (10.0, -0.02), (10.0, 0.5)] {
            let (coarse, fine) = (depth(SUN_STEPS as usize, h, mu), depth(50_000, h, mu));
            let air = ((coarse - fine) / fine).abs();
            assert!(air.x < 1e-4 && air.y < 1e-3 && air.z < 0.06, "h {h} mu {mu}: {air}");
        }
    }

    #[test]
    fn phase_functions_integrate_to_one() {
        let n = 20_000;
        for phase in [phase_of_air as fn(f64) -> f64, phase_of_haze] {
            let sum: f64 = (0..n).map(|i| phase((2.0 * i as f64 + 1.0) / n as f64 - 1.0)).sum();
            assert!((sum * 4.0 * PI / n as f64 - 1.0).abs() < 1e-6);
        }
    }
}
