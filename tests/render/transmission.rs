//! Light through surfaces: furnaces, directions, colours, and the same picture by every path of the renderer.

use glam::{DVec3, Vec3};
use leadr::maps::material::alpha_code;
use leadr::reflectance::masking::shadowing::Shadowing;
use leadr::reflectance::visible::transmission::{attenuation, passed_solid, refracted_cosine};
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::light::environment::Environment;
use leadr::render::scene::{FrameState, MaterialMap, Medium, Object, Pose};
use leadr::render::settings::{FresnelForm, RenderSettings, ShadingOptions, Technique};
use leadr::scenes::plane::{even, plane};
use leadr_testing::cube::panorama;
use leadr_testing::gpu::{TestGpu, test_gpu};
use leadr_testing::render::{bumps, in_room};

const GLASS: Medium = Medium { weight: 1.0, ior: 1.5, thickness: 0.0, extinction: [0.0; 3] };
const FORMS: [FresnelForm; 2] = [FresnelForm::Schlick, FresnelForm::Exact];
const SOLID: Medium = Medium { thickness: 0.2, ..GLASS };

/// A white, colourless plane of this roughness, which light passes.
fn glass(medium: Medium, alpha: f32) -> Object {
    let map = MaterialMap::new(1, 1, vec![[255, 255, 255, alpha_code(alpha)]]);
    Object::new("glass", plane(2.0, 2, 0.05, [1.0; 4], even))
        .with_material(map)
        .with_medium(Some(medium))
        .without_shadow()
}

fn bumpy(medium: Medium) -> Object {
    glass(medium, 0.02).with_heights(bumps(64, 4.0, 3), 0.002)
}

fn settings(options: ShadingOptions) -> RenderSettings {
    let options = ShadingOptions { shadowing: Shadowing::None, ..options };
    RenderSettings { shading: Technique::Leadr.with(options), ..Default::default() }
}

fn seen(renderer: &mut Renderer, settings: RenderSettings, cosine: f32) -> DVec3 {
    let sine = (1.0 - cosine * cosine).sqrt();
    let camera = Camera::looking_at(Vec3::new(0.0, -sine, cosine) * 3.0, Vec3::ZERO, 4.0);
    let state = FrameState::new(camera, vec![Pose::REST]);
    let [r, g, b, _] =
        renderer.render(&state, &RenderSettings { size: (9, 9), ..settings }).unwrap().color[40].map(f64::from);
    DVec3::new(r, g, b)
}

/// Reflected and transmitted light of a colourless material add up to the light of a furnace.
#[test]
fn colourless_materials_are_invisible_in_a_furnace() {
    let Some(gpu) = test_gpu() else { return };
    for medium in [GLASS, SOLID, Medium { weight: 0.4, ..SOLID }] {
        for object in [glass(medium, 0.05), glass(medium, 0.5), bumpy(medium)] {
            let mut renderer = in_room(&gpu, vec![object], [1.0; 3]);
            for (cosine, fresnel) in [0.2, 0.6, 1.0].into_iter().flat_map(|c| FORMS.map(|form| (c, form))) {
                let options = ShadingOptions { fresnel, ..Default::default() };
                let found = seen(&mut renderer, settings(options), cosine).x;
                // Few probes and slopes beyond the horizon lose up to two percent at grazing angles.
                assert!((found - 1.0).abs() < 0.025, "{medium:?}, {fresnel:?}, cos {cosine}: {found}");
            }
        }
    }
}

/// A body darkens by Beer's law, and an opaque fraction scatters light.
#[test]
fn bodies_have_the_color_of_their_depth() {
    let Some(gpu) = test_gpu() else { return };
    let extinction = [1.0, 3.0, 9.0];
    let mut clear = in_room(&gpu, vec![glass(SOLID, 0.05)], [1.0; 3]);
    let mut colored = in_room(&gpu, vec![glass(Medium { extinction, ..SOLID }, 0.05)], [1.0; 3]);
    for cosine in [0.4f32, 1.0] {
        let [clear, colored] = [&mut clear, &mut colored].map(|r| seen(r, settings(ShadingOptions::default()), cosine));
        let depth = f64::from(SOLID.thickness) * refracted_cosine(cosine.into(), 1.5);
        let kept = attenuation(DVec3::from(extinction.map(f64::from)), depth);
        // The reflected light keeps its colour.
        let reflected = clear.x - (clear.x - colored.x) / (1.0 - kept.x);
        let expected = DVec3::splat(reflected) + (clear.x - reflected) * kept;
        assert!((colored - expected).length() < 0.01, "cos {cosine}: {colored} for {expected}");
        assert!(reflected > 0.02 && reflected < 0.2, "{reflected}");
    }
}

/// Under a panorama, this renderer shows radiance that changes with the direction.
fn under_panorama(gpu: &TestGpu, object: Object) -> Renderer {
    let image = panorama(128, |d| DVec3::new(0.5 + 0.5 * d.x, 0.5 + 0.5 * d.y, 0.5 + 0.5 * d.z));
    let environment = Environment::from_equirect(gpu, 64, &image).unwrap();
    Renderer::new(gpu, vec![object], environment).unwrap()
}

/// Thin walls show what is straight behind them. Solid bodies bend the light as a sphere does.
#[test]
fn light_continues_in_the_right_direction() {
    let Some(gpu) = test_gpu() else { return };
    let cosine = 0.7f32;
    let sine = f64::from(1.0 - cosine * cosine).sqrt();
    let wo = DVec3::new(0.0, -sine, cosine.into());
    let mirrored = DVec3::new(0.0, sine, cosine.into());
    for (medium, behind) in [(GLASS, -wo), (SOLID, passed_solid(wo, DVec3::Z, DVec3::Z, 1.5))] {
        let found = seen(&mut under_panorama(&gpu, glass(medium, 0.05)), settings(ShadingOptions::default()), cosine);
        let fresnel = 0.04 + 0.96 * (1.0 - f64::from(cosine)).powi(5);
        let [behind, mirrored] = [behind, mirrored].map(|d| 0.5 + 0.5 * d);
        let expected = behind * (1.0 - fresnel) + mirrored * fresnel;
        assert!((found - expected).length() < 0.02, "{medium:?}: {found} for {expected}");
    }
}

/// Rough and bumpy bodies blur what is behind them, and thin walls ignore their relief.
#[test]
fn relief_spreads_light_in_solid_bodies() {
    let Some(gpu) = test_gpu() else { return };
    let stripes = panorama(512, |d| DVec3::splat(if (40.0 * d.x.atan2(-d.z)).sin() > 0.0 { 1.0 } else { 0.0 }));
    let contrast = |object: Object| {
        let environment = Environment::from_equirect(&gpu, 128, &stripes).unwrap();
        let mut renderer = Renderer::new(&gpu, vec![object], environment).unwrap();
        let camera = Camera::looking_at(Vec3::new(0.0, -0.3, 3.0), Vec3::ZERO, 20.0);
        let state = FrameState::new(camera, vec![Pose::REST]);
        let size = RenderSettings { size: (33, 33), ..settings(ShadingOptions::default()) };
        let row: Vec<f64> =
            renderer.render(&state, &size).unwrap().color[528..561].iter().map(|c| f64::from(c[0])).collect();
        let mean = row.iter().sum::<f64>() / 33.0;
        (row.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / 33.0).sqrt()
    };
    let [thin, flat_thin, solid] = [bumpy(GLASS), glass(GLASS, 0.02), bumpy(SOLID)].map(&contrast);
    let [smooth, rough] = [glass(SOLID, 0.02), glass(SOLID, 0.6)].map(&contrast);
    assert!(smooth > 2.0 * rough && smooth > 1.2 * solid, "{smooth} {rough} {solid}");
    assert!((thin / flat_thin - 1.0).abs() < 0.1, "{thin} {flat_thin}");
}

#[test]
fn every_path_lets_light_pass() {
    let Some(gpu) = test_gpu() else { return };
    for medium in [GLASS, SOLID] {
        let mut renderer = under_panorama(&gpu, bumpy(medium));
        let at_once = seen(&mut renderer, settings(ShadingOptions::default()), 0.8);
        let edges = seen(&mut renderer, settings(ShadingOptions { edge_samples: 16, ..Default::default() }), 0.8);
        assert!((edges - at_once).length() < 0.01, "{medium:?}: {edges} for {at_once}");
        let options = ShadingOptions { shadowing: Shadowing::None, ..Default::default() };
        let reference =
            RenderSettings { samples: 32, shading: Technique::Reference.with(options), ..Default::default() };
        let reference = seen(&mut renderer, reference, 0.8);
        assert!((reference - at_once).length() < 0.05, "{medium:?}: {at_once} for {reference}");
    }
}
