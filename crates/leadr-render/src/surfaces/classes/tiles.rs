//! The maps of an atlas in which its classes are found.
//!
//! Patches differ in size and in their coordinate directions. Slopes are therefore rise over run along
//! [aligned](crate::surfaces::atlas::turns) directions, per unit of height. The openness is measured in windows of some tiles and the
//! tiles around them, in which rays march as if all texels had the mean size.

use std::borrow::Cow;

use glam::Vec2;
use leadr_maps::checksum::checksum;
use leadr_maps::derive::{OpennessWindow, WindowFacet};
use leadr_maps::{HeightMap, MomentLevel, Moments};
use rayon::prelude::*;

use crate::surfaces::atlas::frames::AtlasFrames;
use crate::surfaces::atlas::tiles::Tiles;
use crate::surfaces::atlas::turns::{quarter_turns, turned_moments, turned_texcoord, turned_texels};
use crate::surfaces::patch_mesh::{PatchMesh, TileLayout};
use crate::surfaces::topology::Topology;

/// The largest number of texels of an atlas in which classes are found.
const MOST_TEXELS: u32 = 32 << 20;
/// The largest number of texels of the classes, which then need up to 0.7 GB. The classes of larger atlases start at a coarser level.
const MOST_CLASS_TEXELS: u32 = 8 << 20;
/// The number of windows, and of facets that are measured in each of them.
const WINDOWS: usize = 64;
const FACETS: usize = 512;

/// The tiles of an atlas and the surface on which they lie.
pub(super) struct AtlasSurface<'a> {
    mesh: Cow<'a, PatchMesh>,
    layout: TileLayout,
}

/// The relief of an atlas as rise over run.
pub(super) struct AtlasRelief {
    /// The moments of all texels. Tiles without a patch repeat the first tile.
    pub level: MomentLevel,
    /// Windows of some patches.
    pub windows: Vec<OpennessWindow>,
}

impl<'a> AtlasSurface<'a> {
    /// Returns `None` if the search would need too much memory.
    pub fn new(mesh: &'a PatchMesh, layout: TileLayout) -> Option<Self> {
        let (width, height) = layout.size();
        let is_small = width.checked_mul(height).is_some_and(|texels| texels <= MOST_TEXELS);
        (is_small && !mesh.patches.is_empty()).then_some(Self { mesh: Cow::Borrowed(mesh), layout })
    }

    /// Returns how many of the finest levels have no classes.
    pub fn skipped(&self) -> usize {
        let (width, height) = self.layout.size();
        (0..).find(|skipped| (width >> skipped) * (height >> skipped) <= MOST_CLASS_TEXELS).unwrap_or(0)
    }

    pub fn into_owned(self) -> AtlasSurface<'static> {
        AtlasSurface { mesh: Cow::Owned(self.mesh.into_owned()), layout: self.layout }
    }

    /// Returns numbers that determine the surface, as part of a cache key.
    pub fn key(&self) -> [u64; 5] {
        let Self { mesh, layout } = self;
        let vectors = |of: &[glam::Vec3]| {
            let values: Vec<[f32; 3]> = of.iter().map(|v| v.to_array()).collect();
            checksum(bytemuck::cast_slice(&values))
        };
        let [tile, gutter] = [layout.tile, layout.gutter].map(u64::from);
        let patches = checksum(bytemuck::cast_slice(&mesh.patches));
        [tile, gutter, patches, vectors(&mesh.positions), vectors(&mesh.normals)]
    }

    /// Converts the moments of an atlas, whose slopes are per unit of texture coordinate.
    pub fn relief(&self, heights: &HeightMap, mut level: MomentLevel) -> AtlasRelief {
        let Self { mesh, layout } = self;
        let (width, height) = layout.size();
        let frames = AtlasFrames::new(mesh, *layout);
        let topology = Topology::new(&mesh.welded_patches());
        let turns = quarter_turns(&topology.neighbors());
        let lengths: Vec<[Vec2; 4]> = (0..mesh.patches.len())
            .map(|patch| {
                std::array::from_fn(|corner| Vec2::from(frames.corner(patch, corner).tangents.map(|t| t.length())))
            })
            .collect();
        let mean = lengths.as_flattened().iter().sum::<Vec2>() / (4 * lengths.len()) as f32;
        let texel = (mean / Vec2::new(width as f32, height as f32)).element_sum() / 2.0;
        let margin = layout.inner() as usize;
        let side = layout.tile as usize + 2 * margin;
        // Heights in units of a window make its slopes rise over run.
        let per_window = 1.0 / (side as f32 * texel).max(1e-20);
        self.to_rise_over_run(&mut level, &lengths, &turns, per_window);
        let tiles = Tiles::new(mesh, &topology, *layout);
        let step = mesh.patches.len().div_ceil(WINDOWS);
        let window = |patch: usize| {
            let around = tiles.around(&heights.texels, width as usize, 0, patch, margin);
            let texels = around.into_iter().map(|height| height * per_window).collect();
            let texels = turned_texels(texels, side, turns[patch]);
            let facet = |(at, index): (Vec2, usize)| WindowFacet {
                at: turned_texcoord(((at + margin as f32) / side as f32).to_array().map(f64::from), turns[patch]),
                moments: level.texels[index],
                material_at: self.texcoord(index),
            };
            let heights = HeightMap { width: side as u32, height: side as u32, texels };
            OpennessWindow { heights, facets: self.texels_of(patch, FACETS).map(facet).collect() }
        };
        let windows = (0..mesh.patches.len()).into_par_iter().step_by(step).map(window).collect();
        AtlasRelief { level, windows }
    }

    /// Converts slopes to rise over run in aligned directions. `lengths` are those of the tangents at the corners of the patches.
    fn to_rise_over_run(&self, level: &mut MomentLevel, lengths: &[[Vec2; 4]], turns: &[u32], per_height: f32) {
        let layout = self.layout;
        let (tile, columns, inner) = (layout.tile as usize, layout.columns as usize, layout.inner() as f32);
        let width = level.width as usize;
        level.texels.par_chunks_mut(width * tile).enumerate().for_each(|(row, texels)| {
            for (i, texel) in texels.iter_mut().enumerate() {
                let (x, y) = (i % width, i / width);
                let patch = row * columns + x / tile;
                let Some([a, b, c, d]) = lengths.get(patch) else { continue };
                let at = (Vec2::new((x % tile) as f32, y as f32) + 0.5 - layout.gutter as f32) / inner;
                let at = at.clamp(Vec2::ZERO, Vec2::ONE);
                let length = a.lerp(*b, at.x).lerp(d.lerp(*c, at.x), at.y).max(Vec2::splat(1e-20));
                let [s, t] = length.recip().to_array();
                let moments = Moments {
                    mean_slope: [texel.mean_slope[0] * s, texel.mean_slope[1] * t],
                    second: [texel.second[0] * s * s, texel.second[1] * t * t],
                    cross: texel.cross * s * t,
                    height: texel.height * per_height,
                };
                *texel = turned_moments(moments, turns[patch]);
            }
        });
        for unused in lengths.len()..columns * layout.rows as usize {
            let (from, to) = (layout.first_texel(0, 0), layout.first_texel(unused, 0));
            for y in 0..tile {
                level.texels.copy_within(from + y * width..from + y * width + tile, to + y * width);
            }
        }
    }

    /// Returns about `most` texels from all parts of a patch: their positions in the tile in texels, and their indices in the atlas.
    fn texels_of(&self, patch: usize, most: usize) -> impl Iterator<Item = (Vec2, usize)> + use<> {
        let layout = self.layout;
        let inner = layout.inner() as usize;
        // An odd step reaches all columns, because their number is even.
        let step = (inner * inner / most.max(1)) | 1;
        let (first, width) = (layout.first_texel(patch, 0), layout.size().0 as usize);
        // Patches start at different texels.
        (patch % step..inner * inner).step_by(step).map(move |i| {
            let [x, y] = [i % inner, i / inner].map(|k| k + layout.gutter as usize);
            (Vec2::new(x as f32, y as f32) + 0.5, first + y * width + x)
        })
    }

    /// Returns the texture coordinate of the centre of a texel.
    fn texcoord(&self, index: usize) -> [f64; 2] {
        let (width, height) = self.layout.size();
        let centre = |k: usize, side: u32| (k as f64 + 0.5) / f64::from(side);
        [centre(index % width as usize, width), centre(index / width as usize, height)]
    }
}
