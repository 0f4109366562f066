//! The reference: it agrees with ray casts, converges, repeats and can be resumed.

mod common;

use glam::{Affine3A, DVec2, DVec3, Vec3};
use leadr::maps::RgbImage;
use leadr::maps::ray_cast::{Patch, Spectrum, Tile};
use leadr::render::camera::Camera;
use leadr::render::displacement::{Border, HeightField};
use leadr::render::environment::Environment;
use leadr::render::frame::Renderer;
use leadr::render::scene::{FrameState, Object, Pose, Sun};
use leadr::render::settings::{RenderSettings, ShadingSettings, Technique};
use leadr::render::tessellation::TessellationSettings;
use leadr::scenes::plane::{even, plane};

fn reference(size: u32, samples: u32, relief_shadows: bool) -> RenderSettings {
    RenderSettings {
        size: (size, size),
        samples,
        shading: ShadingSettings { technique: Technique::Reference, ..Default::default() },
        tessellation: TessellationSettings { to_texels: true, ..Default::default() },
        relief_shadows,
        ..Default::default()
    }
}

/// A camera so far away along −y that it is nearly parallel; the unit sphere fills `fill` of the picture.
fn far_camera(fill: f32) -> Camera {
    let distance = 100.0;
    Camera {
        near: 1.0,
        ..Camera::looking_at(-Vec3::Y * distance, Vec3::ZERO, 2.0 * (1.0 / (distance * fill)).atan().to_degrees())
    }
}

fn sun(direction: Vec3) -> Option<Sun> {
    Some(Sun { direction, irradiance: Vec3::ONE })
}

/// Three by three repeats of a tile on a plane of metres, slopes of deviation `sigma`, drawn with a vertex per texel.
fn plane_of(tile: &Tile, sigma: f32) -> Object {
    let cells = tile.size();
    let heights = HeightField { width: cells, height: cells, texels: tile.heights().to_vec(), border: Border::Wrap };
    Object {
        name: "plane".to_owned(),
        mesh: plane(1.5, 3 * cells / 32, 1.0, [1.0, 1.0, 1.0, 1.0 / 255.0], even),
        heights: Some(heights),
        height_scale: sigma / cells as f32,
        color_map: None,
        specular_f0: 0.0,
        casts_shadow: true,
    }
}

#[test]
fn explore() {
    let Some(gpu) = common::test_gpu() else { return };
    let samples = std::env::var("N").map_or(16, |s| s.parse().unwrap());
    let tile = Tile::new(Spectrum::Gaussian, 128, std::env::var("L").map_or(8.0, |s| s.parse().unwrap()), 1);
    let wo = Vec3::new(0.75f32.sqrt(), 0.0, 0.5);
    let camera =
        Camera { near: 1.0, ..Camera::looking_at(wo * 200.0, Vec3::ZERO, 2.0 * (0.25f32 / 200.0).atan().to_degrees()) };
    for sigma in [0.5f32, 1.0] {
        let s = tile.covariance() * f64::from(sigma * sigma);
        let patch = Patch::new(&tile, DVec2::ZERO, s);
        for (name, light) in [
            ("front", Some(wo)),
            ("side45", Some(Vec3::new(0.0, 0.5f32.sqrt(), 0.5f32.sqrt()))),
            ("opp60", Some(Vec3::new(-0.75f32.sqrt(), 0.0, 0.5))),
            ("env", None),
        ] {
            let sky = RgbImage { width: 2, height: 1, texels: vec![[if light.is_none() { 1.0 } else { 0.0 }; 3]; 2] };
            let state = FrameState {
                camera,
                poses: vec![Pose::Rigid(Affine3A::IDENTITY)],
                sky: None,
                sun: light.and_then(sun),
                point_lights: Vec::new(),
                height_scale: 1.0,
            };
            for relief in [false, true] {
                let environment = Environment::from_equirect(&gpu, 16, &sky).unwrap();
                let object = Object { casts_shadow: relief, ..plane_of(&tile, sigma) };
                let mut renderer = Renderer::new(&gpu, vec![object], environment).unwrap();
                let settings = RenderSettings { size: (64, 32), shadows: false, ..reference(64, samples, true) };
                let start = std::time::Instant::now();
                let output = renderer.render(&state, &settings).unwrap();
                let got = output.color.iter().map(|c| f64::from(c[1])).sum::<f64>() / 2048.0;
                let covered = output.color.iter().filter(|c| c[3] == 1.0).count();
                for flip in [1.0] {
                    let (w, l) = (wo.as_dvec3(), light.map(|l| l.as_dvec3() * DVec3::new(1.0, flip, 1.0)));
                    let truth = match l {
                        Some(l) => patch.diffuse_light(w, l, 400, 1),
                        None => patch.diffuse_environment(w, 300, 4, 1, |_| 1.0),
                    }
                    .unwrap()
                    .mean[usize::from(relief)];
                    println!(
                        "sigma {sigma} {name} relief {relief}: {got:.4} instead of {truth:.4}: {:+.2} % ({covered}; {:?})",
                        100.0 * (got / truth - 1.0),
                        start.elapsed()
                    );
                }
            }
        }
    }
}
