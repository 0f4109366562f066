//! Transforms height derivatives per unit texture coordinate to slopes in an orthonormal frame.
//!
//! The transform is LEADR eq. 12, for any parametrisation and deformation. A point of the surface is `X + h N`. Let `T_s = ∂X/∂s + h ∂N/∂s`
//! be the derivative of the offset macrosurface. The tangent of the surface is then `T_s + h_s N` (since `N·N_s = 0`, the height moves the
//! point only along `N`). In the frame `z = N`, the normal `(−slope, 1)` is orthogonal to this tangent exactly when
//!
//! `slope · T_s.xy = h_s + T_s.z`, and the same for `t`.
//!
//! The term `T.z` is the tilt between the geometric normal and the displacement direction.

use super::statistics::{clamp_covariance, map_second_moments};
use crate::limits::MAX_SLOPE;
use glam::{DMat2, DVec2, DVec3};

/// The affine map `slope = linear · (h_s, h_t) + offset`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlopeMap {
    /// The linear part, whose columns are the responses to `h_s` and `h_t`, in units of one over length. In GLSL, the columns are
    /// `linear_s` and `linear_t`.
    pub linear: DMat2,
    /// The slope of the offset macrosurface without the height derivatives.
    pub offset: DVec2,
}

/// Returns the map for the tangents `ts` and `tt` (derivatives of the offset macrosurface by `s` and `t`) and the orthonormal frame `x`,
/// `y`, `z`. `z` is the displacement direction, and all vectors are in the same space.
///
/// For a surface edge-on to `z`, the magnitude of the determinant is clamped to at least 1e-4 of the squared tangent lengths. Its sign is
/// kept, which is negative on mirrored charts. The slopes of such a surface are large but finite. Zero tangents give zero.
pub fn slope_map(ts: DVec3, tt: DVec3, x: DVec3, y: DVec3, z: DVec3) -> SlopeMap {
    let s = DVec3::new(ts.dot(x), ts.dot(y), ts.dot(z));
    let t = DVec3::new(tt.dot(x), tt.dot(y), tt.dot(z));
    let det = s.x * t.y - s.y * t.x;
    let bound = (1e-4 * (s.length_squared() + t.length_squared())).max(1e-20);
    let inverse = if det < 0.0 { -1.0 } else { 1.0 } / det.abs().max(bound);
    let linear = DMat2::from_cols(DVec2::new(t.y, -t.x), DVec2::new(-s.y, s.x)) * inverse;
    SlopeMap { linear, offset: linear * DVec2::new(s.z, t.z) }
}

/// Returns the mean slope in the frame from `gradient = (E[h_s], E[h_t])`, with its magnitude clamped to [`MAX_SLOPE`].
pub fn map_mean_slope(map: &SlopeMap, gradient: DVec2) -> DVec2 {
    let bound = DVec2::splat(1e12);
    let slope = (map.linear * gradient + map.offset).clamp(-bound, bound);
    slope * (MAX_SLOPE / slope.length_squared().max(1e-12).sqrt()).min(1.0)
}

/// Returns the covariance in the frame, `linear S linearᵀ` (LEADR eq. 12), clamped to the usable range.
pub fn map_covariance(map: &SlopeMap, s: DVec3) -> DVec3 {
    clamp_covariance(map_second_moments(map.linear, s))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::frame::frame_about;

    #[test]
    fn is_the_normal_of_a_displaced_curved_patch() {
        // The surface is a skewed paraboloid X plus a height along N, which is not orthogonal to X. Its normal comes from central
        // differences.
        let x = |s: f64, t: f64| DVec3::new(2.0 * s + 0.3 * t, 0.5 * t - 0.2 * s, 0.4 * s * s - 0.3 * s * t);
        let n = |s: f64, t: f64| DVec3::new(-0.3 * s, 0.2 + 0.1 * t, 1.0).normalize();
        let h = |s: f64, t: f64| 0.1 * (3.0 * s).sin() + 0.07 * (2.0 * t + s).cos();
        for mirrored in [1.0, -1.0] {
            let (s0, t0, d) = (0.4, 0.7, 1e-5);
            let at = |s: f64, t: f64| x(s, mirrored * t) + h(s, t) * n(s, mirrored * t);
            let ps = (at(s0 + d, t0) - at(s0 - d, t0)) / (2.0 * d);
            let pt = (at(s0, t0 + d) - at(s0, t0 - d)) / (2.0 * d);
            let frame = frame_about(n(s0, mirrored * t0));
            // With a constant height, the surface is the offset macrosurface.
            let h0 = h(s0, t0);
            let offset = |s: f64, t: f64| x(s, mirrored * t) + h0 * n(s, mirrored * t);
            let ts = (offset(s0 + d, t0) - offset(s0 - d, t0)) / (2.0 * d);
            let tt = (offset(s0, t0 + d) - offset(s0, t0 - d)) / (2.0 * d);
            let gradient =
                DVec2::new((h(s0 + d, t0) - h(s0 - d, t0)) / (2.0 * d), (h(s0, t0 + d) - h(s0, t0 - d)) / (2.0 * d));
            let map = slope_map(ts, tt, frame.x, frame.y, frame.z);
            let slope = map_mean_slope(&map, gradient);
            let normal = (frame.z - slope.x * frame.x - slope.y * frame.y).normalize();
            let truth = ps.cross(pt).normalize() * mirrored;
            assert!((normal - truth).length() < 1e-8, "{normal} instead of {truth}");
        }
    }

    #[test]
    fn stretching_halves_slopes_and_quarters_variances() {
        let map = slope_map(DVec3::X * 2.0, DVec3::Y, DVec3::X, DVec3::Y, DVec3::Z);
        assert_eq!(map_mean_slope(&map, DVec2::new(1.0, 1.0)), DVec2::new(0.5, 1.0));
        assert_eq!(map_covariance(&map, DVec3::new(0.4, 0.2, 0.1)), DVec3::new(0.1, 0.2, 0.05));
    }

    #[test]
    fn degenerate_tangents_stay_finite() {
        for (ts, tt) in
            [(DVec3::ZERO, DVec3::ZERO), (DVec3::X, DVec3::X), (DVec3::Z, DVec3::X), (DVec3::X * 1e-12, DVec3::Y)]
        {
            let map = slope_map(ts, tt, DVec3::X, DVec3::Y, DVec3::Z);
            let (m, s) = (map_mean_slope(&map, DVec2::new(0.5, -0.5)), map_covariance(&map, DVec3::new(1.0, 2.0, 0.5)));
            assert!(m.is_finite() && m.length() <= MAX_SLOPE * (1.0 + 1e-12), "{m}");
            assert!(s.is_finite() && s.x <= MAX_SLOPE * MAX_SLOPE && s.y <= MAX_SLOPE * MAX_SLOPE, "{s}");
        }
    }
}
