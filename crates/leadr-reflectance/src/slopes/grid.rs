//! The N×N grid of slopes over P22 (LEADR 5.1).

use super::statistics::slope_correlation;
use crate::limits::{MAX_SLOPE, at_least};
use glam::{DVec2, DVec3, Vec3Swizzles as _};

/// Returns the half extent of the grid in standard deviations. It is 0 for `n = 1` (the mean alone), then `0.3 (n + 1)` up to 3. `n = 5`
/// gives the paper's value of 1.8 (supplement 3.4). From `n = 32`, every doubling adds 0.8 while the spacing still shrinks, so denser grids
/// converge to the integral.
pub fn grid_lambda(n: u32) -> f64 {
    if n <= 1 {
        return 0.0;
    }
    let n = f64::from(n);
    (0.3 * (n + 1.0)).min(3.0) + 0.8 * (n / 32.0).max(1.0).log2()
}

/// Returns the distance between neighbouring nodes in standard deviations. For `n = 1`, the distance is √12, the width of a box that has
/// the same variance.
///
/// (LEADR 5.2 divides by N. Its supplement divides by N − 1, which gives the true distance.)
pub fn grid_spacing(n: u32, lambda: f64) -> f64 {
    if n <= 1 { 12f64.sqrt() } else { 2.0 * lambda / f64::from(n - 1) }
}

/// Returns `(p_j, p_k, weight)` of the node `j, k` in `0..n`. The weights are not normalised, since the estimators divide by their sum.
pub fn grid_node(j: u32, k: u32, n: u32, lambda: f64) -> DVec3 {
    if n <= 1 {
        return DVec3::new(0.0, 0.0, 1.0);
    }
    let at = |i: u32| lambda * (2.0 * f64::from(i) / f64::from(n - 1) - 1.0);
    let (p, q) = (at(j), at(k));
    DVec3::new(p, q, (-0.5 * (p * p + q * q)).exp())
}

/// Returns all `n`×`n` nodes of [`grid_node`].
pub fn grid_nodes(n: u32, lambda: f64) -> impl Iterator<Item = DVec3> {
    (0..n).flat_map(move |j| (0..n).map(move |k| grid_node(j, k, n, lambda)))
}

/// Returns the lower Cholesky factor `(c_xx, c_yx, c_yy)` of the covariance.
pub fn slope_cholesky(s: DVec3) -> DVec3 {
    let deviation = |variance: f64| variance.clamp(0.0, MAX_SLOPE * MAX_SLOPE).sqrt();
    let sigma = DVec2::new(deviation(s.x), deviation(s.y));
    let r = slope_correlation(sigma, s.z);
    DVec3::new(sigma.x, sigma.y * r, sigma.y * ((1.0 - r) * (1.0 + r)).sqrt())
}

/// Returns the slope at standard normal coordinates `p` (LEADR 5.1).
pub fn slope_at(p: DVec2, m: DVec2, cholesky: DVec3) -> DVec2 {
    m + DVec2::new(cholesky.x * p.x, cholesky.y * p.x + cholesky.z * p.y)
}

/// Computes [`slope_at`] from the covariance instead of its Cholesky factor.
pub fn slope_sample(p: DVec2, m: DVec2, s: DVec3) -> DVec2 {
    slope_at(p, m, slope_cholesky(s))
}

/// Returns the unit normal of a slope (LEADR eq. 11).
pub fn normal_of_slope(slope: DVec2) -> DVec3 {
    DVec3::new(-slope.x, -slope.y, 1.0) / (slope.length_squared() + 1.0).sqrt()
}

/// Returns `⟨wn, wo⟩ / (wn·wg)`, the projected area per unit of macrosurface of the facet with this slope. The result is 0 for a
/// back-facing facet.
pub fn facet_area(wo: DVec3, slope: DVec2) -> f64 {
    at_least(wo.z - wo.xy().dot(slope), 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn five_by_five_matches_the_supplement() {
        let weights: Vec<f64> = (0..5).map(|j| (-0.5 * grid_node(j, 2, 5, grid_lambda(5)).x.powi(2)).exp()).collect();
        let sum: f64 = weights.iter().sum();
        for (w, printed) in weights.iter().zip([0.0725, 0.2443, 0.3663, 0.2443, 0.0725]) {
            assert!((w / sum - printed).abs() < 1e-4);
        }
        assert!((grid_spacing(5, grid_lambda(5)) - 0.9).abs() < 1e-15);
    }

    #[test]
    fn a_dense_grid_has_the_moments() {
        let (m, s) = (DVec2::new(0.3, 0.1), DVec3::new(0.2, 0.5, -0.2));
        let (mut sum, mut mean, mut second) = (0.0, DVec2::ZERO, DVec3::ZERO);
        for j in 0..41 {
            for k in 0..41 {
                let node = grid_node(j, k, 41, 6.0);
                let slope = slope_sample(node.xy(), m, s);
                let d = slope - m;
                sum += node.z;
                mean += node.z * slope;
                second += node.z * DVec3::new(d.x * d.x, d.y * d.y, d.x * d.y);
            }
        }
        assert!((mean / sum - m).length() < 1e-7 && (second / sum - s).length() < 1e-7);
    }
}
