//! Whether a model has a floor of its own, such as a room or a landscape.

use glam::{Vec2, Vec3, Vec3Swizzles};

use super::parts::{Parts, to_z_up};
use leadr_models::{Model, Pose};

/// The number of cells along each side of the model's bounds, seen from above.
const CELLS: usize = 32;
/// The smallest share of the cells that a floor covers.
const COVERED: f32 = 0.6;
/// The height of a floor above the lowest point, as a share of the model's height.
const THICKNESS: f32 = 0.1;
/// The smallest vertical component of the normal of a floor, which allows slopes of 45°.
const UPWARD: f32 = 0.7;
/// The smallest horizontal size of a floor, as a share of the height of the model.
const WIDTH: f32 = 0.5;

/// Whether upward triangles at the bottom of the model cover most of its bounds, seen from above. A model that is narrower than half its
/// height stands on a base rather than on a floor.
pub fn has_floor(model: &Model, parts: &Parts, pose: &Pose) -> bool {
    let (a, b) = parts.bounds(model, pose);
    let (a, b) = (to_z_up(a), to_z_up(b));
    let (low, high) = (a.min(b), a.max(b));
    let size = (high - low).max(Vec3::splat(1e-20));
    if size.xy().max_element() < WIDTH * size.z {
        return false;
    }
    let mut covered = vec![false; CELLS * CELLS];
    for part in parts.objects.iter().flat_map(|object| &object.parts) {
        let positions = model.posed_vertices(pose, part.node, part.primitive).positions;
        for &triangle in &part.shown_in(model).triangles {
            let [a, b, c] = triangle.map(|vertex| (to_z_up(Vec3::from(positions[vertex as usize])) - low) / size);
            if a.z.max(b.z).max(c.z) > THICKNESS {
                continue;
            }
            let normal = ((b - a) * size).cross((c - a) * size).normalize_or_zero();
            let upward = if part.mirrored { -normal.z } else { normal.z };
            let faces = if model.materials[part.shown_in(model).material].double_sided { upward.abs() } else { upward };
            if faces >= UPWARD {
                cover(&mut covered, [a, b, c].map(|corner| corner.xy() * CELLS as f32));
            }
        }
    }
    covered.iter().filter(|&&cell| cell).count() as f32 >= COVERED * covered.len() as f32
}

/// Marks the cells whose centres are within a triangle.
fn cover(cells: &mut [bool], [a, b, c]: [Vec2; 3]) {
    let whole = |v: f32| (v.max(0.0) as usize).min(CELLS);
    let (low, high) = (a.min(b).min(c), a.max(b).max(c));
    for y in whole(low.y)..whole(high.y.ceil()) {
        for x in whole(low.x)..whole(high.x.ceil()) {
            let centre = Vec2::new(x as f32 + 0.5, y as f32 + 0.5);
            let side = |p: Vec2, q: Vec2| (q - p).perp_dot(centre - p);
            let sides = [side(a, b), side(b, c), side(c, a)];
            cells[y * CELLS + x] |= sides.iter().all(|s| *s >= 0.0) || sides.iter().all(|s| *s <= 0.0);
        }
    }
}
