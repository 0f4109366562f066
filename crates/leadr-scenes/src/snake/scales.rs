//! The snake's skin: overlapping keeled scales on the back and the sides, wide belly plates, and the colours of both.

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use super::body::to_snout;
use leadr_maps::noise::{fractal, hash, smoothstep, unit};

/// The number of scales around the body.
pub const AROUND: f32 = 30.0;
/// The ratio of the length of a scale to its width.
const LENGTH: f32 = 1.25;

/// The skin at a point of the body.
#[derive(Clone, Copy, Debug)]
pub struct Skin {
    /// The height above the smooth body, in units of the local width of a scale.
    pub height: f32,
    /// The linear albedo.
    pub color: Vec3,
    /// Beckmann roughness.
    pub roughness: f32,
}

/// The scale at a point.
#[derive(Clone, Copy)]
struct Scale {
    height: f32,
    /// A value from 0 at the edge of the scale to 1 inside.
    inside: f32,
    /// The centre of the scale in lattice coordinates.
    centre: Vec2,
    id: u32,
}

/// Returns the highest scale over `p`. `p` counts scale widths around the body, and scale lengths along the body toward the head.
fn scale_at(p: Vec2) -> Scale {
    let mut best = Scale { height: 0.0, inside: 0.0, centre: p, id: 0 };
    // Rows are half a length apart. Every second row is shifted by half a width.
    let row = (p.y * 2.0).round() as i32;
    for k in row - 2..=row + 2 {
        let shift = 0.5 * (k & 1) as f32;
        let column = (p.x - shift).round();
        for c in [column - 1.0, column, column + 1.0] {
            let centre = Vec2::new(c + shift, 0.5 * k as f32);
            // A scale extends from its root, under the scale in front, to its free tip.
            let t = (centre.y - p.y) / 1.3 + 0.5;
            let q = (p.x - centre.x) / 0.56;
            if !(0.0..=1.0).contains(&t) {
                continue;
            }
            // Scales have the shape of leaves, which are widest before the middle and have a rounded tip.
            let half = if t < 0.42 { 1.0 } else { (1.0 - ((t - 0.42) / 0.58).powi(2)).max(0.0).sqrt() };
            let edge = half - q.abs();
            if edge <= 0.0 {
                continue;
            }
            let inside = smoothstep(0.0, 0.22, edge);
            let keel = (-(q / 0.13).powi(2)).exp() * smoothstep(0.1, 0.45, t) * (1.0 - smoothstep(0.85, 1.0, t));
            let dome = (1.0 - q * q) * 0.09;
            let height = 0.03 + inside * (0.21 * t + dome + 0.055 * keel);
            if height > best.height {
                let wrapped = (centre.x * 2.0).rem_euclid(AROUND * 2.0) as i32;
                best = Scale { height, inside, centre, id: hash(17, wrapped, k) };
            }
        }
    }
    best
}

/// Returns the height and the id of the wide belly plate at `y`.
fn belly_at(y: f32) -> (f32, u32) {
    let t = 1.0 - (y - y.floor());
    (0.17 * t * smoothstep(0.0, 0.12, 1.0 - t), hash(23, y.floor() as i32, 0))
}

/// Evaluates the skin. `angle` is the angle around the body (0 is left, a quarter turn is on top), `girths` is the length along the body in
/// girths, and `x` runs from the tail (0) to the snout (1).
pub fn skin(angle: f32, girths: f32, x: f32) -> Skin {
    let p = Vec2::new(angle / TAU * AROUND, girths * AROUND / LENGTH);
    // The number of half turns from the middle of the back: 0 is on top, and 1 is below.
    let down = ((angle / TAU - 0.25 + 0.5).rem_euclid(1.0) - 0.5).abs() * 2.0;
    let belly = smoothstep(0.71, 0.77, down);
    let scale = scale_at(p);
    let (plate, plate_id) = belly_at(p.y * LENGTH / 1.7);
    let d = to_snout(x);
    let head = smoothstep(0.42, 0.25, d);
    // The pattern fades toward the two pointed ends of the body.
    let end = smoothstep(0.03, 0.0, d).max(smoothstep(0.006, 0.0, x));
    let mut height = scale.height * (1.0 - belly) + plate * belly;
    // Scales on the head are flat.
    height *= (1.0 - 0.55 * head) * (1.0 - end);

    // The back has dark saddles with a black rim and a lighter centre. Between the saddles, the sides have spots.
    let at = Vec2::new(down, scale.centre.y / 15.0);
    let wobble = 0.22 * fractal(5, p.x * 0.2 + 40.0, p.y * 0.2, 1 << 20, 3, 0.5);
    let saddle = {
        let along = (at.y - at.y.round()).abs() * 2.0;
        0.30 + 0.14 * (TAU * at.y.round() * 0.37).sin() - (along * along * 0.34 + down * down * 0.9).sqrt() * 0.9
            + wobble * 0.35
    };
    let spot = {
        let along = (at.y + 0.5 - (at.y + 0.5).round()).abs() * 2.0;
        0.2 - ((down - 0.52) * (down - 0.52) + along * along * 0.14).sqrt() + wobble * 0.25
    };
    let sand = Vec3::new(0.47, 0.33, 0.15).lerp(Vec3::new(0.62, 0.5, 0.28), smoothstep(0.25, 0.7, down));
    let mut color = sand;
    let fade = 0.5 * smoothstep(0.16, 0.05, d) + 0.5 * end;
    for (mark, heart) in [(saddle - fade, Vec3::new(0.23, 0.105, 0.04)), (spot - fade, Vec3::new(0.19, 0.1, 0.045))] {
        color = color.lerp(Vec3::new(0.018, 0.014, 0.012), smoothstep(-0.02, 0.015, mark));
        color = color.lerp(heart, smoothstep(0.05, 0.09, mark));
    }
    // A dark band runs from the eye to the corner of the jaw.
    let band = (1.0 - ((down - 0.5 - 0.25 * (0.12 - d)) / 0.06).powi(2)).max(0.0);
    let band = band * smoothstep(0.38, 0.3, d) * smoothstep(0.04, 0.08, d);
    color = color.lerp(Vec3::new(0.02, 0.015, 0.012), smoothstep(0.1, 0.5, band));
    // The mouth is a groove around the snout that continues below the eyes. There are two nostrils.
    let lip =
        (1.0 - ((down - 0.60 - 0.12 * smoothstep(0.1, 0.0, d)) / 0.014).powi(2)).max(0.0) * smoothstep(0.27, 0.2, d);
    let nostril = (1.0 - ((down - 0.33) / 0.05).powi(2) - ((d - 0.034) / 0.007).powi(2)).max(0.0);
    let cut = lip.max(nostril);
    height -= 0.25 * cut;
    let cream = Vec3::new(0.66, 0.58, 0.42) * (0.85 + 0.25 * unit(plate_id));
    color = color.lerp(cream, belly);
    // The colours of scales vary. The skin between the scales is dark.
    color *= 1.0 + (0.44 * unit(scale.id) - 0.22) * (1.0 - belly) * (1.0 - end);
    color = color.lerp(color * 0.32, (1.0 - scale.inside) * (1.0 - belly) * (1.0 - end));
    color = color.lerp(Vec3::new(0.03, 0.018, 0.012), smoothstep(0.0, 0.6, cut));
    Skin { height, color: color.min(Vec3::splat(0.95)), roughness: 0.34 - 0.08 * belly }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_skin_closes_around_the_body_and_stays_thin() {
        for i in 0..2000 {
            let (angle, girths) = (i as f32 * 0.37 % TAU, i as f32 * 0.0031);
            let (here, around) = (skin(angle, girths, 0.5), skin(angle + TAU, girths, 0.5));
            assert!((here.height - around.height).abs() < 2e-2, "{angle} {girths}");
            assert!((-0.25..0.4).contains(&here.height) && here.color.min_element() > 0.0);
        }
    }

    #[test]
    fn scales_overlap_toward_the_tail() {
        // Along the keel of a row, the height climbs from root to tip and then drops, so most steps go up.
        let heights: Vec<f32> = (0..4000).map(|i| scale_at(Vec2::new(7.0, 40.0 - i as f32 * 0.002)).height).collect();
        let up = heights.windows(2).filter(|w| w[1] > w[0]).count();
        let down = heights.windows(2).filter(|w| w[1] < w[0]).count();
        assert!(up > 2 * down, "{up} {down}");
        assert!(heights.iter().all(|&h| h > 0.03), "no gaps");
    }
}
