//! Prepared frames: paused, resumed, measured, and drawn by nothing else.

use crate::common::render::{bumps, under_sky};
use glam::Vec3;
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::light::sky::Sky;
use leadr::render::scene::{FrameState, Object, Pose};
use leadr::render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr::scenes::sphere::cube_sphere;

fn scene(gpu: &crate::common::gpu::TestGpu) -> (Renderer, FrameState, RenderSettings) {
    let sphere = Object::new("rock", cube_sphere(4, [0.5, 0.4, 0.3, 0.4])).with_heights(bumps(32, 4.0, 3), 0.05);
    let camera = Camera::looking_at(Vec3::new(0.0, -4.0, 1.0), Vec3::ZERO, 40.0);
    let state = FrameState::new(camera, vec![Pose::REST]).under(&Sky::default());
    let shading = Technique::Leadr.with(ShadingOptions { edge_samples: 4, ..Default::default() });
    let settings = RenderSettings { size: (32, 24), samples: 3, shading, ..Default::default() };
    (under_sky(gpu, vec![sphere], 16), state, settings)
}

#[test]
fn a_paused_frame_ends_as_the_picture_drawn_at_once() {
    let Some(gpu) = crate::common::gpu::test_gpu() else { return };
    let (mut renderer, state, settings) = scene(&gpu);
    let whole = renderer.render(&state, &settings).unwrap().color;
    let mut paused = renderer.prepare(&state, &settings).unwrap().pause();
    for index in 0..settings.samples {
        let mut frame = renderer.resume(paused).unwrap();
        assert_eq!(frame.samples(), index);
        frame.draw_sample(index).unwrap();
        paused = frame.pause();
    }
    let image: Vec<[f32; 4]> = renderer.image().unwrap().read(0, 0).unwrap();
    assert_eq!(image, whole);
}

#[test]
fn a_frame_whose_renderer_went_on_cannot_be_resumed() {
    let Some(gpu) = crate::common::gpu::test_gpu() else { return };
    let (mut renderer, state, settings) = scene(&gpu);
    let paused = renderer.prepare(&state, &settings).unwrap().pause();
    renderer.render(&state, &settings).unwrap();
    let error = renderer.resume(paused).err().expect("another frame was prepared");
    assert!(error.to_string().contains("prepare it again"), "{error}");
}

#[test]
fn repetitions_change_neither_the_picture_nor_the_names_of_passes() {
    let Some(gpu) = crate::common::gpu::test_gpu() else { return };
    let (mut renderer, state, settings) = scene(&gpu);
    let settings = RenderSettings { samples: 1, shading: Technique::Leadr.into(), ..settings };
    let drawn = renderer.render(&state, &settings).unwrap();
    let measured = renderer.measure(&state, &settings, 0, 5).unwrap();
    let image: Vec<[f32; 4]> = renderer.image().unwrap().read(0, 0).unwrap();
    assert_eq!(image, drawn.color);
    let names = |times: &[leadr::render::frame::PassTime]| times.iter().map(|t| t.pass.clone()).collect::<Vec<_>>();
    assert_eq!(names(&measured), names(&drawn.times));
    let passes = ["sky", "cube mips", "irradiance", "shadow", "geometry", "filter and shade", "accumulate"];
    assert_eq!(names(&measured), passes);
}

#[test]
fn shadows_that_are_switched_off_leave_nothing_behind() {
    let Some(gpu) = crate::common::gpu::test_gpu() else { return };
    let (mut renderer, state, settings) = scene(&gpu);
    let unshadowed = RenderSettings { shadows: false, ..settings };
    let fresh = renderer.render(&state, &unshadowed).unwrap();
    let shadowed = renderer.render(&state, &settings).unwrap();
    let again = renderer.render(&state, &unshadowed).unwrap();
    assert!(shadowed.triangles > fresh.triangles, "the sun's view has triangles");
    assert_eq!((again.triangles, again.color), (fresh.triangles, fresh.color));
}
