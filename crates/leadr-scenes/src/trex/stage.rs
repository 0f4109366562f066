//! The T-rex, which walks over dry ground.

use glam::{Affine3A, Vec3};

use super::{Trex, walk};
use crate::error::SceneError;
use crate::ground::{STEP, ground};
use crate::registry::Progress;
use crate::sphere::tiled_object;
use crate::stage::{Stage, Views};
use leadr_render::camera::Camera;
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
