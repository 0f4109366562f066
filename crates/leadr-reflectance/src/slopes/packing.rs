//! The texel formats of slope moments: LEADR (all moments), LEAN (fixed point), and CLEAN (one variance).
//!
//! CLEAN stores two means and one roughness value, which must represent one slope variance:
//!
//! * [`pack_clean`] (Baker; thesis eq. 3.18) stores `E[x² + y²]` and reads back `(third − |m|²) / 2`. This is the mean of the two principal
//!   variances, which is too small along the major axis by up to one half.
//! * [`pack_clean_major`] (thesis 3.4, a conjecture) stores `|m|² + 2 λ` and reads back `(third − |m|²) / 2`. This is the larger principal
//!   variance at a texel centre, but filtering between texels adds only half of the variance of their means.
//! * [`pack_clean_conservative`] (this project) stores `|m|² + λ` and reads back `third − |m|²`. This is the larger principal variance at
//!   the texel, and is never too small between texels.
//!
//! In these formulas, `λ` is the larger eigenvalue of the texel's covariance. The conservative form can be proved: under filter weights
//! `w`, the covariance is `Σ w S_i + B`, where `B` is the covariance of the texels' means. [`pack_clean_conservative`] reads back
//! `Σ w λ_i + tr B`, and the variance in any direction is at most `Σ w λ_i + λ(B)`. [`pack_clean_major`] reads back only half of `tr B`,
//! which is already too small for two texels with different means.

use super::moments::SlopeMoments;
use super::statistics::outer_square;
use glam::{DVec2, DVec3};

/// Returns the larger and the smaller principal variance of `s`, both at least 0. They are half the squared radii of the ellipse in thesis
/// 2.3.
pub fn principal_variances(s: DVec3) -> DVec2 {
    let (mean, half) = (0.5 * (s.x + s.y), 0.5 * (s.x - s.y));
    let major = mean + (half * half + s.z * s.z).sqrt();
    // The determinant gives the smaller variance without the cancellation of nearly equal numbers.
    let minor = (s.x * s.y - s.z * s.z).max(0.0) / major.max(1e-30);
    DVec2::new(major, minor)
}

/// Returns the larger principal variance of moments, from the unclamped covariance. Clamping would limit the correlation, which would
/// shorten the major axis of a ridge by a fraction of 6e-5.
fn major_variance(a: SlopeMoments) -> f64 {
    let s = a.second - outer_square(a.first);
    principal_variances(DVec3::new(s.x.max(0.0), s.y.max(0.0), s.z)).x
}

/// Packs the moments and the height into the texels of the two floating-point textures of a LEADR map: `(E[x], E[y], E[x²], E[y²])` and
/// `(E[xy], height)`.
pub fn pack_leadr(a: SlopeMoments, height: f64) -> ([f64; 4], [f64; 2]) {
    ([a.first.x, a.first.y, a.second.x, a.second.y], [a.second.z, height])
}

/// Unpacks the moments and the height of [`pack_leadr`].
pub fn unpack_leadr(a: [f64; 4], b: [f64; 2]) -> (SlopeMoments, f64) {
    (SlopeMoments { first: DVec2::new(a[0], a[1]), second: DVec3::new(a[2], a[3], b[0]) }, b[1])
}

/// Packs moments as five numbers in `[0, 1]` for fixed-point textures (LEAN mapping). Signed moments are halved and biased. Slopes are
/// divided by `limit` > 0, the steepest slope that can be stored.
///
/// Clamp steeper slopes before computing moments. Otherwise the packed texel is clamped.
pub fn pack_lean(a: SlopeMoments, limit: f64) -> [f64; 5] {
    let (first, second) = (a.first / limit, a.second / (limit * limit));
    [0.5 + 0.5 * first.x, 0.5 + 0.5 * first.y, second.x, second.y, 0.5 + 0.5 * second.z].map(|v| v.clamp(0.0, 1.0))
}

/// Unpacks the moments of [`pack_lean`].
pub fn unpack_lean(p: [f64; 5], limit: f64) -> SlopeMoments {
    let square = limit * limit;
    SlopeMoments {
        first: (DVec2::new(p[0], p[1]) * 2.0 - 1.0) * limit,
        second: DVec3::new(p[2], p[3], 2.0 * p[4] - 1.0) * square,
    }
}

/// Returns the largest error of a variance or covariance after [`pack_lean`] and rounding to fixed point with `levels` steps (255 for 8
/// bits). Surfaces with smaller variances cannot be stored. Add the error to the variances to avoid aliasing.
///
/// With `q = 1/levels`, the error is at most `q·limit` for a mean and `½q·limit²` for a second moment (`q·limit²` for the signed one). For
/// the product of two means, each at most `limit`, it is at most `2q·limit² + q²·limit²`.
pub fn lean_error(limit: f64, levels: f64) -> f64 {
    let q = 1.0 / levels;
    (3.0 + q) * q * limit * limit
}

/// Packs Baker's CLEAN map: the mean slope and `E[x² + y²]`. Both are linear in the samples.
pub fn pack_clean(a: SlopeMoments) -> DVec3 {
    a.first.extend(a.second.x + a.second.y)
}

/// Packs the thesis's untested proposal, for which [`clean_covariance`] returns the larger principal variance. Each mip level is packed
/// from all five moments. As the module explains, this map is not conservative between texels.
pub fn pack_clean_major(a: SlopeMoments) -> DVec3 {
    a.first.extend(a.first.length_squared() + 2.0 * major_variance(a))
}

/// Returns the isotropic covariance of [`pack_clean`] or [`pack_clean_major`], by thesis eq. 3.18 with `σ² = α²/2`.
pub fn clean_covariance(p: DVec3) -> DVec3 {
    let variance = (0.5 * (p.z - p.x * p.x - p.y * p.y)).max(0.0);
    DVec3::new(variance, variance, 0.0)
}

/// Packs this project's conservative CLEAN map: the mean slope and `|m|² + λ`. Each mip level is packed from all five moments, and any
/// linear filter may then average the texels.
pub fn pack_clean_conservative(a: SlopeMoments) -> DVec3 {
    a.first.extend(a.first.length_squared() + major_variance(a))
}

/// Returns the isotropic covariance of [`pack_clean_conservative`], which is at least the variance of the packed slopes in every direction.
pub fn clean_conservative_covariance(p: DVec3) -> DVec3 {
    let variance = (p.z - p.x * p.x - p.y * p.y).max(0.0);
    DVec3::new(variance, variance, 0.0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slopes::moments::{mix_moments, moments_covariance, moments_of_slope};
    use std::f64::consts::TAU;

    const SIZE: usize = 64;

    /// Samples the slopes at the texels of level 0 from a height field on `[0, 1]²`.
    fn sampled(height: impl Fn(f64, f64) -> f64) -> Vec<DVec2> {
        let d = 1e-5;
        let at = |i: usize| (i as f64 + 0.5) / SIZE as f64;
        let slope = |x: f64, y: f64| {
            DVec2::new(height(x + d, y) - height(x - d, y), height(x, y + d) - height(x, y - d)) / (2.0 * d)
        };
        (0..SIZE * SIZE).map(|i| slope(at(i % SIZE), at(i / SIZE))).collect()
    }

    /// Returns anisotropic, bimodal, rotating and sparse surfaces: ridges, facets, bumps and steps.
    fn surfaces() -> Vec<(&'static str, Vec<DVec2>)> {
        vec![
            ("ridges", sampled(|x, y| 0.02 * (TAU * (9.3 * x + 4.1 * y)).sin())),
            ("rings", sampled(|x, y| 0.01 * (80.0 * ((x - 0.3).powi(2) + (y - 0.6).powi(2)).sqrt()).sin())),
            (
                "roof tiles",
                sampled(|x, y| 0.05 * ((8.0 * x).fract() - 0.5).abs() + 0.02 * ((5.0 * y).fract() - 0.3).abs()),
            ),
            ("egg box", sampled(|x, y| 0.02 * (TAU * 7.0 * x).sin() * (TAU * 7.0 * y).cos())),
            ("bend", sampled(|x, y| 0.3 * (x - 0.5).powi(2) + 0.1 * x * y)),
            (
                "scratches",
                sampled(|x, y| if (11.0 * (x + 0.3 * y)).fract() < 0.1 { 0.01 * (300.0 * x).sin() } else { 0.0 }),
            ),
        ]
    }

    /// Returns one mip level: the mean of each square of `2^level` texels per side, packed by `pack`.
    fn level<T>(slopes: &[DVec2], level: u32, pack: impl Fn(SlopeMoments) -> T) -> Vec<T> {
        let block = 1 << level;
        let n = SIZE / block;
        (0..n * n)
            .map(|i| {
                let (x0, y0) = (i % n * block, i / n * block);
                let texels = (0..block * block).map(|k| slopes[(y0 + k / block) * SIZE + x0 + k % block]);
                let (mut sum, mut count) = (SlopeMoments::default(), 0.0);
                for slope in texels {
                    count += 1.0;
                    sum = mix_moments(sum, moments_of_slope(slope), 1.0 / count);
                }
                pack(sum)
            })
            .collect()
    }

    /// Returns the four texels and weights of a bilinear fetch at `(x, y)`, in texels of the level. The coordinates wrap.
    fn fetch(n: usize, x: f64, y: f64) -> [(usize, f64); 4] {
        let (x, y) = (x - 0.5, y - 0.5);
        let (i, j, u, v) = (x.floor(), y.floor(), x - x.floor(), y - y.floor());
        let at = |di: f64, dj: f64| (j + dj).rem_euclid(n as f64) as usize * n + (i + di).rem_euclid(n as f64) as usize;
        [
            (at(0.0, 0.0), (1.0 - u) * (1.0 - v)),
            (at(1.0, 0.0), u * (1.0 - v)),
            (at(0.0, 1.0), (1.0 - u) * v),
            (at(1.0, 1.0), u * v),
        ]
    }

    /// Returns the covariance over the same footprint, computed from the samples and their mean.
    fn exact(slopes: &[DVec2], level: u32, texels: &[(usize, f64); 4]) -> DVec3 {
        let block = 1 << level;
        let n = SIZE / block;
        let footprint = || {
            texels.iter().flat_map(move |&(i, w)| {
                let (x0, y0) = (i % n * block, i / n * block);
                (0..block * block)
                    .map(move |k| (slopes[(y0 + k / block) * SIZE + x0 + k % block], w / (block * block) as f64))
            })
        };
        let mean: DVec2 = footprint().map(|(x, w)| w * x).sum();
        footprint()
            .map(|(x, w)| w * DVec3::new((x - mean).x.powi(2), (x - mean).y.powi(2), (x - mean).x * (x - mean).y))
            .sum()
    }

    /// Tests every CLEAN form on every mip level, at texels and between them. Only the conservative form is never too small.
    #[test]
    fn clean_against_sampled_surfaces() {
        type Form = (&'static str, fn(SlopeMoments) -> DVec3, fn(DVec3) -> DVec3);
        let forms: [Form; 3] = [
            ("usual", pack_clean, clean_covariance),
            ("major (thesis)", pack_clean_major, clean_covariance),
            ("conservative", pack_clean_conservative, clean_conservative_covariance),
        ];
        println!("variance of the form relative to the samples' largest variance, and number of underestimates");
        // The number of underestimates of each form, at texel centres and between them.
        let mut short = [[0; 2]; 3];
        let mut total = [0; 2];
        let mut excess = [[0.0; 2]; 3];
        for (surface, slopes) in surfaces() {
            for (k, (name, pack, unpack)) in forms.iter().enumerate() {
                for between in [false, true] {
                    let (mut low, mut high, mut sum, mut under, mut n) = (f64::MAX, 0.0f64, 0.0, 0, 0);
                    for lod in 1..=5 {
                        let packed = level(&slopes, lod, pack);
                        let side = SIZE >> lod;
                        for i in 0..64 {
                            // The positions are a low-discrepancy sequence over the level.
                            let p = DVec2::new(0.7549 * f64::from(i), 0.5698 * f64::from(i)).fract() * side as f64;
                            let p = if between { p } else { p.floor() + 0.5 };
                            let texels = fetch(side, p.x, p.y);
                            let form = unpack(texels.iter().map(|&(i, w)| w * packed[i]).sum());
                            let s = exact(&slopes, lod, &texels);
                            // The largest variance in any direction.
                            let worst = 0.5 * (s.x + s.y + (s.x - s.y).hypot(2.0 * s.z));
                            if worst < 1e-6 {
                                continue; // A flat footprint cannot alias.
                            }
                            let ratio = form.x / worst;
                            (low, high, sum, n) = (low.min(ratio), high.max(ratio), sum + ratio, n + 1);
                            under += u32::from(ratio < 1.0 - 1e-9);
                        }
                    }
                    let location = if between { "between texels" } else { "at texels" };
                    let mean = sum / f64::from(n);
                    println!(
                        "{surface:10} {name:14} {location:14}: {low:.3} .. {high:.3}, mean {mean:.3}; {under} of {n} too small"
                    );
                    short[k][usize::from(between)] += under;
                    excess[k][usize::from(between)] += sum - f64::from(n);
                    if k == 0 {
                        total[usize::from(between)] += n;
                    }
                }
            }
        }
        for (k, (name, ..)) in forms.iter().enumerate() {
            println!(
                "{name}: too small {:?} of {total:?}, mean error {:+.1} % at texels, {:+.1} % between",
                short[k],
                100.0 * excess[k][0] / f64::from(total[0]),
                100.0 * excess[k][1] / f64::from(total[1])
            );
        }
        assert_eq!(short[2], [0, 0], "the conservative form must never be too small");
        assert_eq!(short[1][0], 0, "the thesis's form must be conservative at texels");
        assert!(short[1][1] > total[1] / 20, "the thesis's form must fail between texels");
        assert!(short[0][0] > total[0] / 2, "the usual form must be too small at most texels");
        assert!(excess[2][1] / f64::from(total[1]) < 0.6, "the conservative form must not be much too wide");
    }

    /// In fixed point, every covariance error is within the bound, and the largest error exceeds a fifth of the bound.
    #[test]
    fn lean_in_fixed_point() {
        for (bits, levels) in [(8, 255.0), (16, 65535.0)] {
            let limit = 1.5;
            let bound = lean_error(limit, levels);
            let mut worst = 0.0f64;
            for (_, slopes) in surfaces() {
                for lod in 1..=3 {
                    let clamp = |m: SlopeMoments| {
                        m.first.abs().max_element() <= limit && m.second.abs().max_element() <= limit * limit
                    };
                    for a in level(&slopes, lod, |a| a).into_iter().filter(|a| clamp(*a)) {
                        let stored = pack_lean(a, limit).map(|v| (v * levels).round() / levels);
                        let read = unpack_lean(stored, limit);
                        let raw = |a: SlopeMoments| {
                            a.second - DVec3::new(a.first.x * a.first.x, a.first.y * a.first.y, a.first.x * a.first.y)
                        };
                        worst = worst.max((raw(read) - raw(a)).abs().max_element());
                        let covariance = moments_covariance(read);
                        assert!(covariance.x * covariance.y >= covariance.z * covariance.z);
                    }
                }
            }
            println!("{bits} bits: largest error {worst:.1e}, bound {bound:.1e} (alpha {:.3})", (2.0 * bound).sqrt());
            assert!(worst <= bound && worst > 0.2 * bound);
        }
    }

    #[test]
    fn packing_errors_stay_within_bounds() {
        let a = SlopeMoments { first: DVec2::new(0.4, -0.2), second: DVec3::new(0.5, 0.3, -0.15) };
        let (p, q) = pack_leadr(a, 0.7);
        assert_eq!(unpack_leadr(p, q), (a, 0.7));
        let b = unpack_lean(pack_lean(a, 2.0), 2.0);
        assert!((a.first - b.first).length() + (a.second - b.second).length() < 1e-14);
        let s = DVec3::new(0.34, 0.26, -0.07);
        let l = principal_variances(s);
        assert!((l.x + l.y - s.x - s.y).abs() < 1e-15 && (l.x * l.y - (s.x * s.y - s.z * s.z)).abs() < 1e-15);
        assert!((clean_covariance(pack_clean(a)).x - 0.3).abs() < 1e-15);
        assert!((clean_conservative_covariance(pack_clean_conservative(a)).x - l.x).abs() < 1e-15);
        assert!((clean_covariance(pack_clean_major(a)).x - l.x).abs() < 1e-15);
        assert_eq!(principal_variances(DVec3::ZERO), DVec2::ZERO);
    }
}
