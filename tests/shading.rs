//! The shading pass as a whole: energy, and every pixel against the reflectance library.

mod common;

use glam::{Affine3A, DVec2, DVec3, Vec3};
use leadr::maps::{RgbImage, procedural};
use leadr::reflectance::{
    diffuse, frame, fresnel, projected_area, sh_projection, slope_grid, slope_statistics, specular,
};
use leadr::render::camera::Camera;
use leadr::render::displacement::{Border, HeightField};
use leadr::render::environment::Environment;
use leadr::render::frame::{Layer, Renderer};
use leadr::render::scene::{FrameState, Object, PointLight, Pose, Sun};
use leadr::render::settings::{DiffuseLights, Quadrature, RenderSettings, ShadingSettings, Visibility};
use leadr::scenes::sphere::displaced_sphere;

const SIZE: u32 = 96;

fn bumpy_sphere(color: [f32; 4], specular_f0: f32) -> Object {
    let map = procedural::gaussian(128, 128, 11, 1.0, 4.0 / 128.0);
    let field = HeightField { width: 128, height: 128, texels: map.texels, border: Border::Wrap };
    let (mesh, heights) = displaced_sphere(&field, 1.0, 6, 32, color);
    Object {
        name: "bumpy sphere".to_owned(),
        mesh,
        heights: Some(heights),
        height_scale: 0.5,
        color_map: None,
        specular_f0,
        casts_shadow: false,
    }
}

fn constant_environment(gpu: &common::TestGpu, radiance: [f32; 3]) -> Environment {
    let image = RgbImage::new(8, 4, vec![radiance; 32]).unwrap();
    Environment::from_equirect(gpu, 16, &image).unwrap()
}

fn state(distance: f32, sun: Option<Sun>, point_lights: Vec<PointLight>) -> FrameState {
    FrameState {
        time: 0.0,
        camera: Camera::looking_at(Vec3::new(0.5, -0.8, 0.3).normalize() * distance, Vec3::ZERO, 30.0),
        poses: vec![Pose::Rigid(Affine3A::IDENTITY)],
        sky: None,
        sun,
        point_lights,
        height_scale: 1.0,
    }
}

fn settings(shading: ShadingSettings) -> RenderSettings {
    RenderSettings { size: (SIZE, SIZE), shading, shadows: false, ..Default::default() }
}

/// Without shadowing, a white surface in a white room cannot be seen: LEADR eq. 16 integrates to one.
#[test]
fn a_white_surface_vanishes_in_a_white_room() {
    let Some(gpu) = common::test_gpu() else { return };
    for (f0, what) in [(0.0, "diffuse under grazing Fresnel"), (0.3, "both"), (1.0, "specular")] {
        let object = bumpy_sphere([1.0, 1.0, 1.0, 0.3], f0);
        let mut renderer = Renderer::new(&gpu, vec![object], constant_environment(&gpu, [1.0; 3])).unwrap();
        for distance in [3.0, 12.0, 60.0] {
            let shading = ShadingSettings { visibility: Visibility::Masking, ..Default::default() };
            let output = renderer.render(&state(distance, None, Vec::new()), &settings(shading)).unwrap();
            let object = output.color.iter().filter(|c| c[3] > 0.0);
            assert!(object.clone().count() > 10);
            let worst = object.map(|c| (c[0] - 1.0).abs()).fold(0.0, f32::max);
            println!("{what} at distance {distance}: off by {worst:.1e} at most");
            assert!(worst < 5e-4);
        }
    }
}

/// With shadowing some of that light is lost, and none is made.
#[test]
fn shadowing_only_takes_light_away() {
    let Some(gpu) = common::test_gpu() else { return };
    let object = bumpy_sphere([1.0, 1.0, 1.0, 0.3], 1.0);
    let mut renderer = Renderer::new(&gpu, vec![object], constant_environment(&gpu, [1.0; 3])).unwrap();
    let output = renderer.render(&state(12.0, None, Vec::new()), &settings(ShadingSettings::default())).unwrap();
    let radiances: Vec<f32> = output.color.iter().filter(|c| c[3] > 0.0).map(|c| c[0]).collect();
    let (low, high) = radiances.iter().fold((f32::MAX, f32::MIN), |(l, h), &v| (l.min(v), h.max(v)));
    println!("{low} .. {high}");
    assert!(high <= 1.0001 && low < 0.99 && low > 0.3);
}

/// Schlick's term averaged over the visible facets.
fn mean_fresnel(wo: DVec3, m: DVec2, s: DVec3, f0: DVec3, n: u32, lambda: f64) -> DVec3 {
    let (mut sum, mut norm) = (DVec3::ZERO, 0.0);
    for j in 0..n {
        for k in 0..n {
            let node = slope_grid::grid_node(j, k, n, lambda);
            let sample = specular::environment_sample(wo, node.truncate(), m, s);
            sum += fresnel::fresnel_schlick(f0, wo.dot(sample.wn)) * (node.z * sample.area);
            norm += node.z * sample.area;
        }
    }
    sum / norm.max(1e-12)
}

/// Directional and point lights on every pixel of a G-buffer, against the 64-bit reference.
#[test]
fn lights_agree_with_the_reference_at_every_pixel() {
    let Some(gpu) = common::test_gpu() else { return };
    let (albedo, alpha, f0) = ([0.5f32, 0.4, 0.3], 0.25, 0.06);
    let object = bumpy_sphere([albedo[0], albedo[1], albedo[2], alpha], f0);
    let mut renderer = Renderer::new(&gpu, vec![object], constant_environment(&gpu, [0.0; 3])).unwrap();
    let sun = Sun { direction: Vec3::new(0.6, -0.1, 0.7).normalize(), irradiance: Vec3::new(3.0, 2.5, 2.0) };
    let point = PointLight { position: Vec3::new(-1.5, -2.5, 0.5), intensity: Vec3::new(2.0, 4.0, 6.0) };
    let (mut worst, mut pixels) = (0.0f64, 0);
    for distance in [4.0, 14.0] {
        for shading in [
            ShadingSettings::default(),
            ShadingSettings { visibility: Visibility::Masking, quadrature: Quadrature::Grid(3), ..Default::default() },
            ShadingSettings { quadrature: Quadrature::Grid(1), ..Default::default() },
            ShadingSettings { diffuse_lights: DiffuseLights::Sh, ..Default::default() },
        ] {
            let state = state(distance, Some(sun), vec![point]);
            let output = renderer.render(&state, &settings(shading)).unwrap();
            let layers =
                [Layer::Depth, Layer::Normal, Layer::MeanSlope, Layer::Covariance, Layer::Albedo, Layer::Roughness];
            let layers = layers.map(|layer| renderer.layer(layer).unwrap());
            let [ray_x, ray_y, ray_z] = state.camera.rays((SIZE, SIZE), glam::Vec2::ZERO).map(|r| r.as_dvec3());
            for (i, color) in output.color.iter().enumerate().filter(|(_, c)| c[3] > 0.0) {
                let [depth, normal, slope, covariance, albedo, roughness] =
                    layers.each_ref().map(|l| l[i].map(f64::from));
                let (x, y) = ((i as u32 % SIZE) as f64 + 0.5, (i as u32 / SIZE) as f64 + 0.5);
                let eye = state.camera.position.as_dvec3();
                let ndc = DVec2::new(x, y) / f64::from(SIZE) * 2.0 - 1.0;
                let ray = ray_z + ray_x * ndc.x + ray_y * ndc.y;
                let position = eye + ray * depth[0];
                let ray = ray.normalize();
                let frame = frame::frame_about(DVec3::new(normal[0], normal[1], normal[2]));
                let wo = frame::to_frame(&frame, -ray);
                let Quadrature::Grid(n) = shading.quadrature else { unreachable!("all are grids") };
                let lambda = slope_grid::grid_lambda(n);
                let m = DVec2::new(slope[0], slope[1]);
                let diffuse_s = DVec3::new(covariance[0], covariance[1], covariance[2]);
                let specular_s = slope_statistics::add_roughness(diffuse_s, roughness[0]);
                let diffuse_m = projected_area::face_viewer(wo, m, diffuse_s, lambda);
                let specular_m = projected_area::face_viewer(wo, m, specular_s, lambda);
                let f0 = DVec3::splat(f64::from(f0));
                let albedo = DVec3::new(albedo[0], albedo[1], albedo[2])
                    * (1.0 - mean_fresnel(wo, specular_m, specular_s, f0, n, lambda));
                let to_point = point.position.as_dvec3() - position;
                let lights = [
                    (sun.direction.as_dvec3(), sun.irradiance.as_dvec3()),
                    (to_point.normalize(), point.intensity.as_dvec3() / to_point.length_squared()),
                ];
                let mut expected = DVec3::ZERO;
                for (direction, irradiance) in lights {
                    let wi = frame::to_frame(&frame, direction);
                    let shadowing = shading.visibility == Visibility::Smith;
                    let d = if shading.diffuse_lights == DiffuseLights::Sh {
                        let normals = diffuse::visible_normal_moments(wo, diffuse_m, diffuse_s, n, lambda);
                        diffuse::leadr_diffuse_light_sh(&normals, wo, wi, diffuse_m, diffuse_s, shadowing)
                    } else {
                        diffuse::leadr_diffuse_light(wo, wi, diffuse_m, diffuse_s, shadowing, n, lambda)
                    };
                    let s = specular::leadr_specular_directional(wo, wi, specular_m, specular_s, f0, shadowing);
                    expected += irradiance * (albedo * d + s);
                }
                let actual = DVec3::new(f64::from(color[0]), f64::from(color[1]), f64::from(color[2]));
                let error = (actual - expected).length() / (expected.length() + 0.02);
                worst = worst.max(error);
                pixels += 1;
            }
        }
    }
    println!("{pixels} pixels, worst relative error {worst:.2e}");
    assert!(pixels > 10_000);
    assert!(worst < 2e-4, "{worst}");
}

/// A panorama of order-2 radiance, which nine coefficients hold exactly: the diffuse part of every pixel (the difference
/// between a white and a black surface) against the 64-bit reference.
#[test]
fn the_diffuse_environment_agrees_with_the_reference_at_every_pixel() {
    let Some(gpu) = common::test_gpu() else { return };
    let radiance =
        |d: DVec3| DVec3::new(1.0 + 0.5 * d.x, 1.2 + 0.4 * d.y * d.z, 0.8 + 0.3 * d.z + 0.3 * (d.x * d.x - d.y * d.y));
    let (width, height) = (256u32, 128u32);
    let texels = (0..width * height).map(|i| {
        let (u, v) =
            ((f64::from(i % width) + 0.5) / f64::from(width), (f64::from(i / width) + 0.5) / f64::from(height));
        let (azimuth, polar) = (std::f64::consts::TAU * (0.5 - u), std::f64::consts::PI * v);
        let d = DVec3::new(polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos());
        radiance(d).as_vec3().to_array()
    });
    let image = RgbImage::new(width, height, texels.collect()).unwrap();
    let coefficients = sh_projection::project_function(8, radiance);
    let f0 = 0.04;
    let mut pictures = [1.0, 0.0].map(|albedo| {
        let environment = Environment::from_equirect(&gpu, 64, &image).unwrap();
        let object = bumpy_sphere([albedo, albedo, albedo, 0.3], f0);
        let mut renderer = Renderer::new(&gpu, vec![object], environment).unwrap();
        let output = renderer.render(&state(5.0, None, Vec::new()), &settings(ShadingSettings::default())).unwrap();
        (renderer, output)
    });
    let (black, white) = (pictures[1].1.color.clone(), pictures[0].1.color.clone());
    let renderer = &mut pictures[0].0;
    let layers = [Layer::Normal, Layer::MeanSlope, Layer::Covariance, Layer::Roughness];
    let layers = layers.map(|layer| renderer.layer(layer).unwrap());
    let camera = state(5.0, None, Vec::new()).camera;
    let [ray_x, ray_y, ray_z] = camera.rays((SIZE, SIZE), glam::Vec2::ZERO).map(|r| r.as_dvec3());
    let (mut worst, mut pixels) = (0.0f64, 0);
    for (i, color) in white.iter().enumerate().filter(|(_, c)| c[3] > 0.0) {
        let [normal, slope, covariance, roughness] = layers.each_ref().map(|l| l[i].map(f64::from));
        let (x, y) = ((i as u32 % SIZE) as f64 + 0.5, (i as u32 / SIZE) as f64 + 0.5);
        let ndc = DVec2::new(x, y) / f64::from(SIZE) * 2.0 - 1.0;
        let frame = frame::frame_about(DVec3::new(normal[0], normal[1], normal[2]));
        let wo = frame::to_frame(&frame, -(ray_z + ray_x * ndc.x + ray_y * ndc.y).normalize());
        let (n, lambda) = (5, slope_grid::grid_lambda(5));
        let m = DVec2::new(slope[0], slope[1]);
        let diffuse_s = DVec3::new(covariance[0], covariance[1], covariance[2]);
        let specular_s = slope_statistics::add_roughness(diffuse_s, roughness[0]);
        let specular_m = projected_area::face_viewer(wo, m, specular_s, lambda);
        let fresnel = mean_fresnel(wo, specular_m, specular_s, DVec3::splat(f64::from(f0)), n, lambda);
        let diffuse_m = projected_area::face_viewer(wo, m, diffuse_s, lambda);
        let normals = diffuse::visible_normal_moments(wo, diffuse_m, diffuse_s, n, lambda);
        let expected = (1.0 - fresnel) * diffuse::leadr_diffuse_environment(&normals, &frame, &coefficients);
        let actual = DVec3::from_array(std::array::from_fn(|k| f64::from(color[k] - black[i][k])));
        worst = worst.max((actual - expected).length() / (expected.length() + 0.02));
        pixels += 1;
    }
    println!("{pixels} pixels, worst relative error {worst:.2e}");
    assert!(pixels > 1_000);
    assert!(worst < 3e-4, "{worst}");
}
