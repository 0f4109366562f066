//! The visible slopes of a normal map on smooth geometry. The facets of a normal map do not occlude each other, so the weight of a facet is
//! its fraction of the macrosurface, for any orientation (the normal map model of thesis section 2.1 and Table 2.IV).
//!
//! A facet of a displaced surface has the visible projected area `a − b u`, where `u` is its slope along the view azimuth in standard
//! deviations. In a normal map, all front-facing facets (`u < ν = a/b`) have equal weight. Back-facing facets are black, because `⟨wo, wm⟩`
//! is clamped at 0. Along `u`, the visible slopes have a normal density truncated at `ν`. With `λ = φ(ν)/Φ(ν)`, the cumulants of this
//! density are
//!
//! ```text
//! E[u] = −λ,   Var[u] = 1 + λ′,   κ₃[u] = −λ″,   κ₄[u] = λ‴,   where λ′ = −λ (ν + λ)
//! ```
//!
//! The base of a facet is rough geometry, so its microfacets are visible by projected area. The base has the slopes of
//! [`visible_slopes`](super::slopes) on the mean front-facing facet. Map and base are independent, so their cumulants add up. Without a
//! map, the sum describes the base's visible slopes. Without a base, it describes the truncated normal density.
//!
//! Diffuse light does not depend on the viewer, so the moments of normals are those of [`visible_diffuse_moments`](super::diffuse) without
//! a clamp. For one light, the clamped cosine needs one clamped mean instead of a product of two.

use super::diffuse::{clamped_mean, damped_gaussian, squared_normal_spread, visible_diffuse_terms};
use super::fresnel::{mean_deviation, visible_cosines, visible_schlick_weight};
use super::slopes::{VISIBLE_TAIL, VisibleSlopes, tilted_area, visible_cumulants};
use crate::facets::beckmann::beckmann_ndf;
use crate::facets::complex_index::ComplexIndex;
use crate::facets::fresnel::{fresnel_schlick, grazing_reflectance};
use crate::facets::normal_distribution::{mills_ratio, normal_cdf, normal_pdf, normal_ramp};
use crate::facets::projected_area::{face_viewer, meso_area, slope_spread, spread_along};
use crate::integrals::diffuse::NormalMoments;
use crate::limits::{MIN_AREA, at_least};
use crate::masking::variants::half_facet_area;
use crate::materials::microfacet::half_vector;
use crate::slopes::statistics::{clamp_covariance, outer_square};
use glam::{DVec2, DVec3, Vec3Swizzles as _};
use std::f64::consts::PI;

/// The lower bound of the slope deviation along the view azimuth, which limits the sharpness of the front-facing edge.
const LEAST_TURN: f64 = 1e-4;

/// The visible slopes of a normal map and its base.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MappedSlopes {
    /// The slopes of front-facing specular facets. The field `area` holds the kernel factor of
    /// [`mapped_probes`](super::specular::mapped_probes).
    pub slopes: VisibleSlopes,
    /// The fraction of facets that are front-facing.
    pub facing: f64,
    /// The fraction of the total slope variance that comes from the normal map.
    pub relief: f64,
}

/// Returns the ratio of the normal density to its integral up to `nu`.
fn lambda_at(nu: f64) -> f64 {
    if nu < 0.0 { 1.0 / mills_ratio(-nu) } else { normal_pdf(nu) / normal_cdf(nu) }
}

/// The lower bound of `nu` for [`fourth_cumulant`]. Below it, so few facets are front-facing that they need no precise shape.
const LEAST_FOURTH: f64 = -4.0;

/// Returns the fourth cumulant of a normal density truncated at `nu`.
fn fourth_cumulant(nu: f64) -> f64 {
    let nu = nu.clamp(LEAST_FOURTH, 40.0);
    let lambda = lambda_at(nu);
    let first = -lambda * (nu + lambda);
    let second = -lambda - (nu + 2.0 * lambda) * first;
    -2.0 * first * (1.0 + first) - (nu + 2.0 * lambda) * second
}

/// Returns the visible slopes of a normal map for the unit vector `wo`. `m` and `relief` are the mean and the covariance of the map's
/// slopes. `all` is the covariance including the base.
pub fn mapped_slopes(wo: DVec3, m: DVec2, relief: DVec3, all: DVec3) -> MappedSlopes {
    let (r, s) = (clamp_covariance(relief), clamp_covariance(all));
    let base = clamp_covariance(s - r);
    // Compute the slopes of the normal map.
    let (across_r, br) = spread_along(wo, r);
    let facing = normal_cdf(meso_area(wo, m) / br.max(LEAST_TURN));
    let a = tilted_area(wo, m, br);
    let m = face_viewer(wo, m, r, 2.0 * VISIBLE_TAIL);
    let nu = (a / br.max(1e-18)).min(1e6);
    let lambda = lambda_at(nu);
    let variance_r = (1.0 - nu.min(40.0) * lambda - lambda * lambda).clamp(0.02, 1.0);
    let nu_here = nu.min(40.0);
    let third_r = (-lambda * (2.0 * lambda * lambda + 3.0 * nu_here * lambda + nu_here * nu_here - 1.0)).min(0.0);
    let facet_r = at_least(a + br * lambda, 1e-3);
    // Compute the slopes of the base on the mean facet.
    let (across_b, bb) = spread_along(wo, base);
    let n = normal_ramp(facet_r / bb.max(1e-18));
    let u = visible_cumulants((facet_r / bb.max(1e-18)).min(1e6), &n);
    let area_b = if bb <= 1e-18 { facet_r } else { bb * n.ramp };
    // Combine the slopes of map and base.
    let b = (br * br + bb * bb).sqrt();
    let (part_r, part_b) = (br / b.max(1e-18), bb / b.max(1e-18));
    let (axis_r, axis_b) = (across_r / br.max(1e-18), across_b / bb.max(1e-18));
    let facet = facet_r + bb * u.shift;
    let variance = part_r * part_r * variance_r + part_b * part_b * u.variance;
    let third = part_r.powi(3) * third_r + part_b.powi(3) * u.third;
    MappedSlopes {
        slopes: VisibleSlopes {
            m,
            s,
            a,
            b,
            area: normal_cdf(nu) * area_b,
            axis: (across_r + across_b) / b.max(1e-18),
            shift: part_r * lambda + part_b * u.shift,
            mean: m - axis_r * lambda - axis_b * u.shift,
            cov: s - (1.0 - variance_r) * outer_square(axis_r) - (1.0 - u.variance) * outer_square(axis_b),
            facet,
            variance: if b <= 1e-18 { 1.0 } else { variance.clamp(0.02, 1.0) },
            third,
            fourth: part_r.powi(4) * fourth_cumulant(nu) + part_b.powi(4) * u.fourth,
        },
        facing,
        relief: ((r.x + r.y) / (s.x + s.y).max(1e-18)).clamp(0.0, 1.0),
    }
}

/// Returns the mean Fresnel reflectance of all facets. Back-facing facets have a cosine of 0. `f0` is the linear RGB reflectance at normal
/// incidence.
pub fn mapped_fresnel(v: &MappedSlopes, f0: DVec3) -> DVec3 {
    f0 + (grazing_reflectance(f0) - f0) * (1.0 + v.facing * (visible_schlick_weight(&v.slopes) - 1.0))
}

/// Returns the mean of the exact reflectance of all facets ([`fresnel_exact`](crate::facets::complex_index::fresnel_exact)).
pub fn mapped_fresnel_exact(v: &MappedSlopes, f0: DVec3, index: &ComplexIndex) -> DVec3 {
    let deviation = v.facing * mean_deviation(&visible_cosines(&v.slopes), f0, index);
    (mapped_fresnel(v, f0) + deviation).clamp(DVec3::ZERO, DVec3::ONE)
}

/// Returns the moments of all normals, like [`visible_diffuse_moments`](super::diffuse::visible_diffuse_moments) for visible normals.
/// `terms` is 2 or 3.
pub fn mapped_diffuse_moments(m: DVec2, s: DVec3, terms: u32) -> NormalMoments {
    let s = clamp_covariance(s);
    let spread = squared_normal_spread(m, s);
    let (mut first, mut diag, mut off) = (DVec3::ZERO, DVec3::ZERO, DVec3::ZERO);
    for term in visible_diffuse_terms(terms) {
        let [t, c, d] = [term.exponent, term.first, term.second].map(|[value, slope]| value + slope * spread.y);
        let g = damped_gaussian(m, s, t / spread.x);
        first += g.weight * c * DVec3::new(-g.m.x, -g.m.y, 1.0);
        diag += g.weight * d * (g.m * g.m + g.s.xy()).extend(1.0);
        off += g.weight * d * DVec3::new(-g.m.y, -g.m.x, g.m.x * g.m.y + g.s.z);
    }
    // The second moments have trace one.
    let scale = 1.0 / diag.element_sum().max(1e-30);
    NormalMoments { mean: first / spread.x.sqrt(), diag: diag * scale, off: off * scale }
}

/// Returns the radiance per unit of albedo, under one light from `wi` that has unit irradiance on a plane facing it. The clamped cosine is
/// averaged over all facets. `terms` is 2 or 3.
pub fn mapped_diffuse_light(wi: DVec3, m: DVec2, s: DVec3, terms: u32) -> f64 {
    let s = clamp_covariance(s);
    let spread = squared_normal_spread(m, s);
    let sum: f64 = visible_diffuse_terms(terms)
        .iter()
        .map(|term| {
            let [t, c] = [term.exponent, term.first].map(|[value, slope]| value + slope * spread.y);
            let g = damped_gaussian(m, s, t / spread.x);
            g.weight * c * clamped_mean(meso_area(wi, g.m), slope_spread(wi, g.s))
        })
        .sum();
    sum / (spread.x.sqrt() * PI)
}

/// Returns the specular radiance towards `wo` under one light from `wi`, per unit of the light's irradiance on a plane that faces the
/// light. The slopes have the mean `m` and the covariance `s`. The result is the normal map term of thesis Table 2.IV, `F D / (4 f)`, where
/// `f` is the projected area of the reflecting facet ([`half_facet_area`]). The base is treated as part of the map.
pub fn mapped_specular_light(wo: DVec3, wi: DVec3, m: DVec2, s: DVec3, f0: DVec3) -> DVec3 {
    let wh = half_vector(wo, wi);
    let facet = half_facet_area(wo, wi, wh).max(MIN_AREA);
    fresnel_schlick(f0, wi.dot(wh)) * (0.25 * beckmann_ndf(wh, m, s) / facet)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrals::reference::visible_mean;
    use crate::quadrature::composite_gauss;
    use crate::slopes::grid::{normal_of_slope, slope_at, slope_cholesky};
    use crate::visible::slopes::visible_slopes;

    /// Returns the brute-force mean over all slopes of a normal map. `g` may jump where facets become back-facing.
    fn mean(m: DVec2, s: DVec3, g: impl Fn(DVec2) -> DVec3) -> DVec3 {
        let cholesky = slope_cholesky(s);
        let nodes = composite_gauss(-7.5, 7.5, 90, 4);
        let mut sum = DVec3::ZERO;
        for &(u, wu) in &nodes {
            for &(v, wv) in &nodes {
                let weight = wu * wv * normal_pdf(u) * normal_pdf(v);
                sum += weight * g(slope_at(DVec2::new(u, v), m, cholesky));
            }
        }
        sum
    }

    const CASES: [(f64, [f64; 2], [f64; 3]); 5] = [
        (0.0, [0.2, -0.1], [0.3, 0.1, 0.05]),
        (45.0, [0.0, 0.0], [0.04, 0.04, 0.0]),
        (60.0, [-0.2, 0.3], [0.5, 0.2, 0.1]),
        (75.0, [0.1, 0.1], [1.0, 1.0, 0.0]),
        (82.0, [0.0, 0.2], [0.2, 0.6, -0.1]),
    ];

    fn case((degrees, m, s): (f64, [f64; 2], [f64; 3])) -> (DVec3, DVec2, DVec3) {
        let (sin, cos) = degrees.to_radians().sin_cos();
        (DVec3::new(sin * 0.8, sin * 0.6, cos), m.into(), s.into())
    }

    #[test]
    fn moments_are_those_of_the_facets_that_face_the_viewer() {
        for (wo, m, s) in CASES.map(case) {
            let v = mapped_slopes(wo, m, s, s);
            let faces = |x: DVec2| if meso_area(wo, x) > 0.0 { 1.0 } else { 0.0 };
            let facing = mean(m, s, |x| DVec3::splat(faces(x))).x;
            assert!((v.facing - facing).abs() < 3e-3, "{} {facing}", v.facing);
            let middle = mean(m, s, |x| (x * faces(x)).extend(0.0)).xy() / facing;
            assert!((v.slopes.mean - middle).length() < 0.01, "{} {middle}", v.slopes.mean);
            let second = mean(m, s, |x| {
                let d = x - v.slopes.mean;
                faces(x) * DVec3::new(d.x * d.x, d.y * d.y, d.x * d.y)
            }) / facing;
            assert!((v.slopes.cov - second).length() < 0.01, "{} {second}", v.slopes.cov);
            let along = |x: DVec2| (x - v.slopes.mean).dot(wo.xy()) / v.slopes.b.max(1e-9);
            let power = |n: i32| mean(m, s, |x| DVec3::splat(faces(x) * along(x).powi(n))).x / facing;
            if v.slopes.b < 1e-6 {
                continue;
            }
            let third = power(3);
            assert!((v.slopes.third - third).abs() < 0.02, "{} {third}", v.slopes.third);
            let fourth = power(4) - 3.0 * power(2) * power(2);
            assert!((v.slopes.fourth - fourth).abs() < 0.03, "{} {fourth}", v.slopes.fourth);
        }
    }

    #[test]
    fn unmapped_base_uses_visible_slopes() {
        for (wo, m, s) in CASES.map(case) {
            let s = DVec3::new(s.x, s.y, 0.0);
            let (v, visible) = (mapped_slopes(wo, m, DVec3::ZERO, s), visible_slopes(wo, m, s));
            let MappedSlopes { slopes, facing, relief, .. } = v;
            assert!((facing - 1.0).abs() < 1e-9 && relief == 0.0);
            assert!((slopes.mean - visible.mean).length() < 1e-9 && (slopes.cov - visible.cov).length() < 1e-9);
            assert!((slopes.area - visible.area).abs() < 1e-9 && (slopes.facet - visible.facet).abs() < 1e-9);
        }
    }

    #[test]
    fn fresnel_is_near_the_mean_over_all_facets() {
        let f0 = DVec3::splat(0.04);
        for (wo, m, s) in CASES.map(case) {
            let exact = mean(m, s, |x| fresnel_schlick(f0, wo.dot(normal_of_slope(x)).max(0.0))).x;
            let found = mapped_fresnel(&mapped_slopes(wo, m, s, s), f0).x;
            println!("{found:.4} {exact:.4}");
            assert!((found - exact).abs() < 0.025, "{found} {exact}");
        }
    }

    #[test]
    fn diffuse_light_is_that_of_all_facets() {
        let (mut worst, mut worst_moments) = (0.0f64, 0.0f64);
        for (wi, m, s) in CASES.map(case) {
            let exact = mean(m, s, |x| DVec3::splat(wi.dot(normal_of_slope(x)).max(0.0))).x;
            worst = worst.max((mapped_diffuse_light(wi, m, s, 3) * PI - exact).abs());
            let moments = mapped_diffuse_moments(m, s, 3);
            let first = mean(m, s, normal_of_slope);
            let second = mean(m, s, |x| normal_of_slope(x) * normal_of_slope(x));
            let off = mean(m, s, |x| {
                let n = normal_of_slope(x);
                DVec3::new(n.y * n.z, n.x * n.z, n.x * n.y)
            });
            let error = (moments.mean - first).length() + (moments.diag - second).length();
            worst_moments = worst_moments.max(error + (moments.off - off).length());
        }
        println!("light {worst:.5}, moments {worst_moments:.5}");
        assert!(worst < 2e-3 && worst_moments < 0.02, "{worst} {worst_moments}");
        // On displaced surfaces, by contrast, facets that face the viewer have more weight.
        let (wo, m, s) = case(CASES[3]);
        let seen = visible_mean(wo, m, s, 20, |x| DVec3::splat(wo.dot(normal_of_slope(x)).max(0.0))).x;
        assert!(seen > 1.2 * mapped_diffuse_light(wo, m, s, 3) * PI, "{seen}");
    }

    /// In a white environment, the reflected radiance equals the fraction of front-facing facets.
    #[test]
    fn white_room_shows_the_visible_fraction() {
        for (wo, m, s) in CASES.map(case).into_iter().take(4) {
            let mut sum = 0.0;
            let (thetas, phis) = (composite_gauss(0.0, PI, 120, 4), composite_gauss(0.0, 2.0 * PI, 120, 4));
            for &(theta, wt) in &thetas {
                for &(phi, wp) in &phis {
                    let wi = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
                    sum += wt * wp * theta.sin() * mapped_specular_light(wo, wi, m, s, DVec3::ONE).x;
                }
            }
            let facing = mapped_slopes(wo, m, s, s).facing;
            println!("{sum:.4} {facing:.4}");
            assert!((sum - facing).abs() < 0.02, "{sum} {facing}");
        }
    }
}
