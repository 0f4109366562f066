//! The T-rex, which walks over dry ground.

use glam::{Affine3A, Vec3};

use super::{Trex, walk};
use crate::error::SceneError;
use crate::ground::{STEP, ground};
use crate::registry::Progress;
use crate::sphere::tiled_object;
use crate::stage::{Stage, Views};
use leadr_maps::noise::smoothstep;
use leadr_render::camera::Camera;
use leadr_render::named_enum;
use leadr_render::scene::{Object, Pose};
use leadr_render::surfaces::patch_mesh::{PatchMesh, TileLayout};

const BODY: &str = "trex body";
/// The number of patches of the body.
const BODY_PATCHES: u32 = 5920;

/// Builds the body and the props of the animal. [`walk::pose`] skins both.
pub fn animal(trex: Trex) -> [Object; 2] {
    let mut body = trex.body;
    // Colours come from the atlas, so vertex colours are white.
    body.colors = vec![[1.0; 4]; body.positions.len()];
    // The F0 of keratin is slightly above the usual 0.04.
    let body = tiled_object(BODY, body, trex.layout, trex.heights, trex.colors).with_specular_f0(0.045);
    // Two classes of the skin change the picture by less than their error, and take as long again.
    let body = body.with_single_class();
    let props = Object::new("trex teeth, claws and eyes", trex.props)
        .with_coarse_mesh(trex.coarse_props)
        .with_specular_f0(0.05);
    [body, props]
}

named_enum! {
    /// How the height of the skin's relief varies over the T-rex.
    #[derive(Default)]
    pub enum SkinRelief {
        /// The height is as generated.
        #[default]
        Even = "even", "As generated";
        /// The relief is higher on the back and lower on the belly.
        Graded = "graded", "Higher on the back, lower on the belly";
    }
}

/// The factor on the height of the skin where it faces down, and the difference to skin that faces up.
const BELLY: f32 = 0.4;
const BACK_ABOVE_BELLY: f32 = 1.2;

/// Sets the height scales of the body's vertices at rest.
pub fn vary_skin(objects: &mut [Object], relief: SkinRelief) {
    if relief == SkinRelief::Even {
        return;
    }
    for body in objects.iter_mut().filter(|object| object.name == BODY) {
        let scale = |normal: &Vec3| BELLY + BACK_ABOVE_BELLY * smoothstep(-0.7, 0.8, normal.z);
        body.mesh.height_scales = body.mesh.normals.iter().map(scale).collect();
    }
}

/// Returns a body whose maps have their final sizes, but no contents.
pub fn unbaked_body(tile: u32) -> Object {
    let layout = TileLayout::new(BODY_PATCHES, tile);
    tiled_object(BODY, PatchMesh::default(), layout, Vec::new(), Vec::new()).with_single_class()
}

/// Builds the stage with atlas tiles of `tile` texels. [`Trex::load`] describes `progress`.
pub fn trex_stage(tile: u32, progress: Progress<'_>) -> Result<Stage, SceneError> {
    let (trex, ground) = rayon::join(|| Trex::load(tile, progress), ground);
    trex.map(|trex| walking_on(trex, ground))
}

/// Builds the stage with the walking `trex`.
pub fn walking(trex: Trex) -> Stage {
    walking_on(trex, ground())
}

fn walking_on(trex: Trex, ground: Object) -> Stage {
    let [body, props] = animal(trex);
    let middle = Vec3::new(-0.2, 0.0, 2.0);
    let views = Views {
        near: Camera::looking_at(Vec3::new(6.3, -3.0, 3.6), Vec3::new(3.9, 0.0, 3.55), 32.0),
        mid: Camera::looking_at(Vec3::new(6.8, -11.7, 2.3), middle, 36.0),
        far: Camera::looking_at(middle + Vec3::new(0.52, -0.82, 0.16).normalize() * 110.0, middle, 36.0),
    };
    let motion = |time: f64| {
        let joints = walk::pose(time);
        // The ground mesh follows the animal, so that its small patches stay near the animal.
        let steps = (walked(time) / STEP).round();
        let below = Affine3A::from_translation(Vec3::X * steps * STEP);
        vec![Pose::Skinned(joints.clone()), Pose::Skinned(joints), Pose::Rigid(below)]
    };
    Stage::moving(vec![body, props, ground], views, motion, |time| Vec3::X * walked(time))
}

/// Returns the distance in metres that the animal has walked after `time` seconds.
pub fn walked(time: f64) -> f32 {
    (time * walk::SPEED) as f32
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn graded_skin_is_higher_on_the_back() {
        let mesh = PatchMesh { normals: vec![Vec3::Z, Vec3::X, -Vec3::Z], ..PatchMesh::default() };
        let mut objects = [Object::new(BODY, mesh.clone()), Object::new("ground", mesh)];
        vary_skin(&mut objects, SkinRelief::Even);
        assert!(objects.iter().all(|object| object.mesh.height_scales.is_empty()));
        vary_skin(&mut objects, SkinRelief::Graded);
        let [back, flank, belly] = objects[0].mesh.height_scales[..] else { panic!() };
        assert_eq!((back, belly), (BELLY + BACK_ABOVE_BELLY, BELLY));
        assert!(belly < flank && flank < back && objects[1].mesh.height_scales.is_empty());
    }
}
