//! Prints the slopes of a height map at each mip level of its LEADR map. As bumps vanish, slope variance replaces them. The example needs
//! no GPU.
//!
//! ```sh
//! cargo run --example 01_vanishing_bumps -- bricks.png     # or without a file: a wavy surface
//! ```

use leadr::maps::{HeightMap, LeadrMap, Wrap, load_height_map};

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let heights = match std::env::args_os().nth(1) {
        Some(file) => load_height_map(file)?,
        None => waves(256)?,
    };
    // The height range is 2 % of the map's width.
    let scale = 0.02;
    let map = LeadrMap::new(&heights, Wrap::Repeat);

    println!("level       size   rms mean slope   rms slope deviation   together");
    for (number, level) in map.levels.iter().enumerate() {
        let (mut mean, mut variance) = (0.0, 0.0);
        for texel in &level.texels {
            let texel = texel.scaled(scale);
            let [x, y] = texel.mean_slope.map(f64::from);
            let [xx, yy, _] = texel.slope_covariance();
            mean += x * x + y * y;
            variance += xx + yy;
        }
        let count = level.texels.len() as f64;
        let [mean, variance] = [mean / count, variance / count];
        // The variance gains what the means lose, so the last column is constant.
        println!(
            "{number:5} {:>10}   {:14.4}   {:19.4}   {:8.4}",
            format!("{}x{}", level.width, level.height),
            mean.sqrt(),
            variance.sqrt(),
            (mean + variance).sqrt()
        );
    }
    Ok(())
}

/// Returns a swell with ripples.
fn waves(side: u32) -> Result<HeightMap, leadr::maps::MapFault> {
    let tau = std::f32::consts::TAU;
    let height = |x: u32, y: u32| {
        let (s, t) = (x as f32 / side as f32, y as f32 / side as f32);
        0.5 + 0.4 * (tau * (s + t)).sin() + 0.05 * (tau * 11.0 * s).sin() * (tau * 13.0 * t).cos()
    };
    HeightMap::new(side, side, (0..side * side).map(|i| height(i % side, i / side)).collect())
}
