//! The visible slopes that reflect lit directions.
//!
//! The wider a lobe, the more of it lies below the mesosurface's horizon, where nothing is lit. At normal incidence, 3/4 of the lobe is
//! unlit for a slope deviation of 1, and 19/20 for a slope deviation of 2. Probes below the horizon are wasted. Let `N = (−slope, 1)` and
//! `N_m = (−m, 1)`. A facet then reflects a direction of height `(2 (wo·N) N·N_m − (wo·N_m) |N|²) / |N|²` above the mesosurface. The height
//! is positive within a conic. For `m = 0`, the conic is the disc about `−tan θ` of radius `1/cos θ`. The numerator is quadratic in the
//! slope, so a Gaussian weight can follow the height:
//!
//! ```text
//! weight(x) = exp(−l·x − ½ xᵀ D x)      x = slope − m
//! D = k Q,  Q = wo.z I + wo.xy mᵀ + m wo.xyᵀ − (wo.xy·m) I,   S' = (S⁻¹ + D)⁻¹
//! l = l₀/√(1 + 2 l₀ᵀS'l₀),   l₀ = .65 k √(cos θ) |N_m|² wo.xy
//! k = 2.7 cos θ r²/(1 + r²) / |N_m|³,   r = ½ tr S / 0.2
//! ```
//!
//! The weight decreases towards the horizon, and faster for rougher surfaces. Smooth surfaces are lit almost down to the horizon. The
//! square root in `l` keeps the shift of the mean below one standard deviation. Without this root, a flat conic with steep slopes along it
//! would shift the mean further. The weight times the slope density is another Gaussian, whose visible moments have closed forms. The
//! probes sample this Gaussian. Each probe is weighted by the lit fraction times its share, which is the inverse weight. Shares are exact
//! for any weight. The constants only affect the probe positions (`lab::quadrature_study::fit_probes`).

use super::slopes::VisibleSlopes;
use crate::slopes::statistics::covariance_times;
use glam::{DVec2, DVec3, Vec3Swizzles as _};

/// The value of `−ln weight` at the horizon, relative to the highest direction, for a very rough surface at normal incidence.
pub const LIT_FALL: f64 = 1.35;
/// The mean slope variance per axis at which half of [`LIT_FALL`] applies.
pub const LIT_HALF: f64 = 0.2;
/// The strength of the linear term in the weight, relative to the quadratic term.
pub const LIT_LEAN: f64 = 0.65;

/// The slopes weighted towards lit directions.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct LitSlopes {
    /// The mean of the weighted slopes of all facets.
    pub m: DVec2,
    /// The covariance of the weighted slopes.
    pub s: DVec3,
    /// The module's vector `l`.
    pub lean: DVec2,
    /// The module's matrix `D`, as `(xx, yy, xy)`.
    pub damp: DVec3,
    /// The logarithm of the mean weight of all facets.
    pub mean: f64,
}

/// Returns the weighted slopes for the result of [`visible_slopes`](super::slopes::visible_slopes).
pub fn lit_slopes(wo: DVec3, v: &VisibleSlopes) -> LitSlopes {
    let (m, s) = (v.m, v.s);
    let per = 1.0 / (1.0 + m.dot(m));
    let height = v.a.max(0.0) * per.sqrt();
    let r = (0.5 / LIT_HALF) * (s.x + s.y);
    let k = 2.0 * LIT_FALL * height * per.sqrt() * (r * r / (1.0 + r * r));
    let lean = LIT_LEAN * k * height.sqrt() * wo.xy();
    // If the conic is not an ellipse, keep only its flat direction.
    let even = wo.z.max(0.0);
    let across = wo.xy().dot(m);
    let part = even / (wo.xy().length() * m.length()).max(even).max(1e-9);
    let bend = part * DVec3::new(2.0 * wo.x * m.x - across, 2.0 * wo.y * m.y - across, wo.x * m.y + wo.y * m.x);
    let damp = k * per * (DVec3::new(even, even, 0.0) + bend);
    // Compute the weighted covariance (S⁻¹ + D)⁻¹.
    let det = (s.x * s.y - s.z * s.z).max(0.0);
    let both = det * (damp.x * damp.y - damp.z * damp.z).max(0.0);
    let share = 1.0 / (1.0 + s.x * damp.x + s.y * damp.y + 2.0 * s.z * damp.z + both);
    let cov = share * (s + det * DVec3::new(damp.y, damp.x, -damp.z));
    let moved = -covariance_times(cov, lean);
    let bound = 1.0 / (1.0 - 2.0 * lean.dot(moved)).max(1.0).sqrt();
    let (lean, moved) = (bound * lean, bound * moved);
    LitSlopes { m: m + moved, s: cov, lean, damp, mean: 0.5 * (share.ln() - lean.dot(moved)) }
}

/// Returns the logarithm of the inverse weight at the offset `x` from the mean slope.
pub fn lit_share(lit: &LitSlopes, x: DVec2) -> f64 {
    let d = lit.damp;
    lit.lean.dot(x) + 0.5 * (d.x * x.x * x.x + d.y * x.y * x.y) + d.z * x.x * x.y
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::integrals::reference::visible_mean;
    use crate::visible::slopes::visible_slopes;

    /// The weighted moments of the visible slopes equal the visible moments of the weighted slopes.
    #[test]
    fn the_weight_keeps_gaussians() {
        let (m, s) = (DVec2::new(0.2, -0.3), DVec3::new(0.8, 0.3, 0.2));
        let wo = DVec3::new(0.4, 0.5, 0.9).normalize();
        let all = visible_slopes(wo, m, s);
        let lit = lit_slopes(wo, &all);
        let v = visible_slopes(wo, lit.m, lit.s);
        let weighted = visible_mean(wo, m, s, 24, |x| {
            let w = (-lit_share(&lit, x - m)).exp();
            (w * x).extend(w)
        });
        let mean = lit.mean.exp() * v.area / all.area;
        assert!((weighted.z / mean - 1.0).abs() < 1e-6, "mean weight {} instead of {mean}", weighted.z);
        assert!((weighted.xy() / weighted.z - v.mean).length() < 1e-6);
    }

    #[test]
    fn smooth_surfaces_are_left_alone() {
        let (wo, s) = (DVec3::new(0.6, 0.0, 0.8), DVec3::new(1e-4, 1e-4, 0.0));
        let all = visible_slopes(wo, DVec2::ZERO, s);
        let lit = lit_slopes(wo, &all);
        assert!((lit.m - all.m).length() < 1e-8 && (lit.s - s).length() < 1e-8 && lit.mean.abs() < 1e-8);
    }
}
