//! Blends a detail normal with a base normal, both from normal maps.
//!
//! Let `x_b` and `x_d` be the slopes of the base and the detail. If heights add, the slope is `x_b + x_d` ([`blend_partial_derivatives`]).
//! Layers of LEADR maps add in the same way ([`add_moments`](super::moments::add_moments)). If the detail lies *on* the base and rotates
//! with it, the blend is a rotation ([`blend_reoriented`]). For slopes of size ε, the blends have these properties:
//!
//! | blend | slope, less `x_b + x_d` | flat base gives the detail | flat detail gives the base |
//! |---|---|---|---|
//! | partial derivatives | 0 | yes | yes |
//! | reoriented | ε³ | yes | yes |
//! | whiteout | ε³ | yes | yes |
//! | BlendXY | ε³ | yes | yes |
//! | UDN | ε³ | no, it is flattened | yes |
//! | linear | ε: half of the sum | no | no |
//!
//! All blends are finite for finite arguments and return unit vectors. `base` and `detail` are unit normals with `z > 0`. Each function
//! documents what else it accepts.

use glam::DVec3;

/// Returns `n` normalised, or z if `n` has no direction.
fn unit(n: DVec3) -> DVec3 {
    let length = n.length();
    if length > 1e-12 { n / length } else { DVec3::Z }
}

/// Blends by reoriented normal mapping, which applies the shortest rotation from z to `base` to `detail` (Barré-Brisebois and Hill 2012).
/// The function accepts any unit vectors. A base along −z negates `detail`.
pub fn blend_reoriented(base: DVec3, detail: DVec3) -> DVec3 {
    let t = base + DVec3::Z;
    let u = detail * DVec3::new(-1.0, -1.0, 1.0);
    // The rotation equals two reflections, with t.z = |t|²/2.
    unit(t * (2.0 * t.dot(u) / t.length_squared().max(1e-12)) - u)
}

/// Blends by the whiteout method, which adds the x and y of the normals and multiplies their z. Normals below the horizon are clamped to
/// it.
pub fn blend_whiteout(base: DVec3, detail: DVec3) -> DVec3 {
    unit((base.truncate() + detail.truncate()).extend(base.z.max(0.0) * detail.z.max(0.0)))
}

/// Blends by the UDN method, which adds the x and y of the detail to the base. Normals below the horizon are clamped to it.
pub fn blend_udn(base: DVec3, detail: DVec3) -> DVec3 {
    unit((base.truncate() + detail.truncate()).extend(base.z.max(0.0)))
}

/// Blends by BlendXY, which adds the x and y of the normals and computes z from the unit length (Chan 2018, Algorithm 4). Sums longer
/// than 1 are shortened to 1. With Chan's `max(…, 0)`, the resulting normals would be longer than 1.
pub fn blend_xy(base: DVec3, detail: DVec3) -> DVec3 {
    let xy = base.truncate() + detail.truncate();
    let square = xy.length_squared();
    if square >= 1.0 { (xy / square.sqrt()).extend(0.0) } else { xy.extend((1.0 - square).sqrt()) }
}

/// Blends by adding slopes, as if heights were added. Normals below the horizon are clamped to it.
pub fn blend_partial_derivatives(base: DVec3, detail: DVec3) -> DVec3 {
    let (b, d) = (base.z.max(0.0), detail.z.max(0.0));
    unit((base.truncate() * d + detail.truncate() * b).extend(b * d))
}

/// Returns the normalised mean of both normals, whose slope is about half of the summed slope. Opposite normals give z.
pub fn blend_linear(base: DVec3, detail: DVec3) -> DVec3 {
    unit(base + detail)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use crate::slopes::grid::normal_of_slope;
    use crate::slopes::moments::slope_of_normal;
    use glam::{DQuat, DVec2};

    type Blend = fn(DVec3, DVec3) -> DVec3;

    const ALL: [(&str, Blend); 6] = [
        ("reoriented", blend_reoriented),
        ("whiteout", blend_whiteout),
        ("UDN", blend_udn),
        ("BlendXY", blend_xy),
        ("partial derivatives", blend_partial_derivatives),
        ("linear", blend_linear),
    ];

    #[test]
    fn reorienting_is_the_rotation() {
        let mut r = Random(3);
        for _ in 0..1000 {
            let mut any = || DVec3::new(r.range(-1.0, 1.0), r.range(-1.0, 1.0), r.range(-0.9, 1.0)).normalize();
            let (base, detail) = (any(), any());
            let want = DQuat::from_rotation_arc(DVec3::Z, base) * detail;
            assert!((blend_reoriented(base, detail) - want).length() < 1e-12, "{base} {detail}");
        }
    }

    #[test]
    fn partial_derivatives_add_slopes() {
        let (b, d) = (DVec2::new(1.3, -0.4), DVec2::new(-0.2, 2.0));
        let sum = slope_of_normal(blend_partial_derivatives(normal_of_slope(b), normal_of_slope(d)));
        assert!((sum - b - d).length() < 1e-12);
    }

    /// The difference from the slope sum falls with the cube of the slopes, except for the linear blend.
    #[test]
    fn orders_of_the_blends() {
        let (b, d) = (DVec2::new(0.8, -0.5), DVec2::new(0.3, 0.4));
        for (name, blend) in ALL {
            let error = |size: f64| {
                let got = slope_of_normal(blend(normal_of_slope(size * b), normal_of_slope(size * d)));
                (got - size * (b + d)).length()
            };
            let (coarse, fine) = (error(0.02), error(0.01));
            let order = (coarse / fine).log2();
            println!("{name}: {coarse:.1e} at 0.02, order {order:.2}; {:.3} at slopes of about 1", error(1.0));
            match name {
                "partial derivatives" => assert!(coarse < 1e-15),
                "linear" => {
                    assert!((order - 1.0).abs() < 0.01 && (fine / (0.005 * (b + d).length()) - 1.0).abs() < 0.01)
                }
                _ => assert!((order - 3.0).abs() < 0.01, "{name} {order}"),
            }
        }
    }

    #[test]
    fn flat_layers_change_nothing() {
        let n = DVec3::new(0.3, -0.4, 0.8).normalize();
        for (name, blend) in ALL {
            let kept = [blend(n, DVec3::Z), blend(DVec3::Z, n)].map(|got| (got - n).length() < 1e-12);
            assert_eq!(kept, [name != "linear", name != "linear" && name != "UDN"], "{name}");
        }
    }

    #[test]
    fn any_vectors_give_a_direction() {
        let odd = [DVec3::ZERO, DVec3::X, DVec3::NEG_Z, DVec3::new(0.0, 1.0, -1e-9), DVec3::splat(-1e9), DVec3::Z];
        for (name, blend) in ALL {
            for base in odd {
                for detail in odd {
                    let n = blend(base, detail);
                    assert!((n.length() - 1.0).abs() < 1e-9, "{name} {base} {detail}: {n}");
                }
            }
        }
    }
}
