//! The visible and lit colour where paint, moss or snow correlates with the relief under a pixel.
//!
//! *Heights.* In Smith's model, heights are independent of slopes. A facet of height rank `u` (0 is deepest, 1 is highest) is visible from
//! `o` with probability `u^Λ(o)`. Such a facet is visible and lit with probability `u^L`, where `1/(1 + L)` is the masking-shadowing term:
//! `L = Λ(o) + Λ(i)` in Smith's height-correlated form. For any profile of colour over height, the visible colour is then
//!
//! ```text
//! c(L) = (L + 1) E[c u^L]
//! ```
//!
//! The mean `E[c u^L]` is linear in the texels, so texture filters apply to it. Textures store this mean for two values of `L`. A parabola
//! in `L/(L + 2)` interpolates the two stored values and the mean colour. The result is exact at both values for every profile, and at all
//! `L` if the colour is linear in `u`. A step, `1 − (1 − f)^(L+1)` for paint on the top fraction `f`, has an error of at most 0.013 up to
//! `L = 4`. A line fitted to its covariance has an error of up to 0.14 (see the tests). If `lit` is the lit fraction of the visible area
//! `A`, `L + 1 = (A/a)/lit` for every shadowing model.
//!
//! *Slopes.* The regression of colour on slopes is `c + C S⁻¹ (s − m)`, where `C` is the covariance of colour and slopes. Let `w(s)` weight
//! slopes by visibility and lighting. Stein's lemma gives `E[w (s − m)] = S E[∇w]`, so `S` cancels and the colour changes by
//! `C · E[∇w]/E[w]`. The ratio `E[∇w]/E[w]` is the *score*. A second application, with the second derivatives of `w`, gives the covariance
//! of the weighted slopes. If half of the slopes are white, the visible fraction of white is the part on the white side of a Gaussian with
//! this mean and width. One exponential of `|N|²` approximates `1/|N|` in the diffuse weight ([`damped_gaussian`]). Means of products of
//! clamped cosines are first order in their covariance.

use super::diffuse::{clamped_mean, damped_gaussian, squared_normal_spread};
use super::slopes::{VISIBLE_TAIL, tilted_area};
use crate::facets::normal_distribution::normal_ramp;
use crate::facets::projected_area::{face_viewer, slope_spread};
use crate::masking::correlated::DirectionArea;
use crate::slopes::statistics::{clamp_covariance, covariance_times, outer_square};
use glam::{DMat2, DVec2, DVec3, Vec3Swizzles as _};

/// The exponent `L` of the first filtered mean.
pub const RELIEF_COLOR_LOW: f64 = 1.0;
/// The exponent `L` of the second filtered mean.
pub const RELIEF_COLOR_HIGH: f64 = 4.0;
/// The largest `L/(L + 2)` of the parabola. Larger values are clamped.
pub const MOST_SEEN_HEIGHT: f64 = 0.8;
/// The smallest fraction of variance that weighted slopes keep.
pub const NARROWEST_SLOPES: f64 = 0.1;

/// The correlation of colour with the relief under a pixel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct ReliefColor {
    /// The value of `2 E[c u]` minus the mean colour.
    pub low: DVec3,
    /// The value of `5 E[c u⁴]` minus the mean colour.
    pub high: DVec3,
    /// The covariance of colour with the slope along x.
    pub x: DVec3,
    /// The covariance of colour with the slope along y.
    pub y: DVec3,
}

/// Returns `(L + 1) u^L` for the two stored values of `L`, where `u` is the rank of a height, from 0 to 1.
pub fn height_weights(u: f64) -> [f64; 2] {
    [2.0 * u, 5.0 * u.powi(4)]
}

/// Returns `L/(L + 2)` for the facets that are visible and lit, from 0 to 1. `lit` is the lit fraction of the visible area
/// ([`lit_fraction`](crate::masking::correlated::lit_fraction)).
pub fn seen_height(o: &DirectionArea, lit: f64) -> f64 {
    let facing = o.meso.max(0.0) * lit.clamp(0.0, 1.0);
    ((o.visible - facing) / (o.visible + facing).max(1e-30)).clamp(0.0, 1.0)
}

/// The change of the slopes' mean and covariance under a weight for visibility and lighting.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SlopesScore {
    /// The vector `S⁻¹ (mean of the weighted slopes − m)`. Multiplied by the covariance of the slopes and any value, it gives the change of
    /// this value's mean.
    pub moved: DVec2,
    /// The matrix `S⁻¹ (covariance of the weighted slopes − S) S⁻¹`, as `(xx, yy, xy)`.
    pub narrowed: DVec3,
}

/// Returns the score of slopes visible from `wo`.
pub fn seen_slopes_score(wo: DVec3, m: DVec2, s: DVec3) -> SlopesScore {
    let s = clamp_covariance(s);
    let b = slope_spread(wo, s);
    let a = tilted_area(wo, m, b);
    let per = 1.0 / b.max(1e-9);
    let n = normal_ramp((a * per).clamp(-13.0, 13.0));
    let area = clamped_mean(a, b).max(1e-3);
    let moved = n.cdf / area;
    SlopesScore { moved: -moved * wo.xy(), narrowed: (n.pdf * per / area - moved * moved) * outer_square(wo.xy()) }
}

/// Returns the score of slopes visible from `wo`, weighted by the cosine of the light from `wi` on each facet.
pub fn lit_slopes_score(wo: DVec3, wi: DVec3, m: DVec2, s: DVec3) -> SlopesScore {
    let s = clamp_covariance(s);
    let (mut ao, mut ai) = (tilted_area(wo, m, slope_spread(wo, s)), tilted_area(wi, m, slope_spread(wi, s)));
    let m = face_viewer(wo, m, s, 2.0 * VISIBLE_TAIL);
    let t = 0.5 / squared_normal_spread(m, s).x;
    let g = damped_gaussian(m, s, t);
    let (across, along) = (covariance_times(g.s, wo.xy()), covariance_times(g.s, wi.xy()));
    let (bo, bi) = (across.dot(wo.xy()).max(0.0).sqrt(), along.dot(wi.xy()).max(0.0).sqrt());
    let (po, pi) = (1.0 / bo.max(1e-9), 1.0 / bi.max(1e-9));
    ao += 2.0 * t * across.dot(m);
    ai += 2.0 * t * along.dot(m);
    let (xo, xi) = ((ao * po).clamp(-13.0, 13.0), (ai * pi).clamp(-13.0, 13.0));
    let (o, i) = (normal_ramp(xo), normal_ramp(xi));
    let k = across.dot(wi.xy());
    let (area_o, area_i) = (clamped_mean(ao, bo).max(1e-3), clamped_mean(ai, bi).max(1e-3));
    let both = (area_o * area_i + k * o.cdf * i.cdf).max(0.1 * area_o * area_i);
    let by_o = (o.cdf * area_i + k * (o.pdf * po) * i.cdf).max(0.0);
    let by_i = (i.cdf * area_o + k * (i.pdf * pi) * o.cdf).max(0.0);
    let by_oo = o.pdf * po * (area_i - k * po * xo * i.cdf).max(0.0);
    let by_ii = i.pdf * pi * (area_o - k * pi * xi * o.cdf).max(0.0);
    let by_oi = (o.cdf * i.cdf + k * (o.pdf * po) * (i.pdf * pi)).max(0.0);
    let v = (wo.xy() * by_o + wi.xy() * by_i) / both;
    let mixed = DVec3::new(2.0 * wo.x * wi.x, 2.0 * wo.y * wi.y, wo.x * wi.y + wo.y * wi.x);
    let h = (by_oo * outer_square(wo.xy()) + by_ii * outer_square(wi.xy()) + by_oi * mixed) / both - outer_square(v);
    let v = v + 2.0 * t * m;
    // The exponential gives B = (1 + 2tS)⁻¹. The score is then −B v, and the slopes narrow by B h B − 2t B.
    let tt = 2.0 * t;
    let det = 1.0 + tt * (s.x + s.y + tt * (s.x * s.y - s.z * s.z).max(0.0));
    let b = DMat2::from_cols_array(&[1.0 + tt * s.y, -tt * s.z, -tt * s.z, 1.0 + tt * s.x]) * (1.0 / det);
    let narrowed = b * DMat2::from_cols_array(&[h.x, h.z, h.z, h.y]) * b - b * tt;
    SlopesScore { moved: -(b * v), narrowed: DVec3::new(narrowed.x_axis.x, narrowed.y_axis.y, narrowed.x_axis.y) }
}

/// Returns the change of the mean colour. Unlike a linear regression, the change saturates when all visible slopes have one colour, and
/// sooner if the visible slopes are narrower. The function models every profile as a surface with two colours, each on half of the slopes.
/// `s` is the covariance of the slopes that the colours follow.
pub fn slopes_change(r: &ReliefColor, score: &SlopesScore, s: DVec3) -> DVec3 {
    let s = clamp_covariance(s);
    let change = score.moved.x * r.x + score.moved.y * r.y;
    // The variance of the colours along their regression is Cᵀ S⁻¹ C, bounded by the largest variance of colours in 0..1.
    let quadratic = |m: DVec3| m.x * r.x * r.x + m.y * r.y * r.y + 2.0 * m.z * r.x * r.y;
    let explained = quadratic(DVec3::new(s.y, s.x, -s.z)) / (s.x * s.y - s.z * s.z).max(1e-18);
    let explained = explained.clamp(DVec3::splat(1e-9), DVec3::splat(0.25));
    // This is the relative variance of the weighted slopes along the regression.
    let variance = (1.0 + quadratic(score.narrowed) / explained).clamp(DVec3::splat(NARROWEST_SLOPES), DVec3::ONE);
    let held = |change: f64, explained: f64, variance: f64| {
        let width = variance.sqrt().recip();
        let moved = (change.abs() * width / explained.sqrt()).max(1e-2);
        change * width * std::f64::consts::FRAC_PI_2.sqrt() * (2.0 * normal_ramp(moved).cdf - 1.0) / moved
    };
    DVec3::from_array([0, 1, 2].map(|c| held(change[c], explained[c], variance[c])))
}

/// Returns the visible colour, from 0 to 1. `mean` is the mean colour over all facets. `height` is [`seen_height`], and `by_slope` is
/// [`slopes_change`].
pub fn relief_color(mean: DVec3, r: &ReliefColor, height: f64, by_slope: DVec3) -> DVec3 {
    let t = height.min(MOST_SEEN_HEIGHT);
    let by_height = 9.0 * t * (2.0 / 3.0 - t) * r.low + 4.5 * t * (t - 1.0 / 3.0) * r.high;
    (mean + by_height + by_slope).clamp(DVec3::ZERO, DVec3::ONE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::beckmann::beckmann_p22;
    use crate::facets::projected_area::meso_area;
    use std::f64::consts::TAU;

    /// Returns the visible colour of a height profile at `l`, by quadrature and by the stored parabola.
    fn seen(profile: impl Fn(f64) -> f64, l: f64) -> [f64; 2] {
        const N: u32 = 20_000;
        let mean = |weight: &dyn Fn(f64) -> f64| {
            let ranks = (0..N).map(|i| (f64::from(i) + 0.5) / f64::from(N));
            ranks.map(|u| weight(u) * profile(u)).sum::<f64>() / f64::from(N)
        };
        let flat = mean(&|_| 1.0);
        let [low, high] = [0, 1].map(|k| DVec3::splat(mean(&|u| height_weights(u)[k]) - flat));
        let r = ReliefColor { low, high, ..Default::default() };
        let got = relief_color(DVec3::splat(flat), &r, l / (l + 2.0), DVec3::ZERO).x;
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
                // The fitted line is f + 12 Cov(c, u) ((L + 1)/(L + 2) − 1/2).
                of_line = of_line.max((f + 3.0 * f * (1.0 - f) * l / (l + 2.0) - want).abs());
                // This profile has paint in cracks.
                let [want, got] = seen(|u| if u < f { 1.0 } else { 0.0 }, l);
                worst = worst.max((got - want).abs());
            }
        }
        println!("error of steps {worst:.4}, as lines {of_line:.4}");
        assert!(worst < 0.015 && of_line > 5.0 * worst, "{worst} {of_line}");
    }

    /// Samples slopes by brute force. Returns their differences from the mean, with their weights.
    fn weighted(m: DVec2, s: DVec3, weight: impl Fn(DVec2) -> f64) -> Vec<(DVec2, f64)> {
        let steps = -150..150;
        let slopes =
            steps.clone().flat_map(|j| steps.clone().map(move |k| DVec2::new(f64::from(j), f64::from(k)) + 0.5));
        let slopes = slopes.map(|d| d * (5.0 / 150.0) * DVec2::new(s.x.sqrt(), s.y.sqrt()));
        let all: Vec<_> = slopes.map(|d| (d, beckmann_p22(d, DVec2::ZERO, s) * weight(m + d))).collect();
        let sum = all.iter().map(|(_, w)| w).sum::<f64>();
        all.into_iter().map(|(d, w)| (d, w / sum)).collect()
    }

    fn mean(all: &[(DVec2, f64)]) -> DVec2 {
        all.iter().map(|&(d, w)| d * w).sum()
    }

    fn covariance(all: &[(DVec2, f64)]) -> DVec3 {
        let centre = mean(all);
        all.iter().map(|&(d, w)| outer_square(d - centre) * w).sum()
    }

    fn times(s: DVec3, score: &SlopesScore) -> (DVec2, DVec3) {
        let matrix = |m: DVec3| DMat2::from_cols_array(&[m.x, m.z, m.z, m.y]);
        let wide = matrix(s) * matrix(score.narrowed) * matrix(s);
        (matrix(s) * score.moved, DVec3::new(wide.x_axis.x, wide.y_axis.y, wide.x_axis.y))
    }

    fn for_all(mut each: impl FnMut(DVec3, DVec3, DVec2, DVec3)) {
        for s in [DVec3::new(0.04, 0.04, 0.0), DVec3::new(0.3, 0.1, 0.05), DVec3::new(0.5, 0.5, 0.0)] {
            for m in [DVec2::ZERO, DVec2::new(0.2, -0.1)] {
                for (theta_o, theta_i, phi) in [
                    (15.0, 40.0, 0.0),
                    (45.0, 45.0, 180.0),
                    (60.0, 30.0, 90.0),
                    (75.0, 60.0, 150.0),
                    (80.0, 20.0, 60.0),
                ] {
                    let at = |theta: f64, phi: f64| {
                        let (theta, phi) = (theta.to_radians(), phi.to_radians());
                        DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos())
                    };
                    each(at(theta_o, 20.0), at(theta_i, 20.0 + phi), m, s);
                }
            }
        }
    }

    fn seen_from(wo: DVec3) -> impl Fn(DVec2) -> f64 {
        move |n| meso_area(wo, n).max(0.0)
    }

    fn seen_and_lit(wo: DVec3, wi: DVec3) -> impl Fn(DVec2) -> f64 {
        move |n| meso_area(wo, n).max(0.0) * meso_area(wi, n).max(0.0) / (1.0 + n.length_squared()).sqrt()
    }

    #[test]
    fn scores_are_the_moments_of_weighted_slopes() {
        let (mut worst, mut worst_width) = (0.0f64, 0.0f64);
        for_all(|wo, wi, m, s| {
            let want = weighted(m, s, seen_from(wo));
            let (moved, wider) = times(s, &seen_slopes_score(wo, m, s));
            assert!((moved - mean(&want)).length() < 2e-3, "seen: {moved} instead of {}", mean(&want));
            let wide = covariance(&want);
            assert!((s + wider - wide).length() < 2e-3, "seen: {} instead of {wide}", s + wider);
            let want = weighted(m, s, seen_and_lit(wo, wi));
            let (moved, wider) = times(s, &lit_slopes_score(wo, wi, m, s));
            worst = worst.max((moved - mean(&want)).length() / s.x.sqrt());
            worst_width = worst_width.max((s + wider - covariance(&want)).length() / s.x);
        });
        println!("error of scores: {worst:.3} slope deviations, {worst_width:.3} of the variance");
        // The worst case is a very rough surface viewed and lit at grazing angles.
        assert!(worst < 0.25 && worst_width < 0.4, "{worst} {worst_width}");
    }

    /// Returns a surface that is white where slopes rise along a direction, and black elsewhere.
    fn half_white(s: DVec3, along: DVec2) -> ReliefColor {
        let toward = DVec2::new(s.x * along.x + s.z * along.y, s.z * along.x + s.y * along.y);
        let of_white = toward / (TAU * toward.dot(along)).sqrt();
        ReliefColor { x: DVec3::splat(of_white.x), y: DVec3::splat(of_white.y), ..Default::default() }
    }

    #[test]
    fn half_white_relief_matches_weighted_slopes() {
        let (mut seen, mut wide, mut lit) = (0.0f64, 0.0f64, 0.0f64);
        for_all(|wo, wi, m, s| {
            for along in [DVec2::X, DVec2::Y, DVec2::new(-0.6, 0.8)] {
                let r = half_white(s, along);
                let white =
                    |all: &[(DVec2, f64)]| all.iter().filter(|(d, _)| d.dot(along) > 0.0).map(|(_, w)| w).sum::<f64>();
                let want = white(&weighted(m, s, seen_from(wo)));
                let score = seen_slopes_score(wo, m, s);
                seen = seen.max((0.5 + slopes_change(&r, &score, s).x - want).abs());
                let unnarrowed = SlopesScore { narrowed: DVec3::ZERO, ..score };
                wide = wide.max((0.5 + slopes_change(&r, &unnarrowed, s).x - want).abs());
                let want = white(&weighted(m, s, seen_and_lit(wo, wi)));
                lit = lit.max((0.5 + slopes_change(&r, &lit_slopes_score(wo, wi, m, s), s).x - want).abs());
            }
        });
        println!("error of white: visible {seen:.4}, lit {lit:.4}; with unchanged width {wide:.4}");
        assert!(seen < 0.03 && lit < 0.17 && wide > 3.0 * seen, "{seen} {lit} {wide}");
    }

    #[test]
    fn colours_stop_at_paint_edges() {
        let s = DVec3::new(0.25, 0.09, 0.03);
        let deviation = s.x.sqrt();
        let r = half_white(s, DVec2::X);
        for moved in [-5.0, -2.0, -0.5, 0.0, 0.1, 1.0, 3.0] {
            // The score is S⁻¹ times a shift along the slopes' regression on x.
            let score = SlopesScore { moved: DVec2::new(moved / deviation, 0.0), ..Default::default() };
            let got = relief_color(DVec3::splat(0.5), &r, 0.0, slopes_change(&r, &score, s)).x;
            let want = normal_ramp(moved).cdf;
            assert!((got - want).abs() < 2e-4, "{moved}: {got} instead of {want}");
            let without = 0.5 + score.moved.x * r.x.x;
            assert!(moved.abs() < 2.0 || (without - want).abs() > 0.2);
        }
    }

    /// For any covariance, colours change by no more than their range, and results are never NaN.
    #[test]
    fn changes_are_bounded() {
        for s in [DVec3::ZERO, DVec3::new(1e-12, 1e-12, 0.0), DVec3::new(1.0, 0.0, 0.0), DVec3::new(0.3, 0.3, 0.3)] {
            for moved in [DVec2::ZERO, DVec2::new(1e6, -1e6), DVec2::new(0.0, 2.0)] {
                for narrowed in [DVec3::ZERO, DVec3::splat(-1e9), DVec3::splat(1e9)] {
                    let r = ReliefColor {
                        x: DVec3::new(0.1, 0.0, -0.3),
                        y: DVec3::new(0.0, 1e-9, 0.2),
                        ..Default::default()
                    };
                    let change = slopes_change(&r, &SlopesScore { moved, narrowed }, s);
                    assert!(
                        change.abs().max_element() <= 0.6267 && change.is_finite(),
                        "{s} {moved} {narrowed}: {change}"
                    );
                }
            }
        }
    }

    #[test]
    fn snow_flips_with_the_light() {
        let s = DVec3::new(0.1, 0.1, 0.0);
        // Snow lies on slopes that rise towards +x, whose facets face −x.
        let r = ReliefColor { x: DVec3::splat(0.1), ..Default::default() };
        let color = |x: f64| {
            let wi = DVec3::new(x, 0.0, 0.7).normalize();
            let change = slopes_change(&r, &lit_slopes_score(DVec3::Z, wi, DVec2::ZERO, s), s);
            relief_color(DVec3::splat(0.5), &r, 0.0, change).x
        };
        assert!(color(-1.0) > 0.55 && color(1.0) < 0.45 && (color(1.0) + color(-1.0) - 1.0).abs() < 1e-9);
        assert!((color(0.0) - 0.5).abs() < 1e-12);
    }
}
