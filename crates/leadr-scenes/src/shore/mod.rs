//! The T-rex walks on a beach in front of the animated sea. Animal and sea are filtered, and lit by the same light.
//!
//! The coast runs along y and the sea lies toward −x (west, for the sunset). The animal walks toward +y.

pub mod beach;
pub mod sand;

use std::f32::consts::FRAC_PI_2;
use std::f64::consts::TAU;

use glam::{Affine3A, DVec2, Mat4, Vec3};

use self::sand::PERIOD;
use super::error::SceneError;
use super::ocean::waves::Waves;
use super::registry::Progress;
use super::stage::{Stage, Views};
use super::trex::Trex;
use super::trex::stage::{animal, walked};
use super::trex::walk;
use leadr_render::camera::Camera;
use leadr_render::scene::Pose;
use leadr_render::surfaces::ocean::Ocean;
use leadr_render::surfaces::ocean::shore::{Bend, Shore};

/// The x coordinate of the animal's path, on dry sand close to the wet sand.
const PATH: f64 = 6.2;

/// Returns the beach of the scene.
pub fn shore() -> Shore {
    let bend = |amplitude, turns: f64, phase| Bend { amplitude, step: TAU * turns / PERIOD, phase };
    Shore {
        slope: 0.09,
        berm: 0.9,
        reach: 3.0,
        bends: [bend(0.36, 3.0, 0.4), bend(0.32, 7.0, 2.2), bend(0.18, 13.0, 4.0), bend(0.08, 23.0, 1.1)],
        swells: 146,
        run_up: 0.28,
        bed: Vec3::from_array(sand::WET),
        extinction: Vec3::new(0.9, 0.30, 0.36),
    }
}

/// Returns the waves off the beach in a moderate breeze toward the land.
pub fn waves() -> Waves {
    Waves { wind: 6.0, wind_direction: -20.0, fetch: 40e3, ..Waves::default() }
}

/// Returns the sea off the beach with these waves.
pub fn sea(waves: &Waves) -> Ocean {
    Ocean { shore: Some(shore()), foam: Vec3::splat(0.7), ..waves.ocean() }
}

/// Builds the stage with these waves. The animal has atlas tiles of `tile` texels. [`Trex::load`] describes `progress`.
pub fn shore_stage(tile: u32, waves: &Waves, progress: Progress<'_>) -> Result<Stage, SceneError> {
    let shore = shore();
    let (trex, sand) = rayon::join(|| Trex::load(tile, progress), || beach::sand(&shore));
    let mut objects = animal(trex?).to_vec();
    let pieces = sand.len();
    objects.extend(sand);
    // The animal starts here and faces +y, with the sea on its left.
    let level = move |y: f64| shore.ground(shore.offshore(DVec2::new(PATH, y))) as f32;
    let at = |along: f32, seaward: f32, up: f32| Vec3::new(PATH as f32 - seaward, along, 0.42 + up);
    let middle = at(-0.5, 0.8, 1.85);
    let views = Views {
        near: Camera::looking_at(at(6.6, -3.0, 3.3), at(3.7, 0.3, 3.35), 36.0),
        mid: Camera::looking_at(at(7.0, -10.6, 1.9), middle, 38.0),
        far: Camera::looking_at(at(52.0, -72.0, 17.0), at(-2.0, 2.0, 2.0), 34.0),
    };
    let motion = move |time: f64| {
        let gone = walked(time);
        let stand = Vec3::new(PATH as f32, 0.0, level(f64::from(gone)));
        let world = Mat4::from_translation(stand) * Mat4::from_rotation_z(FRAC_PI_2);
        let joints: Vec<Mat4> = walk::pose(time).into_iter().map(|joint| world * joint).collect();
        // The sand follows the animal in steps of one repeat, which are invisible.
        let steps = (gone / PERIOD as f32).round();
        let sand = Pose::Rigid(Affine3A::from_translation(Vec3::Y * (steps * PERIOD as f32)));
        let mut poses = vec![Pose::Skinned(joints); 2];
        poses.resize(2 + pieces, sand);
        poses
    };
    Ok(Stage::moving(objects, views, motion, |time| Vec3::Y * walked(time)).with_ocean(sea(waves)))
}
