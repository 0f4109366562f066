//! A sphere of patches without poles or seams, which works with any height map. Triplanar projections are blended into one tile per patch.

use super::height_scale::SampledScale;
use glam::{Vec2, Vec3};
use leadr_maps::HeightMap;
use leadr_maps::material::alpha_code;
use leadr_maps::srgb::srgb8_from_linear;
use leadr_render::scene::{MaterialMap, Object};
use leadr_render::surfaces::displacement::{Border, HeightField};
use leadr_render::surfaces::patch::{Patch, PatchPoint};
use leadr_render::surfaces::patch_mesh::{PatchMesh, TileLayout};
use leadr_render::surfaces::triplanar;
use rayon::prelude::*;

/// Builds a unit sphere of `6 · n²` patches from a cube, whose edges are divided into equal angles. Texture coordinates cover `[0, 1]²` on
/// each face, so the twelve cube edges are texture seams.
pub fn cube_sphere(n: u32, color: [f32; 4]) -> PatchMesh {
    let mut mesh = PatchMesh::default();
    let mut index = std::collections::HashMap::new();
    for face in 0..6usize {
        let mut vertex = |i: u32, j: u32| {
            let angle = |k: u32| (2 * k) as f32 / n as f32 - 1.0;
            // Integer keys identify vertices that the cube faces share exactly.
            let (a, b) = (2 * i as i32 - n as i32, 2 * j as i32 - n as i32);
            let key = face_axes(face, n as i32, a, b);
            *index.entry(key).or_insert_with(|| {
                let tangent = |k: u32| (angle(k) * std::f32::consts::FRAC_PI_4).tan();
                let p = Vec3::from(face_axes(face, 1.0, tangent(i), tangent(j))).normalize();
                mesh.positions.push(p);
                mesh.normals.push(p);
                (mesh.positions.len() - 1) as u32
            })
        };
        for j in 0..n {
            for i in 0..n {
                let corners = [(i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)];
                mesh.patches.push(corners.map(|(i, j)| vertex(i, j)));
                mesh.texcoords.push(corners.map(|(i, j)| Vec2::new(i as f32, j as f32) / n as f32));
            }
        }
    }
    mesh.colors = vec![color; mesh.positions.len()];
    mesh.accessibility = vec![1.0; mesh.positions.len()];
    mesh
}

fn face_axes<T: Copy + std::ops::Neg<Output = T>>(face: usize, one: T, a: T, b: T) -> [T; 3] {
    match face {
        0 => [one, a, b],
        1 => [-one, -a, b],
        2 => [-a, one, b],
        3 => [a, -one, b],
        4 => [a, b, one],
        _ => [a, -b, -one],
    }
}

/// Gives each patch of `mesh` a tile with `tile` texels per side.
pub fn layout_tiles(mesh: &mut PatchMesh, tile: u32) -> TileLayout {
    let layout = TileLayout::new(mesh.patches.len() as u32, tile);
    mesh.texcoords = (0..mesh.patches.len() as u32).map(|i| layout.texcoords(i)).collect();
    layout
}

/// Gives each patch of `mesh` a tile and fills it with `value(position, normal)` on the smooth surface. Returns the layout and the rows of
/// the atlas. The gutters of the tiles continue the surface beyond the patch.
pub fn bake_tiles<T: Copy + Default + Send + Sync>(
    mesh: &mut PatchMesh,
    tile: u32,
    value: impl Fn(Vec3, Vec3) -> T + Sync,
) -> (TileLayout, Vec<T>) {
    bake_patches(mesh, tile, |_, _, point| value(point.position, point.normal))
}

/// Like [`bake_tiles`], but calls `value(patch, uv, point)` with the patch index and the point's parameters `uv`, which are in `[0, 1]²`
/// or, in gutters, slightly outside.
pub fn bake_patches<T: Copy + Default + Send + Sync>(
    mesh: &mut PatchMesh,
    tile: u32,
    value: impl Fn(usize, Vec2, PatchPoint) -> T + Sync,
) -> (TileLayout, Vec<T>) {
    let layout = layout_tiles(mesh, tile);
    let mesh = &*mesh;
    let atlas = fill_tiles(&layout, mesh.patches.len(), |index| {
        let patch = mesh.patches[index];
        let surface = Patch::new(patch.map(|v| mesh.positions[v as usize]), patch.map(|v| mesh.normals[v as usize]));
        let texel = |i: u32| {
            let corner = Vec2::new((i % tile) as f32, (i / tile) as f32);
            let uv = (corner + 0.5 - layout.gutter as f32) / layout.inner() as f32;
            value(index, uv, surface.at(uv))
        };
        (0..tile * tile).map(texel).collect()
    });
    (layout, atlas)
}

/// Fills an atlas of `count` tiles, in rows of texels. `tile(index)` returns the rows of one tile.
pub fn fill_tiles<T: Copy + Default + Send + Sync>(
    layout: &TileLayout,
    count: usize,
    tile: impl Fn(usize) -> Vec<T> + Sync,
) -> Vec<T> {
    let (width, height) = layout.size();
    let (width, edge, columns) = (width as usize, layout.tile as usize, layout.columns as usize);
    let mut atlas = vec![T::default(); width * height as usize];
    atlas.par_chunks_mut(width * edge).enumerate().for_each(|(row, texels)| {
        for column in 0..columns.min(count - row * columns) {
            for (line, from) in texels.chunks_exact_mut(width).zip(tile(row * columns + column).chunks_exact(edge)) {
                line[column * edge..][..edge].copy_from_slice(from);
            }
        }
    });
    atlas
}

/// Converts tiles to a height field.
pub fn tiled(layout: TileLayout, texels: Vec<f32>) -> HeightField {
    let (width, height) = layout.size();
    HeightField { map: HeightMap { width, height, texels }, border: Border::Tiles(layout) }
}

/// Builds an object with heights in metres and colours, both stored in tiles.
pub fn tiled_object(
    name: &str,
    mesh: PatchMesh,
    layout: TileLayout,
    heights: Vec<f32>,
    colors: Vec<[u8; 4]>,
) -> Object {
    let (width, height) = layout.size();
    let material = MaterialMap::new(width, height, colors);
    Object::new(name, mesh).with_heights(tiled(layout, heights), 1.0).with_material(material)
}

/// Encodes a linear albedo and roughness `α` as a material map texel.
pub fn color_code(albedo: [f32; 3], alpha: f32) -> [u8; 4] {
    let [r, g, b] = albedo.map(srgb8_from_linear);
    [r, g, b, alpha_code(alpha)]
}

/// Builds a unit sphere that is displaced by a repeating map. One repeat covers `repeat` metres. Heights are in the units of the map,
/// relative to the mean of the map.
pub fn displaced_sphere(
    field: &HeightField,
    repeat: f32,
    n: u32,
    tile: u32,
    color: [f32; 4],
) -> (PatchMesh, HeightField) {
    scaled_sphere(field, &SampledScale::new(None), repeat, n, tile, color)
}

/// Like [`displaced_sphere`], with heights that are multiplied by `scale`.
pub fn scaled_sphere(
    field: &HeightField,
    scale: &SampledScale,
    repeat: f32,
    n: u32,
    tile: u32,
    color: [f32; 4],
) -> (PatchMesh, HeightField) {
    let mut mesh = cube_sphere(n, color);
    let mean = field.map.mean();
    let height = |t| {
        let (factor, _) = scale.at(t);
        field.bicubic(t) * factor + mean * (1.0 - factor)
    };
    let (layout, texels) = bake_tiles(&mut mesh, tile, |p, n| triplanar::blend(p, n, repeat, mean, height) - mean);
    (mesh, tiled(layout, texels))
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_render::surfaces::topology::Topology;

    #[test]
    fn the_sphere_is_closed_and_faces_outwards() {
        let mesh = cube_sphere(4, [0.5; 4]);
        assert_eq!(mesh.positions.len(), 6 * 16 + 2);
        assert_eq!(Topology::new(&mesh.patches).irregular_edges(), 0);
        for patch in &mesh.patches {
            let p = patch.map(|v| mesh.positions[v as usize]);
            let centre: Vec3 = p.iter().sum();
            assert!((p[2] - p[0]).cross(p[3] - p[1]).dot(centre) > 0.0);
        }
    }

    #[test]
    fn tiles_agree_on_shared_edges() {
        let texels = (0..256).map(|i| ((i * 29) % 17) as f32 / 17.0).collect();
        let bumps = HeightField::repeating(HeightMap { width: 16, height: 16, texels });
        let (mesh, field) = displaced_sphere(&bumps, 1.5, 4, 32, [0.5; 4]);
        let topology = Topology::new(&mesh.patches);
        // The texel beyond an edge continues into the neighbour, so the reconstructed heights on both sides agree.
        let Border::Tiles(layout) = field.border else { panic!() };
        let read = |patch: usize, side: usize, t: f32| {
            let c = layout.texcoords(patch as u32);
            let texcoord = c[side].lerp(c[(side + 1) & 3], t);
            field.bilinear(texcoord)
        };
        let mut first: Vec<Option<(usize, usize, bool)>> = vec![None; topology.edges.len()];
        let mut worst = 0.0f32;
        for (patch, edges) in topology.patch_edges.iter().enumerate() {
            for (side, code) in edges.iter().enumerate() {
                let (edge, flipped) = ((code >> 1) as usize, code & 1 == 1);
                if let Some((p, s, f)) = first[edge] {
                    for k in 1..8 {
                        let t = k as f32 / 8.0;
                        let at = |flipped: bool| if flipped { 1.0 - t } else { t };
                        worst = worst.max((read(p, s, at(f)) - read(patch, side, at(flipped))).abs());
                    }
                } else {
                    first[edge] = Some((patch, side, flipped));
                }
            }
        }
        assert!(worst < 0.01, "tiles disagree by {worst}");
    }
}
