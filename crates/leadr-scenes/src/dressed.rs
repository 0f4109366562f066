//! The plane and the sphere in a material of the user's.

use glam::{Vec2, Vec3};

use super::cover::{Cover, Stroke, Texel, finest, per_texel};
use super::detail::detail;
use super::sphere::{bake_patches, cube_sphere, tiled};
use super::stage::{PLANE_REPEAT, SPHERE_REPEAT, Stage, plane_meshes, plane_views, sphere_views};
use leadr_maps::HeightMap;
use leadr_maps::material::{Material, TextureWrap};
use leadr_render::scene::{DetailMapping, MaterialMap, Object, PropertyMap};
use leadr_render::surfaces::displacement::HeightField;
use leadr_render::surfaces::patch::PatchPoint;
use leadr_render::surfaces::patch_mesh::{PatchMesh, TileLayout};
use leadr_render::surfaces::triplanar;

/// Albedo and roughness of the vertices: the material's own.
const UNTINTED: [f32; 4] = [1.0; 4];

/// Bytes of memory for each texel of the plane while it is dressed, at least: the material there, its codes and its height.
pub const DRESSING: u64 = size_of::<Texel>() as u64 + 8 + 4;

/// The plane before it is dressed: its maps have sizes and nothing else.
pub fn undressed_plane(material: &Material) -> Object {
    let (width, height) = finest(material);
    let object = Object::new("plane", PatchMesh::default()).with_material(MaterialMap::new(width, height, Vec::new()));
    if material.relief.is_none() && material.normal_map.is_none() && material.anisotropy.is_none() {
        return object;
    }
    object.with_heights(HeightField::repeating(HeightMap { width, height, texels: Vec::new() }), 1.0)
}

/// A plane of 8 m in a material, which repeats every 2 m or after so many metres, and is seen upright from above with `+y` on top.
pub fn plane_stage(material: &Material, repeat: Option<f32>) -> Stage {
    let metres = repeat.unwrap_or(PLANE_REPEAT);
    let cover = Cover::new(material);
    let (width, height) = cover.size;
    let upright = |at: Vec2| Vec2::new(at.x, 1.0 - at.y);
    let texels = cover.texels(true, upright);
    let has_relief = cover.has_heights() || cover.has_slopes() || cover.is_brushed();
    let (mesh, coarse) = plane_meshes(if has_relief { width.max(height) } else { 0 }, metres, UNTINTED);
    let mut object =
        Object::new("plane", mesh).with_specular_f0(texels[0].body_f0).with_conductor_dip(material.conductor_dip);
    let mut map = cover.with_light(cover.map(cover.size, &texels), [[TextureWrap::Repeat; 2]; 3], upright);
    // As upright as the picture: its y is the surface's t.
    map.cones.iter_mut().flat_map(|cones| &mut cones.texels).for_each(|cone| cone[1] = -cone[1]);
    object = object.with_material(beside_heights(&cover, map));
    if has_relief {
        object.coarse_mesh = coarse;
        // In repeats of the textures, as baked files have them, so that slopes are those of the normals.
        let unit = cover.unit(metres);
        let heights = per_texel(cover.size, |at| cover.height(upright(at)) * unit - cover.middle * unit);
        let field = HeightField::repeating(HeightMap { width, height, texels: heights });
        object = object.with_heights(field, metres);
        if cover.has_slopes() || cover.is_brushed() {
            object = object.with_slopes(per_texel(cover.size, |at| {
                let slope = cover.relief_slope(upright(at), unit);
                [slope.x, -slope.y]
            }));
        }
        if cover.is_brushed() {
            let spread = |at| spread_of(cover.stroke(upright(at)), |along| along);
            object = object.with_slope_spread(per_texel(cover.size, spread));
        }
    }
    if let Some(layer) = &material.detail {
        object = object.with_detail(detail(layer, DetailMapping::Texcoords, metres));
    }
    Stage::still(vec![object], plane_views())
}

/// Variance of slopes along a stroke, whose direction `units` turns into slopes by texture coordinate in the heights' unit.
fn spread_of(stroke: Stroke, units: impl Fn(Vec2) -> Vec2) -> [f32; 3] {
    let along = units(stroke.along);
    [along.x * along.x, along.y * along.y, along.x * along.y].map(|square| square * stroke.variance)
}

/// What a tile of the sphere holds at a texel.
#[derive(Clone, Copy, Default)]
struct Baked {
    texel: Texel,
    height: f32,
    slope: [f32; 2],
    emission: [f32; 3],
    accessibility: f32,
    opacity: f32,
    spread: [f32; 3],
}

/// A unit sphere in a material, seen along the three axes and blended; it repeats every 1.2 m or after so many metres.
pub fn sphere_stage(material: &Material, repeat: Option<f32>, tile: u32) -> Stage {
    let metres = repeat.unwrap_or(SPHERE_REPEAT);
    let cover = Cover::new(material);
    // In repeats of the textures, as baked files have them.
    let unit = cover.unit(metres);
    let smooth = material.relief.as_ref().map(|relief| {
        let mut field = HeightField::repeating(relief.map.clone());
        field.map.texels.iter_mut().for_each(|height| *height *= unit);
        field
    });
    let mut mesh = cube_sphere(16, UNTINTED);
    // Texture coordinates by places on a patch.
    let layout = TileLayout::new(mesh.patches.len() as u32, tile);
    let (width, height) = layout.size();
    let per_patch = Vec2::new(width as f32, height as f32) / layout.inner() as f32;
    // A tangent vector of slopes, by texture coordinate and in the heights' unit.
    let by_texcoord =
        |slope: Vec3, point: &PatchPoint| Vec2::new(slope.dot(point.du), slope.dot(point.dv)) * per_patch / metres;
    let (_, baked) = bake_patches(&mut mesh, tile, |_, _, point| {
        let (mut baked, mut gradient) = (Baked::default(), Vec3::ZERO);
        let weights = triplanar::projections(point.position, point.normal, metres);
        let squares: f32 = weights.iter().map(|w| w.weight * w.weight).sum();
        let sum: f32 = weights.iter().map(|w| w.weight).sum();
        for seen in weights.iter().filter(|seen| seen.weight > 0.0) {
            let at = seen.texcoord;
            let share = seen.weight / sum;
            baked.texel = baked.texel.plus(share, cover.texel(at));
            let emission = cover.emission(at);
            baked.emission = std::array::from_fn(|i| baked.emission[i] + share * emission[i]);
            baked.accessibility += share * cover.accessibility(at);
            baked.opacity += share * cover.opacity(at);
            // Relief keeps its variance where it is blended.
            let weight = seen.weight / squares.sqrt();
            baked.height += weight * smooth.as_ref().map_or(0.0, |field| field.bicubic(at) - cover.middle * unit);
            let slope = cover.relief_slope(at, unit) * weight;
            gradient += slope.x * seen.s + slope.y * seen.t;
            if cover.is_brushed() {
                // As on a lathe: from the east towards the north.
                let east = Vec3::Z.cross(point.normal).normalize_or(Vec3::X);
                let north = point.normal.cross(east);
                let spread = spread_of(cover.stroke(at), |along| by_texcoord(along.x * east + along.y * north, &point));
                (0..3).for_each(|i| baked.spread[i] += seen.weight / sum * spread[i]);
            }
        }
        baked.slope = by_texcoord(gradient, &point).to_array();
        baked
    });
    // Tiles without a patch are never seen, but must not look like a second kind of surface.
    let first = baked[0].texel;
    let texels: Vec<Texel> = baked.iter().map(|b| if b.texel == Texel::default() { first } else { b.texel }).collect();
    let mut object =
        Object::new("sphere", mesh).with_specular_f0(first.body_f0).with_conductor_dip(material.conductor_dip);
    let map = MaterialMap {
        emission: cover.emits().then(|| property(layout, &baked, |b| b.emission)),
        // Tiles keep the share alone.
        occlusion: cover.is_occluded().then(|| property(layout, &baked, |b| b.accessibility)),
        opacity: cover.has_holes().then(|| property(layout, &baked, |b| b.opacity)).and_then(|map| cover.holes(map)),
        ..cover.map(layout.size(), &texels)
    };
    object = object
        .with_material(beside_heights(&cover, map))
        .with_heights(tiled(layout, baked.iter().map(|b| b.height).collect()), metres);
    if cover.has_slopes() || cover.is_brushed() {
        object = object.with_slopes(baked.iter().map(|b| b.slope).collect());
    }
    if cover.is_brushed() {
        object = object.with_slope_spread(baked.iter().map(|b| b.spread).collect());
    }
    if let Some(layer) = &material.detail {
        object = object.with_detail(detail(layer, DetailMapping::Triplanar(metres), metres));
    }
    Stage::still(vec![object], sphere_views())
}

/// A property of what tiles hold.
fn property<T>(layout: TileLayout, baked: &[Baked], of: impl Fn(&Baked) -> T) -> PropertyMap<T> {
    let (width, height) = layout.size();
    PropertyMap { width, height, texels: baked.iter().map(of).collect(), wrap: [TextureWrap::Clamp; 2] }
}

/// The same where a relief is drawn: what its bumps hide from each other follows from their heights, and a picture of the same occlusion
/// would count it twice.
fn beside_heights(cover: &Cover, map: MaterialMap) -> MaterialMap {
    MaterialMap { occlusion: map.occlusion.filter(|_| !cover.has_heights()), ..map }
}
