//! Mip levels of roughness that contain the spread of normals.

use leadr_reflectance::facets::shortened_normals::Shortening;
use rayon::prelude::*;

use super::{MipLevel, Mips, NormalMips, filtered, unorm8};
use crate::material::Raster;
use crate::pyramid::level_sizes;

/// The intervals of the table from shortening to roughness.
const STEPS: usize = 2048;

/// A texture with roughness in one channel.
#[derive(Clone, Copy, Debug)]
pub struct RoughnessSource<'a> {
    /// The texels; `None` for a material whose texture is missing, which then has the value 1 everywhere.
    pub raster: Option<&'a Raster>,
    /// The channel of the perceptual roughness `√α`, from 0 to 3. Its value is multiplied by `factor`.
    pub channel: usize,
    /// The factor of the roughness, from 0 to 1. The levels contain it.
    pub factor: f32,
}

/// Returns the levels of a texture whose roughness contains the spread of `normals`. The other channels are averaged. A missing texture
/// has the size of the normal map.
pub fn roughness_mips(source: RoughnessSource<'_>, normals: Option<&NormalMips>) -> Mips {
    let RoughnessSource { raster, channel, factor } = source;
    let size = raster.map(Raster::size).or(normals.map(NormalMips::size)).unwrap_or([1, 1]);
    let table = Table::new();
    let value = |x, y, c| {
        let value = raster.map_or(1.0, |raster| raster.value(x, y, c));
        if c == channel { value * factor } else { value }
    };
    let row = |y| {
        (0..size[0])
            .flat_map(|x| {
                let mut texel = [0, 1, 2, 3].map(|c| value(x, y, c));
                texel[channel] = table.length(texel[channel]);
                texel
            })
            .collect()
    };
    let place = |i: usize, size: [u32; 2]| {
        let (x, y) = (i as u32 % size[0], i as u32 / size[0]);
        [(x as f32 + 0.5) / size[0] as f32, (y as f32 + 0.5) / size[1] as f32]
    };
    let length_of = |i: usize, size: [u32; 2]| normals.map_or(1.0, |normals| normals.length(size, place(i, size)));
    let finest = |i: usize| {
        let (x, y) = (i as u32 % size[0], i as u32 / size[0]);
        let mut texel = [0, 1, 2, 3].map(|c| value(x, y, c));
        let length = length_of(i, size);
        if length < 1.0 {
            texel[channel] = table.roughness(table.length(texel[channel]) * length);
        }
        texel.map(unorm8)
    };
    let texels = (0..size[0] as usize * size[1] as usize).into_par_iter().map(finest).collect();
    let mut levels = vec![MipLevel { size, texels }];
    let coarser = level_sizes(size).into_iter().skip(1).zip(filtered::<4>(size, row));
    levels.extend(coarser.map(|(size, means)| {
        let texel = |(i, mean): (usize, &[f32; 4])| {
            let mut texel = *mean;
            texel[channel] = table.roughness(mean[channel] * length_of(i, size));
            texel.map(unorm8)
        };
        MipLevel { size, texels: means.par_iter().enumerate().map(texel).collect() }
    }));
    Mips { levels, srgb: false }
}

/// Mean normal lengths of GGX facets, and the roughness of lengths. Exact conversions would take most of the time.
struct Table {
    /// Roughness by the root of the shortening, in equal steps from 0 to 1.
    roughness: Vec<f32>,
    /// Lengths by roughness, in equal steps from 0 to 1. Codes of 8 bits are entries.
    lengths: Vec<f32>,
}

impl Table {
    const CODES: usize = 255 * 8;

    fn new() -> Self {
        let model = Shortening::default();
        let roughness = |i: usize| model.alpha_of_shortening((i as f64 / STEPS as f64).powi(2)).sqrt().min(1.0) as f32;
        let length = |i: usize| model.length((i as f64 / Self::CODES as f64).powi(2)) as f32;
        Self { roughness: (0..=STEPS).map(roughness).collect(), lengths: (0..=Self::CODES).map(length).collect() }
    }

    fn length(&self, roughness: f32) -> f32 {
        interpolated(&self.lengths, roughness)
    }

    fn roughness(&self, length: f32) -> f32 {
        interpolated(&self.roughness, (1.0 - length).max(0.0).sqrt())
    }
}

/// Returns the value of a table at a position from 0 to 1.
fn interpolated(table: &[f32], at: f32) -> f32 {
    let at = at.clamp(0.0, 1.0) * (table.len() - 1) as f32;
    let below = (at as usize).min(table.len() - 2);
    table[below] + (at - below as f32) * (table[below + 1] - table[below])
}

#[cfg(test)]
mod tests {
    use glam::DVec3;
    use leadr_reflectance::facets::footprint_normals::{NormalTexel, mean_texel};
    use leadr_reflectance::random::Random;

    use super::*;
    use crate::material::Samples;

    #[test]
    fn tables_are_inverse_and_exact() {
        let (table, model) = (Table::new(), Shortening::default());
        // The model's least roughness is 0.01.
        for i in 6..=255 {
            let roughness = i as f32 / 255.0;
            let alpha = f64::from(roughness).powi(2);
            assert!((f64::from(table.length(roughness)) - model.length(alpha)).abs() < 1e-6, "{i}");
            let back = table.roughness(table.length(roughness));
            assert!((back - roughness).abs() < 0.3 / 255.0, "{i}: {back}");
        }
    }

    /// Normals of one footprint with one roughness give the roughness of Chan's algorithm 3.
    #[test]
    fn footprints_are_the_paper_s() {
        let mut random = Random(5);
        let normals: Vec<DVec3> = (0..64 * 64)
            .map(|_| {
                let [x, y] = random.normals();
                DVec3::new(0.2 * x, 0.1 * y, 1.0).normalize()
            })
            .collect();
        let codes = normals.iter().flat_map(|n| (0.5 * n + 0.5).as_vec3().to_array()).collect();
        let map = Raster::new(64, 64, 3, Samples::F32(codes)).unwrap();
        let mips = NormalMips::new(&map, 1.0);
        for factor in [0.1, 0.4, 0.8] {
            let texels: Vec<NormalTexel> =
                normals.iter().map(|&normal| NormalTexel { normal, alpha: f64::from(factor).powi(2) }).collect();
            let expected = mean_texel(&texels, Shortening::default()).alpha.sqrt();
            let source = RoughnessSource { raster: None, channel: 1, factor };
            let found = roughness_mips(source, Some(&mips));
            let [_, rough, _, _] = found.levels.last().unwrap().texels[0];
            assert!((f64::from(rough) / 255.0 - expected).abs() < 0.6 / 255.0, "{factor}: {rough} {expected}");
            assert_eq!(found.levels[0].texels[0], [255, unorm8(factor), 255, 255]);
        }
    }

    /// Without normals, a texture of one roughness keeps it, and channels beside it are averaged.
    #[test]
    fn flat_surfaces_keep_their_roughness() {
        let codes = (0..16).flat_map(|i| [16 * i, 100, 255 - 16 * i]).collect();
        let raster = Raster::new(4, 4, 3, Samples::U8(codes)).unwrap();
        let found = roughness_mips(RoughnessSource { raster: Some(&raster), channel: 1, factor: 1.0 }, None);
        assert_eq!(found.levels[0].texels[3], [48, 100, 207, 255]);
        assert_eq!(found.levels[2].texels, [[120, 100, 135, 255]]);
    }

    /// A roughness texture of another size has the spread of the normals under its own texels.
    #[test]
    fn sizes_may_differ() {
        let zigzag = |i: u32| if i.is_multiple_of(2) { [0.8, 0.5, 0.9] } else { [0.2, 0.5, 0.9] };
        let normals = Raster::new(8, 8, 3, Samples::F32((0..64).flat_map(zigzag).collect())).unwrap();
        let mips = NormalMips::new(&normals, 1.0);
        let rough = |side: u32| {
            let raster = Raster::new(side, side, 1, Samples::U8(vec![51; (side * side) as usize])).unwrap();
            roughness_mips(RoughnessSource { raster: Some(&raster), channel: 0, factor: 1.0 }, Some(&mips))
        };
        let [large, same, small] = [32, 8, 2].map(rough);
        let first = |mips: &Mips, level: usize| mips.levels[level].texels[0][0];
        assert_eq!([first(&large, 0), first(&large, 2), first(&same, 0)], [51; 3]);
        assert!(first(&same, 1) > 150);
        assert_eq!(first(&large, 3), first(&same, 1));
        assert_eq!(first(&small, 0), first(&same, 2));
    }
}
