//! Tests that by-example tiling keeps the mean and covariance of the map at every moment level.

use glam::{DVec2, DVec3};
use leadr_maps::moments::MomentLevel;
use leadr_maps::{HeightMap, LeadrMap, Wrap, procedural};
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::moments::SlopeMoments;
use leadr_reflectance::slopes::tiling::{add_variant, merged_variants, tiling_fade, tiling_variants, variant_offset};

/// The number of cells, as in the shaders.
const CELLS: f64 = 2.5;

/// Returns the interpolated moments and height of a repeating level.
fn seen(level: &MomentLevel, at: DVec2) -> (SlopeMoments, f64) {
    let (w, h) = (i64::from(level.width), i64::from(level.height));
    let position = at * DVec2::new(w as f64, h as f64) - 0.5;
    let (low, part) = (position.floor(), position - position.floor());
    let (mut sum, mut height) = (SlopeMoments::default(), 0.0);
    for (dx, dy) in [(0, 0), (1, 0), (0, 1), (1, 1)] {
        let share = |d: i64, part: f64| if d == 1 { part } else { 1.0 - part };
        let weight = share(dx, part.x) * share(dy, part.y);
        let texel = (low.y as i64 + dy).rem_euclid(h) * w + (low.x as i64 + dx).rem_euclid(w);
        let m = &level.texels[texel as usize];
        let [mean, second] = [m.mean_slope, m.second].map(|v| DVec2::new(f64::from(v[0]), f64::from(v[1])));
        sum.first += weight * mean;
        sum.second += weight * second.extend(f64::from(m.cross));
        height += weight * f64::from(m.height);
    }
    (sum, height)
}

/// How variants of the map are blended.
#[derive(Clone, Copy, PartialEq)]
enum Blend {
    /// The squares of the weights sum to one.
    Variants,
    /// Like `Variants`, plus the slopes of the changing weights.
    VariantsPassing,
    /// The weights sum to one, which shows that the tests can fail.
    Plain,
}

/// Returns the slope moments over sampled positions of a plane.
fn over_plane(map: &LeadrMap, lod: usize, kind: Blend) -> SlopeMoments {
    let mut r = Random::stream(11, lod as u64);
    let (level, mean_height) = (&map.levels[lod], f64::from(map.mean().height));
    let part = tiling_fade(lod as f64, f64::from(map.levels[0].width), CELLS);
    let mut sum = SlopeMoments::default();
    let side = 400;
    for i in 0..side * side {
        // Jittered positions need fewer samples.
        let cell = DVec2::new(f64::from(i % side), f64::from(i / side));
        let at = (cell + DVec2::new(r.unit(), r.unit())) * 0.61 - 100.0;
        let variants = merged_variants(tiling_variants(at, CELLS), lod as f64);
        let total: f64 = variants.iter().map(|variant| variant.weight).sum();
        let mut blend = SlopeMoments::default();
        for variant in variants.into_iter().filter(|variant| variant.weight > 0.0) {
            let (moments, height) = seen(level, at + variant_offset(variant.corner));
            let weight = if kind == Blend::Plain { variant.weight / total } else { variant.weight };
            blend = add_variant(blend, moments, weight, part);
            if kind == Blend::VariantsPassing {
                blend.first += variant.slope * (part * (height - mean_height));
            }
        }
        let m = blend.first;
        sum.first += m;
        sum.second += blend.second + DVec3::new(m.x * m.x, m.y * m.y, m.x * m.y);
    }
    let count = f64::from(side * side);
    SlopeMoments { first: sum.first / count, second: sum.second / count }
}

/// For narrow bumps, the slopes from changing weights are small. The next test measures the slopes for broad bumps.
#[test]
fn maps_by_example_keep_mean_and_covariance_at_every_level() {
    let maps = [(procedural::soil(256, 256, 1), 0.04), (procedural::gaussian(256, 256, 4, 0.4, 0.01), 0.035)];
    for (map, passing) in maps {
        let leadr = LeadrMap::new(&map, Wrap::Repeat);
        let whole = leadr.mean();
        let sigma = DVec2::new(f64::from(whole.second[0]), f64::from(whole.second[1])).map(f64::sqrt);
        for lod in 0..leadr.levels.len() {
            let found = over_plane(&leadr, lod, Blend::Variants);
            let variance = found.second.truncate() / (sigma * sigma);
            assert!((variance - 1.0).abs().max_element() < 0.02, "level {lod}: {variance}");
            assert!((found.first / sigma).abs().max_element() < 0.01, "level {lod}: {}", found.first);
            let cross = (found.second.z - f64::from(whole.cross)) / (sigma.x * sigma.y);
            assert!(cross.abs() < 0.02, "level {lod}: {cross}");
            let all = over_plane(&leadr, lod, Blend::VariantsPassing).second.truncate() / (sigma * sigma);
            println!("level {lod}: variants {variance}, with what passes {all}");
            assert!((all - variance).abs().max_element() < passing, "level {lod}: {all} {variance}");
        }
    }
}

/// Changing weights make the blended surface steeper than any variant. The added slope variance is the height variance times
/// this factor, for lattice edges of length 1. The added slopes are real slopes of the drawn surface, and significant for
/// broad bumps.
#[test]
fn broad_bumps_gain_the_slopes_of_changing_weights() {
    const PER_EDGE: f64 = 23.4;
    let map = procedural::gaussian(256, 256, 4, 0.4, 0.03);
    let leadr = LeadrMap::new(&map, Wrap::Repeat);
    let mean = f64::from(leadr.mean().height);
    let heights = map.texels.iter().map(|h| (f64::from(*h) - mean).powi(2)).sum::<f64>() / map.texels.len() as f64;
    let gained =
        over_plane(&leadr, 0, Blend::VariantsPassing).second.x - over_plane(&leadr, 0, Blend::Variants).second.x;
    let expected = PER_EDGE * CELLS * CELLS * heights;
    assert!((gained / expected - 1.0).abs() < 0.1, "{gained} {expected}");
    assert!(gained > 0.1 * f64::from(leadr.mean().second[0]));
}

#[test]
fn weights_that_sum_to_one_lose_variance() {
    let map: HeightMap = procedural::gaussian(256, 256, 4, 0.4, 0.03);
    let leadr = LeadrMap::new(&map, Wrap::Repeat);
    let whole = leadr.mean();
    let plain = over_plane(&leadr, 0, Blend::Plain);
    // Blending loses a tenth of the variance.
    assert!(plain.second.x < 0.95 * f64::from(whole.second[0]));
}
