//! Divides a sea spectrum into wave cascades.

use super::spectrum::Sea;
use leadr_render::surfaces::ocean::waves::Cascade;
use std::f64::consts::TAU;

/// A sea that is divided into tiles.
#[derive(Clone, Debug)]
pub struct Cascades {
    /// The tiles in the order of decreasing wavelength.
    pub cascades: Vec<Cascade>,
    /// The wave number in rad/m at which the finest cascade ends. Shorter waves become roughness.
    pub cut: f64,
}

/// The size ratio of neighbouring tiles. The ratio is irrational, so that no two tiles repeat together.
const RATIO: f64 = 6.853;
/// The smallest number of wavelengths across a tile at the long end of its band. With fewer, the repetition would be visible.
const LEAST_WAVES: f64 = 7.0;
/// The largest number of tiles, and the smallest useful edge of a tile in metres.
const MOST: usize = 6;
const SHORTEST_TILE: f64 = 1.2;
/// The step of the golden angle gives every tile a different orientation.
const ROTATION_STEP: f64 = 2.399_963_229_728_653;

/// Divides `sea` into tiles of `resolution²` samples. The energy of the longest band is divided between two tiles of different size and
/// angle, which hides the repetition at a distance.
pub fn divide(sea: &Sea, resolution: u32, seed: u64) -> Cascades {
    let longest = (12.0 * TAU / sea.peak_wave_number()).max(60.0);
    let mut sizes = vec![longest];
    while sizes.len() + 1 < MOST && sizes[sizes.len() - 1] / RATIO > SHORTEST_TILE {
        sizes.push(sizes[sizes.len() - 1] / RATIO);
    }
    let density = sea.density();
    let frequency = |k: f64| sea.angular_frequency(k);
    // A wave needs at least three samples. Shorter waves would be noise.
    let finest = |size: f64| TAU / size * f64::from(resolution) / 3.0;
    let mut cascades = Vec::new();
    let mut low = 0.0;
    for (i, &size) in sizes.iter().enumerate() {
        let high = sizes.get(i + 1).map_or(finest(size), |next| (LEAST_WAVES * TAU / next).min(finest(size)));
        let direction = |n: usize| sea.wind_direction + ROTATION_STEP * n as f64;
        let mut add = |size: f64, share: f64| {
            let n = cascades.len();
            let seed = seed.wrapping_mul(31).wrapping_add(n as u64);
            cascades.push(Cascade::new(size, direction(n), resolution, [low, high], share, seed, &density, frequency));
        };
        if i == 0 {
            add(size, 0.5);
            add(size * 1.272, 0.5);
        } else {
            add(size, 1.0);
        }
        low = high;
    }
    Cascades { cascades, cut: low }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_cascades_carry_the_spectrum_up_to_the_cut_without_gap_or_overlap() {
        for (wind_speed, resolution) in [(4.0, 128), (8.0, 256), (16.0, 128)] {
            let sea = Sea { wind_speed, ..Sea::default() };
            let Cascades { cascades, cut } = divide(&sea, resolution, 1);
            let (mut height, mut slopes) = (0.0, [0.0; 3]);
            for cascade in &cascades {
                for j in 0..resolution {
                    for i in 0..resolution {
                        let w = cascade.waves[(j * resolution + i) as usize].map(f64::from);
                        let (k, v) = (cascade.wave_vector(i, j), 2.0 * (w[0] * w[0] + w[1] * w[1]));
                        height += v;
                        slopes[0] += v * k.x * k.x;
                        slopes[1] += v * k.y * k.y;
                        slopes[2] += v * k.x * k.y;
                    }
                }
            }
            let exact = sea.moments(0.0, cut);
            let all = sea.moments(0.0, f64::INFINITY);
            println!(
                "{wind_speed} m/s: {} tiles, waves down to {:.3} m, {:.1} % of the slopes below; height {:.4}, slopes {:?}",
                cascades.len(),
                TAU / cut,
                100.0 * (1.0 - exact.slopes[0] / all.slopes[0]),
                height / exact.height,
                slopes
            );
            assert!((height / exact.height - 1.0).abs() < 0.03, "{height} {exact:?}");
            for i in 0..3 {
                assert!((slopes[i] - exact.slopes[i]).abs() < 0.02 * exact.slopes[0], "{i}: {slopes:?} {exact:?}");
            }
        }
    }

    #[test]
    fn a_seed_moves_the_waves_and_not_their_energy() {
        let sea = Sea::default();
        let (a, b) = (divide(&sea, 64, 1), divide(&sea, 64, 2));
        let energy = |c: &Cascades| -> f64 {
            c.cascades.iter().flat_map(|c| &c.waves).map(|w| f64::from(w[0]).powi(2) + f64::from(w[1]).powi(2)).sum()
        };
        assert!((energy(&a) / energy(&b) - 1.0).abs() < 1e-5);
        assert!(a.cascades[0].waves != b.cascades[0].waves);
    }
}
