//! A height scale that varies over the surface, and a second layer that displaces it.

use glam::{Affine2, Vec2, Vec3};
use leadr::maps::RgbImage;
use leadr::maps::tonemap::Tonemap;
use leadr::reflectance::masking::shadowing::Shadowing;
use leadr::render::camera::Camera;
use leadr::render::frame::{Layer, Renderer};
use leadr::render::light::sky::Sky;
use leadr::render::scene::{Detail, DetailMapping, FactorMap, FrameState, Object, Pose, Tiling};
use leadr::render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr::render::surfaces::displacement::HeightField;
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::plane::{even, plane};
use leadr::scenes::sphere::displaced_sphere;
use leadr_testing::gpu::{TestGpu, test_gpu};
use leadr_testing::render::{bumps, under_sky};
use leadr_tools::metrics::compare::compare;
use std::f32::consts::TAU;

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
fn compare_constant(gpu: &TestGpu, of: &dyn Fn(f32) -> Object, without: &dyn Fn() -> Object) {
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

/// The root mean square of the numbers of a layer, or of the difference of two layers. Empty pixels count as 0.
fn rms(layer: &[[f32; 4]], other: Option<&[[f32; 4]]>) -> f64 {
    let number = |v: f32| if v.is_finite() { f64::from(v) } else { 0.0 };
    let at = |i: usize, k: usize| number(layer[i][k]) - other.map_or(0.0, |other| number(other[i][k]));
    let squares = (0..layer.len()).flat_map(|i| (0..4).map(move |k| at(i, k) * at(i, k)));
    (squares.sum::<f64>() / layer.len() as f64).sqrt()
}

/// The relative errors of depth, mean slope and covariance. The error of slopes is relative to their standard deviation too, because mean
/// slopes are nearly 0 at a distance.
fn apart(wanted: &[Vec<[f32; 4]>; 3], found: &[Vec<[f32; 4]>; 3]) -> [f64; 3] {
    let variance = wanted[2].iter().map(|s| f64::from(s[0] + s[1])).sum::<f64>() / wanted[2].len() as f64;
    let scale = [rms(&wanted[0], None), rms(&wanted[1], None).hypot(variance.sqrt()), rms(&wanted[2], None)];
    [0, 1, 2].map(|i| rms(&wanted[i], Some(&found[i])) / scale[i])
}

/// Slopes of the base roughness of [`rough_plane`], per axis: near the viewer, the covariance of the relief itself is nearly 0.
const BASE: f32 = 0.5 * 0.25 * 0.25;

/// The depth, the mean slope, and the slope covariance with the base roughness.
fn layers_of(renderer: &mut Renderer) -> [Vec<[f32; 4]>; 3] {
    let [depth, slope, mut covariance] =
        [Layer::Depth, Layer::MeanSlope, Layer::Covariance].map(|layer| renderer.layer(layer).unwrap());
    covariance.iter_mut().for_each(|[xx, yy, ..]| (*xx, *yy) = (*xx + BASE, *yy + BASE));
    [depth, slope, covariance]
}

/// A map that varies, against the finite differences of the product of both as one height map.
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
        (
            "relief",
            bumps(SIDE, 24.0, 5),
            [[1e-4, 1e-3, 5e-4, 5e-4], [4e-4, 3e-3, 1.5e-3, 1e-3], [1e-4, 4e-3, 2.5e-3, 2e-3]],
        ),
        ("raised relief", raised, [[1e-4, 7e-3, 1.5e-3, 4e-3], [3e-4, 9e-3, 6e-3, 4e-3], [1e-4, 9e-3, 0.02, 3e-3]]),
        ("level", level, [[1e-4, 7e-3, 2e-3, 4e-3], [1e-4, 8e-3, 4e-3, 4e-3], [1e-4, 9e-3, 0.016, 3e-3]]),
    ];
    let mut faults = Vec::new();
    for (name, heights, most) in cases {
        let mut one = under_sky(&gpu, vec![rough_plane(product(heights.clone(), &scale))], 32);
        let mut two = under_sky(&gpu, vec![rough_plane(heights).with_height_scale_map(scale.clone())], 32);
        for (distance, most) in DISTANCES.into_iter().zip(most) {
            let state = seen_from(distance);
            let settings = settings(Technique::Leadr, 1);
            let pictures = [&mut one, &mut two].map(|renderer| picture(renderer, &state, &settings));
            let [a, b] = [&mut one, &mut two].map(layers_of);
            let [depth, slope, covariance] = apart(&a, &b);
            let found = [depth, slope, covariance, error(&pictures[0], &pictures[1])];
            println!("{name}, {distance} m: {found:.4?}");
            if found.iter().zip(most).any(|(found, most)| *found > most) {
                faults.push(format!("{name}, {distance} m: {found:?}"));
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
    gpu.assert_silent();
}

/// Texels along a detail, and its repeats. Its texels are as wide as those of the base.
const FINE: u32 = 64;

/// A plane with a base and a finer layer, in metres, as a detail that displaces, as one map of the sum, or with the detail in shading only.
fn layered(gpu: &TestGpu, kind: Layers, masked: bool) -> Renderer {
    let (mut base, mut fine) = (bumps(SIDE, 24.0, 5), bumps(FINE, 5.0, 9));
    base.map.texels.iter_mut().for_each(|height| *height *= STEEP);
    fine.map.texels.iter_mut().for_each(|height| *height *= 0.25 * STEEP);
    let mask = map_of(SIDE, |s, _| if masked { wave(s) } else { 1.0 });
    if kind == Layers::Sum {
        for (i, height) in (0..).zip(&mut base.map.texels) {
            let (x, y) = (i % SIDE, i / SIDE);
            *height += mask.texels[i as usize] * fine.map.texels[(y % FINE * FINE + x % FINE) as usize];
        }
    }
    let detail = (kind != Layers::Sum).then(|| Detail {
        heights: fine,
        slopes: None,
        material: None,
        mapping: DetailMapping::Texcoords,
        transform: Affine2::from_scale(Vec2::splat((SIDE / FINE) as f32)),
        mask: masked.then_some(mask),
        displaces: kind == Layers::Displaces,
    });
    let object = Object {
        height_scale: 0.5,
        ..rough_plane(HeightField {
            map: leadr::maps::HeightMap { texels: base.map.texels.iter().map(|h| 2.0 * h).collect(), ..base.map },
            ..base
        })
    };
    under_sky(gpu, vec![detail.into_iter().fold(object, Object::with_detail)], 32)
}

#[derive(Clone, Copy, PartialEq)]
enum Layers {
    Displaces,
    ShadingOnly,
    Sum,
}

/// Depth, covered pixels, slopes and pictures of two layers against one map of the sum; the depth and the outline of a detail in shading only
/// are farther away.
#[test]
fn a_displacing_detail_equals_a_map_of_the_sum() {
    let Some(gpu) = test_gpu() else { return };
    let mut faults = Vec::new();
    for masked in [false, true] {
        let mut of = [Layers::Sum, Layers::Displaces, Layers::ShadingOnly].map(|kind| layered(&gpu, kind, masked));
        for (distance, most) in DISTANCES.into_iter().zip(MOST_LAYERED) {
            // Far away, the plane is thinner than a pixel at grazing angles.
            for grazing in [false, true].into_iter().filter(|grazing| !grazing || distance < 10.0) {
                let direction = if grazing { Vec3::new(0.3, -0.95, 0.03) } else { Vec3::new(0.3, -0.7, 0.55) };
                let camera = Camera::looking_at(direction.normalize() * distance, Vec3::ZERO, 30.0);
                let state = FrameState::new(camera, vec![Pose::REST]).under(&Sky::default());
                let settings = settings(Technique::Leadr, 1);
                let found = of.each_mut().map(|renderer| {
                    let picture = picture(renderer, &state, &settings);
                    (picture, layers_of(renderer))
                });
                let [sum, displaced, shaded] = &found;
                let errors = |other: &(RgbImage, [Vec<[f32; 4]>; 3])| {
                    let [depth, slope, covariance] = apart(&sum.1, &other.1);
                    [depth, slope, covariance, error(&sum.0, &other.0)]
                };
                let outline = |other: &(RgbImage, [Vec<[f32; 4]>; 3])| {
                    let covered = |pixel: &[f32; 4]| pixel[0].is_finite();
                    sum.1[0].iter().zip(&other.1[0]).filter(|(a, b)| covered(a) != covered(b)).count()
                };
                let (near, far) = (errors(displaced), errors(shaded));
                let (same, other) = (outline(displaced), outline(shaded));
                println!(
                    "masked {masked}, {distance} m, grazing {grazing}: {near:.4?} against {far:.4?}; outline {same} against {other}"
                );
                let drawn = distance > 2.0 || near[0] < 0.1 * far[0];
                if near.iter().zip(most).any(|(found, most)| *found > most) || !drawn || same > other.max(2) {
                    faults.push(format!(
                        "masked {masked}, {distance} m, grazing {grazing}: {near:?} {far:?} {same} {other}"
                    ));
                }
            }
        }
    }
    assert!(faults.is_empty(), "{faults:#?}");
    gpu.assert_silent();
}

/// The largest errors of depth, mean slope, covariance and picture at each distance.
const MOST_LAYERED: [[f64; 4]; 3] = [[3e-3, 3e-3, 0.015, 0.016], [0.012, 0.012, 0.025, 5e-3], [1e-4, 6e-4, 3e-3, 2e-4]];

#[test]
fn the_height_scale_of_the_frame_applies_to_a_displacing_detail() {
    let Some(gpu) = test_gpu() else { return };
    let state = FrameState { height_scale: 0.0, ..seen_from(1.5) };
    let settings = settings(Technique::Leadr, 1);
    let [sum, layers] = [Layers::Sum, Layers::Displaces].map(|kind| {
        let mut renderer = layered(&gpu, kind, false);
        picture(&mut renderer, &state, &settings)
    });
    assert!(error(&sum, &layers) < 1e-5, "{}", error(&sum, &layers));
}

/// One sample against supersampling, with a scale that varies and with the same heights scaled before filtering.
#[test]
fn a_varying_scale_is_filtered() {
    let Some(gpu) = test_gpu() else { return };
    let scale = map_of(SIDE, |s, _| wave(s));
    let heights = bumps(SIDE, 24.0, 5);
    let mut varied =
        under_sky(&gpu, vec![rough_plane(heights.clone()).with_height_scale_map(scale.clone()).without_shadow()], 32);
    let mut baked = under_sky(&gpu, vec![rough_plane(product(heights, &scale)).without_shadow()], 32);
    for distance in [12.0, 60.0] {
        let camera = Camera::looking_at(Vec3::new(0.1, -0.3, 0.95).normalize() * distance, Vec3::ZERO, 6.0);
        let state = FrameState::new(camera, vec![Pose::REST]).under(&Sky::default());
        let options = ShadingOptions { relief_occlusion: false, shadowing: Shadowing::None, ..Default::default() };
        let of = |renderer: &mut Renderer, technique: Technique, samples| {
            let shading = technique.with(options);
            let settings = RenderSettings { size: (16, 16), shadows: false, shading, ..settings(technique, samples) };
            picture(renderer, &state, &settings)
        };
        let truth = of(&mut baked, Technique::Reference, 36);
        let own = error(&truth, &of(&mut baked, Technique::Leadr, 1));
        let found = error(&truth, &of(&mut varied, Technique::Leadr, 1));
        let reference = error(&truth, &of(&mut varied, Technique::Reference, 36));
        println!("{distance} m: {found:.4}, of scaled heights {own:.4}; between the references {reference:.4}");
        assert!(found < 1.1 * own + 0.003 && reference < 0.01, "{found} {own} {reference}");
    }
}
