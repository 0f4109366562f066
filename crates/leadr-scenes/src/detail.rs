//! A material that lies over another and repeats more often, as the renderer takes it.

use glam::{Affine2, Mat2, Vec2};

use super::cover::{Cover, per_texel};
use leadr_maps::HeightMap;
use leadr_maps::material::{MaterialDetail, Texture};
use leadr_render::scene::{Detail, DetailColors, DetailMapping, DetailMask, MaterialMap};
use leadr_render::surfaces::displacement::HeightField;

/// The detail of a surface whose coordinates repeat after so many metres. Texture coordinates run up a picture, views along the axes down.
pub fn detail(layer: &MaterialDetail, mapping: DetailMapping, metres: f32) -> Detail {
    let cover = Cover::new(&layer.material);
    let (width, height) = cover.size;
    // Metres of one repeat, and of a unit of height.
    let repeat = metres / layer.repeat;
    let unit = if cover.has_heights() { cover.unit(repeat) * repeat } else { 1.0 };
    let scale = unit * layer.height_scale;
    let texels = per_texel(cover.size, |at| scale * (cover.height(at) - cover.middle));
    // Slopes are rise over run; the run of a unit of the coordinates is a repeat.
    let per_unit = repeat * layer.height_scale;
    let slopes = cover.has_slopes().then(|| per_texel(cover.size, |at| (cover.slope(at) * per_unit).to_array()));
    let material = layer.colored.then(|| {
        let texels = cover.texels(false, |at| at);
        let map = MaterialMap { f0: None, two_lobes: None, fit: None, ..cover.map(cover.size, &texels) };
        let f0 = texels.iter().map(|texel| texel.f0.iter().sum::<f32>() / 3.0).sum::<f32>() / texels.len() as f32;
        (map, if layer.mask.is_some() { DetailColors::Cover(f0) } else { DetailColors::Vary })
    });
    // Upright, turned counter-clockwise: the picture is looked up at places turned back, t down.
    let flipped = Mat2::from_diagonal(Vec2::new(1.0, -1.0));
    let (to_up, onto_mask) = match mapping {
        DetailMapping::Texcoords => (Mat2::IDENTITY, Affine2 { matrix2: flipped, translation: Vec2::Y }),
        DetailMapping::Triplanar(_) => (flipped, Affine2::IDENTITY),
    };
    let turned = flipped * Mat2::from_angle(-layer.rotation.to_radians()) * to_up * layer.repeat;
    Detail {
        heights: HeightField::repeating(HeightMap { width, height, texels }),
        slopes,
        material,
        mapping,
        transform: Affine2::from_mat2(turned),
        mask: layer.mask.as_ref().map(|mask| DetailMask { transform: onto_mask, ..mask_of(mask) }),
    }
}

fn mask_of(texture: &Texture) -> DetailMask {
    let raster = &texture.raster;
    let (width, height) = (raster.width(), raster.height());
    let texels = (0..height).flat_map(|y| (0..width).map(move |x| raster.value(x, y, 0).clamp(0.0, 1.0))).collect();
    DetailMask { width, height, texels, transform: Affine2::IDENTITY }
}
