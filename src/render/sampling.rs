//! Where samples lie in a pixel.

use glam::Vec2;

/// Offset of sample `index` inside its pixel, `[-½, ½)²`: the R2 low-discrepancy sequence, shifted by the seed. A single
/// sample lies in the centre.
#[must_use]
pub fn jitter(index: u32, samples: u32, seed: u64) -> Vec2 {
    if samples <= 1 {
        return Vec2::ZERO;
    }
    // The reciprocals of the plastic number and of its square.
    let step = [0.754_877_666_246_692_7f64, 0.569_840_290_998_053_2];
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d_4c95_7f2d;
    let mut shift = || {
        state ^= state >> 30;
        state = state.wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state ^= state >> 27;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let at = |step: f64, shift: f64| (f64::from(index).mul_add(step, shift).fract() - 0.5) as f32;
    Vec2::new(at(step[0], shift()), at(step[1], shift()))
}

/// Offset of edge sample `index` of the `count` in one cell of a pixel's grid, in cells, `[-½, ½)²`. The samples form a
/// lattice with one point in each of `count` columns and rows. The lattice is moved by the `offset` of the pixel's own
/// sample and wraps around in the cell.
#[must_use]
pub fn edge_jitter(offset: Vec2, index: u32, count: u32) -> Vec2 {
    let count = count.max(1);
    // The step from row to row is near the golden section and shares no divisor with `count`, so every row is used once.
    let golden = (f64::from(count) * 0.618).round() as u32;
    let step = (golden.max(1)..).find(|&step| greatest_common_divisor(step, count) == 1).unwrap_or(1);
    let at = |place: u32, offset: f32| {
        let place = (f64::from(place) + 0.5) / f64::from(count) + f64::from(offset);
        (place.rem_euclid(1.0) - 0.5) as f32
    };
    Vec2::new(at(index, offset.x), at(index * step % count, offset.y))
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_cover_the_pixel_evenly() {
        assert_eq!(jitter(0, 1, 7), Vec2::ZERO);
        for seed in [0, 1, 99] {
            let mut cells = [0; 16];
            let mut mean = Vec2::ZERO;
            for i in 0..256 {
                let p = jitter(i, 256, seed);
                assert!(p.abs().max_element() <= 0.5);
                mean += p / 256.0;
                cells[((p.y + 0.5) * 4.0) as usize * 4 + ((p.x + 0.5) * 4.0) as usize] += 1;
            }
            assert!(mean.length() < 0.02, "{mean}");
            assert!(cells.iter().all(|&n| (12..=20).contains(&n)), "{cells:?}");
        }
        assert_ne!(jitter(0, 16, 0), jitter(0, 16, 1));
    }

    #[test]
    fn edge_samples_cover_their_cell() {
        assert_eq!(edge_jitter(Vec2::ZERO, 0, 1), Vec2::ZERO);
        for count in 1..=64 {
            for offset in [Vec2::ZERO, jitter(3, 8, 5), Vec2::splat(-0.5)] {
                let points: Vec<Vec2> = (0..count).map(|i| edge_jitter(offset, i, count)).collect();
                assert!(points.iter().all(|p| p.abs().max_element() <= 0.5));
                // Every row and every column has one point.
                for axis in [0, 1] {
                    let mut places: Vec<f32> = points.iter().map(|p| p[axis]).collect();
                    places.sort_by(f32::total_cmp);
                    assert!(places.windows(2).all(|w| ((w[1] - w[0]) * count as f32 - 1.0).abs() < 1e-3), "{places:?}");
                }
            }
            let mean: Vec2 = (0..count).map(|i| edge_jitter(Vec2::ZERO, i, count)).sum::<Vec2>() / count as f32;
            assert!(mean.length() < 1e-5, "{count}: {mean}");
        }
    }
}
