//! Deterministic noise as a function of the rest position: value noise, and a nearly hexagonal Worley pattern.
//!
//! The noise uses only integer hashing and plain arithmetic, so every machine bakes the same skin.

use glam::Vec3;

/// Returns a well-mixed 32-bit hash of a lattice point and a layer seed.
#[inline]
pub fn hash(x: i32, y: i32, z: i32, seed: u32) -> u32 {
    let mut h = (x as u32).wrapping_mul(0x8da6_b343)
        ^ (y as u32).wrapping_mul(0xd816_3841)
        ^ (z as u32).wrapping_mul(0xcb1a_b31f)
        ^ seed.wrapping_mul(0x9e37_79b9);
    h ^= h >> 16;
    h = h.wrapping_mul(0x7feb_352d);
    h ^= h >> 15;
    h = h.wrapping_mul(0x846c_a68b);
    h ^ (h >> 16)
}

/// Converts the top 24 bits of a hash to a number in `[0, 1)`.
#[inline]
pub fn unit(h: u32) -> f32 {
    (h >> 8) as f32 * (1.0 / 16_777_216.0)
}

/// Returns value noise in `[0, 1)`, with Hermite interpolation of one random value per lattice point.
pub fn value(p: Vec3, seed: u32) -> f32 {
    let cell = p.floor();
    let f = p - cell;
    let f = f * f * (Vec3::splat(3.0) - 2.0 * f);
    let (i, j, k) = (cell.x as i32, cell.y as i32, cell.z as i32);
    let at = |a, b, c| unit(hash(i + a, j + b, k + c, seed));
    let row = |b, c| {
        let (low, high) = (at(0, b, c), at(1, b, c));
        low + (high - low) * f.x
    };
    let plane = |c| {
        let (low, high) = (row(0, c), row(1, c));
        low + (high - low) * f.y
    };
    let (low, high) = (plane(0), plane(1));
    low + (high - low) * f.z
}

/// The two feature points that are nearest to a position, in units of cells.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Worley {
    /// The distance to the nearest feature point.
    pub f1: f32,
    /// The distance to the second nearest feature point.
    pub f2: f32,
    /// The identity of the nearest cell, as a uniformly distributed number in `[0, 1)`.
    pub id: f32,
}

/// Evaluates Worley noise on the unit grid. Feature points are displaced at random by up to ±0.275 from the centres of the cells. Every
/// second z layer is shifted by a quarter of a cell, which makes slices of the cells more hexagonal.
pub fn worley(p: Vec3, seed: u32) -> Worley {
    let cell = p.floor();
    let f = p - cell;
    let (i, j, k) = (cell.x as i32, cell.y as i32, cell.z as i32);
    let (mut f1, mut f2, mut nearest) = (f32::MAX, f32::MAX, 0);
    for c in -1..=1 {
        let shift = if (k + c) & 1 == 1 { 0.25 } else { 0.0 };
        for b in -1..=1 {
            for a in -1..=1 {
                let h = hash(i + a, j + b, k + c, seed);
                let jitter = |bits: u32| 0.5 + 0.55 * ((bits & 1023) as f32 * (1.0 / 1024.0) - 0.5);
                let d = Vec3::new(
                    a as f32 + jitter(h) + shift - f.x,
                    b as f32 + jitter(h >> 10) + shift - f.y,
                    c as f32 + jitter(h >> 20) - f.z,
                )
                .length_squared();
                if d < f1 {
                    (f1, f2, nearest) = (d, f1, h);
                } else if d < f2 {
                    f2 = d;
                }
            }
        }
    }
    Worley { f1: f1.sqrt(), f2: f2.sqrt(), id: unit(nearest.wrapping_mul(0x9e37_79b9)) }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn points() -> impl Iterator<Item = Vec3> {
        (0..20_000_i32)
            .map(|i| Vec3::new(unit(hash(i, 0, 0, 1)), unit(hash(i, 1, 0, 1)), unit(hash(i, 2, 0, 1))) * 60.0 - 30.0)
    }

    #[test]
    fn value_noise_is_continuous_bounded_and_centred() {
        let mut sum = 0.0;
        for p in points() {
            let v = value(p, 7);
            assert!((0.0..1.0).contains(&v));
            let near = value(p + Vec3::new(1e-3, -1e-3, 1e-3), 7);
            assert!((v - near).abs() < 0.01, "{p}");
            sum += v;
        }
        assert!((sum / 20_000.0 - 0.5).abs() < 0.01, "{sum}");
    }

    #[test]
    fn worley_orders_its_distances_and_is_continuous() {
        let mut means = [0.0; 3];
        for p in points() {
            let w = worley(p, 3);
            assert!(w.f1 <= w.f2 && w.f1 < 1.2, "{w:?}");
            let near = worley(p + Vec3::splat(1e-3), 3);
            assert!((near.f1 - w.f1).abs() < 2e-3 + 1e-5, "{p}");
            for (m, v) in means.iter_mut().zip([w.f1, w.f2, w.id]) {
                *m += v / 20_000.0;
            }
        }
        assert!(means[0] < means[1] && (means[2] - 0.5).abs() < 0.03, "{means:?}");
    }

    #[test]
    fn seeds_give_different_patterns() {
        let p = Vec3::new(0.3, 4.7, -2.2);
        assert!((value(p, 1) - value(p, 2)).abs() > 1e-6);
        assert!((worley(p, 1).f1 - worley(p, 2).f1).abs() > 1e-6);
    }
}
