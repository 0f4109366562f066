//! A driver may refuse memory or a pipeline, or lose the device, at any call. Each time the error is one line with a remedy, nothing leaks
//! on the device, and the next picture is correct.

use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use leadr::gpu::{DriverCall, Gpu};
use leadr::maps::RgbImage;
use leadr::maps::cache::MapCache;
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::light::environment::Environment;
use leadr::render::light::sky::Sky;
use leadr::render::scene::{FrameState, Object, Pose};
use leadr::render::settings::RenderSettings;
use leadr::scenes::config::{Picture, SceneConfig};
use leadr::scenes::error::SceneError;
use leadr::scenes::registry::{MODEL, NamedScene};
use leadr::scenes::set::{Inputs, set};
use leadr::scenes::sphere::displaced_sphere;
use leadr::scenes::stage::Lights;
use leadr::scenes::trex::Trex;
use leadr::scenes::trex::stage::walking;
use leadr::scenes::view::Size;
use leadr_testing::gpu::test_gpu;
use leadr_testing::render::bumps;

/// A renderer, and the frame to draw.
type Ready = (Renderer, FrameState, RenderSettings);
/// Builds it on a device that may fail.
type Drawing<'a> = &'a dyn Fn(&Arc<Gpu>) -> Result<Ready, SceneError>;

/// A picture or its error. A renderer that fails on a working device is called once more.
fn draw(drawing: Drawing<'_>, gpu: &Arc<Gpu>) -> (Result<RgbImage, SceneError>, Option<RgbImage>) {
    let (mut renderer, state, settings) = match drawing(gpu) {
        Ok(set) => set,
        Err(error) => return (Err(error), None),
    };
    match renderer.render(&state, &settings) {
        Ok(output) => (Ok(output.image()), None),
        Err(error) => {
            let again = renderer.render(&state, &settings).map(|output| output.image());
            (Err(error.into()), again.ok())
        }
    }
}

/// At most `most` of `count` calls, evenly spaced, including the first and the last.
fn spread(count: u32, most: u32) -> impl Iterator<Item = u32> {
    let tried = count.min(most);
    (0..tried).map(move |i| i * (count - 1) / (tried - 1).max(1))
}

/// Draws without a fault, and then with up to `most` faults of each kind.
fn try_faults(name: &str, drawing: Drawing<'_>, most: u32) {
    let Some(first) = test_gpu() else { return };
    let begun = Instant::now();
    // The first of them fills the cache.
    let whole = draw(drawing, &first).0.unwrap();
    drop(first);
    let gpu = test_gpu().unwrap();
    draw(drawing, &gpu).0.unwrap();
    let calls = DriverCall::ALL.map(|call| gpu.calls(call));
    let mut tried = 0;
    for (call, count) in DriverCall::ALL.into_iter().zip(calls) {
        assert!(count > 2, "{name}: {count} calls of {call:?}");
        let lost = matches!(call, DriverCall::Submission | DriverCall::Wait);
        for after in spread(count, most) {
            let what = format!("{name}, {call:?} {after} of {count}");
            let gpu = test_gpu().unwrap();
            gpu.fail_after(after, call);
            let (drawn, again) = draw(drawing, &gpu);
            let error = drawn.err().unwrap_or_else(|| panic!("{what}: nothing failed")).to_string();
            let remedy = if lost { "restart" } else { "use smaller" };
            assert!(error.contains(remedy) && !error.contains('\n'), "{what}: {error}");
            if let Some(picture) = again {
                assert!(!lost && picture.texels == whole.texels, "{what}: the next picture is wrong");
            }
            assert_eq!(Arc::strong_count(&gpu), 1, "{what}: something stays on the device");
            assert_eq!(gpu.memory_use().allocations, 0, "{what}: its memory stays");
            tried += 1;
        }
    }
    let last = draw(drawing, &test_gpu().unwrap()).0.unwrap();
    assert!(last.texels == whole.texels, "{name}: the process draws otherwise than before");
    println!("{name}: {calls:?} calls, {tried} faults, {:.1} s", begun.elapsed().as_secs_f32());
}

/// A small scene with most of the resources of others.
fn sphere(gpu: &Arc<Gpu>) -> Result<Ready, SceneError> {
    let (mesh, heights) = displaced_sphere(&bumps(32, 4.0, 7), 1.0, 2, 8, [0.5; 4]);
    let object = Object::new("ball", mesh).with_heights(heights, 0.05);
    let renderer = Renderer::new(gpu, vec![object], Environment::from_sky(gpu, 8, &Sky::default())?)?;
    let camera = Camera::looking_at(glam::Vec3::new(3.0, 0.5, 0.8), glam::Vec3::ZERO, 45.0);
    let state = FrameState { sky: Some(Sky::default()), ..FrameState::new(camera, vec![Pose::REST]) };
    Ok((renderer, state, RenderSettings { size: (32, 32), ..RenderSettings::default() }))
}

#[test]
#[ignore = "long"]
fn calls_may_fail_while_a_sphere_is_drawn() {
    try_faults("sphere", &sphere, 7);
}

#[test]
#[ignore = "takes minutes"]
fn every_call_may_fail_while_a_sphere_is_drawn() {
    try_faults("sphere", &sphere, u32::MAX);
}

#[test]
#[ignore = "long"]
fn calls_may_fail_while_scenes_are_drawn() {
    let snail = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets/snail.glb");
    for (scene, model) in [("plane", None), ("ocean", None), ("model", Some(snail))] {
        let drawing = |gpu: &Arc<Gpu>| {
            let config = config(scene, model.clone());
            let settings = config.render_settings();
            let set = set(&config, Inputs::load(&config)?, gpu, Some(&settings), &|_| ())?;
            let state = (set.animation)(0.0);
            Ok((set.renderer, state, settings))
        };
        try_faults(scene, &drawing, 2);
    }
}

#[test]
#[ignore = "takes minutes"]
fn calls_may_fail_while_a_trex_is_drawn() {
    let cache = MapCache::in_folder(Path::new(env!("CARGO_TARGET_TMPDIR")).join("trex"));
    let sky = Sky::default();
    let drawing = |gpu: &Arc<Gpu>| {
        let mut stage = walking(Trex::load_from(Some(&cache), 16, &|_| ())?);
        let renderer = Renderer::new(gpu, std::mem::take(&mut stage.objects), Environment::from_sky(gpu, 16, &sky)?)?;
        let state = stage.state(0.0, &stage.views.mid, &Lights::under(&sky));
        Ok((renderer, state, RenderSettings { size: (32, 32), ..RenderSettings::default() }))
    };
    try_faults("trex", &drawing, 3);
}

fn config(scene: &str, model: Option<PathBuf>) -> SceneConfig {
    SceneConfig {
        scene: NamedScene::find(scene).unwrap_or(&MODEL),
        model,
        size: Size { width: 32, height: 32 },
        picture: Picture { samples: 1, ..Picture::default() },
        msaa: 4,
        bare: true,
        ..SceneConfig::default()
    }
}
