//! A height scale that varies over the surface.

use std::f32::consts::TAU;
use std::sync::Arc;

use glam::{Affine2, Vec2, Vec3};
use leadr::gpu::Gpu;
use leadr::maps::RgbImage;
use leadr::maps::tonemap::Tonemap;
use leadr::render::camera::Camera;
use leadr::render::frame::{Layer, Renderer};
use leadr::render::light::sky::Sky;
use leadr::render::scene::{FactorMap, FrameState, Object, Pose, Tiling};
use leadr::render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr::render::surfaces::displacement::HeightField;
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::plane::{even, plane};
use leadr::scenes::sphere::displaced_sphere;
use leadr_testing::gpu::test_gpu;
use leadr_testing::render::{bumps, under_sky};
use leadr_tools::metrics::compare::compare;

fn picture(renderer: &mut Renderer, state: &FrameState, settings: &RenderSettings) -> RgbImage {
    let output = renderer.render(state, settings).unwrap();
    let (width, height) = output.size;
    RgbImage::new(width, height, output.color.iter().map(|c| [c[0], c[1], c[2]]).collect()).unwrap()
}

fn error(truth: &RgbImage, test: &RgbImage) -> f64 {
    compare(truth, test, 1.0, Tonemap::Filmic).unwrap().rrmse
}

/// Side of the maps in texels.
const SIDE: u32 = 256;
/// Width of one repeat in metres.
const METRES: f32 = 2.0;
/// Height of the relief in metres.
const STEEP: f32 = 0.1;

fn rough_plane(heights: HeightField) -> Object {
    let mesh = plane(4.0, 16, METRES, [0.4, 0.35, 0.3, 0.25], even);
    Object::new("plane", mesh).with_specular_f0(0.1).with_heights(heights, STEEP)
}

/// A height scale that varies once per repeat, from 0.2 to 1.
fn wave(s: f32) -> f32 {
    0.6 + 0.4 * (TAU * s).cos()
}

fn map_of(side: u32, factor: impl Fn(f32, f32) -> f32) -> FactorMap {
    let at = |i: u32| (i as f32 + 0.5) / side as f32;
    let texels = (0..side * side).map(|i| factor(at(i % side), at(i / side))).collect();
    FactorMap { width: side, height: side, texels, transform: Affine2::IDENTITY }
}

/// The product of heights and a height scale, texel by texel.
fn product(mut heights: HeightField, scale: &FactorMap) -> HeightField {
    heights.map.texels.iter_mut().zip(&scale.texels).for_each(|(height, factor)| *height *= factor);
    heights
}

fn seen_from(distance: f32) -> FrameState {
    let camera = Camera::looking_at(Vec3::new(0.3, -0.7, 0.55).normalize() * distance, Vec3::ZERO, 30.0);
    FrameState::new(camera, vec![Pose::REST]).under(&Sky::default())
}

fn settings(technique: Technique, samples: u32) -> RenderSettings {
    RenderSettings {
        size: (64, 64),
        samples,
        shading: technique.with(ShadingOptions::default()),
        tessellation: TessellationSettings { to_texels: technique == Technique::Reference, ..Default::default() },
        ..Default::default()
    }
}

const DISTANCES: [f32; 3] = [1.5, 6.0, 60.0];

/// Pictures of objects with a constant height scale, and of the same object without it, at a factor on all heights.
fn compare_constant(gpu: &Arc<Gpu>, of: &dyn Fn(f32) -> Object, without: &dyn Fn() -> Object) {
    for factor in [1.0, 0.5] {
        let (mut varied, mut alike) = (under_sky(gpu, vec![of(factor)], 32), under_sky(gpu, vec![without()], 32));
        for distance in DISTANCES {
            let state = seen_from(distance);
            let scaled = FrameState { height_scale: factor, ..state.clone() };
            let settings = settings(Technique::Leadr, 1);
            let (wanted, found) = (picture(&mut alike, &scaled, &settings), picture(&mut varied, &state, &settings));
            let apart = error(&wanted, &found);
            println!("factor {factor}, {distance} m: relative RMSE {apart:.1e}");
            if factor == 1.0 {
                assert_eq!(wanted.texels, found.texels, "{distance} m");
            } else {
                assert!(apart < 1e-5, "{distance} m: {apart}");
            }
        }
    }
    gpu.assert_silent();
}

#[test]
fn a_constant_map_is_a_factor() {
    let Some(gpu) = test_gpu() else { return };
    for tiling in [Tiling::Repeats, Tiling::ByExample] {
        let without = || rough_plane(bumps(SIDE, 24.0, 5)).with_tiling(tiling);
        compare_constant(&gpu, &|factor| without().with_height_scale_map(map_of(4, |_, _| factor)), &without);
    }
}

#[test]
fn constant_vertices_are_a_factor() {
    let Some(gpu) = test_gpu() else { return };
    let sphere = || {
        let (mesh, heights) = displaced_sphere(&bumps(64, 4.0, 11), 1.0, 6, 32, [0.4, 0.35, 0.3, 0.25]);
        Object::new("sphere", mesh).with_heights(heights, 0.04)
    };
    let varied = |factor: f32| {
        let mut object = sphere();
        object.mesh.height_scales = vec![factor; object.mesh.positions.len()];
        object
    };
    compare_constant(&gpu, &varied, &sphere);
}

/// The difference of two layers relative to the root mean square of the first.
fn relative(wanted: &[[f32; 4]], found: &[[f32; 4]]) -> f64 {
    let numbers = |layer: &[[f32; 4]]| -> Vec<f64> {
        layer.iter().flatten().map(|v| if v.is_finite() { f64::from(*v) } else { 0.0 }).collect()
    };
    let (a, b) = (numbers(wanted), numbers(found));
    let difference: f64 = a.iter().zip(&b).map(|(a, b)| (a - b) * (a - b)).sum();
    (difference / a.iter().map(|a| a * a).sum::<f64>()).sqrt()
}

/// A map and vertices that vary, against the finite differences of the product of both as one height map.
#[test]
fn a_varying_scale_equals_scaled_heights() {
    let Some(gpu) = test_gpu() else { return };
    let scale = map_of(SIDE, |s, t| wave(s) * (1.0 - 0.2 * (TAU * t).sin()).min(1.0));
    let mut raised = bumps(SIDE, 24.0, 5);
    raised.map.texels.iter_mut().for_each(|height| *height += 1.0);
    let level = HeightField {
        map: leadr::maps::HeightMap { texels: vec![1.0; (SIDE * SIDE) as usize], ..raised.map.clone() },
        ..raised
    };
    // The largest errors of depth, mean slope, covariance and picture, at each distance.
    let cases = [
        ("relief", bumps(SIDE, 24.0, 5), [[1e-3, 0.02, 0.05, 0.02]; 3]),
        ("raised relief", raised, [[1e-3, 0.02, 0.05, 0.02]; 3]),
        ("level", level, [[1e-3, 0.02, 0.05, 0.02]; 3]),
    ];
    for (name, heights, most) in cases {
        let mut one = under_sky(&gpu, vec![rough_plane(product(heights.clone(), &scale))], 32);
        let mut two = under_sky(&gpu, vec![rough_plane(heights).with_height_scale_map(scale.clone())], 32);
        for (distance, most) in DISTANCES.into_iter().zip(most) {
            let state = seen_from(distance);
            let settings = settings(Technique::Leadr, 1);
            let pictures = [&mut one, &mut two].map(|renderer| picture(renderer, &state, &settings));
            let layers = [Layer::Depth, Layer::MeanSlope, Layer::Covariance];
            let [a, b] = [&mut one, &mut two].map(|renderer| layers.map(|layer| renderer.layer(layer).unwrap()));
            let [depth, slope, covariance] = [0, 1, 2].map(|i| relative(&a[i], &b[i]));
            let found = [depth, slope, covariance, error(&pictures[0], &pictures[1])];
            println!("{name}, {distance} m: {found:.4?}");
            assert!(found.iter().zip(most).all(|(found, most)| *found < most), "{name}, {distance} m: {found:?}");
        }
    }
    gpu.assert_silent();
}
