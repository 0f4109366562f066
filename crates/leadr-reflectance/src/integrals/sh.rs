//! Real spherical harmonics up to order 2 and their irradiance (Ramamoorthi & Hanrahan 2001).
//!
//! The coefficients are in the order `L00, L1-1, L10, L11, L2-2, L2-1, L20, L21, L22`. Each is an RGB triple in the world frame.

use glam::DVec3;

/// Nine RGB coefficients of radiance.
pub type Sh9 = [DVec3; 9];

/// Evaluates the nine basis functions at the unit direction `d`.
pub fn sh_basis(d: DVec3) -> [f64; 9] {
    use std::f64::consts::PI;
    let k1 = (0.75 / PI).sqrt();
    let k2 = (3.75 / PI).sqrt();
    [
        (0.25 / PI).sqrt(),
        k1 * d.y,
        k1 * d.z,
        k1 * d.x,
        k2 * d.x * d.y,
        k2 * d.y * d.z,
        (0.3125 / PI).sqrt() * (3.0 * d.z * d.z - 1.0),
        k2 * d.x * d.z,
        0.5 * k2 * (d.x * d.x - d.y * d.y),
    ]
}

/// Returns the radiance from the direction `d`. If `d` is shorter than 1, such as a mean of several directions, the terms of order 1 and 2
/// are smaller.
pub fn sh_radiance(c: &Sh9, d: DVec3) -> DVec3 {
    let mut basis = sh_basis(d);
    // This form equals the polynomial of sh_basis for |d| = 1, but has no order-2 term at d = 0.
    basis[6] = (0.3125 / std::f64::consts::PI).sqrt() * (2.0 * d.z * d.z - d.x * d.x - d.y * d.y);
    c.iter().zip(basis).map(|(&c, b)| c * b).sum()
}

/// Adds a light from the unit direction `wi` that has this `irradiance` on a plane facing it (LEADR Algorithm 2). The `L00 += L00 + …`
/// printed there is an erratum.
pub fn sh_add_light(c: &mut Sh9, wi: DVec3, irradiance: DVec3) {
    for (c, b) in c.iter_mut().zip(sh_basis(wi)) {
        *c += b * irradiance;
    }
}

/// Returns the irradiance averaged over normals with the mean `n` and the second moments `diag = E[xx, yy, zz]` and `off = E[yz, xz, xy]`.
/// The cosine convolution scales the bands by `A_l = π, 2π/3, π/4`. The irradiance is linear in the moments, and the trace of `diag` is 1.
pub fn sh_irradiance_moments(c: &Sh9, n: DVec3, diag: DVec3, off: DVec3) -> DVec3 {
    use std::f64::consts::PI;
    let a0 = PI * (0.25 / PI).sqrt();
    let a1 = 2.0 * PI / 3.0 * (0.75 / PI).sqrt();
    let a2 = 0.25 * PI * (3.75 / PI).sqrt();
    let a20 = 0.25 * PI * (0.3125 / PI).sqrt();
    a0 * c[0]
        + a1 * (c[3] * n.x + c[1] * n.y + c[2] * n.z)
        + a2 * (c[4] * off.z + c[7] * off.y + c[5] * off.x)
        + a20 * c[6] * (3.0 * diag.z - 1.0)
        + 0.5 * a2 * c[8] * (diag.x - diag.y)
}

/// Returns the irradiance on a plane of unit normal `n`. The irradiance may be slightly negative opposite a strong light, because of
/// ringing.
pub fn sh_irradiance(c: &Sh9, n: DVec3) -> DVec3 {
    sh_irradiance_moments(c, n, n * n, DVec3::new(n.y * n.z, n.x * n.z, n.x * n.y))
}

/// Returns the order-2 irradiance from one light of unit irradiance, which is a polynomial in the cosine between normal and light.
pub fn sh_irradiance_light(cosine: f64) -> f64 {
    0.09375 + cosine * (0.5 + 0.46875 * cosine)
}

/// Returns the irradiance from one light beyond order 2, which is the clamped cosine minus [`sh_irradiance_light`]. This remainder begins
/// at band 4.
pub fn sh_irradiance_rest(cosine: f64) -> f64 {
    cosine.max(0.0) - sh_irradiance_light(cosine)
}

/// Returns the factor, at most 1, by which normals of mean `n` attenuate the irradiance beyond order 2. A spread of variance `v` per axis
/// shortens the mean to `exp(−v)` and scales band `l` by `exp(−v l (l + 1)/2)`. The result is the factor `|n|¹⁰` of band 4, the lowest and
/// strongest band beyond order 2.
pub fn sh_rest_damping(n: DVec3) -> f64 {
    n.length_squared().min(1.0).powi(5)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn constants_match_the_paper() {
        let mut c = [DVec3::ZERO; 9];
        c[8] = DVec3::ONE;
        assert!((sh_irradiance(&c, DVec3::X).x - 0.429_043).abs() < 1e-6);
        c = [DVec3::ZERO; 9];
        c[6] = DVec3::ONE;
        assert!((sh_irradiance(&c, DVec3::X).x + 0.247_708).abs() < 1e-6);
        assert!((sh_irradiance(&c, DVec3::Z).x - (0.743_125 - 0.247_708)).abs() < 2e-6);
    }

    /// The irradiance beyond order 2 is orthogonal to Legendre polynomials up to order 3. The polynomial of order 4 gives band 4 of the
    /// cosine, which is −π/24.
    #[test]
    fn the_rest_begins_at_band_four() {
        let n = 200_000;
        let mean = |f: &dyn Fn(f64) -> f64| {
            let at = |i: i32| -1.0 + (2.0 * f64::from(i) + 1.0) / f64::from(n);
            (0..n).map(|i| sh_irradiance_rest(at(i)) * f(at(i))).sum::<f64>() * 2.0 / f64::from(n)
        };
        for f in [(|_| 1.0) as fn(f64) -> f64, |c| c, |c| c * c, |c| c * c * c] {
            assert!(mean(&f).abs() < 1e-9);
        }
        let fourth = |c: f64| (35.0 * c.powi(4) - 30.0 * c * c + 3.0) / 8.0;
        assert!((mean(&fourth) + 1.0 / 48.0).abs() < 1e-9, "{}", mean(&fourth));
        assert!((sh_rest_damping(DVec3::new(0.0, 0.0, (-0.1f64).exp())) - (-1.0f64).exp()).abs() < 1e-12);
    }

    #[test]
    fn a_light_is_its_polynomial() {
        let wi = DVec3::new(0.48, -0.6, 0.64);
        let mut c = [DVec3::ZERO; 9];
        sh_add_light(&mut c, wi, DVec3::new(1.0, 2.0, 3.0));
        for n in [DVec3::X, DVec3::new(0.36, 0.48, -0.8), wi, -wi] {
            let e = sh_irradiance(&c, n);
            assert!((e - sh_irradiance_light(n.dot(wi)) * DVec3::new(1.0, 2.0, 3.0)).length() < 1e-14);
        }
    }
}
