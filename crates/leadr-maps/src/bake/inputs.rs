//! The inputs of a bake: images of heights, normals, roughness and colour that have one size and are read row by row.

use glam::DVec3;
use rayon::prelude::*;

use super::{FoundClasses, Kind, Texels};
use crate::material::{Agreement, Encoding, NormalMap, Raster, RoughnessMeaning, STEEPEST, Samples, agreement};
use crate::moments::row_moments;
use crate::{HeightMap, MapFault, Wrap};
use leadr_reflectance::facets::gloss::Gloss;
use leadr_reflectance::facets::shortened_normals::NormalArea;

/// A roughness map.
#[derive(Clone, Debug)]
pub struct Roughness {
    /// The texels of the roughness map.
    pub raster: Raster,
    /// The index of the raster channel that stores roughness.
    pub channel: usize,
    /// The meaning of the roughness values.
    pub meaning: RoughnessMeaning,
}

impl Roughness {
    pub(super) fn alpha(&self, x: u32, y: u32) -> f64 {
        f64::from(self.meaning.alpha(self.raster.value(x, y, self.channel).clamp(0.0, 1.0)))
    }
}

/// A detail normal map, with optional roughness, that repeats over the surface.
#[derive(Clone, Debug)]
pub struct DetailNormals {
    /// The normals of the detail.
    pub normals: NormalMap,
    /// The roughness of the detail. `None` means the roughness of the base.
    pub roughness: Option<Roughness>,
    /// The number of repeats of the detail within one repeat of the surface.
    pub repeat: u32,
    /// The function that blends the base normal (first argument) with the detail normal. See
    /// [`leadr_reflectance::slopes::normal_blending`].
    pub blend: fn(DVec3, DVec3) -> DVec3,
}

/// Input images of one size. At least heights or normals must be given.
#[derive(Clone, Debug, Default)]
pub struct Inputs {
    /// The height map, if any.
    pub heights: Option<HeightMap>,
    /// The normal map, if any. The slopes of the normals replace the slopes of the heights.
    pub normals: Option<NormalMap>,
    /// The roughness of the material, which is filtered together with the slopes.
    pub roughness: Option<Roughness>,
    /// The colour image, which is filtered in linear light.
    pub color: Option<Raster>,
    /// The factor from heights to texture widths. `None` means the best fit to the normals, or 1 without normals, which
    /// keeps the map's own unit.
    pub height_scale: Option<f32>,
    /// How texels outside the height map are addressed.
    pub wrap: Wrap,
    /// The detail that is blended over the normals, for the kinds normal and gloss.
    pub detail: Option<DetailNormals>,
    /// The visibility cone and visible fraction of each texel, for the kinds occlusion and cones. See
    /// [`Inputs::compute_occlusion`].
    pub visibility: Option<Vec<[f32; 4]>>,
    /// The weight of the slope variance inside texels when normals are integrated to heights. See
    /// [`crate::derive::Integration::smoothness`].
    pub smoothness: Option<f64>,
    /// The distance in texture widths up to which occluders count. See [`crate::derive::Occlusion::distance`].
    pub occlusion_distance: Option<f32>,
    /// The gloss scale of kind gloss.
    pub gloss: Gloss,
    /// The area that each normal represents in kind gloss.
    pub area: NormalArea,
    /// What a texel of the finest level represents in kind gloss.
    pub texels: Texels,
    /// The classes that a map of kind leadr stores, if more than one. See [`Inputs::find_classes`].
    pub classes: Option<FoundClasses>,
}

impl Inputs {
    /// Returns the width and height in texels.
    ///
    /// # Errors
    /// Fails if both heights and normals are missing, or if the sizes differ.
    pub fn size(&self) -> Result<[u32; 2], MapFault> {
        let sizes = [
            ("height", self.heights.as_ref().map(|map| [map.width, map.height])),
            ("normal", self.normals.as_ref().map(|map| map.texture.raster.size())),
            ("roughness", self.roughness.as_ref().map(|map| map.raster.size())),
            ("colour", self.color.as_ref().map(Raster::size)),
        ];
        let mut given = sizes.into_iter().filter_map(|(name, size)| Some((name, size?)));
        let Some((first, size)) = given.next().filter(|(name, _)| ["height", "normal"].contains(name)) else {
            let what = "there are neither heights nor normals";
            return Err(MapFault::unsupported(what, "give a height map or a normal map"));
        };
        match given.find(|&(_, other)| other != size) {
            None => Ok(size),
            Some((name, [w, h])) => {
                let what =
                    format!("the {name} map has {w} x {h} texels, and the {first} map {} x {}", size[0], size[1]);
                Err(MapFault::unsupported(what, "give maps of one size, or let leadr bake --resample change them"))
            }
        }
    }

    /// Compares the heights with the normals. Returns `None` if heights or normals are missing or flat.
    pub fn agreement(&self) -> Option<Agreement> {
        agreement(self.heights.as_ref()?, self.normals.as_ref()?, self.wrap)
    }

    /// Compares the heights with the normals, and sets `height_scale` if it is `None`. Later bakes of other kinds then skip
    /// the comparison.
    pub fn agree(&mut self) -> Option<Agreement> {
        let agreement = self.agreement();
        if agreement.is_some() {
            self.height_scale = Some(self.height_scale.unwrap_or_else(|| self.scale_of(agreement)));
        }
        agreement
    }

    /// Returns the best-fitting height factor, or 1 if heights and normals could not be compared.
    fn scale_of(&self, agreement: Option<Agreement>) -> f32 {
        let agreed = agreement.filter(|agreed| agreed.scale_texels > 0.0);
        let width = self.heights.as_ref().map_or(1, |map| map.width);
        agreed.map_or(1.0, |agreed| (agreed.scale_texels / f64::from(width)) as f32)
    }

    /// Returns the height factor: the given one, or the best fit to the normals, or 1 if neither exists.
    pub(super) fn usual_height_scale(&self) -> f32 {
        self.height_scale.unwrap_or_else(|| self.scale_of(self.agreement()))
    }

    /// Returns the moments and mean heights of a row in the order of [`crate::Moments`]. Heights are multiplied by `scale`.
    pub(super) fn moments(&self, scale: f32, y: u32) -> Vec<[f32; 6]> {
        match (&self.heights, &self.normals) {
            (Some(heights), None) => row_moments(heights, self.wrap, scale, y),
            _ => {
                // The slopes are rounded to 32 bits, because the renderer squares 32-bit slopes.
                let narrow = self.slopes(scale, y).into_iter().map(|slope| slope.map(|v| v as f32));
                narrow.map(|[x, y, height]| [x, y, x * x, y * y, x * y, height]).collect()
            }
        }
    }

    /// Returns the slopes `dh/ds`, `dh/dt` and the height of each texel of a row. The slopes come from the normals if
    /// present, otherwise from central differences.
    pub(super) fn slopes(&self, scale: f32, y: u32) -> Vec<[f64; 3]> {
        let [width, height] = self.size().expect("checked before baking");
        let texels = [f64::from(width), f64::from(height)];
        let texel = |x: u32| {
            let of_heights = self.heights.as_ref().map(|map| f64::from(scale * map.at(x, y)));
            let [by_s, by_t] = match (&self.normals, &self.heights) {
                (Some(normals), _) => {
                    let [s, t] = normals.slope(x, y);
                    [s, t * texels[1] / texels[0]]
                }
                (None, Some(heights)) => {
                    let [s, t] = heights.central_differences(x, y, self.wrap);
                    [s * f64::from(scale) * texels[0], t * f64::from(scale) * texels[1]]
                }
                (None, None) => unreachable!("checked before baking"),
            };
            [by_s, by_t, of_heights.unwrap_or(0.0)]
        };
        (0..width).map(texel).collect()
    }

    /// Appends the additional channels of a texel: first α² and α⁴, then the linear colour.
    pub(super) fn beside(&self, kind: Kind, x: u32, y: u32, texel: &mut Vec<f32>) {
        if let Some(roughness) = self.roughness.as_ref().filter(|_| kind.stores_variance()) {
            let alpha = roughness.alpha(x, y);
            texel.extend([alpha.powi(2), alpha.powi(4)].map(|v| v as f32));
        }
        if let Some(color) = self.color.as_ref().filter(|_| kind.has_color()) {
            texel.extend(color.color(x, y, Encoding::Srgb));
        }
    }

    /// Returns the visibility cone and visible fraction of a texel. If visibility was not computed, the cone is fully open.
    pub(super) fn visible_from(&self, x: u32, y: u32) -> [f32; 4] {
        let width = self.size().map_or(0, |size| size[0]) as usize;
        let at = y as usize * width + x as usize;
        self.visibility.as_ref().map_or([0.0, 0.0, 1.0, 1.0], |texels| texels[at])
    }

    /// Returns the largest absolute value of the slopes `dh/ds` and `dh/dt`.
    pub(super) fn steepest(&self, scale: f32) -> f32 {
        if self.normals.is_none() {
            return self.bounds(scale.into())[0] as f32;
        }
        let row = |y: u32| self.slopes(scale, y).iter().fold(0.0f64, |most, s| most.max(s[0].abs()).max(s[1].abs()));
        let rows = self.size().map_or(0, |size| size[1]);
        (0..rows).into_par_iter().map(row).reduce(|| 0.0, f64::max) as f32
    }

    /// Returns the minimum and maximum height before scaling.
    pub(super) fn height_range(&self) -> [f32; 2] {
        let texels = self.heights.iter().flat_map(|map| &map.texels);
        let [low, high] = texels.fold([f32::INFINITY, f32::NEG_INFINITY], |[low, high], &h| [low.min(h), high.max(h)]);
        if low <= high { [low, high] } else { [0.0; 2] }
    }

    /// Returns the largest colour value, or 1 if all values are smaller.
    pub(super) fn brightest(&self) -> f32 {
        match self.color.as_ref().map(Raster::samples) {
            Some(Samples::F32(values)) => values.iter().fold(1.0, |most, &v| most.max(v)),
            _ => 1.0,
        }
    }

    /// Returns the largest roughness `α`.
    pub(super) fn roughest(&self) -> f64 {
        let Some(roughness) = &self.roughness else { return 0.0 };
        let [width, height] = roughness.raster.size();
        let row = |y: u32| (0..width).fold(0.0, |most: f64, x| most.max(roughness.alpha(x, y)));
        (0..height).into_par_iter().map(row).reduce(|| 0.0, f64::max)
    }

    /// Returns two upper bounds: of the absolute slopes `dh/ds` and `dh/dt`, and of the absolute heights.
    pub(super) fn bounds(&self, scale: f64) -> [f64; 2] {
        let [width, height] = self.size().expect("checked before baking").map(f64::from);
        let highest =
            self.heights.iter().flat_map(|map| &map.texels).fold(0.0f64, |most, &h| most.max(f64::from(h).abs()));
        if self.normals.is_some() {
            return [STEEPEST * (height / width).max(1.0), highest * scale.abs()];
        }
        let Some(map) = &self.heights else { return [0.0; 2] };
        let row = |y: u32| {
            (0..map.width).fold(0.0f64, |most, x| {
                let at = |dx, dy| f64::from(map.beyond(i64::from(x) + dx, i64::from(y) + dy, self.wrap));
                most.max((at(1, 0) - at(0, 0)).abs() * width).max((at(0, 1) - at(0, 0)).abs() * height)
            })
        };
        let steepest = (0..map.height).into_par_iter().map(row).reduce(|| 0.0, f64::max);
        [steepest * scale.abs(), highest * scale.abs()]
    }
}
