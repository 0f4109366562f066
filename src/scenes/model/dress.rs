//! A model's triangles in their material.

use glam::Vec2;
use rayon::prelude::*;

use super::charts::Charts;
use super::parts::Parts;
use crate::maps::material::TextureWrap;
use crate::models::Model;
use crate::render::constants::{CHART_COLORS, CHART_EMISSION, CHART_OCCLUSION, CHART_OPACITY};
use crate::render::scene::{MaterialMap, Object};
use crate::render::surfaces::displacement::{Border, HeightField};
use crate::render::surfaces::patch_mesh::{PatchMesh, PosedVertices};
use crate::scenes::cover::{Cover, Texel};
use crate::scenes::holes::filled;

/// An object of the model, at rest in this pose.
pub fn object(model: &Model, parts: &Parts, index: usize, rest: PosedVertices) -> Object {
    let original = &model.materials[parts.objects[index].material];
    let (charts, material) = Charts::of(original, &|set| parts.reached(model, index, set));
    let (corners, places) = parts.triangles(model, index, &charts);
    let mesh = PatchMesh {
        accessibility: parts.opacities(model, index),
        positions: rest.positions,
        normals: rest.normals,
        colors: parts.colors(model, index),
        patches: corners.into_iter().map(|[a, b, c]| [a, b, c, c]).collect(),
        texcoords: places.slopes.into_iter().map(|[a, b, c]| [a, b, c, c]).collect(),
        triangles: true,
        ..PatchMesh::default()
    };
    let cover = Cover::new(&material);
    let (width, height) = cover.size;
    let size = Vec2::new(width as f32, height as f32);
    let place = |index: usize| {
        let [x, y] = [index % width as usize, index / width as usize].map(|k| k as f32 + 0.5);
        Vec2::new(x, y) / size
    };
    let places_of_texels = 0..width as usize * height as usize;
    let mut texels: Vec<Texel> =
        places_of_texels.clone().into_par_iter().map(|index| cover.texel(place(index))).collect();
    let image = |chart: u32| charts.images[chart as usize];
    if cover.has_holes() && image(CHART_OPACITY) == image(CHART_COLORS) {
        texels = filled(&texels, [width, height], |index| cover.opacity(place(index)) >= cover.least_opacity());
    }
    let wraps = [CHART_EMISSION, CHART_OCCLUSION, CHART_OPACITY].map(|chart| image(chart).wrap);
    let map = MaterialMap { wrap: image(CHART_COLORS).wrap, ..Cover::map(width, height, &texels) };
    let object = Object {
        charts: places.images,
        tints_emission: original.unlit,
        slope_wrap: (charts.slopes.wrap != [TextureWrap::Repeat; 2]).then_some(charts.slopes.wrap),
        front_only: !original.double_sided,
        ..Object::new(format!("{} {}", model.name, material.name), mesh)
            .with_specular_f0(texels[0].body_f0)
            .with_material(cover.light_maps(wraps, |at| at).with(map))
    };
    if !cover.has_slopes() {
        return object;
    }
    let flat = vec![0.0; places_of_texels.len()];
    object
        .with_heights(HeightField { width, height, texels: flat, border: Border::Wrap }, 1.0)
        .with_slopes(places_of_texels.into_par_iter().map(|index| cover.slope(place(index)).to_array()).collect())
}
