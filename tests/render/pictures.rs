//! Geometry guarantees of the renderer: no cracks, culling that changes no pixel, reproducible frames.

use glam::{Affine3A, Vec2, Vec3};
use leadr::maps::HeightMap;
use leadr::render::camera::Camera;
use leadr::render::frame::{FrameOutput, Layer, Renderer};
use leadr::render::scene::{FrameState, Object, Pose, Sun};
use leadr::render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr::render::surfaces::displacement::HeightField;
use leadr::render::surfaces::patch_mesh::PatchMesh;
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::sphere::{cube_sphere, displaced_sphere};
use leadr_testing::gpu::{TestGpu, test_gpu};
use leadr_testing::render::{bumps, under_sky};

/// A rough, repeating height map.
fn rough() -> HeightField {
    bumps(128, 4.0, 7)
}

fn object(mesh: PatchMesh, heights: HeightField, height_scale: f32) -> Object {
    Object::new("test", mesh).with_heights(heights, height_scale)
}

fn renderer(gpu: &TestGpu, object: Object) -> Renderer {
    under_sky(gpu, vec![object], 32)
}

fn state(camera: Camera) -> FrameState {
    FrameState::new(camera, vec![Pose::REST])
}

/// Pixels that show the inside, except on the silhouette. There the last front face and the first back face meet edge-on at equal depth,
/// and either may be drawn.
fn inside_pixels(output: &FrameOutput) -> usize {
    let (width, height) = (output.size.0 as usize, output.size.1 as usize);
    let at = |x: usize, y: usize| output.color[y * width + x];
    let covered = |x: usize, y: usize| at(x.min(width - 1), y.min(height - 1))[3] > 0.0;
    (0..width * height)
        .map(|i| (i % width, i / width))
        .filter(|&(x, y)| at(x, y)[..3] == [1.0, 0.0, 1.0])
        .filter(|&(x, y)| {
            covered(x.saturating_sub(1), y) && covered(x + 1, y) && covered(x, y.saturating_sub(1)) && covered(x, y + 1)
        })
        .count()
}

/// Pixels that show the inside, and all covered pixels, at several distances, directions and tessellations.
fn count_inside(renderer: &mut Renderer, max_slope_views: &[f32]) -> (usize, usize) {
    let (mut inside, mut pixels) = (0, 0);
    for (i, &distance) in max_slope_views.iter().enumerate() {
        for (k, direction) in [Vec3::new(1.0, 0.4, 0.3), Vec3::new(-0.3, 0.7, 1.0)].into_iter().enumerate() {
            for pixels_per_triangle in [1.0, 7.3, 150.0] {
                let camera =
                    Camera::looking_at(direction.normalize() * distance, Vec3::ZERO, 35.0 + i as f32 + k as f32);
                let settings = RenderSettings {
                    size: (200, 200),
                    mark_inside: true,
                    tessellation: TessellationSettings { pixels_per_triangle, ..Default::default() },
                    ..Default::default()
                };
                let output = renderer.render(&state(camera), &settings).unwrap();
                assert!(output.color.iter().flatten().all(|v| v.is_finite()));
                inside += inside_pixels(&output);
                pixels += output.color.iter().filter(|c| c[3] > 0.0).count();
            }
        }
    }
    (inside, pixels)
}

#[test]
fn closed_meshes_show_no_crack_across_tiles() {
    let Some(gpu) = test_gpu() else { return };
    let (mesh, heights) = displaced_sphere(&rough(), 1.0, 6, 16, [0.5; 4]);
    // Steep but without overhangs, because a fold would show its own inside.
    let mut renderer = renderer(&gpu, object(mesh, heights, 0.05));
    let (inside, pixels) = count_inside(&mut renderer, &[1.5, 3.0, 9.0, 40.0]);
    println!("{inside} inside pixels among {pixels}");
    assert!(pixels > 100_000);
    assert_eq!(inside, 0);
}

#[test]
fn closed_meshes_show_no_crack_across_uv_seams() {
    let Some(gpu) = test_gpu() else { return };
    // On twelve seams, the charts of neighbouring faces give different heights along their common edge.
    let mesh = cube_sphere(4, [0.5; 4]);
    let mut renderer = renderer(&gpu, object(mesh, rough(), 0.04));
    let (inside, pixels) = count_inside(&mut renderer, &[1.5, 3.0, 9.0]);
    println!("{inside} inside pixels among {pixels}");
    assert_eq!(inside, 0);
}

/// The same seams without shared edges: every patch has its own vertices, so their heights are not joined.
#[test]
fn crack_test_detects_cracks() {
    let Some(gpu) = test_gpu() else { return };
    let mut mesh = cube_sphere(4, [0.5; 4]);
    let (positions, normals) = (mesh.positions.clone(), mesh.normals.clone());
    mesh.positions = mesh.patches.iter().flatten().map(|&v| positions[v as usize]).collect();
    mesh.normals = mesh.patches.iter().flatten().map(|&v| normals[v as usize]).collect();
    mesh.colors = vec![[0.5; 4]; mesh.positions.len()];
    mesh.accessibility = vec![1.0; mesh.positions.len()];
    mesh.patches = (0..mesh.patches.len() as u32).map(|i| [4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3]).collect();
    let mut renderer = renderer(&gpu, object(mesh, rough(), 0.1));
    let (inside, _) = count_inside(&mut renderer, &[1.5, 3.0]);
    println!("{inside} inside pixels through torn seams");
    assert!(inside > 50, "{inside}");
}

#[test]
fn culling_changes_no_pixel() {
    let Some(gpu) = test_gpu() else { return };
    let (mesh, heights) = displaced_sphere(&rough(), 1.0, 8, 16, [0.5; 4]);
    let mut renderer = renderer(&gpu, object(mesh, heights, 0.05));
    for (distance, target) in [(1.3, Vec3::new(0.0, 0.5, 0.4)), (4.0, Vec3::ZERO)] {
        let camera = Camera::looking_at(Vec3::new(0.7, -0.5, 0.4).normalize() * distance, target, 40.0);
        let mut draw = |cull: bool| {
            let tessellation = TessellationSettings { cull, ..Default::default() };
            let settings = RenderSettings { size: (256, 256), tessellation, ..Default::default() };
            renderer.render(&state(camera), &settings).unwrap()
        };
        let (culled, all) = (draw(true), draw(false));
        println!("{} of {} patches drawn", culled.patches, all.patches);
        assert!(culled.patches * 10 < all.patches * 8);
        assert_eq!(culled.color, all.color);
    }
}

#[test]
#[ignore = "long"]
fn same_frame_is_bit_identical() {
    let Some(gpu) = test_gpu() else { return };
    let (mesh, heights) = displaced_sphere(&rough(), 1.0, 4, 16, [0.5; 4]);
    let camera = Camera::looking_at(Vec3::new(2.0, -2.0, 1.0), Vec3::ZERO, 40.0);
    let settings = RenderSettings { size: (96, 64), samples: 3, ..Default::default() };
    let mut first = renderer(&gpu, object(mesh.clone(), heights.clone(), 0.05));
    let mut second = renderer(&gpu, object(mesh, heights, 0.05));
    let a = first.render(&state(camera), &settings).unwrap();
    // An intermediate frame must not change the next.
    let other = RenderSettings { size: (40, 40), ..settings };
    second.render(&state(camera.at_distance(9.0)), &other).unwrap();
    let b = second.render(&state(camera), &settings).unwrap();
    assert_eq!(a.color, b.color);
    let reseeded = first.render(&state(camera), &RenderSettings { seed: 1, ..settings }).unwrap();
    assert_ne!(a.color, reseeded.color);
}

/// A light beside the camera casts no visible shadows at any tessellation: bumps that are not drawn must not cast shadows.
#[test]
fn coarse_surfaces_do_not_shade_themselves() {
    let Some(gpu) = test_gpu() else { return };
    let (mesh, heights) = displaced_sphere(&rough(), 1.0, 6, 32, [0.5; 4]);
    let mut renderer = renderer(&gpu, object(mesh, heights, 0.5));
    let direction = Vec3::new(1.0, 0.4, 0.3).normalize();
    let mut light = |distance: f32, toward: Vec3, shadows: bool| -> f64 {
        let camera = Camera::looking_at(direction * distance, Vec3::ZERO, 40.0);
        let sun = Some(Sun { direction: toward, irradiance: Vec3::splat(20.0) });
        let settings = RenderSettings { size: (96, 96), shadows, ..Default::default() };
        let output = renderer.render(&FrameState { sun, ..state(camera) }, &settings).unwrap();
        output.color.iter().filter(|c| c[3] > 0.0).map(|c| f64::from(c[1])).sum()
    };
    for distance in [3.0, 12.0, 30.0] {
        let lost = 1.0 - light(distance, direction, true) / light(distance, direction, false);
        println!("{distance} m: {lost:.4} of the light lost");
        assert!((-1e-6..0.01).contains(&lost), "{distance} m: {lost}");
    }
    // A low sun must cast shadows; otherwise the check above proves nothing.
    let low = (direction + 3.0 * direction.any_orthonormal_vector()).normalize();
    let lost = 1.0 - light(1.6, low, true) / light(1.6, low, false);
    println!("low sun: {lost:.4}");
    assert!(lost > 0.002, "{lost}");
}

/// Objects so small that a screen tile shows several of them, in a picture with a size that is not a multiple of the tile: as many as a
/// tile has bits for, and many more.
#[test]
#[ignore = "long"]
fn every_pixel_of_a_full_scene_is_filtered() {
    let Some(gpu) = test_gpu() else { return };
    for (columns, count) in [(8, 62), (20, 400)] {
        // Vertex colours have 8 bits.
        let colors = [|k: u32| k % 20, |k: u32| k / 20];
        let color = |part: u32| (12 * part + 4) as f32 / 255.0;
        let sphere = |k| {
            let [red, green] = colors.map(|of| color(of(k)));
            Object::new("test", cube_sphere(2, [red, green, 0.5, 0.3]))
        };
        let mut renderer = under_sky(&gpu, (0..count).map(sphere).collect::<Vec<_>>(), 32);
        let middle = (columns - 1) as f32 / 2.0;
        let position = |k: u32| Vec3::new((k % columns) as f32 - middle, 0.0, (k / columns) as f32 - middle) * 2.5;
        let poses = (0..count).map(|k| Pose::Rigid(Affine3A::from_translation(position(k)))).collect();
        let eye = Vec3::new(2.0, -60.0, 5.0) * (columns as f32 / 8.0);
        let state = FrameState { poses, ..state(Camera::looking_at(eye, Vec3::ZERO, 22.0)) };
        let settings = RenderSettings { size: (107 * columns / 8, 93 * columns / 8), ..Default::default() };
        let picture = renderer.render(&state, &settings).unwrap();
        let [depth, albedo, roughness] =
            [Layer::Depth, Layer::Albedo, Layer::Roughness].map(|layer| renderer.layer(layer).unwrap());
        let mut seen = vec![0u32; count as usize];
        for ((depth, albedo), roughness) in depth.iter().zip(&albedo).zip(&roughness) {
            if depth[0].is_finite() {
                let [red, green] = [albedo[0], albedo[1]].map(|value| (value * 255.0 - 4.0) / 12.0);
                let whole = |part: f32| (part - part.round()).abs() < 0.1;
                assert!(whole(red) && whole(green) && (roughness[0] - 0.3).abs() < 3e-3, "{albedo:?} {roughness:?}");
                seen[(red.round() + 20.0 * green.round()) as usize] += 1;
            } else {
                assert_eq!((*albedo, *roughness), ([0.0; 4], [0.0; 4]));
            }
        }
        assert!(seen.iter().all(|&pixels| pixels > 15), "{seen:?}");
        // Edge samples are filtered and shaded per tile; a missing sample would be black or come from another frame.
        let shading = Technique::Leadr.with(ShadingOptions { edge_samples: 64, ..Default::default() });
        let edges = renderer.render(&state, &RenderSettings { shading, ..settings }).unwrap();
        let samples = renderer.render(&state, &RenderSettings { samples: 64, ..settings }).unwrap();
        let rms = |a: &FrameOutput| {
            let square = |(a, b): (&[f32; 4], &[f32; 4])| (0..3).map(|c| f64::from(a[c] - b[c]).powi(2)).sum::<f64>();
            (a.color.iter().zip(&samples.color).map(square).sum::<f64>() / a.color.len() as f64).sqrt()
        };
        let (with, without) = (rms(&edges), rms(&picture));
        println!("{count} against 64 samples: {with:.4} with 64 edge samples, {without:.4} without");
        assert!(with < 0.18 * without, "{with} {without}");
    }
    gpu.assert_silent();
}

#[test]
fn layers_describe_the_surface() {
    let Some(gpu) = test_gpu() else { return };
    let flat = HeightField::repeating(HeightMap { width: 2, height: 2, texels: vec![0.0; 4] });
    let mut renderer = renderer(&gpu, object(cube_sphere(8, [0.25, 0.5, 0.75, 0.3]), flat, 1.0));
    let camera = Camera::looking_at(Vec3::new(0.0, -4.0, 0.0), Vec3::ZERO, 40.0);
    let size = (65, 65);
    renderer.render(&state(camera), &RenderSettings { size, ..Default::default() }).unwrap();
    let mut at = |layer: Layer, x: usize, y: usize| renderer.layer(layer).unwrap()[y * 65 + x];
    assert!(at(Layer::Depth, 0, 0)[0].is_infinite());
    let mut centre = |layer| at(layer, 32, 32);
    // Vertices of coarse tessellations are slightly outside the sphere, so that the triangles between them approximate it.
    let depth = centre(Layer::Depth)[0];
    assert!((depth - 3.0).abs() < 1e-2, "{depth}");
    let normal = centre(Layer::Normal);
    assert!((Vec3::new(normal[0], normal[1], normal[2]) + Vec3::Y).length() < 1e-3, "{normal:?}");
    let albedo = centre(Layer::Albedo);
    // Vertex colours are stored in eight bits.
    assert!((albedo[0] - 0.25).abs() < 3e-3 && (albedo[2] - 0.75).abs() < 3e-3, "{albedo:?}");
    // On a smooth sphere the mean slope only accounts for the difference between patch and displacement normals.
    let slope = centre(Layer::MeanSlope);
    assert!(Vec2::new(slope[0], slope[1]).length() < 0.01, "{slope:?}");
    assert!(centre(Layer::Covariance)[0] < 1e-3);
}
