//! The snail's skin, and the textures of its surfaces.

use glam::{Vec2, Vec3};

use crate::noise::{cells, codes, fractal, srgb, step};
use crate::png::rgb8;

/// The properties of a surface at texture coordinates.
#[derive(Clone, Copy)]
pub struct Surface {
    /// The height in twentieths of the texture's width.
    pub height: f32,
    /// The linear colour.
    pub color: Vec3,
    /// The perceptual roughness.
    pub roughness: f32,
}

/// Returns damp skin: pebbles in rows, which are smaller towards the foot and have grooves between them.
pub fn surface(p: Vec2) -> Surface {
    let wide = |n: i32, octaves, seed| fractal(p * n as f32, [n; 2], octaves, 0.55, seed);
    let bent = p + 0.012 * Vec2::new(wide(10, 3, 221) - 0.5, wide(10, 3, 222) - 0.5);
    let (distance, own) = cells(bent * Vec2::new(30.0, 22.0), [30, 22], 223);
    let pebble = 1.0 - step(0.05, 0.62, distance);
    let (small, _) = cells(bent * 64.0, [64; 2], 224);
    let height = 0.26 * pebble + 0.05 * (1.0 - step(0.0, 0.6, small));
    // The pebbles are pale and the grooves dark. The back is darker than the flanks.
    let back = step(0.55, 1.0, 1.0 - (2.0 * (p.y - 0.25).abs()).min(1.0));
    let pale = srgb(176, 156, 124).lerp(srgb(140, 118, 92), own);
    let dark = srgb(84, 70, 56);
    let mut color = dark.lerp(pale, 0.25 + 0.75 * pebble);
    color = color.lerp(srgb(74, 62, 52), 0.5 * back * (0.5 + wide(8, 4, 225)));
    Surface { height, color, roughness: 0.38 + 0.22 * (1.0 - pebble) + 0.1 * (wide(20, 3, 226) - 0.5) }
}

/// Returns the textures of a surface: the base colour, the normals, and the roughness in green with zero metalness in blue.
pub fn pictures(side: usize, surface: impl Fn(Vec2) -> Surface) -> [Vec<u8>; 3] {
    let texcoord = |i: usize| Vec2::new((i % side) as f32 + 0.5, (i / side) as f32 + 0.5) / side as f32;
    let texels: Vec<Surface> = (0..side * side).map(|i| surface(texcoord(i))).collect();
    let normal = |i: usize| {
        let (x, y) = (i % side, i / side);
        let at = |x: usize, y: usize| texels[y % side * side + x % side].height * 0.05;
        let per = side as f32 / 2.0;
        let s = Vec2::new(at(x + 1, y) - at(x + side - 1, y), at(x, y + 1) - at(x, y + side - 1)) * per;
        // Green points up, while rows run down.
        Vec3::new(-s.x, s.y, 1.0).normalize().to_array().map(|n| (255.0 * (0.5 + 0.5 * n) + 0.5) as u8)
    };
    let rough = |t: &Surface| [255, (255.0 * t.roughness.clamp(0.05, 1.0) + 0.5) as u8, 0];
    [
        rgb8(side, texels.iter().map(|t| codes(t.color))),
        rgb8(side, (0..side * side).map(normal)),
        rgb8(side, texels.iter().map(rough)),
    ]
}
