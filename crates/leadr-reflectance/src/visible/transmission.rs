//! Light that passes through a surface: refraction by the visible facets (Walter et al. 2007), as in `KHR_materials_transmission` and
//! `KHR_materials_volume`.
//!
//! A facet of normal `n` bends a ray from the direction `w` by Snell's law. With the cosine `c` to the facet, the refractive index `η`, and
//! the cosine `q = √(1 − (1 − c²)/η²)` inside, the ray continues along
//!
//! ```text
//! t = (c/η − q) n − w/η        (Walter eq. 40),   and n ∝ −(w + η t)   (Walter eq. 16)
//! ```
//!
//! A solid body bends the ray again where the ray leaves. Its far side is taken to be that of a sphere, which the ray leaves at the normal
//! `n' = n + 2q t`: the refraction of a smooth sphere is exact. Tilting a facet by `δ` turns `η t` by `(ηq − c) δ`, and the ray outside by
//! `(ηq − c) δ` across the plane of incidence and by `(ηq − c)/c δ` within this plane. Facets of variance `σ²` at one interface therefore
//! spread the light by `(ηq − c)²/c · σ²` per axis, in the geometric mean of both axes. The two sides of the body are independent, so their
//! variances add.
//!
//! A thin wall has two parallel sides, so it does not bend light, and its relief does not spread it. The light that passes has the width of
//! the reflected light of the base, `2 α² c` per axis, as in glTF.

use glam::DVec3;

/// Returns the cosine inside a medium of the relative index `eta` for the cosine outside, or 0 at total reflection.
pub fn refracted_cosine(cosine: f64, eta: f64) -> f64 {
    (1.0 - (1.0 - cosine * cosine).max(0.0) / (eta * eta)).max(0.0).sqrt()
}

/// Returns the direction in which light from `w` continues behind a facet of normal `n` (Walter et al. 2007, eq. 40). `eta > 0` is the
/// index behind the facet divided by the index before it. At total reflection, the direction is tangential.
pub fn refracted(w: DVec3, n: DVec3, eta: f64) -> DVec3 {
    let cosine = w.dot(n);
    ((cosine / eta - refracted_cosine(cosine, eta)) * n - w / eta).normalize()
}

/// Returns the direction of a ray behind a solid body. The facet of normal `facet` refracts the ray from `w` into the body, whose far side
/// is that of a sphere about the mean normal `n`.
pub fn passed_solid(w: DVec3, facet: DVec3, n: DVec3, eta: f64) -> DVec3 {
    let t = refracted(w, facet, eta);
    let out = n - 2.0 * t.dot(n) * t;
    // The facet can send the ray past the sphere.
    let cosine = t.dot(out).max(0.0);
    let inside = (t - t.dot(out) * out) + cosine.max((1.0 - 1.0 / (eta * eta)).max(0.0).sqrt()) * out;
    refracted(-inside.normalize(), -out, 1.0 / eta)
}

/// Returns the variance per axis, in radians squared, of light that has passed one interface whose facets have the slope variance
/// `variance` per axis. `cosine` is the cosine to the mean facet, outside the body.
pub fn refracted_variance(variance: f64, cosine: f64, eta: f64) -> f64 {
    let turn = eta * refracted_cosine(cosine, eta) - cosine;
    variance * turn * turn / cosine.max(1e-2)
}

/// Returns the variance per axis of light that has passed a thin wall of this roughness `α`.
pub fn thin_variance(alpha: f64, cosine: f64) -> f64 {
    2.0 * alpha * alpha * cosine
}

/// Returns the fraction of light that a medium lets pass on a path of `length` metres. `extinction` is per metre (Beer and Lambert).
pub fn attenuation(extinction: DVec3, length: f64) -> DVec3 {
    (-extinction * length).exp()
}

/// Returns the extinction per metre of a medium that lets the fraction `color` of white light pass on a path of `distance` metres, as in
/// `KHR_materials_volume`.
pub fn extinction(color: DVec3, distance: f64) -> DVec3 {
    -color.max(DVec3::splat(1e-4)).map(f64::ln) / distance
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;

    #[test]
    fn refraction_obeys_snell_and_walter() {
        let mut random = Random::stream(3, 0);
        for _ in 0..1000 {
            let n = random.on_sphere();
            let w = random.on_sphere();
            let w = if w.dot(n) < 0.0 { -w } else { w };
            let eta = random.range(1.01, 2.5);
            let t = refracted(w, n, eta);
            let sine = |d: DVec3| d.cross(n).length();
            assert!((sine(w) - eta * sine(t)).abs() < 1e-9 && t.dot(n) < 0.0);
            let half = -(w + eta * t).normalize();
            assert!(half.dot(n) > 1.0 - 1e-9, "{half} {n}");
        }
    }

    /// Rays through a smooth sphere leave in the plane of incidence, turned by twice the difference of the angles.
    #[test]
    fn a_smooth_sphere_turns_rays_exactly() {
        for degrees in [0.0f64, 20.0, 50.0, 80.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let (w, eta) = (DVec3::new(sin, 0.0, cos), 1.5);
            let passed = passed_solid(w, DVec3::Z, DVec3::Z, eta);
            let turned = 2.0 * (degrees.to_radians() - (sin / eta).asin());
            assert!((passed.dot(-w) - turned.cos()).abs() < 1e-9, "{degrees}");
            assert!(passed.y.abs() < 1e-12);
        }
        // An index of 1 bends nothing.
        let w = DVec3::new(0.3, 0.2, 0.8).normalize();
        assert!(passed_solid(w, DVec3::new(0.1, 0.0, 1.0).normalize(), DVec3::Z, 1.0).dot(-w) > 1.0 - 1e-9);
    }

    /// Random facets on the near side, seen through the far side of a sphere, spread light by `refracted_variance`.
    #[test]
    fn near_a_monte_carlo_spread() {
        let mut random = Random::stream(5, 0);
        for degrees in [0.0f64, 30.0, 55.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let (w, eta, sigma) = (DVec3::new(sin, 0.0, cos), 1.5, 0.03);
            let smooth = refracted(-refracted(w, DVec3::Z, eta), DVec3::Z, 1.0 / eta);
            let across = smooth.cross(DVec3::Y).normalize_or(DVec3::X);
            let [mut along, mut beside] = [0.0; 2];
            let count = 20_000;
            for _ in 0..count {
                let [x, y] = random.normals().map(|v| sigma * v);
                // The far side of this test is parallel, as for one interface of a plate.
                let facet = DVec3::new(-x, -y, 1.0).normalize();
                let passed = refracted(-refracted(w, facet, eta), DVec3::Z, 1.0 / eta);
                along += passed.dot(across).powi(2);
                beside += passed.y.powi(2);
            }
            let found = (along * beside).sqrt() / f64::from(count);
            let expected = refracted_variance(sigma * sigma, cos, eta);
            assert!((found / expected - 1.0).abs() < 0.05, "{degrees}°: {found} for {expected}");
        }
    }

    #[test]
    fn the_extinction_gives_the_color_at_its_distance() {
        let color = DVec3::new(0.9, 0.5, 0.1);
        assert!((attenuation(extinction(color, 0.2), 0.2) - color).length() < 1e-12);
        assert_eq!(attenuation(DVec3::ZERO, 3.0), DVec3::ONE);
    }
}
