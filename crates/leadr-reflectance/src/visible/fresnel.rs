//! The mean Fresnel reflectance of the visible facets, which is the fraction of the light that never reaches the diffuse base.
//!
//! Schlick's weight is `k⁵` with `k = 1 − wo·wn`. The weight depends on the facet through `wo·wn = (wo.z − wo.xy·x) / |N|`, which varies
//! almost only along the view azimuth. The exact mean and variance of the visible slopes along this azimuth come from [`super::slopes`]. To
//! second order about the mean facet, the cosine at `d` standard deviations along the axis is
//!
//! ```text
//! c(d) = (f − b d) / √(n + 2 e d + l d²)
//! at d = 0:  −c' = (b + f e/n) / √n,   ½c'' = (b e/n + f (3/2 e²/n² − ½ l/n)) / √n
//! ```
//!
//! Here `f` is the projected area of the mean facet, `b` is the spread of the slope along the axis, `n` is the `|N|²` of the mean facet,
//! and `2 e d + l d²` is the change of `|N|²` along the axis.
//!
//! The fifth power of a normal variable with mean `μ` and variance `v` has the mean `μ⁵ + 10 μ³ v + 15 μ v²`. Slopes across the view
//! azimuth only lengthen `N`. On average, `|N|²` grows by the variance of these slopes.

use super::slopes::tilted_area;
use crate::facets::fresnel::grazing_reflectance;
use crate::facets::normal_distribution::clamped_lean;
use crate::limits::at_least;
use crate::slopes::statistics::covariance_times;
use glam::{DVec2, DVec3, Vec3Swizzles as _};

/// Returns the mean of Schlick's term ([`crate::facets::fresnel::fresnel_schlick`]) over the visible facets. `f0` is the linear RGB
/// reflectance at normal incidence. `s` is the covariance of the slopes, which the caller has clamped
/// ([`crate::slopes::statistics::clamp_covariance`]).
pub fn visible_fresnel(wo: DVec3, m: DVec2, s: DVec3, f0: DVec3) -> DVec3 {
    let across = covariance_times(s, wo.xy());
    let b2 = at_least(across.dot(wo.xy()), 0.0);
    let per_b = 1.0 / b2.max(1e-24).sqrt();
    let b = b2 * per_b;
    let a = tilted_area(wo, m, b);
    let t = (a * per_b).min(1e6);
    let lean = clamped_lean(t);
    let variance = (2.0 - lean * (t + lean)).clamp(0.02, 1.0);
    let axis = across * per_b;
    let rest = (s.x + s.y - axis.length_squared()).max(0.0);
    let mean = mean_schlick_weight(a + b * lean, b, axis, m - axis * lean, rest, variance);
    f0 + (grazing_reflectance(f0) - f0) * mean
}

/// Returns the mean of Schlick's weight over slopes along `axis` about `slope`. `facet` is the projected area of the facet at `slope`, and
/// `b` is the decrease of this area per length of `axis`. `variance` is the variance of the slopes along `axis`, in units of its squared
/// length. `rest` is the variance across the axis.
pub fn mean_schlick_weight(facet: f64, b: f64, axis: DVec2, slope: DVec2, rest: f64, variance: f64) -> f64 {
    let (e, l) = (slope.dot(axis), axis.length_squared());
    let n = 1.0 + slope.length_squared() + rest;
    let per = 1.0 / n.sqrt();
    let first = (b + facet * e / n) * per;
    let second = (b * e / n + facet * (1.5 * e * e / (n * n) - 0.5 * l / n)) * per;
    let k = (1.0 - facet * per - variance * second).clamp(0.0, 1.0);
    let v = variance * first * first;
    (k.powi(5) + 10.0 * k.powi(3) * v + 15.0 * k * v * v).clamp(0.0, 1.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::fresnel::fresnel_schlick;
    use crate::facets::projected_area::{meso_area, slope_spread};
    use crate::integrals::reference::visible_mean;
    use crate::slopes::grid::normal_of_slope;

    #[test]
    fn near_the_converged_mean() {
        let f0 = DVec3::splat(0.04);
        let (mut worst, mut square, mut count, mut at) = (0.0f64, 0.0, 0.0, String::new());
        for degrees in [0.0f64, 30.0, 55.0, 70.0, 80.0, 87.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            for azimuth in [0.0f64, 0.7, 1.6] {
                let wo = DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos);
                for sigma in [0.02f64, 0.1, 0.3, 0.6, 1.0] {
                    for (m, ratio) in [(DVec2::ZERO, 1.0), (DVec2::new(0.3, -0.2), 1.0), (DVec2::ZERO, 0.1)] {
                        let s = DVec3::new(sigma * sigma, ratio * sigma * sigma, 0.0);
                        // Only a few edge-on facets are visible on a mesosurface that faces far away from the viewer.
                        if meso_area(wo, m) < -slope_spread(wo, s) {
                            continue;
                        }
                        let exact = visible_mean(wo, m, s, 10, |x| fresnel_schlick(f0, wo.dot(normal_of_slope(x))));
                        let error = (visible_fresnel(wo, m, s, f0).x - exact.x).abs();
                        square += error * error;
                        count += 1.0;
                        if error > worst {
                            (worst, at) = (error, format!("{degrees}°, {azimuth}, σ {sigma}, {m}, {ratio}"));
                        }
                    }
                }
            }
        }
        let rms = f64::sqrt(square / count);
        println!("worst error {worst:.4} ({at}), rms {rms:.4}");
        assert!(worst < 0.03 && rms < 0.009);
    }
}
