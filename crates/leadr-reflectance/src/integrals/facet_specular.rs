//! The specular reflection of a light on a relief whose facets each have a rough base in their own frame.
//!
//! A facet of slope `x` with a Beckmann base reflects light from `wi` by microfacets of normal `wh`, which have the slope `u` in the
//! facet's frame. Over relief slopes `N(x; m, S)` the density of these microfacets is
//!
//! ```text
//! D = ∫ N(x; m, S) √(1 + |x|²) exp(−½ (u_a²/v_a + u_b²/v_b)) / (2π √(v_a v_b) c⁴) G dx
//! u = (N·a, N·b)/(N·wh)     c = N·wh/|N|     N = (−x, 1)
//! ```
//!
//! The axes `a` and `b` are unit vectors orthogonal to `wh`: `a` lies in the plane of incidence, and `b` is orthogonal to this plane. Along
//! each axis the base variance `α²/2` and the variance from the light's size add up. When the light rotates, the half vector rotates by
//! half the angle along `a`, and by `1/(2 wo·wh)` of the angle along `b`. `G` is the fraction of a facet's microfacets that are both
//! visible and lit. `G` is 0 for a back-facing facet.
//!
//! A single Gaussian of all microfacets is inaccurate, because the microfacets of a steep facet are tilted even further. For flat relief,
//! the density of the single Gaussian is too low at the centre, and ten times too low at 3.5 standard deviations.
//! ([`add_facet_roughness`](crate::facets::base_roughness::add_facet_roughness) fits this Gaussian for environments.) Near `wh` the
//! integrand is nearly Gaussian. Two steps find a Gaussian close to the integrand, in coordinates `x = m + C z` where the slopes are
//! standard normal. The first step linearises `u` about the facet halfway between the mean facet and `wh`. The second step linearises `u`
//! about the most likely facet that the first step found. Four nodes at √2 deviations integrate the quotient of the integrand and the
//! Gaussian.
//!
//! On steep relief the integrand is not Gaussian in `z`: slopes grow without bound where normals only turn. In coordinates on the plane
//! that touches the sphere of normals at the most likely facet `z₀`, of slope `x₀`, it is nearer to a Gaussian. With `λ = 1`, these
//! coordinates `p` have
//!
//! ```text
//! z = z₀ + p/q     q = 1 − λ g·p     g = Cᵀ x₀/(1 + |x₀|²)     dz = dp/q³
//! ```
//!
//! Any `λ` gives the same integral, and the same Gaussian about `z₀`. The nodes have the smallest error for a `λ` between slopes (0) and
//! the plane (1). The sum is exact if the quotient is a cubic in `p`.
//!
//! `docs/measurements/base-roughness.md` lists the errors relative to converged integrals.

use crate::facets::fresnel::fresnel_schlick;
use crate::facets::projected_area::rough_area;
use crate::limits::{MAX_SLOPE, at_least};
use crate::masking::correlated::{DirectionArea, masking_shadowing_factor, whitened_direction};
use crate::masking::shadowing::Shadowing;
use crate::materials::microfacet::half_vector;
use crate::slopes::grid::slope_at;
use glam::{DVec2, DVec3};
use std::f64::consts::{E, FRAC_1_SQRT_2, PI};

/// The lower bound of z for the sum of the two normals that starts the search.
const LEAST_HALFWAY_Z: f64 = 0.1;
/// The lower bound of the squared cosine between viewer and half vector in the light-size term.
const LEAST_HALF_COSINE2: f64 = 1e-3;

/// The lower bound of the base's slope variance. For smaller variances, the search for the reflecting facet is unreliable.
const LEAST_BASE_VARIANCE: f64 = 1e-8;
/// The lower bound of the cosine between half vector and facet normal. No base has microfacets at larger angles to the facet normal.
const LEAST_FACET_COSINE: f64 = 1e-3;
/// The lower bound of the cosine between half vector and facet normal for the linearisation of `u`.
const LEAST_LINEAR_COSINE: f64 = 0.05;
/// The cosine between facet normal and viewer below which the facets of a normal map on a smooth base fade out.
const LEAST_MAPPED_COSINE: f64 = 0.02;
/// The `λ` of the module documentation, by measurement.
const TOWARDS_PLANE: f64 = 0.7;
/// The lower bound of `q` of the module documentation.
const LEAST_Q: f64 = 0.02;
/// The largest slope of the relief, in standard deviations from the mean.
const MOST_DEVIATIONS: f64 = 50.0;

/// The directions to the light and the viewer, their half vector, and the spread of the base slopes about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetSpecular {
    /// The unit direction towards the viewer, in the tangent frame.
    pub wo: DVec3,
    /// The unit direction towards the light, in the tangent frame.
    pub wi: DVec3,
    /// The unit half vector, in the tangent frame.
    pub wh: DVec3,
    /// A unit vector orthogonal to `wh`, in the plane of incidence.
    pub along: DVec3,
    /// A unit vector orthogonal to `wh` and `along`.
    pub beside: DVec3,
    /// The standard deviations of the base's slopes on the axes `along` and `beside`, including the size of the light.
    pub deviation: DVec2,
    /// The standard deviation of the base's slopes without the size of the light.
    pub base: f64,
}

/// Prepares the lobe of a light. `wo` and `wi` are unit vectors in the tangent frame, and `alpha` is the Beckmann roughness of the base,
/// from 0 to 1. `variance` is the variance of the light's directions in radians², along each of two axes across `wi`.
pub fn facet_specular(wo: DVec3, wi: DVec3, alpha: f64, variance: f64) -> FacetSpecular {
    let wh = half_vector(wo, wi);
    let d = wi - wo;
    let along = if d.length_squared() > 1e-8 {
        d / d.length()
    } else {
        // If `wo` and `wi` coincide, any axis works.
        DVec3::new(wh.z, 1e-6, -wh.x).normalize()
    };
    let cosine = wo.dot(wh);
    let size = 0.25 * variance / DVec2::new(1.0, at_least(cosine * cosine, LEAST_HALF_COSINE2));
    let total = size + at_least(0.5 * alpha * alpha, LEAST_BASE_VARIANCE);
    let deviation = DVec2::new(total.x.sqrt(), total.y.sqrt());
    FacetSpecular { wo, wi, wh, along, beside: wh.cross(along), deviation, base: FRAC_1_SQRT_2 * alpha }
}

/// Returns the fraction of a facet's microfacets that are both visible and lit, by the relief's shadowing model. The fraction fades to 0
/// for back-facing facets.
///
/// `co` and `ci` are the cosines of viewer and light with the facet's normal, `between` is the cosine between `wo` and `wi`, and
/// `deviation` is the standard deviation of the base's slopes. In a normal map only the base hides microfacets. Front-facing facets of a
/// normal map are fully visible, but edge-on facets fade out.
pub fn facet_visibility(shadowing: Shadowing, co: f64, ci: f64, between: f64, deviation: f64) -> f64 {
    let mapped = shadowing == Shadowing::NormalMap;
    let shadowing = if mapped { Shadowing::Correlated } else { shadowing };
    let (so, si) = ((1.0 - co * co).max(0.0).sqrt(), (1.0 - ci * ci).max(0.0).sqrt());
    // These are the components of `wi` in the facet's plane. The first axis points towards the viewer.
    let toward = ((between - co * ci) / at_least(so, 1e-6)).clamp(-si, si);
    let aside = (si * si - toward * toward).max(0.0).sqrt();
    let area = |across: DVec2, sine: f64, cosine: f64| {
        let spread = sine * deviation;
        let visible = cosine.max(0.0) + rough_area(cosine, spread);
        DirectionArea { whitened: across * deviation, spread, meso: cosine, visible }
    };
    let (o, i) = (area(DVec2::new(so, 0.0), so, co), area(DVec2::new(toward, aside), si, ci));
    let seen = if mapped { (co / LEAST_MAPPED_COSINE.max(deviation)).min(1.0) } else { co };
    seen.max(0.0) * masking_shadowing_factor(shadowing, &o, &i)
}

/// A Gaussian distribution of the facets that reflect a light, in coordinates where the relief's slopes are standard normal.
struct ReflectingFacets {
    middle: DVec2,
    /// The inverse covariance `(xx, yy, xy)`.
    inverse: DVec3,
    determinant: f64,
}

/// Computes the Gaussian of the reflecting facets. The microfacet slopes `u` are linearised about the facet of slope `about`.
fn reflecting_facets(f: &FacetSpecular, about: DVec2, m: DVec2, cholesky: DVec3) -> ReflectingFacets {
    let n = (-about).extend(1.0);
    let per = 1.0 / at_least(n.dot(f.wh), LEAST_LINEAR_COSINE * n.length());
    // Compute u at the mean slope and its gradients, in standard deviations of the base.
    let u = DVec2::new(n.dot(f.along), n.dot(f.beside)) * per;
    let along = (u.x * f.wh - f.along) * (per / f.deviation.x);
    let beside = (u.y * f.wh - f.beside) * (per / f.deviation.y);
    let away = (m - about).extend(0.0);
    let at = u / f.deviation + DVec2::new(along.dot(away), beside.dot(away));
    let (a, b) = (whitened_direction(along, cholesky), whitened_direction(beside, cholesky));
    // The precisions of the relief's slopes and of u along both axes add up.
    let inverse = DVec3::new(1.0 + a.x * a.x + b.x * b.x, 1.0 + a.y * a.y + b.y * b.y, a.x * a.y + b.x * b.y);
    let across = a.perp_dot(b);
    let determinant = 1.0 + a.length_squared() + b.length_squared() + across * across;
    let pull = -(a * at.x + b * at.y);
    let middle =
        DVec2::new(inverse.y * pull.x - inverse.z * pull.y, inverse.x * pull.y - inverse.z * pull.x) / determinant;
    let most = DVec2::splat(MOST_DEVIATIONS);
    ReflectingFacets { middle: middle.clamp(-most, most), inverse, determinant }
}

/// Computes the density `D` of the module documentation, per macrosurface area, more accurately than one Gaussian of all microfacets. `m`
/// is the relief's mean slope, and `cholesky` is the lower Cholesky factor of its covariance
/// ([`slope_cholesky`](crate::slopes::grid::slope_cholesky)).
pub fn facet_specular_density(f: &FacetSpecular, m: DVec2, cholesky: DVec3, shadowing: Shadowing) -> f64 {
    let m = m.clamp(DVec2::splat(-MAX_SLOPE), DVec2::splat(MAX_SLOPE));
    let halfway = (-m).extend(1.0).normalize() + f.wh;
    let halfway = halfway.truncate() / -at_least(halfway.z, LEAST_HALFWAY_Z);
    let start = reflecting_facets(f, halfway, m, cholesky).middle;
    let likely = slope_at(start, m, cholesky);
    let found = reflecting_facets(f, likely, m, cholesky);
    let lean = whitened_direction((TOWARDS_PLANE / (1.0 + likely.length_squared()) * likely).extend(0.0), cholesky);

    // The steps are the columns of the covariance's Cholesky factor, times √2.
    let first = DVec2::new(found.inverse.y, -found.inverse.z) * (2.0 / (found.determinant * found.inverse.y)).sqrt();
    let second = DVec2::new(0.0, (2.0 / found.inverse.y).sqrt());
    let sum: f64 = [first, -first, second, -second]
        .into_iter()
        .map(|step| {
            let p = found.middle - start + step;
            let q = 1.0 - lean.dot(p);
            if q <= LEAST_Q {
                return 0.0;
            }
            let z = start + p / q;
            (-0.5 * z.length_squared()).exp() * of_facet(f, slope_at(z, m, cholesky), shadowing) / q.powi(3)
        })
        .sum();
    sum * E / (8.0 * PI * found.determinant.sqrt() * f.deviation.x * f.deviation.y)
}

/// Returns the factor of `N(x; m, S)` in `D`, without `2π √(v_a v_b)`.
fn of_facet(f: &FacetSpecular, slope: DVec2, shadowing: Shadowing) -> f64 {
    let n = (-slope).extend(1.0);
    let length = n.length();
    let cosine = n.dot(f.wh) / length;
    if cosine <= LEAST_FACET_COSINE {
        return 0.0;
    }
    let t = DVec2::new(n.dot(f.along), n.dot(f.beside)) / (length * cosine * f.deviation);
    let seen = facet_visibility(shadowing, n.dot(f.wo) / length, n.dot(f.wi) / length, f.wo.dot(f.wi), f.base);
    // Facets of a normal map are weighted by their area on the macrosurface.
    let area = if shadowing == Shadowing::NormalMap { 1.0 } else { length };
    (-0.5 * t.length_squared()).exp() * seen * area / cosine.powi(4)
}

/// Returns [`facet_specular_density`] for a relief whose facets all have the same slope.
pub fn single_facet_density(f: &FacetSpecular, slope: DVec2, shadowing: Shadowing) -> f64 {
    of_facet(f, slope, shadowing) / (2.0 * PI * f.deviation.x * f.deviation.y)
}

/// Returns the radiance towards the viewer, in linear RGB per unit of the light's irradiance on a plane that faces the light. `o` and `i`
/// are the areas of the relief visible to viewer and light ([`direction_area`](crate::masking::correlated::direction_area)).
pub fn facet_specular_light(
    shadowing: Shadowing,
    o: &DirectionArea,
    i: &DirectionArea,
    f: &FacetSpecular,
    m: DVec2,
    cholesky: DVec3,
    f0: DVec3,
) -> DVec3 {
    let d = facet_specular_density(f, m, cholesky, shadowing);
    fresnel_schlick(f0, f.wi.dot(f.wh)) * (0.25 * d * masking_shadowing_factor(shadowing, o, i))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::base_roughness::add_facet_roughness;
    use crate::facets::beckmann::beckmann_ndf;
    use crate::frame::{frame_about, to_frame};
    use crate::masking::correlated::direction_area;
    use crate::random::Random;
    use crate::slopes::grid::{normal_of_slope, slope_cholesky};

    /// Integrates the `D` of the module documentation by the midpoint rule.
    fn converged(f: &FacetSpecular, m: DVec2, cholesky: DVec3, shadowing: Shadowing, n: u32) -> f64 {
        const REACH: f64 = 7.0;
        let step = 2.0 * REACH / f64::from(n);
        let between = f.wo.dot(f.wi);
        let mut sum = 0.0;
        for k in 0..n * n {
            let z = (DVec2::new(f64::from(k % n), f64::from(k / n)) + 0.5) * step - REACH;
            let facet = (-slope_at(z, m, cholesky)).extend(1.0);
            let normal = facet.normalize();
            let c = normal.dot(f.wh);
            let seen = facet_visibility(shadowing, normal.dot(f.wo), normal.dot(f.wi), between, f.base);
            if c > 0.0 && seen > 0.0 {
                let u = DVec2::new(normal.dot(f.along), normal.dot(f.beside)) / (c * f.deviation);
                let exponent = -0.5 * (z.length_squared() + u.length_squared());
                sum += exponent.exp() * seen * facet.length() / c.powi(4);
            }
        }
        sum * step * step / (4.0 * PI * PI * f.deviation.x * f.deviation.y)
    }

    fn direction(r: &mut Random) -> DVec3 {
        let (z, phi) = (r.range(0.1, 1.0), r.range(0.0, std::f64::consts::TAU));
        let side = (1.0 - z * z).sqrt();
        DVec3::new(side * phi.cos(), side * phi.sin(), z)
    }

    /// Compares the density with the converged integral, for several slope deviations along each axis. The error of a single Gaussian of
    /// all microfacets is three to nine times as large.
    #[test]
    #[ignore = "long"]
    fn four_facets_are_near_the_integral() {
        for (deviations, bound) in
            [((0.03, 0.1), 0.02), ((0.1, 0.3), 0.02), ((0.3, 0.6), 0.03), ((0.6, 1.0), 0.06), ((1.0, 2.5), 0.25)]
        {
            let (mut r, mut errors, mut one_gaussian, mut all) = (Random(3), 0.0, 0.0, 0.0);
            for _ in 0..200 {
                let (x, y) = (r.log(deviations.0, deviations.1), r.log(deviations.0, deviations.1));
                let s = DVec3::new(x * x, y * y, r.range(-0.8, 0.8) * x * y);
                let m = DVec2::new(r.range(-0.5, 0.5), r.range(-0.5, 0.5));
                let alpha = r.log(0.1, 0.8);
                let (wo, wi) = (direction(&mut r), direction(&mut r));
                let (f, cholesky) = (facet_specular(wo, wi, alpha, 0.0), slope_cholesky(s));
                let factor = |s: DVec3| {
                    let [o, i] = [wo, wi].map(|w| direction_area(w, m, slope_cholesky(s)));
                    masking_shadowing_factor(Shadowing::Correlated, &o, &i)
                };
                let truth = factor(s) * converged(&f, m, cholesky, Shadowing::Correlated, 200);
                let got = factor(s) * facet_specular_density(&f, m, cholesky, Shadowing::Correlated);
                let one_lobe = add_facet_roughness(s, alpha, wo, m);
                errors += (got - truth).powi(2);
                one_gaussian += (beckmann_ndf(f.wh, m, one_lobe) * factor(one_lobe) - truth).powi(2);
                all += truth * truth;
            }
            let [got, before] = [errors, one_gaussian].map(|e| (e / all).sqrt());
            println!("{deviations:?}: {got:.4}, one Gaussian {before:.4}");
            assert!(got < bound && before > 2.5 * got, "{deviations:?}: {got}, {before}");
        }
    }

    /// Without relief the density is the base's density on a facet of slope `m`.
    #[test]
    fn a_smooth_surface_has_the_specular_term_of_its_base() {
        let mut r = Random(5);
        for _ in 0..1000 {
            let (wo, wi, alpha) = (direction(&mut r), direction(&mut r), r.log(0.02, 1.0));
            let f = facet_specular(wo, wi, alpha, 0.0);
            let flat = DVec2::ZERO;
            let s = DVec3::new(0.5 * alpha * alpha, 0.5 * alpha * alpha, 0.0);
            let [o, i] = [wo, wi].map(|w| direction_area(w, flat, slope_cholesky(s)));
            let want = beckmann_ndf(f.wh, flat, s) * wo.z * masking_shadowing_factor(Shadowing::Correlated, &o, &i);
            let got = facet_specular_density(&f, flat, DVec3::ZERO, Shadowing::Correlated);
            assert!((got - want).abs() < 1e-9 * want + 1e-200, "{got} {want}");
            // The expected value is the density of the base in the frame of the tilted facet, per macrosurface area.
            let m = DVec2::new(r.range(-0.7, 0.7), r.range(-0.7, 0.7));
            let frame = frame_about(normal_of_slope(m));
            let local = facet_specular(to_frame(&frame, wo), to_frame(&frame, wi), alpha, 0.0);
            let on_facet = facet_specular_density(&local, flat, DVec3::ZERO, Shadowing::Correlated);
            let want = on_facet * (1.0 + m.length_squared()).sqrt();
            let got = facet_specular_density(&f, m, DVec3::ZERO, Shadowing::Correlated);
            let single = single_facet_density(&f, m, Shadowing::Correlated);
            assert!((got - want).abs().max((single - want).abs()) < 1e-9 * want + 1e-200, "{got} {single} {want}");
        }
    }

    /// For a light of finite size, the density is the mean over the directions of the light.
    #[test]
    fn lights_have_a_size() {
        let (m, s, alpha) = (DVec2::new(0.1, -0.2), DVec3::new(0.02, 0.04, 0.01), 0.15);
        let cholesky = slope_cholesky(s);
        let deviation = 0.12;
        let mut worst = 0.0f64;
        for (wo, wi) in [
            (DVec3::new(0.3, 0.0, 1.0), DVec3::new(-0.3, 0.4, 1.0)),
            (DVec3::new(1.0, 0.0, 1.0), DVec3::new(-1.0, 0.4, 1.0)),
            (DVec3::new(2.0, 0.0, 1.0), DVec3::new(-2.0, 0.5, 1.0)),
        ] {
            let (wo, wi) = (wo.normalize(), wi.normalize());
            let (x, y) = wi.any_orthonormal_pair();
            let density = |wi, variance| {
                facet_specular_density(&facet_specular(wo, wi, alpha, variance), m, cholesky, Shadowing::Smith)
            };
            let (mut sum, mut weights) = (0.0, 0.0);
            for j in -20..=20 {
                for k in -20..=20 {
                    let d = DVec2::new(f64::from(j), f64::from(k)) * 0.2;
                    let weight = (-0.5 * d.length_squared()).exp();
                    sum += weight * density((wi + (x * d.x + y * d.y) * deviation).normalize(), 0.0);
                    weights += weight;
                }
            }
            let (truth, point) = (sum / weights, density(wi, 0.0));
            let got = density(wi, deviation * deviation);
            worst = worst.max((got / truth - 1.0).abs());
            assert!((point / truth - 1.0).abs() > 0.02, "the size of the light must matter: {point} {truth}");
        }
        assert!(worst < 0.04, "{worst}");
    }

    #[test]
    fn any_argument_has_a_finite_density() {
        let mut r = Random(9);
        for _ in 0..20_000 {
            let d = |r: &mut Random| DVec3::new(r.range(-1.0, 1.0), r.range(-1.0, 1.0), r.range(-1.0, 1.0)).normalize();
            let (wo, wi) = (d(&mut r), d(&mut r));
            let (x, y) = (r.log(1e-6, 30.0), r.log(1e-6, 30.0));
            let s = DVec3::new(x * x, y * y, r.range(-1.0, 1.0) * x * y);
            let m = DVec2::new(r.range(-8.0, 8.0), r.range(-8.0, 8.0));
            let wi = if r.unit() < 0.1 { -wo } else { wi };
            let f = facet_specular(wo, wi, r.range(0.0, 1.0).powi(4), r.log(1e-9, 0.1));
            let density = facet_specular_density(&f, m, slope_cholesky(s), Shadowing::Correlated);
            assert!(density.is_finite() && density >= 0.0, "{density}");
        }
    }
}
