//! Details over materials, normal maps on smooth geometry, and anisotropic bases.

use glam::{Affine2, DVec2, DVec3, Mat2, Vec2, Vec3};
use leadr::gpu::Gpu;
use leadr::maps::RgbImage;
use leadr::maps::material::{Anisotropy, Input, Material, MaterialDetail, Relief, TextureWrap, alpha_code, alpha_of};
use leadr::maps::tonemap::Tonemap;
use leadr::maps::{HeightMap, procedural};
use leadr::reflectance::facets::normal_distribution::tail_mean_ratio;
use leadr::reflectance::facets::shortened_normals::Shortening;
use leadr::reflectance::masking::shadowing::Shadowing;
use leadr::reflectance::materials::classic::normal_variance;
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::light::environment::Environment;
use leadr::render::light::sky::Sky;
use leadr::render::scene::{
    Detail, DetailColors, DetailMapping, FactorMap, FrameState, MaterialMap, Object, Pose, PropertyMap,
};
use leadr::render::settings::{RenderSettings, ShadingOptions, Technique, Terms};
use leadr::render::surfaces::displacement::HeightField;
use leadr::render::surfaces::tessellation::TessellationSettings;
use leadr::scenes::dressed;
use leadr::scenes::plane::{even, plane};
use leadr::scenes::spheres::cell::{Lighting, ROTATION_PERIOD};
use leadr::scenes::spheres::surface::{Detail as Fineness, Frequency, Surface};
use leadr_testing::gpu::test_gpu;
use leadr_testing::render::{bumps, in_room, under_sky};
use leadr_tools::metrics::compare::compare;
use std::sync::Arc;

fn error(truth: &RgbImage, test: &RgbImage) -> f64 {
    compare(truth, test, 1.0, Tonemap::Filmic).unwrap().rrmse
}

fn picture(renderer: &mut Renderer, state: &FrameState, settings: &RenderSettings) -> RgbImage {
    let output = renderer.render(state, settings).unwrap();
    let (width, height) = output.size;
    RgbImage::new(width, height, output.color.iter().map(|c| [c[0], c[1], c[2]]).collect()).unwrap()
}

/// Settings without shadows, to compare only the filter.
fn settings(technique: Technique, size: u32, samples: u32, shadowing: Shadowing) -> RenderSettings {
    RenderSettings {
        size: (size, size),
        samples,
        shading: technique.with(ShadingOptions { shadowing, relief_occlusion: false, ..Default::default() }),
        tessellation: TessellationSettings { to_texels: technique == Technique::Reference, ..Default::default() },
        shadows: false,
        ..Default::default()
    }
}

/// Texels along a base, texels along a detail, and repeats of the detail; texel sizes are equal.
const BASE: u32 = 512;
const FINE: u32 = 64;
const REPEATS: u32 = BASE / FINE;
/// Width of one repeat of the base, metres.
const METRES: f32 = 2.0;
const STEEP: f32 = 0.12;
const FINE_STEEP: f32 = 0.3;

/// Slopes of repeating heights by central differences, per unit of their own coordinates.
fn slopes_of(field: &HeightField) -> Vec<[f32; 2]> {
    let n = field.map.width;
    let at = |x: u32, y: u32| field.map.texels[((y % n) * n + x % n) as usize];
    let per = 0.5 * n as f32;
    (0..n * n)
        .map(|i| (i % n, i / n))
        .map(|(x, y)| [(at(x + 1, y) - at(x + n - 1, y)) * per, (at(x, y + 1) - at(x, y + n - 1)) * per])
        .collect()
}

/// The mask of the tests' detail: soft stripes, or everywhere.
fn mask(masked: bool) -> Vec<f32> {
    let wave = |i: u32| {
        let s = (i % BASE) as f32 / BASE as f32;
        if masked { (0.5 + 2.0 * (s * 11.0 * std::f32::consts::TAU).sin()).clamp(0.0, 1.0) } else { 1.0 }
    };
    (0..BASE * BASE).map(wave).collect()
}

/// A plane with a coarse and a fine relief, as a detail or as one map of the sum. `rotated`: by a quarter turn.
fn layered(gpu: &Arc<Gpu>, as_detail: bool, masked: bool, rotated: bool) -> Renderer {
    let mesh = plane(4.0, 16, METRES, [0.4, 0.35, 0.3, 0.25], even);
    let (coarse, fine) = (bumps(BASE, 24.0, 5), bumps(FINE, 4.0, 9));
    let base: Vec<[f32; 2]> = slopes_of(&coarse).iter().map(|s| s.map(|v| v * STEEP * METRES)).collect();
    let metres = METRES / REPEATS as f32;
    let detail_slopes: Vec<[f32; 2]> = slopes_of(&fine).iter().map(|s| s.map(|v| v * FINE_STEEP * metres)).collect();
    let mut heights = coarse;
    heights.map.texels.iter_mut().for_each(|h| *h *= STEEP * METRES);
    let (masks, object) = (mask(masked), Object::new("plane", mesh).with_specular_f0(0.1).without_shadow());
    let object = object.with_heights(heights, 1.0);
    if as_detail {
        let rotation = if rotated { Mat2::from_angle(-std::f32::consts::FRAC_PI_2) } else { Mat2::IDENTITY };
        let detail = Detail {
            heights: HeightField { map: HeightMap { texels: vec![0.0; (FINE * FINE) as usize], ..fine.map }, ..fine },
            slopes: Some(detail_slopes),
            material: None,
            mapping: DetailMapping::Texcoords,
            transform: Affine2::from_mat2(rotation * REPEATS as f32),
            displaces: false,
            mask: masked.then_some(FactorMap {
                width: BASE,
                height: BASE,
                texels: masks,
                transform: Affine2::IDENTITY,
            }),
        };
        return under_sky(gpu, vec![object.with_slopes(base).with_detail(detail)], 64);
    }
    let sum = (0..BASE * BASE).map(|i| {
        let (x, y) = (i % BASE, i / BASE);
        // One unit of the base's coordinates holds this many repeats.
        let at = |x: u32, y: u32| detail_slopes[((y % FINE) * FINE + x % FINE) as usize].map(|v| v * REPEATS as f32);
        // A quarter turn: the detail's s is -t' there; its texel (u, v) lies at (-v, u) of the plane.
        let [s, t] = if rotated {
            let [along, across] = at(y, BASE - 1 - x);
            [-across, along]
        } else {
            at(x, y)
        };
        let m = masks[i as usize];
        [base[i as usize][0] + m * s, base[i as usize][1] + m * t]
    });
    under_sky(gpu, vec![object.with_slopes(sum.collect())], 64)
}

/// Near, middle and far.
const DISTANCES: [f32; 3] = [1.2, 6.0, 30.0];

#[test]
fn detail_equals_a_map_of_the_sum() {
    let Some(gpu) = test_gpu() else { return };
    for (masked, rotated) in [(false, false), (true, false), (false, true)] {
        let (mut layers, mut sum) = (layered(&gpu, true, masked, rotated), layered(&gpu, false, masked, rotated));
        for distance in DISTANCES {
            let from = Vec3::new(0.3, -0.7, 0.55).normalize() * distance;
            let camera = Camera::looking_at(from, Vec3::ZERO, 12.0);
            let state = FrameState::new(camera, vec![Pose::REST]).under(&Sky::default());
            let settings = settings(Technique::Leadr, 40, 1, Shadowing::None);
            let found = error(&picture(&mut sum, &state, &settings), &picture(&mut layers, &state, &settings));
            println!("masked {masked}, turned {rotated}, {distance} m: relative RMSE {found:.4}");
            assert!(found < 0.03, "{found}");
        }
    }
}

/// The gloss technique multiplies the lengths of the mean normals of base and detail (Chan 2018, eq. 34), so a plane with a distant detail
/// equals a rougher plane. A detail may have a roughness of its own, over all of the plane or a part of it.
#[test]
fn a_distant_detail_is_gloss() {
    let Some(gpu) = test_gpu() else { return };
    let base = 0.25f64;
    let plane_of = |alpha: f64| {
        let mesh = plane(4.0, 16, METRES, [0.4, 0.35, 0.3, alpha as f32], even);
        Object::new("plane", mesh).with_specular_f0(0.5).without_shadow()
    };
    let fine = bumps(FINE, 4.0, 9);
    let metres = METRES / REPEATS as f32;
    let slopes: Vec<[f32; 2]> = slopes_of(&fine).iter().map(|s| s.map(|v| v * FINE_STEEP * metres)).collect();
    let per = 1.0 / f64::from(FINE * FINE) / f64::from(metres * metres);
    let variance = [0, 1].map(|k| slopes.iter().map(|s| f64::from(s[k] * s[k])).sum::<f64>() * per);
    let (own, shortening) = (alpha_code(0.3), Shortening::ALL[0]);
    // The roughness of the base with a detail that has a roughness of its own or none. `share` scales its slopes and its own spread.
    let combined = |share: f64, is_rough: bool| {
        let spread = normal_variance(DVec2::ZERO, DVec3::new(variance[0], variance[1], 0.0) * share * share);
        let rough = if is_rough { share * (1.0 - shortening.length(f64::from(alpha_of(own)))) } else { 0.0 };
        let slopes = 1.0 - tail_mean_ratio(spread.sqrt().recip());
        shortening.alpha_of_shortening(1.0 - slopes * (1.0 - rough) * shortening.length(base))
    };
    let detail = |share: f32, is_rough: bool| Detail {
        heights: HeightField {
            map: HeightMap { texels: vec![0.0; (FINE * FINE) as usize], ..fine.map.clone() },
            ..fine.clone()
        },
        slopes: Some(slopes.clone()),
        material: is_rough.then(|| (MaterialMap::new(1, 1, vec![[255, 255, 255, own]]), DetailColors::Vary)),
        mapping: DetailMapping::Texcoords,
        transform: Affine2::from_scale(Vec2::splat(REPEATS as f32)),
        mask: Some(FactorMap { width: 1, height: 1, texels: vec![share], transform: Affine2::IDENTITY }),
        displaces: false,
    };
    let camera = Camera::looking_at(Vec3::new(0.3, -0.7, 0.55).normalize() * 300.0, Vec3::ZERO, 1.0);
    let state = FrameState::new(camera, vec![Pose::REST]).under(&Sky::default());
    let settings = settings(Technique::Gloss, 24, 1, Shadowing::None);
    let draw = |object| picture(&mut under_sky(&gpu, vec![object], 64), &state, &settings);
    for (share, is_rough, without) in [(1.0, false, base), (1.0, true, combined(1.0, false)), (0.5, true, base)] {
        let rougher = combined(share, is_rough);
        let found = draw(plane_of(base).with_detail(detail(share as f32, is_rough)));
        let [error, of_other] = [rougher, without].map(|alpha| error(&draw(plane_of(alpha)), &found));
        println!("α {rougher:.3}: {error:.4}, as α {without:.3}: {of_other:.4}");
        assert!(rougher > 1.5 * without && error < 0.01 && of_other > 5.0 * error, "{error} {of_other}");
    }
}

/// A detail removes neither emission nor occlusion of its base: the light equals that without them, times the accessibility, plus the
/// emission.
#[test]
fn emission_and_occlusion_work_under_a_detail() {
    let Some(gpu) = test_gpu() else { return };
    let from = Vec3::new(0.1, -0.3, 0.95).normalize() * 6.0;
    let camera = Camera::looking_at(from, Vec3::ZERO, 12.0);
    let state = FrameState::new(camera, vec![Pose::REST]).under(&Sky::default());
    let terms = Terms::DIFFUSE_ENVIRONMENT | Terms::DIFFUSE_LIGHTS;
    let shading = Technique::Leadr.with(ShadingOptions { terms, shadowing: Shadowing::None, ..Default::default() });
    let settings = RenderSettings { size: (24, 24), shading, shadows: false, ..Default::default() };
    let light = |detail: bool, emission: Option<[f32; 3]>, occlusion: Option<f32>| {
        let fine = bumps(FINE, 4.0, 9);
        let wrap = [TextureWrap::Repeat; 2];
        let material = MaterialMap {
            emission: emission.map(|e| PropertyMap { width: 1, height: 1, texels: vec![e], wrap }),
            occlusion: occlusion.map(|v| PropertyMap { width: 1, height: 1, texels: vec![v], wrap }),
            ..MaterialMap::new(1, 1, vec![[128, 128, 128, 200]])
        };
        let object =
            Object::new("plane", plane(4.0, 4, METRES, [1.0; 4], even)).without_shadow().with_material(material);
        let detail = detail.then(|| Detail {
            slopes: Some(slopes_of(&fine).iter().map(|s| s.map(|v| v * FINE_STEEP)).collect()),
            heights: fine,
            material: None,
            mapping: DetailMapping::Texcoords,
            transform: Affine2::from_scale(Vec2::splat(8.0)),
            mask: None,
            displaces: false,
        });
        let object = detail.into_iter().fold(object, Object::with_detail);
        let picture = picture(&mut under_sky(&gpu, vec![object], 32), &state, &settings);
        picture.texels[12 * 24 + 12]
    };
    for detail in [false, true] {
        let bare = light(detail, None, None);
        let glows = light(detail, Some([0.25, 0.5, 0.75]), None);
        let both = light(detail, Some([0.25, 0.5, 0.75]), Some(0.5));
        let emitted = [0, 1, 2].map(|c| glows[c] - bare[c]);
        assert!(emitted[0] > 0.0 && (emitted[2] / emitted[0] - 3.0).abs() < 0.02, "{detail} {emitted:?}");
        let seen = [0, 1, 2].map(|c| (both[c] - emitted[c]) / bare[c]);
        println!("detail {detail}: emits {emitted:?}, sees {seen:?}");
        assert!(seen.iter().all(|share| (0.3..0.95).contains(share)), "{detail} {seen:?}");
    }
    gpu.assert_silent();
}

/// One sample of a base and a detail against supersampling; it fails without the detail's variance.
#[test]
#[ignore = "long"]
fn a_detail_is_filtered() {
    let Some(gpu) = test_gpu() else { return };
    let mut layers = layered(&gpu, true, true, false);
    for distance in DISTANCES.into_iter().skip(1) {
        // From above, because a detail is shading only: the reference samples it as a normal map, LEADR as a relief.
        let camera = Camera::looking_at(Vec3::new(0.1, -0.3, 0.95).normalize() * distance, Vec3::ZERO, 12.0);
        let state = FrameState::new(camera, vec![Pose::REST]).under(&Sky::default());
        let mut of =
            |technique, samples| picture(&mut layers, &state, &settings(technique, 20, samples, Shadowing::None));
        let truth = of(Technique::Reference, 256);
        let (leadr, mip) = (error(&truth, &of(Technique::Leadr, 1)), error(&truth, &of(Technique::NormalMip, 1)));
        println!("{distance} m: relative RMSE {leadr:.4}, with mean slopes alone {mip:.4}");
        assert!(leadr < 0.09 && (distance < 10.0 || leadr < mip), "{leadr} {mip}");
    }
}

/// A user's material with a detail that covers it, on the plane and on the sphere.
#[test]
#[ignore = "long"]
fn details_cover_and_vary_materials() {
    let Some(gpu) = test_gpu() else { return };
    let mut material = Material::new("base");
    let map = HeightMap::new(64, 64, procedural::gaussian(64, 64, 3, 1.0, 0.1).texels).unwrap();
    material.relief = Some(Relief { map, scale: Some(0.05), middle: 0.0, in_widths: false });
    let mut layer = Material::new("layer");
    layer.base_color = Input::constant([0.05, 0.3, 0.02]);
    layer.roughness = Input::constant(0.9);
    let fine = HeightMap::new(32, 32, procedural::gaussian(32, 32, 4, 1.0, 0.1).texels).unwrap();
    layer.relief = Some(Relief { map: fine, scale: Some(0.01), middle: 0.0, in_widths: false });
    let detail = |mask| MaterialDetail {
        material: layer.clone(),
        colored: true,
        repeat: 6.0,
        rotation: 30.0,
        height_scale: 1.0,
        displaces: false,
        mask,
    };
    let stripes = (0..64).map(|i| if i % 8 < 4 { 255 } else { 0 }).collect();
    let stripes = leadr::maps::material::Raster::new(64, 1, 1, leadr::maps::material::Samples::U8(stripes)).unwrap();
    let stripes = leadr::maps::material::Texture::new(stripes, "stripes", leadr::maps::material::Encoding::Linear);
    let mut means = Vec::new();
    for detail in [None, Some(detail(None)), Some(detail(Some(stripes)))] {
        material.detail = detail.map(Box::new);
        for (mut stage, most) in
            [(dressed::plane_stage(&material, None), 0.1), (dressed::sphere_stage(&material, None, 16), 0.16)]
        {
            // A pixel covers several texels, and the surface fills most of the picture.
            let camera = Camera::looking_at(Vec3::new(0.3, -0.7, 0.65).normalize() * 20.0, Vec3::ZERO, 12.0);
            let mut renderer = under_sky(&gpu, stage.take_scene(), 64);
            let state = FrameState::new(camera, vec![Pose::REST]).under(&Sky::default());
            let mut of =
                |technique, samples| picture(&mut renderer, &state, &settings(technique, 24, samples, Shadowing::None));
            let (one, truth) = (of(Technique::Leadr, 16), of(Technique::Reference, 64));
            let found = error(&truth, &one);
            println!("relative RMSE {found:.4}, mean {:?}", one.mean());
            assert!(found < most, "{found}");
            means.push(one.mean());
        }
    }
    // Without a mask the layer's constant colour changes nothing; with one, half of the plane is green.
    let green = |mean: [f64; 3]| mean[1] / mean[0];
    assert!((green(means[2]) / green(means[0]) - 1.0).abs() < 0.02, "{means:?}");
    assert!(green(means[4]) > 1.1 * green(means[0]), "{means:?}");
}

/// Fine-grained heights without a scale, as in material libraries, over a smooth specular base: however fine they are, the reflection stays
/// bright. At the default height of coarse relief their slopes would be 3.3, and facets of such a relief would only reflect each other.
#[test]
fn fine_grain_does_not_blacken_a_mirror() {
    let Some(gpu) = test_gpu() else { return };
    let mean = |grain: Option<(u32, Option<f32>)>| {
        let mut material = Material::new("mirror");
        material.base_color = Input::constant([0.9; 3]);
        material.metalness = Input::constant(1.0);
        material.roughness = Input::constant(0.2);
        material.detail = grain.map(|(n, scale)| {
            let mut layer = Material::new("grain");
            let (slope, size) = (0.075 * n as f32, 2.0 / n as f32);
            let map = HeightMap::new(n, n, procedural::gaussian(n, n, 3, slope, size).texels).unwrap();
            layer.relief = Some(Relief { map, scale, in_widths: false, middle: 0.0 });
            let (colored, repeat, rotation, height_scale) = (false, 8.0, 0.0, 1.0);
            Box::new(MaterialDetail {
                material: layer,
                colored,
                repeat,
                rotation,
                height_scale,
                displaces: false,
                mask: None,
            })
        });
        let objects = std::mem::take(&mut dressed::sphere_stage(&material, None, 16).objects);
        let centre = objects[0].mesh.positions.iter().sum::<Vec3>() / objects[0].mesh.positions.len() as f32;
        let mut renderer = in_room(&gpu, objects, [1.0; 3]);
        let camera = Camera::looking_at(centre + Vec3::new(0.3, -0.8, 0.5).normalize() * 20.0, centre, 3.0);
        let state = FrameState::new(camera, vec![Pose::REST]);
        picture(&mut renderer, &state, &settings(Technique::Leadr, 8, 1, Shadowing::Correlated)).mean()[0]
    };
    let smooth = mean(None);
    // 6 % of an eighth of 1.2 m.
    let [usual, steep] = [None, Some(0.009)].map(|scale| mean(Some((512, scale))) / smooth);
    println!("of the smooth mirror: {usual:.3}, as high as coarse grain {steep:.3}");
    assert!((0.8..1.001).contains(&usual) && steep < 0.2, "{usual} {steep}");
}

/// The top row of the LEADR paper's Figure 8: normal maps of Gaussian slopes, supersampled, and LEADR with the normal map's facets.
#[test]
#[ignore = "long"]
fn normal_maps_are_filtered_as_normal_maps() {
    let Some(gpu) = test_gpu() else { return };
    let surface = Surface::bake(Vec2::ONE, Frequency::High, Fineness { patches: 8, tile: 32 });
    for (lighting, terms) in [
        (Lighting::Front, Terms::DIFFUSE_LIGHTS),
        (Lighting::Irradiance, Terms::DIFFUSE_ENVIRONMENT),
        (Lighting::Environment, Terms::SPECULAR_ENVIRONMENT),
    ] {
        let mut stage = surface.stage(1.0, lighting.facets());
        let environment = Environment::from_equirect(&gpu, 64, &lighting.panorama()).unwrap();
        let mut renderer = Renderer::new(&gpu, stage.take_scene(), environment).unwrap();
        for sigma in [0.2, 1.0] {
            let mut mean = |technique: Technique, samples: u32, shadowing: Shadowing, displacement: bool| {
                let mut settings = settings(technique, 24, samples, shadowing);
                settings.displacement = displacement;
                settings.shading = settings.shading.adjusted(|options| ShadingOptions { terms, ..options });
                let mut texels = vec![[0.0f32; 3]; 24 * 24];
                for turn in 0..4 {
                    let mut state =
                        stage.state(ROTATION_PERIOD * f64::from(turn) / 4.0, &stage.views.mid, &lighting.lights());
                    state.height_scale = sigma;
                    let one = picture(&mut renderer, &state, &settings);
                    texels.iter_mut().zip(&one.texels).for_each(|(t, o)| (0..3).for_each(|c| t[c] += 0.25 * o[c]));
                }
                RgbImage::new(24, 24, texels).unwrap()
            };
            let of_truth = if lighting == Lighting::Environment { 256 } else { 64 };
            let truth = mean(Technique::Reference, of_truth, Shadowing::NormalMap, false);
            let mapped = error(&truth, &mean(Technique::Leadr, 4, Shadowing::NormalMap, false));
            let displaced = error(&truth, &mean(Technique::Leadr, 4, Shadowing::None, false));
            println!("{lighting:?}, σ {sigma}: as a normal map {mapped:.4}, as a relief {displaced:.4}");
            // Specular reflections of a studio with small lamps on smooth geometry are the hardest case.
            let most = if lighting == Lighting::Environment { 0.17 } else { 0.08 };
            assert!(mapped < most, "{mapped}");
            assert!(sigma < 0.5 || displaced > 2.0 * mapped, "{displaced} {mapped}");
        }
    }
}

/// An anisotropic ball: one sample against supersampling, and the direction matters.
#[test]
fn anisotropic_metal_is_filtered() {
    let Some(gpu) = test_gpu() else { return };
    let ball = |strength: f32, rotation: f32| {
        let mut material = Material::new("ball");
        material.base_color = Input::constant([0.9, 0.9, 0.9]);
        material.metalness = Input::constant(1.0);
        material.roughness = Input::constant(0.35);
        let strength = Input::constant(strength);
        material.anisotropy = Some(Anisotropy { strength, rotation, direction: None });
        dressed::sphere_stage(&material, None, 16)
    };
    let of = |strength, rotation, technique, samples| {
        let mut stage = ball(strength, rotation);
        let mut renderer = under_sky(&gpu, stage.take_scene(), 64);
        let state = FrameState::new(stage.views.mid, vec![Pose::REST]).under(&Sky::default());
        picture(&mut renderer, &state, &settings(technique, 32, samples, Shadowing::None))
    };
    let truth = of(0.6, 0.0, Technique::Reference, 128);
    let one = error(&truth, &of(0.6, 0.0, Technique::Leadr, 16));
    let across = error(&truth, &of(0.6, std::f32::consts::FRAC_PI_2, Technique::Leadr, 16));
    let round = error(&truth, &of(0.0, 0.0, Technique::Leadr, 16));
    println!("relative RMSE {one:.4}, brushed the other way {across:.4}, not brushed {round:.4}");
    assert!(one < 0.06 && across > 3.0 * one && round > 3.0 * one, "{one} {across} {round}");
}
