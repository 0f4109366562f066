//! Many point lights, spots and directional lights: they add up, reach only their range, and the brightest cast shadows.

use crate::classes::hard_edges;
use crate::reference::{mean, renderer, state};
use glam::Vec3;
use leadr::render::camera::Camera;
use leadr::render::frame::{Layer, Renderer};
use leadr::render::scene::{Cone, FrameState, MAX_LAMPS, Object, PointLight, Pose, Sun};
use leadr::render::settings::{Quadrature, RenderSettings, Shading, ShadingOptions, Technique};
use leadr::render::surfaces::displacement::HeightField;
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::plane::{even, plane};
use leadr::scenes::sphere::cube_sphere;
use leadr_testing::gpu::{TestGpu, test_gpu};
use leadr_testing::render::{bumps, in_room};

const SIZE: u32 = 32;

/// Four metres of bricks with hard edges, or of Gaussian bumps.
fn relief(gpu: &TestGpu, bricks: bool) -> Renderer {
    let heights = if bricks { HeightField::repeating(hard_edges(true)) } else { bumps(64, 8.0, 3) };
    let mesh = plane(2.0, 16, 1.0, [0.7, 0.6, 0.5, 0.3], even);
    in_room(gpu, vec![Object::new("relief", mesh).with_heights(heights, if bricks { 0.06 } else { 0.5 })], [0.0; 3])
}

/// Points, spots and suns of several colours. The first four have shadow maps if there are casters.
fn lights() -> (Vec<PointLight>, Vec<Sun>) {
    let color = |i: usize| Vec3::from([[3.0, 1.0, 0.5], [0.5, 2.0, 1.0], [0.2, 0.6, 3.0]][i % 3]);
    let point = |i: usize| {
        let angle = 1.1 * i as f32;
        let position = Vec3::new(1.5 * angle.cos(), 1.5 * angle.sin(), 0.6 + 0.15 * i as f32);
        let cone = Cone { axis: (Vec3::new(0.2, 0.1, 0.0) - position).normalize(), inner_angle: 0.2, outer_angle: 0.6 };
        PointLight {
            cone: i.is_multiple_of(2).then_some(cone),
            range: i.is_multiple_of(3).then_some(4.0),
            ..PointLight::new(position, color(i))
        }
    };
    let sun =
        |i: usize| Sun { direction: Vec3::new(0.4 - 0.5 * i as f32, 0.3, 0.6).normalize(), irradiance: 0.4 * color(i) };
    ((0..6).map(point).collect(), (0..2).map(sun).collect())
}

fn camera() -> Camera {
    Camera::looking_at(Vec3::new(0.4, -2.6, 1.9), Vec3::ZERO, 40.0)
}

fn lit(point_lights: Vec<PointLight>, more_suns: Vec<Sun>) -> FrameState {
    FrameState { point_lights, more_suns, ..FrameState::new(camera(), vec![Pose::REST]) }
}

fn settings(shading: Shading) -> RenderSettings {
    RenderSettings { size: (SIZE, SIZE), shading, shadows: false, ..Default::default() }
}

/// The states with one light each.
fn single() -> Vec<FrameState> {
    let (points, suns) = lights();
    let points = points.into_iter().map(|light| lit(vec![light], Vec::new()));
    points.chain(suns.into_iter().map(|sun| lit(Vec::new(), vec![sun]))).collect()
}

fn sum(pictures: impl Iterator<Item = Vec<[f32; 4]>>) -> Vec<[f32; 4]> {
    let add = |a: Vec<[f32; 4]>, b: Vec<[f32; 4]>| {
        a.iter().zip(&b).map(|(a, b)| std::array::from_fn(|c| if c < 3 { a[c] + b[c] } else { a[c] })).collect()
    };
    pictures.reduce(add).unwrap()
}

/// The largest difference of two pictures, relative to the mean of the second.
fn worst(a: &[[f32; 4]], b: &[[f32; 4]]) -> f32 {
    let mean = b.iter().map(|b| b[1]).sum::<f32>() / b.len() as f32;
    let difference = |(a, b): (&[f32; 4], &[f32; 4])| (0..3).map(|c| (a[c] - b[c]).abs()).fold(0.0, f32::max);
    a.iter().zip(b).map(difference).fold(0.0, f32::max) / mean
}

/// The picture under eight lights is the sum of the pictures under each of them, with every family of techniques.
#[test]
fn lights_add_up() {
    let Some(gpu) = test_gpu() else { return };
    let options = ShadingOptions::default();
    let cases = [
        (false, Technique::Leadr, options),
        (false, Technique::Leadr, ShadingOptions { quadrature: Quadrature::Grid(5), ..options }),
        (true, Technique::Leadr, options),
        (true, Technique::Leadr, ShadingOptions { interreflection: true, ..options }),
        (false, Technique::LeadrGgx, options),
        (true, Technique::Gloss, options),
        (false, Technique::Lean, options),
        (false, Technique::Toksvig, options),
    ];
    let (points, suns) = lights();
    let mut renderers = [false, true].map(|bricks| relief(&gpu, bricks));
    for (bricks, technique, options) in cases {
        let settings = settings(technique.with(options));
        let renderer = &mut renderers[usize::from(bricks)];
        let mut draw = |state: &FrameState| renderer.render(state, &settings).unwrap().color;
        let all = draw(&lit(points.clone(), suns.clone()));
        let parts = sum(single().iter().map(&mut draw));
        let difference = worst(&all, &parts);
        println!("{}, bricks {bricks}: {difference:.1e}", settings.shading);
        assert!(difference < 2e-5, "{}: {difference}", settings.shading);
        // Each light contributes.
        let without = draw(&lit(points[1..].to_vec(), suns.clone()));
        assert!(
            worst(&without, &parts) > 0.05 && worst(&draw(&lit(points.clone(), suns[1..].to_vec())), &parts) > 0.05
        );
    }
}

/// The reference draws four of the lights per sample, and the mean of its samples has all of them, with their shadows.
#[test]
fn lights_of_the_reference_add_up() {
    let Some(gpu) = test_gpu() else { return };
    for (casts, relief_shadows) in [(false, false), (true, true)] {
        let mesh = plane(2.0, 16, 1.0, [0.7, 0.6, 0.5, 0.3], even);
        let object = Object::new("relief", mesh).with_heights(bumps(64, 8.0, 3), 0.5);
        let mut renderer = in_room(&gpu, vec![Object { casts_shadow: casts, ..object }], [0.0; 3]);
        let shading = Technique::Reference.with(ShadingOptions { relief_shadows, ..Default::default() });
        let tessellation = TessellationSettings { to_texels: true, ..Default::default() };
        let settings = RenderSettings { samples: 16, tessellation, ..settings(shading) };
        let (points, suns) = lights();
        let mut draw = |state: &FrameState| renderer.render(state, &settings).unwrap().color;
        let all = draw(&lit(points, suns));
        let parts = sum(single().iter().map(&mut draw));
        let mean = |picture: &[[f32; 4]], c: usize| picture.iter().map(|p| p[c]).sum::<f32>() / picture.len() as f32;
        for c in 0..3 {
            let ratio = mean(&all, c) / mean(&parts, c);
            println!("relief shadows {relief_shadows}, channel {c}: {ratio}");
            assert!((ratio - 1.0).abs() < if relief_shadows { 0.02 } else { 1e-4 }, "{ratio}");
        }
    }
}

/// LEADR under eight lights against the reference with its shadows of the relief.
#[test]
fn lights_follow_the_reference() {
    let Some(gpu) = test_gpu() else { return };
    let heights = HeightField::repeating(hard_edges(true));
    let mesh = plane(1.5, 6, 1.0, [1.0; 4], even);
    let object = Object::new("plane", mesh).with_heights(heights, 4.0 / 64.0).with_specular_f0(0.0);
    let mut renderer = renderer(&gpu, object, 0.0);
    // Far lights, so that the relief in the picture has the same light everywhere.
    let far = |light: &PointLight| {
        let towards = light.position.normalize();
        PointLight { cone: None, range: None, ..PointLight::new(towards * 30.0, 900.0 * light.intensity) }
    };
    let (points, suns) = lights();
    let (point_lights, more_suns) = (points.iter().map(far).collect(), suns);
    let state = FrameState { point_lights, more_suns, ..state(None) };
    let mut draw = |technique: Technique, size, samples| {
        let relief_shadows = technique.is_reference();
        let shading = technique.with(ShadingOptions { relief_shadows, ..Default::default() });
        let tessellation = TessellationSettings { to_texels: true, ..Default::default() };
        let settings = RenderSettings { size, samples, tessellation, ..settings(shading) };
        mean(&renderer.render(&state, &settings).unwrap().color)
    };
    let (leadr, truth) = (draw(Technique::Leadr, (2, 1), 1), draw(Technique::Reference, (128, 64), 16));
    println!("LEADR {leadr:.4}, reference {truth:.4}");
    assert!((leadr / truth - 1.0).abs() < 0.08, "{leadr} {truth}");
}

/// Lights out of range or whose cone points away change no bit, wherever they are in the list.
#[test]
fn lights_that_do_not_reach_change_nothing() {
    let Some(gpu) = test_gpu() else { return };
    let mut renderer = relief(&gpu, true);
    let settings = settings(Technique::Leadr.into());
    let (points, suns) = lights();
    let mut draw = |points: Vec<PointLight>| renderer.render(&lit(points, suns.clone()), &settings).unwrap().color;
    let expected = draw(points.clone());
    let away = Cone { axis: Vec3::Z, inner_angle: 0.3, outer_angle: 1.0 };
    let dark = [
        PointLight { range: Some(0.5), ..PointLight::new(Vec3::new(0.0, 0.0, 3.0), Vec3::ONE) },
        PointLight { cone: Some(away), ..PointLight::new(Vec3::new(0.5, 0.5, 1.0), Vec3::ONE) },
        PointLight::new(Vec3::ZERO, Vec3::ZERO),
    ];
    // Lights after the fourth change neither the maps nor the order of the others.
    let many = points.iter().copied().chain(dark.into_iter().cycle().take(300)).collect();
    assert_eq!(draw(many), expected);
    let between: Vec<_> = points.iter().flat_map(|&light| [light, dark[0], dark[1]]).collect();
    assert!(worst(&draw(between), &expected) < 2e-5);
}

/// Of many lights, the brightest at the casters cast shadows, wherever they are in the list.
#[test]
fn the_brightest_lights_cast_shadows() {
    let Some(gpu) = test_gpu() else { return };
    let white = [0.8, 0.8, 0.8, 0.9];
    let floor = Object::new("floor", plane(3.0, 8, 1.0, white, even)).without_shadow();
    let ball = Object::new("ball", cube_sphere(8, white));
    let mut renderer = in_room(&gpu, vec![floor, ball], [0.0; 3]);
    let poses = vec![
        Pose::REST,
        Pose::Rigid(glam::Affine3A::from_scale_rotation_translation(Vec3::splat(0.3), glam::Quat::IDENTITY, Vec3::Z)),
    ];
    let camera = Camera { up: Vec3::Y, ..Camera::looking_at(Vec3::new(1.0, 0.0, 8.0), Vec3::X, 20.0) };
    let settings = RenderSettings { size: (64, 64), shading: Technique::Leadr.into(), ..Default::default() };
    let lamp = PointLight::new(Vec3::new(-2.0, 0.0, 3.0), Vec3::splat(30.0));
    let sun = Sun { direction: Vec3::new(-2.0, 0.0, 2.0).normalize(), irradiance: Vec3::splat(2.0) };
    let dim = PointLight::new(Vec3::new(-2.0, 0.5, 1.0), Vec3::splat(1e-6));
    for (point, suns) in [(Some(lamp), vec![]), (None, vec![sun])] {
        let mut draw = |point_lights: Vec<PointLight>, shadows| {
            let more_suns = suns.clone();
            let state = FrameState { point_lights, more_suns, ..FrameState::new(camera, poses.clone()) };
            let settings = RenderSettings { shadows, ..settings };
            let picture = renderer.render(&state, &settings).unwrap().color;
            (picture, renderer.layer(Layer::Shadow).unwrap())
        };
        let alone: Vec<PointLight> = point.into_iter().collect();
        let many: Vec<PointLight> = vec![dim; 7].into_iter().chain(point).collect();
        let ((one, share_of_one), (all, share)) = (draw(alone.clone(), true), draw(many, true));
        let unshadowed = draw(alone, false).0;
        assert!(worst(&all, &one) < 1e-3, "{}", worst(&all, &one));
        assert!(share.iter().any(|s| s[0] < 0.01) && share.iter().any(|s| s[0] == 1.0));
        assert!(share.iter().zip(&share_of_one).all(|(a, b)| (a[0] - b[0]).abs() < 1e-3));
        assert!(worst(&unshadowed, &one) > 0.3, "{}", worst(&unshadowed, &one));
    }
}

/// A frame refuses too many lights and lights that are not finite, and draws the most lights it accepts.
#[test]
fn invalid_lights_are_refused() {
    let Some(gpu) = test_gpu() else { return };
    let mut renderer = relief(&gpu, true);
    let settings = RenderSettings { size: (4, 4), ..settings(Technique::Leadr.into()) };
    let lamp = PointLight::new(Vec3::Z, Vec3::splat(1.0 / MAX_LAMPS as f32));
    let mut draw = |lights| renderer.render(&lit(lights, Vec::new()), &settings).map(|picture| picture.color);
    let fault = draw(vec![lamp; MAX_LAMPS + 1]).unwrap_err().to_string();
    assert!(fault.contains("1025 lights exceed the limit of 1024"), "{fault}");
    let fault = draw(vec![lamp, PointLight::new(Vec3::NAN, Vec3::ONE)]).unwrap_err().to_string();
    assert!(fault.contains("light 2 has a number that is not finite"), "{fault}");
    let all = draw(vec![lamp; MAX_LAMPS]).unwrap();
    let one = draw(vec![PointLight::new(Vec3::Z, Vec3::ONE)]).unwrap();
    println!("{} lights: {:.1e}", MAX_LAMPS, worst(&all, &one));
    assert!(worst(&all, &one) < 1e-3);
}
