//! A model's triangles in their material.

use super::charts::Charts;
use super::parts::Parts;
use super::places::Surface;
use super::relief::{cover_bare_triangles, with_relief};
use crate::cover::Cover;
use leadr_maps::material::{Material, TextureWrap};
use leadr_models::Model;
use leadr_render::constants::{CHART_COLORS, CHART_EMISSION, CHART_OCCLUSION, CHART_OPACITY};
use leadr_render::scene::{MaterialMap, Object};
use leadr_render::surfaces::patch_mesh::{PatchMesh, PosedVertices};

/// An object of the model, at rest in this pose.
pub fn object(
    model: &Model,
    parts: &Parts,
    surface: &Surface,
    (charts, material): &(Charts, Material),
    index: usize,
    rest: PosedVertices,
) -> Object {
    let (mut corners, mut at) = parts.triangles(model, index, charts);
    let places = surface.places.as_ref();
    if let Some(places) = places {
        let spanned: Vec<bool> = corners.iter().map(|&triangle| places.is_spanned(index, triangle)).collect();
        keep(&mut corners, &spanned);
        keep(&mut at.slopes, &spanned);
        at.images.iter_mut().for_each(|images| keep(images, &spanned));
    }
    let colors = parts.colors(model, index);
    let mut mesh = PatchMesh {
        accessibility: colors.iter().map(|color| color[3]).collect(),
        positions: rest.positions,
        normals: rest.normals,
        colors: colors.into_iter().map(|[r, g, b, _]| [r, g, b, 1.0]).collect(),
        patches: corners.into_iter().map(|[a, b, c]| [a, b, c, c]).collect(),
        texcoords: at.slopes.into_iter().map(|[a, b, c]| [a, b, c, c]).collect(),
        triangles: true,
        places: places.map_or(Vec::new(), |places| places.firsts(index)),
        rims: surface.rims.get(index).cloned().unwrap_or_default(),
        ..PatchMesh::default()
    };
    cover_bare_triangles(&mut mesh, material, surface.size);
    let cover = Cover::new(material);
    let image = |chart: u32| charts.images[chart as usize];
    let texels = cover.texels(image(CHART_OPACITY) == image(CHART_COLORS), |at| at);
    let wraps = [CHART_EMISSION, CHART_OCCLUSION, CHART_OPACITY].map(|chart| image(chart).wrap);
    let map = MaterialMap { wrap: image(CHART_COLORS).wrap, ..cover.map(cover.size, &texels) };
    let object = Object {
        charts: at.images,
        tints_emission: material.unlit,
        slope_wrap: (charts.slopes.wrap != [TextureWrap::Repeat; 2]).then_some(charts.slopes.wrap),
        // Steep relief may fold over itself; the backs of folds must not be holes.
        front_only: !material.double_sided && material.relief.is_none(),
        ..Object::new(format!("{} {}", model.name, material.name), mesh)
            .with_specular_f0(texels[0].body_f0)
            .with_conductor_dip(material.conductor_dip)
            .with_material(cover.with_light(map, wraps, |at| at))
    };
    if !cover.has_heights() && !cover.has_slopes() && !cover.is_brushed() {
        return object;
    }
    with_relief(object, material, &cover, surface)
}

/// Leaves those that are to be kept.
fn keep<T>(list: &mut Vec<T>, kept: &[bool]) {
    let mut flags = kept.iter();
    list.retain(|_| flags.next().copied().unwrap_or(true));
}
