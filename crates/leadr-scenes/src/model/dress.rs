//! A model's triangles in their material.

use glam::Vec2;
use rayon::prelude::*;

use super::charts::Charts;
use super::parts::Parts;
use super::relief::{cover_bare_triangles, with_relief};
use super::surface::Surface;
use crate::cover::{Cover, Texel};
use crate::holes::filled;
use leadr_maps::material::TextureWrap;
use leadr_models::Model;
use leadr_render::constants::{CHART_COLORS, CHART_EMISSION, CHART_OCCLUSION, CHART_OPACITY};
use leadr_render::scene::{MaterialMap, Object};
use leadr_render::surfaces::patch_mesh::{PatchMesh, PosedVertices};

/// An object of the model, at rest in this pose.
pub fn object(model: &Model, parts: &Parts, surface: &Surface, index: usize, rest: PosedVertices) -> Object {
    let original = &model.materials[parts.objects[index].material];
    let (charts, material) = Charts::of(original, &|set| parts.reached(model, index, set));
    let (mut corners, mut at) = parts.triangles(model, index, &charts);
    let places = surface.places.as_ref();
    if let Some(places) = places {
        let spanned: Vec<bool> = corners.iter().map(|&triangle| places.is_spanned(index, triangle)).collect();
        keep(&mut corners, &spanned);
        keep(&mut at.slopes, &spanned);
        at.images.iter_mut().for_each(|images| keep(images, &spanned));
    }
    let mut mesh = PatchMesh {
        accessibility: parts.opacities(model, index),
        positions: rest.positions,
        normals: rest.normals,
        colors: parts.colors(model, index),
        patches: corners.into_iter().map(|[a, b, c]| [a, b, c, c]).collect(),
        texcoords: at.slopes.into_iter().map(|[a, b, c]| [a, b, c, c]).collect(),
        triangles: true,
        places: places.map_or(Vec::new(), |places| places.firsts(index)),
        rims: surface.rims.get(index).cloned().unwrap_or_default(),
        ..PatchMesh::default()
    };
    cover_bare_triangles(&mut mesh, &material, surface.size);
    let cover = Cover::new(&material);
    let (width, height) = cover.size;
    let size = Vec2::new(width as f32, height as f32);
    let place = |index: usize| {
        let [x, y] = [index % width as usize, index / width as usize].map(|k| k as f32 + 0.5);
        Vec2::new(x, y) / size
    };
    let places_of_texels = 0..width as usize * height as usize;
    let mut texels: Vec<Texel> = places_of_texels.into_par_iter().map(|index| cover.texel(place(index))).collect();
    let image = |chart: u32| charts.images[chart as usize];
    if cover.has_holes() && image(CHART_OPACITY) == image(CHART_COLORS) {
        texels = filled(&texels, [width, height], |index| cover.opacity(place(index)) >= cover.least_opacity());
    }
    let wraps = [CHART_EMISSION, CHART_OCCLUSION, CHART_OPACITY].map(|chart| image(chart).wrap);
    let map = MaterialMap { wrap: image(CHART_COLORS).wrap, ..cover.with_fit(Cover::map(width, height, &texels)) };
    let object = Object {
        charts: at.images,
        tints_emission: original.unlit,
        slope_wrap: (charts.slopes.wrap != [TextureWrap::Repeat; 2]).then_some(charts.slopes.wrap),
        // Steep relief may fold over itself; the backs of folds must not be holes.
        front_only: !original.double_sided && original.relief.is_none(),
        ..Object::new(format!("{} {}", model.name, material.name), mesh)
            .with_specular_f0(texels[0].body_f0)
            .with_conductor_dip(material.conductor_dip)
            .with_material(cover.light_maps(wraps, |at| at).with(map))
    };
    if !cover.has_heights() && !cover.has_slopes() && !cover.is_brushed() {
        return object;
    }
    with_relief(object, &material, &cover, surface)
}

/// Leaves those that are to be kept.
fn keep<T>(list: &mut Vec<T>, kept: &[bool]) {
    let mut flags = kept.iter();
    list.retain(|_| flags.next().copied().unwrap_or(true));
}
