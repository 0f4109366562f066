//! The colour of what is seen and lit, where paint, moss or snow follows the relief under a pixel.
//!
//! *Heights.* In Smith's model the heights are independent of the slopes, and a facet whose height has the rank `u` (0 at the deepest,
//! 1 at the highest) is seen from `o` with the probability `u^Λ(o)`, and seen and lit with `u^L`, where `1/(1 + L)` is the model's
//! masking-shadowing term: `L = Λ(o) + Λ(i)` in Smith's height-correlated form. So the colour that is seen is
//!
//! ```text
//! c(L) = (L + 1) E[c u^L]
//! ```
//!
//! whatever the profile of colours over heights. `E[c u^L]` is linear in the texels, so mips and taps filter it; it is kept for two
//! values of `L`, and a parabola in `L/(L + 2)` through these and the mean colour gives the others. That is exact at both for every
//! profile, and for all `L` where the colour is a line in `u`. A step, `1 − (1 − f)^(L+1)` for paint on the share `f` on top, errs by
//! .013 at most up to `L = 4`, where a line fitted to its covariance errs by up to .14 (tests). With a share `lit` of the visible area `A`,
//! `L + 1 = (A/a)/lit`, for every shadowing model that tells this share.
//!
//! *Slopes.* The regression of the colour on the slopes is `c + C S⁻¹ (s − m)`, `C` their covariance. For slopes that are weighted by
//! what is seen and how light falls on it, `w(s)`, Stein's lemma gives `E[w (s − m)] = S E[∇w]`, so `S` cancels: the colour changes by
//! `C · E[∇w]/E[w]`, the *score* here. `1/|N|` in the weight of diffuse light is one exponential of `|N|²`
//! ([`damped_gaussian`]); means of products of clamped cosines are taken to first order in the covariance of the two.

use super::diffuse::{clamped_mean, damped_gaussian, squared_normal_spread};
use super::slopes::{VISIBLE_TAIL, tilted_area};
use crate::reflectance::facets::normal_distribution::normal_ramp;
use crate::reflectance::facets::projected_area::{face_viewer, slope_spread};
use crate::reflectance::masking::correlated::DirectionArea;
use crate::reflectance::slopes::statistics::clamp_covariance;
use glam::{DVec2, DVec3, Vec3Swizzles as _};

/// `L` of the means that are filtered.
pub const RELIEF_COLOR_LOW: f64 = 1.0;
/// And of the second one.
pub const RELIEF_COLOR_HIGH: f64 = 4.0;
/// `L/(L + 2)` up to which the parabola follows the colour.
pub const MOST_SEEN_HEIGHT: f64 = 0.8;

/// How colours follow the relief under a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReliefColor {
    /// `2 E[c u]` less the mean colour.
    pub low: DVec3,
    /// `5 E[c u⁴]` less the mean colour.
    pub high: DVec3,
    /// Covariance with the slope along x.
    pub x: DVec3,
    /// And along y.
    pub y: DVec3,
}

/// `(L + 1) u^L` for the two that are filtered; `u`: rank of a height, 0 to 1.
#[must_use]
pub fn height_weights(u: f64) -> [f64; 2] {
    [2.0 * u, 5.0 * u.powi(4)]
}

/// `L/(L + 2)`, 0 to 1, of what is seen and lit. `lit`: share of the visible area that is lit
/// ([`lit_fraction`](crate::reflectance::masking::correlated::lit_fraction)).
#[must_use]
pub fn seen_height(o: &DirectionArea, lit: f64) -> f64 {
    let facing = o.meso.max(0.0) * lit.clamp(0.0, 1.0);
    ((o.visible - facing) / (o.visible + facing).max(1e-30)).clamp(0.0, 1.0)
}

/// `S⁻¹ (mean of the visible slopes − m)`: its product with a covariance of slopes and something is how the mean of that changes.
#[must_use]
pub fn seen_slopes_score(wo: DVec3, m: DVec2, s: DVec3) -> DVec2 {
    let s = clamp_covariance(s);
    let b = slope_spread(wo, s);
    let a = tilted_area(wo, m, b);
    let n = normal_ramp(a / b.max(1e-18));
    wo.xy() * (-n.cdf / clamped_mean(a, b).max(1e-3))
}

/// The same for slopes seen from `wo` and weighted by the cosine of light from `wi` on them.
#[must_use]
pub fn lit_slopes_score(wo: DVec3, wi: DVec3, m: DVec2, s: DVec3) -> DVec2 {
    let s = clamp_covariance(s);
    let (mut ao, mut ai) = (tilted_area(wo, m, slope_spread(wo, s)), tilted_area(wi, m, slope_spread(wi, s)));
    let m = face_viewer(wo, m, s, 2.0 * VISIBLE_TAIL);
    let t = 0.5 / squared_normal_spread(m, s).x;
    let g = damped_gaussian(m, s, t);
    let times = |w: DVec3| DVec2::new(g.s.x * w.x + g.s.z * w.y, g.s.z * w.x + g.s.y * w.y);
    let (across, along) = (times(wo), times(wi));
    let (bo, bi) = (across.dot(wo.xy()).max(0.0).sqrt(), along.dot(wi.xy()).max(0.0).sqrt());
    let (po, pi) = (1.0 / bo.max(1e-9), 1.0 / bi.max(1e-9));
    ao += 2.0 * t * across.dot(m);
    ai += 2.0 * t * along.dot(m);
    let (o, i) = (normal_ramp((ao * po).clamp(-13.0, 13.0)), normal_ramp((ai * pi).clamp(-13.0, 13.0)));
    let k = across.dot(wi.xy());
    let (area_o, area_i) = (clamped_mean(ao, bo).max(1e-3), clamped_mean(ai, bi).max(1e-3));
    let both = (area_o * area_i + k * o.cdf * i.cdf).max(0.1 * area_o * area_i);
    let by_o = (o.cdf * area_i + k * (o.pdf * po) * i.cdf).max(0.0);
    let by_i = (i.cdf * area_o + k * (i.pdf * pi) * o.cdf).max(0.0);
    let v = 2.0 * t * m + (wo.xy() * by_o + wi.xy() * by_i) / both;
    let tt = 2.0 * t;
    let det = 1.0 + tt * (s.x + s.y + tt * (s.x * s.y - s.z * s.z).max(0.0));
    DVec2::new(s.z * v.y * tt - (1.0 + tt * s.y) * v.x, s.z * v.x * tt - (1.0 + tt * s.x) * v.y) / det
}

/// The part of a score by which no colour leaves those that there are. Regression goes on for ever; where a half of all slopes has one
/// colour and the other half another, the change of the mean is `erf` of the slopes' move, and ends as that half ends. This takes that
/// for every profile.
#[must_use]
pub fn held_part(score: DVec2, s: DVec3) -> f64 {
    let s = clamp_covariance(s);
    let square = s.x * score.x * score.x + s.y * score.y * score.y + 2.0 * s.z * score.x * score.y;
    let moved = square.max(0.0).sqrt().clamp(1e-2, 13.0);
    std::f64::consts::FRAC_PI_2.sqrt() * (2.0 * normal_ramp(moved).cdf - 1.0) / moved
}

/// A score times its [`held_part`].
#[must_use]
pub fn held_score(score: DVec2, s: DVec3) -> DVec2 {
    score * held_part(score, s)
}

/// The colour, 0 to 1, whose mean over all facets is `mean`. `height`: [`seen_height`]; `score`: [`seen_slopes_score`] or
/// [`lit_slopes_score`], of [`held_score`].
#[must_use]
pub fn relief_color(mean: DVec3, r: &ReliefColor, height: f64, score: DVec2) -> DVec3 {
    let t = height.min(MOST_SEEN_HEIGHT);
    let by_height = 9.0 * t * (2.0 / 3.0 - t) * r.low + 4.5 * t * (t - 1.0 / 3.0) * r.high;
    (mean + by_height + score.x * r.x + score.y * r.y).clamp(DVec3::ZERO, DVec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::reflectance::facets::beckmann::beckmann_p22;
    use crate::reflectance::facets::projected_area::meso_area;

    /// The colour seen at `l` of a profile over ranks, by quadrature and by what is kept of it.
    fn seen(profile: impl Fn(f64) -> f64, l: f64) -> [f64; 2] {
        const N: u32 = 20_000;
        let mean = |weight: &dyn Fn(f64) -> f64| {
            let ranks = (0..N).map(|i| (f64::from(i) + 0.5) / f64::from(N));
            ranks.map(|u| weight(u) * profile(u)).sum::<f64>() / f64::from(N)
        };
        let flat = mean(&|_| 1.0);
        let [low, high] = [0, 1].map(|k| DVec3::splat(mean(&|u| height_weights(u)[k]) - flat));
        let r = ReliefColor { low, high, ..Default::default() };
        let got = relief_color(DVec3::splat(flat), &r, l / (l + 2.0), DVec2::ZERO).x;
        [mean(&|u| (l + 1.0) * u.powf(l)), got]
    }

    #[test]
    fn lines_and_steps_over_height() {
        let (mut worst, mut of_line) = (0.0f64, 0.0f64);
        for l in [0.0, 0.2, 0.5, 1.0, 1.5, 2.0, 3.0, 4.0] {
            let [want, got] = seen(|u| 0.2 + 0.5 * u, l);
            assert!((got - want).abs() < 1e-4, "a line at {l}: {got} instead of {want}");
            for f in [0.05, 0.1, 0.25, 0.5, 0.75, 0.9, 0.95] {
                let [want, got] = seen(|u| if u > 1.0 - f { 1.0 } else { 0.0 }, l);
                assert!((want - (1.0 - (1.0 - f).powf(l + 1.0))).abs() < 1e-3);
                let exact = l == RELIEF_COLOR_LOW || l == RELIEF_COLOR_HIGH;
                assert!(!exact || (got - want).abs() < 1e-6, "a step of {f} at {l}: {got} instead of {want}");
                worst = worst.max((got - want).abs());
                // f + 12 Cov(c, u) ((L + 1)/(L + 2) - 1/2)
                of_line = of_line.max((f + 3.0 * f * (1.0 - f) * l / (l + 2.0) - want).abs());
                // In cracks.
                let [want, got] = seen(|u| if u < f { 1.0 } else { 0.0 }, l);
                worst = worst.max((got - want).abs());
            }
        }
        println!("steps err by {worst:.4}, as lines by {of_line:.4}");
        assert!(worst < 0.015 && of_line > 5.0 * worst, "{worst} {of_line}");
    }

    /// Means over Gaussian slopes by brute force: of everything, of `x` and of `y`, weighted.
    fn brute(m: DVec2, s: DVec3, weight: impl Fn(DVec2) -> f64) -> DVec2 {
        let (mut all, mut moved) = (0.0, DVec2::ZERO);
        for j in -150..=150 {
            for k in -150..=150 {
                let d = DVec2::new(f64::from(j), f64::from(k)) * (5.0 / 150.0) * DVec2::new(s.x.sqrt(), s.y.sqrt());
                let w = beckmann_p22(d, DVec2::ZERO, s) * weight(m + d);
                all += w;
                moved += w * d;
            }
        }
        moved / all
    }

    #[test]
    fn scores_are_the_means_of_weighted_slopes() {
        let mut worst = 0.0f64;
        for s in [DVec3::new(0.04, 0.04, 0.0), DVec3::new(0.3, 0.1, 0.05), DVec3::new(0.5, 0.5, 0.0)] {
            for m in [DVec2::ZERO, DVec2::new(0.2, -0.1)] {
                for (theta_o, theta_i, phi) in
                    [(15.0, 40.0, 0.0), (45.0, 45.0, 180.0), (60.0, 30.0, 90.0), (75.0, 60.0, 150.0)]
                {
                    let at = |theta: f64, phi: f64| {
                        let (theta, phi) = (theta.to_radians(), phi.to_radians());
                        DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
                    };
                    let (wo, wi) = (at(theta_o, 20.0), at(theta_i, 20.0 + phi));
                    let times = |v: DVec2| DVec2::new(s.x * v.x + s.z * v.y, s.z * v.x + s.y * v.y);
                    let want = brute(m, s, |n| meso_area(wo, n).max(0.0));
                    let got = times(seen_slopes_score(wo, m, s));
                    assert!((got - want).length() < 2e-3, "seen: {got} instead of {want}");
                    let want = brute(m, s, |n| {
                        meso_area(wo, n).max(0.0) * meso_area(wi, n).max(0.0) / (1.0 + n.length_squared()).sqrt()
                    });
                    let got = times(lit_slopes_score(wo, wi, m, s));
                    worst = worst.max((got - want).length() / s.x.sqrt());
                }
            }
        }
        println!("scores err by {worst:.3} deviations of the slopes");
        // The worst is a very rough surface seen and lit at grazing angles.
        assert!(worst < 0.25, "{worst}");
    }

    /// White where slopes rise along x, black elsewhere, seen with slopes moved by so many deviations.
    #[test]
    fn colours_end_where_paint_ends() {
        let s = DVec3::new(0.25, 0.09, 0.03);
        let deviation = s.x.sqrt();
        let of_white = DVec2::new(s.x, s.z) * (std::f64::consts::TAU.sqrt().recip() / deviation);
        let r = ReliefColor { x: DVec3::splat(of_white.x), y: DVec3::splat(of_white.y), ..Default::default() };
        for moved in [-5.0, -2.0, -0.5, 0.0, 0.1, 1.0, 3.0] {
            // S⁻¹ of a move along the slopes' regression on x.
            let score = DVec2::new(moved / deviation, 0.0);
            let got = relief_color(DVec3::splat(0.5), &r, 0.0, held_score(score, s)).x;
            let want = normal_ramp(moved).cdf;
            assert!((got - want).abs() < 2e-4, "{moved}: {got} instead of {want}");
            let without = 0.5 + score.x * r.x.x;
            assert!(moved.abs() < 2.0 || (without - want).abs() > 0.2);
        }
    }

    #[test]
    fn snow_flips_with_the_light() {
        let s = DVec3::new(0.1, 0.1, 0.0);
        // Snow where slopes rise toward +x: facets that face -x.
        let r = ReliefColor { x: DVec3::splat(0.1), ..Default::default() };
        let color = |x: f64| {
            let wi = DVec3::new(x, 0.0, 0.7).normalize();
            relief_color(DVec3::splat(0.5), &r, 0.0, lit_slopes_score(DVec3::Z, wi, DVec2::ZERO, s)).x
        };
        assert!(color(-1.0) > 0.55 && color(1.0) < 0.45 && (color(1.0) + color(-1.0) - 1.0).abs() < 1e-9);
        assert!((color(0.0) - 0.5).abs() < 1e-12);
    }
}
