//! Places on an atlas with one tile per patch, as `shaders-glsl/passes/filter/atlas.glsl` finds them.

use glam::Vec2;

use crate::render::surfaces::patch_mesh::TileLayout;

/// The patch and place in it, `[0, 1]²`, that a place outside a patch lies on: across up to two borders.
fn place_beyond(neighbors: &[[Option<(u32, u8)>; 4]], mut patch: usize, mut at: Vec2) -> (usize, Vec2) {
    for _ in 0..2 {
        let beyond = (-at).max(at - Vec2::ONE);
        let over = beyond.max_element();
        if over <= 0.0 {
            break;
        }
        let side = match beyond.x > beyond.y {
            true => {
                if at.x < 0.0 {
                    3
                } else {
                    1
                }
            }
            false => {
                if at.y < 0.0 {
                    0
                } else {
                    2
                }
            }
        };
        let Some((other, beside)) = neighbors[patch][side] else { break };
        let along = if side % 2 == 0 { at.x } else { at.y };
        let along = if side < 2 { along } else { 1.0 - along };
        patch = other as usize;
        // The neighbour traverses the shared edge in the other direction.
        at = match beside {
            0 => Vec2::new(1.0 - along, over),
            1 => Vec2::new(1.0 - over, 1.0 - along),
            2 => Vec2::new(along, 1.0 - over),
            _ => Vec2::new(over, along),
        };
    }
    (patch, at.clamp(Vec2::ZERO, Vec2::ONE))
}

/// The texels of a tile at a level of the maps, `texels` with rows of `width`, and as many as `margin` around it, taken
/// from the patches beyond.
#[must_use]
pub fn around_tile(
    texels: &[f32],
    width: usize,
    level: u32,
    layout: TileLayout,
    neighbors: &[[Option<(u32, u8)>; 4]],
    patch: usize,
    margin: usize,
) -> Vec<f32> {
    let side = (layout.tile >> level) as usize;
    let (around, cell) = (side + 2 * margin, (1u32 << level) as f32);
    let (inner, gutter) = (layout.inner() as f32, layout.gutter as f32);
    let start = |patch: usize| {
        let (x, y) = layout.origin(patch as u32);
        (y >> level) as usize * width + (x >> level) as usize
    };
    let own = start(patch);
    let texel = |x: i64, y: i64| {
        let inside = 0..side as i64;
        if inside.contains(&x) && inside.contains(&y) {
            return texels[own + y as usize * width + x as usize];
        }
        let at = (Vec2::new(x as f32, y as f32) + 0.5) * cell - gutter;
        let (other, at) = place_beyond(neighbors, patch, at / inner);
        let at = ((at * inner + gutter) / cell - 0.5).clamp(Vec2::ZERO, Vec2::splat(side as f32 - 1.0));
        let whole = at.floor().min(Vec2::splat(side as f32 - 2.0)).max(Vec2::ZERO);
        let f = at - whole;
        let first = start(other) + whole.y as usize * width + whole.x as usize;
        let row = |k: usize| texels[k] * (1.0 - f.x) + texels[k + 1] * f.x;
        row(first) * (1.0 - f.y) + row(first + width) * f.y
    };
    let place = |k: usize| k as i64 - margin as i64;
    (0..around * around).map(|k| texel(place(k % around), place(k / around))).collect()
}
