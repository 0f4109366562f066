//! A quad that fills the picture, with one texel of its map per pixel. Nothing is filtered, and all pixels do the same work.
//! A measurement therefore shows only the fragment shader, as for the tables of the LEADR paper (section 7).

use glam::{Vec2, Vec3};

use leadr_maps::procedural;
use leadr_render::camera::Camera;
use leadr_render::scene::Object;
use leadr_render::surfaces::displacement::HeightField;
use leadr_render::surfaces::patch_mesh::PatchMesh;
use leadr_scenes::stage::{Stage, Views};

/// The vertical field of view in degrees. At the edges of a square picture, the view direction is up to 22° from the normal.
const FOV: f32 = 45.0;
/// The Beckmann roughness of the material.
const ROUGHNESS: f32 = 0.2;
/// The standard deviation of the map's slopes, along each axis.
const SLOPE: f32 = 0.5;

/// Returns a rectangle in the plane z = 0 with a Gaussian height map of `size` texels. Seen from above, the rectangle
/// exactly fills a picture of `size` pixels, and pixel centres coincide with texel centres at LOD 0. Draw the rectangle
/// without displacement, which would move parts out of the picture.
pub fn full_screen_stage(size: (u32, u32)) -> Stage {
    let (width, height) = (size.0.max(1), size.1.max(1));
    let half = Vec2::new(width as f32 / height as f32, 1.0);
    let corners = [Vec2::new(-1.0, -1.0), Vec2::new(1.0, -1.0), Vec2::ONE, Vec2::new(-1.0, 1.0)];
    let mesh = PatchMesh {
        positions: corners.iter().map(|&c| (c * half).extend(0.0)).collect(),
        normals: vec![Vec3::Z; 4],
        colors: vec![[0.5, 0.4, 0.3, ROUGHNESS]; 4],
        accessibility: vec![1.0; 4],
        patches: vec![[0, 1, 2, 3]],
        texcoords: vec![corners.map(|c| c * 0.5 + 0.5)],
        ..Default::default()
    };
    // A bump is six texels wide. The map's slopes are per unit texture coordinate, and one unit is the 2 m height of the
    // rectangle.
    let map = procedural::gaussian(width, height, 1, 2.0 * SLOPE, 6.0 / height as f32);
    let object = Object::new("full screen", mesh).with_heights(HeightField::repeating(map), 1.0).without_shadow();
    let distance = 1.0 / (FOV.to_radians() * 0.5).tan();
    let camera = Camera { up: Vec3::Y, ..Camera::looking_at(Vec3::Z * distance, Vec3::ZERO, FOV) };
    Stage::still(vec![object], Views { near: camera, mid: camera, far: camera })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn pixel_centres_fall_on_texel_centres() {
        for size in [(64u32, 64u32), (96, 32)] {
            let stage = full_screen_stage(size);
            let camera = stage.views.mid;
            let mesh = &stage.objects[0].mesh;
            let clip = camera.clip_from_world(size, Vec2::ZERO);
            for (corner, texcoord) in mesh.patches[0].iter().zip(&mesh.texcoords[0]) {
                let ndc = clip.project_point3(mesh.positions[*corner as usize]);
                // Rows of the picture run down, and rows of the map run up.
                let seen = Vec2::new(ndc.x, -ndc.y) * 0.5 + 0.5;
                assert!((seen - *texcoord).length() < 1e-6, "{seen} shows {texcoord}");
            }
            // The order is counter-clockwise from above, so the quad faces the viewer.
            let p: Vec<Vec3> = mesh.positions.clone();
            assert!((p[1] - p[0]).cross(p[3] - p[0]).z > 0.0);
        }
    }
}
