//! Converts a detail material, which repeats more often than its base, to the renderer's form.

use glam::{Affine2, Mat2, Vec2};

use super::cover::{SampledMaterial, per_texel};
use leadr_maps::HeightMap;
use leadr_maps::material::{MaterialDetail, Raster};
use leadr_render::scene::{Detail, DetailColors, DetailMapping, FactorMap, MaterialMap};
use leadr_render::surfaces::displacement::HeightField;

/// The direction of t in the coordinates of a surface.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Vertical {
    /// t points up, as on the plane.
    Up,
    /// t points down the image, as on models and in axis projections.
    Down,
}

/// Converts the detail of a surface that repeats every `metres`.
pub fn detail(layer: &MaterialDetail, mapping: DetailMapping, vertical: Vertical, metres: f32) -> Detail {
    let sampled = SampledMaterial::new(&layer.material);
    let (width, height) = sampled.size;
    // The number of metres per repeat of the detail, and per unit of height.
    let repeat = metres / layer.repeat;
    let unit = if sampled.has_heights() { sampled.unit(repeat) * repeat } else { 1.0 };
    let scale = unit * layer.height_scale;
    let texels = per_texel(sampled.size, |at| scale * (sampled.height(at) - sampled.middle));
    // Slopes are rise over run, and one unit of texture coordinate spans one repeat.
    let per_unit = repeat * layer.height_scale;
    let slopes = sampled.has_slopes().then(|| per_texel(sampled.size, |at| (sampled.slope(at) * per_unit).to_array()));
    let material = layer.colored.then(|| {
        let texels = sampled.texels(false, |at| at);
        let map = MaterialMap { f0: None, fit: None, ..sampled.map(sampled.size, &texels) };
        let f0 = texels.iter().map(|texel| texel.f0.iter().sum::<f32>() / 3.0).sum::<f32>() / texels.len() as f32;
        (map, if layer.mask.is_some() { DetailColors::Cover(f0) } else { DetailColors::Vary })
    });
    // A counter-clockwise rotation of the image rotates the lookup clockwise. In images, t points down.
    let flipped = Mat2::from_diagonal(Vec2::new(1.0, -1.0));
    let (to_up, onto_mask) = match vertical {
        Vertical::Up => (Mat2::IDENTITY, Affine2 { matrix2: flipped, translation: Vec2::Y }),
        Vertical::Down => (flipped, Affine2::IDENTITY),
    };
    let rotated = flipped * Mat2::from_angle(-layer.rotation.to_radians()) * to_up * layer.repeat;
    Detail {
        heights: HeightField::repeating(HeightMap { width, height, texels }),
        slopes,
        material,
        mapping,
        transform: Affine2::from_mat2(rotated),
        mask: layer.mask.as_ref().map(|mask| FactorMap { transform: onto_mask, ..factor_map(&mask.raster) }),
        displaces: layer.displaces,
    }
}

/// Returns the first channel of an image as factors over its own coordinates.
pub fn factor_map(raster: &Raster) -> FactorMap {
    let (width, height) = (raster.width(), raster.height());
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| raster.value(x, y, 0).clamp(0.0, 1.0))).collect();
    FactorMap { width, height, texels, transform: Affine2::IDENTITY }
}
