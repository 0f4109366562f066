//! Relief with hard edges, shaded by classes of facets: one sample of LEADR against the reference with shadows of the relief, and white
//! reliefs in a furnace.

use crate::reference::{VIEW, mean, renderer, state};
use glam::{Affine3A, Quat, Vec2, Vec3};
use leadr::maps::cache::MapCache;
use leadr::maps::{HeightMap, RgbImage, procedural};
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::light::environment::Environment;
use leadr::render::scene::{FrameState, Object, Pose, Scene, Sun};
use leadr::render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr::render::surfaces::displacement::HeightField;
use leadr::render::surfaces::patch_mesh::{PatchMesh, TileLayout};
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::plane::{even, plane};
use leadr::scenes::sphere::{bake_tiles, tiled};
use leadr_testing::gpu::{TestGpu, test_gpu};
use leadr_tools::metrics::compare::rrmse;

const CELLS: u32 = 64;

/// Heights of bricks in two rows per repeat, with sloping sides, or of grooves across x.
pub fn hard_edges(bricks: bool) -> HeightMap {
    let side = |x: f32, period: f32| {
        let x = (x / period).fract() * period;
        (0.35 * x.min(period - x)).min(1.0)
    };
    let height = |i: u32| {
        let (x, y) = ((i % CELLS) as f32 + 0.5, (i / CELLS) as f32 + 0.5);
        let shifted = if (y as u32 / 16).is_multiple_of(2) { x } else { x + 16.0 };
        if bricks { side(shifted, 32.0).min(side(y, 16.0)) } else { side(x, 16.0) }
    };
    HeightMap { width: CELLS, height: CELLS, texels: (0..CELLS * CELLS).map(height).collect() }
}

/// Three by three repeats of one metre. `depth` is the height of 1 in texels.
fn surface(map: HeightMap, depth: f32) -> Object {
    let mesh = plane(1.5, 3 * CELLS / 32, 1.0, [1.0; 4], even);
    let heights = HeightField::repeating(map);
    let object = Object::new("plane", mesh).with_heights(heights, depth / CELLS as f32).with_specular_f0(0.0);
    Object { casts_shadow: true, ..object }
}

fn radiance(renderer: &mut Renderer, sun: Option<Vec3>, technique: Technique, options: ShadingOptions) -> f64 {
    let reference = technique.is_reference();
    let settings = RenderSettings {
        size: if reference { (128, 64) } else { (2, 1) },
        samples: if reference { 4 } else { 1 },
        shading: technique.with(ShadingOptions { relief_shadows: reference, ..options }),
        tessellation: TessellationSettings { to_texels: true, ..Default::default() },
        shadows: false,
        ..Default::default()
    };
    mean(&renderer.render(&state(sun), &settings).unwrap().color)
}

/// Three by three metres of relief in an atlas whose patches lie in all four directions. `height` returns the height at a position.
pub fn in_tiles(height: impl Fn(Vec2) -> f32 + Sync) -> (PatchMesh, TileLayout, Vec<f32>) {
    let mut mesh = plane(1.5, 12, 1.0, [1.0; 4], even);
    mesh.flat_repeat = None;
    mesh.patches.iter_mut().enumerate().for_each(|(i, patch)| patch.rotate_left((i * 7 / 3) % 4));
    let (layout, heights) = bake_tiles(&mut mesh, 32, |p, _| height(p.truncate()));
    (mesh, layout, heights)
}

/// The bricks or grooves of [`surface`] in an atlas.
fn surface_in_tiles(map: HeightMap, depth: f32) -> Object {
    let field = HeightField::repeating(map);
    let (mesh, layout, heights) = in_tiles(|p| field.bicubic(p));
    let object = Object::new("atlas", mesh).with_heights(tiled(layout, heights), depth / CELLS as f32);
    Object { casts_shadow: true, ..object.with_specular_f0(0.0) }
}

#[test]
fn hard_edges_follow_the_reference() {
    follow_the_reference(surface);
}

#[test]
fn hard_edges_in_an_atlas_follow_the_reference() {
    follow_the_reference(surface_in_tiles);
}

fn follow_the_reference(surface: fn(HeightMap, f32) -> Object) {
    let Some(gpu) = test_gpu() else { return };
    for bricks in [false, true] {
        let mut renderer = renderer(&gpu, surface(hard_edges(bricks), 4.0), 0.0);
        let mut errors = [0.0f64; 2];
        for sun in [Vec3::new(1.0, 0.2, 0.7), Vec3::new(0.3, 1.0, 0.5), Vec3::new(-0.8, 0.4, 0.6)] {
            let sun = Some(sun.normalize());
            let truth = radiance(&mut renderer, sun, Technique::Reference, ShadingOptions::default());
            for (error, classes) in errors.iter_mut().zip([true, false]) {
                let options = ShadingOptions { classes, ..Default::default() };
                let found = radiance(&mut renderer, sun, Technique::Leadr, options);
                println!("bricks {bricks}, {sun:.2?}, classes {classes}: {found:.4} of {truth:.4}");
                *error = error.max((found / truth - 1.0).abs());
            }
        }
        assert!(errors[0] < 0.1 && errors[0] < 0.6 * errors[1], "{errors:?}");
    }
}

/// Steps across x, as of roof tiles: each rises gently, and falls in front.
fn steps() -> HeightMap {
    let height = |x: f32| (0.25 * x).min(1.1 * (32.0 - x));
    let texels = (0..CELLS * CELLS).map(|i| height(((i % CELLS) as f32 + 24.5) % 32.0)).collect();
    HeightMap { width: CELLS, height: CELLS, texels }
}

/// A pixel of a front and of the lip above it turns away from a low light in the mean. The lip is lit.
#[test]
fn classes_face_a_light_behind_their_mean_slope() {
    let Some(gpu) = test_gpu() else { return };
    let mut renderer = renderer(&gpu, surface(steps(), 1.0), 0.02);
    let state = state(Some(Vec3::new(-0.9, 0.0, 0.2).normalize()));
    let mut picture = |size: (u32, u32), technique: Technique| {
        let reference = technique.is_reference();
        let settings = RenderSettings {
            size,
            samples: if reference { 16 } else { 1 },
            shading: technique.with(ShadingOptions { relief_shadows: reference, ..Default::default() }),
            tessellation: TessellationSettings { to_texels: true, ..Default::default() },
            shadows: false,
            ..Default::default()
        };
        renderer.render(&state, &settings).unwrap().color
    };
    let (found, fine) = (picture((4, 4), Technique::Leadr), picture((64, 64), Technique::Reference));
    for (row, colors) in found.chunks_exact(4).enumerate() {
        let truth = fine[row * 16 * 64..(row + 1) * 16 * 64].iter().map(|color| color[1]).sum::<f32>() / (16.0 * 64.0);
        let found = colors.iter().map(|color| color[1]).sum::<f32>() / 4.0;
        println!("row {row}: {found:.4} of {truth:.4}");
        // The share of the lip that is lit is a class mean. The plane of the mean slope would leave .22 of the light.
        assert!(found > 0.45 * truth && found < 1.1 * truth, "row {row}: {found:.4} of {truth:.4}");
    }
}

#[test]
fn rock_is_one_class() {
    let Some(gpu) = test_gpu() else { return };
    let mut renderer = renderer(&gpu, surface(procedural::fbm(CELLS, CELLS, 3, 8, 4, 0.5), 8.0), 0.5);
    let sun = Some(Vec3::new(1.0, 0.2, 0.7).normalize());
    let [on, off] = [true, false].map(|classes| {
        radiance(&mut renderer, sun, Technique::Leadr, ShadingOptions { classes, ..Default::default() })
    });
    assert_eq!(on, off);
}

#[test]
fn white_reliefs_are_white_in_a_furnace() {
    let Some(gpu) = test_gpu() else { return };
    for (map, depth) in
        [(hard_edges(true), 4.0), (hard_edges(false), 4.0), (procedural::fbm(CELLS, CELLS, 3, 8, 4, 0.5), 20.0)]
    {
        let mut renderer = renderer(&gpu, surface(map, depth), 1.0);
        let [lost, kept] = [false, true].map(|interreflection| {
            1.0 - radiance(
                &mut renderer,
                None,
                Technique::Leadr,
                ShadingOptions { interreflection, ..Default::default() },
            )
        });
        println!("a furnace loses {lost:.4} without and {kept:.4} with light between bumps");
        assert!(lost > 0.02 && kept.abs() < 0.02, "{lost} {kept}");
    }
}

/// A plate of small bricks.
fn bricks(half: f32) -> Object {
    let repeat = 0.08;
    let object = surface(hard_edges(true), 4.0);
    Object { mesh: plane(half, 2, repeat, [1.0; 4], even), height_scale: repeat * object.height_scale, ..object }
}

/// Such a plate above another one, seen so that its edges cross the picture.
fn plates(gpu: &TestGpu, below: Object) -> (Renderer, FrameState) {
    let sky = RgbImage { width: 2, height: 1, texels: vec![[0.05; 3]; 2] };
    let environment = Environment::from_equirect(gpu, 16, &sky).unwrap();
    let renderer = Renderer::new(gpu, vec![below, bricks(0.4)], environment).unwrap();
    let sun = Some(Sun { direction: Vec3::new(-0.8, 0.4, 0.6).normalize(), irradiance: Vec3::ONE });
    let camera = Camera::looking_at(20.0 * VIEW, Vec3::new(0.0, 0.0, 0.1), 5.0);
    let raised = Affine3A::from_rotation_translation(Quat::from_rotation_z(0.4), Vec3::new(0.0, 0.0, 0.3));
    let poses = vec![Pose::REST, Pose::Rigid(raised)];
    (renderer, FrameState { sun, ..FrameState::new(camera, poses) })
}

/// Frames with edge samples show the classes of frames without them, in pixels and along edges.
#[test]
fn edge_samples_show_the_same_classes() {
    same_with_edge_samples(bricks(1.5), 0.4);
}

#[test]
fn edge_samples_show_the_same_classes_of_an_atlas() {
    let (field, repeat) = (HeightField::repeating(hard_edges(true)), 0.25);
    let (mesh, layout, heights) = in_tiles(|p| field.bicubic(p / repeat));
    let object = Object::new("atlas", mesh).with_heights(tiled(layout, heights), 4.0 * repeat / CELLS as f32);
    same_with_edge_samples(object.with_specular_f0(0.0), 0.6);
}

/// `most` is the largest error of edge samples relative to that of one class.
fn same_with_edge_samples(below: Object, most: f64) {
    let Some(gpu) = test_gpu() else { return };
    let (mut renderer, state) = plates(&gpu, below);
    let mut shot = |samples: u32, edge_samples: u32, classes: bool| {
        let shading = Technique::Leadr.with(ShadingOptions { edge_samples, classes, ..Default::default() });
        let settings = RenderSettings { size: (48, 32), samples, shading, shadows: false, ..Default::default() };
        renderer.render(&state, &settings).unwrap().image()
    };
    let many = shot(64, 1, true);
    let [edges, one_class, without] = [(16, true), (16, false), (1, true)]
        .map(|(edge_samples, classes)| rrmse(&many, &shot(1, edge_samples, classes)).unwrap());
    println!("edge samples {edges:.4}, with one class {one_class:.4}, without edge samples {without:.4}");
    assert!(edges < most * one_class && edges < 0.8 * without, "{edges} {one_class} {without}");
}

/// Classes are found for the first frame that needs them, whenever it comes, and then come from the cache.
#[test]
fn classes_are_found_when_a_frame_needs_them() {
    let Some(gpu) = test_gpu() else { return };
    let folder = tempfile::tempdir().unwrap();
    let found = || {
        let files = std::fs::read_dir(folder.path()).map(Iterator::flatten).into_iter().flatten();
        files.filter(|file| file.file_name().to_string_lossy().starts_with("classes-")).count()
    };
    let sun = Some(Vec3::new(1.0, 0.2, 0.7).normalize());
    let settings = |technique: Technique, classes: bool| RenderSettings {
        size: (4, 2),
        samples: 1,
        shading: technique.with(ShadingOptions { classes, ..Default::default() }),
        ..Default::default()
    };
    let by_class = settings(Technique::Leadr, true);
    let renderer = |first: &RenderSettings| {
        let scene = Scene {
            objects: vec![surface(hard_edges(true), 4.0).with_instances(2)],
            cache: Some(MapCache::in_folder(folder.path())),
            ..Scene::default()
        };
        let state = FrameState { poses: vec![Pose::REST; 2], ..state(sun) };
        let sky = RgbImage { width: 2, height: 1, texels: vec![[0.5; 3]; 2] };
        let environment = Environment::from_equirect(&gpu, 16, &sky).unwrap();
        (Renderer::for_frames_like(&gpu, scene, environment, &state, first).unwrap(), state)
    };
    let others =
        [settings(Technique::Leadr, false), settings(Technique::Clean, true), settings(Technique::Reference, true)];
    let (mut late, state) = renderer(&others[0]);
    let before = others.map(|settings| late.render(&state, &settings).unwrap().color);
    assert_eq!(found(), 0, "no frame needed classes");
    let found_late = late.render(&state, &by_class).unwrap().color;
    assert_eq!(found(), 1);
    assert!(found_late != before[0]);
    // Frames without classes stay the same.
    assert_eq!(others.map(|settings| late.render(&state, &settings).unwrap().color), before);
    let (mut early, state) = renderer(&by_class);
    assert_eq!(early.render(&state, &by_class).unwrap().color, found_late);
    assert_eq!(found(), 1);
}
