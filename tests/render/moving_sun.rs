//! A sun that moves every frame: the device's sky, its mips and its spherical harmonics against the 64-bit sky.

use glam::{DVec3, Vec3};
use leadr::reflectance::integrals::sh::{Sh9, sh_add_light};
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::light::environment::Environment;
use leadr::render::light::sky::Sky;
use leadr::render::scene::FrameState;
use leadr::render::settings::RenderSettings;
use leadr::scenes::daylight;
use leadr::scenes::stage::{Lights, ReliefOptions, plane_stage};
use leadr_testing::gpu::{TestGpu, test_gpu};
use leadr_testing::render::luminance;

/// Edge of a face, the size projected by the irradiance pass.
const FACE: usize = 64;

/// The projection of the 64-bit sky on the texel centres of the cube.
fn project(sky: &Sky) -> Sh9 {
    let tables = sky.tables();
    let mut c = [DVec3::ZERO; 9];
    for face in 0..6 {
        for texel in 0..FACE * FACE {
            let (x, y) = (texel % FACE, texel / FACE);
            let direction = leadr_testing::cube::texel_direction(face, x, y, FACE);
            sh_add_light(&mut c, direction, leadr_testing::cube::solid_angle(x, y, FACE) * tables.radiance(direction));
        }
    }
    c
}

/// Largest difference relative to the mean of the three channels of L00.
fn error(got: &[[f32; 4]], exact: &Sh9) -> f64 {
    let scale = exact[0].element_sum() / 3.0;
    let at = |k: usize| (DVec3::from_array([0, 1, 2].map(|i| got[k][i].into())) - exact[k]).abs().max_element();
    (0..9).map(at).fold(0.0, f64::max) / scale
}

fn scene(gpu: &TestGpu) -> (Renderer, impl Fn(f64) -> FrameState) {
    let mut stage = plane_stage(ReliefOptions::default());
    let camera = Camera::looking_at(Vec3::new(6.0, -8.0, 5.0), Vec3::ZERO, 35.0);
    let sky = Sky { sun_direction: daylight::at_hour(4.0), ..Sky::default() };
    let environment = Environment::from_sky(gpu, FACE as u32, &sky).unwrap();
    let renderer = Renderer::new(gpu, std::mem::take(&mut stage.objects), environment).unwrap();
    let lights = Lights::under(&sky);
    let state = move |hours: f64| {
        let mut state = stage.state(0.0, &camera, &lights);
        daylight::pass(&mut state, hours);
        state
    };
    (renderer, state)
}

#[test]
fn device_holds_the_latest_sky() {
    let Some(gpu) = test_gpu() else { return };
    let (mut renderer, state) = scene(&gpu);
    let settings = RenderSettings { size: (16, 12), samples: 2, ..RenderSettings::default() };
    let mut worst = 0.0f64;
    for frame in 0..24 {
        let state = state(f64::from(frame) * 0.9);
        let output = renderer.render(&state, &settings).unwrap();
        assert!(output.color.iter().all(|c| c.iter().all(|v| v.is_finite() && *v >= 0.0)), "frame {frame}");
        for pass in ["sky", "cube mips", "irradiance"] {
            assert!(output.times.iter().any(|t| t.pass == pass), "{pass} is not timed");
        }
        if frame % 3 != 2 {
            continue;
        }
        let (sky, got) = (state.sky.unwrap(), renderer.radiance_sh().unwrap());
        let off = error(&got, &project(&sky));
        println!("frame {frame}, sun at {:.1} degrees: {off:.1e}", sky.sun_direction.z.asin().to_degrees());
        worst = worst.max(off);
        // The sun one minute later must differ.
        let mut later = state.clone();
        daylight::pass(&mut later, 1.0 / 60.0);
        assert!(sky.sun_direction.z < -0.1 || error(&got, &project(&later.sky.unwrap())) > 3.0 * off);
    }
    println!("worst {worst:.1e}");
    assert!(worst < 1e-5, "{worst:.1e}");
}

#[test]
fn frame_does_not_depend_on_earlier_frames() {
    let Some(gpu) = test_gpu() else { return };
    let (mut renderer, state) = scene(&gpu);
    let settings = RenderSettings { size: (32, 24), ..RenderSettings::default() };
    let in_order: Vec<_> =
        (0..4).map(|i| renderer.render(&state(f64::from(i) * 2.5), &settings).unwrap().color).collect();
    for i in [2, 0, 3, 1] {
        assert_eq!(renderer.render(&state(f64::from(i) * 2.5), &settings).unwrap().color, in_order[i as usize]);
    }
    assert_ne!(in_order[1], in_order[2]);
}

#[test]
fn exposed_pictures_of_a_day_are_neither_black_nor_white() {
    let Some(gpu) = test_gpu() else { return };
    let (mut renderer, state) = scene(&gpu);
    let settings = RenderSettings { size: (32, 24), ..RenderSettings::default() };
    let mut seen: Vec<(f32, f64)> = Vec::new();
    for hour in 0..24 {
        let state = state(f64::from(hour));
        let output = renderer.render(&state, &settings).unwrap();
        let mean = output.color.iter().map(|c| f64::from(luminance(c))).sum::<f64>() / output.color.len() as f64;
        seen.push((state.sky.unwrap().sun_direction.z.asin().to_degrees(), mean * f64::from(state.exposure())));
    }
    println!("{seen:.3?}");
    let (low, high) = seen.iter().fold((f64::MAX, 0.0f64), |(l, h), s| (l.min(s.1), h.max(s.1)));
    assert!(low > 0.008 && high < 1.0, "{low} {high}");
    assert!(
        seen.iter().all(|s| if s.0 < -12.0 { s.1 < 0.25 * high } else { s.0 < 5.0 || s.1 > 0.05 }),
        "night is darker than day"
    );
}
