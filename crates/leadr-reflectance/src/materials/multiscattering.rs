//! The multiple-scattering diffuse BRDF of rough surfaces under a specular coat (Chan 2018, section 5).
//!
//! [`chan_diffuse`] is the published hand fit (listing 1). [`multiscattering_diffuse`] is this project's fit to the same simulation
//! (`leadr_lab::facet_walk`), with an exact formula for the directional albedo:
//!
//! `f_r = ρ/π (κ P / (c_o + c_i) + r_o r_i / r̄ (1 + (1 − ρ q) η d))`
//!
//! * `t` is the coat's transmittance along a direction, which is one minus its reflectance ([`entered`](super::energy::entered)).
//! * `κ / (c_o + c_i)` is the first bounce at grazing angles (Lommel–Seeliger law). `κ` includes the factor `1 − F0` and is smaller for
//!   dark facets. `P` is the phase function of a Lambertian sphere, `P = 1 + 11/9 d + 2/9 (2 d² − s_o² s_i²)` with `d = s_o s_i cos φ` and
//!   `s = sin θ`. `P` is not negative, and its mean over azimuths is 1. The albedo of `1 / (c_o + c_i)` is `h = 2 (1 − c ln(1 + 1/c))`,
//!   with the mean `8/3 (1 − ln 2)`.
//! * `r = t (1 − q) / (1 − ρ q) − κ h` is the remaining albedo, distributed as in Kelemen and Szirmay-Kalos (2001). The term `η d` skews
//!   the first bounce of `r` towards the light without changing the albedo.
//!
//! The total albedo is therefore `ρ (1 − q) / (1 − ρ q) t`. The albedo is at most `t`, and equals `t` for `ρ = 1`. A white surface under
//! its coat therefore reflects all light. ([`BOUNCES_LOSSY`] multiplies the albedo by less than 1.) `q` is the probability that light
//! leaving a facet hits another facet, which saturates colours. The BRDF is symmetric, so Helmholtz reciprocity holds.

use crate::facets::fresnel::schlick_weight;
use crate::limits::{at_least, unit};
use glam::DVec3;
use std::f64::consts::{FRAC_1_PI, LN_2, PI};

/// The normalisation of [`facet_diffuse`], which makes a facet's albedo exactly `1 − F` for Schlick's `F`.
pub const FACET_DIFFUSE: f64 = 21.0 / (20.0 * PI);

/// Returns the BRDF of a white diffuse facet below a coat (Chan 2018, eq. 62; Shirley et al. 1997), from the cosines of both directions.
pub fn facet_diffuse(f0: f64, cosine_o: f64, cosine_i: f64) -> f64 {
    FACET_DIFFUSE * (1.0 - f0) * (1.0 - schlick_weight(cosine_o)) * (1.0 - schlick_weight(cosine_i))
}

/// Returns the hand fit of Chan 2018, eq. 64–69 and listing 1, without the factor `albedo / π`. `n_l`, `n_v`, `n_h` and `l_h` are the
/// cosines between normal, light, viewer and half vector, clamped to 0..1. `gloss` is from 0 to 1 (eq. 2).
///
/// The fit is reciprocal, since `l_h = v_h`. Its albedo can exceed 1 (see `docs/measurements/energy.md`).
pub fn chan_diffuse(n_l: f64, n_v: f64, n_h: f64, l_h: f64, gloss: f64) -> f64 {
    let [n_l, n_v, n_h, l_h, g] = [n_l, n_v, n_h, l_h, gloss].map(unit);
    let rough = l_h + schlick_weight(l_h);
    let smooth = (1.0 - 0.75 * schlick_weight(n_l)) * (1.0 - 0.75 * schlick_weight(n_v));
    let t = (2.2 * g - 0.5).clamp(0.0, 1.0);
    let bump = (34.5 * g * g - 59.0 * g + 24.5) * l_h * (-(73.2 * g - 21.2).max(8.9) * n_h.sqrt()).exp2();
    rough + (smooth - rough) * t + bump
}

/// The coefficients of Chan 2018, eq. 63, in the order of [`slice_quotient`].
pub const CHAN_RATIONAL: [f64; 15] =
    [0.568, -0.692, -0.938, 1.326, 0.301, 1.96, -0.98, 1.533, 1.731, -0.997, -0.998, -0.843, 9.905, -0.971, 0.948];

/// Returns the numerator and the denominator of a function of the form of Chan 2018, eq. 63, with `x = n·h` and `y = l·h`. The numerator has
/// eight coefficients, of `1, x, y, x², y², xy, x³, y³`. The denominator has seven, because its constant is 1.
///
/// # Panics
/// With fewer than 15 coefficients.
pub fn slice_quotient(x: f64, y: f64, coefficients: &[f64]) -> [f64; 2] {
    let terms = [x, y, x * x, y * y, x * y, x * x * x, y * y * y];
    let sum = |c: &[f64]| terms.iter().zip(c).map(|(term, c)| term * c).sum::<f64>();
    [coefficients[0] + sum(&coefficients[1..8]), 1.0 + sum(&coefficients[8..15])]
}

/// Returns the rational fit of Chan 2018, eq. 63, to the BRDF at gloss 0. `x = n·h` and `y = l·h` are clamped to 0..1.
pub fn chan_rational_rough(x: f64, y: f64) -> f64 {
    let [top, under] = slice_quotient(unit(x), unit(y), &CHAN_RATIONAL);
    top / if under.abs() < 1e-6 { 1e-6 } else { under }
}

/// The interreflection between facets of one roughness.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FacetBounces {
    /// The weight `κ` of the first bounce at grazing angles, without a coat.
    pub grazing: f64,
    /// The probability `q` that light leaving a facet hits another facet.
    pub again: f64,
    /// The skew `η` of the remaining first bounce towards the light, from −1 to 1.
    pub lean: f64,
    /// The fraction of the light that is lost between facets. The fraction is 0 if light that the coat reflects can hit other facets.
    pub lost: f64,
}

/// The fit constants of [`FacetBounces`] by roughness. Each value is `k₀ α² / (α² + k₁ α + k₂)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct BounceFit {
    /// The constants of [`FacetBounces::grazing`].
    pub grazing: [f64; 3],
    /// The constants of [`FacetBounces::again`].
    pub again: [f64; 3],
    /// The constants of [`FacetBounces::lean`].
    pub lean: [f64; 3],
    /// The constants of [`FacetBounces::lost`].
    pub lost: [f64; 3],
}

/// The recommended fit. Example 20 fits it to random walks on GGX facets with a specular coat (`Facets::Coated` of the simulation). These
/// walks lose no light.
pub const BOUNCES: BounceFit = BounceFit {
    grazing: [0.39284, 0.11088, 0.01835],
    again: [0.92213, 0.76687, 0.46287],
    lean: [0.36175, -0.7515, 0.48674],
    lost: [0.0, 0.0, 1.0],
};

/// The fit to random walks that discard the light reflected by the coat (`Facets::Diffuse`), as in Chan's simulation.
pub const BOUNCES_LOSSY: BounceFit = BounceFit {
    grazing: [0.38738, 0.12849, 0.02321],
    again: [0.84374, 0.74115, 0.45752],
    lean: [0.49619, -0.73675, 0.60793],
    lost: [0.38913, 1.77282, 0.13691],
};

impl BounceFit {
    /// Returns the interreflection values at the roughness `alpha`, which is clamped to 0..1.
    pub fn at(&self, alpha: f64) -> FacetBounces {
        let a = unit(alpha);
        let value = |k: [f64; 3]| k[0] * a * a / at_least(a * a + k[1] * a + k[2], 1e-9);
        FacetBounces {
            grazing: value(self.grazing),
            again: value(self.again).clamp(0.0, 0.9),
            lean: value(self.lean).clamp(-1.0, 1.0),
            lost: value(self.lost).clamp(0.0, 1.0),
        }
    }
}

/// Returns `2 (1 − c ln(1 + 1/c))`, the albedo of the BRDF `1 / (π (c_o + c_i))`. The albedo is 2 at grazing incidence.
pub fn grazing_albedo(cosine: f64) -> f64 {
    let c = at_least(unit(cosine), 1e-12);
    2.0 * (1.0 - c * ((1.0 + c) / c).ln())
}

/// The mean of [`grazing_albedo`] over the hemisphere.
pub const GRAZING_AVERAGE: f64 = 8.0 / 3.0 * (1.0 - LN_2);

/// Returns the module's multiple-scattering diffuse BRDF, per steradian. `wo` and `wi` are in the tangent frame. The BRDF is 0 unless both
/// directions are above the horizon. The coat's `f0` and the facets' `albedo` are linear RGB from 0 to 1. `entered_o`, `entered_i` and
/// `entered_average` are the transmittance of the coat along `wo`, along `wi`, and on average ([`entered`](super::energy::entered)).
pub fn multiscattering_diffuse(
    wo: DVec3,
    wi: DVec3,
    bounces: FacetBounces,
    f0: DVec3,
    albedo: DVec3,
    entered_o: DVec3,
    entered_i: DVec3,
    entered_average: DVec3,
) -> DVec3 {
    if !(wo.z > 0.0 && wi.z > 0.0) {
        return DVec3::ZERO;
    }
    let (c_o, c_i) = (wo.z.min(1.0), wi.z.min(1.0));
    let d = wo.x * wi.x + wo.y * wi.y;
    let sines = (1.0 - c_o * c_o) * (1.0 - c_i * c_i);
    let phase = at_least(1.0 + 11.0 / 9.0 * d + 2.0 / 9.0 * (2.0 * d * d - sines), 0.0);
    let kappa = grazing_weight(bounces, f0, albedo);
    let white = first_albedo(bounces, albedo);
    let left = |t: DVec3, h: f64| (t * white - kappa * h).max(DVec3::ZERO);
    let [r_o, r_i] = [(entered_o, c_o), (entered_i, c_i)].map(|(t, c)| left(t, grazing_albedo(c)));
    let average = left(entered_average, GRAZING_AVERAGE).max(DVec3::splat(1e-6));
    let lean = DVec3::ONE + (DVec3::ONE - albedo * bounces.again) * (bounces.lean * d);
    albedo * FRAC_1_PI * (kappa * (phase / at_least(c_o + c_i, 1e-6)) + r_o * (r_i / average) * lean)
}

/// Returns `κ`, which is smaller for dark facets so that the remaining albedo `r` is never negative. Dark facets reflect only a first
/// bounce.
fn grazing_weight(bounces: FacetBounces, f0: DVec3, albedo: DVec3) -> DVec3 {
    bounces.grazing * (DVec3::ONE - f0) * (DVec3::ONE - 0.7 * bounces.again * (DVec3::ONE - albedo))
}

/// Returns the surface albedo divided by the facet albedo and by the transmitted light.
fn first_albedo(bounces: FacetBounces, albedo: DVec3) -> DVec3 {
    (1.0 - bounces.lost) * (1.0 - bounces.again) / (DVec3::ONE - albedo * bounces.again)
}

/// Returns the albedo of facets whose surface has the given `albedo` for the light that enters it, from 0 to 1. Light that hits other facets
/// is absorbed more often, so the facets of a grey surface are brighter than the surface. The colour of a material is that of its surface.
pub fn facet_albedo(bounces: FacetBounces, albedo: DVec3) -> DVec3 {
    let kept = (1.0 - bounces.lost) * (1.0 - bounces.again);
    (albedo / (kept + albedo * bounces.again).max(DVec3::splat(1e-6))).min(DVec3::ONE)
}

/// Returns the directional albedo of [`multiscattering_diffuse`], from the coat's transmittance along that direction.
pub fn multiscattering_albedo(bounces: FacetBounces, albedo: DVec3, entered: DVec3) -> DVec3 {
    albedo * first_albedo(bounces, albedo) * entered
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::materials::energy::{EnergyTable, entered};
    use crate::materials::microfacet::half_vector;
    use crate::quadrature::composite_gauss;
    use crate::random::Random;

    fn direction(c: f64, phi: f64) -> DVec3 {
        let s = ((1.0 - c) * (1.0 + c)).max(0.0).sqrt();
        DVec3::new(s * phi.cos(), s * phi.sin(), c)
    }

    /// Computes `∫ f c dω` over the hemisphere of lights, with more nodes at grazing angles.
    fn albedo(wo: DVec3, brdf: impl Fn(DVec3) -> f64) -> f64 {
        let azimuths = composite_gauss(0.0, PI, 2, 12);
        let towards = wo.y.atan2(wo.x);
        composite_gauss(0.0, 1.0, 4, 10)
            .into_iter()
            .map(|(u, w)| {
                let c = u * u;
                let ring = azimuths.iter().map(|(phi, v)| v * brdf(direction(c, towards + phi))).sum::<f64>();
                2.0 * ring * c * 2.0 * u * w
            })
            .sum()
    }

    /// A facet scatters all light that its coat does not reflect, as in Chan's eq. 61 with the factor 1 − F0.
    #[test]
    fn facets_scatter_unreflected_light() {
        for (f0, c) in [(0.0, 1.0), (0.04, 0.3), (0.5, 0.05)] {
            let got = albedo(direction(c, 0.0), |wi| facet_diffuse(f0, c, wi.z));
            let fresnel = f0 + (1.0 - f0) * schlick_weight(c);
            assert!((got - (1.0 - fresnel)).abs() < 1e-12, "{got}");
        }
    }

    /// The albedo is exact because `r` is never clamped, for any roughness, coat, albedo and angle.
    #[test]
    fn the_rest_is_never_negative() {
        for table in [EnergyTable::ggx(), EnergyTable::beckmann()] {
            let mut least = f64::MAX;
            for (a, f) in (1..=60).flat_map(|a| (0..=20).map(move |f| (a, f))) {
                let (alpha, f0) = ((f64::from(a) / 60.0).powi(2), (f64::from(f) / 20.0).powi(2));
                let average = table.average(alpha).ideal;
                for bounces in [BOUNCES.at(alpha), BOUNCES_LOSSY.at(alpha)] {
                    assert!(bounces.lean.abs() <= 1.0 && bounces.grazing >= 0.0);
                    for c in (0..=40).map(|c| (f64::from(c) / 40.0).powi(2)) {
                        let t = entered(DVec3::splat(f0), table.albedo(alpha, c), average).x;
                        for rho in [0.0, 0.25, 0.5, 0.75, 1.0].map(DVec3::splat) {
                            let kappa = grazing_weight(bounces, DVec3::splat(f0), rho).x;
                            let rest = t * first_albedo(bounces, rho).x - kappa * grazing_albedo(c);
                            // A perfect mirror leaves no diffuse light.
                            least = least.min(if f0 < 1.0 { rest / (1.0 - f0) } else { f64::MAX });
                        }
                    }
                }
            }
            println!("least of the rest, per 1 − F0: {least:.4}");
            // The smoothest surfaces transmit no light at grazing incidence, where 2 κ is 3e-6.
            assert!(least > -1e-5, "{least}");
        }
    }

    #[test]
    fn albedo_matches_its_setting() {
        let table = EnergyTable::ggx();
        let mut worst = 0.0f64;
        for (i, bounces) in [BOUNCES, BOUNCES_LOSSY].into_iter().enumerate() {
            for (alpha, f0, rho, c) in
                [(0.05, 0.04, 1.0, 0.1), (0.3, 0.04, 0.5, 0.7), (1.0, 0.0, 1.0, 0.02), (0.6, 0.6, 0.2, 1.0)]
            {
                let (f0, rho, b) = (DVec3::splat(f0), DVec3::splat(rho), bounces.at(alpha));
                let average = table.average(alpha);
                let t = |c: f64| entered(f0, table.albedo(alpha, c), average.ideal);
                let mean = entered(f0, average, average.ideal);
                let wo = direction(c, 0.4);
                let got = albedo(wo, |wi| multiscattering_diffuse(wo, wi, b, f0, rho, t(wo.z), t(wi.z), mean).x);
                let want = multiscattering_albedo(b, rho, t(wo.z)).x;
                worst = worst.max((got - want).abs());
                assert!(want <= t(wo.z).x && (i == 1 || rho.x < 1.0 || (want - t(wo.z).x).abs() < 1e-12));
            }
        }
        assert!(worst < 2e-4, "{worst}");
    }

    #[test]
    fn the_albedo_of_a_surface_follows_from_its_facets() {
        for alpha in [0.05, 0.35, 1.0] {
            for albedo in [0.0, 0.1, 0.5, 1.0].map(DVec3::splat) {
                let bounces = BOUNCES.at(alpha);
                let facets = facet_albedo(bounces, albedo);
                let found = multiscattering_albedo(bounces, facets, DVec3::ONE);
                assert!((found - albedo).abs().max_element() < 1e-12 && facets.cmpge(albedo - 1e-12).all(), "{found}");
            }
        }
    }

    #[test]
    fn reciprocal_positive_and_finite() {
        let table = EnergyTable::ggx();
        let mut random = Random(3);
        for _ in 0..20_000 {
            let mut draw = || {
                let c = match (random.unit() * 4.0) as u32 {
                    0 => 1e-9,
                    1 => 1.0,
                    _ => random.unit(),
                };
                direction(c, random.range(0.0, 6.0))
            };
            let (wo, wi) = (draw(), draw());
            let (alpha, f0, rho) = (random.unit(), random.unit().powi(2), random.unit());
            let (f0, average) = (DVec3::splat(f0), table.average(alpha));
            let [o, i] = [wo, wi].map(|w| entered(f0, table.albedo(alpha, w.z), average.ideal));
            let mean = entered(f0, average, average.ideal);
            let (b, rho) = (BOUNCES.at(alpha), DVec3::splat(rho));
            let there = multiscattering_diffuse(wo, wi, b, f0, rho, o, i, mean).x;
            let back = multiscattering_diffuse(wi, wo, b, f0, rho, i, o, mean).x;
            assert!(there.is_finite() && there >= 0.0 && (there - back).abs() <= 1e-12 * there.max(1.0));
            // The published fit is also reciprocal, because l·h = v·h.
            let h = half_vector(wo, wi);
            let g = random.unit();
            let there = chan_diffuse(wi.z, wo.z, h.z, wi.dot(h), g);
            let back = chan_diffuse(wo.z, wi.z, h.z, wo.dot(h), g);
            assert!((there - back).abs() < 1e-9 && there.is_finite(), "{there} {back}");
        }
        for x in [f64::NAN, -1.0, 0.0, 1.0, 1e300] {
            assert!(chan_diffuse(x, x, x, x, x).is_finite() && chan_rational_rough(x, x).is_finite());
            let b = BOUNCES.at(x);
            assert!(b.again.is_finite() && grazing_albedo(x).is_finite());
        }
    }

    /// The hand fit creates energy on rough surfaces at grazing angles.
    #[test]
    fn the_published_fit_is_brighter_than_white() {
        let of = |c: f64, gloss: f64| {
            let wo = direction(c, 0.0);
            albedo(wo, |wi| {
                let h = half_vector(wo, wi);
                chan_diffuse(wi.z, c, h.z, wi.dot(h), gloss) * FRAC_1_PI
            })
        };
        assert!((of(1e-3, 0.0) - 1.156).abs() < 2e-3, "{}", of(1e-3, 0.0));
        assert!((of(1.0, 0.0) - 0.973).abs() < 1e-3 && (of(1.0, 1.0) - 0.964).abs() < 1e-3);
        assert!(of(1e-3, 30.0 / 255.0) > 1.0 && of(1e-3, 60.0 / 255.0) < 1.0);
    }
}
