//! Converts the finest level of a baked map to a material.

use super::{Encoding, GreenAxis, Input, Material, NormalMap, Raster, Relief, RoughnessMeaning, Samples, Texture};
use crate::MapFault;
use crate::baked::{BakedMap, HeightUnit};

impl Material {
    /// Converts the finest level of a baked map to a material with heights, slopes from normals, roughness and colour.
    ///
    /// # Errors
    /// Fails if the map is not of kind LEADR, does not repeat, or has a height that is too large.
    pub fn of_baked(map: &BakedMap) -> Result<Self, MapFault> {
        map.check_drawable()?;
        let mut material = Self::new("baked map");
        let [width, height] = [map.levels[0].width, map.levels[0].height];
        let texture = |channels: &[Vec<f32>], encoding| {
            let texels = (0..channels[0].len()).flat_map(|i| channels.iter().map(move |channel| channel[i]));
            let raster = Raster::new(width, height, channels.len(), Samples::F32(texels.collect()))?;
            Ok::<_, MapFault>(Texture::new(raster, "baked map", encoding))
        };
        if map.heights != HeightUnit::None {
            let in_widths = map.heights == HeightUnit::Width;
            material.relief = Some(Relief { map: map.height_map()?, scale: None, in_widths, middle: map.middle });
        }
        if map.dropped_levels > 0 {
            let mut moments = map.levels[0].moments();
            if map.of_normals {
                let ratio = width as f32 / height as f32;
                moments.texels.iter_mut().for_each(|texel| *texel = texel.with_t_times(ratio));
            }
            material.slope_moments = Some(moments);
        } else if let (true, Some(across), Some(mut down)) = (map.of_normals, map.channel("x"), map.channel("y")) {
            // Slopes along t are converted from per texture height to per texture width.
            down.iter_mut().for_each(|slope| *slope *= width as f32 / height as f32);
            let none = vec![0.0; down.len()];
            let texture = texture(&[across, down, none], Encoding::Slopes)?;
            material.normal_map = Some(NormalMap { texture, green: GreenAxis::Up, scale: 1.0 });
        }
        if let Some(mut roughness) = map.channel("alpha2") {
            // α² is converted back to perceptual roughness, because textures interpolate perceptual roughness.
            roughness.iter_mut().for_each(|square| *square = as_code(square.max(0.0).sqrt().sqrt()));
            material.roughness = Input::texture(texture(&[roughness], Encoding::Linear)?, 0);
            material.roughness_meaning = RoughnessMeaning::Perceptual;
        }
        let colors: Vec<Vec<f32>> = ["red", "green", "blue"].iter().filter_map(|name| map.channel(name)).collect();
        if colors.len() == 3 {
            material.base_color = Input::colors(texture(&colors, Encoding::Linear)?);
        }
        Ok(material)
    }
}

/// Returns the nearest 8- or 16-bit code if `value` differs only by rounding, otherwise `value`.
fn as_code(value: f32) -> f32 {
    let code = (value * 65535.0).round();
    if (value * 65535.0 - code).abs() < 0.03 { code / 65535.0 } else { value }
}
