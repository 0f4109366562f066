//! Resamples images by area or linearly.

use crate::material::{Encoding, Raster, Samples};
use crate::moments::{Wrap, coverage};

/// Returns the source texels of each of `to` texels, with weights that sum to 1. When shrinking, the weights are area
/// fractions. When enlarging, the weights interpolate linearly between texel centres.
fn taps(from: u32, to: u32, wrap: Wrap) -> Vec<Vec<(usize, f64)>> {
    if to < from {
        return coverage(from, to);
    }
    let tap = |i: u32| {
        let position = (f64::from(i) + 0.5) * f64::from(from) / f64::from(to) - 0.5;
        let (first, share) = (position.floor(), position - position.floor());
        [(0, 1.0 - share), (1, share)].map(|(step, weight)| (wrap.texel(first as i64 + step, from), weight)).to_vec()
    };
    (0..to).map(tap).collect()
}

pub(crate) fn resampled(
    value: impl Fn(u32, u32, usize) -> f32,
    from: [u32; 2],
    to: [u32; 2],
    channels: usize,
    wrap: Wrap,
) -> Vec<f32> {
    let [columns, rows] = [0, 1].map(|axis| taps(from[axis], to[axis], wrap));
    let mut texels = Vec::with_capacity(to[0] as usize * to[1] as usize * channels);
    for row in &rows {
        for column in &columns {
            for channel in 0..channels {
                let along = |&(y, wy): &(usize, f64)| {
                    column.iter().map(|&(x, wx)| wx * wy * f64::from(value(x as u32, y as u32, channel))).sum::<f64>()
                };
                texels.push(row.iter().map(along).sum::<f64>() as f32);
            }
        }
    }
    texels
}

/// Resamples a raster, whose samples have the given `encoding`, to linear floats.
pub(crate) fn resampled_raster(raster: &Raster, to: [u32; 2], encoding: Encoding, wrap: Wrap) -> Raster {
    let value = |x, y, channel| match encoding {
        Encoding::Srgb if channel < 3 => raster.color(x, y, encoding)[channel],
        Encoding::Srgb => raster.value(x, y, 3),
        _ => raster.value(x, y, if channel == 1 && raster.channels() == 2 { 3 } else { channel }),
    };
    let channels = match raster.channels() {
        1 | 3 if encoding == Encoding::Srgb => 3,
        2 if encoding == Encoding::Srgb => 4,
        channels => channels,
    };
    let texels = resampled(value, raster.size(), to, channels, wrap);
    Raster::new(to[0], to[1], channels, Samples::F32(texels)).expect("means of finite values in a valid size")
}
