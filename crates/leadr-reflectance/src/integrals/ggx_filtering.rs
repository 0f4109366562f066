//! Filters a displaced GGX surface. The method is a proposed solution to an open problem of the thesis (5.3).
//!
//! Slopes of independent displacements add (thesis 5.1). The filtered slope density is therefore a convolution of the base's GGX density of
//! roughness matrix `A` with the LEADR map's Gaussian of mean `m` and covariance `S`. The result is neither GGX nor Gaussian and has no
//! finite variance to match. But GGX is a mixture of Gaussians. If `e` is exponentially distributed, Gaussian slopes of covariance `A / 2e`
//! have exactly the GGX distribution (the bivariate t distribution with two degrees of freedom). The convolution is therefore also a
//! mixture of Gaussians, `P(x) = ∫₀^∞ exp(−e) N(x; m, S + A / 2e) de`,
//!
//! and every quantity linear in `P` is the same integral of its Gaussian form. [`convolved_p22`] and [`convolved_visible_area`] compute
//! reference values of these integrals. Shading uses one of two approximations:
//!
//! * [`filter_ggx`] is one GGX lobe of matrix `A + 2S`. This lobe is as accurate as any single GGX lobe if the base dominates the
//!   roughness. If displacement dominates, the single lobe lacks the round shoulders of the true lobe, and its tail is too strong.
//! * [`displaced_ggx`] is a GGX lobe plus a Beckmann lobe of the same shape. The GGX weight is approximately the fraction `t` of the
//!   roughness that comes from the base. (With a weight of exactly `t`, the far tail would be exact, since displacement does not change the
//!   far tail.) The sum is exact at `t = 0` and `t = 1`. The Smith terms belong to the mixture of both lobes, so the white furnace holds.
//!
//! `docs/measurements/ggx-filtering.md` compares these approximations with a single Beckmann lobe.

use crate::facets::beckmann::{beckmann_ndf, beckmann_p22};
use crate::facets::ggx::{ggx_ndf, ggx_p22, ggx_rough_area};
use crate::facets::projected_area::{meso_area, rough_area, slope_spread, visible_area};
use crate::limits::MIN_AREA;
use glam::{DVec2, DVec3};

/// Returns the nodes `(e, weight)` of a rule for `∫₀^∞ exp(−e) f(e) de`. The trapezoidal rule in `ln e` truncates 1e-6 of the mass near 0.
fn exponential_rule() -> impl Iterator<Item = (f64, f64)> {
    const STEP: f64 = 0.15;
    (0..=120).map(|i| {
        let e = (-14.0 + STEP * f64::from(i)).exp();
        (e, STEP * e * (-e).exp())
    })
}

/// Returns the slope covariance `S + A / 2e` of the mixture component `e`.
fn component(e: f64, a: DVec3, s: DVec3) -> DVec3 {
    s + a / (2.0 * e)
}

/// Returns the slope density of a GGX base of matrix `a` under Gaussian displacement of mean `m` and covariance `s`.
pub fn convolved_p22(slope: DVec2, m: DVec2, a: DVec3, s: DVec3) -> f64 {
    exponential_rule().map(|(e, w)| w * beckmann_p22(slope, m, component(e, a, s))).sum()
}

/// Returns the visible projected area of a GGX base under Gaussian displacement. The error is within 1e-3 at grazing angles, where the
/// truncated tail matters most.
pub fn convolved_visible_area(w: DVec3, m: DVec2, a: DVec3, s: DVec3) -> f64 {
    exponential_rule().map(|(e, weight)| weight * visible_area(w, m, component(e, a, s))).sum()
}

/// Returns the roughness matrix `A + 2S` of the single GGX lobe for a GGX base of matrix `a` under displacement of covariance `s`. The mean
/// slope of the map is unchanged.
pub fn filter_ggx(a: DVec3, s: DVec3) -> DVec3 {
    a + 2.0 * s
}

/// Returns the fraction of the roughness that comes from the base, `√(|A| / |A + 2S|)`. The fraction is 0 for a displaced ideal mirror
/// and 1 for a flat base.
///
/// The formula is `1 / √(1 + 2 tr(adj(A) S) / |A| + 4 |S| / |A|)`, because a difference of two determinants cancels small displacements.
pub fn base_share(a: DVec3, s: DVec3) -> f64 {
    let det = |v: DVec3| (v.x * v.y - v.z * v.z).max(0.0);
    let mixed = (a.y * s.x + a.x * s.y - 2.0 * a.z * s.z).max(0.0);
    1.0 / (1.0 + (2.0 * mixed + 4.0 * det(s)) / det(a).max(1e-30)).sqrt()
}

/// A mixture of a GGX surface of matrix `roughness` and weight `weight`, and a Beckmann surface of covariance `roughness / 2`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DisplacedGgx {
    /// The weight of the GGX lobe, from 0 to 1.
    pub weight: f64,
    /// The roughness matrix `(a_xx, a_yy, a_xy)` of both lobes.
    pub roughness: DVec3,
}

/// The widening of both lobes, fitted to minimise the largest `∫ |P − P̂|` over all fractions `t`. The test `the_constants_are_the_best`
/// checks the fit.
const WIDEN: f64 = 0.5;
/// The increase of the GGX weight above `t`, fitted together with `WIDEN`.
const FAVOUR: f64 = 0.15;

/// Returns the two lobes for a GGX base of matrix `a` under displacement of covariance `s`. The lobes are slightly wider than `A + 2S`,
/// because the convolution moves density out of the peak.
pub fn displaced_ggx(a: DVec3, s: DVec3) -> DisplacedGgx {
    let t = base_share(a, s);
    let hump = t.sqrt() * (1.0 - t);
    DisplacedGgx {
        weight: (t + FAVOUR * hump * (1.0 - t)).min(1.0),
        roughness: filter_ggx(a, s) * (1.0 + WIDEN * hump),
    }
}

/// Returns the slope density of the mixture.
pub fn displaced_ggx_p22(slope: DVec2, m: DVec2, d: &DisplacedGgx) -> f64 {
    let gaussian = beckmann_p22(slope, m, 0.5 * d.roughness);
    gaussian + d.weight * (ggx_p22(slope, m, d.roughness) - gaussian)
}

/// Returns the normal density `D(wh)` of the mixture per unit of macrosurface and solid angle. The density is 0 for `wh.z ≤ 0`.
pub fn displaced_ggx_ndf(wh: DVec3, m: DVec2, d: &DisplacedGgx) -> f64 {
    let gaussian = beckmann_ndf(wh, m, 0.5 * d.roughness);
    gaussian + d.weight * (ggx_ndf(wh, m, d.roughness) - gaussian)
}

/// Returns `A(w) − max(a, 0)` of the mixture, at the mesosurface's projected area `meso`.
fn displaced_rough_area(w: DVec3, meso: f64, d: &DisplacedGgx) -> f64 {
    let spread = slope_spread(w, d.roughness);
    let gaussian = rough_area(meso, spread * 0.5f64.sqrt());
    gaussian + d.weight * (ggx_rough_area(meso, spread) - gaussian)
}

/// Returns the visible projected area of the mixture. This area is linear in the distribution, so it is the weighted mean of the areas of
/// both lobes.
pub fn displaced_ggx_visible_area(w: DVec3, m: DVec2, d: &DisplacedGgx) -> f64 {
    let meso = meso_area(w, m);
    meso.max(0.0) + displaced_rough_area(w, meso, d)
}

/// Returns the height-correlated masking and shadowing of the mixture, `1 / (a_o (1 + Λo + Λi))` (LEADR eq. 13). The result is 0 for a
/// light below the mesosurface. Without `shadowing`, the result is one divided by the visible area.
pub fn displaced_ggx_masking_shadowing(wo: DVec3, wi: DVec3, m: DVec2, d: &DisplacedGgx, shadowing: bool) -> f64 {
    let visible = displaced_ggx_visible_area(wo, m, d).max(MIN_AREA);
    if !shadowing {
        return 1.0 / visible;
    }
    let (ao, ai) = (meso_area(wo, m).max(0.0), meso_area(wi, m).max(0.0));
    ai / (ai * visible + ao * displaced_rough_area(wi, ai, d)).max(1e-30)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::ggx::ggx_visible_area;
    use crate::quadrature::composite_gauss;
    use crate::slopes::grid::{slope_at, slope_cholesky};
    use std::f64::consts::PI;

    fn isotropic(v: f64) -> DVec3 {
        DVec3::new(v, v, 0.0)
    }

    /// Returns nodes `(r, weight, P(r))` of the exact radial density of a base `α² = t` under displacement of `2σ² = 1 − t`.
    fn profile(t: f64) -> Vec<(f64, f64, f64)> {
        composite_gauss(0.0, 0.5 * PI, 24, 8)
            .into_iter()
            .map(|(angle, w)| {
                let r = angle.tan();
                let p = convolved_p22(DVec2::new(r, 0.0), DVec2::ZERO, isotropic(t), isotropic(0.5 * (1.0 - t)));
                (r, w * 2.0 * PI * r * (1.0 + r * r), p)
            })
            .collect()
    }

    fn shape_error(exact: &[(f64, f64, f64)], p22: impl Fn(DVec2) -> f64) -> f64 {
        exact.iter().map(|&(r, w, p)| w * (p - p22(DVec2::new(r, 0.0))).abs()).sum()
    }

    /// Sums of sampled base slopes and displacement slopes have the density and the visible area of the convolution.
    #[test]
    fn the_convolution_is_that_of_samples() {
        let (m, a, s) = (DVec2::new(0.2, -0.1), DVec3::new(0.04, 0.09, 0.02), DVec3::new(0.05, 0.02, -0.01));
        let (base, bumps) = (slope_cholesky(a), slope_cholesky(s));
        let (n, width) = (400_000u32, 0.2);
        let bins = [DVec2::new(0.2, -0.1), DVec2::new(0.5, 0.2), DVec2::new(-0.4, -0.5), DVec2::new(1.0, 0.6)];
        let w = DVec3::new(0.8, 0.1, 0.35).normalize();
        let (mut hits, mut area, mut square) = ([0.0; 4], 0.0, 0.0);
        for i in 1..=n {
            // The samples are the additive sequence of the root of x⁵ = x + 1, which has low discrepancy in four dimensions.
            let u = |k: i32| (0.5 + f64::from(i) * 1.167_303_978_261_418_7f64.powi(-k)).fract();
            let ggx = DVec2::from_angle(2.0 * PI * u(1)) * (u(2) / (1.0 - u(2))).sqrt();
            let gauss = DVec2::from_angle(2.0 * PI * u(3)) * (-2.0 * (1.0 - u(4)).ln()).sqrt();
            let x = slope_at(ggx, slope_at(gauss, m, bumps), base);
            for (hit, bin) in hits.iter_mut().zip(bins) {
                *hit += f64::from(u8::from((x - bin).abs().max_element() < 0.5 * width)) / f64::from(n);
            }
            let seen = (w.z - w.x * x.x - w.y * x.y).max(0.0);
            area += seen / f64::from(n);
            square += seen * seen / f64::from(n);
        }
        let nodes = composite_gauss(-0.5 * width, 0.5 * width, 1, 6);
        for (hit, bin) in hits.into_iter().zip(bins) {
            let mut expected = 0.0;
            for &(x, wx) in &nodes {
                for &(y, wy) in &nodes {
                    expected += wx * wy * convolved_p22(bin + DVec2::new(x, y), m, a, s);
                }
            }
            println!("slopes near {bin}: {hit:.5} sampled, {expected:.5} by quadrature");
            assert!((hit - expected).abs() < 5.0 * (expected / f64::from(n)).sqrt());
        }
        let expected = convolved_visible_area(w, m, a, s);
        println!("visible area {area:.5} sampled, {expected:.5} by quadrature");
        assert!((area - expected).abs() < 5.0 * ((square - area * area) / f64::from(n)).sqrt() + 1e-3 * expected);
    }

    /// Measures the error of the best single lobe. Checks that no other pair of constants is better by more than a tenth.
    #[test]
    fn the_constants_are_the_best() {
        let profiles: Vec<_> = (1..32).map(|i| f64::from(i) / 32.0).map(|t| (t, profile(t))).collect();
        let error = |t: f64, exact: &[(f64, f64, f64)], widen: f64, favour: f64| {
            let hump = t.sqrt() * (1.0 - t);
            let d = DisplacedGgx { weight: t + favour * hump * (1.0 - t), roughness: isotropic(1.0 + widen * hump) };
            shape_error(exact, |x| displaced_ggx_p22(x, DVec2::ZERO, &d))
        };
        let worst =
            |widen: f64, favour: f64| profiles.iter().map(|(t, p)| error(*t, p, widen, favour)).fold(0.0, f64::max);
        let mut best = (f64::MAX, 0.0, 0.0);
        for i in 0..=10 {
            for j in 0..=10 {
                let (widen, favour) = (0.3 + 0.04 * f64::from(i), 0.04 * f64::from(j));
                let e = worst(widen, favour);
                best = if e < best.0 { (e, widen, favour) } else { best };
            }
        }
        println!(
            "best constants {:.2}, {:.2}: worst error {:.4}; those used {:.4}; zeros {:.4}",
            best.1,
            best.2,
            best.0,
            worst(WIDEN, FAVOUR),
            worst(0.0, 0.0)
        );
        println!("| share t | Beckmann | GGX of A + 2S | best single GGX, its factor on 2S | two lobes |");
        println!("|---|---|---|---|---|");
        for (t, exact) in profiles.iter().skip(1).step_by(4) {
            let ggx = |k: f64| shape_error(exact, |x| ggx_p22(x, DVec2::ZERO, isotropic(t + k * (1.0 - t))));
            let factors = (40..=140).map(|k| f64::from(k) / 100.0);
            let single = factors.map(|k| (ggx(k), k)).fold((f64::MAX, 0.0), |a, b| if b.0 < a.0 { b } else { a });
            let beckmann = shape_error(exact, |x| beckmann_p22(x, DVec2::ZERO, isotropic(0.5)));
            let two = error(*t, exact, WIDEN, FAVOUR);
            println!("| {t:.3} | {beckmann:.3} | {:.3} | {:.3}, {:.2} | {two:.3} |", ggx(1.0), single.0, single.1);
            if *t > 0.25 {
                assert!(ggx(1.0) < 1.02 * single.0, "a single GGX lobe of A + 2S is as good as any");
            }
        }
        assert!(worst(WIDEN, FAVOUR) < 1.1 * best.0 && best.0 < 0.35 * worst(0.0, 0.0));
    }

    /// Returns the errors `∫ |L̂ − L| dwi` of the lobe visible from `wo`, for Beckmann, for GGX, and for the two lobes. The lobes have
    /// masking only and F = 1, so the exact lobe integrates to one. With `dwi = 4 (wo·wh) dwh` the integral over slopes is
    /// `∫ |P̂/Â − P/A| max(0, wo·(−x, −y, 1))`.
    fn lobe_errors(wo: DVec3, m: DVec2, a: DVec3, s: DVec3) -> [f64; 3] {
        let (total, two) = (filter_ggx(a, s), displaced_ggx(a, s));
        let c = slope_cholesky(total);
        let areas =
            [visible_area(wo, m, 0.5 * total), ggx_visible_area(wo, m, total), displaced_ggx_visible_area(wo, m, &two)];
        let exact_area = convolved_visible_area(wo, m, a, s);
        let mut errors = [0.0; 3];
        for (angle, weight) in composite_gauss(0.0, 0.5 * PI, 10, 6) {
            let r = angle.tan();
            let ring = weight * r * (1.0 + r * r) * c.x * c.z * 2.0 * PI / 32.0;
            for k in 0..32 {
                let x = slope_at(DVec2::from_angle(2.0 * PI * (f64::from(k) + 0.5) / 32.0) * r, m, c);
                let seen = (wo.z - wo.x * x.x - wo.y * x.y).max(0.0);
                let exact = convolved_p22(x, m, a, s) / exact_area;
                let forms = [beckmann_p22(x, m, 0.5 * total), ggx_p22(x, m, total), displaced_ggx_p22(x, m, &two)];
                for ((e, p), area) in errors.iter_mut().zip(forms).zip(areas) {
                    *e += ring * seen * (p / area - exact).abs();
                }
            }
        }
        errors
    }

    /// Prints the table in `docs/measurements/ggx-filtering.md`.
    #[test]
    fn lobes_against_ground_truth() {
        let (mut worst, mut mean, mut n) = ([0.0f64; 3], [0.0; 3], 0.0);
        let mut row = |name: &str, m: DVec2, a: DVec3, s: DVec3| {
            let mut line = format!("| {name} ");
            for degrees in [0.0f64, 45.0, 75.0] {
                let (sin, cos) = degrees.to_radians().sin_cos();
                let e = lobe_errors(DVec3::new(sin * 0.4f64.cos(), sin * 0.4f64.sin(), cos), m, a, s);
                line += &format!("| {:.3} / {:.3} / {:.3} ", e[0], e[1], e[2]);
                for k in 0..3 {
                    worst[k] = worst[k].max(e[k]);
                    mean[k] += e[k];
                }
                n += 1.0;
            }
            println!("{line}|");
        };
        println!("| base, displacement | 0° | 45° | 75° |\n|---|---|---|---|");
        for alpha in [0.05, 0.1, 0.2, 0.4] {
            for sigma in [0.05, 0.1, 0.2, 0.4] {
                row(&format!("α {alpha}, σ {sigma}"), DVec2::ZERO, isotropic(alpha * alpha), isotropic(sigma * sigma));
            }
        }
        let diagonal = DVec3::new(0.0452, 0.0452, 0.0448);
        for (name, m, a, s) in [
            ("α 0.1, ridges σ 0.3 × 0.02", DVec2::ZERO, isotropic(0.01), DVec3::new(0.09, 0.0004, 0.0)),
            ("α 0.3, ridges σ 0.3 × 0.02 at 45°", DVec2::ZERO, isotropic(0.09), diagonal),
            ("brushed α 0.4 × 0.05, σ 0.15", DVec2::ZERO, DVec3::new(0.16, 0.0025, 0.0), isotropic(0.0225)),
            ("α 0.2, σ 0.2, mean slope (−0.6, 0.3)", DVec2::new(-0.6, 0.3), isotropic(0.04), isotropic(0.04)),
        ] {
            row(name, m, a, s);
        }
        let mean = mean.map(|e| e / n);
        println!("\nBeckmann / GGX / two lobes: mean {mean:.3?}, worst {worst:.3?}");
        assert!(mean[2] < 0.25 * mean[0].min(mean[1]) && worst[2] < 0.6 * worst[0].min(worst[1]));
    }

    /// The white furnace of the mixture holds: `∫ P̂ max(0, wo·(−x, −y, 1)) / Â = 1`.
    #[test]
    fn white_furnace() {
        for degrees in [0.0f64, 60.0, 85.0, 89.0] {
            let (sin, cos) = degrees.to_radians().sin_cos();
            let (wo, m) = (DVec3::new(sin, 0.0, cos), DVec2::new(0.3, -0.2));
            let d = displaced_ggx(DVec3::new(0.04, 0.02, 0.01), DVec3::new(0.03, 0.05, -0.02));
            let c = slope_cholesky(d.roughness);
            let mut sum = 0.0;
            for (angle, wa) in composite_gauss(0.0, 0.5 * PI, 40, 8) {
                let r = angle.tan();
                for (phi, wp) in composite_gauss(0.0, 2.0 * PI, 40, 8) {
                    let x = slope_at(DVec2::from_angle(phi) * r, m, c);
                    let seen = (wo.z - wo.x * x.x - wo.y * x.y).max(0.0);
                    sum += wa * wp * r * (1.0 + r * r) * c.x * c.z * displaced_ggx_p22(x, m, &d) * seen;
                }
            }
            let albedo = sum * displaced_ggx_masking_shadowing(wo, wo, m, &d, false);
            println!("{degrees}°: {albedo:.7}");
            assert!((albedo - 1.0).abs() < 2e-4);
        }
    }

    #[test]
    fn exact_at_both_ends_and_finite() {
        let a = DVec3::new(0.04, 0.02, 0.01);
        assert_eq!(displaced_ggx(a, DVec3::ZERO), DisplacedGgx { weight: 1.0, roughness: a });
        assert!(displaced_ggx(DVec3::ZERO, a).weight < 1e-5);
        for a in [DVec3::ZERO, DVec3::splat(1e30), DVec3::new(1e-30, 4.0, 9.0)] {
            for s in [DVec3::ZERO, DVec3::splat(1e4), DVec3::new(1.0, 0.0, 0.0)] {
                let d = displaced_ggx(a, s);
                for w in [DVec3::ZERO, DVec3::X, DVec3::NEG_Z, DVec3::Z] {
                    assert!(displaced_ggx_ndf(w, DVec2::splat(1e6), &d).is_finite(), "{d:?}");
                    assert!(displaced_ggx_masking_shadowing(w, DVec3::X, DVec2::ZERO, &d, true).is_finite(), "{d:?}");
                }
            }
        }
    }
}
