//! The tables of scale, which list frame and set-up times by number of objects, materials, triangles, pixels and texels.

use std::sync::Arc;
use std::time::Instant;

use glam::{Affine3A, Vec3};

use super::rows::Row;
use super::scene;
use crate::command::output::Output;
use crate::error::LabError;
use leadr_gpu::Gpu;
use leadr_maps::procedural;
use leadr_render::camera::Camera;
use leadr_render::frame::Renderer;
use leadr_render::light::environment::Environment;
use leadr_render::light::sky::Sky;
use leadr_render::scene::{FrameState, MaterialMap, Object, Pose};
use leadr_render::settings::{RenderSettings, Technique};
use leadr_render::surfaces::displacement::HeightField;
use leadr_scenes::config::SceneConfig;
use leadr_scenes::sphere::{color_code, cube_sphere};

/// The numbers of balls. Each number of balls fills the same part of the picture.
const COUNTS: [u32; 4] = [1, 10, 100, 1000];
/// The number of patches along a side of a face. The ball then has 10^5 triangles before tessellation.
const FINE_SIDE: u32 = 92;
/// The numbers of instances of the fine ball, with their total triangles.
const INSTANCES: [(u32, &str); 4] = [(1, "10^5"), (10, "10^6"), (100, "10^7"), (1000, "10^8")];
/// The number of patches along a side of a face, if there are many balls.
const SIDE: u32 = 4;
/// The number of texels along a side of each material.
const TEXELS: u32 = 16;
/// The sides of square pictures in pixels, and of square height maps in texels.
const SIDES: [u32; 4] = [128, 256, 512, 1024];
/// Half the width in metres of the square of balls.
const HALF: f32 = 5.0;

/// Returns renderers with their rows for increasing numbers of balls, of balls with separate materials, of instances of a fine
/// ball, of pixels, and of texels of a height map. Every row is compared with the first row of its table.
///
/// # Errors
/// Fails if memory runs out or the device fails.
pub fn scale(
    config: &SceneConfig,
    gpu: &Arc<Gpu>,
    only: Option<Technique>,
    output: &Output,
) -> Result<Vec<(Renderer, Vec<Row>)>, LabError> {
    let technique = only.unwrap_or(Technique::Leadr);
    let row = |of: &str, name: &str, base: &str, state: FrameState, set_up| {
        let row = scene::row(config, technique, state, [format!("by {of}"), name.to_owned(), base.to_owned()]);
        Row { set_up, ..row }
    };
    let mut all = Vec::new();
    let mut add = |of: &str, name: &str, base: &str, balls: Vec<Object>| -> Result<(), LabError> {
        let (renderer, state, seconds) = set_up(gpu, balls)?;
        output.say(&format!("by {of}, {name}: set up in {seconds:.2} s"));
        all.push((renderer, vec![row(of, name, base, state, Some(seconds))]));
        Ok(())
    };
    for count in COUNTS {
        add("objects", &count.to_string(), "1", balls(count, SIDE, false))?;
    }
    for count in COUNTS {
        add("materials", &count.to_string(), "1", balls(count, SIDE, true))?;
    }
    for (count, name) in INSTANCES {
        let ball = balls(1, FINE_SIDE, false).into_iter().map(|ball| ball.with_instances(count));
        add("triangles", name, INSTANCES[0].1, ball.collect())?;
    }
    for side in SIDES {
        let ball = balls(1, SIDE, false).into_iter().map(|ball| ball.with_heights(rough(side), 0.02));
        add("texels", &format!("{side}x{side}"), &format!("{0}x{0}", SIDES[0]), ball.collect())?;
    }
    let (renderer, state, _) = set_up(gpu, balls(100, SIDE, false))?;
    let pictures = SIDES.map(|side| {
        let row = row("pixels", &format!("{side}x{side}"), &format!("{0}x{0}", SIDES[0]), state.clone(), None);
        Row { settings: RenderSettings { size: (side, side), ..row.settings }, ..row }
    });
    all.push((renderer, pictures.to_vec()));
    Ok(all)
}

/// Returns a renderer of the balls, a state that shows all of them, and the upload time in seconds.
fn set_up(gpu: &Arc<Gpu>, balls: Vec<Object>) -> Result<(Renderer, FrameState, f64), LabError> {
    let sky = Sky::default();
    let environment = Environment::from_sky(gpu, Environment::FACE_SIZE, &sky)?;
    let camera = Camera::looking_at(Vec3::new(0.0, -0.01, 3.0 * HALF), Vec3::ZERO, 40.0);
    let count = balls.iter().map(|ball| ball.instances).sum();
    let state = FrameState::new(camera, poses(count)).under(&sky);
    gpu.wait_idle()?;
    let start = Instant::now();
    let renderer = Renderer::new(gpu, balls, environment)?;
    gpu.wait_idle()?;
    Ok((renderer, state, start.elapsed().as_secs_f64()))
}

/// Returns `count` unit balls, with separate materials if `materials` is set.
fn balls(count: u32, side: u32, materials: bool) -> Vec<Object> {
    let mesh = cube_sphere(side, [0.5, 0.5, 0.5, 0.3]);
    let ball = |i: u32| {
        let object = Object::new(format!("ball {i}"), mesh.clone());
        let albedo = [0.2 + 0.6 * i as f32 / count as f32, 0.5, 0.4];
        let texels = vec![color_code(albedo, 0.3); (TEXELS * TEXELS) as usize];
        if materials { object.with_material(MaterialMap::new(TEXELS, TEXELS, texels)) } else { object }
    };
    (0..count).map(ball).collect()
}

/// Returns a rough, repeating height map of `side` by `side` texels.
fn rough(side: u32) -> HeightField {
    HeightField::repeating(procedural::gaussian(side, side, 1, 1.0, 0.1))
}

fn poses(count: u32) -> Vec<Pose> {
    let columns = f64::from(count).sqrt().ceil() as u32;
    let spacing = 2.0 * HALF / columns as f32;
    let position = |i: u32| {
        let at = |k: u32| (k as f32 + 0.5) * spacing - HALF;
        Vec3::new(at(i % columns), at(i / columns), 0.0)
    };
    let pose = |i| {
        Pose::Rigid(Affine3A::from_scale_rotation_translation(
            Vec3::splat(0.45 * spacing),
            glam::Quat::IDENTITY,
            position(i),
        ))
    };
    (0..count).map(pose).collect()
}
