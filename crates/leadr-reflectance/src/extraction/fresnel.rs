//! Extracts the Fresnel term of a material whose slope distribution has been fitted (thesis eq. 4.11).
//!
//! Both functions average the reflectance of the material, divided by the reflectance of ideal specular facets with the same slopes
//! (eq. 4.10), over pairs of directions with one difference angle `θ_d`:
//!
//! | function | azimuths `φ_d` | values above 1 |
//! |---|---|---|
//! | [`thesis_fresnel`] | all | kept, as a residual |
//! | [`slice_fresnel`] | 90° | clamped to 1 |
//!
//! [`thesis_fresnel`] is algorithm 2 as printed. The author's library, `dj_brdf`, has the slice and the clamp instead. The thesis does not
//! print the steps of `θ_h`; both functions space them as its listings space all elevations, denser at the highlight.

use std::f64::consts::{FRAC_PI_2, TAU};

use glam::DVec3;

use super::samples::pair;
use crate::facets::fresnel::{FresnelTable, MAX_RESIDUAL};
use crate::facets::radial_table::angle_at;
use crate::facets::tabulated::Tabulated;
use crate::masking::variants::Masking;
use crate::materials::brdf::Brdf;
use crate::materials::microfacet::microfacet_eval;

/// The lowest reflectance of ideal facets that may divide a measured reflectance. Ratios to smaller values are unreliable.
const LEAST: f64 = 1e-4;
/// The lowest cosine of a direction in algorithm 2. Nearer to the horizon, measured reflectances diverge, and single pairs would dominate the
/// mean.
const HORIZON: f64 = 0.01;
/// The number of azimuths of the half vector for anisotropic slopes. Isotropic slopes need one.
const HALF_AZIMUTHS: usize = 8;
/// The number of azimuths `φ_d` of algorithm 2.
const DIFFERENCE_AZIMUTHS: usize = 16;

/// Extracts the Fresnel term by algorithm 2 of the thesis: the mean over all `φ_d`, `φ_h` and `θ_h`. The table has `count` difference
/// angles from 0 to 90°. Its values can exceed 1, because errors of the fit become part of the term.
///
/// The quotient is undefined for directions below the horizon and for facets that reflect nothing. Pairs are left out if a direction is
/// within 0.6° of the horizon, or if ideal facets reflect less than 1e-4.
pub fn thesis_fresnel(brdf: &dyn Brdf, slopes: &Tabulated, masking: Masking, count: usize) -> FresnelTable {
    let (half, difference) = (half_azimuths(slopes), DIFFERENCE_AZIMUTHS);
    let values = mean_ratios(brdf, slopes, masking, HORIZON, count, |theta_d, count, add| {
        for h in 0..count {
            let theta_h = angle_at((h as f64 + 0.5) / count as f64);
            for (k, p) in (0..half).flat_map(|k| (0..difference).map(move |p| (k, p))) {
                let phi_d = (p as f64 + 0.5) / difference as f64 * TAU;
                add(pair(theta_h, TAU * k as f64 / half as f64, theta_d, phi_d));
            }
        }
    });
    let values = values.into_iter().map(|value| value.min(DVec3::splat(MAX_RESIDUAL))).collect();
    FresnelTable::residual(values).expect("at least two values within the limit")
}

/// Extracts the Fresnel term from the slice `φ_d` = 90°, where both directions have the same height, so most pairs stay above the horizon.
/// The table has `count` difference angles from 0 to 90°, and its values are clamped to 0..1.
pub fn slice_fresnel(brdf: &dyn Brdf, slopes: &Tabulated, masking: Masking, count: usize) -> FresnelTable {
    let half = half_azimuths(slopes);
    let values = mean_ratios(brdf, slopes, masking, 0.0, count, |theta_d, count, add| {
        for (h, k) in (0..count).flat_map(|h| (0..half).map(move |k| (h, k))) {
            add(pair(angle_at(h as f64 / count as f64), TAU * k as f64 / half as f64, theta_d, FRAC_PI_2));
        }
    });
    let values = values.into_iter().map(|value| value.min(DVec3::ONE)).collect();
    FresnelTable::new(values).expect("reflectances within 0..1")
}

fn half_azimuths(slopes: &Tabulated) -> usize {
    if matches!(slopes, Tabulated::Radial(_)) { 1 } else { HALF_AZIMUTHS }
}

/// Returns the mean quotient for each of `count` difference angles. `pairs` passes the pairs of an angle to its last argument. Pairs with a
/// cosine of at most `horizon` are left out. Angles without pairs have the value 1, and 90° has the value of the last angle before.
fn mean_ratios(
    brdf: &dyn Brdf,
    slopes: &Tabulated,
    masking: Masking,
    horizon: f64,
    count: usize,
    pairs: impl Fn(f64, usize, &mut dyn FnMut((DVec3, DVec3, DVec3))),
) -> Vec<DVec3> {
    let count = count.max(2);
    let mut values: Vec<DVec3> = (0..count - 1)
        .map(|d| {
            let (mut sum, mut number) = (DVec3::ZERO, 0.0);
            pairs(d as f64 / (count - 1) as f64 * FRAC_PI_2, count, &mut |(wo, wi, _)| {
                if wo.z <= horizon || wi.z <= horizon {
                    return;
                }
                let ideal = microfacet_eval(masking, slopes, wo, wi) / wi.z;
                if ideal > LEAST {
                    sum += brdf.eval(wo, wi) / ideal;
                    number += 1.0;
                }
            });
            if number > 0.0 { (sum / number).max(DVec3::ZERO) } else { DVec3::ONE }
        })
        .collect();
    values.push(values[count - 2]);
    values
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::extraction::power_iteration::{Backscattering, extract_radial};
    use crate::facets::fresnel::Fresnel;
    use crate::facets::ggx::Ggx;
    use crate::facets::slope_distribution::SlopeDistribution as _;
    use crate::materials::half_difference::directions_to_half_difference;
    use crate::materials::microfacet::Microfacet;
    use glam::DVec2;

    /// Rough facets whose reflectance is multiplied by a function of `φ_d`.
    struct Turning<F>(Microfacet<Ggx>, F);

    impl<F: Fn(f64) -> f64> Brdf for Turning<F> {
        fn eval_cos(&self, wo: DVec3, wi: DVec3) -> DVec3 {
            let wd = directions_to_half_difference(wo, wi).wd;
            self.1(wd.y.atan2(wd.x)) * self.0.eval_cos(wo, wi)
        }
    }

    fn rough() -> Microfacet<Ggx> {
        let fresnel = Fresnel::Schlick(DVec3::new(0.9, 0.5, 0.1));
        Microfacet { distribution: Ggx::isotropic(DVec2::ZERO, 0.5), masking: Masking::SmithCorrelated, fresnel }
    }

    /// Returns the Fresnel terms of the two functions at a few difference angles, and the true one.
    fn terms(factor: impl Fn(f64) -> f64, count: usize) -> Vec<[DVec3; 3]> {
        let material = Turning(rough(), factor);
        let back = |i: usize| {
            let (sine, cosine) = angle_at(i as f64 / 90.0).sin_cos();
            let o = DVec3::new(sine, 0.0, cosine);
            let area = rough().distribution.visible_area(o);
            rough().distribution.ndf(o) / (4.0 * cosine * area)
        };
        let found = extract_radial(&(0..90).map(back).collect::<Vec<_>>(), Backscattering::Smith).unwrap();
        let slopes = Tabulated::Radial(found.slopes);
        let thesis = thesis_fresnel(&material, &slopes, Masking::SmithCorrelated, count);
        let slice = slice_fresnel(&material, &slopes, Masking::SmithCorrelated, count);
        let at = |degrees: f64| {
            let cosine = degrees.to_radians().cos();
            [thesis.at(cosine), slice.at(cosine), rough().fresnel.at(cosine)]
        };
        [5.0, 30.0, 60.0, 80.0].map(at).to_vec()
    }

    #[test]
    fn both_find_the_term_of_facets() {
        for [thesis, slice, truth] in terms(|_| 1.0, 90) {
            println!("{thesis} {slice} {truth}");
            assert!((thesis - truth).length() < 1e-3 && (slice - truth).length() < 1e-3, "{thesis} {slice} {truth}");
        }
    }

    /// Near `θ_d` = 0, all azimuths are above the horizon, so the mean of the factor is 2. The slice sees the factor at 90°, which is 1.
    #[test]
    fn algorithm_2_averages_all_azimuths_and_keeps_residuals() {
        let [thesis, slice, truth] = terms(|phi| 2.0 + (2.0 * phi).cos(), 90)[0];
        assert!((thesis / truth - 2.0).abs().max_element() < 0.02, "{thesis} {truth}");
        assert!((slice / truth - 1.0).abs().max_element() < 0.01, "{slice} {truth}");
        let [thesis, slice, truth] = terms(|_| 3.0, 90)[1];
        assert!((thesis / truth - 3.0).abs().max_element() < 0.01 && thesis.x > 1.0, "{thesis} {truth}");
        assert!(slice.x == 1.0 && (slice.z / truth.z - 3.0).abs() < 0.01, "{slice} {truth}");
    }

    /// The mean is independent of the number of angles.
    #[test]
    fn algorithm_2_has_converged() {
        let factor = |phi: f64| 1.0 + 0.8 * phi.sin().powi(4);
        for (few, many) in terms(factor, 45).into_iter().zip(terms(factor, 180)) {
            println!("{} {}", few[0], many[0]);
            assert!((few[0] / many[0] - 1.0).abs().max_element() < 0.01, "{} {}", few[0], many[0]);
        }
    }
}
