//! Tiling by example: a map that repeats becomes one that does not, with the same mean and covariance (Heitz and Neyret 2018,
//! *High-Performance By-Example Noise using a Histogram-Preserving Blending Operator*, with their linear, variance-preserving
//! operator; Burley 2019 on sharper weights).
//!
//! A lattice of triangles lies over the texture coordinates. Each of its corners shows the map somewhere else, by a hash of its
//! number: a *look*. A place sees the looks of the three corners around it, blended about the mean `m` of the map,
//!
//! `h = m + Σ Wᵢ (hᵢ − m)`, `Σ Wᵢ² = 1`,
//!
//! so that the variance is that of one look wherever it is: looks know nothing of each other. So for slopes, whose mean under a
//! footprint is `Σ Wᵢ E[∇hᵢ] + Σ (hᵢ − m) ∇Wᵢ`, and their covariance `Σ Wᵢ² Cᵢ`: LEADR moments blend in closed form at every level.
//!
//! **Sharpness.** Weights that follow barycentric coordinates would lay three looks over each other almost everywhere, which blurs
//! features and makes every distribution Gaussian. Here a corner counts from [`LEAST_LOOK`] of the barycentric coordinates on:
//! more than half of the surface shows one look unchanged, a hundredth shows three. The price is that weights change faster, and
//! `(hᵢ − m) ∇Wᵢ` is a slope that no look has. Its variance is 23.4 times that of the heights for edges of the lattice of length 1: .5 % of
//! that of the slopes of fine soil, a quarter of that of bumps a tenth of a repeat wide. It is there to be seen, and counted.

use glam::{DMat2, DVec2, IVec2};

use super::moments::SlopeMoments;
use super::statistics::outer_square;

/// The barycentric coordinate from which on the look of a corner is seen.
pub const LEAST_LOOK: f64 = 0.3;

/// Looks are moved by whole multiples of this part of a repeat: by whole texels of maps whose sides are powers of two.
const STEPS: f64 = 4096.0;

/// A look that a place sees.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Look {
    /// The corner of the lattice.
    pub corner: IVec2,
    /// How much of it is seen; the squares of all sum to one.
    pub weight: f64,
    /// How the weight changes by texture coordinate.
    pub slope: DVec2,
}

/// The looks at a place in descending order of their weights. `cells`: edges of the lattice along one repeat of the map.
pub fn tiling_looks(texcoord: DVec2, cells: f64) -> [Look; 3] {
    // To coordinates in which the triangles are halves of unit squares.
    let skew = DMat2::from_cols_array(&[1.0, 0.0, -0.577_350_269_189_625_8, 1.154_700_538_379_251_5]) * cells;
    let at = skew * texcoord;
    let (low, inside) = (at.floor(), at - at.floor());
    let upper = inside.x + inside.y >= 1.0;
    // Of each corner where it lies, its barycentric coordinate, and how that changes by `at`.
    let side = if upper { -1.0 } else { 1.0 };
    let local = if upper { 1.0 - inside } else { inside };
    let first = if upper { IVec2::ONE } else { IVec2::ZERO };
    let step = if upper { -1 } else { 1 };
    let corner = low.as_ivec2();
    let around = [
        (corner + first, 1.0 - local.x - local.y, DVec2::splat(-side)),
        (corner + first + IVec2::X * step, local.x, DVec2::X * side),
        (corner + first + IVec2::Y * step, local.y, DVec2::Y * side),
    ];
    let mut looks = around.map(|(corner, share, slope)| {
        let seen = (share - LEAST_LOOK).max(0.0);
        Look { corner, weight: seen * seen, slope: skew.transpose() * slope * (2.0 * seen) }
    });
    let length = looks.iter().map(|look| look.weight * look.weight).sum::<f64>().sqrt();
    let along = looks.iter().map(|look| look.slope * (look.weight / length)).sum::<DVec2>();
    for look in &mut looks {
        look.weight /= length;
        look.slope = (look.slope - along * look.weight) / length;
    }
    looks.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    looks
}

/// Two numbers from 0 to 1 that belong to a corner (Jarzynski and Olano 2020, `pcg2d`).
fn corner_hash(corner: IVec2) -> [u32; 2] {
    let mix = |v: u32| v.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
    let [mut x, mut y] = [mix(corner.x as u32), mix(corner.y as u32)];
    x = x.wrapping_add(y.wrapping_mul(1_664_525));
    y = y.wrapping_add(x.wrapping_mul(1_664_525));
    x ^= x >> 16;
    y ^= y >> 16;
    x = x.wrapping_add(y.wrapping_mul(1_664_525));
    y = y.wrapping_add(x.wrapping_mul(1_664_525));
    [x ^ (x >> 16), y ^ (y >> 16)]
}

/// By how much of a repeat a corner's look at the map is moved.
pub fn look_offset(corner: IVec2) -> DVec2 {
    let [x, y] = corner_hash(corner).map(|bits| f64::from(bits >> 20));
    DVec2::new(x, y) / STEPS
}

/// Part of what differs from the mean that is left of looks as coarse as `lod` texels, as a power of two, of a map of `size` texels along a
/// repeat: footprints as wide as the lattice average over looks, and then nothing is left.
pub fn tiling_fade(lod: f64, size: f64, cells: f64) -> f64 {
    let t = ((size / cells).max(1.0).log2() + 1.0 - lod).clamp(0.0, 2.0) / 2.0;
    t * t * (3.0 - 2.0 * t)
}

/// Where a texel of `lod` is so coarse that no eye tells a seam from the texels, the foremost look takes the place of the others: squares
/// still sum to one, and most footprints need one look.
pub fn merged_looks(looks: [Look; 3], lod: f64) -> [Look; 3] {
    let left = 1.0 - ((lod - 3.0) / 1.5).clamp(0.0, 1.0);
    let [mut a, b, c] = looks.map(|look| Look { weight: look.weight * left, slope: look.slope * left, ..look });
    a.weight = (1.0 - b.weight * b.weight - c.weight * c.weight).max(0.0).sqrt();
    [a, b, c]
}

/// Adds a look of such moments to the mean slope and the covariance of a blend. `part`: [`tiling_fade`]; what it takes from the mean
/// slopes is in the covariance.
pub fn add_look(blend: SlopeMoments, look: SlopeMoments, weight: f64, part: f64) -> SlopeMoments {
    let mean = look.first * part;
    let covariance = look.second - outer_square(mean);
    SlopeMoments { first: blend.first + mean * weight, second: blend.second + covariance * (weight * weight) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use glam::DVec3;

    const CELLS: f64 = 2.5;

    fn places() -> impl Iterator<Item = DVec2> {
        let mut r = Random::stream(3, 0);
        (0..20_000).map(move |_| DVec2::new(r.range(-900.0, 900.0), r.range(-900.0, 900.0)))
    }

    /// The weight that a place gives each corner.
    fn weight_of(corner: IVec2, at: DVec2) -> f64 {
        tiling_looks(at, CELLS).into_iter().find(|look| look.corner == corner).map_or(0.0, |look| look.weight)
    }

    #[test]
    fn squares_of_weights_sum_to_one_everywhere() {
        let mut looks_seen = [0.0; 4];
        for at in places() {
            let looks = tiling_looks(at, CELLS);
            assert!((looks.iter().map(|look| look.weight * look.weight).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(looks[0].weight >= looks[1].weight && looks[1].weight >= looks[2].weight);
            looks_seen[looks.iter().filter(|look| look.weight > 0.0).count()] += 1.0 / 20_000.0;
        }
        // Of the triangle, six squares of the least share show one look, and a triangle of less than three of them three.
        assert!(f64::abs(looks_seen[1] - 0.54) < 0.02 && f64::abs(looks_seen[3] - 0.01) < 0.003, "{looks_seen:?}");
    }

    #[test]
    fn weights_change_as_they_say_and_never_jump() {
        for at in places().take(2_000) {
            for look in tiling_looks(at, CELLS) {
                let step = 1e-6;
                let change = |by: DVec2| {
                    (weight_of(look.corner, at + by * step) - weight_of(look.corner, at - by * step)) / (2.0 * step)
                };
                let slope = DVec2::new(change(DVec2::X), change(DVec2::Y));
                assert!(
                    (slope - look.slope).length() < 1e-3 * (1.0 + look.slope.length()),
                    "{at} {slope} {}",
                    look.slope
                );
            }
        }
    }

    #[test]
    fn looks_are_spread_evenly_and_know_nothing_of_their_neighbours() {
        let n = 200;
        let offset = |x: i32, y: i32| look_offset(IVec2::new(x, y));
        let (mut mean, mut square, mut beside) = (DVec2::ZERO, DVec2::ZERO, DVec2::ZERO);
        for x in -n / 2..n / 2 {
            for y in -n / 2..n / 2 {
                let here = offset(x, y) - 0.5;
                mean += here;
                square += here * here;
                beside += here * (offset(x + 1, y) - 0.5) + here * (offset(x, y + 1) - 0.5);
            }
        }
        let count = f64::from(n * n);
        assert!((mean / count).abs().max_element() < 5e-3);
        assert!((square / count - 1.0 / 12.0).abs().max_element() < 2e-3);
        assert!((beside / count).abs().max_element() < 2e-3);
    }

    #[test]
    fn looks_merge_where_texels_are_coarse() {
        for at in places().take(1000) {
            let looks = tiling_looks(at, CELLS);
            let merged = |lod| merged_looks(looks, lod).map(|look| look.weight);
            assert!(merged(0.0).iter().zip(looks).all(|(weight, look)| (weight - look.weight).abs() < 1e-12));
            assert_eq!(merged(5.0), [1.0, 0.0, 0.0]);
            assert!((merged(3.7).map(|weight| weight * weight).iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn a_blend_keeps_what_its_looks_have() {
        let look =
            |mean: f64| SlopeMoments { first: DVec2::new(mean, 0.0), second: DVec3::new(mean * mean + 0.4, 0.3, 0.1) };
        let blend = |part: f64| {
            let sum = add_look(SlopeMoments::default(), look(0.2), 0.6, part);
            add_look(sum, look(-0.1), 0.8, part)
        };
        assert!((blend(1.0).first.x - (0.6 * 0.2 - 0.8 * 0.1)).abs() < 1e-12);
        assert!((blend(1.0).second - DVec3::new(0.4, 0.3, 0.1)).length() < 1e-12);
        // Where looks average out, their means have become variance.
        assert_eq!(blend(0.0).first, DVec2::ZERO);
        assert!((blend(0.0).second.x - (0.4 + 0.36 * 0.04 + 0.64 * 0.01)).abs() < 1e-12);
        assert_eq!((tiling_fade(0.0, 1024.0, CELLS), tiling_fade(10.0, 1024.0, CELLS)), (1.0, 0.0));
    }
}
