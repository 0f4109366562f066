//! Resamples the input images of a surface to a common size.

use super::Inputs;
use crate::material::{Encoding, Raster, Samples};
use crate::resample::{resampled, resampled_raster};

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
    use crate::{HeightMap, Wrap};

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
