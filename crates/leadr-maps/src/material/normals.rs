//! Decodes the slopes of normal maps, detects the green direction, and compares normals with heights.

use rayon::prelude::*;

use super::{Encoding, GreenAxis, NormalMap, Raster, Samples};
use crate::moments::Wrap;
use crate::types::HeightMap;

/// The steepest slope of a normal map, as rise over run. Steeper slopes are quantisation noise.
pub const STEEPEST: f64 = 8.0;

/// Returns the channel that stores y. Two-channel images store y in the second channel.
fn second(raster: &Raster) -> usize {
    if raster.channels() == 2 { 3 } else { 1 }
}

/// Returns the channels of x and y if an image of codes stores only these, in a layout of compressed textures: x in the colours
/// and y in alpha, x in alpha and y in green with red 1 (DXT5nm), or x in red and y in green with blue 0.
pub(super) fn packed_axes(raster: &Raster) -> Option<[usize; 2]> {
    if matches!(raster.samples(), Samples::F32(_)) || raster.channels() < 3 {
        return None;
    }
    let [width, height] = raster.size();
    let texels = || (0..height).flat_map(|y| (0..width).map(move |x| [0, 1, 2, 3].map(|c| raster.value(x, y, c))));
    let first = texels().next()?;
    let varies = |channel: usize| texels().any(|texel| texel[channel] != first[channel]);
    if texels().all(|[r, g, b, _]| r == g && g == b) {
        return (raster.channels() == 4 && varies(3)).then_some([0, 3]);
    }
    if texels().all(|[r, ..]| r == 1.0) && varies(3) {
        return Some([3, 1]);
    }
    texels().all(|[_, _, b, _]| b == 0.0).then_some([0, 1])
}

impl NormalMap {
    /// Returns the slope of a texel along `s` and `t` (down) as rise over run, at most [`STEEPEST`]. Panics outside the
    /// image.
    pub fn slope(&self, x: u32, y: u32) -> [f64; 2] {
        let raster = &self.texture.raster;
        if self.texture.encoding == Encoding::Slopes {
            return [0, 1].map(|channel| f64::from(raster.value(x, y, channel)));
        }
        let code = |channel| 2.0 * f64::from(raster.value(x, y, channel)) - 1.0;
        let [nx, ny] = [0, second(raster)].map(|channel| code(channel) * f64::from(self.scale));
        let nz = if raster.channels() >= 3 { code(2) } else { (1.0 - nx * nx - ny * ny).max(0.0).sqrt() };
        let up = if self.green == GreenAxis::Up { 1.0 } else { -1.0 };
        let slope = [-nx, up * ny].map(|n| n / nz.max(1e-3));
        let kept = (STEEPEST / slope[0].hypot(slope[1]).max(1e-20)).min(1.0);
        slope.map(|v| v * kept)
    }

    /// Returns the stored vector of a texel without scaling or clamping. y points along `t` (down). Returns `None` for slope
    /// maps, and for maps that store only x and y. Panics outside the image.
    pub fn vector(&self, x: u32, y: u32) -> Option<[f32; 3]> {
        let raster = &self.texture.raster;
        if self.texture.encoding == Encoding::Slopes || raster.channels() < 3 {
            return None;
        }
        let up = if self.green == GreenAxis::Up { -1.0 } else { 1.0 };
        let code = |channel| 2.0 * raster.value(x, y, channel) - 1.0;
        Some([code(0), up * code(1), code(2)])
    }
}

/// How well the heights and normals of a surface agree.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Agreement {
    /// The best height scale, in texels per unit of height, found by regression of the normals' slopes on the heights'
    /// slopes.
    pub scale_texels: f64,
    /// The correlation between the slopes of the heights and of the normals, from -1 to 1.
    pub correlation: f64,
    /// The fraction of the normals' squared slopes that remains unexplained at the best height scale.
    pub left_over: f64,
}

/// The correlation below which two maps probably show different surfaces.
const SAME_SURFACE: f64 = 0.5;

impl Agreement {
    /// Whether the two maps probably show the same surface.
    pub fn is_of_one_surface(&self) -> bool {
        self.correlation >= SAME_SURFACE
    }
}

impl std::fmt::Display for Agreement {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let Self { scale_texels, correlation, left_over } = self;
        write!(
            f,
            "correlation {correlation:.3}, best height scale {scale_texels:.2} texels, {:.1} % unexplained",
            100.0 * left_over
        )
    }
}

/// Compares the heights and normals of a surface at the texels of the height map. Returns `None` if either map is flat.
pub fn agreement(heights: &HeightMap, normals: &NormalMap, wrap: Wrap) -> Option<Agreement> {
    let raster = &normals.texture.raster;
    let nearest = |k: u32, of: u32, to: u32| (u64::from(k) * u64::from(to) / u64::from(of)) as u32;
    // Rows are summed in order, which makes the result independent of the number of cores.
    let row = |y: u32| {
        (0..heights.width).fold([0.0f64; 3], |sum, x| {
            let gradient = heights.central_differences(x, y, wrap);
            let slope =
                normals.slope(nearest(x, heights.width, raster.width()), nearest(y, heights.height, raster.height()));
            let dot = |a: [f64; 2], b: [f64; 2]| a[0] * b[0] + a[1] * b[1];
            [sum[0] + dot(gradient, slope), sum[1] + dot(gradient, gradient), sum[2] + dot(slope, slope)]
        })
    };
    let rows: Vec<[f64; 3]> = (0..heights.height).into_par_iter().map(row).collect();
    let [both, of_heights, of_normals] = rows.into_iter().fold([0.0; 3], |a, b| std::array::from_fn(|i| a[i] + b[i]));
    if of_heights <= 0.0 || of_normals <= 0.0 {
        return None;
    }
    let correlation = both / (of_heights * of_normals).sqrt();
    Some(Agreement { scale_texels: both / of_heights, correlation, left_over: 1.0 - correlation * correlation })
}

/// Detects the green direction by the curl, which is 0 for slopes of heights: `dh/ds` changes along `t` as `dh/dt` changes
/// along `s`. Returns the direction with less curl, or up if both are equal.
pub fn green_axis(raster: &Raster) -> GreenAxis {
    let (width, height, green) = (raster.width(), raster.height(), second(raster));
    let signed = |x: u32, y: u32, channel: usize| f64::from(2.0 * raster.value(x % width, y % height, channel) - 1.0);
    let curl_of = |x: u32, y: u32| {
        // Returns the change over a cell between four texels, multiplied by the texel size.
        let by = |channel, dx, dy| {
            signed(x + dx, y + dy, channel) + signed(x + 1, y + 1, channel)
                - signed(x, y, channel)
                - signed(x + dy, y + dx, channel)
        };
        // The slope dh/ds is the negative of red. If green points up, dh/dt is green, because t points down.
        (-by(0, 0, 1), by(green, 1, 0))
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

    /// Returns a normal map of waves as 8-bit codes.
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
    fn two_channels_are_x_and_y() {
        let three = waves(1.0);
        let Samples::U8(codes) = three.samples() else { panic!("codes") };
        let two = codes.chunks(3).flat_map(|texel| [texel[0], texel[1]]).collect();
        let two = Raster::new(32, 32, 2, Samples::U8(two)).unwrap();
        assert_eq!((green_axis(&two), two.channels()), (GreenAxis::Up, 2));
        let map = |raster| NormalMap {
            texture: crate::material::Texture::new(raster, "waves", Encoding::Linear),
            green: GreenAxis::Up,
            scale: 1.0,
        };
        let (two, three) = (map(two), map(three));
        for (x, y) in [(0, 0), (3, 17), (30, 9)] {
            let (a, b) = (two.slope(x, y), three.slope(x, y));
            assert!((a[0] - b[0]).abs() < 0.01 && (a[1] - b[1]).abs() < 0.01, "{a:?} {b:?}");
        }
    }

    #[test]
    fn layouts_of_compressed_textures_are_recognised() {
        let raster = |texel: fn(u8, u8) -> [u8; 4]| {
            let codes = (0..32 * 32).flat_map(|i| texel(100 + (i % 32) as u8, 90 + (i / 32) as u8)).collect();
            Raster::new(32, 32, 4, Samples::U8(codes)).unwrap()
        };
        assert_eq!(packed_axes(&raster(|x, y| [x, x, x, y])), Some([0, 3]));
        assert_eq!(packed_axes(&raster(|x, y| [255, y, 255, x])), Some([3, 1]));
        assert_eq!(packed_axes(&raster(|x, y| [x, y, 0, 255])), Some([0, 1]));
        assert_eq!(packed_axes(&raster(|x, y| [x, y, 250, x])), None);
        assert_eq!(packed_axes(&raster(|_, _| [128, 128, 255, 255])), None);
        let selected = raster(|x, y| [255, y, 255, x]).selected(&[3, 1]);
        assert_eq!(
            (selected.channels(), selected.value(5, 7, 0), selected.value(5, 7, 3)),
            (2, 105.0 / 255.0, 97.0 / 255.0)
        );
    }

    #[test]
    fn green_is_found_by_the_curl() {
        assert_eq!(green_axis(&waves(1.0)), GreenAxis::Up);
        assert_eq!(green_axis(&waves(-1.0)), GreenAxis::Down);
        let flat = Raster::new(1, 1, 3, Samples::U8(vec![128, 128, 255])).unwrap();
        assert_eq!(green_axis(&flat), GreenAxis::Up);
    }
}
