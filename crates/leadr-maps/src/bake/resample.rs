//! Resamples the input images of a surface to a common size.

use super::Inputs;
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

fn resampled(
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
fn resampled_raster(raster: &Raster, to: [u32; 2], encoding: Encoding, wrap: Wrap) -> Raster {
    let value = |x, y, channel| match encoding {
        Encoding::Srgb => raster.color(x, y, encoding)[channel],
        _ => raster.value(x, y, if channel == 1 && raster.channels() == 2 { 3 } else { channel }),
    };
    let channels = if encoding == Encoding::Srgb { 3 } else { raster.channels() };
    let texels = resampled(value, raster.size(), to, channels, wrap);
    Raster::new(to[0], to[1], channels, Samples::F32(texels)).expect("means of finite values in a valid size")
}

impl Inputs {
    /// Resamples all images to the size of the first image. Returns a message for each resampled image.
    pub fn resample(&mut self) -> Vec<String> {
        let heights = self.heights.as_ref().map(|map| [map.width, map.height]);
        let Some(size) = heights.or(self.normals.as_ref().map(|map| map.texture.raster.size())) else {
            return Vec::new();
        };
        let mut remarks = Vec::new();
        let mut differs = |what: &str, [w, h]: [u32; 2]| {
            if [w, h] != size {
                remarks.push(format!("the {what} are resampled from {w} x {h} to {} x {}", size[0], size[1]));
            }
            [w, h] != size
        };
        if let Some(normals) = &mut self.normals
            && differs("normals", normals.texture.raster.size())
        {
            // Normals are resampled as slopes. If vectors were resampled, a vector's length would act as a weight.
            let map = normals.clone();
            let slope = |x, y, channel: usize| if channel < 2 { map.slope(x, y)[channel] as f32 } else { 0.0 };
            let texels = resampled(slope, map.texture.raster.size(), size, 3, self.wrap);
            let raster = Raster::new(size[0], size[1], 3, Samples::F32(texels)).expect("means of finite slopes");
            normals.texture.raster = raster.into();
            normals.texture.encoding = Encoding::Slopes;
        }
        if let Some(roughness) = &mut self.roughness
            && differs("roughness", roughness.raster.size())
        {
            roughness.raster = resampled_raster(&roughness.raster, size, Encoding::Linear, self.wrap);
        }
        if let Some(color) = &mut self.color
            && differs("colours", color.size())
        {
            *color = resampled_raster(color, size, Encoding::Srgb, self.wrap);
        }
        remarks
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::HeightMap;

    #[test]
    fn sizes_change_and_means_stay() {
        let heights = HeightMap::new(6, 4, vec![0.0; 24]).unwrap();
        let codes: Vec<u8> = (0..9 * 5).map(|i| (i * 5) as u8).collect();
        let mean = codes.iter().map(|&c| f32::from(c) / 255.0).sum::<f32>() / 45.0;
        let raster = Raster::new(9, 5, 1, Samples::U8(codes)).unwrap();
        let shrunk = resampled_raster(&raster, [6, 4], Encoding::Linear, Wrap::Repeat);
        let Samples::F32(texels) = shrunk.samples() else { panic!("floats") };
        assert!((texels.iter().sum::<f32>() / 24.0 - mean).abs() < 1e-6);
        let grown = resampled_raster(&raster, [18, 10], Encoding::Linear, Wrap::Repeat);
        let Samples::F32(texels) = grown.samples() else { panic!("floats") };
        assert!((texels.iter().sum::<f32>() / 180.0 - mean).abs() < 1e-6);
        let mut inputs = Inputs { heights: Some(heights), color: Some(raster), ..Inputs::default() };
        assert!(inputs.size().is_err());
        assert_eq!(inputs.resample(), ["the colours are resampled from 9 x 5 to 6 x 4"]);
        assert_eq!(inputs.size().unwrap(), [6, 4]);
        assert_eq!(inputs.resample(), [""; 0]);
    }
}
