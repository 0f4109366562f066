//! The plane and the sphere with a user's material.

use glam::{Vec2, Vec3};

use super::cover::{AnisotropySample, SampledMaterial, Texel, coat_of, finest, medium_of, per_texel};
use super::detail::{Vertical, detail};
use super::height_scale::SampledScale;
use super::sphere::{bake_patches, cube_sphere, tiled};
use super::stage::{PLANE_REPEAT, SPHERE_REPEAT, Stage, plane_meshes, plane_views, sphere_views};
use leadr_maps::HeightMap;
use leadr_maps::material::{Material, TextureWrap};
use leadr_render::scene::{DetailMapping, FactorMap, MaterialMap, Object, PropertyMap};
use leadr_render::surfaces::atlas::frames::orthonormal;
use leadr_render::surfaces::displacement::HeightField;
use leadr_render::surfaces::patch::PatchPoint;
use leadr_render::surfaces::patch_mesh::{PatchMesh, TileLayout};
use leadr_render::surfaces::triplanar;

/// The vertex albedo and roughness that leave the material unchanged.
const UNTINTED: [f32; 4] = [1.0; 4];

/// The memory per texel for a material on the plane, in bytes, at least: the texel, its codes and its height.
pub const DRESSING: u64 = size_of::<Texel>() as u64 + 8 + 4;

/// Returns a plane whose maps have the sizes of the material's maps but no contents.
pub fn placeholder_plane(material: &Material) -> Object {
    let (width, height) = finest(material);
    let object = Object::new("plane", PatchMesh::default()).with_material(MaterialMap::new(width, height, Vec::new()));
    if material.relief.is_none()
        && material.normal_map.is_none()
        && material.anisotropy.is_none()
        && material.slope_moments.is_none()
    {
        return object;
    }
    object.with_heights(HeightField::repeating(HeightMap { width, height, texels: Vec::new() }), 1.0)
}

/// Builds an 8 m plane with a material. Seen from above with `+y` on top, the material is upright. The material repeats every `repeat`
/// metres, or every 2 metres by default.
pub fn plane_stage(material: &Material, repeat: Option<f32>) -> Stage {
    let metres = repeat.unwrap_or(PLANE_REPEAT);
    let sampled = SampledMaterial::new(material);
    let (width, height) = sampled.size;
    let upright = |at: Vec2| Vec2::new(at.x, 1.0 - at.y);
    let texels = sampled.texels(true, upright);
    let displacing = material.detail.as_deref().filter(|layer| layer.displaces);
    let has_relief = sampled.has_heights() || sampled.has_slopes() || sampled.is_anisotropic() || displacing.is_some();
    // Texels of the detail along one repeat of the material.
    let fine = displacing.map_or(0, |layer| {
        let (width, height) = SampledMaterial::new(&layer.material).size;
        (width.max(height) as f32 * layer.repeat).ceil() as u32
    });
    let (mesh, coarse) = plane_meshes(if has_relief { width.max(height).max(fine) } else { 0 }, metres, UNTINTED);
    let mut object =
        Object::new("plane", mesh).with_specular_f0(texels[0].diffuse_f0).with_edge_tint(material.edge_tint);
    object = object.with_coat(coat_of(material)).with_medium(medium_of(material, 1.0));
    let mut map = sampled.with_light(sampled.map(sampled.size, &texels), [[TextureWrap::Repeat; 2]; 3], upright);
    // The surface's t is the image's y, so the y coordinate of the cones is flipped as well.
    map.cones.iter_mut().flat_map(|cones| &mut cones.texels).for_each(|cone| cone[1] = -cone[1]);
    object = object.with_material(with_relief_maps(&sampled, map));
    if has_relief {
        object.coarse_mesh = coarse;
        // Heights in texture repeats, as in baked files, have the same slopes as the normals.
        let unit = sampled.unit(metres);
        let heights = per_texel(sampled.size, |at| sampled.height(upright(at)) * unit - sampled.middle * unit);
        let field = HeightField::repeating(HeightMap { width, height, texels: heights });
        object = object.with_heights(field, metres);
        if sampled.has_slopes() || sampled.is_anisotropic() {
            object = object.with_slopes(per_texel(sampled.size, |at| {
                let slope = sampled.relief_slope(upright(at), unit);
                [slope.x, -slope.y]
            }));
        }
        if sampled.is_anisotropic() || sampled.has_slope_spread() {
            object = object.with_slope_spread(per_texel(sampled.size, |at| {
                let [ss, tt, st] = sampled.slope_spread(upright(at), unit);
                let base = spread_of(sampled.anisotropy_at(upright(at)), |along| along);
                [base[0] + ss, base[1] + tt, base[2] - st]
            }));
        }
    }
    if let Some(layer) = &material.detail {
        object = object.with_detail(detail(layer, DetailMapping::Texcoords, Vertical::Up, metres));
    }
    Stage::still(vec![object], plane_views())
}

/// Returns the slope variance that the anisotropy adds. `units` converts a direction to slopes by texture coordinate, in the unit of the
/// heights.
fn spread_of(sample: AnisotropySample, units: impl Fn(Vec2) -> Vec2) -> [f32; 3] {
    let along = units(sample.along);
    [along.x * along.x, along.y * along.y, along.x * along.y].map(|square| square * sample.variance)
}

/// The material data of one texel in a tile of the sphere.
#[derive(Clone, Copy, Default)]
struct Baked {
    texel: Texel,
    height: f32,
    slope: [f32; 2],
    emission: [f32; 3],
    accessibility: f32,
    /// The occlusion cone, along the sides of the tile: `s`, `-t` and the normal, and the accessibility.
    cone: [f32; 4],
    opacity: f32,
    spread: [f32; 3],
}

/// Exponent of the blend weights. Projections blend within a few degrees, because a wider blend shows every joint between bricks twice.
const SHARPNESS: i32 = 4;

/// Builds a unit sphere with a material, by blended triplanar mapping. It repeats every `repeat` metres; default 1.2.
pub fn sphere_stage(material: &Material, repeat: Option<f32>, tile: u32) -> Stage {
    scaled_sphere_stage(material, repeat, tile, None)
}

/// Like [`sphere_stage`], with heights that are multiplied by `scale`, a map over the images of the material.
pub fn scaled_sphere_stage(material: &Material, repeat: Option<f32>, tile: u32, scale: Option<&FactorMap>) -> Stage {
    let metres = repeat.unwrap_or(SPHERE_REPEAT);
    let sampled = SampledMaterial::new(material);
    // The number of texture repeats per unit of height, as in baked files.
    let unit = sampled.unit(metres);
    let smooth = material.relief.as_ref().map(|relief| {
        let mut field = HeightField::repeating(relief.map.clone());
        field.map.texels.iter_mut().for_each(|height| *height *= unit);
        field
    });
    let scale = SampledScale::new(scale);
    let mut mesh = cube_sphere(16, UNTINTED);
    // The scale from patch parameters to texture coordinates.
    let layout = TileLayout::new(mesh.patches.len() as u32, tile);
    let (width, height) = layout.size();
    let per_patch = Vec2::new(width as f32, height as f32) / layout.inner() as f32;
    // Converts a slope vector of the tangent space to slopes by texture coordinate, in the unit of the heights.
    let by_texcoord =
        |slope: Vec3, point: &PatchPoint| Vec2::new(slope.dot(point.du), slope.dot(point.dv)) * per_patch / metres;
    let (_, baked) = bake_patches(&mut mesh, tile, |_, _, point| {
        let (mut baked, mut gradient, mut open) = (Baked::default(), Vec3::ZERO, Vec3::ZERO);
        let mut weights = triplanar::projections(point.position, point.normal, metres);
        weights.iter_mut().for_each(|seen| seen.weight = seen.weight.powi(SHARPNESS));
        let squares: f32 = weights.iter().map(|w| w.weight * w.weight).sum();
        let sum: f32 = weights.iter().map(|w| w.weight).sum();
        for seen in weights.iter().filter(|seen| seen.weight > 0.0) {
            let at = seen.texcoord;
            let share = seen.weight / sum;
            baked.texel = baked.texel.plus(share, sampled.texel(at));
            let emission = sampled.emission(at);
            baked.emission = std::array::from_fn(|i| baked.emission[i] + share * emission[i]);
            baked.accessibility += share * sampled.accessibility(at);
            if let Some([x, y, z, seen_share]) = sampled.cone(at) {
                let [s, t] = orthonormal([seen.s, seen.t].map(|axis| axis.reject_from_normalized(point.normal)));
                open += share * (s * x - t * y);
                baked.cone[2] += share * z;
                baked.cone[3] += share * seen_share;
            }
            baked.opacity += share * sampled.opacity(at);
            // With this weight, the blended relief has the variance of the original relief.
            let weight = seen.weight / squares.sqrt();
            let height = smooth.as_ref().map_or(0.0, |field| field.bicubic(at) - sampled.middle * unit);
            let (factor, change) = scale.at(at);
            baked.height += weight * height * factor;
            let slope = (sampled.relief_slope(at, unit) * factor + height * change) * weight;
            gradient += slope.x * seen.s + slope.y * seen.t;
            if sampled.has_slope_spread() {
                let [ss, tt, st] = sampled.slope_spread(at, unit).map(|spread| spread * factor * factor);
                let [s, t] = [seen.s, seen.t].map(|axis| weight * by_texcoord(axis, &point));
                let product = |a: Vec2, b: Vec2| [a.x * b.x, a.y * b.y, 0.5 * (a.x * b.y + a.y * b.x)];
                for (variance, product) in [(ss, product(s, s)), (tt, product(t, t)), (2.0 * st, product(s, t))] {
                    (0..3).for_each(|i| baked.spread[i] += variance * product[i]);
                }
            }
            if sampled.is_anisotropic() {
                // The anisotropy follows the rotation of a lathe, from east to north.
                let east = Vec3::Z.cross(point.normal).normalize_or(Vec3::X);
                let north = point.normal.cross(east);
                let spread =
                    spread_of(sampled.anisotropy_at(at), |along| by_texcoord(along.x * east + along.y * north, &point));
                (0..3).for_each(|i| baked.spread[i] += seen.weight / sum * spread[i]);
            }
        }
        baked.slope = by_texcoord(gradient, &point).to_array();
        let [s, t] = orthonormal([point.du, point.dv]);
        (baked.cone[0], baked.cone[1]) = (s.dot(open), -t.dot(open));
        baked
    });
    // Unused tiles copy a real texel, so that they do not count as a second class of surface.
    let first = baked[0].texel;
    let texels: Vec<Texel> = baked.iter().map(|b| if b.texel == Texel::default() { first } else { b.texel }).collect();
    let mut object = Object::new("sphere", mesh).with_specular_f0(first.diffuse_f0).with_edge_tint(material.edge_tint);
    object = object.with_coat(coat_of(material)).with_medium(medium_of(material, 1.0));
    let map = MaterialMap {
        emission: sampled.emits().then(|| property(layout, &baked, |b| b.emission)),
        occlusion: sampled.is_occluded().then(|| property(layout, &baked, |b| b.accessibility)),
        cones: sampled.has_cones().then(|| property(layout, &baked, |b| b.cone)),
        opacity: sampled
            .has_cutouts()
            .then(|| property(layout, &baked, |b| b.opacity))
            .and_then(|map| sampled.cutout(map)),
        ..sampled.map(layout.size(), &texels)
    };
    object = object
        .with_material(with_relief_maps(&sampled, map))
        .with_heights(tiled(layout, baked.iter().map(|b| b.height).collect()), metres);
    if sampled.has_slopes() || sampled.is_anisotropic() {
        object = object.with_slopes(baked.iter().map(|b| b.slope).collect());
    }
    if sampled.is_anisotropic() || sampled.has_slope_spread() {
        object = object.with_slope_spread(baked.iter().map(|b| b.spread).collect());
    }
    if let Some(layer) = &material.detail {
        object = object.with_detail(detail(layer, DetailMapping::Triplanar(metres), Vertical::Down, metres));
    }
    Stage::still(vec![object], sphere_views())
}

/// Extracts one property from the texels of the tiles.
fn property<T>(layout: TileLayout, baked: &[Baked], of: impl Fn(&Baked) -> T) -> PropertyMap<T> {
    let (width, height) = layout.size();
    PropertyMap { width, height, texels: baked.iter().map(of).collect(), wrap: [TextureWrap::Clamp; 2] }
}

/// Removes the occlusion map of a surface with heights, because the relief's self-occlusion already follows from the heights.
fn with_relief_maps(sampled: &SampledMaterial, map: MaterialMap) -> MaterialMap {
    MaterialMap { occlusion: map.occlusion.filter(|_| !sampled.has_heights()), ..map }
}
