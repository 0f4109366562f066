//! Rotates slope statistics of surface parts into one frame and combines them.
//!
//! A normal `(−s, 1)` in one frame has the coordinates `n = R (−s, 1)` in another frame, where its slope is `s' = −n.xy / n.z`. This
//! projective map is linear to first order about the mean slope, with the derivatives `∂s'/∂s_j = (R_j.xy + s' R_j.z) / n.z`, where `R_j`
//! are the columns of `R`. A facet over a unit area of the old plane covers the area `n.z` of the new plane, since both areas are
//! projections of the same facet. The moments of several surfaces over one plane are the area-weighted mean of the surfaces' moments (LEADR
//! 4.1).

use super::statistics::{map_second_moments, outer_square};
use glam::{DMat2, DMat3, DVec2, DVec3};

/// A part of a surface over a common plane.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SlopePart {
    /// The mean slope.
    pub mean: DVec2,
    /// The covariance `(s_xx, s_yy, s_xy)`.
    pub covariance: DVec3,
    /// The area on the plane, in any unit.
    pub area: f64,
}

/// Rotates the mean and the covariance of a surface part into another frame. The part has unit area on its own plane. The columns of
/// `rotation` are the axes of the old frame in the new frame. The result is accurate to first order about the mean normal. Normals with z
/// below 0.1 in the new frame are raised to 0.1.
pub fn rotate_slopes(rotation: DMat3, mean: DVec2, covariance: DVec3) -> SlopePart {
    let n = rotation * DVec3::new(-mean.x, -mean.y, 1.0);
    let z = n.z.max(0.1 * n.length());
    let slope = -n.truncate() / z;
    let by = |column: DVec3| (column.truncate() + slope * column.z) / z;
    let linear = DMat2::from_cols(by(rotation.x_axis), by(rotation.y_axis));
    SlopePart { mean: slope, covariance: map_second_moments(linear, covariance), area: z }
}

/// Returns the union of two parts over the same plane.
pub fn join_slopes(a: SlopePart, b: SlopePart) -> SlopePart {
    let area = a.area + b.area;
    let t = if area > 0.0 { b.area / area } else { 0.0 };
    let d = b.mean - a.mean;
    let spread = outer_square(d) * (t * (1.0 - t));
    SlopePart { mean: a.mean.lerp(b.mean, t), covariance: a.covariance.lerp(b.covariance, t) + spread, area }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slopes::moments::{mix_moments, moments_covariance, moments_of_distribution};
    use glam::DQuat;

    fn rotation(axis: DVec3, angle: f64) -> DMat3 {
        DMat3::from_quat(DQuat::from_axis_angle(axis.normalize(), angle))
    }

    /// Rotates four slopes of the given mean and covariance separately, and weights them by area.
    fn rotated_one_by_one(rotation: DMat3, mean: DVec2, s: DVec3) -> SlopePart {
        let a = DVec2::new(s.x.sqrt(), s.z / s.x.sqrt());
        let b = DVec2::new(0.0, (s.y - a.y * a.y).sqrt());
        let root = 2f64.sqrt();
        let slopes = [a, -a, b, -b].map(|d| mean + d * root);
        let rotated = slopes.map(|s| rotation * DVec3::new(-s.x, -s.y, 1.0));
        let area: f64 = rotated.iter().map(|n| n.z).sum();
        let (mut first, mut second) = (DVec2::ZERO, DVec3::ZERO);
        for n in rotated {
            let slope = -n.truncate() / n.z;
            first += slope * (n.z / area);
            second += DVec3::new(slope.x * slope.x, slope.y * slope.y, slope.x * slope.y) * (n.z / area);
        }
        let square = DVec3::new(first.x * first.x, first.y * first.y, first.x * first.y);
        SlopePart { mean: first, covariance: second - square, area: area / 4.0 }
    }

    #[test]
    fn small_spreads_rotate_exactly() {
        for (axis, angle) in [(DVec3::X, 0.3), (DVec3::new(1.0, -2.0, 0.7), 0.4), (DVec3::Z, 1.1)] {
            for mean in [DVec2::ZERO, DVec2::new(0.4, -0.3)] {
                let shape = DVec3::new(1.0, 0.5, 0.3);
                // The absolute error falls with the spread, and the relative error with the variance.
                let mut before = f64::INFINITY;
                for variance in [1e-2, 1e-4, 1e-6] {
                    let s = shape * variance;
                    let (got, want) = (
                        rotate_slopes(rotation(axis, angle), mean, s),
                        rotated_one_by_one(rotation(axis, angle), mean, s),
                    );
                    let error =
                        (got.covariance - want.covariance).length() / variance + (got.mean - want.mean).length();
                    assert!(
                        error < 4.0 * variance + 1e-9 && error <= before + 1e-9,
                        "{axis} {angle}: {got:?} {want:?}"
                    );
                    assert!((got.area - want.area).abs() < 1e-12);
                    before = error;
                }
            }
        }
    }

    #[test]
    fn rotation_about_normal_and_back_is_identity() {
        let (mean, s) = (DVec2::new(0.2, 0.1), DVec3::new(0.2, 0.1, 0.05));
        let r = rotation(DVec3::new(0.3, 1.0, 0.2), 0.35);
        let there = rotate_slopes(r, mean, s);
        let back = rotate_slopes(r.transpose(), there.mean, there.covariance);
        assert!((back.mean - mean).length() < 1e-12 && (back.covariance - s).length() < 1e-12);
        assert!((back.area * there.area - 1.0).abs() < 1e-12);
    }

    #[test]
    fn parts_join_as_their_moments_mix() {
        let part = |x: f64, area| SlopePart {
            mean: DVec2::new(x, -0.5 * x),
            covariance: DVec3::new(0.1 + x * x, 0.2, 0.05),
            area,
        };
        let (a, b, c) = (part(0.3, 1.0), part(-0.7, 3.0), part(1.1, 0.5));
        let joined = join_slopes(a, b);
        let moments = |p: SlopePart| moments_of_distribution(p.mean, p.covariance);
        let mixed = mix_moments(moments(a), moments(b), 0.75);
        assert!((joined.mean - mixed.first).length() < 1e-14);
        assert!((joined.covariance - moments_covariance(mixed)).length() < 1e-14);
        let (left, right) = (join_slopes(joined, c), join_slopes(a, join_slopes(b, c)));
        assert!((left.covariance - right.covariance).length() < 1e-14 && (left.mean - right.mean).length() < 1e-14);
        assert_eq!(join_slopes(SlopePart::default(), a).covariance, a.covariance);
    }

    #[test]
    fn back_facing_surfaces_stay_finite() {
        let away = rotate_slopes(rotation(DVec3::X, 2.5), DVec2::new(0.1, 3.0), DVec3::new(0.3, 0.3, 0.1));
        assert!(away.mean.is_finite() && away.mean.length() <= 10.0 && away.covariance.is_finite());
        assert!(away.area > 0.0);
    }
}
