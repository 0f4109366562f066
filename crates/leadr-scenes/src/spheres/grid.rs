//! The `spheres` scene, with all sixteen spheres of the tables on a floor.

use std::collections::HashMap;

use glam::{Affine3A, Vec2, Vec3};

use super::cell::MIRROR_ROUGHNESS;
use super::surface::{Detail, Frequency, Surface};
use super::{ANISOTROPIC, ISOTROPIC};
use crate::plane::{self, plane};
use crate::stage::{Stage, Views};
use leadr_render::camera::Camera;
use leadr_render::scene::{Object, Pose};

/// The distance between the centres of neighbouring spheres in metres. A sphere has a radius of 1 metre.
const SPACING: f32 = 2.5;
/// The distance between rows in metres.
const DEPTH: f32 = 3.0;
/// Albedo and roughness of the floor.
const FLOOR: [f32; 4] = [0.13, 0.13, 0.14, 0.35];
/// Detail with 1440 texels around the equator, 29 MB on the device.
const DETAIL: Detail = Detail { patches: 6, tile: 64 };

/// Returns the slopes and centre of each sphere. The back row is isotropic, with the smoothest sphere on the left. The rows in front are
/// anisotropic. The smallest `σ_θ` is on the left. In groups of three, `σ_φ` increases to the right.
pub fn slopes_and_centres() -> Vec<(Vec2, Vec3)> {
    let row = |count: usize, i: usize, y: f32| Vec3::new((i as f32 - 0.5 * (count - 1) as f32) * SPACING, y, 1.0);
    let isotropic = ISOTROPIC.iter().enumerate().map(|(i, &s)| (Vec2::splat(s), row(7, i, DEPTH)));
    let (back, front) = ANISOTROPIC.split_at(5);
    let middle = back.iter().enumerate().map(|(i, &s)| (s, row(5, i, 0.0)));
    let front = front.iter().enumerate().map(|(i, &s)| (s, row(4, i, -DEPTH)));
    isotropic.chain(middle).chain(front).collect()
}

/// Builds the stage, in which spheres rotate slowly about their poles.
pub fn stage() -> Stage {
    let mut surfaces: HashMap<u32, Surface> = HashMap::new();
    let slopes_and_centres = slopes_and_centres();
    let mut objects: Vec<Object> = slopes_and_centres
        .iter()
        .map(|&(sigma, _)| {
            let aspect = (sigma.y / sigma.x).round();
            let surface = surfaces
                .entry(aspect as u32)
                .or_insert_with(|| Surface::kept(Vec2::new(1.0, aspect), Frequency::High, DETAIL));
            let mut object = surface.object(
                &format!("sphere {} {}", sigma.x, sigma.y),
                sigma.max_element(),
                super::cell::Facets::Mirror,
            );
            object.specular_f0 = 0.75;
            // The floor hides a part of the lower sky.
            object.mesh.accessibility = object.mesh.normals.iter().map(|n| 0.7 + 0.3 * n.z).collect();
            object.mesh.colors.fill([0.62, 0.42, 0.22, MIRROR_ROUGHNESS]);
            object
        })
        .collect();
    objects.push(floor(&slopes_and_centres));
    let views = Views {
        near: Camera::looking_at(Vec3::new(1.0, -11.0, 3.6), Vec3::new(1.7, -1.6, 0.9), 24.0),
        mid: Camera::looking_at(Vec3::new(0.0, -20.0, 11.5), Vec3::new(0.0, -0.25, 0.5), 27.0),
        far: Camera::looking_at(Vec3::new(0.0, -60.0, 34.5), Vec3::new(0.0, -0.25, 0.5), 27.0),
    };
    let motion = move |time: f64| {
        let rotation = Affine3A::from_rotation_z((time * 0.3) as f32);
        let spheres = slopes_and_centres.iter().map(|&(_, at)| Pose::Rigid(Affine3A::from_translation(at) * rotation));
        spheres.chain([Pose::Rigid(Affine3A::IDENTITY)]).collect()
    };
    let [r, g, b, _] = FLOOR;
    Stage::moving(objects, views, motion, |_| Vec3::ZERO).with_albedo_below([r, g, b])
}

/// Builds a smooth floor that is darker where the spheres hide the sky.
fn floor(slopes_and_centres: &[(Vec2, Vec3)]) -> Object {
    let mut mesh = plane(400.0, 112, 1.0, FLOOR, |t| (5.5 * t).sinh() / 5.5f32.sinh());
    mesh.accessibility = mesh
        .positions
        .iter()
        .map(|p| {
            // The fraction of the cosine-weighted hemisphere that a unit sphere covers, as seen from the floor.
            let hidden = slopes_and_centres.iter().map(|(_, centre)| (centre - p).length_squared().powf(-1.5));
            hidden.map(|h| 1.0 - h.min(1.0)).product()
        })
        .collect();
    plane::floor(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_has_a_sphere() {
        let slopes_and_centres = slopes_and_centres();
        let pairs: Vec<Vec2> = ISOTROPIC.iter().map(|&sigma| Vec2::splat(sigma)).chain(ANISOTROPIC).collect();
        assert_eq!(slopes_and_centres.iter().map(|(sigma, _)| *sigma).collect::<Vec<_>>(), pairs);
        for (i, (_, a)) in slopes_and_centres.iter().enumerate() {
            assert!(slopes_and_centres[..i].iter().all(|(_, b)| a.distance(*b) > 2.1), "spheres overlap");
        }
    }
}
