//! Orthonormal frames and the octahedral map.

use glam::{DVec2, DVec3};

/// An orthonormal, right-handed frame.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    /// The first tangent.
    pub x: DVec3,
    /// The second tangent.
    pub y: DVec3,
    /// The third axis, around which the frame is built.
    pub z: DVec3,
}

/// Returns an orthonormal frame around the unit vector `z` (Frisvad 2012; Duff et al. 2017).
///
/// Below the equator, the code computes `1 / (1 + z.z)` as `(1 − z.z) / (z.x² + z.y²)`, which keeps full precision down to the only
/// discontinuity, `(0, 0, −1)`. (The copysign form of Duff et al. jumps along the whole equator.)
pub fn frame_about(z: DVec3) -> Frame {
    let r2 = z.x * z.x + z.y * z.y;
    if z.z < 0.0 && r2 < 1e-30 {
        return Frame { x: DVec3::X, y: DVec3::NEG_Y, z };
    }
    let a = if z.z >= 0.0 { 1.0 / (1.0 + z.z) } else { (1.0 - z.z) / r2 };
    let xy = -z.x * z.y * a;
    Frame { x: DVec3::new(1.0 - z.x * z.x * a, xy, -z.x), y: DVec3::new(xy, 1.0 - z.y * z.y * a, -z.y), z }
}

/// Returns the coordinates of a world direction in the frame.
pub fn to_frame(f: &Frame, world: DVec3) -> DVec3 {
    DVec3::new(world.dot(f.x), world.dot(f.y), world.dot(f.z))
}

/// Returns the world direction that has these frame coordinates.
pub fn from_frame(f: &Frame, local: DVec3) -> DVec3 {
    f.x * local.x + f.y * local.y + f.z * local.z
}

/// Maps a unit vector to its octahedral point in `[−1, 1]²` (Meyer et al. 2010).
pub fn octahedral_encode(n: DVec3) -> DVec2 {
    let p = DVec2::new(n.x, n.y) / (n.x.abs() + n.y.abs() + n.z.abs()).max(1e-30);
    if n.z >= 0.0 {
        return p;
    }
    let sign = |v: f64| if v >= 0.0 { 1.0 } else { -1.0 };
    DVec2::new((1.0 - p.y.abs()) * sign(p.x), (1.0 - p.x.abs()) * sign(p.y))
}

/// Returns the unit vector of an octahedral point in `[−1, 1]²`.
pub fn octahedral_decode(e: DVec2) -> DVec3 {
    let z = 1.0 - e.x.abs() - e.y.abs();
    let t = (-z).max(0.0);
    let fold = |v: f64| if v >= 0.0 { v - t } else { v + t };
    DVec3::new(fold(e.x), fold(e.y), z).normalize()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn directions() -> impl Iterator<Item = DVec3> {
        let axes = [DVec3::X, DVec3::NEG_X, DVec3::Y, DVec3::NEG_Y, DVec3::Z, DVec3::NEG_Z];
        let near_pole = (0..40).map(|i| {
            let r = 10f64.powi(-(i / 4));
            let (s, c) = f64::from(i).sin_cos();
            DVec3::new(0.9 * r * c, 0.9 * r * s, -(1.0 - 0.81 * r * r).sqrt())
        });
        let spiral = (0..500).map(|i| {
            let z = 1.0 - 2.0 * (f64::from(i) + 0.5) / 500.0;
            let (s, c) = (2.399_963 * f64::from(i)).sin_cos();
            DVec3::new((1.0 - z * z).sqrt() * c, (1.0 - z * z).sqrt() * s, z)
        });
        axes.into_iter().chain(near_pole).chain(spiral)
    }

    #[test]
    fn frames_are_orthonormal_and_right_handed() {
        for n in directions() {
            let f = frame_about(n);
            assert!((f.x.cross(f.y) - n).length() < 1e-14, "{n}");
            assert!((f.x.length() - 1.0).abs() < 1e-14 && f.x.dot(f.y).abs() < 1e-14, "{n}");
            assert!(
                (from_frame(&f, to_frame(&f, DVec3::new(1.0, 2.0, 3.0))) - DVec3::new(1.0, 2.0, 3.0)).length() < 1e-13
            );
        }
    }

    #[test]
    fn frames_are_continuous_across_the_equator() {
        let (above, below) = (DVec3::new(0.6, 0.8, 1e-9).normalize(), DVec3::new(0.6, 0.8, -1e-9).normalize());
        assert!((frame_about(above).x - frame_about(below).x).length() < 1e-8);
    }

    #[test]
    fn octahedral_round_trip() {
        for n in directions() {
            let e = octahedral_encode(n);
            assert!(e.x.abs() <= 1.0 && e.y.abs() <= 1.0);
            assert!((octahedral_decode(e) - n).length() < 1e-14, "{n}");
        }
    }
}
