//! Colours that follow the relief: one sample of LEADR against the reference, which uses every texel's own colour.

use crate::classes::in_tiles;
use crate::reference::{mean, plane_of, renderer};
use glam::Vec3;
use leadr::maps::material::{Encoding, Input, Material, MaterialDetail, Raster, Relief, Samples, Texture};
use leadr::maps::{HeightMap, procedural};
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::light::sky::Sky;
use leadr::render::scene::{FrameState, MaterialMap, Object, Pose, Sun};
use leadr::render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr::render::surfaces::displacement::HeightField;
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::dressed;
use leadr::scenes::sphere::tiled_object;
use leadr_lab::ray_cast::{Spectrum, Tile};
use leadr_testing::gpu::{TestGpu, test_gpu};
use leadr_testing::render::under_sky;

const RED: [u8; 4] = [200, 25, 20, 128];
const GREY: [u8; 4] = [110, 120, 130, 128];
const CELLS: u32 = 64;

/// Bumps painted where `paint` selects the rank of the height, 0 to 1, and the slope along x. With `follows`, the paint separates classes.
fn painted(tile: &Tile, sigma: f32, follows: bool, paint: impl Fn(f32, f32) -> bool) -> Object {
    let heights = tile.heights();
    let mut order: Vec<usize> = (0..heights.len()).collect();
    order.sort_by(|&a, &b| heights[a].total_cmp(&heights[b]));
    let n = tile.size() as usize;
    let mut colors = vec![GREY; heights.len()];
    for (rank, &i) in order.iter().enumerate() {
        let rise = heights[i / n * n + (i + 1) % n] - heights[i / n * n + (i + n - 1) % n];
        if paint(rank as f32 / heights.len() as f32, rise) {
            colors[i] = RED;
        }
    }
    let plane = plane_of(tile, sigma, true).with_material(MaterialMap::new(tile.size(), tile.size(), colors));
    Object { follows_relief: follows, ..plane }
}

/// The bumps of [`painted`] in an atlas, with red tops.
fn red_tops_in_tiles(tile: &Tile, sigma: f32, follows: bool) -> Object {
    let (n, mut sorted) = (tile.size(), tile.heights().to_vec());
    sorted.sort_by(f32::total_cmp);
    let least = sorted[sorted.len() * 7 / 10];
    let texels = tile.heights().to_vec();
    let field = HeightField::repeating(HeightMap { width: n, height: n, texels });
    let (mesh, layout, heights) = in_tiles(|p| field.bicubic(p));
    let colors = heights.iter().map(|height| if *height > least { RED } else { GREY }).collect();
    let object = tiled_object("atlas", mesh, layout, heights, colors).with_specular_f0(0.0);
    Object { height_scale: sigma / n as f32, follows_relief: follows, casts_shadow: true, ..object }
}

/// Mean colour of one repeat seen from `degrees` off the normal, in few pixels or many.
fn seen(renderer: &mut Renderer, degrees: f32, sun: Vec3, technique: Technique) -> [f64; 3] {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let view = Vec3::new(sine, 0.0, cosine);
    let fov = 2.0 * (0.5 * cosine / 200.0).atan().to_degrees();
    let camera = Camera { near: 1.0, ..Camera::looking_at(view * 200.0, Vec3::ZERO, fov) };
    let sun = Some(Sun { direction: sun.normalize(), irradiance: Vec3::ONE });
    let state = FrameState { sun, ..FrameState::new(camera, vec![Pose::REST]) };
    let (rows, samples) = if technique.is_reference() { ((64.0 * cosine).round().max(1.0), 16) } else { (1.0, 1) };
    let settings = RenderSettings {
        size: ((rows / cosine).round() as u32, rows as u32),
        samples,
        shading: technique.with(ShadingOptions { relief_shadows: technique.is_reference(), ..Default::default() }),
        tessellation: TessellationSettings { to_texels: true, ..Default::default() },
        shadows: false,
        ..Default::default()
    };
    let color = renderer.render(&state, &settings).unwrap().color;
    [0, 1, 2].map(|c| mean(&color.iter().map(|p| [p[c], p[c], p[c], p[3]]).collect::<Vec<_>>()))
}

/// Lights in front of the viewer, beside and behind.
const LIGHTS: [Vec3; 3] = [Vec3::new(0.6, 0.1, 0.8), Vec3::new(0.0, 0.8, 0.6), Vec3::new(-0.6, 0.2, 0.77)];

/// Relative errors of the red fraction of the light, over views and lights: of LEADR, and without relief colours. Brightness is excluded,
/// because its errors come from the masking model.
fn errors(gpu: &TestGpu, paint: impl Fn(f32, f32) -> bool, lights: &[Vec3]) -> [f64; 2] {
    let tile = Tile::new(Spectrum::Gaussian, CELLS, 4.0, 1);
    errors_of(gpu, |follows| painted(&tile, 0.6, follows, &paint), &[15.0, 45.0, 65.0, 80.0], lights)
}

/// The same errors of objects with and without relief colours.
fn errors_of(gpu: &TestGpu, object: impl Fn(bool) -> Object, views: &[f32], lights: &[Vec3]) -> [f64; 2] {
    let mut renderers = [true, false].map(|follows| renderer(gpu, object(follows), 0.0));
    let (mut sums, mut power) = ([0.0; 2], 0.0);
    for &degrees in views {
        for &light in lights {
            let share = |[r, g, b]: [f64; 3]| r / (r + g + b);
            let want = share(seen(&mut renderers[0], degrees, light, Technique::Reference));
            let got = renderers.each_mut().map(|renderer| share(seen(renderer, degrees, light, Technique::Leadr)));
            println!("{degrees}°, light {light}: red {want:.4}, LEADR {:.4}, of the mean colour {:.4}", got[0], got[1]);
            for (sum, got) in sums.iter_mut().zip(got) {
                *sum += (got - want).powi(2);
            }
            power += want * want;
        }
    }
    let errors = sums.map(|sum: f64| (sum / power).sqrt());
    println!("relative RMSE {:.4} against {:.4}: {:.2}", errors[0], errors[1], errors[0] / errors[1]);
    errors
}

#[test]
#[ignore = "long"]
fn paint_on_tops_and_in_cracks() {
    let Some(gpu) = test_gpu() else { return };
    let [tops, dropped] = errors(&gpu, |rank, _| rank > 0.7, &LIGHTS);
    assert!(tops < 0.2 * dropped && dropped > 0.04, "{tops} {dropped}");
    let [cracks, dropped] = errors(&gpu, |rank, _| rank < 0.3, &LIGHTS[..1]);
    assert!(cracks < 0.18 * dropped && dropped > 0.04, "{cracks} {dropped}");
}

#[test]
fn paint_on_tops_of_an_atlas() {
    let Some(gpu) = test_gpu() else { return };
    let tile = Tile::new(Spectrum::Gaussian, CELLS, 4.0, 1);
    let [tops, dropped] =
        errors_of(&gpu, |follows| red_tops_in_tiles(&tile, 0.6, follows), &[45.0, 80.0], &LIGHTS[1..]);
    assert!(tops < 0.3 * dropped && dropped > 0.04, "{tops} {dropped}");
}

/// Paint on slopes facing one way brightens under light from that side, and darkens under light from the other.
#[test]
#[ignore = "long"]
fn rain_side_flips_with_the_light() {
    let Some(gpu) = test_gpu() else { return };
    let sides = [Vec3::new(-0.8, 0.0, 0.6), Vec3::new(0.8, 0.0, 0.6)];
    let [rain, dropped] = errors(&gpu, |_, rise| rise > 0.0, &sides);
    assert!(rain < 0.06 * dropped && dropped > 0.1, "{rain} {dropped}");
}

/// Relative RMSE of pictures.
fn difference(a: &[[f32; 4]], b: &[[f32; 4]]) -> f32 {
    let (mut error, mut power) = (0.0, 0.0);
    for (a, b) in a.iter().zip(b) {
        for c in 0..3 {
            error += (a[c] - b[c]).powi(2);
            power += a[c] * a[c];
        }
    }
    (error / power).sqrt()
}

/// Frames with a G-buffer show the same classes; paint without relation to the relief changes nothing.
#[test]
fn colours_change_classes_only() {
    let Some(gpu) = test_gpu() else { return };
    let tile = Tile::new(Spectrum::Gaussian, CELLS, 4.0, 1);
    let shoot = |object: Object, in_two: bool| {
        let mut renderer = renderer(&gpu, object, 1.0);
        let camera = Camera::looking_at(Vec3::new(3.0, 1.0, 1.5), Vec3::ZERO, 20.0);
        let sun = Some(Sun { direction: LIGHTS[1].normalize(), irradiance: Vec3::ONE });
        let state = FrameState { sun, ..FrameState::new(camera, vec![Pose::REST]) };
        let settings = RenderSettings { size: (48, 24), samples: 1, shadows: false, ..Default::default() };
        let output =
            if in_two { renderer.render_in_two_passes(&state, &settings) } else { renderer.render(&state, &settings) };
        output.unwrap().color
    };
    let paint = |rank: f32, rise: f32| rank > 0.6 || rise > 0.3;
    let dropped = shoot(painted(&tile, 0.6, false, paint), false);
    let found = shoot(painted(&tile, 0.6, true, paint), false);
    let through = difference(&found, &shoot(painted(&tile, 0.6, true, paint), true));
    let changed = difference(&dropped, &found);
    println!("classes change {changed:.5}, through a G-buffer {through:.1e}");
    assert!(through < 1e-6 && changed > 0.02, "{through} {changed}");
    let plain = |follows| shoot(painted(&tile, 0.6, follows, |_, _| true), false);
    assert_eq!(plain(true), plain(false));
}

/// A material with red tops, and the material of a moss that covers stripes of it.
fn red_tops(size: u32) -> (Material, MaterialDetail) {
    let map = HeightMap::new(size, size, procedural::gaussian(size, size, 3, 1.0, 0.016).texels).unwrap();
    let raster = |width: u32, channels: usize, codes: Vec<u8>| {
        Raster::new(width, (codes.len() / channels) as u32 / width, channels, Samples::U8(codes)).unwrap()
    };
    let codes =
        map.texels.iter().flat_map(|&h| if h > 0.006 { [RED[0], RED[1], RED[2]] } else { [GREY[0], GREY[1], GREY[2]] });
    let colors = Texture::new(raster(size, 3, codes.collect()), "red tops", Encoding::Srgb);
    let stripes = (0..64).map(|i| if i % 8 < 4 { 255 } else { 0 }).collect();
    let mut layer = Material::new("moss");
    layer.base_color = Input::constant([0.05, 0.3, 0.02]);
    let fine = HeightMap::new(32, 32, procedural::gaussian(32, 32, 4, 1.0, 0.1).texels).unwrap();
    layer.relief = Some(Relief { map: fine, scale: Some(0.002), middle: 0.0, in_widths: false });
    let mut material = Material::new("red tops");
    // The specular reflection has no colour and its own errors.
    material.specular = Input::constant(0.0);
    material.base_color = Input::colors(colors);
    material.relief = Some(Relief { map, scale: Some(0.7), middle: 0.0, in_widths: false });
    let mask = Some(Texture::new(raster(64, 1, stripes), "stripes", Encoding::Linear));
    let detail = MaterialDetail {
        material: layer,
        colored: true,
        repeat: 6.0,
        rotation: 30.0,
        height_scale: 1.0,
        displaces: false,
        mask,
    };
    (material, detail)
}

/// Paint on the tops of a material, with and without a detail that covers a part of it.
#[test]
#[ignore = "long"]
fn tops_under_a_detail() {
    let Some(gpu) = test_gpu() else { return };
    let (bare, detail) = red_tops(128);
    let covered = Material { detail: Some(Box::new(detail)), ..bare.clone() };
    let mut changes = Vec::new();
    for material in [&bare, &covered] {
        let shoot = |follows: bool, technique: Technique, samples: u32| {
            let mut stage = dressed::plane_stage(material, None);
            // Steep, with pixels as wide as several bumps.
            let positions = &stage.objects[0].mesh.positions;
            let centre = positions.iter().sum::<Vec3>() / positions.len() as f32;
            let eye = centre + Vec3::new(0.3, -0.85, 0.42).normalize() * 200.0;
            let camera =
                Camera { near: 1.0, ..Camera::looking_at(eye, centre, 2.0 * (1.05f32 / 200.0).atan().to_degrees()) };
            stage.objects.iter_mut().for_each(|object| object.follows_relief = follows);
            let mut renderer = under_sky(&gpu, stage.take_scene(), 16);
            let state = FrameState::new(camera, vec![Pose::REST]).under(&Sky::default());
            let shading =
                technique.with(ShadingOptions { relief_shadows: technique.is_reference(), ..Default::default() });
            let tessellation = TessellationSettings { to_texels: true, ..Default::default() };
            let settings =
                RenderSettings { size: (8, 8), samples, shading, tessellation, shadows: false, ..Default::default() };
            renderer.render(&state, &settings).unwrap().color
        };
        let [on, off] = [true, false].map(|follows| shoot(follows, Technique::Leadr, 1));
        let truth = shoot(false, Technique::Reference, 64);
        let change = difference(&on, &off);
        let red = |picture: &[[f32; 4]]| {
            let sum = |c: usize| picture.iter().map(|texel| f64::from(texel[c])).sum::<f64>();
            sum(0) / (sum(0) + sum(1) + sum(2))
        };
        let [want, got, mean] = [&truth, &on, &off].map(|picture| red(picture));
        println!("change {change:.5}, red {want:.4}, LEADR {got:.4}, of the mean colour {mean:.4}");
        assert!((got - want).abs() < 0.7 * (mean - want).abs(), "{want} {got} {mean}");
        changes.push(change);
    }
    // Colours covered by the detail follow nothing.
    assert!(changes[1] < changes[0], "{changes:?}");
}
