//! The pillow and the snake: no cracks at any tessellation, and at a distance filtered like their reference.

use std::sync::Arc;

use glam::Vec3;
use leadr::gpu::Gpu;
use leadr::render::frame::{FrameOutput, Layer, Renderer};
use leadr::render::light::environment::Environment;
use leadr::render::scene::FrameState;
use leadr::render::settings::{RenderSettings, Technique};
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::stage::{Lights, Stage};
use leadr::scenes::studio::studio;
use leadr::scenes::{pillow, snake};
use leadr_testing::gpu::test_gpu;

/// Only the first object of a stage, in the studio.
fn alone(gpu: &Arc<Gpu>, stage: &mut Stage) -> Renderer {
    let environment = Environment::from_equirect(gpu, 32, &studio()).unwrap();
    let mut objects = std::mem::take(&mut stage.objects);
    objects.truncate(1);
    Renderer::new(gpu, objects, environment).unwrap()
}

fn state(stage: &Stage, direction: Vec3, distance: f32) -> FrameState {
    let mut camera = stage.views.mid;
    camera.position = camera.target + direction.normalize() * distance;
    let mut state = stage.state(0.0, &camera.at_distance(distance), &Lights::default());
    state.poses.truncate(1);
    state
}

/// Pixels that show the inside through a crack. On a silhouette the last front face and the first back face meet edge-on and have equal
/// depths. Such a pixel is hardly further away than its neighbours; a crack shows the far wall.
fn inside_pixels(output: &FrameOutput, depth: &[[f32; 4]], outline: f32) -> usize {
    let (width, height) = (output.size.0 as usize, output.size.1 as usize);
    let inside = |i: usize| output.color[i][..3] == [1.0, 0.0, 1.0];
    (0..width * height)
        .filter(|&i| inside(i))
        .filter(|&i| {
            let (x, y) = (i % width, i / width);
            let around = [(x.wrapping_sub(1), y), (x + 1, y), (x, y.wrapping_sub(1)), (x, y + 1)];
            let outside = around.into_iter().filter(|&(x, y)| x < width && y < height).map(|(x, y)| y * width + x);
            outside.filter(|&k| !inside(k)).all(|k| (depth[i][0] - depth[k][0]).abs() > outline)
        })
        .count()
}

/// Inside pixels and all pixels of the first object, `thick` metres thick, over several views.
fn count_inside(gpu: &Arc<Gpu>, mut stage: Stage, distance: f32, thick: f32) -> (usize, usize) {
    let mut renderer = alone(gpu, &mut stage);
    let (mut inside, mut pixels) = (0, 0);
    for direction in [Vec3::new(0.4, -1.0, 0.6), Vec3::new(-1.0, 0.3, -0.4)] {
        for pixels_per_triangle in [3.0, 40.0] {
            let settings = RenderSettings {
                size: (180, 120),
                mark_inside: true,
                tessellation: TessellationSettings { pixels_per_triangle, ..Default::default() },
                ..Default::default()
            };
            let state = state(&stage, direction, distance);
            let output = renderer.render(&state, &settings).unwrap();
            assert!(output.color.iter().flatten().all(|v| v.is_finite()));
            // Over the last pixel before its silhouette a cylinder of radius r recedes by sqrt(2 r pixel).
            let pixel = 2.0 * distance * (0.5 * state.camera.fov_y).tan() / 120.0;
            let outline = 1.5 * (thick * pixel).sqrt();
            assert!(outline < 0.8 * thick, "too far away to tell cracks from silhouettes");
            inside += inside_pixels(&output, &renderer.layer(Layer::Depth).unwrap(), outline);
            pixels += output.color.iter().filter(|c| c[3] > 0.0).count();
        }
    }
    (inside, pixels)
}

/// Gives every patch its own vertices, so that gaps between their heights stay open.
fn torn(mut stage: Stage) -> Stage {
    let mesh = &mut stage.objects[0].mesh;
    let vertices: Vec<usize> = mesh.patches.iter().flatten().map(|&v| v as usize).collect();
    mesh.positions = vertices.iter().map(|&v| mesh.positions[v]).collect();
    mesh.normals = vertices.iter().map(|&v| mesh.normals[v]).collect();
    mesh.colors = vec![[1.0; 4]; vertices.len()];
    mesh.accessibility = vec![1.0; vertices.len()];
    mesh.patches = (0..mesh.patches.len() as u32).map(|i| [4 * i, 4 * i + 1, 4 * i + 2, 4 * i + 3]).collect();
    stage
}

#[test]
fn the_pillow_has_no_cracks() {
    let Some(gpu) = test_gpu() else { return };
    let (inside, pixels) = count_inside(&gpu, pillow::stage(16), 0.7, 0.15);
    println!("{inside} inside pixels among {pixels}");
    assert!(pixels > 10_000);
    assert_eq!(inside, 0);
}

#[test]
fn the_snake_has_no_cracks_unless_it_is_torn() {
    let Some(gpu) = test_gpu() else { return };
    let (inside, pixels) = count_inside(&gpu, snake::stage(16), 1.8, 0.2);
    println!("{inside} inside pixels among {pixels}");
    assert!(pixels > 10_000);
    assert_eq!(inside, 0);
    let (inside, _) = count_inside(&gpu, torn(snake::stage(16)), 1.8, 0.2);
    println!("{inside} through torn seams");
    assert!(inside > 10, "{inside}");
}

/// At a distance, every pixel of one sample is close to the converged reference, and much closer than with mipmapped normals.
#[test]
#[ignore = "long"]
fn one_distant_sample_matches_the_reference() {
    let Some(gpu) = test_gpu() else { return };
    let mut stage = pillow::stage(32);
    let mut renderer = alone(&gpu, &mut stage);
    let state = state(&stage, Vec3::new(-0.5, -1.0, 0.78), 4.0);
    let mut render = |technique: Technique, samples: u32, seed: u64| {
        let settings = RenderSettings {
            size: (96, 64),
            samples,
            seed,
            shading: technique.into(),
            tessellation: TessellationSettings { to_texels: technique.is_reference(), ..Default::default() },
            ..Default::default()
        };
        renderer.render(&state, &settings).unwrap().color
    };
    let halves = [1, 2].map(|seed| render(Technique::Reference, 64, seed));
    let reference: Vec<[f32; 4]> =
        halves[0].iter().zip(&halves[1]).map(|(a, b)| std::array::from_fn(|c| 0.5 * (a[c] + b[c]))).collect();
    let inside: Vec<usize> = (0..reference.len()).filter(|&i| reference[i][3] > 0.999).collect();
    assert!(inside.len() > 100, "{}", inside.len());
    // Relative mean square error over the pixels filled by the pillow.
    let error = |a: &[[f32; 4]], b: &[[f32; 4]]| {
        let square = |a: f32| f64::from(a) * f64::from(a);
        let (off, all) = inside.iter().fold((0.0, 0.0), |(off, all), &i| {
            let (a, b, r) = (a[i], b[i], reference[i]);
            (off + (0..3).map(|c| square(a[c] - b[c])).sum::<f64>(), all + (0..3).map(|c| square(r[c])).sum::<f64>())
        });
        off / all
    };
    // The mean of two independent halves has a quarter of their squared difference as its noise.
    let noise = 0.25 * error(&halves[0], &halves[1]);
    let [leadr, normals] =
        [Technique::Leadr, Technique::NormalMip].map(|t| (error(&render(t, 1, 0), &reference) - noise).max(0.0).sqrt());
    println!("rRMSE: LEADR {leadr:.4}, mipmapped normals {normals:.4}, noise of the reference {:.4}", noise.sqrt());
    assert!(leadr < 0.17, "{leadr}");
    assert!(normals > 1.4 * leadr, "mipmapped normals should be told from LEADR: {normals}");
}
