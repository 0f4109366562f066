//! The part of a specular lobe that Schlick's weight multiplies.
//!
//! Schlick's weight `k⁵` is large on facets that are nearly edge-on to the viewer, and such facets reflect directions just above the
//! horizon of the mesosurface, or below it, where nothing is lit. Few nodes of a rule lie there, so rules with few probes misjudge this
//! part by 10 to 15 % on a dielectric at 75°. A quadrature along the view azimuth alone needs no lookup and is more exact. With the
//! coordinate `u` of [`super::slopes`], the part is
//!
//! ```text
//! W = ∫ φ(u) (ν − u) k⁵ lit du / H,   u from −3 to min(ν, u_h, 3)
//! ```
//!
//! Here `u_h` belongs to the facets that reflect the horizon. On the line `m + axis u`, `up·wi = 0` is the quadratic equation
//! `2 (a − b u)(p − q u) = (up·wo) |N|²`, with `p = up·(−m, 1)` and `q = up.xy·axis`. The slopes across the azimuth, of variance `rest`,
//! lengthen `N`, and lower the reflected directions. A facet one standard deviation to the side has the mean of these heights.
//!
//! The mean of the reflected directions over the same density is the direction of the lookup. Directions of variance `σ²` per axis have a
//! mean of length `exp(−σ²)`, which gives the variance.

use super::shadowed_specular::{HORIZON_DEVIATIONS, NARROWEST};
use super::slopes::VisibleSlopes;
use crate::facets::fresnel::schlick_weight;
use crate::facets::normal_distribution::normal_pdf;
use crate::masking::correlated::{direction_area, lit_fraction};
use crate::masking::shadowing::Shadowing;
use crate::quadrature::gauss_legendre;
use crate::slopes::grid::slope_cholesky;
use glam::{DVec3, Vec3Swizzles as _};

/// The number of nodes of the quadrature.
const NODES: usize = 6;
/// The largest deviation of the slopes in the quadrature, in standard deviations.
const REACH: f64 = 3.0;

/// The light that Schlick's weight multiplies, as one lookup.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct GrazingLobe {
    /// The mean of Schlick's weight times the lit fraction over the visible facets, from 0 to 1.
    pub weight: f64,
    /// The unit mean direction that these facets reflect.
    pub wi: DVec3,
    /// The variance of the lookup per axis, in radians², below 2.
    pub variance: f64,
    /// The variance of the reflected directions per axis, in radians². The fraction that larger bumps let through is concave in the height
    /// of the direction, so its mean needs two directions, one standard deviation above and below `wi`.
    pub spread: f64,
}

/// Returns the `u` of the facets that reflect the horizon of the mesosurface with the normal `up`. `rest` is the variance across the azimuth.
fn horizon_slope(wo: DVec3, v: &VisibleSlopes, up: DVec3, rest: f64) -> f64 {
    let height = up.dot(wo);
    let (p, q) = (up.z - up.xy().dot(v.m), up.xy().dot(v.axis));
    let b = v.b * p + v.a * q + height * v.m.dot(v.axis);
    let c = 2.0 * v.a * p - height * (1.0 + v.m.length_squared() + rest);
    let a = 2.0 * v.b * q - height * v.axis.length_squared();
    c / (b + (b * b - a * c).max(0.0).sqrt()).max(1e-6)
}

/// Returns the grazing part of the lobe with the visible slopes `v`, of which `base_variance` per axis belongs to the base. The facets of the
/// base hide each other, and the mesosurface with the unit normal `up` hides what lies below it. The caller multiplies the fraction that
/// larger bumps let through.
pub fn grazing_lobe(shadowing: Shadowing, wo: DVec3, v: &VisibleSlopes, up: DVec3, base_variance: f64) -> GrazingLobe {
    let base = slope_cholesky(DVec3::new(base_variance, base_variance, 0.0));
    let o = direction_area(wo, v.m, base);
    let per_b = 1.0 / v.b.max(1e-6);
    let nu = v.a * per_b;
    let rest = (v.s.x + v.s.y - v.axis.length_squared()).max(0.0);
    // Given `u`, the slopes vary orthogonally to the azimuth.
    let aside = wo.xy().perp() * (rest / wo.xy().length_squared().max(1e-12)).sqrt();
    let highest = nu.min(horizon_slope(wo, v, up, rest)).min(REACH);
    let lowest = (highest - REACH).min(-REACH);
    let (mut sum, mut weights) = (DVec3::ZERO, 0.0);
    for (x, w) in gauss_legendre(NODES) {
        let u = lowest + (highest - lowest) * (0.5 + 0.5 * x);
        let slope = v.m + v.axis * u;
        let per = 1.0 / (1.0 + slope.length_squared() + rest);
        let facet = (v.a - v.b * u).max(0.0);
        let beside = DVec3::new(-slope.x - aside.x, -slope.y - aside.y, 1.0);
        let wi = 2.0 * wo.dot(beside).max(0.0) * per * beside - wo;
        let lit = lit_fraction(shadowing, &o, &direction_area(wi, v.m, base));
        let weight = 0.5 * w * normal_pdf(u) * (nu - u).max(0.0) * schlick_weight(facet * per.sqrt()) * lit;
        sum += weight * (2.0 * facet * per * DVec3::new(-slope.x, -slope.y, 1.0) - wo);
        weights += weight;
    }
    let square = sum.length_squared();
    let wi = sum / square.max(1e-30).sqrt();
    let spread = -0.5 * (square / (weights * weights).max(1e-30)).clamp(1e-4, 1.0).ln();
    let variance = spread / (1.0 + 0.5 * spread);
    let widest = up.dot(wi).max(0.0) / HORIZON_DEVIATIONS;
    GrazingLobe {
        weight: (weights * (highest - lowest) / (v.area * per_b).max(1e-9)).min(1.0),
        wi,
        variance: (widest * widest).min(variance).max(NARROWEST * variance),
        spread,
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::projected_area::meso_area;
    use crate::integrals::reference::visible_mean;
    use crate::slopes::grid::normal_of_slope;
    use crate::visible::slopes::visible_slopes;
    use glam::DVec2;

    #[test]
    fn weight_and_direction_are_those_of_the_integral() {
        let (mut worst, mut square, mut count, mut turned) = (0.0f64, 0.0, 0.0, 0.0f64);
        for degrees in [20.0f64, 45.0, 60.0, 75.0, 85.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let wo = DVec3::new(sin * 0.8, sin * 0.6, cos);
            for base in [0.1f64, 0.25, 0.4] {
                for (m, relief) in [
                    (DVec2::ZERO, DVec3::ZERO),
                    (DVec2::new(0.2, -0.1), DVec3::ZERO),
                    (DVec2::ZERO, DVec3::new(0.01, 0.01, 0.0)),
                    (DVec2::new(0.1, 0.1), DVec3::new(0.05, 0.01, -0.01)),
                ] {
                    let variance = base * base;
                    let s = relief + DVec3::new(variance, variance, 0.0);
                    let cholesky = slope_cholesky(DVec3::new(variance, variance, 0.0));
                    let o = direction_area(wo, m, cholesky);
                    let reflected = |x: DVec2| {
                        let n = normal_of_slope(x);
                        let (cosine, wi) = (wo.dot(n).max(0.0), 2.0 * wo.dot(n) * n - wo);
                        let lit = lit_fraction(Shadowing::Correlated, &o, &direction_area(wi, m, cholesky));
                        (if wi.z > 0.0 && meso_area(wi, m) > 0.0 { lit * schlick_weight(cosine) } else { 0.0 }, wi)
                    };
                    let exact = visible_mean(wo, m, s, 30, |x| DVec3::splat(reflected(x).0)).x;
                    let mean = visible_mean(wo, m, s, 30, |x| reflected(x).0 * reflected(x).1);
                    let found = grazing_lobe(Shadowing::Correlated, wo, &visible_slopes(wo, m, s), DVec3::Z, variance);
                    let error = (found.weight - exact).abs();
                    square += error * error;
                    count += 1.0;
                    worst = worst.max(error);
                    if exact > 0.01 {
                        turned = turned.max(found.wi.angle_between(mean).to_degrees());
                    }
                    println!("{degrees}° {base} {m} {relief}: {:.4} {exact:.4}, {:.4}", found.weight, found.variance);
                }
            }
        }
        println!("worst {worst:.4}, rms {:.4}, turned by {turned:.2}°", f64::sqrt(square / count));
        assert!(worst < 0.003 && f64::sqrt(square / count) < 0.001 && turned < 1.5);
    }
}
