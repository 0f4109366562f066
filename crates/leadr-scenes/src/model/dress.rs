//! Builds render objects from a model's triangles and materials.

use super::charts::Charts;
use super::parts::Parts;
use super::relief::{metres_per_unit, project_bare_triangles, with_relief};
use super::welds::Surface;
use crate::cover::{SampledMaterial, coat_of, medium_of};
use crate::detail::Vertical;
use leadr_maps::material::{Material, TextureWrap};
use leadr_models::Model;
use leadr_render::constants::{CHART_COLORS, CHART_EMISSION, CHART_OCCLUSION, CHART_OPACITY};
use leadr_render::scene::{DetailMapping, MaterialMap, Object};
use leadr_render::surfaces::patch_mesh::{PatchMesh, PosedVertices};

/// Builds one object of the model. The rest vertices of the object are those of this pose.
pub fn object(
    model: &Model,
    parts: &Parts,
    surface: &Surface,
    (charts, material): &(Charts, Material),
    index: usize,
    rest: PosedVertices,
) -> Object {
    let (mut corners, mut at) = parts.triangles(model, index, charts);
    let welds = surface.welds.as_ref();
    if let Some(welds) = welds {
        let spanned: Vec<bool> = corners.iter().map(|&triangle| welds.is_spanned(index, triangle)).collect();
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
        height_scales: parts.height_scales(model, index),
        patches: corners.into_iter().map(|[a, b, c]| [a, b, c, c]).collect(),
        texcoords: at.slopes.into_iter().map(|[a, b, c]| [a, b, c, c]).collect(),
        triangles: true,
        welds: welds.map_or(Vec::new(), |welds| welds.firsts(index)),
        rims: surface.rims.get(index).cloned().unwrap_or_default(),
        ..PatchMesh::default()
    };
    project_bare_triangles(&mut mesh, material, surface.size);
    let sampled = SampledMaterial::new(material);
    let image = |chart: u32| charts.images[chart as usize];
    let texels = sampled.texels(image(CHART_OPACITY) == image(CHART_COLORS), |at| at);
    let wraps = [CHART_EMISSION, CHART_OCCLUSION, CHART_OPACITY].map(|chart| image(chart).wrap);
    let wrap = image(CHART_COLORS).wrap;
    let map = MaterialMap { wrap, coat: sampled.coat_map(wrap), ..sampled.map(sampled.size, &texels) };
    let object = Object {
        charts: at.images,
        tints_emission: material.unlit,
        slope_wrap: (charts.slopes.wrap != [TextureWrap::Repeat; 2]).then_some(charts.slopes.wrap),
        // Steep relief can fold over itself. If the back faces of folds were culled, there would be gaps.
        front_only: !material.double_sided && material.relief.is_none(),
        ..Object::new(format!("{} {}", model.name, material.name), mesh)
            .with_specular_f0(texels[0].diffuse_f0)
            .with_edge_tint(material.edge_tint)
            .with_coat(coat_of(material))
            .with_medium(medium_of(material, surface.placement.scale()))
            .with_material(sampled.with_light(map, wraps, |at| at))
    };
    let detail = material.detail.as_ref().zip(metres_per_unit(&object.mesh));
    if !sampled.has_heights() && !sampled.has_slopes() && !sampled.is_anisotropic() && detail.is_none() {
        return object;
    }
    let object = with_relief(object, material, &sampled, surface);
    match detail {
        Some((layer, metres)) => {
            object.with_detail(crate::detail::detail(layer, DetailMapping::Texcoords, Vertical::Down, metres))
        }
        None => object,
    }
}

/// Removes the entries that are not marked in `kept`.
fn keep<T>(list: &mut Vec<T>, kept: &[bool]) {
    let mut flags = kept.iter();
    list.retain(|_| flags.next().copied().unwrap_or(true));
}
