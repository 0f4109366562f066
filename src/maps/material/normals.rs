//! Which way the green of a normal map goes.

use super::{GreenAxis, Raster};

/// As the slopes fit together best. Those of heights have no curl: `dh/ds` changes along `t` as `dh/dt` does along `s`. Of the two ways
/// to read green, the one that leaves less curl is right; up, where both leave as much.
#[must_use]
pub fn green_axis(raster: &Raster) -> GreenAxis {
    let (width, height) = (raster.width(), raster.height());
    let signed = |x: u32, y: u32, channel: usize| f64::from(2.0 * raster.value(x % width, y % height, channel) - 1.0);
    let curl_of = |x: u32, y: u32| {
        // Over a cell between four texels, times the size of a texel.
        let by = |channel, dx, dy| {
            signed(x + dx, y + dy, channel) + signed(x + 1, y + 1, channel)
                - signed(x, y, channel)
                - signed(x + dy, y + dx, channel)
        };
        // dh/ds = -red; dh/dt, t down, is green where that goes up.
        (-by(0, 0, 1), by(1, 1, 0))
    };
    let (mut up, mut down) = (0.0, 0.0);
    for y in 0..height {
        for x in 0..width {
            let (along_t, along_s) = curl_of(x, y);
            up += (along_t - along_s).powi(2);
            down += (along_t + along_s).powi(2);
        }
    }
    if down < up { GreenAxis::Down } else { GreenAxis::Up }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::maps::material::Samples;

    /// Normals of waves, as codes of 8 bits.
    fn waves(up: f32) -> Raster {
        let n = 32;
        let codes = (0..n * n).flat_map(|i| {
            let [s, t] = [i % n, i / n].map(|k| std::f32::consts::TAU * k as f32 / n as f32);
            let [by_s, by_t] = [0.4 * (s + t).cos() + 0.2 * s.cos(), 0.4 * (s + t).cos() - 0.3 * (2.0 * t).sin()];
            let length = (1.0 + by_s * by_s + by_t * by_t).sqrt();
            [-by_s, up * by_t, 1.0].map(|v| ((v / length * 0.5 + 0.5) * 255.0 + 0.5) as u8)
        });
        Raster::new(n, n, 3, Samples::U8(codes.collect())).unwrap()
    }

    #[test]
    fn green_is_found_by_the_curl() {
        assert_eq!(green_axis(&waves(1.0)), GreenAxis::Up);
        assert_eq!(green_axis(&waves(-1.0)), GreenAxis::Down);
        let flat = Raster::new(1, 1, 3, Samples::U8(vec![128, 128, 255])).unwrap();
        assert_eq!(green_axis(&flat), GreenAxis::Up);
    }
}
