//! Dry ground that extends to the horizon. Displaced soil is tiled by example, and dust drifts and trodden paths cover it.

use super::plane::{plane, toward_horizon};
use super::sphere::color_code;
use leadr_maps::cache::cached;
use leadr_maps::noise::transpose;
use leadr_maps::{HeightMap, procedural};
use leadr_render::scene::{MaterialMap, Object, Tiling};
use leadr_render::surfaces::displacement::HeightField;

/// The width of ground that one repeat of the soil map covers, in metres.
const REPEAT: f32 = 5.0;
/// The height from the lowest crack to the highest pebble, in metres.
pub const RELIEF: f32 = 0.10;
/// The Beckmann roughness of the soil.
const SOIL_ROUGHNESS: f32 = 0.78;
/// Half the side of the ground, in metres. At this distance, the rim is 0.02° below the horizon of a standing viewer.
const HALF: f32 = 6000.0;
/// The resolution of the soil map along one repeat in texels.
const TEXELS: u32 = 1024;

/// The step in metres in which the ground mesh follows the viewer. The features of the ground stay fixed in the world ([`Tiling::Ground`]).
pub const STEP: f32 = 40.0;

/// Returns the heights of the soil, without broad swells.
fn soil() -> Vec<f32> {
    let programs = [include_str!("ground.rs"), procedural::SOURCE, leadr_maps::noise::SOURCE];
    cached(
        "soil",
        &programs,
        (TEXELS * TEXELS) as usize,
        |height: &f32| height.abs() <= 1.0,
        || {
            let mut soil = procedural::soil(TEXELS, TEXELS, 1).texels;
            flatten(&mut soil, TEXELS as usize, 80);
            soil
        },
    )
}

/// Builds the ground at z = 0, with heights centred on zero.
pub fn ground() -> Object {
    let soil = soil();
    let mean = soil.iter().sum::<f32>() / soil.len() as f32;
    let (low, high) = soil.iter().fold((f32::MAX, f32::MIN), |(l, h), &t| (l.min(t), h.max(t)));
    let range = (high - low).max(1e-6);
    let texels: Vec<f32> = soil.iter().map(|h| (h - mean) / range * RELIEF).collect();
    let colors = soil
        .iter()
        .map(|h| {
            // Dust covers the high points, and dark damp earth fills the cracks.
            let t = ((h - low) / range).clamp(0.0, 1.0);
            let mix = |dark: f32, light: f32| dark + (light - dark) * t * (2.0 - t);
            color_code([mix(0.10, 0.40), mix(0.075, 0.31), mix(0.05, 0.22)], SOIL_ROUGHNESS)
        })
        .collect();
    Object::new("ground", plane(HALF, 80, REPEAT, [1.0; 4], toward_horizon))
        .with_tiling(Tiling::Ground)
        .with_heights(HeightField::repeating(HeightMap { width: TEXELS, height: TEXELS, texels }), 1.0)
        .with_material(MaterialMap::new(TEXELS, TEXELS, colors))
        .with_specular_f0(0.03)
        .without_shadow()
}

/// Removes features wider than about `radius` texels from a repeating map. Tiling by example blends pieces of the map, and pieces with
/// broad swells would not fit together.
fn flatten(texels: &mut [f32], width: usize, radius: usize) {
    let mut swell = texels.to_vec();
    for _ in 0..2 {
        swell = blur_rows(&swell, width, radius);
        swell = transpose(&blur_rows(&transpose(&swell, width), texels.len() / width, radius), texels.len() / width);
    }
    for (texel, swell) in texels.iter_mut().zip(swell) {
        *texel -= swell;
    }
}

/// Returns the running means over `2 · radius + 1` texels, for rows that repeat.
fn blur_rows(texels: &[f32], width: usize, radius: usize) -> Vec<f32> {
    let count = (2 * radius + 1) as f64;
    texels
        .chunks(width)
        .flat_map(|row| {
            let at = |i: usize| f64::from(row[i % width]);
            let mut sum: f64 = (0..2 * radius + 1).map(|i| at(i + width - radius)).sum();
            (0..width).map(move |x| {
                let mean = (sum / count) as f32;
                sum += at(x + radius + 1) - at(x + width - radius);
                mean
            })
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_ground_follows_by_whole_repeats() {
        // With this step, shifts of the lattice are integers and exact at any distance.
        assert_eq!(STEP % REPEAT, 0.0);
    }

    #[test]
    fn flattening_removes_swells_and_keeps_pebbles() {
        let wave = |x: usize, periods: f32| (x as f32 / 256.0 * periods * std::f32::consts::TAU).sin();
        let mut swells: Vec<f32> = (0..256 * 64).map(|i| wave(i % 256, 1.0)).collect();
        flatten(&mut swells, 256, 20);
        assert!(swells.iter().all(|h| h.abs() < 0.12));
        let mut pebbles: Vec<f32> = (0..256 * 64).map(|i| wave(i % 256, 32.0)).collect();
        let before = pebbles.clone();
        flatten(&mut pebbles, 256, 20);
        assert!(pebbles.iter().zip(before).all(|(a, b)| (a - b).abs() < 0.05));
    }

    #[test]
    fn soil_height_matches_its_constant() {
        let object = ground();
        let heights = object.heights.unwrap().map.texels;
        let (low, high) = heights.iter().fold((f32::MAX, f32::MIN), |(l, h), &t| (l.min(t), h.max(t)));
        assert!((high - low - RELIEF).abs() < 1e-5);
        assert!(heights.iter().sum::<f32>().abs() / (heights.len() as f32) < 1e-5);
    }
}
