//! A mixture of two base roughnesses under a pixel, such as polished and dusty areas, or wet and dry areas.
//!
//! LEADR (section 4.1) filters roughness as the variance `α²/2`. If a pixel covers both roughnesses, the base is then a single lobe of the
//! mean `α²`. The sharp highlight of the smoother area is lost, for any number of samples. In this module, each texel belongs to one of two
//! classes, below or above a threshold roughness. The filtered values are linear: the fraction `p` of the surface in the rougher class, and
//! the contributions of each class to the mean `α²`, `E[α² 1_rough]` and `E[α² 1_smooth]`. Each class has its own lobe, with the mean `α²`
//! of the class. For surfaces with two roughness values the result is exact under every footprint. For other surfaces the lobes keep the
//! mean of `α²`, and its variance between the classes but not within them.

use glam::DVec3;

/// The fraction of the surface below which a class is ignored.
pub const LEAST_SHARE: f64 = 1.0 / 512.0;

/// A mixture of two roughnesses under one pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MixedRoughness {
    /// The fraction of the surface in the rougher class, from 0 to 1.
    pub share: f64,
    /// The Beckmann roughness `α` of the smoother class.
    pub smooth_alpha: f64,
    /// The Beckmann roughness `α` of the rougher class. Both roughnesses are equal if either class is empty.
    pub rough_alpha: f64,
}

/// Decodes the filtered `means`: the fraction of the rougher class, then the contributions of the rougher and of the smoother class to the
/// mean `α²`.
pub fn mixed_roughness(means: DVec3) -> MixedRoughness {
    let share = means.x.clamp(0.0, 1.0);
    let (rough, smooth) = (means.y.clamp(0.0, share), means.z.clamp(0.0, 1.0 - share));
    let rough_alpha = (rough / share.max(LEAST_SHARE)).sqrt();
    let smooth_alpha = (smooth / (1.0 - share).max(LEAST_SHARE)).sqrt();
    if share < LEAST_SHARE {
        MixedRoughness { share: 0.0, smooth_alpha, rough_alpha: smooth_alpha }
    } else if share > 1.0 - LEAST_SHARE {
        MixedRoughness { share: 1.0, smooth_alpha: rough_alpha, rough_alpha }
    } else {
        MixedRoughness { share, smooth_alpha, rough_alpha }
    }
}

impl MixedRoughness {
    /// Returns the `α` of a single lobe that represents both classes (LEADR section 4.1).
    pub fn joint_alpha(&self) -> f64 {
        let square = |alpha: f64| alpha * alpha;
        (square(self.smooth_alpha) + self.share * (square(self.rough_alpha) - square(self.smooth_alpha))).sqrt()
    }
}

/// Returns the threshold roughness `α` that minimises the variance of `ln α` within the two classes it separates. `weights` holds the
/// fraction of the surface for each entry of the ascending positive `alphas`. The result is `None` if no threshold gives classes whose mean
/// `α²` differ by a factor of two or more.
pub fn two_classes(alphas: &[f64], weights: &[f64]) -> Option<f64> {
    // Each part holds the weight, the weight times ln α, and the weight times α².
    let part = |i: usize| weights[i] * DVec3::new(1.0, alphas[i].ln(), alphas[i] * alphas[i]);
    let all: DVec3 = (0..alphas.len()).map(part).sum();
    let (mut best, mut threshold) = (0.0, None);
    let mut smooth = DVec3::ZERO;
    for i in 1..alphas.len() {
        smooth += part(i - 1);
        let rough = all - smooth;
        // Rounding can leave a small nonzero sum in an empty class.
        if smooth.x <= 0.0 || rough.x <= 1e-12 * all.x {
            continue;
        }
        let apart = rough.y / rough.x - smooth.y / smooth.x;
        let between = smooth.x * rough.x * apart * apart;
        if rough.z / rough.x >= 2.0 * smooth.z / smooth.x && between > best {
            best = between;
            threshold = Some((alphas[i - 1] * alphas[i]).sqrt());
        }
    }
    threshold
}

#[cfg(test)]
mod tests {
    use super::*;

    fn means(surface: &[(f64, f64)], threshold: f64) -> DVec3 {
        surface.iter().fold(DVec3::ZERO, |sum, &(share, alpha)| {
            let part = share * alpha * alpha;
            sum + if alpha >= threshold { DVec3::new(share, part, 0.0) } else { DVec3::new(0.0, 0.0, part) }
        })
    }

    #[test]
    fn two_values_are_recovered_for_any_shares() {
        for share in [0.01, 0.3, 0.5, 0.97] {
            let found = mixed_roughness(means(&[(share, 0.6), (1.0 - share, 0.1)], 0.3));
            assert!((found.share - share).abs() < 1e-12);
            assert!((found.rough_alpha - 0.6).abs() < 1e-12 && (found.smooth_alpha - 0.1).abs() < 1e-12);
        }
    }

    #[test]
    fn one_value_is_one_lobe() {
        for (share, alpha) in [(0.0, 0.2), (1.0, 0.5)] {
            let found = mixed_roughness(means(&[(1.0, alpha)], 0.3));
            assert_eq!(found.share, share);
            assert!((found.smooth_alpha - alpha).abs() < 1e-12 && found.smooth_alpha == found.rough_alpha);
        }
    }

    #[test]
    fn any_numbers_give_roughnesses() {
        for x in [-1.0, 0.0, 1e-30, 0.5, 1.0, 1e30] {
            for y in [-1.0, 0.0, 0.5, 1e30] {
                let m = mixed_roughness(DVec3::new(x, y, y));
                let all = [m.share, m.smooth_alpha, m.rough_alpha];
                assert!(all.iter().all(|v| (0.0..=1.0).contains(v)), "{x} {y}: {m:?}");
            }
        }
    }

    #[test]
    fn roughness_classes_split_where_useful() {
        let alphas = [0.1, 0.2, 0.4, 0.6];
        let threshold = two_classes(&alphas, &[1.0, 0.0, 0.0, 1.0]).unwrap();
        assert!(threshold > 0.1 && threshold < 0.6);
        assert!(two_classes(&alphas, &[0.0, 1.0, 0.0, 0.0]).is_none());
        assert!(two_classes(&[0.5, 0.55, 0.6], &[1.0; 3]).is_none());
        let between = two_classes(&alphas, &[5.0, 5.0, 1.0, 9.0]).unwrap();
        assert!(between > 0.2 && between < 0.4, "{between}");
    }
}
