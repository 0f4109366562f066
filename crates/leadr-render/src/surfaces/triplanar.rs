//! Maps a texture without texture coordinates, by triplanar mapping. The texture is projected onto the surface at rest, from
//! outside along the three axes. The texture stays upright (z is up), and the projections are blended by the normal.
//! `shaders-glsl/passes/triplanar.glsl` is the GLSL version.

use glam::{Vec2, Vec3};

/// The offsets of the three projections in repeats. With them, adjacent projections differ, but courses of bricks still continue
/// around a corner.
const SHIFTS: [Vec2; 3] = [Vec2::ZERO, Vec2::new(0.37, 0.0), Vec2::splat(0.71)];

/// A projection of the texture along an axis.
#[derive(Clone, Copy, Debug)]
pub struct Projection {
    /// The blend weight, which depends on the normal. The weights of the three projections are not normalised.
    pub weight: f32,
    /// The texture coordinate of the position, where `t` points down.
    pub texcoord: Vec2,
    /// The unit direction in which `s` increases.
    pub s: Vec3,
    /// The unit direction in which `t` increases.
    pub t: Vec3,
}

/// Returns the three projections for a position with this normal. One repeat covers `repeat` metres.
pub fn projections(position: Vec3, normal: Vec3, repeat: f32) -> [Projection; 3] {
    let weights = (normal.abs() - 0.5).max(Vec3::ZERO);
    let weights = weights * weights;
    let side = Vec3::new(side(normal.x), side(normal.y), side(normal.z));
    let seen = |weight: f32, shift: Vec2, s: Vec3, t: Vec3| Projection {
        weight,
        texcoord: Vec2::new(position.dot(s), position.dot(t)) / repeat + shift,
        s,
        t,
    };
    [
        seen(weights.x, SHIFTS[0], Vec3::Y * side.x, Vec3::NEG_Z),
        seen(weights.y, SHIFTS[1], Vec3::NEG_X * side.y, Vec3::NEG_Z),
        seen(weights.z, SHIFTS[2], Vec3::X * side.z, Vec3::NEG_Y),
    ]
}

/// Returns the sign of the axis direction that points outwards. `facing` is the component of the normal along the axis.
fn side(facing: f32) -> f32 {
    if facing < 0.0 { -1.0 } else { 1.0 }
}

/// Samples a repeating map in all projections, and blends the samples. The squares of the weights are normalised. The blend
/// therefore keeps the variance of the map, and blended regions look equally rough.
pub fn blend(position: Vec3, normal: Vec3, repeat: f32, mean: f32, sample: impl Fn(Vec2) -> f32) -> f32 {
    let (mut sum, mut squares) = (0.0, 0.0);
    for Projection { weight, texcoord, .. } in projections(position, normal, repeat) {
        if weight > 0.0 {
            sum += weight * (sample(texcoord) - mean);
            squares += weight * weight;
        }
    }
    mean + sum / squares.max(1e-20).sqrt()
}

/// The largest factor by which a blend amplifies deviations from the mean: √3, for three equal weights.
pub const MOST_BLENDED: f32 = 1.732_050_8;

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn blending_keeps_the_variance() {
        // If the noise is independent in each texel, the blend has the variance of the map everywhere on the surface.
        let noise = |t: Vec2| {
            let h = ((t.x * 64.0).floor() as i64 * 73_856_093) ^ ((t.y * 64.0).floor() as i64 * 19_349_663);
            ((h.wrapping_mul(2_654_435_761) >> 7) & 0xffff) as f32 / 65_535.0
        };
        let variance = |normal: Vec3| {
            let (mut sum, mut square, mut count) = (0.0, 0.0, 0.0);
            for i in 0..60 {
                for j in 0..60 {
                    let p = Vec3::new(i as f32 * 0.173, j as f32 * 0.191, (i * 60 + j) as f32 * 0.0571);
                    let h = blend(p, normal, 1.0, 0.5, noise);
                    sum += h;
                    square += h * h;
                    count += 1.0;
                }
            }
            square / count - (sum / count) * (sum / count)
        };
        let (axis, corner) = (variance(Vec3::Z), variance(Vec3::ONE.normalize()));
        assert!((axis / corner - 1.0).abs() < 0.15, "{axis} {corner}");
    }

    #[test]
    fn textures_are_seen_upright_from_outside() {
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            for outward in [axis, -axis] {
                let seen = projections(Vec3::ZERO, outward, 1.0).into_iter().find(|seen| seen.weight > 0.0).unwrap();
                // With `s` to the right and `t` down, the surface faces the viewer. The texture is then not mirrored.
                assert!((seen.s.cross(seen.t).dot(outward) + 1.0).abs() < 1e-6, "{outward}");
                assert!(outward.z != 0.0 || seen.t == Vec3::NEG_Z);
            }
        }
    }

    #[test]
    fn texture_coordinates_follow_their_directions() {
        let (p, n) = (Vec3::new(0.3, -0.7, 0.2), Vec3::new(-0.6, 0.55, -0.58));
        for axis in 0..3 {
            let seen = projections(p, n, 2.0)[axis];
            let moved = |by: Vec3| projections(p + by, n, 2.0)[axis].texcoord - seen.texcoord;
            assert!((moved(seen.s) - Vec2::new(0.5, 0.0)).length() < 1e-6);
            assert!((moved(seen.t) - Vec2::new(0.0, 0.5)).length() < 1e-6);
        }
    }
}
