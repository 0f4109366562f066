//! What scales and adds to the heights of a map: a height scale that varies over the surface (LEADR section 4.2), as a map over the
//! texture coordinates times a factor per vertex, and a detail that displaces (LEADR section 4.1).
//! `shaders-glsl/passes/geometry/height_scale.glsl` and `detail_height.glsl` are the twins.

use std::borrow::Cow;
use std::sync::Arc;

use glam::{Affine2, Vec2};
use half::f16;

use super::displacement::{HeightField, HeightPyramid};
use super::material::{halve, write_mips};
use super::patch_mesh::PatchMesh;
use crate::constants::{HEIGHT_SCALED_BY_MAP, HEIGHT_SCALED_BY_VERTEX, HEIGHT_WITH_DETAIL};
use crate::scene::{FactorMap, Object};
use leadr_gpu::vk::Format;
use leadr_gpu::{AddressMode, Filter, Gpu, GpuError, Image, ImageDesc, Result, Sampler};
use leadr_maps::HeightMap;

/// Returns the `HEIGHT_` bits of an object that is drawn with `mesh`. An object without relief has none.
pub fn height_terms_of(object: &Object, mesh: &PatchMesh) -> u32 {
    let bits = [
        (HEIGHT_SCALED_BY_VERTEX, mesh.height_scales.iter().any(|&scale| scale != 1.0)),
        (HEIGHT_SCALED_BY_MAP, object.height_scale_map.is_some()),
        (HEIGHT_WITH_DETAIL, object.detail.as_ref().is_some_and(|detail| detail.displaces)),
    ];
    let set = bits.iter().filter(|(_, set)| *set && object.heights.is_some());
    set.fold(0, |bits, (bit, _)| bits | bit)
}

/// The fields of an object's record for its heights.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct HeightTermsRecord {
    /// The columns of the matrix from texture coordinates to coordinates of the map.
    pub linear: [f32; 4],
    /// The offset of these coordinates.
    pub offset: [f32; 2],
    /// The level of the map whose texels are as wide as those of the heights.
    pub lod: f32,
    /// The root mean square over the surface, for terms that have one value per object.
    pub typical: f32,
    /// The units of the heights per metre of the detail.
    pub detail_unit: f32,
    /// The level of the detail whose texels are as wide as those of the heights.
    pub detail_lod: f32,
}

/// The heights of a detail that displaces.
#[derive(Clone)]
pub struct DetailHeights {
    heights: HeightField,
    transform: Affine2,
    mask: Option<(HeightField, Affine2)>,
    unit: f32,
}

impl DetailHeights {
    /// Copies the heights from an object, if its detail displaces.
    pub fn of(object: &Object) -> Option<Self> {
        let detail = object.detail.as_ref().filter(|detail| detail.displaces)?;
        Some(Self {
            heights: detail.heights.clone(),
            transform: detail.transform,
            mask: detail.mask.as_ref().map(|mask| (field_of(mask), mask.transform)),
            unit: if object.height_scale == 0.0 { 0.0 } else { 1.0 / object.height_scale },
        })
    }
}

/// Returns the level of a map whose texels are as wide as those of another map of `of` texels.
fn level_of(transform: Affine2, size: [u32; 2], of: Vec2) -> f32 {
    let size = Vec2::new(size[0] as f32, size[1] as f32);
    let [s, t] = [transform.matrix2.x_axis, transform.matrix2.y_axis].map(|axis| (axis * size).length());
    (s / of.x.max(1.0)).max(t / of.y.max(1.0)).max(1e-6).log2()
}

/// What scales and adds to the heights of an object, on the CPU.
pub struct HeightTerms<'a> {
    mesh: &'a PatchMesh,
    map: Option<(HeightPyramid<'a>, &'a FactorMap)>,
    lod: f32,
    /// The smallest and the largest factor of the map.
    of_map: [f32; 2],
    detail: Option<(HeightPyramid<'a>, &'a DetailHeights)>,
    detail_lod: f32,
    /// The lowest and the highest addition of the detail, which include 0, because its mask may be 0.
    added: [f32; 2],
}

/// Returns the smallest and the largest factor.
fn range_of(factors: &[f32]) -> [f32; 2] {
    factors.iter().fold([f32::INFINITY, 0.0f32], |[low, high], &factor| [low.min(factor), high.max(factor)])
}

impl<'a> HeightTerms<'a> {
    /// Creates the terms of an object's mesh. The first part of `map` has the texels of the second, and `heights` is the size of the
    /// height map in texels.
    pub fn new(
        mesh: &'a PatchMesh,
        map: Option<(&'a HeightField, &'a FactorMap)>,
        detail: Option<&'a DetailHeights>,
        heights: Vec2,
    ) -> Self {
        let size = |map: &HeightMap| [map.width, map.height];
        Self {
            mesh,
            lod: map.map_or(0.0, |(field, map)| level_of(map.transform, size(&field.map), heights)),
            of_map: map.map_or([1.0; 2], |(_, map)| range_of(&map.texels)),
            map: map.map(|(field, map)| (HeightPyramid::new(field), map)),
            added: detail.map_or([0.0; 2], |detail| {
                let heights = detail.heights.map.texels.iter().map(|height| height * detail.unit);
                heights.fold([0.0f32; 2], |[low, high], height| [low.min(height), high.max(height)])
            }),
            detail_lod: detail.map_or(0.0, |detail| level_of(detail.transform, size(&detail.heights.map), heights)),
            detail: detail.map(|detail| (HeightPyramid::new(&detail.heights), detail)),
        }
    }

    /// Returns the height of the surface at a point between two corners of a patch, where the map has this height. `spacing` is the
    /// level of the heights at the spacing of the samples, which may be negative.
    pub fn whole(&self, height: f32, patch: usize, [from, to]: [usize; 2], part: f32, spacing: f32) -> f32 {
        if self.is_one() {
            return height;
        }
        let [a, b] = [from, to].map(|corner| self.mesh.height_scale_of(self.mesh.patches[patch][corner] as usize));
        let texcoord = || self.mesh.texcoords[patch][from].lerp(self.mesh.texcoords[patch][to], part);
        let scale = self.map.as_ref().map_or(1.0, |(pyramid, map)| {
            let lookup = pyramid.lookup(spacing.max(0.0) + self.lod, patch);
            lookup.at(map.transform.transform_point2(texcoord()))
        });
        let added = self.detail.as_ref().map_or(0.0, |(pyramid, detail)| {
            let lookup = pyramid.lookup(spacing + self.detail_lod, patch);
            let masked =
                |(mask, transform): &(HeightField, Affine2)| mask.bilinear(transform.transform_point2(texcoord()));
            let share = detail.mask.as_ref().map_or(1.0, masked);
            lookup.at(detail.transform.transform_point2(texcoord())) * detail.unit * share
        });
        height * (a * (1.0 - part) + b * part) * scale + added
    }

    /// Returns bounds of the whole heights of a patch, where the map has heights in this range.
    pub fn range(&self, patch: usize, [low, high]: [f32; 2]) -> [f32; 2] {
        if self.is_one() {
            return [low, high];
        }
        // The least and the largest factor may meet any height.
        let [least, most] = self.factors(patch);
        [(low * least).min(low * most) + self.added[0], (high * least).max(high * most) + self.added[1]]
    }

    /// Returns how many times as many texels the finest map has along a line as the heights.
    pub fn finer(&self) -> f32 {
        if self.detail.is_some() { self.detail_lod.max(0.0).exp2() } else { 1.0 }
    }

    /// Returns the smallest and the largest factor on a patch.
    fn factors(&self, patch: usize) -> [f32; 2] {
        let of_vertices = self.mesh.patches[patch].map(|vertex| self.mesh.height_scale_of(vertex as usize));
        let ([a, b], [c, d]) = (range_of(&of_vertices), self.of_map);
        [a * c, b * d]
    }

    /// Whether the heights are those of the map.
    fn is_one(&self) -> bool {
        self.map.is_none() && self.detail.is_none() && self.mesh.height_scales.is_empty()
    }

    /// Returns the fields of the object's record.
    pub fn record(&self) -> HeightTermsRecord {
        let mean_square = |values: &[f32]| {
            let sum: f64 = values.iter().map(|&v| f64::from(v) * f64::from(v)).sum();
            if values.is_empty() { 1.0 } else { sum / values.len() as f64 }
        };
        let transform = self.map.as_ref().map(|(_, map)| map.transform).unwrap_or_default();
        let of_map = self.map.as_ref().map_or(1.0, |(_, map)| mean_square(&map.texels));
        HeightTermsRecord {
            linear: transform.matrix2.to_cols_array(),
            offset: transform.translation.to_array(),
            lod: self.lod,
            typical: (mean_square(&self.mesh.height_scales) * of_map).sqrt() as f32,
            detail_unit: self.detail.as_ref().map_or(0.0, |(_, detail)| detail.unit),
            detail_lod: self.detail_lod,
        }
    }
}

/// Returns the factors as a field that can be sampled like heights.
pub fn field_of(map: &FactorMap) -> HeightField {
    HeightField::repeating(HeightMap { width: map.width, height: map.height, texels: map.texels.clone() })
}

/// The map of a height scale on the device: the mean and the variance in each texel, with mips.
pub struct HeightScaleImage {
    /// The image.
    pub image: Image,
    /// Its sampler.
    pub sampler: Sampler,
}

impl HeightScaleImage {
    /// Uploads a map.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if the map has the wrong number of texels or a factor outside 0 to 1.
    pub fn new(gpu: &Arc<Gpu>, name: &str, map: &FactorMap) -> Result<Self> {
        let name = format!("{name} height scale");
        if u64::from(map.width) * u64::from(map.height) != map.texels.len() as u64 {
            let fault = format!("{} texels do not match {}x{}", map.texels.len(), map.width, map.height);
            return Err(GpuError::usage(name, fault));
        }
        if let Some(factor) = map.texels.iter().find(|factor| !(0.0..=1.0).contains(*factor)) {
            return Err(GpuError::usage(name, format!("{factor} is not a factor from 0 to 1")));
        }
        let image = Image::new(gpu, &name, ImageDesc::new(Format::R16G16_SFLOAT, map.width, map.height).full_mips())?;
        let squares = map.texels.iter().map(|&m| [m, m * m, 0.0, 0.0]).collect();
        write_mips(&image, [map.width, map.height], squares, means_and_variances, halve)?;
        Ok(Self { image, sampler: Sampler::new(gpu, Filter::Trilinear, AddressMode::Repeat)? })
    }
}

/// Converts means of factors and of their squares. The squares alone would lose small variances in 16 bits.
fn means_and_variances(texels: &[[f32; 4]]) -> Cow<'_, [[f16; 2]]> {
    texels.iter().map(|&[m, square, ..]| [m, (square - m * m).max(0.0)].map(f16::from_f32)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::{Affine2, Mat2, Vec3};

    #[test]
    fn edges_take_map_times_vertices() {
        let mesh = PatchMesh {
            positions: vec![Vec3::ZERO, Vec3::X, Vec3::new(1.0, 1.0, 0.0), Vec3::Y],
            normals: vec![Vec3::Z; 4],
            patches: vec![[0, 1, 2, 3]],
            texcoords: vec![[Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y]],
            height_scales: vec![1.0, 3.0, 3.0, 1.0],
            ..PatchMesh::default()
        };
        // The map covers two repeats, so its texels are twice as wide.
        let transform = Affine2::from_mat2(Mat2::from_diagonal(Vec2::splat(0.5)));
        let map = FactorMap { width: 8, height: 8, texels: (0..64).map(|i| (i % 8) as f32 / 8.0).collect(), transform };
        let field = field_of(&map);
        let scales = HeightTerms::new(&mesh, Some((&field, &map)), None, Vec2::splat(8.0));
        assert_eq!(scales.record().lod, -1.0);
        assert_eq!(scales.range(0, [-1.0, 2.0]), [-3.0 * 7.0 / 8.0, 6.0 * 7.0 / 8.0]);
        // At the middle of the first side, the map is read at 1/4, between texels 1 and 2.
        let middle = scales.whole(1.0, 0, [0, 1], 0.5, 0.0);
        assert!((middle - 2.0 * 1.5 / 8.0).abs() < 1e-6, "{middle}");
        assert_eq!(scales.whole(1.0, 0, [1, 0], 0.5, 0.0), middle);
        let alone = HeightTerms::new(&mesh, None, None, Vec2::splat(8.0));
        assert_eq!((alone.whole(1.0, 0, [0, 1], 0.25, 0.0), alone.record().typical), (1.5, 5f32.sqrt()));
    }

    #[test]
    fn variances_survive_sixteen_bits() {
        let spread = 1e-3f32;
        let texels = [[0.7 - spread, 0.0], [0.7 + spread, 0.0]].map(|[m, _]| [m, m * m, 0.0, 0.0]);
        let coarse = halve(&texels, [2, 1], [1, 1]);
        let [mean, variance] = means_and_variances(&coarse)[0].map(f32::from);
        assert!((mean - 0.7).abs() < 5e-4 && (variance / (spread * spread) - 1.0).abs() < 0.15, "{mean} {variance}");
        assert!(means_and_variances(&texels).iter().all(|[_, variance]| *variance == f16::ZERO));
    }
}
