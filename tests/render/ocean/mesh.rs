//! The mesh of the sea: its horizon is geometrically correct, without holes or popping, and its triangles resolve visible waves.

use glam::{Vec2, Vec3};
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::light::sky::Sky;
use leadr::render::scene::FrameState;
use leadr::render::settings::RenderSettings;
use leadr::render::surfaces::ocean::Ocean;
use leadr::render::surfaces::ocean::mesh::EARTH;
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::ocean::sea::ocean;
use leadr::scenes::ocean::spectrum::Sea;
use leadr::scenes::shore;
use leadr_testing::gpu::test_gpu;
use leadr_testing::render::seascape;

fn sea() -> Ocean {
    ocean(&Sea::default(), 64, 1)
}

/// A camera at `position` with this `yaw`, looking `down` below the horizontal; radians, field of view in degrees.
fn camera(position: Vec3, yaw: f32, down: f32, fov: f32) -> Camera {
    let (sin, cos) = down.sin_cos();
    let direction = Vec3::new(cos * yaw.cos(), cos * yaw.sin(), -sin);
    Camera::looking_at(position, position + direction * position.z, fov)
}

fn state(camera: &Camera) -> FrameState {
    FrameState { time: 5.0, ..FrameState::new(*camera, Vec::new()).under(&Sky::default()) }
}

/// Tangent of the dip of calm water's horizon below the horizontal.
fn dip(height: f32) -> f32 {
    (2.0 * height / EARTH).sqrt()
}

/// Tangent of the angle below the horizon of the ray through a picture point in pixels.
fn below(camera: &Camera, size: (u32, u32), at: Vec2) -> f32 {
    let [x, y, z] = camera.rays(size, Vec2::ZERO);
    let ndc = at / Vec2::new(size.0 as f32, size.1 as f32) * 2.0 - 1.0;
    let ray = z + x * ndc.x + y * ndc.y;
    -dip(camera.position.z) - ray.z / ray.truncate().length().max(1e-9)
}

/// Row of the horizon in a column, in pixels from the top.
fn horizon_row(camera: &Camera, size: (u32, u32), column: u32) -> f32 {
    let (mut low, mut high) = (0.0, size.1 as f32);
    for _ in 0..40 {
        let middle = 0.5 * (low + high);
        let above = below(camera, size, Vec2::new(column as f32 + 0.5, middle)) < 0.0;
        if above { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

#[test]
#[ignore = "long"]
fn the_horizon_is_the_curve_of_the_earth() {
    let Some(gpu) = test_gpu() else { return };
    let size = (192, 96);
    let settings = RenderSettings { size, samples: 64, ..RenderSettings::default() };
    let mut calm = sea();
    calm.height = 0.0;
    calm.cascades.iter_mut().for_each(|c| c.waves.iter_mut().for_each(|w| (w[0], w[1]) = (0.0, 0.0)));
    for (waves, ocean) in [("calm", calm), ("windy", sea())] {
        let mut renderer = seascape(&gpu, ocean);
        for height in [2.5, 100.0, 1000.0, 5000.0] {
            for (yaw, down) in [(0.3f32, dip(height)), (2.0, 0.12)] {
                let camera = camera(Vec3::new(40.0, 9.0, height), yaw, down, 45.0);
                let picture = renderer.render(&state(&camera), &settings).unwrap().color;
                let errors: Vec<f32> = (0..size.0)
                    .map(|column| {
                        let air = |row: u32| 1.0 - picture[(row * size.0 + column) as usize][3];
                        (0..size.1).map(air).sum::<f32>() - horizon_row(&camera, size, column)
                    })
                    .collect();
                let worst = errors.iter().fold(0.0f32, |a, e| a.max(e.abs()));
                let step = errors.windows(2).map(|e| (e[1] - e[0]).abs()).fold(0.0, f32::max);
                let mean = errors.iter().sum::<f32>() / errors.len() as f32;
                println!("{waves}, {height} m, down {down:.3}: mean {mean:.3}, worst {worst:.3}, step {step:.3} px");
                // One of 64 samples per pixel is 0.016; straight triangle edges may miss the curve by 0.05.
                assert!(worst < 0.1 && step < 0.06, "{waves}, {height} m: worst {worst}, step {step}");
            }
        }
    }
}

#[test]
fn water_covers_everything_below_horizon() {
    let Some(gpu) = test_gpu() else { return };
    let mut renderer = seascape(&gpu, sea());
    let size = (160, 100);
    let settings = RenderSettings { size, samples: 4, ..RenderSettings::default() };
    let (mut holes, mut water, mut sky, mut flying) = (0u32, 0u32, 0u32, 0u32);
    for (i, height) in [2.5f32, 4.0, 20.0, 150.0, 1000.0, 6000.0].into_iter().enumerate() {
        for (j, (down, fov)) in [(0.0f32, 60.0f32), (0.25, 40.0), (0.7, 100.0), (1.57, 140.0)].into_iter().enumerate() {
            let eye = Vec3::new(37.0 * i as f32, -53.0 * j as f32, height);
            let camera = camera(eye, 0.9 * (i * 4 + j) as f32, down, fov);
            let picture = renderer.render(&state(&camera), &settings).unwrap().color;
            // Two pixels around the horizon may show either.
            let pixel = 2.0 * (fov.to_radians() * 0.5).tan() / size.1 as f32;
            for y in 0..size.1 {
                for x in 0..size.0 {
                    let alpha = picture[(y * size.0 + x) as usize][3];
                    let below = below(&camera, size, Vec2::new(x as f32 + 0.5, y as f32 + 0.5));
                    if below > 2.0 * pixel {
                        water += 1;
                        holes += u32::from(alpha < 1.0);
                    } else if below < -2.0 * pixel {
                        sky += 1;
                        flying += u32::from(alpha > 0.0);
                    }
                }
            }
            println!("{height} m, down {down}: {holes} of {water}, {flying} of {sky}");
        }
    }
    assert!(water > 200_000 && sky > 20_000, "{water} {sky}");
    assert_eq!((holes, flying), (0, 0));
}

/// Largest distance of a pixel's luminance beyond those of the sea and the sky around it, relative to the brighter one.
fn overshoot(picture: &[[f32; 4]], size: (u32, u32), camera: &Camera) -> f32 {
    let luminance = |x: u32, y: u32| {
        let [r, g, b, _] = picture[(y * size.0 + x) as usize];
        0.2126 * r + 0.7152 * g + 0.0722 * b
    };
    (0..size.0).fold(0.0, |worst: f32, x| {
        let row = horizon_row(camera, size, x) as u32;
        // The sea becomes brighter within a few rows of the horizon, so both sides take part.
        let around = (row - 8..row - 2).chain(row + 3..row + 9).map(|y| luminance(x, y));
        let (low, high) = around.fold((f32::MAX, 0.0f32), |(low, high), v| (low.min(v), high.max(v)));
        (row - 2..row + 3).map(|y| luminance(x, y)).fold(worst, |worst, v| worst.max((low - v).max(v - high) / high))
    })
}

#[test]
fn pixels_on_the_horizon_lie_between_sea_and_sky() {
    let Some(gpu) = test_gpu() else { return };
    let at = |position: [f32; 3], target: [f32; 3], fov| Camera::looking_at(position.into(), target.into(), fov);
    // The views of the shore and of the open sea, which look at the water from 3 m to 17 m above it.
    let cameras = [
        at([9.2, 6.6, 3.7], [5.9, 3.7, 3.8], 36.0),
        at([16.8, 7.0, 2.3], [5.4, -0.5, 2.3], 38.0),
        at([78.2, 52.0, 17.4], [4.2, -2.0, 2.4], 34.0),
        at([0.0, 0.0, 12.0], [-30.0, 5.0, 9.0], 50.0),
    ];
    let mut all = 0.0f32;
    for (name, water) in [("shore", shore::sea(&shore::waves())), ("open sea", sea())] {
        let mut renderer = seascape(&gpu, water);
        for (size, msaa) in [((640, 360), 4), ((333, 187), 1), ((250, 200), 4)] {
            for (i, camera) in cameras.iter().enumerate() {
                let settings = RenderSettings { size, samples: 1, msaa, ..RenderSettings::default() };
                let picture = renderer.render(&state(camera), &settings).unwrap().color;
                let worst = overshoot(&picture, size, camera);
                println!("{name}, {size:?}, {msaa} samples, camera {i}: {worst:.3}");
                all = all.max(worst);
            }
        }
    }
    assert!(all < 0.1, "{all}");
}

const MOVED: (u32, u32) = (96, 64);
/// Edge of the pixel blocks with compared means, in pixels.
const BLOCK: usize = 16;

/// A tone-mapped picture, one value per pixel.
fn tone_mapped(renderer: &mut Renderer, camera: &Camera, tessellation: TessellationSettings) -> Vec<f32> {
    let settings = RenderSettings { size: MOVED, samples: 4, tessellation, ..RenderSettings::default() };
    let picture = renderer.render(&state(camera), &settings).unwrap().color;
    picture.iter().map(|c| (c[0] + c[1] + c[2]) / (3.0 + c[0] + c[1] + c[2])).collect()
}

fn mean_change(a: &[f32], b: &[f32]) -> f32 {
    a.iter().zip(b).map(|(a, b)| (a - b).abs()).sum::<f32>() / a.len() as f32
}

/// The mean change of every pixel block.
fn block_changes(a: &[f32], b: &[f32]) -> Vec<f32> {
    let width = MOVED.0 as usize;
    let blocks = width / BLOCK;
    let mut sums = vec![0.0; blocks * (MOVED.1 as usize / BLOCK)];
    for (i, (a, b)) in a.iter().zip(b).enumerate() {
        sums[i / width / BLOCK * blocks + i % width / BLOCK] += (a - b).abs() / (BLOCK * BLOCK) as f32;
    }
    sums
}

#[test]
#[ignore = "long"]
fn nothing_pops_while_the_camera_moves() {
    let Some(gpu) = test_gpu() else { return };
    let mut renderer = seascape(&gpu, sea());
    let usual = TessellationSettings::default();
    // Time stands still and the camera moves slowly, so the picture changes little and evenly unless the mesh jumps. In the last case the
    // mesh does jump, and the test must detect it.
    for (height, down, way, popping) in [
        (2.5f32, 0.1f32, Vec3::X * 0.01, false),
        (2.5, 0.1, Vec3::Z * 0.01, false),
        (100.0, 0.25, Vec3::X * 0.4, false),
        (100.0, 0.25, Vec3::Z * 0.4, false),
        (1000.0, 0.3, Vec3::Z * 4.0, false),
        (2.5, 0.1, Vec3::X * 0.01, true),
    ] {
        let frames: Vec<_> = (0..41)
            .map(|i| {
                let start = camera(Vec3::new(0.0, 0.0, height), 0.9, down, 45.0);
                let by = way * i as f32;
                let moved = Camera { position: start.position + by, target: start.target + by, ..start };
                let pixels_per_triangle = if popping && i > 20 { 16.0 } else { usual.pixels_per_triangle };
                tone_mapped(&mut renderer, &moved, TessellationSettings { pixels_per_triangle, ..usual })
            })
            .collect();
        let median = |mut v: Vec<f32>| {
            v.sort_by(f32::total_cmp);
            v[v.len() / 2]
        };
        let changes: Vec<f32> = frames.windows(2).map(|f| mean_change(&f[0], &f[1])).collect();
        let whole = changes.iter().fold(0.0f32, |a, c| a.max(*c)) / median(changes.clone());
        let blocks: Vec<Vec<f32>> = frames.windows(2).map(|f| block_changes(&f[0], &f[1])).collect();
        // Blocks of sky do not change at all.
        let peak = |block: usize| {
            let series: Vec<f32> = blocks.iter().map(|b| b[block]).collect();
            let floor = median(series.clone()).max(0.1 * median(changes.clone()));
            series.into_iter().fold(0.0, f32::max) / floor
        };
        // When the horizon crosses a row of samples, a whole row of pixels changes at once for any mesh.
        let across = MOVED.0 as usize / BLOCK;
        let horizon = horizon_row(&camera(Vec3::Z * height, 0.9, down, 45.0), MOVED, MOVED.0 / 2) as usize / BLOCK;
        let block = (0..blocks[0].len()).filter(|b| b / across != horizon).map(peak).fold(0.0, f32::max);
        println!(
            "{height} m, steps of {way}{}: change {:.6}, largest over median {whole:.2}, of a block {block:.2}",
            if popping { ", popping" } else { "" },
            median(changes.clone())
        );
        if popping {
            assert!(whole > 2.0, "the jumping mesh was not noticed: {whole}");
        } else {
            assert!(whole < 1.25 && block < 2.2, "{height} m: {whole} {block}");
        }
    }
}

#[test]
fn finer_mesh_changes_little() {
    let Some(gpu) = test_gpu() else { return };
    let mut renderer = seascape(&gpu, sea());
    for (height, down, most) in [(2.5f32, 0.1f32, 2e-3f32), (100.0, 0.25, 1e-3), (1000.0, 0.3, 2e-4)] {
        let camera = camera(Vec3::new(0.0, 0.0, height), 0.9, down, 45.0);
        let usual = tone_mapped(&mut renderer, &camera, TessellationSettings::default());
        let dense = TessellationSettings { pixels_per_triangle: 0.5, to_texels: true, ..Default::default() };
        let dense = tone_mapped(&mut renderer, &camera, dense);
        let error = mean_change(&usual, &dense);
        let largest = usual.iter().zip(&dense).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max);
        println!("{height} m: mean difference to a mesh of two triangles a pixel {error:.6}, largest {largest:.4}");
        assert!(error < most, "{height} m: {error}");
    }
}
