//! The height of a relief whose scale is unknown.

use crate::HeightMap;

/// The largest height of a relief without scale and normals, as a fraction of its repeat.
pub const USUAL_HEIGHT: f32 = 0.06;

/// The largest RMS slope of a relief without scale and normals. The limit matters for fine-grained maps: with a height of 6 %, scanned
/// leather would be steeper than 80° on average, and masking would make it black.
pub const USUAL_SLOPE: f32 = 0.5;

/// Returns the RMS slope of a height map, in units of height per repeat.
fn steepness(map: &HeightMap) -> f32 {
    let [w, h] = [map.width, map.height].map(|n| n as usize);
    let at = |x: usize, y: usize| f64::from(map.texels[y % h * w + x % w]);
    let square = |(x, y): (usize, usize)| {
        let [s, t] = [(at(x + 1, y) - at(x, y)) * w as f64, (at(x, y + 1) - at(x, y)) * h as f64];
        s * s + t * t
    };
    let sum: f64 = (0..h).flat_map(|y| (0..w).map(move |x| (x, y))).map(square).sum();
    (sum / (w * h) as f64).sqrt() as f32
}

/// Returns the default scale of a height map without scale, in texture repeats per unit of height.
pub fn usual_scale(map: &HeightMap) -> f32 {
    usual_scale_of_slope(steepness(map))
}

/// Returns the default scale of a height map without scale, from its RMS slope in units of height per repeat.
pub fn usual_scale_of_slope(rms: f32) -> f32 {
    USUAL_HEIGHT.min(USUAL_SLOPE / rms.max(1e-6))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn steepness_is_that_of_the_slopes() {
        let waves = |x: u32| (std::f32::consts::TAU * 3.0 * x as f32 / 256.0).sin();
        let texels = (0..256 * 4).map(|i| waves(i % 256)).collect();
        let found = steepness(&HeightMap { width: 256, height: 4, texels });
        let want = 3.0 * std::f32::consts::TAU * 0.5f32.sqrt();
        assert!((found / want - 1.0).abs() < 1e-3, "{found} {want}");
    }
}
