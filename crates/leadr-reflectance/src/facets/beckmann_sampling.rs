//! Exact sampling of visible normals of a noncentral anisotropic Beckmann surface (thesis 2.2, eq. 2.35 and 3.4).
//!
//! The affine map `slope = m + C s`, `C Cᵀ = S`, relates the surface to the unit surface with slopes `s ~ N(0, 1)²`. On the unit surface,
//! the facet of slope `s` has the projected area `a − t·s` towards the viewer, with `t = Cᵀ wo.xy`. Let `b = |t|` and `ν = a/b`. The
//! coordinate `x` of a visible slope along `t` has the density `(ν − x)⁺ φ(x) / g(ν)`, and the coordinate across `t` is an independent
//! normal variable. The sampler inverts the integral of `(ν − x)⁺ φ(x)`, which has the closed form `F(x) = ν Φ(x) + φ(x)` up to
//! `F(ν) = g(ν)`.
//!
//! The method is valid for every `ν`, that is for a front-facing (`ν > 0`), edge-on or back-facing mesosurface. On a back-facing
//! mesosurface, only the tail of the slopes below `ν` is visible. Published inversions take the viewer's angle as their parameter, so they
//! stop at the horizon.

use super::normal_distribution::{MIN_PROBABILITY, mills_ratio, normal_quantile, tail_mean_ratio};
use super::projected_area::meso_area;
use crate::slopes::grid::{normal_of_slope, slope_at, slope_cholesky};
use crate::slopes::statistics::with_least_variance;
use glam::{DVec2, DVec3};
use std::f64::consts::PI;

/// The maximum number of Newton steps. The solver uses 3 to 6 steps, and the shader always uses 5.
const STEPS: u32 = 60;

/// Returns the quantile of the visible slopes of the unit surface along the viewer's azimuth. The result `x ≤ ν` solves
/// `(ν Φ(x) + φ(x)) / (ν Φ(ν) + φ(ν)) = u`, where `−∞ < ν ≤ ∞` is the mesosurface's projected area divided by the slope spread `b`.
///
/// `u` is clamped to `[2⁻³², 1 − 2⁻³²]`. The solver is a bracketed Newton method. The solver starts from Wilson and Hilferty's estimate for
/// the gamma distribution with the mean and variance of `y = ν − x`. In the lower half of the range it matches `ln F`, which is concave, so
/// every start converges. In the upper half it matches `√(g − F)`, which is linear where `F` approaches `g`. All values are divided by
/// `φ(min(ν, 0))` and are sums of terms of one sign, so the tail at `ν = −10` is just as accurate.
pub fn visible_slope_quantile(u: f64, nu: f64) -> f64 {
    let u = u.clamp(MIN_PROBABILITY, 1.0 - MIN_PROBABILITY);
    let (positive, negative) = (nu.clamp(0.0, 1e15), nu.clamp(-1e15, 0.0));
    let root_2pi = (2.0 * PI).sqrt();
    let z = normal_quantile(u);
    // Compute g, the mean of y, and a starting value for w = x − min(ν, 0).
    let (total, start) = if nu > 0.0 {
        let e = (-0.5 * positive * positive).exp();
        let total = root_2pi * positive + e * tail_mean_ratio(positive);
        let pull = (root_2pi - e * mills_ratio(positive)) / total;
        let mean = positive + pull;
        let variance = (2.0 - mean * pull).max(1e-3);
        let start = if nu > 5.0 { variance.sqrt() * z - pull } else { positive - gamma_quantile(z, mean, variance) };
        (total, start)
    } else {
        let t = -negative;
        let total = tail_mean_ratio(t);
        let mean = if t > 8.0 { 2.0 * t / (t * t + 3.0) } else { mills_ratio(t) / total - t };
        // The bound y ≥ √(2 (1 − u) g) holds because the density of y is y times a factor below 1.
        let least = (2.0 * (1.0 - u) * total).sqrt();
        (total, -gamma_quantile(z, mean, 2.0 - mean * (mean + t)).max(least))
    };
    let (mut low, mut high) = (-9.0, positive.min(7.0));
    let mut w = start.clamp(low, high);
    for _ in 0..STEPS {
        let (part, density) = visible_part(w, positive, negative);
        let change = if u < 0.5 {
            -part * (part / (u * total)).ln()
        } else {
            let rest = (total - part).max(0.0);
            2.0 * (rest - rest.sqrt() * ((1.0 - u) * total).sqrt())
        };
        // Update the bracket from the sign of the step. Near the root, a comparison of `part` would round differently.
        *(if change > 0.0 { &mut low } else { &mut high }) = w;
        let next = w + change / density;
        // Bisect if the step leaves the bracket or is NaN.
        let next = if next >= low && next <= high { next } else { 0.5 * (low + high) };
        let done = (next - w).abs() <= 1e-15 * w.abs();
        w = next;
        if done {
            break;
        }
    }
    negative + w
}

/// Returns `(F(x), F'(x)) / φ(min(ν, 0))` at `x = min(ν, 0) + w`.
fn visible_part(w: f64, positive: f64, negative: f64) -> (f64, f64) {
    let (x, y) = (negative + w, positive - w);
    let e = (-w * (negative + 0.5 * w)).exp();
    let part = if x <= 0.0 {
        e * (tail_mean_ratio(-x) + y * mills_ratio(-x))
    } else {
        positive * ((2.0 * PI).sqrt() - e * mills_ratio(x)) + e
    };
    (part, y * e)
}

/// Returns the upper-tail quantile of a gamma distribution at the normal deviate `z`, by the Wilson–Hilferty approximation. Shape
/// parameters below 2 occur only through rounding and are treated as 2.
fn gamma_quantile(z: f64, mean: f64, variance: f64) -> f64 {
    let shape = (mean * mean / variance.max(1e-30)).max(2.0);
    let cube = (1.0 - 1.0 / (9.0 * shape) - z / (3.0 * shape.sqrt())).max(0.02);
    mean * cube * cube * cube
}

/// Samples a visible normal from `u` in `[0, 1)²`. `u.x` selects the slope along the viewer's azimuth, `u.y` the slope across it.
///
/// The density is `max(0, wo·wn) D(wn) / A(wo)` for [`beckmann_ndf`](super::beckmann::beckmann_ndf) with the same statistics. A viewer
/// exactly opposite the displacement direction sees no facets, so the result is an arbitrary finite normal.
pub fn beckmann_sample_visible(wo: DVec3, u: DVec2, m: DVec2, s: DVec3) -> DVec3 {
    let c = slope_cholesky(with_least_variance(s));
    let t = DVec2::new(c.x * wo.x + c.y * wo.y, c.z * wo.y);
    let nu = (meso_area(wo, m) / t.length().max(1e-18)).clamp(-1e15, 1e15);
    // Rotate the visible slope of the unit surface from the azimuth of `t` to the axes.
    let along = t.try_normalize().unwrap_or(DVec2::X);
    let standard = along.rotate(DVec2::new(visible_slope_quantile(u.x, nu), normal_quantile(u.y)));
    normal_of_slope(slope_at(standard, m, c))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::normal_distribution::{normal_cdf, normal_pdf, normal_tail_mean};

    /// Returns `F(x) / g` from functions that can underflow, in the range where they do not.
    fn cdf(x: f64, nu: f64) -> f64 {
        let g = nu.max(0.0) + normal_tail_mean(nu.abs());
        let part =
            if x <= 0.0 { normal_tail_mean(-x) + (nu - x) * normal_cdf(x) } else { nu * normal_cdf(x) + normal_pdf(x) };
        part / g
    }

    #[test]
    fn quantile_inverts_the_visible_distribution() {
        let mut worst = (0.0f64, 0.0, 0.0);
        for i in -100..=400 {
            let nu = if i < 200 { 0.1 * f64::from(i) } else { 20.0 * 1.2f64.powi(i - 200) };
            let mut before = f64::NEG_INFINITY;
            for k in 0..=200 {
                let u = match k {
                    0..20 => 10f64.powi(k / 2 - 10),
                    20..=180 => f64::from(k - 19) / 162.0,
                    _ => 1.0 - 10f64.powf(-0.4 * f64::from(k - 176)),
                };
                let x = visible_slope_quantile(u, nu);
                let held = u.clamp(MIN_PROBABILITY, 1.0 - MIN_PROBABILITY);
                assert!(
                    x >= before - 1e-13 * x.abs().max(1.0) || k == 20 || k == 181,
                    "u {u}, ν {nu}: {x} after {before}"
                );
                assert!(x <= nu);
                before = x;
                let error = (cdf(x, nu) - held).abs() / held;
                if error > worst.0 {
                    worst = (error, u, nu);
                }
            }
        }
        println!(
            "worst relative error of the CDF at the quantile: {:.1e} (u = {:e}, ν = {})",
            worst.0, worst.1, worst.2
        );
        assert!(worst.0 < 2e-13);
    }

    #[test]
    fn limits_of_the_quantile() {
        // For a large positive ν the slopes have a normal distribution. For a large negative ν they have a gamma distribution of shape 2.
        for u in [0.001, 0.3, 0.5, 0.999] {
            assert!((visible_slope_quantile(u, 1e12) - normal_quantile(u)).abs() < 1e-11);
            let y = 1e4 * (-1e4 - visible_slope_quantile(u, -1e4));
            let gamma = (1.0 + y) * (-y).exp();
            assert!((gamma - u).abs() < 1e-6, "{u}: {gamma}");
        }
        for nu in [-f64::INFINITY, -1e300, -1e15, 0.0, 1e-300, 1e15, f64::INFINITY] {
            for u in [0.0, 1e-300, 0.5, 1.0] {
                assert!(visible_slope_quantile(u, nu).is_finite(), "{u} {nu}");
            }
        }
    }

    #[test]
    fn samples_are_visible_unit_normals() {
        for m in [DVec2::ZERO, DVec2::new(3.0, -1.0)] {
            for s in [DVec3::ZERO, DVec3::new(0.3, 0.1, 0.1), DVec3::new(1.0, 1.0, 1.0)] {
                for degrees in [0.0f64, 40.0, 89.0, 120.0] {
                    let (sin, cos) = degrees.to_radians().sin_cos();
                    let wo = DVec3::new(-0.6 * sin, 0.8 * sin, cos);
                    for i in 0..100 {
                        let u = DVec2::new(f64::from(i) / 100.0, (0.618 * f64::from(i)).fract());
                        let wn = beckmann_sample_visible(wo, u, m, s);
                        assert!((wn.length() - 1.0).abs() < 1e-14 && wn.z > 0.0);
                        let seen = meso_area(wo, m) > 0.0 || s.x > 0.0;
                        assert!(wo.dot(wn) > -1e-14 || !seen, "{wn} for {wo} {m} {s}");
                    }
                }
            }
        }
        assert!(beckmann_sample_visible(DVec3::NEG_Z, DVec2::ZERO, DVec2::ZERO, DVec3::ZERO).is_finite());
    }
}
