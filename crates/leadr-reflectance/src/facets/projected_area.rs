//! Projected areas of a Gaussian rough surface (LEADR 4.3), in a form without cotangents and poles.
//!
//! For a direction `w`, `a(w)` is the projected area of the mesosurface, and `b(w)` is the spread of the slope along `w`. The visible area
//! is `A(w) = a Φ(a/b) + b φ(a/b)`. Wherever the paper's `Λ` is defined, `A = a (1 + Λ)`. Unlike `Λ`, `A` stays finite and positive for a
//! back-facing mesosurface.

use super::normal_distribution::normal_tail_mean;
use crate::limits::{at_least, within};
use crate::slopes::statistics::covariance_times;
use glam::{DVec2, DVec3, Vec3Swizzles as _};

/// Returns `a(w)`, the projected area of the mesosurface per unit of macrosurface (LEADR eq. 14). The area is negative if the mesosurface
/// is back-facing.
pub fn meso_area(w: DVec3, m: DVec2) -> f64 {
    w.z - w.x * m.x - w.y * m.y
}

/// Returns `b(w)`, the standard deviation of the slope along `w` times sin θ (LEADR eq. 15).
pub fn slope_spread(w: DVec3, s: DVec3) -> f64 {
    at_least(w.x * w.x * s.x + w.y * w.y * s.y + 2.0 * w.x * w.y * s.z, 0.0).sqrt()
}

/// Returns `S w.xy`, the direction in which visible slopes shift, and the [`slope_spread`] computed from it.
pub(crate) fn spread_along(w: DVec3, s: DVec3) -> (DVec2, f64) {
    let across = covariance_times(s, w.xy());
    (across, at_least(across.dot(w.xy()), 0.0).sqrt())
}

/// Returns the area that only roughness makes visible, `A − max(a, 0) = b h(|a|/b)`. The area equals `a Λ` for `a > 0`.
pub fn rough_area(a: f64, b: f64) -> f64 {
    b * normal_tail_mean(a.abs() / b.max(1e-18))
}

/// Returns the visible projected area per unit of macrosurface, `A(w) = a Φ(a/b) + b φ(a/b)`. The area tends to `max(a, 0)` as `b → 0`.
pub fn visible_area(w: DVec3, m: DVec2, s: DVec3) -> f64 {
    let a = meso_area(w, m);
    a.max(0.0) + rough_area(a, slope_spread(w, s))
}

/// Tilts the mean slope towards the viewer just enough for a slope grid to have a visible node, which needs `a ≥ 1e-3 − λ b / 2`. `lambda`
/// is the half extent of the grid in standard deviations.
///
/// A front-facing mesosurface is not tilted. The tilt is continuous and points along `S wo`, the direction of the visible slopes. It
/// replaces the artificial micronormal of the paper's supplement (3.7). A viewer exactly opposite the displacement direction (`wo = −z`)
/// sees no facet of a height field, so the slope is not tilted.
pub fn face_viewer(wo: DVec3, m: DVec2, s: DVec3, lambda: f64) -> DVec2 {
    let across = covariance_times(s, wo.xy());
    let b2 = at_least(across.dot(wo.xy()), 0.0);
    let deficit = 1e-3 - 0.5 * lambda * b2.sqrt() - meso_area(wo, m);
    if deficit <= 0.0 {
        return m;
    }
    // Tilt a smooth surface (S → 0) along wo.xy.
    let along = across + 1e-6 * wo.xy();
    let gain = b2 + 1e-6 * wo.xy().length_squared();
    let tilted = m - along * (deficit / at_least(gain, 1e-12));
    DVec2::new(within(tilted.x, 1e6), within(tilted.y, 1e6))
}

/// Returns the change of slope along `wo.xy` that makes a back-facing mesosurface edge-on. The change is zero for a front-facing
/// mesosurface.
///
/// A back-facing surface is invisible, so its pixel actually shows other facets nearby. The error of the filtered mean slope is then about
/// the angle by which the surface is tilted beyond edge-on. The renderer shifts the mean slope by this tilt `d` and adds `d dᵀ` to the
/// covariance. With the unshifted mean slope, back-facing pixels are black specks along silhouettes and on the far sides of bumps. The tilt
/// is also finite for a viewer opposite the displacement direction, where no tilt is sufficient.
pub fn tilt_to_edge(wo: DVec3, m: DVec2) -> DVec2 {
    wo.xy() * (meso_area(wo, m).min(0.0) / wo.xy().length_squared().max(1e-4))
}

/// The factor `ε` of [`artificial_micronormal`] (supplement 3.7).
pub const ARTIFICIAL_BIAS: f64 = 1.01;
/// The weight of [`artificial_micronormal`] beside the weights of the other micronormals, which sum to 1 (supplement 3.7).
pub const ARTIFICIAL_WEIGHT: f64 = 1e-5;

/// Returns the artificial micronormal of the paper's supplement (3.7), `(n − ε (n·wo) wo)` with unit length. `wo` and the mesonormal `n` are
/// unit vectors.
///
/// For a back-facing mesonormal (`n·wo < 0`), the result faces the viewer by a cosine of `0.01 |n·wo|` before the normalisation, so it is
/// nearly edge-on. For a front-facing mesonormal, the result is back-facing and has no visible area. By default, the renderer has
/// [`face_viewer`] and [`tilt_to_edge`] instead.
pub fn artificial_micronormal(wo: DVec3, n: DVec3) -> DVec3 {
    let biased = n - ARTIFICIAL_BIAS * n.dot(wo) * wo;
    // The length is at least 0.01 for unit vectors.
    biased / at_least(biased.length(), 1e-3)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn visible_area_is_the_mean_of_clamped_facets() {
        // The reference is a midpoint sum over 10⁵ slopes along the view, for front-facing and back-facing mesosurfaces.
        let s = DVec3::new(0.3, 0.1, -0.08);
        for (theta, m) in [(0.3, DVec2::new(0.2, -0.1)), (1.4, DVec2::new(0.9, 0.3)), (1.55, DVec2::new(-1.0, 0.0))] {
            let (sin, cos) = f64::sin_cos(theta);
            let wo = DVec3::new(sin * 0.8, sin * 0.6, cos);
            let (a, b) = (meso_area(wo, m), slope_spread(wo, s));
            let n = 100_000;
            let sum: f64 = (0..n)
                .map(|i| {
                    let u = -10.0 + 20.0 * (f64::from(i) + 0.5) / f64::from(n);
                    crate::facets::normal_distribution::normal_pdf(u) * (a - b * u).max(0.0) * 20.0 / f64::from(n)
                })
                .sum();
            let area = visible_area(wo, m, s);
            assert!((area / sum - 1.0).abs() < 1e-7, "A = {area}, sum {sum} (a = {a})");
        }
    }

    #[test]
    fn artificial_micronormals_of_hidden_mesonormals_face_the_viewer() {
        let wo = DVec3::new(0.6, 0.0, 0.8);
        for n in [DVec3::new(-0.96, 0.0, 0.28), DVec3::new(-0.8, 0.0, 0.6), DVec3::new(-0.9, 0.3, 0.1).normalize(), -wo]
        {
            let found = artificial_micronormal(wo, n);
            assert!((found.length() - 1.0).abs() < 1e-12);
            // The component along the view is `(1 − ε) n·wo`, and the component across it is kept.
            let along = -0.01 * n.dot(wo);
            let across = (n - n.dot(wo) * wo).length();
            assert!((found.dot(wo) - along / along.hypot(across)).abs() < 1e-12, "{n}: {found}");
            assert!(n.dot(wo) >= 0.0 || found.dot(wo) > 0.0);
            assert!(artificial_micronormal(wo, -n).dot(wo) <= 0.0 || n.dot(wo) > 0.0);
        }
    }

    #[test]
    fn limits_of_smooth_surfaces() {
        let w = DVec3::new(0.6, 0.0, 0.8);
        assert_eq!(visible_area(w, DVec2::ZERO, DVec3::ZERO), 0.8);
        assert_eq!(visible_area(w, DVec2::new(2.0, 0.0), DVec3::ZERO), 0.0);
    }

    #[test]
    fn backfacing_slopes_become_edge_on() {
        let wo = DVec3::new(0.6, 0.36, (1.0f64 - 0.36 - 0.36 * 0.36).sqrt());
        assert_eq!(tilt_to_edge(wo, DVec2::new(0.3, 0.2)), DVec2::ZERO);
        let away = DVec2::new(4.0, -1.0);
        assert!(meso_area(wo, away) < -1.0);
        assert!(meso_area(wo, away + tilt_to_edge(wo, away)).abs() < 1e-12);
    }

    #[test]
    fn face_viewer_reaches_its_bound_and_no_further() {
        let wo = DVec3::new(0.99, 0.0, (1.0f64 - 0.99 * 0.99).sqrt());
        for s in [DVec3::ZERO, DVec3::new(0.04, 0.09, 0.02)] {
            let facing = DVec2::new(0.1, 0.5);
            assert_eq!(face_viewer(wo, facing, s, 1.8), facing);
            let away = DVec2::new(3.0, 0.5);
            let a = meso_area(wo, face_viewer(wo, away, s, 1.8));
            assert!((a - (1e-3 - 0.9 * slope_spread(wo, s))).abs() < 1e-12);
        }
    }
}
