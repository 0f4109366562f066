//! Facets with a Phong distribution of normals (LEADR section 6), about any mean slope and with any covariance.
//!
//! Phong's distribution `D = (n + 2)/2π cosⁿθ` has the slope density `(n + 2)/2π (1 + |x|²)^(−(n+4)/2)`: a bivariate t distribution with
//! `n + 2` degrees of freedom and the variance `1/n` on each axis. An affine map of the slopes gives it a mean `m` and a covariance `C`:
//!
//! ```text
//! P(x) = (n + 2)/(2π n √|C|) (1 + q/n)^(−(n+4)/2),   q = (x − m)ᵀ C⁻¹ (x − m),   n = 1/√|C|
//! ```
//!
//! so rougher footprints have heavier tails, as rougher Phong lobes have. For `C = I/n` and `m = 0` this is Phong's distribution.
//!
//! *Masking.* Walter et al. (2007) mask Phong facets like Beckmann facets with `a = √(n/2 + 1)/tan θ`, which have the slope covariance
//! `C n/(n + 2)`. At `n = 2` and 80°, a white plane would then reflect 1.07 of the light that it receives, because the tails hide more. The
//! visible area is therefore that of both Gaussian surfaces below, with which the plane reflects at most .98.
//!
//! *Environments.* The t distribution is a mixture of Gaussians whose inverse variance has a gamma distribution. The Gauss rule with two nodes
//! of this distribution is a closed form: with `t = 1/√(n/2 + 2)`, the covariances `(1 ± t) C n/(n + 2)` have the weights `(1 ± t)/2`. Its
//! error `∫ |P − P̂|` is .10 of at most 2 for `n = 2`, .02 for 8 and .006 for 20; one Gaussian of covariance `C` has .37, .13 and .06.

use super::ggx_lobes::GaussianLobe;
use crate::facets::projected_area::{meso_area, visible_area};
use crate::limits::{MIN_NORMAL_Z, MIN_VARIANCE};
use crate::masking::correlated::{DirectionArea, whitened_direction};
use crate::slopes::grid::slope_cholesky;
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// The number of Gaussian surfaces that [`phong_lobe`] returns.
pub const PHONG_LOBES: usize = 2;

/// Returns Phong's exponent of facets whose slopes have the covariance `c`. It is the inverse of the variance of round slopes.
pub fn phong_exponent(c: DVec3) -> f64 {
    let factor = phong_cholesky(c);
    1.0 / (factor.x * factor.z)
}

/// Returns the Cholesky factor of a covariance of at least the smallest variance.
fn phong_cholesky(c: DVec3) -> DVec3 {
    slope_cholesky(DVec3::new(c.x.max(MIN_VARIANCE), c.y.max(MIN_VARIANCE), c.z))
}

/// Returns the density of the slopes with the mean `m` and the covariance `c`.
pub fn phong_p22(slope: DVec2, m: DVec2, c: DVec3) -> f64 {
    let (factor, d) = (phong_cholesky(c), slope - m);
    let n = 1.0 / (factor.x * factor.z);
    let x = d.x / factor.x;
    let y = (d.y - factor.y * x) / factor.z;
    (n + 2.0) / TAU * (-0.5 * (n + 4.0) * ((x * x + y * y) / n).ln_1p()).exp()
}

/// Returns the density `D(wh)` of the normals per unit of macrosurface and solid angle. It is 0 for `wh.z ≤ 0`.
pub fn phong_ndf(wh: DVec3, m: DVec2, c: DVec3) -> f64 {
    if wh.z <= 0.0 {
        return 0.0;
    }
    let z = wh.z.max(MIN_NORMAL_Z);
    phong_p22(DVec2::new(-wh.x, -wh.y) / z, m, c) / z.powi(4)
}

/// Returns the covariance of the Gaussian facets with which Walter et al. mask Phong facets.
pub fn phong_masking(c: DVec3) -> DVec3 {
    let n = phong_exponent(c);
    c * (n / (n + 2.0))
}

/// Returns one of the Gaussian surfaces that approximate the facets: the wider for `k = 0`, the narrower for `k = 1`.
pub fn phong_lobe(c: DVec3, k: usize) -> GaussianLobe {
    let t = 1.0 / (0.5 * phong_exponent(c) + 2.0).sqrt();
    let by = if k == 0 { 1.0 + t } else { 1.0 - t };
    GaussianLobe { weight: 0.5 * by, s: by * phong_masking(c) }
}

/// Returns the projected areas of the surface along `w`. `cholesky` is the Cholesky factor of [`phong_masking`].
pub fn phong_area(w: DVec3, m: DVec2, c: DVec3, cholesky: DVec3) -> DirectionArea {
    let whitened = whitened_direction(w, cholesky);
    let area = |k| {
        let lobe = phong_lobe(c, k);
        lobe.weight * visible_area(w, m, lobe.s)
    };
    DirectionArea {
        whitened,
        spread: whitened.length(),
        meso: meso_area(w, m),
        visible: (0..PHONG_LOBES).map(area).sum(),
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::beckmann::beckmann_p22;
    use crate::materials::classic::blinn_phong_ndf;
    use crate::materials::microfacet::half_vector;
    use crate::quadrature::composite_gauss;
    use crate::slopes::grid::normal_of_slope;

    /// Integrates over slopes about `m` in polar coordinates that cover the plane.
    fn over_slopes(m: DVec2, c: DVec3, f: impl Fn(DVec2) -> f64) -> f64 {
        let cholesky = slope_cholesky(c);
        let azimuths = 64;
        composite_gauss(0.0, 1.0 - 1e-9, 60, 8)
            .into_iter()
            .map(|(v, w)| {
                let radius = v / (1.0 - v);
                let around: f64 = (0..azimuths)
                    .map(|i| {
                        let p = DVec2::from_angle(TAU * (f64::from(i) + 0.5) / f64::from(azimuths)) * radius;
                        f(crate::slopes::grid::slope_at(p, m, cholesky))
                    })
                    .sum();
                w * radius / (1.0 - v).powi(2) * TAU / f64::from(azimuths) * around * cholesky.x * cholesky.z
            })
            .sum()
    }

    #[test]
    fn round_facets_are_those_of_phong() {
        for n in [0.7, 2.0, 30.0, 1000.0] {
            let c = DVec3::new(1.0 / n, 1.0 / n, 0.0);
            for z in [0.05, 0.5, 0.9, 1.0f64] {
                let wh = DVec3::new((1.0 - z * z).sqrt(), 0.0, z);
                let expected = blinn_phong_ndf(z, n);
                assert!((phong_ndf(wh, DVec2::ZERO, c) - expected).abs() < 1e-9 * expected.max(1e-3), "{n} {z}");
            }
        }
    }

    #[test]
    fn slopes_have_their_moments() {
        for scale in [0.02, 0.1, 0.3] {
            let (m, c) = (DVec2::new(0.3, -0.2), scale * DVec3::new(2.0, 1.0, 0.5));
            let total = over_slopes(m, c, |x| phong_p22(x, m, c));
            let second = over_slopes(m, c, |x| (x.x - m.x) * (x.y - m.y) * phong_p22(x, m, c));
            assert!((total - 1.0).abs() < 1e-6, "{scale}: {total}");
            assert!((second / c.z - 1.0).abs() < 0.01, "{scale}: {second}");
        }
    }

    #[test]
    fn two_gaussians_are_near() {
        for (n, most) in [(2.0, 0.1), (8.0, 0.024), (20.0, 0.006)] {
            let c = DVec3::new(1.0, 1.0, 0.0) / n;
            let lobes = [0, 1].map(|k| phong_lobe(c, k));
            assert!((lobes[0].weight + lobes[1].weight - 1.0).abs() < 1e-12);
            let density = |x: DVec2| lobes.iter().map(|l| l.weight * beckmann_p22(x, DVec2::ZERO, l.s)).sum::<f64>();
            let error = over_slopes(DVec2::ZERO, c, |x| (density(x) - phong_p22(x, DVec2::ZERO, c)).abs());
            let one =
                over_slopes(DVec2::ZERO, c, |x| (beckmann_p22(x, DVec2::ZERO, c) - phong_p22(x, DVec2::ZERO, c)).abs());
            println!("n {n}: two Gaussians {error:.4}, one {one:.4}");
            assert!(error < most && one > 3.0 * error, "{n}: {error} {one}");
        }
    }

    /// No more light is reflected than received. With Walter's masking, rough facets gain light at grazing angles.
    #[test]
    fn a_white_furnace_gains_nothing() {
        for n in [2.0, 8.0, 50.0] {
            let c = DVec3::new(1.0, 1.0, 0.0) / n;
            for degrees in [5.0f64, 40.0, 65.0, 80.0] {
                let (sin, cos) = degrees.to_radians().sin_cos();
                let wo = DVec3::new(sin, 0.0, cos);
                let cholesky = slope_cholesky(phong_masking(c));
                let area = |w: DVec3| phong_area(w, DVec2::ZERO, c, cholesky).visible;
                let walter = |w: DVec3| visible_area(w, DVec2::ZERO, phong_masking(c));
                let masked = area(wo);
                // The weak white furnace: visible facets over the area that masking assumes.
                let seen = over_slopes(DVec2::ZERO, c, |x| {
                    let wn = normal_of_slope(x);
                    phong_p22(x, DVec2::ZERO, c) * (wo.dot(wn) / wn.z).max(0.0)
                });
                println!("n {n}, {degrees} degrees: {:.4}", seen / masked);
                assert!(seen / masked < 1.08 && seen / masked > 0.99, "{n} {degrees}: {}", seen / masked);
                // With shadowing, over the hemisphere of lights.
                let (mut sum, mut by_walter) = (0.0, 0.0);
                for (z, w) in composite_gauss(0.0, 1.0, 40, 4) {
                    for i in 0..128 {
                        let phi = TAU * (f64::from(i) + 0.5) / 128.0;
                        let wi = DVec3::new((1.0 - z * z).sqrt() * phi.cos(), (1.0 - z * z).sqrt() * phi.sin(), z);
                        let d = phong_ndf(half_vector(wo, wi), DVec2::ZERO, c) * w * TAU / 128.0 / (4.0 * wo.z);
                        sum += d / (area(wo) / wo.z + area(wi) / wi.z - 1.0);
                        by_walter += d / (walter(wo) / wo.z + walter(wi) / wi.z - 1.0);
                    }
                }
                println!("  with shadowing {sum:.4}, Walter {by_walter:.4}");
                assert!(sum < 1.0005 && sum > 0.6 && sum <= by_walter + 1e-9, "{n} {degrees}: {sum}");
                assert!((by_walter > 1.05) == (n < 8.0 && degrees > 70.0), "{n} {degrees}: {by_walter}");
            }
        }
    }
}
