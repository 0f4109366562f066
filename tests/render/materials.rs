//! Materials that change over a surface, filtered: held against supersampled pictures of the same surface.

use crate::common::gpu::{TestGpu, test_gpu};
use crate::common::render::{bumps, under_sky};
use glam::Vec3;
use leadr::lab::metrics::compare::compare;
use leadr::maps::RgbImage;
use leadr::maps::material::alpha_code;
use leadr::maps::tonemap::Tonemap;
use leadr::reflectance::masking::shadowing::Shadowing;
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::light::sky::Sky;
use leadr::render::scene::{FrameState, MaterialMap, Object, Pose};
use leadr::render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr::render::surfaces::displacement::Border;
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::plane::{even, plane};
use leadr::scenes::sphere::{bake_tiles, displaced_sphere};

const GREY: [u8; 3] = [90; 3];
const SMOOTH: f32 = 0.1;
const ROUGH: f32 = 0.6;
/// Between both.
const THRESHOLD: f32 = 0.25;

/// How roughness is filtered.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Filtered {
    /// Two lobes.
    Mixed,
    /// One lobe of the mean `α²` (LEADR section 4.1).
    Variance,
    /// One lobe of the mean `α`.
    Mean,
}

fn dressed(width: u32, height: u32, alphas: Vec<f32>, filtered: Filtered) -> MaterialMap {
    let mean = alphas.iter().sum::<f32>() / alphas.len() as f32;
    let alpha = |alpha: f32| if filtered == Filtered::Mean { mean } else { alpha };
    let colors = alphas.iter().map(|&a| [GREY[0], GREY[1], GREY[2], alpha_code(alpha(a))]).collect();
    MaterialMap {
        rough_from: (filtered == Filtered::Mixed).then_some(THRESHOLD),
        ..MaterialMap::new(width, height, colors)
    }
}

/// A floor in whose mirror the sun stands, chequered in two roughnesses; a pixel sees several squares.
fn floor(gpu: &TestGpu, filtered: Filtered) -> Renderer {
    const TEXELS: u32 = 16;
    let checker = |i: u32| if (i % TEXELS / 8 + i / TEXELS / 8).is_multiple_of(2) { SMOOTH } else { ROUGH };
    let alphas = (0..TEXELS * TEXELS).map(checker).collect();
    let object = Object::new("floor", plane(4.0, 8, 0.05, [1.0; 4], even))
        .with_material(dressed(TEXELS, TEXELS, alphas, filtered))
        .with_specular_f0(0.3)
        .without_shadow();
    under_sky(gpu, vec![object], 64)
}

/// A bumpy sphere that is chequered in space.
fn sphere(gpu: &TestGpu, filtered: Filtered) -> Renderer {
    let (mut mesh, heights) = displaced_sphere(&bumps(256, 5.0, 3), 1.0, 8, 32, [1.0; 4]);
    let (layout, alphas) = bake_tiles(&mut mesh, 32, |p, _| {
        let cell = (p * 16.0).floor();
        if (cell.x + cell.y + cell.z).rem_euclid(2.0) < 0.5 { SMOOTH } else { ROUGH }
    });
    assert_eq!(heights.border, Border::Tiles(layout));
    let object = Object::new("sphere", mesh)
        .with_material(dressed(heights.width, heights.height, alphas, filtered))
        .with_heights(heights, 0.1)
        .with_specular_f0(0.3)
        .without_shadow();
    under_sky(gpu, vec![object], 64)
}

fn picture(renderer: &mut Renderer, camera: Camera, technique: Technique, samples: u32) -> RgbImage {
    let state = FrameState::new(camera, vec![Pose::REST]).under(&Sky::default());
    let settings = RenderSettings {
        size: (48, 48),
        samples,
        // As in the reference, whose bumps do not shadow each other.
        shading: technique.with(ShadingOptions { shadowing: Shadowing::None, ..Default::default() }),
        tessellation: TessellationSettings { to_texels: technique == Technique::Reference, ..Default::default() },
        shadows: false,
        ..Default::default()
    };
    let output = renderer.render(&state, &settings).unwrap();
    RgbImage::new(48, 48, output.color.iter().map(|c| [c[0], c[1], c[2]]).collect()).unwrap()
}

/// Relative RMSE of LEADR with so many samples against the reference with others, by how roughness is filtered.
fn errors(
    gpu: &TestGpu,
    scene: fn(&TestGpu, Filtered) -> Renderer,
    camera: Camera,
    [samples, of_truth]: [u32; 2],
) -> [f64; 3] {
    let truth = picture(&mut scene(gpu, Filtered::Mixed), camera, Technique::Reference, of_truth);
    [Filtered::Mixed, Filtered::Variance, Filtered::Mean].map(|filtered| {
        let one = picture(&mut scene(gpu, filtered), camera, Technique::Leadr, samples);
        let error = compare(&truth, &one, 1.0, Tonemap::Filmic).unwrap();
        println!("{filtered:?}: relative RMSE {:.4}, FLIP {:.4}", error.rrmse, error.flip);
        error.rrmse
    })
}

#[test]
fn two_roughnesses_keep_both_highlights() {
    let Some(gpu) = test_gpu() else { return };
    let sun = Sky::default().sun_direction.normalize();
    let mirrored = Vec3::new(-sun.x, -sun.y, sun.z);
    let camera = Camera::looking_at(6.0 * mirrored, Vec3::ZERO, 30.0);
    let [mixed, variance, mean] = errors(&gpu, floor, camera, [1, 256]);
    assert!(mixed < 0.25 * variance.min(mean), "{mixed} {variance} {mean}");
    // Filtered as a variance alone, the sharp highlight is lost.
    assert!(variance > 0.1);
}

#[test]
fn two_roughnesses_on_relief() {
    let Some(gpu) = test_gpu() else { return };
    let camera = Camera::looking_at(Vec3::new(0.6, -0.7, 0.3).normalize() * 16.0, Vec3::ZERO, 10.0);
    let [mixed, variance, mean] = errors(&gpu, sphere, camera, [16, 64]); // outlines are smooth in both
    assert!(mixed < 0.8 * variance.min(mean), "{mixed} {variance} {mean}");
}
