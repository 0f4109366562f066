//! A coiled snake on dry ground, lit by the sky and four lamps (after LEADR Figure 9).

mod body;
mod scales;

use std::f32::consts::TAU;

use glam::{Vec2, Vec3};

use self::body::{ALONG, AROUND, Body};
use super::ground::ground;
use super::sphere::{bake_patches, color_code, cube_sphere, tiled_object};
use super::stage::{Stage, Views};
use leadr_render::camera::Camera;
use leadr_render::scene::{Object, PointLight};
use leadr_render::surfaces::patch_mesh::PatchMesh;

/// Returns the body angle and the ring index of a point on a patch, as continuous values.
fn parameters(patch: usize, uv: Vec2) -> Vec2 {
    let (along, around) = (patch / AROUND as usize, patch % AROUND as usize);
    Vec2::new((around as f32 + uv.x) / AROUND as f32 * TAU, along as f32 + uv.y)
}

/// Interpolates linearly between rings, and extrapolates beyond the ends.
fn at_ring(values: &[f32], ring: f32) -> f32 {
    let k = (ring.floor().max(0.0) as usize).min(values.len() - 2);
    values[k] + (values[k + 1] - values[k]) * (ring - k as f32)
}

/// Builds the body with its skin, in atlas tiles of `tile` texels.
fn body_object(body: &Body, tile: u32) -> Object {
    let mut mesh = body.mesh();
    let widths: Vec<f32> = body.rings.iter().map(|r| TAU * 0.5 * (r.half.x + r.half.y) / scales::AROUND).collect();
    let tube = (ALONG * AROUND) as usize;
    let (layout, texels) = bake_patches(&mut mesh, tile, |patch, uv, point| {
        let parameter = if patch < tube {
            parameters(patch, uv)
        } else {
            // On end caps, the angle is the direction to the axis.
            let k = if patch < tube + AROUND as usize / 2 { 0 } else { ALONG as usize };
            let (ring, offset) = (body.rings[k], point.position - body.rings[k].centre);
            Vec2::new(offset.dot(ring.up).atan2(offset.dot(ring.left)), k as f32)
        };
        let x = at_ring(&body.distance, parameter.y) / body.length();
        let skin = scales::skin(parameter.x, at_ring(&body.girths, parameter.y), x);
        let fade = if patch < tube { (parameter.y.min(ALONG as f32 - parameter.y) / 1.5).clamp(0.0, 1.0) } else { 0.0 };
        let height = skin.height * at_ring(&widths, parameter.y).max(0.0) * fade;
        (height, color_code(skin.color.to_array(), skin.roughness))
    });
    shade_contacts(body, &mut mesh);
    let (heights, colors) = texels.into_iter().unzip();
    tiled_object("snake", mesh, layout, heights, colors).with_specular_f0(0.045)
}

/// Computes the ambient accessibility: the fraction of the surroundings that is visible above the ground and between the turns of the body.
fn shade_contacts(body: &Body, mesh: &mut PatchMesh) {
    mesh.accessibility = mesh
        .positions
        .iter()
        .zip(&mesh.normals)
        .map(|(&p, &n)| {
            let ground = 0.5 + 0.5 * n.z;
            let near_ground = (-p.z.max(0.0) / 0.12).exp();
            let mut open = 1.0 - near_ground * (1.0 - ground);
            // Rows of spheres approximate the other turns of the body. Each sphere is weighted by its solid angle times the cosine.
            for ring in body.rings.iter().step_by(2) {
                let d = ring.centre - p;
                let (r, square) = (ring.half.y, d.length_squared());
                if square > (1.35 * r).powi(2) {
                    let cosine = (n.dot(d) / square.sqrt()).max(0.0);
                    open *= 1.0 - (0.8 * cosine * r * r / square).min(0.9);
                }
            }
            open.clamp(0.05, 1.0)
        })
        .collect();
}

/// Builds two glossy eyes as one mesh.
fn eyes(body: &Body) -> Object {
    let mut mesh = PatchMesh::default();
    let eye = body.length() - 0.13;
    let ring = body.distance.partition_point(|&d| d < eye);
    let section = body.rings[ring];
    for side in [0.09f32, 0.41] {
        let surface = body.point(ring, TAU * side);
        let centre = surface - (surface - section.centre) * 0.12;
        let ball = cube_sphere(2, [0.012, 0.009, 0.006, 0.08]);
        let first = mesh.positions.len() as u32;
        mesh.positions.extend(ball.positions.iter().map(|&p| centre + p * 0.017));
        mesh.normals.extend(&ball.normals);
        mesh.patches.extend(ball.patches.iter().map(|patch| patch.map(|v| v + first)));
        mesh.texcoords.extend(&ball.texcoords);
        mesh.colors.extend(&ball.colors);
        mesh.accessibility.extend(&ball.accessibility);
    }
    Object::new("eyes", mesh).with_specular_f0(0.05).without_shadow()
}

/// The radius of the lamp globes in metres.
const LAMP_RADIUS: f32 = 0.06;

/// Returns four lamps around the coil. The lamps in front are warm, and the lamps behind are cool.
pub fn lamps() -> Vec<PointLight> {
    let lamp = |x: f32, y: f32, z: f32, color: [f32; 3], power: f32| {
        PointLight::new(Vec3::new(x, y, z), Vec3::from_array(color) * power).with_radius(LAMP_RADIUS)
    };
    vec![
        lamp(1.5, -1.3, 1.1, [1.0, 0.62, 0.3], 2.6),
        lamp(-1.6, -1.0, 0.7, [1.0, 0.78, 0.5], 1.5),
        lamp(-1.2, 1.5, 1.2, [0.35, 0.6, 1.0], 2.6),
        lamp(1.3, 1.4, 0.8, [0.5, 0.75, 1.0], 1.8),
    ]
}

/// Builds the static stage, with atlas tiles of `tile` texels.
pub fn stage(tile: u32) -> Stage {
    let body = Body::new();
    let from = |direction: Vec3, distance: f32, target: Vec3, fov: f32| {
        Camera::looking_at(target + direction.normalize() * distance, target, fov)
    };
    let (direction, middle) = (Vec3::new(0.35, -1.0, 0.55), Vec3::new(0.0, 0.0, 0.16));
    let views = Views {
        near: from(Vec3::new(0.75, -1.0, 0.35), 0.75, Vec3::new(0.0, -0.22, 0.5), 31.8),
        mid: from(direction, 3.1, middle, 31.8),
        far: from(direction, 14.0, middle, 31.8),
    };
    Stage::still(vec![body_object(&body, tile), eyes(&body), ground()], views).with_points(lamps())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn parameters_lead_back_to_the_corners() {
        let body = Body::new();
        let mesh = body.mesh();
        for index in [0, 5, 200, (ALONG * AROUND - 1) as usize] {
            for (corner, uv) in [Vec2::ZERO, Vec2::X, Vec2::ONE, Vec2::Y].into_iter().enumerate() {
                let parameter = parameters(index, uv);
                let position = mesh.positions[mesh.patches[index][corner] as usize];
                assert!(
                    position.distance(body.point(parameter.y.round() as usize, parameter.x)) < 1e-4,
                    "{index} {corner}"
                );
            }
        }
    }
}
