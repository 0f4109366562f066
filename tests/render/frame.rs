//! Prepared frames: paused, resumed, measured, and drawn by no other path.

use glam::{Affine3A, Vec3};
use leadr::gpu::{Buffer, CommandRecorder, Memory, Timestamps, Use};
use leadr::render::camera::Camera;
use leadr::render::frame::{Layer, MAX_PASSES, Renderer};
use leadr::render::light::sky::Sky;
use leadr::render::scene::{FrameState, Object, Pose, Scene};
use leadr::render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr::render::surfaces::ocean::Ocean;
use leadr::scenes::ocean::sea::ocean;
use leadr::scenes::ocean::spectrum::Sea;
use leadr::scenes::sphere::cube_sphere;
use leadr_testing::gpu::TestGpu;
use leadr_testing::render::{bumps, under_sky};

fn scene(gpu: &TestGpu) -> (Renderer, FrameState, RenderSettings) {
    let sphere = Object::new("rock", cube_sphere(4, [0.5, 0.4, 0.3, 0.4])).with_heights(bumps(32, 4.0, 3), 0.05);
    let camera = Camera::looking_at(Vec3::new(0.0, -4.0, 1.0), Vec3::ZERO, 40.0);
    let state = FrameState::new(camera, vec![Pose::REST]).under(&Sky::default());
    let shading = Technique::Leadr.with(ShadingOptions { edge_samples: 4, ..Default::default() });
    let settings = RenderSettings { size: (32, 24), samples: 3, shading, ..Default::default() };
    (under_sky(gpu, vec![sphere], 16), state, settings)
}

/// Instances give the same picture, shadows and object numbers as separate objects.
#[test]
fn instances_are_drawn_as_objects_of_their_own() {
    let Some(gpu) = leadr_testing::gpu::test_gpu() else { return };
    let ball = |patches| Object::new("ball", cube_sphere(patches, [0.5, 0.4, 0.3, 0.4]));
    let rock = || ball(4).with_heights(bumps(32, 4.0, 3), 0.05).with_coarse_mesh(cube_sphere(2, [0.5, 0.4, 0.3, 0.4]));
    let mut one = under_sky(&gpu, vec![rock().with_instances(3), ball(2)], 16);
    let mut many = under_sky(&gpu, vec![rock(), rock(), rock(), ball(2)], 16);
    let at = |x: f32, y: f32, scale: f32| {
        Pose::Rigid(Affine3A::from_translation(Vec3::new(x, y, 0.0)) * Affine3A::from_scale(Vec3::splat(scale)))
    };
    let poses = vec![at(-1.5, 0.0, 1.0), at(0.4, -1.0, 0.5), at(1.5, 3.0, 1.2), at(0.4, 1.0, 0.4)];
    let camera = Camera::looking_at(Vec3::new(0.0, -6.0, 2.0), Vec3::ZERO, 40.0);
    let state = FrameState::new(camera, poses).under(&Sky::default());
    for technique in [Technique::Leadr, Technique::Reference] {
        let settings = RenderSettings { size: (64, 48), shading: technique.into(), ..Default::default() };
        let pictures = [&mut one, &mut many].map(|renderer| renderer.render(&state, &settings).unwrap());
        assert!(pictures[0].color == pictures[1].color, "{technique:?}");
        let [one, many] = [&mut one, &mut many].map(|renderer| renderer.layer(Layer::Patch).unwrap());
        assert_eq!(one, many);
        let seen = |number: f32| one.iter().any(|pixel| pixel[0] == number);
        assert!([1.0, 2.0, 3.0, 4.0].map(seen) == [true; 4]);
    }
}

#[test]
fn paused_frame_finishes_identically() {
    let Some(gpu) = leadr_testing::gpu::test_gpu() else { return };
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
fn frame_cannot_resume_after_renderer_moved_on() {
    let Some(gpu) = leadr_testing::gpu::test_gpu() else { return };
    let (mut renderer, state, settings) = scene(&gpu);
    let paused = renderer.prepare(&state, &settings).unwrap().pause();
    renderer.render(&state, &settings).unwrap();
    let error = renderer.resume(paused).err().expect("another frame was prepared");
    assert!(error.to_string().contains("prepare it again"), "{error}");
}

/// Frames of a moving camera, sun, object and sea, recorded without waiting, equal those drawn one at a time. No frame may write buffers
/// that the device still reads for another.
#[test]
#[ignore = "long"]
fn frames_on_their_way_do_not_disturb_each_other() {
    let Some(gpu) = leadr_testing::gpu::test_gpu() else { return };
    let sphere = Object::new("rock", cube_sphere(4, [0.5, 0.4, 0.3, 0.4])).with_heights(bumps(32, 4.0, 3), 0.05);
    let sea = Ocean { level: -0.5, ..ocean(&Sea::default(), 32, 1) };
    let mut renderer = under_sky(&gpu, Scene { objects: vec![sphere], ocean: Some(sea), ..Scene::default() }, 16);
    let states: Vec<FrameState> = (0..4)
        .map(|i| {
            let turn = i as f32 * 0.7;
            let eye = Vec3::new(4.0 * turn.sin(), -4.0 * turn.cos(), 1.0 + 0.2 * turn);
            let sky = Sky::with_sun(0.7, turn);
            let pose = Pose::Rigid(Affine3A::from_translation(Vec3::Z * 0.2 * turn));
            let camera = Camera::looking_at(eye, Vec3::ZERO, 40.0);
            FrameState { time: f64::from(turn), ..FrameState::new(camera, vec![pose]).under(&sky) }
        })
        .collect();
    // The reference marches through the sea.
    let reference = RenderSettings { shading: Technique::Reference.into(), ..Default::default() };
    for settings in [RenderSettings { msaa: 4, ..Default::default() }, reference] {
        let settings = RenderSettings { size: (96, 64), samples: 1, ..settings };
        together_as_alone(&gpu, &mut renderer, &states, &settings);
    }
}

fn together_as_alone(gpu: &TestGpu, renderer: &mut Renderer, states: &[FrameState], settings: &RenderSettings) {
    let alone: Vec<_> = states.iter().map(|state| renderer.render(state, settings).unwrap().color).collect();

    let mut on_their_way = Vec::new();
    for state in states {
        let mut frame = renderer.prepare(state, settings).unwrap();
        assert!(frame.overlaps());
        let [width, height] = frame.image().mip_extent(0);
        let bytes = u64::from(width) * u64::from(height) * frame.image().texel_bytes().unwrap();
        let kept = Buffer::new(gpu, "kept", bytes, Memory::Readback).unwrap();
        let mut recorder = CommandRecorder::new(gpu, "test").unwrap();
        let timestamps = Timestamps::new(gpu, MAX_PASSES + 1).unwrap();
        recorder
            .record("test", |cmd| {
                cmd.full_barrier();
                frame.record_sample(0, cmd, &timestamps).unwrap();
                cmd.transition(frame.image(), Use::CopySource);
                cmd.copy_image_to_buffer(frame.image(), 0, 0, 0..height, &kept, 0);
                cmd.full_barrier();
            })
            .unwrap();
        recorder.submit(&[], &[]).unwrap();
        on_their_way.push((recorder, frame.pause(), timestamps, kept));
    }
    for ((mut recorder, _, timestamps, kept), alone) in on_their_way.into_iter().zip(&alone) {
        recorder.wait().unwrap();
        assert!(timestamps.intervals().unwrap().iter().any(|(pass, _)| pass == "geometry"));
        assert!(&kept.read_all::<[f32; 4]>().unwrap() == alone);
    }
}

#[test]
fn a_frame_with_edge_samples_takes_several_submissions() {
    let Some(gpu) = leadr_testing::gpu::test_gpu() else { return };
    let (mut renderer, state, settings) = scene(&gpu);
    let mut frame = renderer.prepare(&state, &settings).unwrap();
    assert!(!frame.overlaps());
    let timestamps = Timestamps::new(&gpu, MAX_PASSES + 1).unwrap();
    let refused = gpu.submit("test", |cmd| frame.record_sample(0, cmd, &timestamps)).unwrap();
    assert!(refused.unwrap_err().to_string().contains("call `draw_sample` instead"));
}

#[test]
fn repetitions_change_neither_the_picture_nor_the_names_of_passes() {
    let Some(gpu) = leadr_testing::gpu::test_gpu() else { return };
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
fn disabled_shadows_leave_no_state() {
    let Some(gpu) = leadr_testing::gpu::test_gpu() else { return };
    let (mut renderer, state, settings) = scene(&gpu);
    let unshadowed = RenderSettings { shadows: false, ..settings };
    let fresh = renderer.render(&state, &unshadowed).unwrap();
    let shadowed = renderer.render(&state, &settings).unwrap();
    let again = renderer.render(&state, &unshadowed).unwrap();
    assert!(shadowed.triangles > fresh.triangles, "the sun's view has triangles");
    assert_eq!((again.triangles, again.color), (fresh.triangles, fresh.color));
}
