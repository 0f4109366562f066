//! Mip levels of colours and of other data.

use rayon::prelude::*;

use super::{MipLevel, Mips, filtered, unorm8};
use crate::material::{Encoding, Raster};
use crate::pyramid::level_sizes;
use crate::srgb::srgb8_from_linear;

/// What the alpha of a colour texture means.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum Alpha {
    /// Nothing: colours count alike.
    #[default]
    Ignored,
    /// The coverage of a blended surface. Colours count by their alpha.
    Blended,
    /// A mask, which is opaque where alpha is at least the cutoff. Colours count by their alpha, and each level covers as much as the finest.
    Masked {
        /// The cutoff, above 0.
        cutoff: f32,
    },
}

/// Returns the levels of a colour texture. Colours are averaged in linear light.
pub fn color_mips(raster: &Raster, alpha: Alpha) -> Mips {
    let [width, height] = raster.size();
    let texel = |x: u32, y: u32| {
        let [r, g, b] = raster.color(x, y, Encoding::Srgb);
        let a = raster.value(x, y, 3);
        // The colour of transparent texels counts only where all are transparent.
        let weight = if alpha == Alpha::Ignored { 1.0 } else { a.max(1e-4) };
        [r * weight, g * weight, b * weight, a, weight]
    };
    let row = |y| (0..width).flat_map(|x| texel(x, y)).collect();
    let finest = (0..height).into_par_iter().flat_map_iter(|y| (0..width).map(move |x| texel(x, y)));
    let finest: Vec<[u8; 4]> = finest.map(|texel| encoded(texel, 1.0)).collect();
    let levels = filtered::<5>(raster.size(), row);
    let coverage = match alpha {
        Alpha::Masked { cutoff } => Some((cutoff, covered(finest.iter().map(|t| f32::from(t[3]) / 255.0), cutoff))),
        _ => None,
    };
    let coarser = |(size, texels): ([u32; 2], Vec<[f32; 5]>)| {
        let scale = coverage.map_or(1.0, |(cutoff, wanted)| alpha_scale(&texels, cutoff, wanted));
        MipLevel { size, texels: texels.into_iter().map(|texel| encoded(texel, scale)).collect() }
    };
    let mut all = vec![MipLevel { size: raster.size(), texels: finest }];
    all.extend(level_sizes(raster.size()).into_iter().skip(1).zip(levels).map(coarser));
    Mips { levels: all, srgb: true }
}

fn encoded([r, g, b, a, weight]: [f32; 5], scale: f32) -> [u8; 4] {
    let [r, g, b] = [r, g, b].map(|c| srgb8_from_linear(c / weight));
    [r, g, b, unorm8(a * scale)]
}

/// Returns the fraction of the texels that a mask keeps.
fn covered(alphas: impl ExactSizeIterator<Item = f32>, cutoff: f32) -> f64 {
    let count = alphas.len() as f64;
    alphas.filter(|&alpha| alpha >= cutoff).count() as f64 / count
}

/// Returns the factor on alpha with which a level covers the fraction `wanted`.
fn alpha_scale(texels: &[[f32; 5]], cutoff: f32, wanted: f64) -> f32 {
    let mut alphas: Vec<f32> = texels.iter().map(|texel| texel[3]).collect();
    alphas.sort_by(f32::total_cmp);
    let kept = (wanted * alphas.len() as f64).round() as usize;
    let last = match alphas.len() - kept.min(alphas.len()) {
        first if first < alphas.len() => alphas[first],
        _ => return 1.0,
    };
    // The code of the last kept texel must not round below the cutoff.
    if last > 0.0 { (cutoff * 255.0).ceil() / 255.0 / last } else { 1.0 }
}

/// Returns the levels of a texture of linear data. All channels are averaged.
pub fn data_mips(raster: &Raster) -> Mips {
    let [width, height] = raster.size();
    let texel = |x, y| [0, 1, 2, 3].map(|channel| raster.value(x, y, channel));
    let row = |y| (0..width).flat_map(|x| texel(x, y)).collect();
    let levels = filtered::<4>(raster.size(), row);
    let finest = (0..height).into_par_iter().flat_map_iter(|y| (0..width).map(move |x| texel(x, y).map(unorm8)));
    let mut all = vec![MipLevel { size: raster.size(), texels: finest.collect() }];
    let coarser = level_sizes(raster.size()).into_iter().skip(1).zip(levels);
    all.extend(coarser.map(|(size, texels)| MipLevel { size, texels: texels.iter().map(|t| t.map(unorm8)).collect() }));
    Mips { levels: all, srgb: false }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Samples;

    fn raster(width: u32, texels: &[[u8; 4]]) -> Raster {
        Raster::new(width, texels.len() as u32 / width, 4, Samples::U8(texels.as_flattened().to_vec())).unwrap()
    }

    #[test]
    fn colours_are_means_of_light() {
        let mips = color_mips(&raster(2, &[[0, 0, 0, 255], [255, 255, 255, 255]]), Alpha::Ignored);
        assert_eq!(mips.levels.len(), 2);
        assert_eq!(mips.levels[1], MipLevel { size: [1, 1], texels: vec![[188, 188, 188, 255]] });
        assert!(mips.srgb && !mips.has_alpha());
        assert_eq!(
            data_mips(&raster(2, &[[0, 10, 0, 255], [255, 20, 255, 0]])).levels[1].texels,
            [[128, 15, 128, 128]]
        );
    }

    #[test]
    fn transparent_texels_do_not_color_opaque_ones() {
        let mips = color_mips(&raster(2, &[[200, 0, 0, 255], [0, 255, 0, 0]]), Alpha::Blended);
        let [r, g, _, a] = mips.levels[1].texels[0];
        assert!((199..=200).contains(&r) && g < 12 && a == 128, "{r} {g} {a}");
        let clear = color_mips(&raster(2, &[[9, 9, 9, 0]; 2]), Alpha::Blended);
        assert_eq!(clear.levels[1].texels, [[9, 9, 9, 0]]);
    }

    #[test]
    fn masks_keep_their_coverage() {
        // One texel in five is opaque, so a mean of many texels is below the cutoff.
        let texels: Vec<[u8; 4]> =
            (0..64u32 * 64).map(|i| [90, 90, 90, if i * 7 % 5 == 0 { 255 } else { 0 }]).collect();
        let cover = |level: &MipLevel| covered(level.texels.iter().map(|t| f32::from(t[3]) / 255.0), 0.5);
        let masked = color_mips(&raster(64, &texels), Alpha::Masked { cutoff: 0.5 });
        let plain = color_mips(&raster(64, &texels), Alpha::Blended);
        for level in 1..4 {
            assert!((cover(&masked.levels[level]) - 0.2).abs() < 0.2, "{level}: {}", cover(&masked.levels[level]));
            assert!(cover(&masked.levels[level]) > 0.1);
        }
        assert!(cover(&plain.levels[3]) < 0.01);
    }
}
