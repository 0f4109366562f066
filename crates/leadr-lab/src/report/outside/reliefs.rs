//! The height maps of the external truths. Three height maps are box means of maps from the shared data. The formula of
//! `scripts/external-truth/reliefs.py` gives the fourth.

use std::f64::consts::PI;

use crate::report::shared::shared;

use leadr_maps::{HeightMap, MapError, load_height_map};

/// The names of all height maps.
#[cfg(test)]
pub const NAMES: [&str; 4] = ["studs", "rock", "walkway", "leather"];

/// The number of texels along a side of each height map.
const TEXELS: u32 = 256;

/// Returns a height map by name, or `None` if the name is unknown or its shared data is missing.
///
/// # Errors
/// Fails if a file of the shared data cannot be read.
pub fn relief(name: &str) -> Result<Option<HeightMap>, MapError> {
    let set = match name {
        "studs" => return Ok(Some(studs())),
        "rock" => "Rock003",
        "walkway" => "MetalWalkway006",
        "leather" => "Leather027",
        _ => return Ok(None),
    };
    let Some(path) = shared(&format!("displacement/{set}/{set}_1K-PNG_Displacement.png")) else { return Ok(None) };
    Ok(Some(box_means(&load_height_map(path)?)))
}

/// Returns round studs of eight sizes plus a slow wave.
fn studs() -> HeightMap {
    let height = |i: u32| {
        let at = |n: u32| (f64::from(n) + 0.5) / f64::from(TEXELS) * 8.0;
        let (x, y) = (at(i % TEXELS), at(i / TEXELS));
        let (i, j) = (x.floor(), y.floor());
        let radius = 0.26 + 0.03 * (3.0 * i + 5.0 * j).rem_euclid(8.0);
        let square = (1.0 - ((x - i - 0.5).powi(2) + (y - j - 0.5).powi(2)) / (radius * radius)).max(0.0);
        0.25 + 0.6 * radius * square.sqrt() / 0.47 + 0.1 * (2.0 * PI * (x + 2.0 * y) / 8.0).sin()
    };
    let texels = (0..TEXELS * TEXELS).map(|i| height(i) as f32).collect();
    HeightMap { width: TEXELS, height: TEXELS, texels }
}

/// Reduces a map to [`TEXELS`] texels per side. The sides of the map must be multiples of this number.
fn box_means(map: &HeightMap) -> HeightMap {
    let side = (map.width / TEXELS).max(1);
    let mean = |i: u32| {
        let (x, y) = (i % TEXELS * side, i / TEXELS * side);
        let texels = (0..side * side).map(|k| f64::from(map.at(x + k % side, y + k / side)));
        (texels.sum::<f64>() / f64::from(side * side)) as f32
    };
    HeightMap { width: TEXELS, height: TEXELS, texels: (0..TEXELS * TEXELS).map(mean).collect() }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn studs_stand_in_their_cells_and_repeat() {
        let map = studs();
        // Cell centres are higher than cell corners, and all heights are between 0 and 1.
        assert!(map.at(16, 16) > map.at(1, 1) + 0.2);
        assert!(map.texels.iter().all(|h| (0.0..=1.0).contains(h)));
        assert!((map.at(0, 7) - map.at(TEXELS - 1, 7)).abs() < 0.02);
    }

    #[test]
    fn boxes_keep_the_mean() {
        let map = HeightMap { width: 512, height: 512, texels: (0..512 * 512).map(|i| (i % 7) as f32).collect() };
        let mean = |m: &HeightMap| m.texels.iter().map(|&h| f64::from(h)).sum::<f64>() / m.texels.len() as f64;
        assert!((mean(&box_means(&map)) - mean(&map)).abs() < 1e-6);
        assert_eq!(box_means(&map).at(0, 0), (map.at(0, 0) + map.at(1, 0) + map.at(0, 1) + map.at(1, 1)) / 4.0);
    }
}
