//! Rusinkiewicz' half/difference parametrisation of a pair of directions (thesis eq. 1.8).

use glam::DVec3;

/// The half vector `wh`, and the light direction `wd` in a frame whose z axis is `wh`. Both are unit vectors. `wd.z = cos θ_d` is the
/// argument of the Fresnel term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct HalfDifference {
    /// The half vector `(wi + wo) / |wi + wo|`.
    pub wh: DVec3,
    /// The difference vector `Rot_y(−θ_h) Rot_z(−φ_h) wi`, with `wd.z ≥ 0`.
    pub wd: DVec3,
}

/// Returns `(sin θ, cos φ, sin φ)` of a direction, with `φ = 0` at the poles.
fn angles(w: DVec3) -> (f64, f64, f64) {
    let sin = (w.x * w.x + w.y * w.y).sqrt();
    if sin < 1e-18 { (0.0, 1.0, 0.0) } else { (sin, w.x / sin, w.y / sin) }
}

/// Returns the half and difference vectors of the unit directions `wo` and `wi` (thesis eq. 1.8).
///
/// Opposite directions have no half vector. Instead, `wh` is the highest direction orthogonal to `wi`, which is the limit in the plane of
/// incidence. [`half_difference_to_directions`] recovers the pair from this direction.
pub fn directions_to_half_difference(wo: DVec3, wi: DVec3) -> HalfDifference {
    let sum = wi + wo;
    let length2 = sum.length_squared();
    // The sum is (|sum|² / 2) wi plus a vector orthogonal to wi. For short sums, rounding destroys the component along wi.
    let across = sum - sum.dot(wi) * wi;
    let wh = if length2 > 1.0 {
        sum / length2.sqrt()
    } else if across.length_squared() > 1e-36 {
        (across + 0.5 * length2 * wi).normalize()
    } else {
        let (sin, cos_phi, sin_phi) = angles(wi);
        DVec3::new(-wi.z * cos_phi, -wi.z * sin_phi, sin)
    };
    let (sin, cos_phi, sin_phi) = angles(wh);
    let (x, y) = (cos_phi * wi.x + sin_phi * wi.y, cos_phi * wi.y - sin_phi * wi.x);
    HalfDifference { wh, wd: DVec3::new(wh.z * x - sin * wi.z, y, sin * x + wh.z * wi.z) }
}

/// Returns `(wo, wi)` from the half and difference vectors, as unit vectors (thesis eq. 1.8).
pub fn half_difference_to_directions(p: &HalfDifference) -> (DVec3, DVec3) {
    let (sin, cos_phi, sin_phi) = angles(p.wh);
    let x = p.wh.z * p.wd.x + sin * p.wd.z;
    let wi = DVec3::new(cos_phi * x - sin_phi * p.wd.y, sin_phi * x + cos_phi * p.wd.y, p.wh.z * p.wd.z - sin * p.wd.x);
    // The dot product wi·wh is wd.z.
    (2.0 * p.wd.z * p.wh - wi, wi)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns directions over the whole sphere, on the axes and next to them.
    fn directions() -> Vec<DVec3> {
        let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        let near = [1e-3, 1e-6, 1e-9, 1e-12, 1e-16, 1e-20];
        let mut all: Vec<DVec3> = (0..60)
            .map(|i| {
                let z: f64 = 1.0 - 2.0 * (f64::from(i) + 0.5) / 60.0;
                let (s, c) = (2.399_963 * f64::from(i)).sin_cos();
                DVec3::new((1.0 - z * z).sqrt() * c, (1.0 - z * z).sqrt() * s, z)
            })
            .collect();
        for axis in axes {
            all.push(axis);
            all.extend(near.map(|e| (axis + e * DVec3::new(0.3, -0.7, 0.5)).normalize()));
        }
        all
    }

    #[test]
    fn round_trip_of_every_pair_of_directions() {
        // Tests all pairs of directions: opposite, nearly opposite, equal, on the poles and on the horizon.
        let (mut worst, mut worst_unit) = (0.0f64, 0.0f64);
        let mut opposite = 0;
        for wo in directions() {
            for wi in directions().into_iter().chain([-wo, wo, (1e-8 * DVec3::X - wo).normalize()]) {
                opposite += u32::from((wo + wi).length() < 1e-7);
                let p = directions_to_half_difference(wo, wi);
                let (o, i) = half_difference_to_directions(&p);
                worst = worst.max((o - wo).length()).max((i - wi).length());
                worst_unit = worst_unit.max((p.wh.length() - 1.0).abs()).max((p.wd.length() - 1.0).abs());
                assert!(p.wd.z >= -1e-15 && (p.wd.z - wo.dot(p.wh)).abs() < 1e-7, "{wo} {wi}");
            }
        }
        println!("half/difference round trip: worst error {worst:.1e}, lengths {worst_unit:.1e}; {opposite} opposite");
        assert!(worst < 1e-14 && worst_unit < 1e-14 && opposite > 100);
    }

    #[test]
    fn round_trip_of_half_and_difference() {
        let mut worst = 0.0f64;
        for wh in directions() {
            for wd in directions().into_iter().filter(|d| d.z > 1e-3) {
                let (wo, wi) = half_difference_to_directions(&HalfDifference { wh, wd });
                let back = directions_to_half_difference(wo, wi);
                worst = worst.max((back.wh - wh).length());
                // Near the poles, the azimuth of wh is only as accurate as the tiny x and y of wh. The same holds for wd.
                if wh.z.abs() < 0.999 {
                    worst = worst.max((back.wd - wd).length());
                }
            }
        }
        println!("half/difference from half and difference: worst error {worst:.1e}");
        assert!(worst < 1e-11);
    }

    #[test]
    fn is_the_rotation_of_the_thesis() {
        let (theta, phi) = (0.7f64, 2.1f64);
        let wh = DVec3::new(theta.sin() * phi.cos(), theta.sin() * phi.sin(), theta.cos());
        let wi = DVec3::new(0.3, -0.2, 0.9).normalize();
        let wo = 2.0 * wi.dot(wh) * wh - wi;
        let rotated = glam::DQuat::from_rotation_y(-theta) * glam::DQuat::from_rotation_z(-phi) * wi;
        let p = directions_to_half_difference(wo, wi);
        assert!((p.wd - rotated).length() < 1e-14 && (p.wh - wh).length() < 1e-14);
    }
}
