//! A clear coat: a dielectric layer over a base material, with its own relief and roughness, as in `KHR_materials_clearcoat`.
//!
//! The coat reflects a fraction of the light, and the rest reaches the base. A fraction of the light that leaves the base is reflected back
//! to the base. The layer is thin, so all its light leaves at the point of entry, and light keeps its direction in the layer. With the
//! reflectance `o` of the coat toward the viewer, `i` toward the light, `r` from below, and the reflectance `b` of the base, the base adds
//!
//! ```text
//! (1 − o) (1 − i) b (1 + r b + (r b)² + …) = (1 − o) (1 − i) b / (1 − r b)
//! ```
//!
//! A white base (`b = 1`) with `i = r` therefore returns all the light that the coat does not reflect, which is `1 − o`. All reflectances
//! are means over the visible facets of the coat ([`visible_fresnel`]). Under a light, they are means over the facets that the viewer and
//! the light both see: the visible slopes of one of them are the slopes that the other sees.

use super::fresnel::{visible_fresnel, visible_fresnel_exact};
use super::slopes::visible_slopes;
use crate::facets::complex_index::ComplexIndex;
use crate::facets::fresnel::{fresnel_dielectric, fresnel_schlick};
use glam::{DVec2, DVec3};

/// The reflectance of the coat at normal incidence, for an index of refraction of 1.5.
pub const COAT_F0: f64 = 0.04;

/// The index of refraction of the coat.
const COAT_INDEX: f64 = 1.5;

/// Returns the reflectance of the coat toward `w`. The slopes of the coat have the mean `m` and the covariance `s`, which includes the
/// roughness of the coat. `weight` is the covered fraction of the surface, 0 to 1. `exact` is whether the Fresnel term is exact, otherwise
/// Schlick's.
pub fn coat_reflectance(w: DVec3, m: DVec2, s: DVec3, weight: f64, exact: bool) -> f64 {
    let f0 = DVec3::splat(COAT_F0);
    let index = ComplexIndex { eta: DVec3::splat(COAT_INDEX), k: DVec3::ZERO };
    weight * if exact { visible_fresnel_exact(w, m, s, f0, &index) } else { visible_fresnel(w, m, s, f0) }.x
}

/// Returns the reflectance of one facet of the coat, seen at this cosine.
pub fn coat_facet_reflectance(cosine: f64, weight: f64, exact: bool) -> f64 {
    let schlick = fresnel_schlick(DVec3::splat(COAT_F0), cosine).x;
    weight * if exact { fresnel_dielectric(cosine.max(0.0), COAT_INDEX) } else { schlick }
}

/// Returns the mean reflectance of the coat over the hemisphere, weighted by the cosine: the reflectance for diffuse light.
pub fn coat_average(weight: f64, exact: bool) -> f64 {
    coat_bands(weight, exact).x
}

/// Returns the reflectances of the coat toward `wo` and `wi`, over the facets that are visible from both.
pub fn coat_reflectances(wo: DVec3, wi: DVec3, m: DVec2, s: DVec3, weight: f64, exact: bool) -> DVec2 {
    let (from_viewer, from_light) = (visible_slopes(wo, m, s), visible_slopes(wi, m, s));
    DVec2::new(
        coat_reflectance(wo, from_light.mean, from_light.cov, weight, exact),
        coat_reflectance(wi, from_viewer.mean, from_viewer.cov, weight, exact),
    )
}

/// Returns the reflectance of the coat for the spherical harmonics of orders 0, 1 and 2 of an environment: the ratio between the
/// coefficients of `F(c) c` and of the cosine `c`. The first is [`coat_average`].
pub fn coat_bands(weight: f64, exact: bool) -> DVec3 {
    let schlick = COAT_F0 + (1.0 - COAT_F0) * DVec3::new(1.0 / 21.0, 1.0 / 56.0, -1.0 / 14.0);
    weight * if exact { DVec3::new(0.0917780, 0.0630481, -0.0262027) } else { schlick }
}

/// Returns the factor of the coat on the light that the base reflects. `outward` and `inward` are the reflectances of the coat toward the
/// viewer and toward the light. `below` is its reflectance for light from the base, whose reflectance is `base`.
pub fn coated_base(outward: f64, inward: f64, below: f64, base: DVec3) -> DVec3 {
    (1.0 - outward) * (1.0 - inward) / (1.0 - below * base).max(DVec3::splat(1e-4))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrals::reference::visible_mean;
    use crate::random::Random;
    use crate::slopes::grid::{normal_of_slope, slope_at, slope_cholesky};

    fn direction(degrees: f64, azimuth: f64) -> DVec3 {
        let (sin, cos) = degrees.to_radians().sin_cos();
        DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos)
    }

    /// A white base under a coat returns all light, and a coat of weight 0 changes nothing.
    #[test]
    fn a_white_base_keeps_its_energy() {
        for degrees in [0.0, 40.0, 70.0, 88.0] {
            for sigma in [0.0, 0.1, 0.4] {
                let (wo, s) = (direction(degrees, 0.4), DVec3::new(sigma * sigma, sigma * sigma, 0.0));
                for weight in [0.0, 0.3, 1.0] {
                    let o = coat_reflectance(wo, DVec2::ZERO, s, weight, degrees > 50.0);
                    let mean = coat_average(weight, degrees > 50.0);
                    let diffuse = o + coated_base(o, mean, mean, DVec3::ONE).x;
                    assert!((diffuse - 1.0).abs() < 1e-9, "{diffuse}");
                    // A perfect mirror below.
                    let mirror = o + coated_base(o, o, o, DVec3::ONE).x;
                    assert!((mirror - 1.0).abs() < 1e-9, "{mirror}");
                    // Darker bases lose more, but never gain.
                    let grey = o + 0.5 * coated_base(o, mean, mean, DVec3::splat(0.5)).x;
                    assert!(grey < 1.0 && grey >= 0.5 * (1.0 - mean) - 1e-9, "{grey}");
                }
            }
        }
        assert_eq!(coated_base(0.0, 0.0, 0.0, DVec3::splat(0.7)), DVec3::ONE);
    }

    #[test]
    fn the_average_is_the_mean_over_the_hemisphere() {
        let steps = 20_000;
        let legendre = [|_: f64| 1.0, |c| c, |c| 1.5 * c * c - 0.5];
        for exact in [false, true] {
            let sum: f64 = (0..steps)
                .map(|i| coat_facet_reflectance(((f64::from(i) + 0.5) / f64::from(steps)).sqrt(), 0.8, exact))
                .sum();
            assert!((sum / f64::from(steps) - coat_average(0.8, exact)).abs() < 1e-6);
            for (order, of) in legendre.into_iter().enumerate() {
                let integral = |f: &dyn Fn(f64) -> f64| -> f64 {
                    (0..steps).map(|i| (f64::from(i) + 0.5) / f64::from(steps)).map(|c| c * of(c) * f(c)).sum()
                };
                let ratio = integral(&|c| coat_facet_reflectance(c, 0.8, exact)) / integral(&|_| 1.0);
                assert!((ratio - coat_bands(0.8, exact)[order]).abs() < 1e-5, "{order}: {ratio}");
            }
        }
    }

    /// Facets of a Gaussian relief, each with a coat and a diffuse base of albedo 0.6, drawn at random and lit by a sun. The mean over the
    /// visible facets is compared with the product of mean reflectances.
    #[test]
    fn near_a_monte_carlo_integral_of_coated_facets() {
        let mut random = Random::stream(7, 0);
        let (albedo, average) = (DVec3::splat(0.6), coat_average(1.0, false));
        let (mut worst, mut square) = (0.0f64, 0.0);
        for (view, light, azimuth) in
            [(0.0, 30.0, 0.0), (45.0, 20.0, 2.0), (60.0, 60.0, 3.1), (70.0, 40.0, 0.5), (75.0, 65.0, 1.6)]
        {
            let (wo, wi) = (direction(view, 0.0), direction(light, azimuth));
            for sigma in [0.05f64, 0.2, 0.4] {
                let (m, s) = (DVec2::new(0.1, -0.05), DVec3::new(sigma * sigma, 0.6 * sigma * sigma, 0.0));
                let cholesky = slope_cholesky(s);
                let (mut coated, mut bare) = (0.0, 0.0);
                for _ in 0..100_000 {
                    let n = normal_of_slope(slope_at(DVec2::from(random.normals()), m, cholesky));
                    let (co, ci) = (n.dot(wo).max(0.0), n.dot(wi).max(0.0));
                    let (o, i) = (coat_facet_reflectance(co, 1.0, false), coat_facet_reflectance(ci, 1.0, false));
                    bare += co / n.z * ci;
                    coated += co / n.z * ci * coated_base(o, i, average, albedo).x;
                }
                let both = coat_reflectances(wo, wi, m, s, 1.0, false);
                let error = coated_base(both.x, both.y, average, albedo).x / (coated / bare) - 1.0;
                (worst, square) = (worst.max(error.abs()), square + error * error);
            }
        }
        let rms = f64::sqrt(square / 15.0);
        println!("worst error {worst:.4}, rms {rms:.4}");
        assert!(worst < 0.055 && rms < 0.016);
    }

    /// The reflected light of the coat itself is the mean Fresnel reflectance over its visible facets.
    #[test]
    fn the_reflectance_is_the_visible_mean() {
        for degrees in [0.0, 50.0, 75.0] {
            let (wo, m, s) = (direction(degrees, 0.3), DVec2::new(0.2, 0.1), DVec3::new(0.05, 0.03, 0.01));
            for exact in [false, true] {
                let of_facet = |x: DVec2| DVec3::splat(coat_facet_reflectance(wo.dot(normal_of_slope(x)), 0.5, exact));
                let mean = visible_mean(wo, m, s, 10, of_facet).x;
                assert!((coat_reflectance(wo, m, s, 0.5, exact) - mean).abs() < 0.01);
            }
        }
    }
}
