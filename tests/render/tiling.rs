//! Planes with tiling by example.

use glam::{Affine3A, Vec3};
use leadr::maps::{HeightMap, LeadrMap, RgbImage, Wrap, procedural};
use leadr::render::camera::Camera;
use leadr::render::frame::Layer;
use leadr::render::scene::{FrameState, MaterialMap, Object, Pose, Tiling};
use leadr::render::settings::RenderSettings;
use leadr::render::surfaces::displacement::HeightField;
use leadr::scenes::ground::ground;
use leadr::scenes::plane::{even, plane};
use leadr::scenes::shore::sand::{SQUARE, dry};
use leadr_testing::gpu::test_gpu;
use leadr_testing::render::under_sky;
use leadr_tools::metrics::repetition::repetition;

fn settings(size: u32) -> RenderSettings {
    RenderSettings { size: (size, size), samples: 1, shadows: false, ..Default::default() }
}

/// From above, with a picture `metres` wide.
fn from_above(metres: f32) -> Camera {
    let eye = Vec3::new(3.0, -2.0, metres / 2.0 / 15f32.to_radians().tan());
    Camera { up: Vec3::Y, ..Camera::looking_at(eye, Vec3::new(3.0, -2.0, 0.0), 30.0) }
}

/// The device blends moments like crates/leadr-maps/tests/maps/tiling.rs: mean and variance equal the map's, for any footprint.
#[test]
fn pixels_of_a_plane_by_example_have_the_statistics_of_its_map() {
    let Some(gpu) = test_gpu() else { return };
    let bumps = procedural::gaussian(256, 256, 4, 0.05, 0.01);
    let sand = dry();
    let heights = sand.heights.iter().map(|metres| metres / SQUARE).collect();
    let sand = HeightMap::new(sand.width, sand.height, heights).unwrap();
    for (name, map) in [("bumps", bumps), ("sand", sand)] {
        let whole = LeadrMap::new(&map, Wrap::Repeat).mean();
        let object = Object::new(name, plane(40.0, 16, 1.0, [0.5; 4], even))
            .with_heights(HeightField::repeating(map), 1.0)
            .with_tiling(Tiling::ByExample)
            .without_shadow();
        let mut renderer = under_sky(&gpu, vec![object], 16);
        for metres in [4.0, 12.0, 40.0] {
            let state = FrameState::new(from_above(metres), vec![Pose::REST]);
            renderer.render(&state, &settings(160)).unwrap();
            let means = renderer.layer(Layer::MeanSlope).unwrap();
            let covariances = renderer.layer(Layer::Covariance).unwrap();
            let count = means.len() as f64;
            for axis in 0..2 {
                let mean = means.iter().map(|m| f64::from(m[axis])).sum::<f64>() / count;
                let square = |(m, s): (&[f32; 4], &[f32; 4])| f64::from(m[axis] * m[axis] + s[axis]);
                let variance = means.iter().zip(&covariances).map(square).sum::<f64>() / count;
                let expected = f64::from(whole.second[axis]);
                println!("{name}, {metres} m, axis {axis}: {:.3}", variance / expected);
                assert!(
                    (variance / expected - 1.0).abs() < 0.05,
                    "{name}, {metres} m, axis {axis}: {variance} {expected}"
                );
                assert!(mean.abs() < 0.05 * expected.sqrt(), "{name}, {metres} m, axis {axis}: {mean}");
            }
        }
    }
}

/// The far picture of the T-rex used to repeat every 5 m.
#[test]
fn the_ground_does_not_repeat_itself() {
    let Some(gpu) = test_gpu() else { return };
    let seen = |tiling: Tiling| {
        let mut renderer = under_sky(&gpu, vec![ground().with_tiling(tiling)], 16);
        let state = FrameState::new(from_above(30.0), vec![Pose::REST]);
        let output = renderer.render(&state, &settings(192)).unwrap();
        let picture = RgbImage::new(192, 192, output.color.iter().map(|c| [c[0], c[1], c[2]]).collect()).unwrap();
        [[32, 0], [0, 32]].map(|lag| repetition(&picture, lag)).into_iter().fold(f64::MIN, f64::max)
    };
    let (repeats, ground) = (seen(Tiling::Repeats), seen(Tiling::Ground));
    println!("side by side {repeats:.2}, without repeats {ground:.2}");
    assert!(repeats > 0.6, "{repeats}");
    assert!(ground < 0.3, "{ground}");
}

/// Features of the ground stay in place while its mesh follows the viewer.
#[test]
fn the_ground_stays_in_the_world() {
    let Some(gpu) = test_gpu() else { return };
    let mut renderer = under_sky(&gpu, vec![ground()], 16);
    let mut albedo = |moved: f32| {
        let pose = Pose::Rigid(Affine3A::from_translation(Vec3::new(moved, 2.0 * moved, 0.0)));
        renderer.render(&FrameState::new(from_above(12.0), vec![pose]), &settings(96)).unwrap();
        renderer.layer(Layer::Albedo).unwrap()
    };
    let apart = |a: &[[f32; 4]], b: &[[f32; 4]]| {
        a.iter().zip(b).map(|(a, b)| (a[0] - b[0]).abs()).sum::<f32>() / a.len() as f32
    };
    let [here, stepped, slid] = [0.0, 5.0, 0.37].map(&mut albedo);
    // The displaced triangles differ, so the points seen by pixels change slightly.
    let (stepped, slid) = (apart(&here, &stepped), apart(&here, &slid));
    assert!(stepped < 0.01 && slid < 0.01, "{stepped} {slid}");
}

/// Repeat of the hills of [`sand`], metres.
const HILLS: f32 = 2.0 * SQUARE;

/// The dry sand of the shore on low hills.
fn sand(tiling: Tiling) -> Object {
    let mut mesh = plane(2.0 * HILLS, 64, SQUARE, [1.0; 4], even);
    mesh.flat_repeat = None;
    let turn = std::f32::consts::TAU / HILLS;
    for (position, normal) in mesh.positions.iter_mut().zip(&mut mesh.normals) {
        position.z = 0.5 * (turn * (position.x + position.y)).sin();
        let slope = 0.5 * turn * (turn * (position.x + position.y)).cos();
        *normal = Vec3::new(-slope, -slope, 1.0).normalize();
    }
    let map = dry();
    let heights = HeightField::repeating(HeightMap { width: map.width, height: map.height, texels: map.heights });
    Object::new("sand", mesh)
        .with_heights(heights, 1.0)
        .with_material(MaterialMap::new(map.width, map.height, map.colors))
        .with_tiling(tiling)
        .without_shadow()
}

/// Towards the horizon the shore's sand used to show the grid of its repeats.
#[test]
fn sand_on_hills_does_not_repeat_itself() {
    let Some(gpu) = test_gpu() else { return };
    let seen = |tiling: Tiling| {
        let mut renderer = under_sky(&gpu, vec![sand(tiling)], 16);
        renderer.render(&FrameState::new(from_above(60.0), vec![Pose::REST]), &settings(192)).unwrap();
        let albedo = renderer.layer(Layer::Albedo).unwrap();
        let picture = RgbImage::new(192, 192, albedo.iter().map(|c| [c[0], c[1], c[2]]).collect()).unwrap();
        [[64, 0], [0, 64]].map(|lag| repetition(&picture, lag)).into_iter().fold(f64::MIN, f64::max)
    };
    let [repeats, alone] = [Tiling::Repeats, Tiling::ByExample].map(seen);
    println!("side by side {repeats:.2}, by example {alone:.2}");
    assert!(repeats > 0.6, "{repeats}");
    assert!(alone < 0.3, "{alone}");
}

/// With only one variant the result is the repeated map, drawn by other shaders.
#[test]
#[ignore = "long"]
fn one_look_is_the_map_as_it_is() {
    let Some(gpu) = test_gpu() else { return };
    let seen = |tiling: Tiling, layer: Layer| {
        let mut renderer = under_sky(&gpu, vec![sand(tiling)], 16);
        renderer.render(&FrameState::new(from_above(12.0), vec![Pose::REST]), &settings(96)).unwrap();
        renderer.layer(layer).unwrap()
    };
    for layer in [Layer::Albedo, Layer::MeanSlope, Layer::Covariance, Layer::Depth] {
        let [repeats, one, example] =
            [Tiling::Repeats, Tiling::OneVariant, Tiling::ByExample].map(|tiling| seen(tiling, layer));
        let apart = |other: &[[f32; 4]]| {
            let square = |(a, b): (&[f32; 4], &[f32; 4])| (0..4).map(|i| (a[i] - b[i]).powi(2)).sum::<f32>();
            (repeats.iter().zip(other).map(square).sum::<f32>() / other.len() as f32).sqrt()
        };
        let (one, example) = (apart(&one), apart(&example));
        println!("{layer:?}: one look {one:.1e}, by example {example:.1e}");
        // Here heights along patch edges are looked up; repeated maps bake them. Hardware blends texels in steps: 1.1e-3 of the albedo on
        // an H100.
        let blended = if gpu.is_software() { 1e-3 } else { 2e-3 };
        let most = if layer == Layer::Depth { 0.05 } else { blended };
        assert!(one < most * example, "{layer:?}: {one:e} of {example:e}");
    }
}

/// A mesh of hills that follows the viewer by whole repeats leaves its sand in place.
#[test]
fn sand_on_hills_stays_in_the_world() {
    let Some(gpu) = test_gpu() else { return };
    let apart = |tiling: Tiling| {
        let mut renderer = under_sky(&gpu, vec![sand(tiling)], 16);
        let [here, there] = [0.0, HILLS].map(|moved| {
            let pose = Pose::Rigid(Affine3A::from_translation(Vec3::new(0.0, moved, 0.0)));
            renderer.render(&FrameState::new(from_above(12.0), vec![pose]), &settings(96)).unwrap();
            renderer.layer(Layer::Albedo).unwrap()
        });
        here.iter().zip(&there).map(|(a, b)| (a[0] - b[0]).abs()).sum::<f32>() / here.len() as f32
    };
    let [moves, stays] = [Tiling::ByExample, Tiling::ByExampleInWorld].map(apart);
    println!("moves {moves:.5}, stays {stays:.5}");
    assert!(stays < 1e-4 && moves > 10.0 * stays, "{stays} {moves}");
}
