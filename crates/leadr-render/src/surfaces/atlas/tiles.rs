//! Positions in an atlas with one tile per patch. `shaders-glsl/passes/filter/atlas.glsl` follows the same rules.

use glam::Vec2;

use crate::surfaces::patch_mesh::{PatchMesh, TileLayout};
use crate::surfaces::topology::Topology;

/// The tiles and the adjacent patches of a mesh at rest.
pub struct Tiles {
    layout: TileLayout,
    /// The patch across each side of each patch, with the side at which it meets this patch.
    neighbors: Vec<[Option<(u32, u8)>; 4]>,
    /// The mean width and the mean height of each patch, in metres.
    extents: Vec<Vec2>,
}

impl Tiles {
    /// Collects the tiles of a mesh that has these edges.
    pub fn new(mesh: &PatchMesh, topology: &Topology, layout: TileLayout) -> Self {
        let extent = |patch: &[u32; 4]| {
            let p = patch.map(|v| mesh.positions[v as usize]);
            let mean = |a: [usize; 2], b: [usize; 2]| 0.5 * (p[a[0]].distance(p[a[1]]) + p[b[0]].distance(p[b[1]]));
            Vec2::new(mean([0, 1], [3, 2]), mean([0, 3], [1, 2])).max(Vec2::splat(1e-9))
        };
        Self { layout, neighbors: topology.neighbors(), extents: mesh.patches.iter().map(extent).collect() }
    }

    /// Returns the number of patches.
    pub fn patches(&self) -> usize {
        self.neighbors.len()
    }

    /// Returns the layout of the atlas.
    pub fn layout(&self) -> TileLayout {
        self.layout
    }

    /// Converts a position outside a patch to a position in `[0, 1]²` on the patch that contains it, and returns both. Crosses up
    /// to two borders. Distances are kept in metres, because patches may differ in size.
    fn point_across_borders(&self, mut patch: usize, mut at: Vec2) -> (usize, Vec2) {
        for _ in 0..2 {
            let beyond = (-at).max(at - Vec2::ONE);
            let over = beyond.max_element();
            if over <= 0.0 {
                break;
            }
            let side = match (beyond.x > beyond.y, at.x < 0.0, at.y < 0.0) {
                (true, true, _) => 3,
                (true, false, _) => 1,
                (false, _, true) => 0,
                (false, _, false) => 2,
            };
            let Some((other, beside)) = self.neighbors[patch][side] else { break };
            let along = if side % 2 == 0 { at.x } else { at.y };
            let along = if side < 2 { along } else { 1.0 - along };
            let across = |patch: usize, side: usize| self.extents[patch][1 - side % 2];
            let over = over * across(patch, side) / across(other as usize, usize::from(beside));
            patch = other as usize;
            // The neighbour runs along the shared edge in the other direction.
            at = match beside {
                0 => Vec2::new(1.0 - along, over),
                1 => Vec2::new(1.0 - over, 1.0 - along),
                2 => Vec2::new(along, 1.0 - over),
                _ => Vec2::new(over, along),
            };
        }
        (patch, at.clamp(Vec2::ZERO, Vec2::ONE))
    }

    /// Returns the texels of a tile at a level of the maps, with a margin of `margin` texels on each side. Rows of `texels` have
    /// `width` entries. Texels beyond the borders of the patch come from the adjacent patches.
    pub fn around(&self, texels: &[f32], width: usize, level: u32, patch: usize, margin: usize) -> Vec<f32> {
        let layout = self.layout;
        let side = (layout.tile >> level) as usize;
        let (around, cell) = (side + 2 * margin, (1u32 << level) as f32);
        let (inner, gutter) = (layout.inner() as f32, layout.gutter as f32);
        let own = layout.first_texel(patch, level);
        let texel = |x: i64, y: i64| {
            let at = (Vec2::new(x as f32, y as f32) + 0.5) * cell - gutter;
            // The gutter only extrapolates its patch, so these texels come from the adjacent patch.
            if at.min_element() >= 0.0 && at.max_element() <= inner {
                return texels[own + y as usize * width + x as usize];
            }
            let (other, at) = self.point_across_borders(patch, at / inner);
            let at = ((at * inner + gutter) / cell - 0.5).clamp(Vec2::ZERO, Vec2::splat(side as f32 - 1.0));
            let whole = at.floor().min(Vec2::splat(side as f32 - 2.0)).max(Vec2::ZERO);
            let f = at - whole;
            let first = layout.first_texel(other, level) + whole.y as usize * width + whole.x as usize;
            let row = |k: usize| texels[k] * (1.0 - f.x) + texels[k + 1] * f.x;
            row(first) * (1.0 - f.y) + row(first + width) * f.y
        };
        let coordinate = |k: usize| k as i64 - margin as i64;
        (0..around * around).map(|k| texel(coordinate(k % around), coordinate(k / around))).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns two adjacent patches, of which the second is three times as wide as the first. Heights are linear over both patches,
    /// and the gutters of the first patch are wrong.
    #[test]
    fn heights_go_on_beyond_a_border() {
        let layout = TileLayout::new(2, 16);
        let (width, rows) = layout.size();
        let (tile, inner) = (layout.tile, layout.inner() as f32);
        let height = |across: f32, v: f32| 3.0 * across + v;
        let texels: Vec<f32> = (0..width * rows)
            .map(|k| {
                let (x, y) = (k % width, k / width);
                let uv = [x % tile, y].map(|k| (k as f32 - 1.5) / inner);
                let outside = uv.iter().any(|&k| !(0.0..=1.0).contains(&k));
                match x / tile {
                    0 if outside => 1e9,
                    0 => height(uv[0], uv[1]),
                    _ => height(1.0 + 3.0 * uv[0], uv[1]),
                }
            })
            .collect();
        let neighbors = vec![[None, Some((1, 3)), None, None], [None, None, None, Some((0, 1))]];
        let tiles = Tiles { layout, neighbors, extents: vec![Vec2::ONE, Vec2::new(3.0, 1.0)] };
        let margin = 4;
        let around = tiles.around(&texels, width as usize, 0, 0, margin);
        let side = tile as usize + 2 * margin;
        for y in margin + 2..side - margin - 2 {
            for x in margin + 2..side {
                let [u, v] = [x, y].map(|k| (k as f32 - margin as f32 - 1.5) / inner);
                let (found, want) = (around[y * side + x], height(u, v));
                assert!((found - want).abs() < 1e-4, "{found} at {u}, {v} instead of {want}");
            }
        }
    }
}
