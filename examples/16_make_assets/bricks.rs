//! An old wall in Flemish bond, with stretchers, glazed headers, lime mortar, and moss in the joints. The material covers one square metre
//! and repeats.

use glam::{Vec2, Vec3};

use crate::noise::{cells, codes, fractal, hash, srgb, step};
use crate::png::{grey8, grey16, rgb8};

/// Texels per side.
const SIDE: usize = 768;
/// The number of rows of bricks per metre, and of stretcher-header pairs per row.
const ROWS: i32 = 14;
const PAIRS: i32 = 3;
/// Half the width of a joint in metres.
const JOINT: f32 = 0.0055;
/// The height difference between black and white, in metres.
const RELIEF: f32 = 0.02;

/// The properties of the surface at a point.
#[derive(Clone, Copy)]
struct Texel {
    height: f32,
    color: Vec3,
    roughness: f32,
}

/// A brick: the position of the point relative to the brick's centre, half the size of the brick, and its own number.
struct Brick {
    at: Vec2,
    half: Vec2,
    number: u32,
    header: bool,
}

fn brick(p: Vec2) -> Brick {
    let row = (p.y * ROWS as f32).floor();
    let pair = 1.0 / PAIRS as f32;
    let (stretcher, header) = (pair * 0.675, pair * 0.325);
    let shift = if row as i32 % 2 == 0 { 0.0 } else { 0.5 * (stretcher + header) };
    let x = p.x + shift;
    let index = (x / pair).floor();
    let inside = x - index * pair;
    let is_header = inside > stretcher;
    let (middle, width) = if is_header { (stretcher + 0.5 * header, header) } else { (0.5 * stretcher, stretcher) };
    let tall = 1.0 / ROWS as f32;
    let number = (row as i32).rem_euclid(ROWS) * 64 + (index as i32).rem_euclid(PAIRS) * 2 + i32::from(is_header);
    Brick {
        at: Vec2::new(inside - middle, p.y - (row + 0.5) * tall),
        half: 0.5 * Vec2::new(width, tall) - JOINT,
        number: number as u32,
        header: is_header,
    }
}

fn texel(p: Vec2) -> Texel {
    let wobble = |cells: i32, seed: u32| fractal(p * cells as f32, [cells; 2], 4, 0.55, seed) - 0.5;
    // The edges of the bricks are uneven.
    let bent = p + 0.006 * Vec2::new(wobble(24, 11), wobble(24, 12));
    let b = brick(bent);
    let own = |k: i32| hash(b.number as i32, k, 77);
    let corner = 0.006 + 0.006 * own(1);
    let outside = (b.at.abs() - b.half + corner).max(Vec2::ZERO).length() - corner;
    let inside_edge = (b.at.abs() - b.half).max_element();
    let edge = if outside > 0.0 { outside } else { inside_edge.max(-0.02) };
    let worn = edge + 0.006 * (wobble(40, 13) + 0.35 * wobble(96, 14));
    let on_brick = 1.0 - step(-0.0012, 0.0012, worn);

    // Bricks have a bulge, a tilt, drag marks of the wire, and pits of burnt-out lime.
    let tilt = Vec2::new(own(2) - 0.5, own(3) - 0.5).dot(b.at / b.half) * 0.0016;
    let rounded = -0.0026 * step(-0.013, 0.0, worn);
    let drag = fractal(Vec2::new(p.x * 20.0, p.y * 160.0), [20, 160], 3, 0.6, 21) - 0.5;
    let grain = wobble(128, 22);
    let (pit, pit_size) = cells(p * 56.0, [56; 2], 23);
    let glazed = b.header && own(4) < 0.62;
    let pitted = (1.0 - step(0.04, 0.10 + 0.16 * pit_size, pit)) * f32::from(pit_size > 0.72 && !glazed);
    let texture = if glazed { 0.0006 * wobble(14, 24) } else { 0.0009 * drag + 0.0012 * grain };
    let face = 0.0135 + 0.0028 * (own(5) - 0.5) + tilt + rounded + texture - 0.0024 * pitted + 0.0018 * wobble(9, 25);

    // The mortar is struck concave and sandy, with protruding grit.
    let (grit, grit_size) = cells(p * 150.0, [150; 2], 31);
    let sand =
        0.0013 * (fractal(p * 190.0, [190; 2], 2, 0.6, 32) - 0.5) + 0.0011 * (1.0 - step(0.1, 0.42, grit)) * grit_size;
    let hollow = 0.0048 + 0.0022 * wobble(18, 33) - 0.0016 * step(0.0, JOINT, worn);
    let joint = hollow + sand;
    let mut height = joint + (face - joint) * on_brick;

    // The kiln colours vary from brick to brick.
    let warm = [srgb(150, 74, 51), srgb(133, 60, 44), srgb(166, 92, 62), srgb(117, 56, 48), srgb(176, 110, 74)];
    let pick = own(6) * warm.len() as f32;
    let (first, second) = (warm[pick as usize % 5], warm[(pick as usize + 2) % 5]);
    let flame = step(0.35, 0.75, fractal(p * 12.0, [12; 2], 4, 0.5, 41 + b.number % 5));
    let mut clay = first.lerp(second, 0.55 * flame) * (0.82 + 0.36 * own(7));
    clay *= 1.0 + 0.5 * grain + 0.35 * drag;
    clay = clay.lerp(srgb(196, 150, 116), 0.45 * step(-0.006, 0.0, worn) * own(8));
    clay = clay.lerp(srgb(70, 40, 34), 0.6 * pitted);
    let glaze = srgb(38, 42, 50).lerp(srgb(66, 74, 84), step(0.3, 0.8, fractal(p * 20.0, [20; 2], 3, 0.5, 42)));
    let glaze_worn = step(0.62, 0.78, fractal(p * 30.0, [30; 2], 4, 0.6, 43)) * 0.8;
    let (mut brick_color, mut brick_rough) = (clay, 0.80 + 0.16 * grain);
    if glazed {
        brick_color = glaze.lerp(clay, glaze_worn);
        brick_rough = 0.34 + 0.46 * glaze_worn + 0.1 * grain;
    }
    let lime = srgb(186, 176, 158) * (0.80 + 0.5 * (fractal(p * 64.0, [64; 2], 4, 0.6, 44) - 0.5) + 0.20 * grit_size);
    let mut color = lime.lerp(brick_color, on_brick);
    let mut roughness = 0.93 + (brick_rough - 0.93) * on_brick;

    // Lime blooms on some bricks. Moss grows deep in the damp joints.
    let bloom = step(0.56, 0.80, fractal(p * 6.0, [6; 2], 5, 0.55, 51)) * (0.4 + 0.6 * step(-0.2, 0.3, grain));
    color = color.lerp(srgb(205, 196, 184), 0.42 * bloom * on_brick);
    roughness += (0.92 - roughness) * bloom * on_brick;
    let damp = step(0.50, 0.68, fractal(p * 5.0, [5; 2], 4, 0.55, 52));
    let low = 1.0 - step(0.0075, 0.0125, height);
    let tuft = fractal(p * 110.0, [110; 2], 3, 0.6, 53);
    let moss = damp * low * step(0.30, 0.50, tuft + 0.25 * damp);
    height += moss * (0.0012 + 0.0030 * (tuft - 0.3));
    color = color.lerp(srgb(74, 88, 38).lerp(srgb(128, 136, 62), step(0.4, 0.8, tuft)), 0.92 * moss);
    roughness += (0.97 - roughness) * moss;
    Texel { height, color, roughness: roughness.clamp(0.05, 1.0) }
}

/// Returns the approximate visibility of the sky, from the depth below the mean of the surroundings at three sizes.
fn occlusion(heights: &[f32]) -> Vec<f32> {
    let mut open = vec![1.0f32; heights.len()];
    for (radius, depth) in [(3usize, 0.0016), (8, 0.0035), (18, 0.0065)] {
        let blurred = blur(&blur(heights, radius), radius);
        for (open, (mean, height)) in open.iter_mut().zip(blurred.iter().zip(heights)) {
            *open *= 1.0 - 0.42 * step(0.0, depth, mean - height);
        }
    }
    open
}

/// Blurs a periodic map with a box.
fn blur(texels: &[f32], radius: usize) -> Vec<f32> {
    let rows = |source: &[f32]| -> Vec<f32> {
        let mut result = vec![0.0; source.len()];
        for y in 0..SIDE {
            for x in 0..SIDE {
                let row = (0..=2 * radius).map(|k| source[y * SIDE + (x + k + SIDE - radius) % SIDE]);
                result[x * SIDE + y] = row.sum::<f32>() / (2 * radius + 1) as f32;
            }
        }
        result
    };
    rows(&rows(texels))
}

/// Returns the texture files of the material.
pub fn files() -> Vec<(String, Vec<u8>)> {
    let texcoords = (0..SIDE * SIDE).map(|i| Vec2::new((i % SIDE) as f32 + 0.5, (i / SIDE) as f32 + 0.5) / SIDE as f32);
    let texels: Vec<Texel> = texcoords.map(texel).collect();
    let heights: Vec<f32> = texels.iter().map(|t| t.height).collect();
    let slope = |i: usize| {
        let (x, y) = (i % SIDE, i / SIDE);
        let at = |x: usize, y: usize| heights[y % SIDE * SIDE + x % SIDE];
        let per = SIDE as f32 / 2.0;
        Vec2::new(at(x + 1, y) - at(x + SIDE - 1, y), at(x, y + 1) - at(x, y + SIDE - 1)) * per
    };
    let open = occlusion(&heights);
    let normal = |i: usize| {
        // Green points up, while rows run down.
        let s = slope(i);
        let n = Vec3::new(-s.x, s.y, 1.0).normalize();
        n.to_array().map(|x| (255.0 * (0.5 + 0.5 * x) + 0.5) as u8)
    };
    let file = |what: &str, bytes: Vec<u8>| (format!("bricks/bricks_{what}.png"), bytes);
    let all = 0..SIDE * SIDE;
    vec![
        file("Displacement", grey16(SIDE, heights.iter().map(|h| h / RELIEF))),
        file("NormalGL", rgb8(SIDE, all.map(normal))),
        file("Color", rgb8(SIDE, texels.iter().map(|t| codes(t.color)))),
        file("Roughness", grey8(SIDE, texels.iter().map(|t| t.roughness))),
        file("AmbientOcclusion", grey8(SIDE, open.into_iter())),
    ]
}
