//! A rough dielectric coat over a diffuse base, in the form that Mitsuba and pbrt implement.

use std::f64::consts::FRAC_1_PI;

use glam::{DVec2, DVec3};

use leadr_reflectance::facets::fresnel::fresnel_dielectric;
use leadr_reflectance::facets::ggx::Ggx;
use leadr_reflectance::facets::slope_distribution::SlopeDistribution as _;

/// The largest albedo and reflectance in an exported material.
pub const MOST: f64 = 0.999;
/// The number of cosines in the table, which are evenly spaced from 0 to 1.
const COSINES: usize = 65;
/// The number of cells along each side of the grid that samples visible facets.
const FACETS: usize = 24;

/// The transmission of dielectric GGX facets. A single facet refracts or reflects the light. Light that other facets mask is lost.
#[derive(Clone, Debug, PartialEq)]
pub struct Coat {
    /// The refractive index of the coat.
    index: f64,
    /// The transmitted fraction of light from outside, at each cosine of the table.
    entering: [f64; COSINES],
    /// The fraction of diffuse light from inside that is reflected back.
    kept: f64,
}

impl Coat {
    /// Computes the transmission of facets with roughness `alpha` and this refractive index, which must be above 1.
    pub fn new(alpha: f64, index: f64) -> Self {
        let facets = Ggx::new(DVec2::ZERO, DVec3::new(alpha * alpha, alpha * alpha, 0.0));
        let cosine = |i: usize| (i as f64 / (COSINES - 1) as f64).max(1e-3);
        let entering = std::array::from_fn(|i| mean_over_facets(&facets, cosine(i), |c| entered(c, index)));
        // The trapezoidal rule gives twice the integral over the cosine.
        let kept = (1..COSINES).map(|i| {
            let sent_back = |i| cosine(i) * mean_over_facets(&facets, cosine(i), |c| reflected(c, 1.0 / index));
            (sent_back(i - 1) + sent_back(i)) / (COSINES - 1) as f64
        });
        Self { index, entering, kept: kept.sum::<f64>().min(MOST) }
    }

    /// Returns `f_r` of a white diffuse base without internal reflection, or 0 below the horizon.
    pub fn window(&self, wo: DVec3, wi: DVec3) -> f64 {
        if wo.z <= 0.0 || wi.z <= 0.0 {
            return 0.0;
        }
        FRAC_1_PI * self.entered(wo.z) * self.entered(wi.z) / (self.index * self.index)
    }

    /// Returns the factor on [`Coat::window`] for a base of albedo `ρ`. The factor is `ρ / (1 − ρ kept)`, the sum over all internal
    /// reflections.
    pub fn strength(&self, albedo: DVec3) -> DVec3 {
        albedo / (DVec3::ONE - self.kept * albedo)
    }

    /// Returns the albedo that gives this factor, at most [`MOST`].
    pub fn albedo(&self, strength: DVec3) -> DVec3 {
        let strength = strength.max(DVec3::ZERO);
        (strength / (DVec3::ONE + self.kept * strength)).min(DVec3::splat(MOST))
    }

    fn entered(&self, cosine: f64) -> f64 {
        let at = cosine.clamp(0.0, 1.0) * (COSINES - 1) as f64;
        let low = (at as usize).min(COSINES - 2);
        self.entering[low] + (at - low as f64) * (self.entering[low + 1] - self.entering[low])
    }
}

/// The fraction of the light that a facet reflects or refracts, and the coefficients `(a, b)` of the outgoing direction `a ω + b m`.
type Deed = (f64, DVec2);

fn reflected(cosine: f64, index: f64) -> Deed {
    (fresnel_dielectric(cosine, index), DVec2::new(-1.0, 2.0 * cosine))
}

fn entered(cosine: f64, index: f64) -> Deed {
    let inside = (1.0 - (1.0 - cosine * cosine) / (index * index)).max(0.0).sqrt();
    (1.0 - fresnel_dielectric(cosine, index), DVec2::new(-1.0 / index, cosine / index - inside))
}

/// Averages a fraction over the facets that are visible at this cosine. The fraction is multiplied by the probability that no other facet
/// masks the light.
fn mean_over_facets(facets: &Ggx, cosine: f64, deed: impl Fn(f64) -> Deed) -> f64 {
    let w = DVec3::new((1.0 - cosine * cosine).max(0.0).sqrt(), 0.0, cosine);
    let mut sum = 0.0;
    for i in 0..FACETS * FACETS {
        let at = |i: usize| (i as f64 + 0.5) / FACETS as f64;
        let facet = facets.sample_visible(w, DVec2::new(at(i % FACETS), at(i / FACETS)));
        let (share, way) = deed(w.dot(facet).clamp(0.0, 1.0));
        let to = way.x * w + way.y * facet;
        // Reflected light must go up, and refracted light must go down. In other directions, the light hits another facet.
        if to.z * to.dot(facet) > 0.0 && (to.z > 0.0) == (to.dot(facet) * w.dot(facet) > 0.0) {
            let up = if to.z < 0.0 { -to } else { to };
            sum += share * up.z / facets.visible_area(up).max(1e-9);
        }
    }
    (sum / (FACETS * FACETS) as f64).min(1.0)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_smooth_coat_is_a_dielectric() {
        let coat = Coat::new(1e-3, 1.5);
        for i in 3..=32 {
            let cosine = f64::from(i) / 32.0;
            let through = 1.0 - fresnel_dielectric(cosine, 1.5);
            assert!((coat.entered(cosine) - through).abs() < 2e-3, "{cosine}: {} {through}", coat.entered(cosine));
        }
        // Glass of index 1.5 reflects 59.6 % of the diffuse light from inside (Egan and Hilgeman 1979).
        assert!((coat.kept - 0.596).abs() < 3e-3, "{}", coat.kept);
    }

    #[test]
    fn rough_coats_are_those_of_mitsuba() {
        // The expected values are the transmission at cosines 0.25, 0.5 and 1, and the internal reflection. The values come from
        // `roughplastic` of Mitsuba 3.9.1 without specular reflectance, as the quotient of a white and a nearly black diffuse base.
        for (alpha, entering, kept) in [
            (0.05, [0.7455, 0.9093, 0.9600], 0.5761),
            (0.2, [0.7937, 0.8989, 0.9572], 0.4863),
            (0.5, [0.7284, 0.8399, 0.9402], 0.2900),
            (1.0, [0.4843, 0.6515, 0.8808], 0.1174),
        ] {
            let coat = Coat::new(alpha, 1.5);
            for (cosine, expected) in [0.25, 0.5, 1.0].into_iter().zip(entering) {
                let entered = coat.entered(cosine);
                println!("{alpha} {cosine}: {:.4}", entered - expected);
                assert!((entered - expected).abs() < 5e-3, "{alpha} {cosine}: {entered}");
            }
            // Mitsuba averages over 64 cosines, and gives the two end points full weight.
            let mean = (63.0 * coat.kept + 0.04) / 64.0;
            println!("{alpha}: {:.4}", mean - kept);
            assert!((mean - kept).abs() < 5e-3, "{alpha}: {mean}");
        }
    }

    #[test]
    fn no_energy_is_gained() {
        for alpha in [1e-4, 0.05, 0.5, 1.0, 3.0] {
            let coat = Coat::new(alpha, 1.5);
            assert!(coat.kept > 0.0 && coat.kept < 1.0, "{alpha}");
            assert!(coat.entering.iter().all(|t| (0.0..=1.0).contains(t)), "{coat:?}");
            let albedo = DVec3::new(0.0, 0.5, 0.999);
            assert!((coat.albedo(coat.strength(albedo)) - albedo).length() < 1e-12);
            assert_eq!(coat.albedo(DVec3::splat(-1.0)), DVec3::ZERO);
            // The albedo under diffuse light is at most 1.
            let mut all = 0.0;
            for (i, j) in (0..64).flat_map(|i| (0..64).map(move |j| (i, j))) {
                let w = |i: i32| DVec3::new(0.0, 0.0, (f64::from(i) + 0.5) / 64.0);
                all += 4.0 * std::f64::consts::PI * coat.window(w(i), w(j)) * w(i).z * w(j).z / 4096.0;
            }
            assert!(all * coat.strength(DVec3::ONE).x < 1.0, "{alpha} {all}");
        }
    }
}
