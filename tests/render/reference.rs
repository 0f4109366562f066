//! The reference technique: it agrees with ray casts, converges, is reproducible and can be resumed.

use glam::{DVec2, Vec3};
use leadr::maps::{HeightMap, RgbImage};
use leadr::render::camera::Camera;
use leadr::render::frame::{Layer, Renderer};
use leadr::render::light::environment::Environment;
use leadr::render::passes::accumulate::Accumulation;
use leadr::render::scene::{FrameState, Object, PointLight, Pose, Sun};
use leadr::render::settings::{RenderSettings, ShadingOptions, Technique, Terms};
use leadr::render::surfaces::displacement::HeightField;
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::plane::{even, plane};
use leadr_lab::ray_cast::{Patch, Spectrum, Tile};
use leadr_testing::gpu::{TestGpu, test_gpu};

fn reference(size: (u32, u32), samples: u32, relief_shadows: bool) -> RenderSettings {
    RenderSettings {
        size,
        samples,
        shading: Technique::Reference.with(ShadingOptions { relief_shadows, ..Default::default() }),
        tessellation: TessellationSettings { to_texels: true, ..Default::default() },
        shadows: false,
        ..Default::default()
    }
}

/// Three by three repeats of a tile, one metre each, white and diffuse, with slopes of standard deviation `sigma`.
pub fn plane_of(tile: &Tile, sigma: f32, casts: bool) -> Object {
    let cells = tile.size();
    let heights = HeightField::repeating(HeightMap { width: cells, height: cells, texels: tile.heights().to_vec() });
    let mesh = plane(1.5, 3 * cells / 32, 1.0, [1.0; 4], even);
    let object = Object::new("plane", mesh).with_heights(heights, sigma / cells as f32).with_specular_f0(0.0);
    Object { casts_shadow: casts, ..object }
}

/// From 60° and so far that rays are parallel: a picture twice as wide as high shows exactly one repeat.
pub const VIEW: Vec3 = Vec3::new(0.866_025_4, 0.0, 0.5);

pub fn state(sun: Option<Vec3>) -> FrameState {
    let fov = 2.0 * (0.25f32 / 200.0).atan().to_degrees();
    let camera = Camera { near: 1.0, ..Camera::looking_at(VIEW * 200.0, Vec3::ZERO, fov) };
    let sun = sun.map(|direction| Sun { direction, irradiance: Vec3::ONE });
    FrameState { sun, ..FrameState::new(camera, vec![Pose::REST]) }
}

pub fn renderer(gpu: &TestGpu, object: Object, radiance: f32) -> Renderer {
    let sky = RgbImage { width: 2, height: 1, texels: vec![[radiance; 3]; 2] };
    Renderer::new(gpu, vec![object], Environment::from_equirect(gpu, 16, &sky).unwrap()).unwrap()
}

pub fn mean(color: &[[f32; 4]]) -> f64 {
    assert!(color.iter().all(|c| c[3] == 1.0), "the plane does not fill the picture");
    color.iter().map(|c| f64::from(c[1])).sum::<f64>() / color.len() as f64
}

/// The same surface ray cast and rasterised, under three lights, with and without shadows of the relief.
#[test]
#[ignore = "long"]
fn lights_agree_with_ray_casts() {
    let Some(gpu) = test_gpu() else { return };
    let tile = Tile::new(Spectrum::Gaussian, 128, 8.0, 1);
    let sigma = 1.0;
    let patch = Patch::new(&tile, DVec2::ZERO, tile.covariance() * f64::from(sigma * sigma));
    let mut renderers = [false, true].map(|casts| renderer(&gpu, plane_of(&tile, sigma, casts), 0.0));
    let half = 0.5f32.sqrt();
    for (name, light) in
        [("front", VIEW), ("side", Vec3::new(0.0, half, half)), ("opposite", Vec3::new(-0.866_025_4, 0.0, 0.5))]
    {
        let truth = patch.diffuse_light(VIEW.as_dvec3(), light.as_dvec3(), 400, 1).unwrap().mean;
        for (renderer, (want, shadows)) in renderers.iter_mut().zip(truth.into_iter().zip(["without", "with"])) {
            let output = renderer.render(&state(Some(light)), &reference((64, 32), 16, true)).unwrap();
            let error = 100.0 * (mean(&output.color) / want - 1.0);
            println!("{name} light {shadows} shadows: {:.4} instead of {want:.4}: {error:+.2} %", mean(&output.color));
            // The opposite light grazes few facets: their shadows start closer than the search in a bilinear height field resolves, and
            // 32,768 rays are noisier.
            let bound = if name == "opposite" { 8.0 } else { 2.0 };
            assert!(error.abs() < bound, "{name} light {shadows} shadows: {error:+.2} %");
        }
        assert!(name == "front" || truth[1] < 0.99 * truth[0], "shadows matter");
    }
}

/// The same under a uniform sky, sampled by directions.
#[test]
fn the_sky_agrees_with_ray_casts() {
    let Some(gpu) = test_gpu() else { return };
    let tile = Tile::new(Spectrum::Gaussian, 64, 6.0, 1);
    let patch = Patch::new(&tile, DVec2::ZERO, tile.covariance());
    let want = patch.diffuse_environment(VIEW.as_dvec3(), 300, 4, 1, |_| 1.0).unwrap().mean;
    let [open, shadowed] = [false, true].map(|casts| {
        let mut renderer = renderer(&gpu, plane_of(&tile, 1.0, casts), 1.0);
        mean(&renderer.render(&state(None), &reference((32, 16), 32, true)).unwrap().color)
    });
    println!(
        "sky: {open:.4} without shadows instead of {:.4}, {shadowed:.4} with them instead of {:.4}",
        want[0], want[1]
    );
    assert!((open - want[0]).abs() < 0.04 && (shadowed / want[1] - 1.0).abs() < 0.06);
    assert!(want[1] < 0.8);
}

/// With shadows of the relief, the terms add up to the whole picture.
#[test]
fn terms_add_up() {
    let Some(gpu) = test_gpu() else { return };
    let tile = Tile::new(Spectrum::Gaussian, 64, 6.0, 1);
    let mut object = plane_of(&tile, 0.7, true);
    object.specular_f0 = 0.3;
    object.mesh.colors = vec![[0.6, 0.6, 0.6, 0.4]; object.mesh.positions.len()];
    let mut renderer = renderer(&gpu, object, 1.0);
    let mut shoot = |terms| {
        let mut settings = reference((32, 16), 8, true);
        settings.shading = settings.shading.adjusted(|options| ShadingOptions { terms, ..options });
        renderer.render(&state(Some(Vec3::new(0.0, 0.6, 0.8))), &settings).unwrap().color
    };
    let all = shoot(Terms::ALL);
    let parts = Terms::NAMES.map(|(term, _)| shoot(term));
    for part in &parts {
        assert!((0.01..0.7).contains(&(mean(part) / mean(&all))), "{} of {}", mean(part), mean(&all));
    }
    for (pixel, whole) in all.iter().enumerate() {
        let sum: f32 = parts.iter().map(|part| part[pixel][1]).sum();
        assert!((sum - whole[1]).abs() < 1e-5 * (1.0 + whole[1]), "{sum} instead of {}", whole[1]);
    }
}

/// A distant point light, with another kind of shadow map, casts the same shadows as a sun.
#[test]
fn far_point_lights_shadow_like_a_sun() {
    let Some(gpu) = test_gpu() else { return };
    let tile = Tile::new(Spectrum::Gaussian, 64, 6.0, 2);
    let mut renderer = renderer(&gpu, plane_of(&tile, 1.0, true), 0.0);
    let direction = Vec3::new(-0.7, 0.3, 0.5).normalize();
    let settings = reference((32, 16), 4, true);
    let sun = renderer.render(&state(Some(direction)), &settings).unwrap().color;
    let lamp = PointLight::new(direction * 300.0, Vec3::splat(9e4));
    let point = renderer.render(&FrameState { point_lights: vec![lamp], ..state(None) }, &settings).unwrap().color;
    let (sun_mean, point_mean) = (mean(&sun), mean(&point));
    let rms =
        (sun.iter().zip(&point).map(|(a, b)| f64::from(a[1] - b[1]).powi(2)).sum::<f64>() / sun.len() as f64).sqrt();
    println!("sun {sun_mean:.4}, lamp {point_mean:.4}, rms difference {rms:.4}");
    assert!((point_mean / sun_mean - 1.0).abs() < 0.02 && rms < 0.15 * sun_mean);
}

#[test]
fn samples_repeat_and_parts_make_the_whole() {
    let Some(gpu) = test_gpu() else { return };
    let tile = Tile::new(Spectrum::Gaussian, 32, 4.0, 3);
    let state = state(Some(Vec3::new(0.3, 0.4, 0.5).normalize()));
    for relief in [false, true] {
        let settings = reference((32, 16), 6, relief);
        let [mut first, mut second] = [0, 1].map(|_| renderer(&gpu, plane_of(&tile, 0.7, true), 0.5));
        let whole = first.render(&state, &settings).unwrap().color;
        let mut parts = Accumulation::default();
        for range in [4..6, 0..1, 1..4] {
            let count = range.len() as u32;
            parts.add(&second.render_range(&state, &settings, range).unwrap().color, count);
        }
        assert_eq!(whole, second.render(&state, &settings).unwrap().color, "relief shadows {relief}");
        assert_eq!(parts.samples(), 6);
        for (a, b) in whole.iter().flatten().zip(parts.mean().iter().flatten()) {
            assert!((a - b).abs() <= 1e-6 * a.abs().max(1.0), "{a} {b}");
        }
        let other = RenderSettings { seed: 1, ..settings };
        assert_ne!(whole, second.render(&state, &other).unwrap().color);
        assert!(second.render_range(&state, &settings, 3..7).is_err());
    }
}

/// Errors fall at least with the square root of the number of samples.
#[test]
fn errors_fall_with_samples() {
    let Some(gpu) = test_gpu() else { return };
    let tile = Tile::new(Spectrum::Gaussian, 64, 4.0, 5);
    let mut renderer = renderer(&gpu, plane_of(&tile, 0.7, false), 0.3);
    let state = state(Some(Vec3::new(0.2, 0.6, 0.5).normalize()));
    let mut draw = |samples: u32, seed: u64| {
        let settings = RenderSettings { seed, ..reference((64, 32), samples, false) };
        renderer.render(&state, &settings).unwrap().color
    };
    let truth = draw(128, 9);
    let errors = [2u32, 8, 32].map(|samples| {
        let sum: f64 = draw(samples, 0).iter().zip(&truth).map(|(a, b)| f64::from(a[1] - b[1]).powi(2)).sum();
        (sum / truth.len() as f64).sqrt() / mean(&truth)
    });
    println!("relative errors with 2, 8 and 32 samples: {errors:.4?}");
    assert!(errors[0] > 0.02, "the picture should be noisy: {errors:?}");
    // The noise of the 128-sample picture affects all of them.
    assert!(errors[1] < errors[0] / 2.0 && errors[2] < errors[0] / 4.0, "{errors:?}");
}

/// With mapped normals on smooth geometry (LEADR Figure 8) nothing casts a shadow, with any settings.
#[test]
fn smooth_geometry_casts_no_shadows() {
    let Some(gpu) = test_gpu() else { return };
    let tile = Tile::new(Spectrum::Gaussian, 64, 6.0, 4);
    let state = state(Some(Vec3::new(-0.6, 0.2, 0.6).normalize()));
    let smooth = RenderSettings { displacement: false, ..reference((32, 16), 4, true) };
    let [open, shadowed] = [false, true].map(|casts| {
        let mut renderer = renderer(&gpu, plane_of(&tile, 1.0, casts), 0.0);
        [smooth, reference((32, 16), 4, true)].map(|s| mean(&renderer.render(&state, &s).unwrap().color))
    });
    println!("mapped {open:?}, with shadows {shadowed:?}");
    assert!((shadowed[0] / open[0] - 1.0).abs() < 1e-3, "a flat plane shadows itself");
    assert!((open[0] / open[1] - 1.0).abs() > 0.1, "mapped normals should lack masking");
    assert!(shadowed[1] < 0.97 * open[1], "the displaced surface throws no shadows");
}

/// Seen straight down with one pixel per texel, the plane's height equals the map at every pixel, because each texel centre has a vertex.
/// The map has 100 texels per repeat, so patch borders fall between texels.
#[test]
fn the_plane_has_a_vertex_at_the_centre_of_every_texel() {
    let Some(gpu) = test_gpu() else { return };
    let (cells, scale) = (100u32, 0.01);
    let texels: Vec<f32> = (0..cells * cells).map(|i| (i * 37 % 101) as f32 / 101.0).collect();
    let heights = HeightField::repeating(HeightMap { width: cells, height: cells, texels: texels.clone() });
    let mesh = plane(1.5, 9, 1.0, [1.0; 4], even);
    let mut renderer = renderer(&gpu, Object::new("plane", mesh).with_heights(heights, scale), 0.5);
    let distance = 100.0;
    let camera = Camera {
        near: 1.0,
        up: Vec3::Y,
        ..Camera::looking_at(
            Vec3::new(0.5, 0.5, distance),
            Vec3::new(0.5, 0.5, 0.0),
            2.0 * (0.5f32 / distance).atan().to_degrees(),
        )
    };
    let settings = reference((cells, cells), 1, false);
    renderer.render(&FrameState::new(camera, vec![Pose::REST]), &settings).unwrap();
    let depth = renderer.layer(Layer::Depth).unwrap();
    let mut worst = 0.0f32;
    for (i, depth) in depth.iter().enumerate() {
        let (x, y) = (i as u32 % cells, cells - 1 - i as u32 / cells);
        let expected = distance - scale * texels[(y * cells + x) as usize];
        worst = worst.max((depth[0] - expected).abs() / scale);
    }
    println!("heights differ by up to {worst:.4} of the relief");
    assert!(worst < 0.02, "{worst}");
}

/// On a plane with a vertex at every texel, the reference reads the finest level. If patches are too large for this, it filters the bumps
/// between vertices.
#[test]
fn the_reference_filters_only_bumps_between_vertices() {
    let Some(gpu) = test_gpu() else { return };
    let cells = 256;
    for (patches_per_repeat, expected) in [(6, 0.0), (1, 1.36)] {
        let texels = (0..cells * cells).map(|i| (i * 37 % 101) as f32 / 101.0).collect();
        let heights = HeightField::repeating(HeightMap { width: cells, height: cells, texels });
        let mesh = plane(1.5, 3 * patches_per_repeat, 1.0, [1.0; 4], even);
        let mut renderer = renderer(&gpu, Object::new("plane", mesh).with_heights(heights, 0.001), 0.5);
        renderer.render(&state(None), &reference((32, 16), 1, false)).unwrap();
        let lods = renderer.layer(Layer::Lod).unwrap();
        assert!(lods.iter().all(|lod| (lod[0] - expected).abs() < 0.01), "{patches_per_repeat}: {:?}", lods[0]);
    }
}
