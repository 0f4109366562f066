//! Mip levels of normal maps.

use glam::Vec3;
use rayon::prelude::*;

use super::{MipLevel, Mips, filtered, unorm8};
use crate::material::Raster;
use crate::pyramid::level_sizes;

/// The filtered normals of a map. Every level has the mean of the unit normals under each texel.
#[derive(Clone, Debug)]
pub struct NormalMips {
    sizes: Vec<[u32; 2]>,
    finest: Vec<[u8; 4]>,
    scale: f32,
    /// The means of all levels but the finest, whose normals have length 1.
    means: Vec<Vec<[f32; 3]>>,
}

impl NormalMips {
    /// Filters a tangent-space normal map with codes from −1 to 1. `scale` multiplies x and y before normals get length 1, as glTF's
    /// `normalTexture.scale` does.
    pub fn new(raster: &Raster, scale: f32) -> Self {
        let [width, height] = raster.size();
        let codes = |x, y| [0, 1, 2].map(|channel| raster.value(x, y, channel));
        let row = |y| (0..width).flat_map(|x| unit_normal(codes(x, y), scale).to_array()).collect();
        let texel = |x, y| {
            let [r, g, b] = codes(x, y).map(unorm8);
            [r, g, b, u8::MAX]
        };
        let finest = (0..height).into_par_iter().flat_map_iter(|y| (0..width).map(move |x| texel(x, y)));
        Self {
            sizes: level_sizes(raster.size()),
            finest: finest.collect(),
            scale,
            means: filtered::<3>(raster.size(), row),
        }
    }

    /// Returns the size of the finest level.
    pub fn size(&self) -> [u32; 2] {
        self.sizes[0]
    }

    /// Returns the levels as a texture whose normals have length 1.
    pub fn mips(&self) -> Mips {
        let texel = |mean: &[f32; 3]| {
            let n = Vec3::from(*mean);
            let n = Vec3::new(n.x / self.scale, n.y / self.scale, n.z);
            let n = if n.is_finite() { n.normalize_or(Vec3::Z) } else { Vec3::Z };
            let [r, g, b] = (0.5 * n + 0.5).to_array().map(unorm8);
            [r, g, b, u8::MAX]
        };
        let mut levels = vec![MipLevel { size: self.sizes[0], texels: self.finest.clone() }];
        let coarser = self.sizes[1..].iter().zip(&self.means);
        levels.extend(coarser.map(|(&size, means)| MipLevel { size, texels: means.par_iter().map(texel).collect() }));
        Mips { levels, srgb: false }
    }

    /// Returns the length of the mean normal over a texel of a map of this size, at the position `(s, t)` of its centre. The result is 1
    /// for texels that are not larger than those of the finest level.
    pub(super) fn length(&self, size: [u32; 2], [s, t]: [f32; 2]) -> f32 {
        let ratio = |axis: usize| (self.sizes[0][axis] as f32 / size[axis] as f32).max(1.0).log2();
        // Sides of one texel are not halved any more, so levels are found by their size first.
        let same = self.sizes.iter().position(|level| *level == size);
        let level = same.map_or_else(|| 0.5 * (ratio(0) + ratio(1)), |level| level as f32);
        let (below, part) = (level as usize, level.fract());
        let lower = self.length_in_level(below, [s, t]);
        if part < 1e-3 { lower } else { lower + part * (self.length_in_level(below + 1, [s, t]) - lower) }
    }

    fn length_in_level(&self, level: usize, at: [f32; 2]) -> f32 {
        let level = level.min(self.means.len());
        if level == 0 {
            return 1.0;
        }
        let (size, means) = (self.sizes[level], &self.means[level - 1]);
        let axis = |i: usize| {
            let x = at[i] * size[i] as f32 - 0.5;
            let (low, last) = (x.floor(), size[i] - 1);
            let texel = |x: f32| (x.max(0.0) as u32).min(last) as usize;
            (texel(low), texel(low + 1.0), x - low)
        };
        let ((left, right, u), (top, bottom, v)) = (axis(0), axis(1));
        let length = |x: usize, y: usize| Vec3::from(means[y * size[0] as usize + x]).length();
        // A texel of the same size has its centre here, and needs no interpolation.
        if u.min(1.0 - u) < 1e-3 && v.min(1.0 - v) < 1e-3 {
            return length(if u < 0.5 { left } else { right }, if v < 0.5 { top } else { bottom });
        }
        let mix = |a: f32, b: f32, t: f32| a + t * (b - a);
        mix(mix(length(left, top), length(right, top), u), mix(length(left, bottom), length(right, bottom), u), v)
    }
}

/// Returns the unit normal of three codes. Codes without a direction give z.
fn unit_normal(codes: [f32; 3], scale: f32) -> Vec3 {
    let n = Vec3::from(codes.map(|code| 2.0 * code - 1.0));
    Vec3::new(n.x * scale, n.y * scale, n.z).normalize_or(Vec3::Z)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::material::Samples;

    fn map(width: u32, normals: &[Vec3]) -> Raster {
        let codes = normals.iter().flat_map(|n| (0.5 * n.normalize() + 0.5).to_array()).collect();
        Raster::new(width, normals.len() as u32 / width, 3, Samples::F32(codes)).unwrap()
    }

    #[test]
    fn levels_have_mean_directions_of_length_one() {
        let (a, b) = (Vec3::new(0.6, 0.0, 0.8), Vec3::new(-0.6, 0.0, 0.8));
        let mips = NormalMips::new(&map(2, &[a, b]), 1.0);
        assert_eq!(mips.mips().levels[1].texels, [[128, 128, 255, 255]]);
        assert!((mips.length([1, 1], [0.5, 0.5]) - 0.8).abs() < 1e-6);
        assert_eq!(mips.length([2, 1], [0.25, 0.5]), 1.0);
        assert_eq!(mips.length([8, 8], [0.1, 0.1]), 1.0);
    }

    #[test]
    fn scale_belongs_to_the_engine() {
        let a = Vec3::new(0.3, 0.2, 0.9).normalize();
        for scale in [0.25, 1.0, 2.0] {
            let levels = NormalMips::new(&map(2, &[a, a]), scale).mips().levels;
            for (fine, coarse) in levels[0].texels[0].iter().zip(levels[1].texels[0]) {
                assert!(fine.abs_diff(coarse) <= 1, "{scale}: {levels:?}");
            }
        }
        // With a scale of 0 the surface is flat.
        let mips = NormalMips::new(&map(2, &[a, -a.with_z(-a.z)]), 0.0);
        assert!((mips.length([1, 1], [0.5, 0.5]) - 1.0).abs() < 1e-6);
        assert_eq!(mips.mips().levels[1].texels, [[128, 128, 255, 255]]);
    }
}
