//! The mean Fresnel reflectance of the visible facets, which is the fraction of the light that never reaches the diffuse base.
//!
//! Schlick's weight is `k⁵` with `k = 1 − wo·wn`. The weight depends on the facet through `wo·wn = (wo.z − wo.xy·x) / |N|`, which varies
//! almost only along the view azimuth. The weight is too nonlinear for a series expansion, because it reaches 1 on nearly edge-on facets.
//! Instead, it is evaluated at the mean visible slope and at one slope on either side along the azimuth. The weights of the three slopes
//! match the first four cumulants of the visible slopes, which [`super::slopes`] has in closed form. With the skewness `γ` and the kurtosis
//! `κ`, the slopes are `0` and `γ/2 ± √(κ − 3/4 γ²)` standard deviations from the mean.
//!
//! Slopes across the view azimuth only lengthen `N`. On average, `|N|²` grows by the variance of these slopes.
//!
//! The exact Fresnel term is Schlick's plus a deviation ([`fresnel_deviation`]), which has the same three slopes.

use super::slopes::{VisibleSlopes, visible_slopes};
use crate::facets::complex_index::{ComplexIndex, fresnel_deviation};
use crate::facets::fresnel::{grazing_reflectance, schlick_weight};
use glam::{DVec2, DVec3};

/// Returns the mean of Schlick's term ([`crate::facets::fresnel::fresnel_schlick`]) over the visible facets. `f0` is the linear RGB
/// reflectance at normal incidence. `m` and `s` may have any finite value.
pub fn visible_fresnel(wo: DVec3, m: DVec2, s: DVec3, f0: DVec3) -> DVec3 {
    f0 + (grazing_reflectance(f0) - f0) * visible_schlick_weight(&visible_slopes(wo, m, s))
}

/// Returns the mean of the exact reflectance ([`fresnel_exact`](crate::facets::complex_index::fresnel_exact)) over the visible facets.
pub fn visible_fresnel_exact(wo: DVec3, m: DVec2, s: DVec3, f0: DVec3, index: &ComplexIndex) -> DVec3 {
    let cosines = visible_cosines(&visible_slopes(wo, m, s));
    let schlick = f0 + (grazing_reflectance(f0) - f0) * mean_schlick_weight(&cosines);
    (schlick + mean_deviation(&cosines, f0, index)).clamp(DVec3::ZERO, DVec3::ONE)
}

/// Returns the mean of Schlick's weight over visible slopes, from 0 to 1.
pub fn visible_schlick_weight(v: &VisibleSlopes) -> f64 {
    mean_schlick_weight(&visible_cosines(v))
}

/// Three cosines between the viewer and the normals of visible facets, and their weights.
#[derive(Clone, Copy, Debug)]
pub struct VisibleCosines {
    /// The cosines, which can be negative.
    pub cosine: DVec3,
    /// The weights, which sum to one.
    pub weight: DVec3,
}

/// Returns the three slopes along the view azimuth whose weights reproduce the first four cumulants of the visible slopes.
pub fn visible_cosines(v: &VisibleSlopes) -> VisibleCosines {
    let rest = (v.s.x + v.s.y - v.axis.length_squared()).max(0.0);
    let deviation = v.variance.sqrt();
    let skewness = v.third / (v.variance * deviation);
    let kurtosis = 3.0 + v.fourth / (v.variance * v.variance);
    let reach = (kurtosis - 0.75 * skewness * skewness).max(0.5).sqrt();
    let (near, far) = (0.5 * skewness + reach, 0.5 * skewness - reach);
    let (of_near, of_far) = (0.5 / (near * reach), -0.5 / (far * reach));
    let at = |node: f64| {
        let u = node * deviation;
        let slope = v.mean + v.axis * u;
        (v.facet - v.b * u) / (1.0 + slope.length_squared() + rest).sqrt()
    };
    VisibleCosines {
        cosine: DVec3::new(at(0.0), at(near), at(far)),
        weight: DVec3::new(1.0 - of_near - of_far, of_near, of_far),
    }
}

fn mean_schlick_weight(c: &VisibleCosines) -> f64 {
    c.weight.dot(c.cosine.to_array().map(schlick_weight).into()).clamp(0.0, 1.0)
}

/// Returns the mean of [`fresnel_deviation`] over visible facets.
pub fn mean_deviation(c: &VisibleCosines, f0: DVec3, index: &ComplexIndex) -> DVec3 {
    (0..3).map(|i| c.weight[i] * fresnel_deviation(f0, index, c.cosine[i])).sum()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::complex_index::{complex_index, fresnel_exact};
    use crate::facets::fresnel::fresnel_schlick;
    use crate::facets::metals::Metal;
    use crate::facets::projected_area::{meso_area, slope_spread};
    use crate::integrals::reference::visible_mean;
    use crate::slopes::grid::normal_of_slope;

    /// Returns the largest and the root mean square error of `mean` against the converged mean of `term`, a function of the cosine.
    fn errors(mean: impl Fn(DVec3, DVec2, DVec3) -> DVec3, term: impl Fn(f64) -> DVec3) -> (f64, f64) {
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
                        let exact = visible_mean(wo, m, s, 10, |x| term(wo.dot(normal_of_slope(x))));
                        let error = (mean(wo, m, s) - exact).abs().max_element();
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
        (worst, rms)
    }

    #[test]
    fn near_the_converged_mean() {
        let f0 = DVec3::splat(0.04);
        let (worst, rms) = errors(|wo, m, s| visible_fresnel(wo, m, s, f0), |c| fresnel_schlick(f0, c));
        assert!(worst < 0.02 && rms < 0.0045);
    }

    /// The exact mean is as near to its converged value as that of Schlick's term, which is farther from the truth.
    #[test]
    fn exact_terms_near_their_converged_mean() {
        let metal = |name| Metal::named(name).unwrap();
        let (gold, chromium) = (metal("gold"), metal("chromium"));
        let glass = (DVec3::splat(0.04), DVec3::ZERO);
        for (f0, tint) in [glass, (gold.f0(), gold.edge_tint()), (chromium.f0(), chromium.edge_tint())] {
            let index = complex_index(f0, tint);
            let truth = |c| fresnel_exact(f0, &index, c);
            let (worst, rms) = errors(|wo, m, s| visible_fresnel_exact(wo, m, s, f0, &index), truth);
            let (schlick, _) = errors(|wo, m, s| visible_fresnel(wo, m, s, f0), truth);
            assert!(worst < 0.02 && rms < 0.0045 && worst < schlick, "{worst} {rms} {schlick}");
        }
    }
}
