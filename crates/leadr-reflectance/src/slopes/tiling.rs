//! Tiling by example, which turns a repeating map into a non-repeating map of the same mean and covariance (Heitz and Neyret 2018,
//! *High-Performance By-Example Noise using a Histogram-Preserving Blending Operator*, with their linear, variance-preserving operator;
//! Burley 2019 on sharper weights).
//!
//! A triangle lattice covers the texture coordinates. Each corner of the lattice has a *variant*, which is the map shifted by an offset
//! that is hashed from the corner's index. Each point blends the variants of the three corners around it about the map's mean `m`:
//!
//! `h = m + Σ Wᵢ (hᵢ − m)`, `Σ Wᵢ² = 1`.
//!
//! The variants are independent, so the variance everywhere equals the variance of one variant. The variance of the slopes is also
//! preserved. The mean slope under a footprint is `Σ Wᵢ E[∇hᵢ] + Σ (hᵢ − m) ∇Wᵢ`, and the slope covariance is `Σ Wᵢ² Cᵢ`. LEADR moments
//! therefore blend in closed form at every level.
//!
//! **Sharpness.** Barycentric weights would blend three variants almost everywhere, which blurs features and makes every distribution
//! Gaussian. In this module, a corner has weight only where its barycentric coordinate exceeds [`VARIANT_THRESHOLD`]. More than half of the
//! surface then shows one variant unchanged, and 1 % shows three variants. In exchange, the weights change faster, and the term
//! `(hᵢ − m) ∇Wᵢ` adds a slope that none of the variants has. For lattice edges of length 1, its variance is 23.4 times the heights'
//! variance. This is 0.5 % of the slope variance for fine soil, and a quarter of it for bumps that are a tenth of a repeat wide. The added
//! slope is visible, so the moments include it.

use glam::{DMat2, DVec2, IVec2};

use super::moments::SlopeMoments;
use super::statistics::outer_square;

/// The barycentric coordinate above which a corner's variant is visible.
pub const VARIANT_THRESHOLD: f64 = 0.3;

/// The number of offset steps in one repeat. For maps with power-of-two sides, variants are offset by whole texels.
const STEPS: f64 = 4096.0;

/// A variant that is visible at a point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct TilingVariant {
    /// The corner of the lattice.
    pub corner: IVec2,
    /// The blend weight. The squares of all weights sum to one.
    pub weight: f64,
    /// The gradient of the weight with respect to the texture coordinate.
    pub slope: DVec2,
}

/// Returns the variants at a point in descending order of weight. `cells` is the number of lattice edges along one repeat of the map.
pub fn tiling_variants(texcoord: DVec2, cells: f64) -> [TilingVariant; 3] {
    // The skew maps the triangles to halves of unit squares.
    let skew = DMat2::from_cols_array(&[1.0, 0.0, -0.577_350_269_189_625_8, 1.154_700_538_379_251_5]) * cells;
    let at = skew * texcoord;
    let (low, inside) = (at.floor(), at - at.floor());
    let upper = inside.x + inside.y >= 1.0;
    // Each entry is the position of a corner, its barycentric coordinate, and the gradient of this coordinate.
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
    let mut variants = around.map(|(corner, share, slope)| {
        let seen = (share - VARIANT_THRESHOLD).max(0.0);
        TilingVariant { corner, weight: seen * seen, slope: skew.transpose() * slope * (2.0 * seen) }
    });
    let length = variants.iter().map(|variant| variant.weight * variant.weight).sum::<f64>().sqrt();
    let along = variants.iter().map(|variant| variant.slope * (variant.weight / length)).sum::<DVec2>();
    for variant in &mut variants {
        variant.weight /= length;
        variant.slope = (variant.slope - along * variant.weight) / length;
    }
    variants.sort_by(|a, b| b.weight.total_cmp(&a.weight));
    variants
}

/// Returns two 32-bit hashes of a corner (Jarzynski and Olano 2020, `pcg2d`).
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

/// Returns the offset of a corner's variant in the map, as a fraction of one repeat.
pub fn variant_offset(corner: IVec2) -> DVec2 {
    let [x, y] = corner_hash(corner).map(|bits| f64::from(bits >> 20));
    DVec2::new(x, y) / STEPS
}

/// Returns the fraction of a variant's difference from the mean that remains at `lod`, which is the binary logarithm of the footprint width
/// in texels. The map has `size` texels per repeat. A footprint as wide as the lattice averages over variants, so the fraction is 0.
pub fn tiling_fade(lod: f64, size: f64, cells: f64) -> f64 {
    let t = ((size / cells).max(1.0).log2() + 1.0 - lod).clamp(0.0, 2.0) / 2.0;
    t * t * (3.0 - 2.0 * t)
}

/// Merges variants at a coarse `lod`, where seams between variants are invisible. The strongest variant replaces the others, so most
/// footprints need only one variant. The squared weights still sum to one.
pub fn merged_variants(variants: [TilingVariant; 3], lod: f64) -> [TilingVariant; 3] {
    let left = 1.0 - ((lod - 3.0) / 1.5).clamp(0.0, 1.0);
    let [mut a, b, c] =
        variants.map(|variant| TilingVariant { weight: variant.weight * left, slope: variant.slope * left, ..variant });
    a.weight = (1.0 - b.weight * b.weight - c.weight * c.weight).max(0.0).sqrt();
    [a, b, c]
}

/// Adds the moments of a variant to the mean slope and the covariance of a blend. `part` is the result of [`tiling_fade`]. The variance
/// that `part` removes from the mean slopes is added to the covariance.
pub fn add_variant(blend: SlopeMoments, variant: SlopeMoments, weight: f64, part: f64) -> SlopeMoments {
    let mean = variant.first * part;
    let covariance = variant.second - outer_square(mean);
    SlopeMoments { first: blend.first + mean * weight, second: blend.second + covariance * (weight * weight) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::random::Random;
    use glam::DVec3;

    const CELLS: f64 = 2.5;

    fn points() -> impl Iterator<Item = DVec2> {
        let mut r = Random::stream(3, 0);
        (0..20_000).map(move |_| DVec2::new(r.range(-900.0, 900.0), r.range(-900.0, 900.0)))
    }

    fn weight_of(corner: IVec2, at: DVec2) -> f64 {
        tiling_variants(at, CELLS)
            .into_iter()
            .find(|variant| variant.corner == corner)
            .map_or(0.0, |variant| variant.weight)
    }

    #[test]
    fn squares_of_weights_sum_to_one_everywhere() {
        let mut variants_seen = [0.0; 4];
        for at in points() {
            let variants = tiling_variants(at, CELLS);
            assert!((variants.iter().map(|variant| variant.weight * variant.weight).sum::<f64>() - 1.0).abs() < 1e-12);
            assert!(variants[0].weight >= variants[1].weight && variants[1].weight >= variants[2].weight);
            variants_seen[variants.iter().filter(|variant| variant.weight > 0.0).count()] += 1.0 / 20_000.0;
        }
        // With the threshold t, the fraction 6 t² of a triangle's area shows one variant, and (1 − 3 t)² shows three.
        assert!(
            f64::abs(variants_seen[1] - 0.54) < 0.02 && f64::abs(variants_seen[3] - 0.01) < 0.003,
            "{variants_seen:?}"
        );
    }

    #[test]
    fn weight_derivatives_match_and_are_continuous() {
        for at in points().take(2_000) {
            for variant in tiling_variants(at, CELLS) {
                let step = 1e-6;
                let change = |by: DVec2| {
                    (weight_of(variant.corner, at + by * step) - weight_of(variant.corner, at - by * step))
                        / (2.0 * step)
                };
                let slope = DVec2::new(change(DVec2::X), change(DVec2::Y));
                assert!(
                    (slope - variant.slope).length() < 1e-3 * (1.0 + variant.slope.length()),
                    "{at} {slope} {}",
                    variant.slope
                );
            }
        }
    }

    #[test]
    fn variant_offsets_are_uniform_and_independent() {
        let n = 200;
        let offset = |x: i32, y: i32| variant_offset(IVec2::new(x, y));
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
    fn variants_merge_at_coarse_levels() {
        for at in points().take(1000) {
            let variants = tiling_variants(at, CELLS);
            let merged = |lod| merged_variants(variants, lod).map(|variant| variant.weight);
            assert!(merged(0.0).iter().zip(variants).all(|(weight, variant)| (weight - variant.weight).abs() < 1e-12));
            assert_eq!(merged(5.0), [1.0, 0.0, 0.0]);
            assert!((merged(3.7).map(|weight| weight * weight).iter().sum::<f64>() - 1.0).abs() < 1e-12);
        }
    }

    #[test]
    fn blending_preserves_moments_of_variants() {
        let variant =
            |mean: f64| SlopeMoments { first: DVec2::new(mean, 0.0), second: DVec3::new(mean * mean + 0.4, 0.3, 0.1) };
        let blend = |part: f64| {
            let sum = add_variant(SlopeMoments::default(), variant(0.2), 0.6, part);
            add_variant(sum, variant(-0.1), 0.8, part)
        };
        assert!((blend(1.0).first.x - (0.6 * 0.2 - 0.8 * 0.1)).abs() < 1e-12);
        assert!((blend(1.0).second - DVec3::new(0.4, 0.3, 0.1)).length() < 1e-12);
        // Where variants average out, the covariance includes the variance of their means.
        assert_eq!(blend(0.0).first, DVec2::ZERO);
        assert!((blend(0.0).second.x - (0.4 + 0.36 * 0.04 + 0.64 * 0.01)).abs() < 1e-12);
        assert_eq!((tiling_fade(0.0, 1024.0, CELLS), tiling_fade(10.0, 1024.0, CELLS)), (1.0, 0.0));
    }
}
