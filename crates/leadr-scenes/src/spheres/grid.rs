//! All sixteen spheres of the tables on a floor: the `spheres` scene.

use std::collections::HashMap;

use glam::{Affine3A, Vec2, Vec3};

use super::cell::MIRROR_ROUGHNESS;
use super::surface::{Detail, Frequency, Surface};
use super::{ANISOTROPIC, ISOTROPIC};
use crate::plane::{self, plane};
use crate::stage::{Stage, Views};
use leadr_render::camera::Camera;
use leadr_render::scene::{Object, Pose};

/// Metres between the centres of neighbours; the spheres have radius 1.
const SPACING: f32 = 2.5;
/// Metres between rows.
const DEPTH: f32 = 3.0;
/// 1440 texels around the equator, 29 MB on the device.
const DETAIL: Detail = Detail { patches: 6, tile: 64 };

/// Slopes of each sphere and where its centre is: the isotropic row behind, smoothest on the left, then the anisotropic
/// ones with the smallest `σ_θ` in front of the left; each group of three rougher along `ω_φ` to the right.
pub fn places() -> Vec<(Vec2, Vec3)> {
    let row = |count: usize, i: usize, y: f32| Vec3::new((i as f32 - 0.5 * (count - 1) as f32) * SPACING, y, 1.0);
    let isotropic = ISOTROPIC.iter().enumerate().map(|(i, &s)| (Vec2::splat(s), row(7, i, DEPTH)));
    let (back, front) = ANISOTROPIC.split_at(5);
    let middle = back.iter().enumerate().map(|(i, &s)| (s, row(5, i, 0.0)));
    let front = front.iter().enumerate().map(|(i, &s)| (s, row(4, i, -DEPTH)));
    isotropic.chain(middle).chain(front).collect()
}

/// The stage. Spheres turn slowly about their poles.
pub fn stage() -> Stage {
    let mut surfaces: HashMap<u32, Surface> = HashMap::new();
    let places = places();
    let mut objects: Vec<Object> = places
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
            // Below, the floor hides part of the sky.
            object.mesh.accessibility = object.mesh.normals.iter().map(|n| 0.7 + 0.3 * n.z).collect();
            object.mesh.colors.fill([0.62, 0.42, 0.22, MIRROR_ROUGHNESS]);
            object
        })
        .collect();
    objects.push(floor(&places));
    let views = Views {
        near: Camera::looking_at(Vec3::new(1.0, -11.0, 3.6), Vec3::new(1.7, -1.6, 0.9), 24.0),
        mid: Camera::looking_at(Vec3::new(0.0, -20.0, 11.5), Vec3::new(0.0, -0.25, 0.5), 27.0),
        far: Camera::looking_at(Vec3::new(0.0, -120.0, 69.0), Vec3::new(0.0, -0.25, 0.5), 27.0),
    };
    let motion = move |time: f64| {
        let turn = Affine3A::from_rotation_z((time * 0.3) as f32);
        let spheres = places.iter().map(|&(_, at)| Pose::Rigid(Affine3A::from_translation(at) * turn));
        spheres.chain([Pose::Rigid(Affine3A::IDENTITY)]).collect()
    };
    Stage::moving(objects, views, motion, |_| Vec3::ZERO)
}

/// A smooth floor, dark around the feet of the spheres, which hide the sky from it.
fn floor(places: &[(Vec2, Vec3)]) -> Object {
    let mut mesh = plane(400.0, 112, 1.0, [0.13, 0.13, 0.14, 0.35], |t| (5.5 * t).sinh() / 5.5f32.sinh());
    mesh.accessibility = mesh
        .positions
        .iter()
        .map(|p| {
            // The share of a cosine-weighted hemisphere that a sphere of radius 1 takes, seen from the plane it rests on.
            let hidden = places.iter().map(|(_, centre)| (centre - p).length_squared().powf(-1.5));
            hidden.map(|h| 1.0 - h.min(1.0)).product()
        })
        .collect();
    plane::floor(mesh)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_pair_has_its_place() {
        let places = places();
        let pairs: Vec<Vec2> = ISOTROPIC.iter().map(|&sigma| Vec2::splat(sigma)).chain(ANISOTROPIC).collect();
        assert_eq!(places.iter().map(|(sigma, _)| *sigma).collect::<Vec<_>>(), pairs);
        for (i, (_, a)) in places.iter().enumerate() {
            assert!(places[..i].iter().all(|(_, b)| a.distance(*b) > 2.1), "spheres overlap");
        }
    }
}
