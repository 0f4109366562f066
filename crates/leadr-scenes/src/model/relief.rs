//! The relief of a model: heights in metres over its texture coordinates or, without these, over generated coordinates.

use glam::{Vec2, Vec3};

use super::welds::Surface;
use crate::cover::{AnisotropySample, SampledMaterial, per_texel};
use leadr_maps::HeightMap;
use leadr_maps::material::Material;
use leadr_render::scene::Object;
use leadr_render::surfaces::displacement::HeightField;
use leadr_render::surfaces::patch_mesh::PatchMesh;
use leadr_render::surfaces::triplanar;

/// The number of map repeats along the diagonal of a model without texture coordinates.
const REPEATS: f32 = 8.0;

/// Whether the heights and the occlusion cones of a material are projected onto triangles without texture coordinates. They are not if other
/// textures use the coordinates.
pub fn is_projected(material: &Material) -> bool {
    let others = Material { relief: None, cones: None, ..material.clone() };
    material.relief.is_some() && others.coordinate_sets() == 0
}

/// Gives triangles without area in texture coordinates a projection along the axes, unless textures use their coordinates. If no triangle
/// of the mesh has area, the projection is triplanar. In other meshes, each triangle without area uses its dominant axis. `size` is the
/// diagonal of the model in metres.
pub fn project_bare_triangles(mesh: &mut PatchMesh, material: &Material, size: f32) {
    if !is_projected(material) {
        return;
    }
    let repeat = size / REPEATS;
    if mesh.texcoords.iter().all(|texcoords| chart_area(texcoords) == 0.0) {
        mesh.triplanar = Some(repeat);
        return;
    }
    for (patch, texcoords) in mesh.patches.iter().zip(&mut mesh.texcoords) {
        if chart_area(texcoords) != 0.0 {
            continue;
        }
        let corners = patch.map(|vertex| mesh.positions[vertex as usize]);
        let normal = (corners[1] - corners[0]).cross(corners[3] - corners[0]).normalize_or(Vec3::Z);
        let foremost = normal.abs().max_position();
        *texcoords = corners.map(|corner| triplanar::projections(corner, normal, repeat)[foremost].texcoord);
    }
}

/// Returns twice the area of a triangle in texture coordinates.
fn chart_area(t: &[Vec2; 4]) -> f32 {
    (t[1] - t[0]).perp_dot(t[3] - t[0]).abs()
}

/// Returns the metres per unit of texture coordinate over all triangles, or `None` if the coordinates have no area.
pub fn metres_per_unit(mesh: &PatchMesh) -> Option<f32> {
    if mesh.triplanar.is_some() {
        return mesh.triplanar;
    }
    let (mut metres, mut units) = (0.0f64, 0.0f64);
    for (patch, texcoords) in mesh.patches.iter().zip(&mesh.texcoords) {
        let corners = patch.map(|vertex| mesh.positions[vertex as usize]);
        let (area, chart) = ((corners[1] - corners[0]).cross(corners[3] - corners[0]).length(), chart_area(texcoords));
        if area > 0.0 && chart > 0.0 {
            metres += f64::from(area);
            units += f64::from(chart);
        }
    }
    (units > 0.0).then(|| (metres / units).sqrt() as f32)
}

/// Adds the heights and slopes of a material to an object.
pub fn with_relief(object: Object, material: &Material, sampled: &SampledMaterial, surface: &Surface) -> Object {
    let size = relief_size(material, sampled);
    let scale = match &material.relief {
        None => 0.0,
        Some(relief) => match relief.scale {
            Some(scale) => scale * surface.placement.scale(),
            None => metres_per_unit(&object.mesh).map_or(0.0, |repeat| sampled.unit(repeat) * repeat),
        },
    };
    let texels = per_texel(size, |at| (sampled.height(at) - sampled.middle) * scale);
    let object = object.with_heights(HeightField::repeating(HeightMap { width: size.0, height: size.1, texels }), 1.0);
    // Without normals, the slopes of heights come from triangles, and have no additional variance.
    let anisotropic = sampled.is_anisotropic() && (sampled.has_slopes() || !sampled.has_heights());
    if !sampled.has_slopes() && !anisotropic {
        return object;
    }
    let object = object.with_slopes(per_texel(size, |at| sampled.slope(at).to_array()));
    if !anisotropic {
        return object;
    }
    // The bitangent points in the direction opposite to t.
    object.with_slope_spread(per_texel(size, |at| {
        let AnisotropySample { along, variance } = sampled.anisotropy_at(at);
        [along.x * along.x, along.y * along.y, -along.x * along.y].map(|square| square * variance)
    }))
}

/// Returns the finer of the resolutions of the height map and the normal map.
fn relief_size(material: &Material, sampled: &SampledMaterial) -> (u32, u32) {
    if sampled.is_anisotropic() {
        return sampled.size;
    }
    let heights = material.relief.as_ref().map(|relief| (relief.map.width, relief.map.height));
    let normals = material.normal_map.as_ref().map(|map| (map.texture.raster.width(), map.texture.raster.height()));
    heights.into_iter().chain(normals).fold((1, 1), |a, b| (a.0.max(b.0), a.1.max(b.1)))
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_maps::HeightMap;

    fn triangle(corners: [Vec3; 3], texcoords: [Vec2; 3]) -> PatchMesh {
        let [a, b, c] = texcoords;
        PatchMesh {
            positions: corners.to_vec(),
            patches: vec![[0, 1, 2, 2]],
            texcoords: vec![[a, b, c, c]],
            triangles: true,
            ..PatchMesh::default()
        }
    }

    #[test]
    fn charts_are_measured() {
        let mesh = triangle([Vec3::ZERO, 3.0 * Vec3::X, 3.0 * Vec3::Y], [Vec2::ZERO, Vec2::Y * 0.5, Vec2::X * 0.5]);
        assert!((metres_per_unit(&mesh).unwrap() - 6.0).abs() < 1e-5);
        assert_eq!(metres_per_unit(&triangle([Vec3::ZERO, Vec3::X, Vec3::Y], [Vec2::ZERO; 3])), None);
    }

    #[test]
    fn bare_triangles_see_the_map_upright_from_outside() {
        let mut material = Material::new("bare");
        material.relief = Some(leadr_maps::material::Relief {
            map: HeightMap { width: 1, height: 1, texels: vec![0.0] },
            scale: None,
            in_widths: false,
            middle: 0.0,
        });
        let bare = triangle([Vec3::ZERO, Vec3::X, Vec3::Y], [Vec2::ZERO; 3]);
        let mut whole = bare.clone();
        project_bare_triangles(&mut whole, &material, REPEATS);
        assert_eq!((whole.triplanar, metres_per_unit(&whole)), (Some(1.0), Some(1.0)));
        // In a mesh with texture coordinates, each triangle without coordinates uses one axis. Charts are clockwise when seen from outside,
        // since t points down.
        for axis in [Vec3::X, Vec3::Y, Vec3::Z] {
            for outward in [axis, -axis] {
                let (a, b) = (outward.any_orthonormal_pair(), outward);
                assert!(a.0.cross(a.1).dot(b) > 0.99);
                let mut mesh = triangle([b, b + a.0, b + a.1], [Vec2::ZERO; 3]);
                mesh.patches.push([0, 1, 2, 2]);
                mesh.texcoords.push([Vec2::ZERO, Vec2::X, -Vec2::Y, -Vec2::Y]);
                project_bare_triangles(&mut mesh, &material, REPEATS);
                let t = mesh.texcoords[0];
                assert!(((t[1] - t[0]).perp_dot(t[3] - t[0]) + 1.0).abs() < 1e-5, "{outward}: {t:?}");
                assert_eq!(metres_per_unit(&mesh), Some(1.0));
            }
        }
    }
}
