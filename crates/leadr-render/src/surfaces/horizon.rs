//! The horizon maps of an object, which describe how the relief occludes itself, at every texel of every height level
//! ([`leadr_reflectance::visible::horizon`]). There are two images:
//!
//! * leans, RGBA: `lean` (xy) and the standard deviations of `spread` (zw), in height units per unit of texture coordinate
//! * correlations, R: the correlation of `spread`
//!
//! Each level is computed from *its own* filtered heights, because the slope moments represent detail that is smaller than a texel
//! of the level. The coarsest level has no occluders. For large maps, the images begin at a coarser level than the heights.

use std::cmp::Ordering;
use std::sync::Arc;

use rayon::prelude::*;

use super::atlas::tiles::Tiles;
use super::displacement::Border;
use super::moments::LeadrMapGpu;
use super::patch_mesh::PatchMesh;
use super::placeholder;
use super::topology::Topology;
use crate::constants::SOURCE_LEVEL;
use leadr_gpu::vk::Format;
use leadr_gpu::{Gpu, GpuError, Image, ImageDesc, Result};
use leadr_maps::Wrap;
use leadr_maps::cache::{MapCache, expect_all, put};
use leadr_maps::checksum::checksum;
use leadr_maps::horizon::{Heights, HorizonTexel, Rays, Window, horizons};

/// The maximum number of texels of a horizon map. The horizons of larger maps start at a coarser level, which then serves all finer
/// levels too.
pub const MOST_TEXELS: u32 = 8 << 20;

/// The number of pairs of opposite rays per texel. An atlas has many more texels, so its tiles use fewer rays.
const AXES: usize = 8;
const TILE_AXES: usize = 4;

/// The maximum length of rays on an atlas, in texels of the level and in texels of level 0.
const TILE_REACH: [u32; 2] = [12, 24];

/// The smallest number of texels that is worth caching. Computing fewer texels is as fast as reading a file.
const LEAST_CACHED: usize = 1 << 18;

/// The source code that determines the horizons, as part of the cache key.
const SOURCES: [&str; 4] = [
    include_str!("horizon.rs"),
    include_str!("atlas/tiles.rs"),
    include_str!("moments.rs"),
    leadr_maps::horizon::SOURCE,
];

/// What the horizons of a map depend on, apart from the heights.
pub struct HorizonInput<'a> {
    /// The mesh of the surface with the relief.
    pub mesh: &'a PatchMesh,
    /// The edges of the mesh.
    pub topology: &'a Topology,
    /// The border rule of the map.
    pub border: Border,
    /// The height scale, of which only the sign matters.
    pub height_scale: f32,
}

impl HorizonInput<'_> {
    fn sign(&self) -> f32 {
        if self.height_scale < 0.0 { -1.0 } else { 1.0 }
    }

    /// Returns the cache key for this relief. `heights` is the checksum of its heights.
    fn key(&self, size: [u32; 2], heights: u64) -> u64 {
        let mut words = vec![u64::from(size[0]) << 32 | u64::from(size[1]), heights, u64::from(self.sign() > 0.0)];
        match self.border {
            Border::Wrap => words.push(0),
            Border::Clamp => words.push(1),
            Border::Tiles(layout) => {
                words.extend([2, layout.tile, layout.gutter, layout.columns].map(u64::from));
                words.push(checksum(bytemuck::cast_slice(&self.mesh.patches)));
                let positions: Vec<[f32; 3]> = self.mesh.positions.iter().map(|p| p.to_array()).collect();
                words.push(checksum(bytemuck::cast_slice(&positions)));
            }
        }
        words.extend(SOURCES.map(|source| checksum(source.as_bytes())));
        checksum(bytemuck::cast_slice(&words))
    }
}

/// The number of bytes per texel in each of the two images.
const TEXEL_BYTES: [usize; 2] = [8, 2];

/// The horizon maps of an object. Clones share the images.
#[derive(Clone)]
pub struct HorizonMaps {
    /// The values `lean` and the standard deviations of `spread`, with mips.
    pub leans: Image,
    /// The correlations of `spread`, with mips.
    pub correlations: Image,
}

/// A level of the LEADR maps on the CPU.
struct HeightLevel {
    size: [u32; 2],
    heights: Vec<f32>,
    /// The mean slopes, in height units per texel.
    slopes: Vec<[f32; 2]>,
}

impl HeightLevel {
    /// Reads back a level. `sign` is -1 for heights that point inwards, and 1 otherwise.
    fn read(maps: &LeadrMapGpu, level: u32, sign: f32) -> Result<Self> {
        let size = maps.heights.mip_extent(level);
        let [w, h] = size.map(|n| sign / n as f32);
        let heights: Vec<f32> = maps.heights.read(level, 0)?;
        let slopes = maps.read_slopes(level)?;
        Ok(Self {
            size,
            heights: heights.iter().map(|v| v * sign).collect(),
            slopes: slopes.iter().map(|m| [m[0] * w, m[1] * h]).collect(),
        })
    }

    /// Computes the horizons of a map without tiles.
    fn of_map(&self, wrap: Wrap) -> Vec<HorizonTexel> {
        let [width, height] = self.size.map(|n| n as usize);
        let heights = Heights::new(width, height, &self.heights, wrap);
        let rays = Rays { axes: AXES, reach: width.max(height) / 2 };
        horizons(&heights, Window { x: 0, y: 0, width, height }, &self.slopes, rays)
    }

    /// Computes the horizons of an atlas with one tile per patch. Rays continue in the tiles of adjacent patches.
    fn of_tiles(&self, level: u32, atlas: &Tiles) -> Vec<HorizonTexel> {
        let layout = atlas.layout();
        let [width, height] = self.size.map(|n| n as usize);
        let side = (layout.tile >> level) as usize;
        let reach = TILE_REACH[0].min(TILE_REACH[1] >> level).min(layout.inner() >> level) as usize;
        let margin = reach + 2;
        let tiles: Vec<Vec<HorizonTexel>> = (0..atlas.patches())
            .into_par_iter()
            .map(|patch| {
                let texels = atlas.around(&self.heights, width, level, patch, margin);
                let around = side + 2 * margin;
                let heights = Heights::new(around, around, &texels, Wrap::Clamp);
                let start = layout.first_texel(patch, level);
                let rows = (0..side).flat_map(|y| &self.slopes[start + y * width..][..side]);
                let slopes: Vec<[f32; 2]> = rows.copied().collect();
                let window = Window { x: margin, y: margin, width: side, height: side };
                horizons(&heights, window, &slopes, Rays { axes: TILE_AXES, reach })
            })
            .collect();
        let mut texels = vec![HorizonTexel::default(); width * height];
        for (patch, tile) in tiles.iter().enumerate() {
            let start = layout.first_texel(patch, level);
            let gutter = (layout.gutter >> level) as usize;
            let inside = |k: usize| k.clamp(gutter, side - 1 - gutter);
            for y in 0..side {
                let row = &mut texels[start + y * width..][..side];
                row.copy_from_slice(&tile[y * side..][..side]);
                // A corner of the gutter repeats the nearest texel of the patch. Any number of patches can meet there.
                for x in (0..gutter).chain(side - gutter..side).filter(|_| inside(y) != y) {
                    row[x] = tile[inside(y) * side + inside(x)];
                }
            }
        }
        texels
    }
}

/// Checks the stored texels of all levels: finite leans, deviations of at least 0, correlations from -1 to 1.
fn check_texels(mut bytes: &[u8], sizes: &[usize]) -> std::result::Result<(), &'static str> {
    const INFINITE: u16 = 0x7c00;
    const ONE: u16 = 0x3c00;
    let size_of = |half: &[u8; 2]| u16::from_le_bytes(*half) & 0x7fff;
    for count in sizes {
        let (leans, rest) = bytes.split_at(TEXEL_BYTES[0] * count);
        let (correlations, rest) = rest.split_at(TEXEL_BYTES[1] * count);
        let is_horizon = |texel: &[[u8; 2]; 4]| {
            texel.iter().all(|half| size_of(half) < INFINITE)
                && texel[2..].iter().all(|half| half[1] >> 7 == 0 || size_of(half) == 0)
        };
        expect_all(leans.as_chunks().0.as_chunks().0, is_horizon)?;
        expect_all(correlations.as_chunks().0, |half| size_of(half) <= ONE)?;
        bytes = rest;
    }
    Ok(())
}

impl HorizonMaps {
    /// Creates placeholders for an object without relief. Shaders never read them.
    pub fn none(gpu: &Arc<Gpu>) -> Result<Self> {
        Ok(Self {
            leans: placeholder(gpu, "no horizon", Format::R16G16B16A16_SFLOAT)?,
            correlations: placeholder(gpu, "no horizon correlation", Format::R16_SFLOAT)?,
        })
    }

    /// Computes the horizons of the heights in `maps`. Large results come from the cache if it contains them. `cache` is the cache,
    /// together with the checksum of the heights.
    pub fn new(
        gpu: &Arc<Gpu>,
        name: &str,
        maps: &LeadrMapGpu,
        relief: &HorizonInput<'_>,
        cache: Option<(&MapCache, u64)>,
    ) -> Result<Self> {
        let levels = match relief.border {
            Border::Wrap | Border::Clamp => maps.levels(),
            // The filter pass does not use coarser levels of the tiles than this.
            Border::Tiles(_) => maps.levels().min(SOURCE_LEVEL + 1),
        };
        let small = |&level: &u32| maps.heights.mip_extent(level).iter().product::<u32>() <= MOST_TEXELS;
        let first = (0..levels).find(small).unwrap_or(levels - 1);
        let [width, height] = maps.heights.mip_extent(first);
        let desc = ImageDesc::new(Format::R16G16B16A16_SFLOAT, width, height).mips(levels - first);
        let leans = Image::new(gpu, &format!("{name} horizon"), desc)?;
        let single = ImageDesc { format: Format::R16_SFLOAT, ..desc };
        let correlations = Image::new(gpu, &format!("{name} horizon correlation"), single)?;
        let sizes: Vec<usize> =
            (first..levels).map(|level| maps.heights.mip_extent(level).iter().product::<u32>() as usize).collect();
        // The bytes hold all levels in order, with both images for each level.
        let find = || {
            let mut bytes = Vec::new();
            (first..levels).try_for_each(|level| Self::level(maps, level, relief, &mut bytes))?;
            Ok::<_, GpuError>(bytes)
        };
        let upload = |mut bytes: &[u8]| {
            for (level, count) in (0..).zip(&sizes) {
                for (image, texel) in [&leans, &correlations].into_iter().zip(TEXEL_BYTES) {
                    let (texels, rest) = bytes.split_at(texel * count);
                    image.write(level, 0, texels)?;
                    bytes = rest;
                }
            }
            Ok::<_, GpuError>(())
        };
        let texels: usize = sizes.iter().sum();
        let length = texels * TEXEL_BYTES.iter().sum::<usize>();
        match cache {
            Some((cache, heights)) if texels >= LEAST_CACHED => {
                let key = relief.key(maps.heights.mip_extent(0), heights);
                // Cached data are uploaded without a copy.
                let read = |bytes: &[u8]| match bytes.len().cmp(&length) {
                    Ordering::Less => Err("it is too short"),
                    Ordering::Greater => Err("it is too long"),
                    Ordering::Equal => check_texels(bytes, &sizes).map(|()| upload(bytes)),
                };
                let make = || find().map(|bytes| (upload(&bytes), bytes));
                cache.load_or_make("horizon", key, length as u64, read, make)??;
            }
            _ => upload(&find()?)?,
        }
        Ok(Self { leans, correlations })
    }

    /// Appends the horizons of a level to `bytes`.
    fn level(maps: &LeadrMapGpu, level: u32, relief: &HorizonInput<'_>, bytes: &mut Vec<u8>) -> Result<()> {
        let read = HeightLevel::read(maps, level, relief.sign())?;
        let texels = match relief.border {
            Border::Wrap => read.of_map(Wrap::Repeat),
            Border::Clamp => read.of_map(Wrap::Clamp),
            Border::Tiles(layout) => read.of_tiles(level, &Tiles::new(relief.mesh, relief.topology, layout)),
        };
        let (leans, correlations): (Vec<[u16; 4]>, Vec<u16>) =
            texels.iter().map(|texel| texel.halves(read.size)).unzip();
        put(bytes, &leans);
        put(bytes, &correlations);
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn planted_texels_are_refused() {
        let texels: [[u16; 4]; 2] = [[0xbc00, 0x3c00, 0x3c00, 0x8000], [0; 4]];
        let check = |at: usize, half: u16| {
            let mut bytes = Vec::new();
            put(&mut bytes, &texels);
            put(&mut bytes, &[0xbc00_u16, 0x3c00]);
            bytes[2 * at..][..2].copy_from_slice(&half.to_le_bytes());
            check_texels(&bytes, &[2])
        };
        assert_eq!(check(0, 0xbc00), Ok(()));
        for (at, half) in [(0, 0x7e00), (1, 0x7c00), (2, 0xfc00), (7, 0xbc00), (8, 0x7e00), (9, 0x3c01), (8, 0xbc01)] {
            assert!(check(at, half).is_err(), "{at} {half:x}");
        }
    }
}
