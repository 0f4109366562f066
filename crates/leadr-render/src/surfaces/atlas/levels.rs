//! Levels of detail that are coarser than the mips of the tiles.
//!
//! In mip [`SOURCE_LEVEL`] of a tile, texels are centred on the border of the patch. The coarse levels continue from this mip, and
//! have samples on a grid over the patch and its border. The grid has `2ᵏ` intervals along each side, for `k = finest … 0`. Each
//! sample is the mean over a square around it that is one interval wide, on all patches that the square touches. The remaining
//! levels only have samples at the four corners, which are means over ever larger neighbourhoods. The weights of such a mean have
//! the variance of a square of 2, 4, 8 … patches per side. At every level, bilinear interpolation in two patches therefore agrees
//! along their shared edge.

use glam::Vec2;
use rayon::prelude::*;

use super::frames::{AtlasFrames, Carried, Linear};
use crate::constants::{SOURCE_LEVEL, WIDE_LEVELS};
use crate::surfaces::patch_mesh::{PatchMesh, TileLayout};

/// The smallest accessibility that the weight of a patch uses.
const LEAST_ACCESSIBILITY: f32 = 0.01;

/// The layout of the coarse levels in their image. Each patch has one block. Blocks are arranged like tiles, and the levels of a
/// block are stacked vertically.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct CoarseShape {
    /// The layout of the tiles.
    pub layout: TileLayout,
    /// The base-2 logarithm of the number of intervals along a patch, in the first coarse level.
    pub finest: u32,
}

impl CoarseShape {
    /// Returns the shape for tiles with this layout.
    pub fn new(layout: TileLayout) -> Self {
        Self { layout, finest: (layout.tile / 8).max(1).ilog2() }
    }

    /// Returns the number of coarse levels.
    pub fn levels(&self) -> u32 {
        self.finest + 1 + WIDE_LEVELS
    }

    /// Returns the number of intervals along a patch at a coarse level.
    pub fn intervals(&self, level: u32) -> u32 {
        1 << self.finest.saturating_sub(level)
    }

    /// Returns the width and height of the block of a patch, in texels.
    pub fn block(&self) -> [u32; 2] {
        [self.intervals(0) + 1, self.row(self.levels())]
    }

    /// Returns the row of a block at which a level starts.
    pub fn row(&self, level: u32) -> u32 {
        (0..level).map(|level| self.intervals(level) + 1).sum()
    }

    /// Returns the width and height of the image in texels.
    pub fn size(&self) -> [u32; 2] {
        let [w, h] = self.block();
        [w * self.layout.columns, h * self.layout.rows]
    }
}

/// The patches that meet at each vertex and each edge, with the weight of each patch.
pub struct Star {
    /// The patches at each vertex, each with the index of its corner there.
    corners: Vec<Vec<(u32, u8)>>,
    /// The weights of the patches in the means.
    weights: Vec<f32>,
    /// The weights of the vertices, which are sums of the weights of their patches.
    vertex_weights: Vec<f32>,
    /// The vertex indices of the patches.
    patches: Vec<[u32; 4]>,
    /// The patch across each side of each patch, with the side at which it meets this patch.
    pub neighbors: Vec<[Option<(u32, u8)>; 4]>,
}

impl Star {
    /// Collects which patches of a mesh meet. `neighbors` comes from
    /// [`Topology::neighbors`](crate::surfaces::topology::Topology::neighbors).
    ///
    /// The weight of a patch is its area at rest, times a measure of its visibility, which prevents the inside of a mouth from
    /// darkening the lips. Accessibility, the fraction of unblocked directions above a patch, would be correct on average over all
    /// viewers. But a viewer who faces the lips sees less of the mouth than the average viewer. The weight uses the fourth power of
    /// accessibility, which gives the smallest measured error for the distant T-rex.
    pub fn new(mesh: &PatchMesh, neighbors: Vec<[Option<(u32, u8)>; 4]>) -> Self {
        let weight = |patch: &[u32; 4]| {
            let p = patch.map(|v| mesh.positions[v as usize]);
            let area = 0.5 * (p[2] - p[0]).cross(p[3] - p[1]).length();
            let open = |&v: &u32| mesh.accessibility_of(v as usize).max(LEAST_ACCESSIBILITY);
            (area * (patch.iter().map(open).sum::<f32>() / 4.0).powi(4)).max(1e-20)
        };
        let weights: Vec<f32> = mesh.patches.iter().map(weight).collect();
        let mut vertex_weights = vec![0.0; mesh.positions.len()];
        let mut corners = vec![Vec::with_capacity(4); mesh.positions.len()];
        for (patch, vertices) in mesh.patches.iter().enumerate() {
            for (corner, &vertex) in vertices.iter().enumerate() {
                vertex_weights[vertex as usize] += weights[patch];
                corners[vertex as usize].push((patch as u32, corner as u8));
            }
        }
        Self { corners, weights, vertex_weights, patches: mesh.patches.clone(), neighbors }
    }

    /// Averages the corner values of the patches around each vertex.
    fn about_vertices<T: Carried>(
        &self,
        frames: &AtlasFrames,
        value: impl Fn(usize, usize) -> T + Sync,
    ) -> Vec<T::Common> {
        self.corners
            .par_iter()
            .zip(&self.vertex_weights)
            .map(|(corners, all)| {
                let mut sum = T::Common::default();
                for &(patch, corner) in corners {
                    let (patch, corner) = (patch as usize, usize::from(corner));
                    let lifted = value(patch, corner).lift(&frames.corner(patch, corner));
                    sum.add(&lifted, self.weights[patch] / all);
                }
                sum
            })
            .collect()
    }
}

/// Computes the texels of the image with all coarse levels. `source` is mip [`SOURCE_LEVEL`] of the atlas.
pub fn coarse_levels<T: Carried>(star: &Star, frames: &AtlasFrames, shape: CoarseShape, source: &[T]) -> Vec<T> {
    let [width, height] = shape.size();
    let [block_width, block_height] = shape.block();
    let mut image = vec![T::default(); width as usize * height as usize];
    let mut write = |patch: usize, level: u32, a: u32, b: u32, value: T| {
        let (column, row) = (patch as u32 % shape.layout.columns, patch as u32 / shape.layout.columns);
        let (x, y) = (column * block_width + a, row * block_height + shape.row(level) + b);
        image[y as usize * width as usize + x as usize] = value;
    };
    let mut vertices = Vec::new();
    for level in 0..=shape.finest {
        let intervals = shape.intervals(level);
        let nodes = intervals + 1;
        let own = own_means(shape, intervals, source, star.patches.len());
        let own_at = |patch: usize, a: u32, b: u32| own[patch * (nodes * nodes) as usize + (b * nodes + a) as usize];
        vertices = star.about_vertices(frames, |patch, corner| {
            let (a, b) = on_side(corner, 0, intervals);
            own_at(patch, a, b)
        });
        let shared: Vec<Vec<T>> = (0..star.patches.len())
            .into_par_iter()
            .map(|patch| {
                let node = |k: u32| {
                    let (a, b) = (k % nodes, k / nodes);
                    let own = own_at(patch, a, b);
                    let Some((side, along)) = side_of(a, b, intervals) else { return own };
                    if along % intervals == 0 {
                        let corner = (side + (along / intervals) as usize) & 3;
                        return T::land(&vertices[star.patches[patch][corner] as usize], &frames.corner(patch, corner));
                    }
                    let Some((other, beside)) = star.neighbors[patch][side] else { return own };
                    let (c, d) = on_side(usize::from(beside), intervals - along, intervals);
                    let uv = |a: u32, b: u32| Vec2::new(a as f32, b as f32) / intervals as f32;
                    let (here, there) = (frames.at(patch, uv(a, b)), frames.at(other as usize, uv(c, d)));
                    let other = other as usize;
                    let weights = [star.weights[patch], star.weights[other]];
                    let mut sum = T::Common::default();
                    sum.add(&own.lift(&here), weights[0] / (weights[0] + weights[1]));
                    sum.add(&own_at(other, c, d).lift(&there), weights[1] / (weights[0] + weights[1]));
                    T::land(&sum, &here)
                };
                (0..nodes * nodes).map(node).collect()
            })
            .collect();
        for (patch, values) in shared.iter().enumerate() {
            for (k, &value) in values.iter().enumerate() {
                write(patch, level, k as u32 % nodes, k as u32 / nodes, value);
            }
        }
    }
    for wide in 0..WIDE_LEVELS {
        vertices = widened::<T>(star, frames, vertices, wide);
        for (patch, corners) in star.patches.iter().enumerate() {
            for (corner, &vertex) in corners.iter().enumerate() {
                let value = T::land(&vertices[vertex as usize], &frames.corner(patch, corner));
                let (a, b) = on_side(corner, 0, 1);
                write(patch, shape.finest + 1 + wide, a, b, value);
            }
        }
    }
    image
}

/// Widens means over squares of `2ʷⁱᵈᵉ` patches per side to squares that are twice as wide. Each step averages the corner means of
/// the patches, which increases the variance of the weights by half a squared patch width. Doubling the width of a square increases
/// its variance by `4ʷⁱᵈᵉ / 4`.
fn widened<T: Carried>(
    star: &Star,
    frames: &AtlasFrames,
    mut vertices: Vec<<T as Carried>::Common>,
    wide: u32,
) -> Vec<T::Common> {
    let steps = 0.5 * 4.0f32.powi(wide as i32);
    for step in 0..steps.ceil() as u32 {
        let part = (steps - step as f32).min(1.0);
        let patches: Vec<T> = star
            .patches
            .par_iter()
            .enumerate()
            .map(|(patch, corners)| {
                let all: f32 = corners.iter().map(|&vertex| star.vertex_weights[vertex as usize]).sum();
                let mut sum = T::default();
                for (corner, &vertex) in corners.iter().enumerate() {
                    let landed = T::land(&vertices[vertex as usize], &frames.corner(patch, corner));
                    sum.add(&landed, star.vertex_weights[vertex as usize] / all);
                }
                sum
            })
            .collect();
        let means = star.about_vertices(frames, |patch, _| patches[patch]);
        for (vertex, mean) in vertices.iter_mut().zip(&means) {
            let mut mixed = T::Common::default();
            mixed.add(vertex, 1.0 - part);
            mixed.add(mean, part);
            *vertex = mixed;
        }
    }
    vertices
}

/// Computes a mean for each sample, patch by patch, over the part of the sample's square that lies on its own patch.
fn own_means<T: Linear>(shape: CoarseShape, intervals: u32, source: &[T], patches: usize) -> Vec<T> {
    let TileLayout { tile, gutter, columns, .. } = shape.layout;
    let cells = tile >> SOURCE_LEVEL;
    let row_length = (columns * cells) as usize;
    let (inner, spacing) = (shape.layout.inner() as f32, shape.layout.inner() as f32 / intervals as f32);
    // These are the weights of the cells that overlap the square of each sample, along one axis.
    let weights: Vec<Vec<(usize, f32)>> = (0..=intervals)
        .map(|node| {
            let position = node as f32 * spacing;
            let (low, high) = ((position - 0.5 * spacing).max(0.0), (position + 0.5 * spacing).min(inner));
            let overlap = |cell: u32| {
                let start = (cell << SOURCE_LEVEL) as f32 - gutter as f32;
                (high.min(start + (1 << SOURCE_LEVEL) as f32) - low.max(start)).max(0.0) / (high - low)
            };
            (0..cells).map(|cell| (cell as usize, overlap(cell))).filter(|&(_, weight)| weight > 0.0).collect()
        })
        .collect();
    (0..patches)
        .into_par_iter()
        .flat_map_iter(|patch| {
            let start = shape.layout.first_texel(patch, SOURCE_LEVEL);
            let weights = &weights;
            weights.iter().flat_map(move |down| {
                weights.iter().map(move |across| {
                    let mut sum = T::default();
                    for &(y, wy) in down {
                        for &(x, wx) in across {
                            sum.add(&source[start + y * row_length + x], wx * wy);
                        }
                    }
                    sum
                })
            })
        })
        .collect()
}

/// Returns the side on which a border sample lies, and its position along the side from the first corner.
fn side_of(a: u32, b: u32, intervals: u32) -> Option<(usize, u32)> {
    (0..4).find_map(|side| {
        let along = [a, b, intervals - a, intervals - b][side];
        (on_side(side, along, intervals) == (a, b)).then_some((side, along))
    })
}

/// Returns the sample at this position along a side. The order of the sides is v=0, u=1, v=1, u=0.
fn on_side(side: usize, along: u32, intervals: u32) -> (u32, u32) {
    let back = intervals - along;
    [(along, 0), (intervals, along), (back, intervals), (0, back)][side]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::surfaces::topology::Topology;
    use glam::Vec3;

    /// Returns a cube that is inflated roughly to a sphere. Three patches meet at every vertex, and each has its own coordinate
    /// directions.
    fn cube() -> PatchMesh {
        let positions: Vec<Vec3> =
            (0..8).map(|k| Vec3::from([k & 1, k >> 1 & 1, k >> 2].map(|b| (2 * b - 1) as f32)).normalize()).collect();
        PatchMesh {
            normals: positions.clone(),
            accessibility: vec![1.0; 8],
            patches: vec![[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]],
            positions,
            ..Default::default()
        }
    }

    fn star_of(mesh: &PatchMesh) -> Star {
        Star::new(mesh, Topology::new(&mesh.patches).neighbors())
    }

    /// Returns the value at a position, interpolated in a coarse level.
    fn texel<T: Copy>(image: &[T], shape: CoarseShape, patch: usize, level: u32, [a, b]: [u32; 2]) -> T {
        let [width, _] = shape.size();
        let [block_width, block_height] = shape.block();
        let (column, row) = (patch as u32 % shape.layout.columns, patch as u32 / shape.layout.columns);
        let y = row * block_height + shape.row(level) + b;
        image[(y * width + column * block_width + a) as usize]
    }

    fn source_texels(layout: TileLayout) -> usize {
        let (width, height) = layout.size();
        (width as usize >> SOURCE_LEVEL) * (height as usize >> SOURCE_LEVEL)
    }

    /// Returns a pseudorandom number from 0 to 1.
    fn random(k: usize) -> f32 {
        ((k as u32).wrapping_mul(2_654_435_761) >> 8) as f32 / (1 << 24) as f32
    }

    #[test]
    fn patches_agree_on_their_borders_at_every_level() {
        let mesh = cube();
        let layout = TileLayout::new(mesh.patches.len() as u32, 32);
        let (star, frames, shape) = (star_of(&mesh), AtlasFrames::new(&mesh, layout), CoarseShape::new(layout));
        let source: Vec<[f32; 5]> = (0..source_texels(layout))
            .map(|k| {
                let [s, t] = [0, 1].map(|i| random(2 * k + i) - 0.5);
                [s, t, s * s, t * t, s * t]
            })
            .collect();
        let image = coarse_levels(&star, &frames, shape, &source);
        let close = |a: f32, b: f32| (a - b).abs() <= 1e-4 * (a.abs() + b.abs()).max(1e-3);
        let mut compared = 0;
        for patch in 0..mesh.patches.len() {
            for side in 0..4 {
                let (other, beside) = star.neighbors[patch][side].unwrap();
                let (other, beside) = (other as usize, usize::from(beside));
                for level in 0..shape.levels() {
                    let intervals = shape.intervals(level);
                    for along in 0..=intervals {
                        let value = |patch: usize, side: usize, along: u32| {
                            let (a, b) = on_side(side, along, intervals);
                            let uv = Vec2::new(a as f32, b as f32) / intervals as f32;
                            let value = texel(&image, shape, patch, level, [a, b]);
                            // Both patches measure the slope along the edge that they share, so the two values must agree.
                            let axis = side & 1;
                            let scale = frames.at(patch, uv).tangents[axis].length();
                            let sign = if side < 2 { 1.0 } else { -1.0 };
                            (value, sign * value[axis] / scale, value[2 + axis] / (scale * scale))
                        };
                        let (here, slope, square) = value(patch, side, along);
                        let (there, back, square_there) = value(other, beside, intervals - along);
                        assert!(close(slope, -back), "{patch} {side} {level} {along}: {slope} {back}");
                        assert!(close(square, square_there), "{patch} {side} {level} {along}: {square} {square_there}");
                        if along == 0 {
                            // At a corner, the gradients of both patches lie in one plane.
                            let here = here.lift(&frames.corner(patch, side));
                            let there = there.lift(&frames.corner(other, (beside + 1) & 3));
                            assert!(here.iter().zip(&there).all(|(&a, &b)| close(a, b)), "{here:?} {there:?}");
                        }
                        compared += 1;
                    }
                }
            }
        }
        assert_eq!(compared, 6 * 4 * (5 + 3 + 2 + 2 * WIDE_LEVELS as usize));
    }

    /// Returns a flat grid of `n × n` patches that are each one metre wide.
    fn grid(n: u32) -> PatchMesh {
        let at = |x: u32, y: u32| y * (n + 1) + x;
        PatchMesh {
            positions: (0..(n + 1) * (n + 1))
                .map(|k| Vec3::new((k % (n + 1)) as f32, (k / (n + 1)) as f32, 0.0))
                .collect(),
            normals: vec![Vec3::Z; ((n + 1) * (n + 1)) as usize],
            accessibility: vec![1.0; ((n + 1) * (n + 1)) as usize],
            patches: (0..n * n)
                .map(|k| (k % n, k / n))
                .map(|(x, y)| [at(x, y), at(x + 1, y), at(x + 1, y + 1), at(x, y + 1)])
                .collect(),
            ..Default::default()
        }
    }

    #[test]
    fn every_level_is_a_mean_over_twice_the_width() {
        let n = 33u32;
        let mesh = grid(n);
        let layout = TileLayout::new(n * n, 8);
        let (star, frames, shape) = (star_of(&mesh), AtlasFrames::new(&mesh, layout), CoarseShape::new(layout));
        // Only the central patch has texels of 1.
        let middle = n * n / 2;
        let mut source = vec![[0.0f32; 4]; source_texels(layout)];
        let row = (layout.columns * layout.tile) >> SOURCE_LEVEL;
        let cells = layout.tile >> SOURCE_LEVEL;
        for k in 0..cells * cells {
            let y = middle / layout.columns * cells + k / cells;
            source[(y * row + middle % layout.columns * cells + k % cells) as usize] = [1.0; 4];
        }
        let image = coarse_levels(&star, &frames, shape, &source);
        for wide in 0..=WIDE_LEVELS {
            let (mut sum, mut square) = (0.0f64, 0.0);
            for y in 0..n {
                for x in 0..n {
                    // Each vertex is counted once, as the first corner of a patch.
                    let value = f64::from(texel(&image, shape, (y * n + x) as usize, shape.finest + wide, [0, 0])[0]);
                    let from_middle = f64::from(x) - 0.5 * f64::from(n);
                    sum += value;
                    square += value * from_middle * from_middle;
                }
            }
            assert!((sum - 1.0).abs() < 1e-5, "{wide}: nothing is lost, {sum}");
            // The four corners of the patch have a variance of 1/4. The area of the patch has a variance of 1/12.
            let expected = 0.25 + (4.0f64.powi(wide as i32) - 1.0) / 12.0;
            assert!((square / sum - expected).abs() < 1e-3, "{wide}: {} {expected}", square / sum);
        }
    }

    #[test]
    fn occluded_texels_weigh_little() {
        let mut mesh = grid(2);
        for &vertex in &mesh.patches[3] {
            mesh.accessibility[vertex as usize] = 0.2;
        }
        let layout = TileLayout::new(4, 16);
        let (frames, shape) = (AtlasFrames::new(&mesh, layout), CoarseShape::new(layout));
        let row = ((layout.columns * layout.tile) >> SOURCE_LEVEL) as usize;
        let cells = (layout.tile >> SOURCE_LEVEL) as usize;
        let source: Vec<[f32; 4]> =
            (0..source_texels(layout)).map(|k| if k % row / cells == 3 { [1.0; 4] } else { [0.0; 4] }).collect();
        let image = coarse_levels(&star_of(&mesh), &frames, shape, &source);
        // The vertex lies between four patches. One patch has texels of 1 and an accessibility of 0.2. Two patches have a mean
        // accessibility of 0.6, and one has 0.8.
        let value = texel(&image, shape, 0, 0, [shape.intervals(0), shape.intervals(0)])[0];
        let [dark, beside, open] = [0.2f32, 0.6, 0.8].map(|a| a.powi(4));
        assert!((value - dark / (dark + 2.0 * beside + open)).abs() < 1e-5, "{value}");
    }

    #[test]
    fn blocks_hold_their_levels() {
        for tile in [8, 16, 32, 64] {
            let shape = CoarseShape::new(TileLayout::new(7, tile));
            // The levels are numbered as in passes/filter/atlas.glsl.
            let finest = shape.finest;
            assert_eq!(shape.block(), [(1 << finest) + 1, (2 << finest) + finest + 2 * WIDE_LEVELS]);
            for level in 0..shape.levels() {
                let intervals = 1u32 << (finest - level.min(finest));
                assert_eq!(shape.intervals(level), intervals);
                assert_eq!(shape.row(level), (2 << finest) - 2 * intervals + level + level.saturating_sub(finest));
            }
        }
    }
}
