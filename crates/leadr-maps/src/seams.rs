//! Whether a map tiles: whether its opposite edges match.

use crate::HeightMap;
use crate::material::Raster;

/// The mean step across an edge, relative to the largest mean step between two columns or rows inside, above which a seam shows.
const SHOWS: f64 = 1.5;
/// The smallest mean step across an edge that shows, relative to the range of the map.
const VISIBLE: f64 = 0.02;
/// The number of lines along each axis that are compared.
const LINES: u32 = 512;

/// Whether a map of this size has a seam where it repeats.
fn has_seam([width, height]: [u32; 2], value: impl Fn(u32, u32) -> f32) -> bool {
    let along_x = |across: u32, along: u32| value(along, across);
    has_seam_along(width, height, along_x) || has_seam_along(height, width, &value)
}

/// Whether the last texels of lines of `length` texels do not continue in the first. `value` takes the line and the texel.
fn has_seam_along(length: u32, lines: u32, value: impl Fn(u32, u32) -> f32) -> bool {
    let (mut low, mut high, mut count) = (f32::MAX, f32::MIN, 0.0f64);
    // The sums over the lines of the steps to the next texel. The last one leads to the first texel.
    let mut steps = vec![0.0f64; length as usize];
    for line in (0..lines).step_by(lines.div_ceil(LINES).max(1) as usize) {
        let first = value(line, 0);
        let mut here = first;
        for texel in 0..length {
            (low, high) = (low.min(here), high.max(here));
            let next = if texel + 1 < length { value(line, texel + 1) } else { first };
            steps[texel as usize] += f64::from((next - here).abs());
            here = next;
        }
        count += 1.0;
    }
    let across = steps.pop().unwrap_or_default();
    let inside = steps.into_iter().fold(0.0, f64::max);
    across > SHOWS * inside && across > VISIBLE * f64::from(high - low) * count
}

impl HeightMap {
    /// Whether the opposite edges differ so much that repeats show a seam.
    pub fn has_seam(&self) -> bool {
        has_seam([self.width, self.height], |x, y| self.at(x, y))
    }
}

impl Raster {
    /// Whether the opposite edges differ so much in one of the first three channels that repeats show a seam.
    pub fn has_seam(&self) -> bool {
        (0..self.channels().min(3)).any(|channel| has_seam(self.size(), |x, y| self.value(x, y, channel)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::procedural;

    #[test]
    fn maps_that_tile_have_no_seam() {
        let noise = procedural::fbm(128, 128, 1, 4, 4, 0.5);
        assert!(!noise.has_seam() && !procedural::rock(96, 64, 3).has_seam());
        let cut: Vec<f32> = (0..128).flat_map(|y| (0..80).map(move |x| (x, y))).map(|(x, y)| noise.at(x, y)).collect();
        assert!(HeightMap { width: 80, height: 128, texels: cut }.has_seam());
        let stripes = |x: u32| if (x / 8).is_multiple_of(2) { 0.0 } else { 1.0 };
        let texels = (0..64 * 64).map(|i| stripes(i % 64)).collect();
        assert!(!HeightMap { width: 64, height: 64, texels }.has_seam(), "an edge of the pattern lies on the edge");
        assert!(!HeightMap { width: 1, height: 1, texels: vec![0.5] }.has_seam());
    }
}
