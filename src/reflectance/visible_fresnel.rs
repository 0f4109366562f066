//! Mean Fresnel reflectance of the facets that a viewer sees: what a diffuse surface under mirrors does not get.
//!
//! Schlick's term depends on a facet by `wo·wn = (wo.z − wo.xy·x) / |N|`, which varies almost only along the slope that is
//! seen. Three facets of Gauss-Hermite's weights stand for that direction, about the exact visible mean; what lies across it
//! only lengthens `N`, on average by its variance.

use super::fresnel::{grazing_reflectance, schlick_weight};
use super::projected_area::meso_area;
use super::visible_slopes::visible_slopes;
use glam::{DVec2, DVec3};

/// Mean of Schlick's term ([`super::fresnel::fresnel_schlick`]) over the visible facets. `f0`: linear RGB reflectance at normal incidence.
#[must_use]
pub fn visible_fresnel(wo: DVec3, m: DVec2, s: DVec3, f0: DVec3) -> DVec3 {
    let v = visible_slopes(wo, m, s);
    let across = (v.cov.x + v.cov.y - v.variance * v.axis.length_squared()).max(0.0);
    let away = (3.0 * v.variance).sqrt() * v.axis;
    let facet = |i: f64, weight: f64| {
        let slope = v.mean + i * away;
        let cosine = meso_area(wo, slope).max(0.0) / (1.0 + slope.length_squared() + across).sqrt();
        weight * schlick_weight(cosine)
    };
    let mean = facet(-1.0, 1.0 / 6.0) + facet(0.0, 2.0 / 3.0) + facet(1.0, 1.0 / 6.0);
    f0 + (grazing_reflectance(f0) - f0) * mean
}

#[cfg(test)]
mod tests {
    use super::super::fresnel::fresnel_schlick;
    use super::super::projected_area::slope_spread;
    use super::super::reference::visible_mean;
    use super::super::slope_grid::normal_of_slope;
    use super::*;

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
                        // Mesosurfaces behind their silhouette show next to nothing, and that edge-on.
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
        assert!(worst < 0.073 && rms < 0.024);
    }
}
