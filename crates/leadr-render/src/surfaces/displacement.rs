//! Heights at the edges and vertices that patches share.
//!
//! Inside a patch, the tessellation stage reads heights from the LEADR map. Two patches must agree to the last bit along a shared
//! edge, even if their texture coordinates differ (at a UV seam, or in two atlas tiles). The heights along every edge and at every
//! vertex are therefore baked once, as the mean over the adjacent patches. The baked heights are stored at [`EDGE_LEVELS`]
//! resolutions, each filtered to the spacing of its samples. Heights are 0 on rims, where another object continues the surface.

use std::borrow::Cow;
use std::collections::HashSet;

use super::height_scale::HeightTerms;
use super::patch_mesh::{PatchMesh, TileLayout};
use super::topology::Topology;
use super::triplanar::{self, MOST_BLENDED};
use crate::constants;
use glam::Vec2;
use leadr_maps::HeightMap;
use rayon::prelude::*;

/// The number of resolutions of the heights along an edge, which are 64, 32, … 1 segments.
pub const EDGE_LEVELS: usize = constants::EDGE_LEVELS as usize;
/// The number of height samples of one edge, over all levels.
pub const EDGE_STRIDE: usize = constants::EDGE_STRIDE as usize;

/// A height map, and how it continues beyond its borders.
#[derive(Clone, Debug)]
pub struct HeightField {
    /// The heights, in the mesh's unit of length.
    pub map: HeightMap,
    /// How the map continues beyond its borders.
    pub border: Border,
}

/// How a map continues beyond its borders.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Border {
    /// The map repeats.
    Wrap,
    /// The last texel repeats.
    Clamp,
    /// The map has one tile per patch, and samples stay inside their own tile.
    Tiles(TileLayout),
}

impl HeightField {
    /// Creates a height field from a map that repeats.
    pub fn repeating(map: HeightMap) -> Self {
        Self { map, border: Border::Wrap }
    }

    /// Returns a placeholder with a single height of 0, which shaders never sample.
    pub(super) fn flat() -> Self {
        Self { map: HeightMap { width: 1, height: 1, texels: vec![0.0] }, border: Border::Clamp }
    }

    /// Applies the border rule to texel index `i` along an axis of `n` texels.
    fn within(&self, i: i64, n: u32) -> usize {
        match self.border {
            Border::Wrap => i.rem_euclid(i64::from(n)) as usize,
            Border::Clamp | Border::Tiles(_) => i.clamp(0, i64::from(n) - 1) as usize,
        }
    }

    fn texel(&self, x: i64, y: i64) -> f32 {
        self.map.texels[self.within(y, self.map.height) * self.map.width as usize + self.within(x, self.map.width)]
    }

    /// Returns the two texels around a position along an axis of `n` texels, and the interpolation weight of the second texel.
    fn beside(&self, position: f32, n: u32) -> ([usize; 2], f32) {
        // This code runs many millions of times. On targets limited to SSE2, `floor` would be a function call.
        let toward_zero = position as i32;
        let cell = i64::from(toward_zero) - i64::from(position < toward_zero as f32);
        let inside = cell >= 0 && cell + 1 < i64::from(n);
        let texels = [cell, cell + 1].map(|i| if inside { i as usize } else { self.within(i, n) });
        (texels, position - cell as f32)
    }

    /// Samples the map bilinearly at a texture coordinate.
    pub fn bilinear(&self, texcoord: Vec2) -> f32 {
        let (columns, fx) = self.beside(texcoord.x * self.map.width as f32 - 0.5, self.map.width);
        let (rows, fy) = self.beside(texcoord.y * self.map.height as f32 - 0.5, self.map.height);
        let along = |row: usize| {
            let [a, b] = columns.map(|column| self.map.texels[row * self.map.width as usize + column]);
            a * (1.0 - fx) + b * fx
        };
        along(rows[0]) * (1.0 - fy) + along(rows[1]) * fy
    }

    /// Samples the map with Catmull-Rom interpolation, which has continuous slopes, to resample a map at a finer resolution.
    pub fn bicubic(&self, texcoord: Vec2) -> f32 {
        let (x, y) = (texcoord.x * self.map.width as f32 - 0.5, texcoord.y * self.map.height as f32 - 0.5);
        let (x0, y0) = (x.floor(), y.floor());
        let weights = |t: f32| {
            let (t2, t3) = (t * t, t * t * t);
            [-0.5 * t3 + t2 - 0.5 * t, 1.5 * t3 - 2.5 * t2 + 1.0, -1.5 * t3 + 2.0 * t2 + 0.5 * t, 0.5 * (t3 - t2)]
        };
        let (wx, wy) = (weights(x - x0), weights(y - y0));
        (0..4)
            .map(|j| {
                let row = y0 as i64 + j - 1;
                let sum: f32 = (0..4).map(|i| wx[i] * self.texel(x0 as i64 + i as i64 - 1, row)).sum();
                wy[j as usize] * sum
            })
            .sum()
    }
}

/// A chain of box-filtered mips of heights on the CPU, which is sampled like the LEADR map on the device.
pub(super) struct HeightPyramid<'a> {
    /// The levels from fine to coarse. The first level is the height field itself.
    levels: Vec<Cow<'a, HeightField>>,
}

impl<'a> HeightPyramid<'a> {
    pub(super) fn new(field: &'a HeightField) -> Self {
        let mut pyramid = Self { levels: vec![Cow::Borrowed(field)] };
        while (pyramid.coarsest().map.width, pyramid.coarsest().map.height) != (1, 1) {
            let source = pyramid.coarsest();
            let (width, height) = ((source.map.width / 2).max(1), (source.map.height / 2).max(1));
            let mut texels = vec![0.0; width as usize * height as usize];
            texels.par_chunks_mut(width as usize).zip(0..height).for_each(|(row, y)| {
                for (texel, x) in row.iter_mut().zip(0..) {
                    *texel = box_filter(source, width, height, x, y);
                }
            });
            let map = HeightMap { width, height, texels };
            pyramid.levels.push(Cow::Owned(HeightField { map, border: field.border }));
        }
        pyramid
    }

    fn coarsest(&self) -> &HeightField {
        &self.levels[self.levels.len() - 1]
    }

    /// Returns the width and height of the finest level, in texels.
    fn size(&self) -> Vec2 {
        Vec2::new(self.levels[0].map.width as f32, self.levels[0].map.height as f32)
    }

    /// Prepares trilinear sampling at a level of detail. In an atlas, samples stay inside tile `patch`, as in the shader's
    /// `clamp_to_tile`.
    pub(super) fn lookup(&self, lod: f32, patch: usize) -> Lookup<'_> {
        let spacing = lod;
        let mut lod = lod.clamp(0.0, (self.levels.len() - 1) as f32);
        let mut inside = None;
        if let Border::Tiles(layout) = self.levels[0].border {
            lod = lod.min((layout.tile as f32).log2());
            let (x, y) = layout.origin(patch as u32);
            let low = Vec2::new(x as f32, y as f32);
            let inset = Vec2::splat((lod.ceil().exp2() * 0.5).min(layout.tile as f32 * 0.5));
            inside = Some([self.size(), low + inset, low + Vec2::splat(layout.tile as f32) - inset]);
        }
        let level = lod as usize;
        Lookup { pyramid: self, spacing, level, fraction: lod - level as f32, inside }
    }
}

/// Samples a pyramid at one level of detail.
pub(super) struct Lookup<'a> {
    pyramid: &'a HeightPyramid<'a>,
    /// The level of detail, which is not clamped to the levels of the pyramid.
    spacing: f32,
    level: usize,
    fraction: f32,
    /// The size of the map, and the lowest and highest allowed sample positions, in texels.
    inside: Option<[Vec2; 3]>,
}

impl Lookup<'_> {
    pub(super) fn at(&self, texcoord: Vec2) -> f32 {
        let texcoord = self.inside.map_or(texcoord, |[size, low, high]| (texcoord * size).clamp(low, high) / size);
        let &Self { pyramid, level, fraction, .. } = self;
        let at = |level: usize| pyramid.levels[level].bilinear(texcoord);
        if fraction == 0.0 { at(level) } else { at(level) * (1.0 - fraction) + at(level + 1) * fraction }
    }
}

/// Looks up heights at the corners of a mesh and along its edges.
struct Mapped<'a> {
    mesh: &'a PatchMesh,
    pyramid: HeightPyramid<'a>,
    terms: &'a HeightTerms<'a>,
}

impl Mapped<'_> {
    fn mean(&self) -> f32 {
        self.pyramid.coarsest().map.texels[0]
    }

    /// Returns the vector between two corners of a patch, in texels. For triplanar maps, x is an upper bound on the length of this
    /// vector, and y is 0.
    fn extent(&self, patch: usize, from: usize, to: usize) -> Vec2 {
        let size = self.pyramid.size();
        if let Some(repeat) = self.mesh.triplanar {
            let [a, b] = [from, to].map(|corner| self.mesh.positions[self.mesh.patches[patch][corner] as usize]);
            return Vec2::new(a.distance(b) / repeat * size.max_element(), 0.0);
        }
        let t = &self.mesh.texcoords[patch];
        (t[to] - t[from]) * size
    }

    /// Returns the height between two corners of a patch, at the fraction `part` of the way, with its scale and detail. The
    /// height is sampled with the patch's `lookup`.
    fn height(&self, patch: usize, from: usize, to: usize, part: f32, lookup: &Lookup<'_>) -> f32 {
        self.terms.whole(self.of_map(patch, from, to, part, lookup), patch, [from, to], part, lookup.spacing)
    }

    fn of_map(&self, patch: usize, from: usize, to: usize, part: f32, lookup: &Lookup<'_>) -> f32 {
        if let Some(repeat) = self.mesh.triplanar {
            let [a, b] = [from, to].map(|corner| self.mesh.patches[patch][corner] as usize);
            let position = self.mesh.positions[a].lerp(self.mesh.positions[b], part);
            let normal = self.mesh.normals[a].lerp(self.mesh.normals[b], part).normalize_or_zero();
            return triplanar::blend(position, normal, repeat, self.mean(), |texcoord| lookup.at(texcoord));
        }
        let t = &self.mesh.texcoords[patch];
        lookup.at(t[from].lerp(t[to], part))
    }
}

/// Returns the area-weighted mean of the source texels under texel `(x, y)` of a `w × h` level, exactly for odd sizes too.
fn box_filter(source: &HeightField, w: u32, h: u32, x: u32, y: u32) -> f32 {
    if (source.map.width, source.map.height) == (2 * w, 2 * h) {
        let rows = [2 * y, 2 * y + 1].map(|y| &source.map.texels[(y * source.map.width + 2 * x) as usize..][..2]);
        return (rows.into_iter().flatten().map(|&t| f64::from(t)).sum::<f64>() / 4.0) as f32;
    }
    let span = |i: u32, from: u32, to: u32| {
        let (low, high) = (f64::from(i * from) / f64::from(to), f64::from((i + 1) * from) / f64::from(to));
        (low.floor() as u32..(high.ceil() as u32).min(from)).map(move |k| {
            let weight = (f64::from(k) + 1.0).min(high) - f64::from(k).max(low);
            (k, weight)
        })
    };
    let (mut sum, mut total) = (0.0, 0.0);
    for (j, wy) in span(y, source.map.height, h) {
        for (i, wx) in span(x, source.map.width, w) {
            sum += f64::from(source.map.texels[(j * source.map.width + i) as usize]) * wx * wy;
            total += wx * wy;
        }
    }
    (sum / total) as f32
}

/// Baked heights of edges and vertices, and the height range of each patch. The height scale is not yet applied.
#[derive(Clone, Debug)]
pub struct BoundaryHeights {
    /// The heights along the edges, with [`EDGE_STRIDE`] samples for each edge of the topology.
    pub edges: Vec<f32>,
    /// The heights at the vertices, with [`EDGE_LEVELS`] samples for each vertex.
    pub vertices: Vec<f32>,
    /// The lowest and the highest height of each patch, over its tile or over the whole map if there are no tiles.
    pub patch_range: Vec<[f32; 2]>,
    /// The number of map texels along each edge, which is the maximum over the adjacent patches.
    pub edge_texels: Vec<f32>,
    /// The largest height range of the patches at each edge, or 0 on a rim.
    pub edge_relief: Vec<f32>,
}

impl BoundaryHeights {
    /// Returns placeholders for a mesh without relief. Shaders never read them.
    pub fn none() -> Self {
        Self {
            edges: vec![0.0],
            vertices: vec![0.0; EDGE_LEVELS],
            patch_range: Vec::new(),
            edge_texels: Vec::new(),
            edge_relief: Vec::new(),
        }
    }

    /// Returns the data for a map that is tiled by example. The device samples the heights at shared edges directly, because
    /// adjacent patches have equal texture coordinates there. `vertices` holds the levels of detail for these samples.
    pub fn by_example(mesh: &PatchMesh, topology: &Topology, field: &HeightField, terms: &HeightTerms<'_>) -> Self {
        let mapped = Mapped { mesh, pyramid: HeightPyramid { levels: vec![Cow::Borrowed(field)] }, terms };
        let mut extents = vec![(0.0, 0); mesh.positions.len()];
        let mut edge_texels = vec![1.0f32; topology.edges.len()];
        for (patch, edges) in topology.patch_edges.iter().enumerate() {
            for side in topology.sides(patch) {
                let extent = mapped.extent(patch, side, (side + 1) & 3);
                let texels = &mut edge_texels[(edges[side] >> 1) as usize];
                *texels = texels.max(extent.length());
                for corner in [side, (side + 1) & 3] {
                    let (sum, count) = &mut extents[mesh.patches[patch][corner] as usize];
                    *sum += extent.length();
                    *count += 1;
                }
            }
        }
        let lods = |&(sum, count): &(f32, u32)| {
            let extent = Vec2::X * (sum / count.max(1) as f32);
            (0..EDGE_LEVELS).map(move |level| level_lod(extent, level).max(0.0))
        };
        let ranges = patch_ranges(mesh, field);
        let wider = |range: [f32; 2]| {
            // Blended heights can deviate further from the map's mean than any texel. The mean lies between `low` and `high`.
            let [low, high] = range;
            [high - MOST_BLENDED * (high - low), low + MOST_BLENDED * (high - low)]
        };
        Self {
            edges: vec![0.0],
            vertices: extents.iter().flat_map(lods).collect(),
            edge_relief: vec![relief_of(&ranges, terms); topology.edges.len()],
            patch_range: whole_ranges(ranges.into_iter().map(wider).collect(), terms),
            edge_texels: edge_texels.into_iter().map(|texels| texels * terms.finer()).collect(),
        }
    }

    /// Bakes the heights of all edges and vertices of `mesh`.
    pub fn bake(mesh: &PatchMesh, topology: &Topology, field: &HeightField, terms: &HeightTerms<'_>) -> Self {
        let mapped = Mapped { mesh, pyramid: HeightPyramid::new(field), terms };
        // Here, `sides` holds the patch sides at each edge, and `corners` holds the patch corners at each position.
        let mut sides = vec![Vec::with_capacity(2); topology.edges.len()];
        let mut corners = vec![Vec::with_capacity(4); mesh.positions.len()];
        for (patch, edges) in topology.patch_edges.iter().enumerate() {
            for side in topology.sides(patch) {
                sides[(edges[side] >> 1) as usize].push((patch, side, edges[side] & 1 == 1));
                corners[mesh.weld_of(mesh.patches[patch][side]) as usize].push((patch, side));
            }
        }
        let rims: HashSet<[u32; 2]> = mesh.rims.iter().map(|&[a, b]| [a.min(b), a.max(b)]).collect();
        let on_rim: HashSet<u32> = rims.iter().flatten().copied().collect();
        let at_welds: Vec<[f32; EDGE_LEVELS]> = corners
            .par_iter()
            .enumerate()
            .map(|(weld, corners)| {
                if on_rim.contains(&(weld as u32)) {
                    return [0.0; EDGE_LEVELS];
                }
                std::array::from_fn(|level| {
                    mean(corners.iter().map(|&(patch, corner)| {
                        // A triangle stores its third corner in the last two slots.
                        let before = if mesh.triangles && corner == 3 { 1 } else { (corner + 3) & 3 };
                        let along = [(corner + 1) & 3, before].map(|other| mapped.extent(patch, corner, other).abs());
                        let lod = level_lod((along[0] + along[1]) * 0.5, level);
                        mapped.height(patch, corner, corner, 0.0, &mapped.pyramid.lookup(lod, patch))
                    }))
                })
            })
            .collect();
        let vertices: Vec<f32> =
            (0..mesh.positions.len() as u32).flat_map(|vertex| at_welds[mesh.weld_of(vertex) as usize]).collect();
        let mut edges = vec![0.0; topology.edges.len() * EDGE_STRIDE];
        edges.par_chunks_mut(EDGE_STRIDE).enumerate().for_each(|(edge, mut samples)| {
            if rims.contains(&topology.edges[edge]) {
                return;
            }
            let [from, to] = topology.edges[edge].map(|v| v as usize * EDGE_LEVELS);
            for level in 0..EDGE_LEVELS {
                let segments = 64usize >> level;
                let (along, rest) = samples.split_at_mut(segments + 1);
                samples = rest;
                let lines: Vec<_> = sides[edge]
                    .iter()
                    .map(|&(patch, side, flipped)| {
                        let (a, b) = (side, (side + 1) & 3);
                        let lookup = mapped.pyramid.lookup(level_lod(mapped.extent(patch, a, b), level), patch);
                        let (from, to) = if flipped { (b, a) } else { (a, b) };
                        (patch, from, to, lookup)
                    })
                    .collect();
                for (i, sample) in along.iter_mut().enumerate() {
                    let t = i as f32 / segments as f32;
                    *sample = mean(
                        lines.iter().map(|(patch, from, to, lookup)| mapped.height(*patch, *from, *to, t, lookup)),
                    );
                }
                along[0] = vertices[from + level];
                along[segments] = vertices[to + level];
            }
        });
        let texels = |&(patch, side, _): &(usize, usize, bool)| mapped.extent(patch, side, (side + 1) & 3).length();
        let edge_texels =
            sides.iter().map(|sides| sides.iter().map(texels).fold(1.0, f32::max) * terms.finer()).collect();
        let mut patch_range = patch_ranges(mesh, field);
        if mesh.triplanar.is_some() {
            let mean = mapped.mean();
            let wider = |height: f32| mean + MOST_BLENDED * (height - mean);
            patch_range.iter_mut().for_each(|range| *range = range.map(wider));
        }
        let patch_range = whole_ranges(patch_range, terms);
        let relief = |&(patch, _, _): &(usize, usize, bool)| patch_range[patch][1] - patch_range[patch][0];
        let on_edge = |(edge, sides): (&[u32; 2], &Vec<(usize, usize, bool)>)| {
            if rims.contains(edge) { 0.0 } else { sides.iter().map(relief).fold(0.0, f32::max) }
        };
        let edge_relief = topology.edges.iter().zip(&sides).map(on_edge).collect();
        Self { edges, vertices, patch_range, edge_texels, edge_relief }
    }
}

/// Returns the LOD at which map texels are as long as the segments of an edge. The edge has `64 >> level` segments. The LOD is
/// negative if they are longer at every level.
fn level_lod(extent: Vec2, level: usize) -> f32 {
    (extent.length() / (64 >> level) as f32).max(1e-6).log2()
}

fn mean(values: impl Iterator<Item = f32>) -> f32 {
    let (sum, count) = values.fold((0.0f64, 0u32), |(sum, count), v| (sum + f64::from(v), count + 1));
    if count == 0 { 0.0 } else { (sum / f64::from(count)) as f32 }
}

/// Returns bounds of the heights of patches with their scale and detail.
fn whole_ranges(mut ranges: Vec<[f32; 2]>, terms: &HeightTerms<'_>) -> Vec<[f32; 2]> {
    ranges.iter_mut().enumerate().for_each(|(patch, range)| *range = terms.range(patch, *range));
    ranges
}

/// Returns the largest height range of a patch.
fn relief_of(ranges: &[[f32; 2]], terms: &HeightTerms<'_>) -> f32 {
    let relief = |(patch, range): (usize, &[f32; 2])| {
        let [low, high] = terms.range(patch, *range);
        high - low
    };
    ranges.iter().enumerate().map(relief).fold(0.0, f32::max)
}

fn patch_ranges(mesh: &PatchMesh, field: &HeightField) -> Vec<[f32; 2]> {
    let range = |texels: &mut dyn Iterator<Item = f32>| {
        texels.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], h| [low.min(h), high.max(h)])
    };
    match field.border {
        Border::Tiles(layout) => (0..mesh.patches.len())
            .into_par_iter()
            .map(|patch| {
                let (start, tile, width) =
                    (layout.first_texel(patch, 0), layout.tile as usize, field.map.width as usize);
                range(&mut (0..tile).flat_map(|row| field.map.texels[start + row * width..][..tile].iter().copied()))
            })
            .collect(),
        _ => vec![range(&mut field.map.texels.iter().copied()); mesh.patches.len()],
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::Vec3;

    fn strip() -> PatchMesh {
        // The second of two adjacent patches exchanges u and v in its texture coordinates, which makes a seam.
        PatchMesh {
            positions: vec![
                Vec3::ZERO,
                Vec3::X,
                Vec3::new(1.0, 1.0, 0.0),
                Vec3::Y,
                Vec3::X * 2.0,
                Vec3::new(2.0, 1.0, 0.0),
            ],
            normals: vec![Vec3::Z; 6],
            patches: vec![[0, 1, 2, 3], [1, 4, 5, 2]],
            texcoords: vec![
                [Vec2::ZERO, Vec2::new(0.5, 0.0), Vec2::new(0.5, 0.5), Vec2::new(0.0, 0.5)],
                [Vec2::new(0.0, 0.5), Vec2::new(0.0, 1.0), Vec2::new(0.5, 1.0), Vec2::new(0.5, 0.5)],
            ],
            ..Default::default()
        }
    }

    #[test]
    fn shared_edges_take_the_mean_of_both_sides() {
        let mesh = strip();
        let topology = Topology::new(&mesh.patches);
        let texels = (0..32 * 32).map(|i| (i % 32) as f32).collect();
        let field = HeightField { map: HeightMap { width: 32, height: 32, texels }, border: Border::Clamp };
        let baked = BoundaryHeights::bake(&mesh, &topology, &field, &HeightTerms::new(&mesh, None, None, Vec2::ONE));
        let shared = topology.edges.iter().position(|&e| e == [1, 2]).unwrap();
        let middle = baked.edges[shared * EDGE_STRIDE + 32];
        // At the midpoint of the edge, the first patch reads column 15.5, and the second patch reads column 0.25 · 32 − 0.5.
        assert!((middle - (15.5 + 7.5) / 2.0).abs() < 1e-4, "{middle}");
        assert_eq!(baked.edges[shared * EDGE_STRIDE], baked.vertices[EDGE_LEVELS]);
        assert_eq!(baked.patch_range[0], [0.0, 31.0]);
        assert_eq!(baked.edge_texels[shared], 16.0);
    }

    #[test]
    fn samples_lie_between_four_texels() {
        let texels: Vec<f32> = (0..7 * 5).map(|i| ((i * 37) % 11) as f32).collect();
        for border in [Border::Wrap, Border::Clamp] {
            let field = HeightField { map: HeightMap { width: 7, height: 5, texels: texels.clone() }, border };
            for i in 0..4000 {
                let position = |ratio: f64| ((f64::from(i) * ratio).fract() * 7.0 - 3.5) as f32;
                let at = Vec2::new(position(0.754_877_666_2), position(0.569_840_290_9));
                let (x, y) = (at.x * 7.0 - 0.5, at.y * 5.0 - 0.5);
                let texel = |i: i64, j: i64| field.texel(x.floor() as i64 + i, y.floor() as i64 + j);
                let (fx, fy) = (x - x.floor(), y - y.floor());
                let along = |j: i64| texel(0, j) * (1.0 - fx) + texel(1, j) * fx;
                assert_eq!(field.bilinear(at), along(0) * (1.0 - fy) + along(1) * fy, "{border:?} {at}");
            }
        }
    }

    #[test]
    fn pyramid_keeps_the_mean_of_odd_sizes() {
        let texels: Vec<f32> = (0..7 * 5).map(|i| ((i * 37) % 11) as f32).collect();
        let mean = texels.iter().sum::<f32>() / 35.0;
        let field = HeightField::repeating(HeightMap { width: 7, height: 5, texels });
        let pyramid = HeightPyramid::new(&field);
        let last = pyramid.coarsest();
        assert_eq!((last.map.width, last.map.height), (1, 1));
        assert!((last.map.texels[0] - mean).abs() < 1e-5);
    }
}
