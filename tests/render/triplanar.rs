//! Relief on triangles without texture coordinates, against the same blend baked into tiles, and against the finest maps.

use crate::classes::hard_edges;
use crate::reference::{mean, renderer, state};
use glam::{Affine3A, Quat, Vec3};
use leadr::maps::RgbImage;
use leadr::render::camera::Camera;
use leadr::render::scene::{FrameState, Object, Pose, Sun};
use leadr::render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr::render::surfaces::displacement::HeightField;
use leadr::render::surfaces::patch_mesh::PatchMesh;
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::plane::{even, plane};
use leadr::scenes::sphere::{cube_sphere, displaced_sphere};
use leadr_testing::gpu::{TestGpu, test_gpu};
use leadr_testing::render::{bumps, under_sky};
use leadr_tools::metrics::compare::rrmse;

const GREY: [f32; 4] = [0.5, 0.5, 0.5, 0.3];
/// Metres per repeat.
const REPEAT: f32 = 0.7;
/// RMS slope.
const STEEPNESS: f32 = 0.45;

fn relief() -> HeightField {
    let mut field = bumps(128, 5.0, 7);
    let mean = field.map.texels.iter().sum::<f32>() / field.map.texels.len() as f32;
    field.map.texels.iter_mut().for_each(|height| *height -= mean);
    field
}

/// A unit sphere of triangles.
fn ball(repeat: f32, field: HeightField) -> Object {
    let quads = cube_sphere(24, GREY);
    let halves = |&[a, b, c, d]: &[u32; 4]| [[a, b, c, c], [a, c, d, d]];
    let mesh = PatchMesh {
        patches: quads.patches.iter().flat_map(halves).collect(),
        texcoords: vec![Default::default(); 2 * quads.patches.len()],
        triangles: true,
        triplanar: Some(repeat),
        ..quads
    };
    Object::new("ball", mesh).with_heights(field, STEEPNESS * REPEAT)
}

/// The same sphere in patches with the blend in tiles.
fn tiled() -> Object {
    let (mesh, heights) = displaced_sphere(&relief(), REPEAT, 12, 16, GREY);
    Object::new("tiled", mesh).with_heights(heights, STEEPNESS * REPEAT)
}

/// A picture of the sphere, lit from the left, centred on the point where three projections meet.
fn picture(
    gpu: &TestGpu,
    object: Object,
    technique: Technique,
    distance: f32,
    samples: u32,
    occlusion: bool,
) -> RgbImage {
    let camera = Camera::looking_at(Vec3::new(1.0, -0.8, 0.9).normalize() * distance, Vec3::ZERO, 35.0);
    let sun = Sun { direction: Vec3::new(0.2, -0.9, 0.6).normalize(), irradiance: Vec3::splat(2.0) };
    let state = FrameState { sun: Some(sun), ..FrameState::new(camera, vec![Pose::REST]) };
    let shading = technique.with(ShadingOptions { relief_occlusion: occlusion, ..Default::default() });
    let tessellation = TessellationSettings { to_texels: technique.is_reference(), ..Default::default() };
    let size = ((570.0 / distance) as u32).clamp(16, 96);
    let settings =
        RenderSettings { size: (size, size), samples, shading, tessellation, shadows: false, ..Default::default() };
    under_sky(gpu, vec![object], 32).render(&state, &settings).unwrap().image()
}

#[test]
#[ignore = "long"]
fn triangles_show_the_blend_in_the_tiles() {
    let Some(gpu) = test_gpu() else { return };
    // Tiles search for horizons only within a few texels.
    let shot = |object| picture(&gpu, object, Technique::Leadr, 6.0, 48, false);
    let tiles = shot(tiled());
    let error = |object| rrmse(&tiles, &shot(object)).unwrap();
    let (same, other) = (error(ball(REPEAT, relief())), error(ball(1.1 * REPEAT, relief())));
    println!("{same:.4}, of another repeat {other:.4}");
    assert!(same < 0.035 && other > 3.0 * same, "{same} {other}");
}

#[test]
#[ignore = "long"]
fn one_sample_matches_many_samples_of_finest_maps() {
    let Some(gpu) = test_gpu() else { return };
    for distance in [12.0, 36.0] {
        let shot = |technique, samples| picture(&gpu, ball(REPEAT, relief()), technique, distance, samples, true);
        let reference = shot(Technique::Reference, 64);
        let error = |technique| rrmse(&reference, &shot(technique, 16)).unwrap();
        let (leadr, normal_mip) = (error(Technique::Leadr), error(Technique::NormalMip));
        println!("at {distance} m: LEADR {leadr:.4}, mipmapped normals {normal_mip:.4}");
        assert!(leadr < 0.05 && normal_mip > 2.0 * leadr, "{distance}: {leadr} {normal_mip}");
    }
}

/// A plate of triangles that faces along `normal` at rest, with bricks. The pose lays it flat.
fn plate(normal: Vec3) -> (Object, Pose) {
    let quads = plane(1.5, 6, 1.0, [1.0; 4], even);
    let upright = Quat::from_rotation_arc(Vec3::Z, normal);
    let halves = |&[a, b, c, d]: &[u32; 4]| [[a, b, c, c], [a, c, d, d]];
    let mesh = PatchMesh {
        positions: quads.positions.iter().map(|&p| upright * p).collect(),
        normals: vec![normal; quads.positions.len()],
        patches: quads.patches.iter().flat_map(halves).collect(),
        texcoords: vec![Default::default(); 2 * quads.patches.len()],
        triangles: true,
        triplanar: Some(1.0),
        ..quads
    };
    let bricks = hard_edges(true);
    let depth = 4.0 / bricks.width as f32;
    let object = Object::new("plate", mesh).with_heights(HeightField::repeating(bricks), depth).with_specular_f0(0.0);
    let pose = Pose::Rigid(Affine3A::from_quat(upright.inverse()));
    (Object { casts_shadow: true, ..object }, pose)
}

/// One pixel of bricks in each projection, from both sides and where two projections meet, against the reference with shadows of the relief.
#[test]
fn projected_bricks_follow_the_reference() {
    let Some(gpu) = test_gpu() else { return };
    let mut worst = [0.0f64; 2];
    for normal in [Vec3::X, Vec3::NEG_Y, Vec3::NEG_Z, Vec3::new(1.0, 0.0, 1.0).normalize()] {
        let (object, pose) = plate(normal);
        let mut renderer = renderer(&gpu, object, 0.0);
        let mut errors = [0.0f64; 2];
        for sun in [Vec3::new(1.0, 0.2, 0.7), Vec3::new(0.3, 1.0, 0.5), Vec3::new(-0.8, 0.4, 0.6)] {
            let state = FrameState { poses: vec![pose.clone()], ..state(Some(sun.normalize())) };
            let mut radiance = |technique: Technique, classes| {
                let relief_shadows = technique.is_reference();
                let settings = RenderSettings {
                    size: if relief_shadows { (128, 64) } else { (2, 1) },
                    samples: if relief_shadows { 4 } else { 1 },
                    shading: technique.with(ShadingOptions { relief_shadows, classes, ..Default::default() }),
                    tessellation: TessellationSettings { to_texels: true, ..Default::default() },
                    shadows: false,
                    ..Default::default()
                };
                mean(&renderer.render(&state, &settings).unwrap().color)
            };
            let truth = radiance(Technique::Reference, false);
            for (error, classes) in errors.iter_mut().zip([true, false]) {
                let found = radiance(Technique::Leadr, classes);
                println!("{normal:.2?}, {sun:.2?}, classes {classes}: {found:.4} of {truth:.4}");
                *error = error.max((found / truth - 1.0).abs());
            }
        }
        assert!(errors[0] < 0.1 && errors[0] < 0.7 * errors[1], "{normal}: {errors:?}");
        (0..2).for_each(|i| worst[i] = worst[i].max(errors[i]));
    }
    println!("at most {worst:.3?}");
}
