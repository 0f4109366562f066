//! Diffuse bases, light between facets, gloss and occlusion cones: furnaces, and the environment light on a plane.

use glam::{DVec3, Vec3};
use leadr::maps::material::{TextureWrap, alpha_code, alpha_of};
use leadr::reflectance::facets::gloss::Gloss;
use leadr::reflectance::masking::occlusion::{
    Cone, ConeAxis, ConeEdge, ConeLobe, Hidden, adjusted_visibility, cone_light_by_edge, interreflected_visibility,
};
use leadr::reflectance::masking::shadowing::Shadowing;
use leadr::reflectance::materials::diffuse_models::{
    DiffuseModel, conserving_diffuse, diffuse_model_albedo, diffuse_value,
};
use leadr::reflectance::materials::energy::EnergyTable;
use leadr::reflectance::visible::cone_specular::cone_specular;
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::scene::{FrameState, MaterialMap, Object, Pose, PropertyMap, Sun};
use leadr::render::settings::{FresnelForm, RenderSettings, ShadingOptions, Technique, Terms};
use leadr::scenes::plane::{even, plane};

use leadr_testing::gpu::{TestGpu, test_gpu};
use leadr_testing::render::in_room;

const ALBEDO: f64 = 0.6;

/// A smooth plane, whose albedo is in its colours.
fn ground(albedo: u8, alpha: f32, f0: f32, cone: Option<[f32; 4]>) -> Object {
    let map = MaterialMap {
        cones: cone.map(|cone| PropertyMap { width: 1, height: 1, texels: vec![cone], wrap: [TextureWrap::Repeat; 2] }),
        ..MaterialMap::new(1, 1, vec![[albedo, albedo, albedo, alpha_code(alpha)]])
    };
    Object::new("plane", plane(2.0, 2, 1.0, [1.0; 4], even)).with_material(map).with_specular_f0(f0)
}

/// The code of [`ALBEDO`].
fn code() -> u8 {
    leadr::maps::srgb::srgb8_from_linear(ALBEDO as f32)
}

/// Radiance of the plane's centre from this cosine.
fn seen(renderer: &mut Renderer, technique: Technique, model: DiffuseModel, terms: Terms, cosine: f32) -> DVec3 {
    lit(renderer, technique, model, terms, cosine, None)
}

/// Like [`seen`], also under a sun.
fn lit(
    renderer: &mut Renderer,
    technique: Technique,
    diffuse_model: DiffuseModel,
    terms: Terms,
    cosine: f32,
    sun: Option<Vec3>,
) -> DVec3 {
    drawn(renderer, technique, ShadingOptions { terms, diffuse_model, ..Default::default() }, cosine, sun)
}

fn drawn(
    renderer: &mut Renderer,
    technique: Technique,
    options: ShadingOptions,
    cosine: f32,
    sun: Option<Vec3>,
) -> DVec3 {
    let sine = (1.0 - cosine * cosine).sqrt();
    let camera = Camera::looking_at(Vec3::new(0.0, -sine, cosine) * 3.0, Vec3::ZERO, 4.0);
    let sun = sun.map(|direction| Sun { direction, irradiance: Vec3::ONE });
    let state = FrameState { sun, ..FrameState::new(camera, vec![Pose::REST]) };
    let options = ShadingOptions { shadowing: Shadowing::Smith, ..options };
    let settings = RenderSettings { size: (9, 9), shading: technique.with(options), ..Default::default() };
    let color = renderer.render(&state, &settings).unwrap().color;
    let [r, g, b, _] = color[40].map(f64::from);
    DVec3::new(r, g, b)
}

/// All of these in a room of radiance 1.
fn in_furnace(gpu: &TestGpu, object: Object) -> Renderer {
    in_room(gpu, vec![object], [1.0; 3])
}

const TECHNIQUES: [Technique; 3] = [Technique::Leadr, Technique::NormalMip, Technique::Gloss];
const COSINES: [f32; 4] = [0.2, 0.45, 0.75, 0.98];

#[test]
#[ignore = "long"]
fn mirrors_lose_no_light() {
    let Some(gpu) = test_gpu() else { return };
    for alpha in [0.03, 0.3, 0.6, 1.0] {
        let mut renderer = in_furnace(&gpu, ground(0, alpha, 1.0, None));
        for technique in TECHNIQUES {
            for cosine in COSINES {
                let all =
                    seen(&mut renderer, technique, DiffuseModel::Multiscattering, Terms::SPECULAR_ENVIRONMENT, cosine)
                        .x;
                // Gloss uses the exact albedo of its lobe; others integrate theirs by probes.
                let most = if technique == Technique::Gloss { 0.005 } else { 0.03 };
                assert!((all - 1.0).abs() < most, "{technique:?} α {alpha}, cos {cosine}: {all}");
                let once = seen(&mut renderer, technique, DiffuseModel::Lambert, Terms::SPECULAR_ENVIRONMENT, cosine).x;
                assert!(once < 1.01, "{technique:?} α {alpha}, cos {cosine}: {once}");
                if alpha == 1.0 {
                    assert!(once < 0.97 * all, "{technique:?}, cos {cosine}: {once} of {all}");
                }
            }
        }
    }
}

#[test]
fn diffuse_base_returns_remaining_energy() {
    let Some(gpu) = test_gpu() else { return };
    for alpha in [0.1, 0.5, 1.0] {
        let alpha = alpha_of(alpha_code(alpha));
        let mut renderer = in_furnace(&gpu, ground(code(), alpha, 0.04, None));
        for (technique, table) in [(Technique::Gloss, EnergyTable::ggx()), (Technique::Leadr, EnergyTable::beckmann())]
        {
            for cosine in COSINES {
                let found =
                    seen(&mut renderer, technique, DiffuseModel::Multiscattering, Terms::DIFFUSE_ENVIRONMENT, cosine).x;
                let average = table.average(alpha.into()).ideal;
                let albedo = table.albedo(alpha.into(), cosine.into());
                let enters = leadr::reflectance::materials::energy::entered(DVec3::splat(0.04), albedo, average);
                let white = f64::from(leadr::maps::srgb::linear_from_srgb(f32::from(code()) / 255.0));
                // The colour is the albedo of the surface, for any number of bounces.
                let expected = white * enters.x;
                let most = if technique == Technique::Gloss { 0.01 } else { 0.03 };
                assert!(
                    (found / expected - 1.0).abs() < most,
                    "{technique:?} α {alpha}, cos {cosine}: {found} {expected}"
                );
                // With the specular term, no more than the incident light.
                let whole = Terms::DIFFUSE_ENVIRONMENT | Terms::SPECULAR_ENVIRONMENT;
                assert!(seen(&mut renderer, technique, DiffuseModel::Multiscattering, whole, cosine).x < 1.0);
                // The specular and the diffuse term divide the light in the same way for both Fresnel terms.
                let whole_of = |renderer: &mut _, fresnel, terms| {
                    let diffuse_model = DiffuseModel::Multiscattering;
                    let options = ShadingOptions { terms, diffuse_model, fresnel, ..Default::default() };
                    drawn(renderer, technique, options, cosine, None).x
                };
                let [schlick, exact] = [FresnelForm::Schlick, FresnelForm::Exact].map(|fresnel| {
                    let diffuse = whole_of(&mut renderer, fresnel, Terms::DIFFUSE_ENVIRONMENT) / white;
                    diffuse + whole_of(&mut renderer, fresnel, Terms::SPECULAR_ENVIRONMENT)
                });
                assert!((schlick - exact).abs() < 0.01, "{technique:?} α {alpha}, {cosine}: {schlick} {exact}");
            }
        }
    }
}

/// The blend of ideal facets with Lambert's law (thesis eq. 5.4 with F = 1), in a furnace and under a sun.
#[test]
fn the_blend_of_the_thesis_keeps_its_energy() {
    let Some(gpu) = test_gpu() else { return };
    let white = f64::from(leadr::maps::srgb::linear_from_srgb(f32::from(code()) / 255.0));
    let alpha = alpha_of(alpha_code(0.2));
    let blend = |terms| ShadingOptions { terms, diffuse_model: DiffuseModel::Blend, ..Default::default() };
    let sun = Vec3::new(0.2, 0.5, 0.8).normalize();
    for technique in TECHNIQUES {
        let [mut furnace, mut ideal] = [code(), 0].map(|albedo| in_furnace(&gpu, ground(albedo, alpha, 1.0, None)));
        let [mut dark, mut mirror] =
            [code(), 0].map(|albedo| in_room(&gpu, vec![ground(albedo, alpha, 1.0, None)], [0.0; 3]));
        for cosine in [0.45, 0.98] {
            let all = drawn(&mut furnace, technique, blend(Terms::ALL), cosine, None).x;
            let lambert = |terms| ShadingOptions { terms, ..Default::default() };
            let facets = drawn(&mut ideal, technique, lambert(Terms::SPECULAR_ENVIRONMENT), cosine, None).x;
            let expected = white + (1.0 - white) * facets;
            assert!((all - expected).abs() < 5e-3, "{technique:?}, cos {cosine}: {all} for {expected}");
            // The facets of roughness .2 shadow little. Those of gloss, which are GGX, lose more of the light.
            assert!(technique == Technique::Gloss || (all - 1.0).abs() < 0.015, "{technique:?}, cos {cosine}: {all}");
            let specular = drawn(&mut mirror, technique, lambert(Terms::SPECULAR_LIGHTS), cosine, Some(sun)).x;
            let [own, diffuse] = [Terms::SPECULAR_LIGHTS, Terms::DIFFUSE_LIGHTS]
                .map(|terms| drawn(&mut dark, technique, blend(terms), cosine, Some(sun)).x);
            // Colours have 8 bits, and their filter rounds to 16.
            assert!((own / specular - (1.0 - white)).abs() < 3e-3, "{technique:?}: {own} of {specular}");
            let expected = white * f64::from(sun.z) / std::f64::consts::PI;
            assert!((diffuse / expected - 1.0).abs() < 0.02, "{technique:?}: {diffuse} for {expected}");
        }
    }
}

/// Each model has its albedo in an even environment, and its value under a sun. Burley's and Chan's models contain the loss to the coat.
#[test]
fn diffuse_models_are_drawn() {
    let Some(gpu) = test_gpu() else { return };
    let (alpha, white) =
        (alpha_of(alpha_code(0.7)), f64::from(leadr::maps::srgb::linear_from_srgb(f32::from(code()) / 255.0)));
    let mut room = in_furnace(&gpu, ground(code(), alpha, 0.04, None));
    let mut dark = in_room(&gpu, vec![ground(code(), alpha, 0.04, None)], [0.0; 3]);
    let sun = Vec3::new(0.3, -0.8, 0.4).normalize();
    let models = [DiffuseModel::OrenNayar, DiffuseModel::Disney, DiffuseModel::CallOfDuty];
    for (technique, cosine) in [(Technique::Leadr, 0.2f32), (Technique::Leadr, 0.75), (Technique::Gloss, 0.45)] {
        let mut even = |model| seen(&mut room, technique, model, Terms::DIFFUSE_ENVIRONMENT, cosine).x;
        let mut under_sun = |model| lit(&mut dark, technique, model, Terms::DIFFUSE_LIGHTS, cosine, Some(sun)).x;
        let (lambert, lambert_lit) = (even(DiffuseModel::Lambert), under_sun(DiffuseModel::Lambert));
        assert!(lambert > 0.5 * white && lambert_lit > 0.01, "{lambert} {lambert_lit}");
        let wo = DVec3::new(0.0, -f64::from(cosine.mul_add(-cosine, 1.0).sqrt()), cosine.into());
        for model in models {
            let coat = if model == DiffuseModel::OrenNayar { lambert / white } else { 1.0 };
            let grey = DVec3::splat(white);
            let albedo = diffuse_model_albedo(model, cosine.into(), alpha.into(), grey).x;
            let value = diffuse_value(model, wo, sun.as_dvec3(), alpha.into(), grey).x;
            let (found, found_lit) =
                (even(model) / (white * coat), under_sun(model) / lambert_lit * lambert / (white * coat));
            assert!((found - albedo).abs() < 0.004, "{technique:?} {model:?} {cosine}: {found} {albedo}");
            assert!((found_lit - value).abs() < 0.01, "{technique:?} {model:?} {cosine}: {found_lit} {value}");
        }
    }
}

/// Lambert's law for the light that enters has the mean transmittance of the coat in an even environment, and its transmittance towards a
/// sun, from every view.
#[test]
fn conserving_bases_lose_light_on_the_way_in() {
    let Some(gpu) = test_gpu() else { return };
    let (alpha, f0) = (alpha_of(alpha_code(0.3)), DVec3::splat(0.04));
    let white = f64::from(leadr::maps::srgb::linear_from_srgb(f32::from(code()) / 255.0));
    let mut room = in_furnace(&gpu, ground(code(), alpha, 0.04, None));
    let mut dark = in_room(&gpu, vec![ground(code(), alpha, 0.04, None)], [0.0; 3]);
    let model = DiffuseModel::Conserving;
    for (technique, table) in [(Technique::Gloss, EnergyTable::ggx()), (Technique::Leadr, EnergyTable::beckmann())] {
        for cosine in [0.45f32, 0.9] {
            let even = seen(&mut room, technique, model, Terms::DIFFUSE_ENVIRONMENT, cosine).x / white;
            let want = conserving_diffuse(f0, table.average(alpha.into())).x;
            assert!((even - want).abs() < 0.004, "{technique:?} {cosine}: {even} {want}");
        }
        let high = Vec3::new(0.3, 0.0, 0.95).normalize();
        let [high, low] = [high, Vec3::new(0.97, 0.0, 0.2).normalize()].map(|sun| {
            let lit = lit(&mut dark, technique, model, Terms::DIFFUSE_LIGHTS, 0.9, Some(sun)).x;
            (
                lit * std::f64::consts::PI / (white * f64::from(sun.z)),
                conserving_diffuse(f0, table.albedo(alpha.into(), sun.z.into())).x,
            )
        });
        for (found, want) in [high, low] {
            assert!((found - want).abs() < 0.01, "{technique:?}: {found} {want}");
        }
        assert!(high.1 > low.1 + 0.06, "{high:?} {low:?}");
    }
}

/// Each choice for cones has its closed form: the light of hidden directions, the edge for a sun, and the cone for reflections.
#[test]
fn choices_for_cones_are_drawn() {
    let Some(gpu) = test_gpu() else { return };
    let (share, alpha, cosine) = (0.6f32, 0.5, 0.8f32);
    let white = DVec3::splat(leadr::maps::srgb::linear_from_srgb(f32::from(code()) / 255.0).into());
    let cone = Cone::about_normal(DVec3::Z, share.into());
    let object = |cone| ground(code(), alpha, 0.04, cone);
    let vector = Some([0.0, 0.0, share, share]);
    let (mut room, mut open) = (in_furnace(&gpu, object(vector)), in_furnace(&gpu, object(None)));
    let mut left = |technique, options: ShadingOptions| {
        drawn(&mut room, technique, options, cosine, None).x / drawn(&mut open, technique, options, cosine, None).x
    };
    for cone_occluders in Hidden::ALL {
        let options = ShadingOptions { terms: Terms::DIFFUSE_ENVIRONMENT, cone_occluders, ..Default::default() };
        let (found, want) =
            (left(Technique::Leadr, options), adjusted_visibility(cone_occluders, share.into(), white).x);
        assert!((found - want).abs() < 0.01, "{cone_occluders:?}: {found} {want}");
    }
    let wo = DVec3::new(0.0, -f64::from((1.0 - cosine * cosine).sqrt()), cosine.into());
    let gloss = Gloss::Wwii.gloss(alpha_of(alpha_code(alpha)).into());
    let wants = ConeLobe::ALL.map(|cone_lobe| {
        let options = ShadingOptions { terms: Terms::SPECULAR_ENVIRONMENT, cone_lobe, ..Default::default() };
        let seen = cone_lobe.of(cone, share.into(), gloss, cosine.into());
        let (found, want) = (left(Technique::Gloss, options), cone_specular(alpha.into(), wo, &seen));
        assert!((found - want).abs() < 0.01, "{cone_lobe:?}: {found} {want}");
        want
    });
    // The bent cone of this plane is about the normal.
    assert!((wants[0] - wants[1]).abs() < 1e-9 && wants[1] < wants[2] && wants[2] < wants[3], "{wants:?}");
    let mut dark = in_room(&gpu, vec![object(vector)], [0.0; 3]);
    let sun = Vec3::new(0.9, 0.0, 0.4).normalize();
    let mut under_sun = |cone_edge| {
        let options = ShadingOptions { terms: Terms::DIFFUSE_LIGHTS, cone_edge, ..Default::default() };
        drawn(&mut dark, Technique::Leadr, options, cosine, Some(sun)).x
    };
    let all = under_sun(ConeEdge::Open);
    assert!(all > 0.05, "{all}");
    for edge in ConeEdge::ALL {
        let (found, want) = (under_sun(edge) / all, cone_light_by_edge(edge, &cone, sun.as_dvec3()));
        assert!((found - want).abs() < 0.01, "{edge:?}: {found} {want}");
    }
    // A bent cone lets more of a light on its side through than the cone about the normal, and less of one on the other side.
    let bent = Vec3::new(0.3, 0.0, 0.4);
    let mut tilted = in_room(&gpu, vec![object(Some([bent.x, bent.y, bent.z, share]))], [0.0; 3]);
    for (sun, sign) in [(sun, 1.0), (Vec3::new(-0.9, 0.0, 0.4).normalize(), -1.0)] {
        let mut under_sun = |cone_edge, cone_axis| {
            let options = ShadingOptions { terms: Terms::DIFFUSE_LIGHTS, cone_edge, cone_axis, ..Default::default() };
            drawn(&mut tilted, Technique::Leadr, options, cosine, Some(sun)).x
        };
        let all = under_sun(ConeEdge::Open, ConeAxis::Bent);
        let [bent, normal] =
            [(ConeAxis::Bent, Cone::of_vector(bent.as_dvec3())), (ConeAxis::Normal, cone)].map(|(axis, cone)| {
                let (found, want) =
                    (under_sun(ConeEdge::Soft, axis) / all, cone_light_by_edge(ConeEdge::Soft, &cone, sun.as_dvec3()));
                assert!((found - want).abs() < 0.01, "{axis:?}: {found} {want}");
                want
            });
        assert!(sign * (bent - normal) > 0.05, "{bent} {normal}");
    }
}

#[test]
#[ignore = "long"]
fn cone_keeps_its_share_with_interreflection() {
    let Some(gpu) = test_gpu() else { return };
    for share in [1.0f32, 0.6, 0.25] {
        // About the normal, with a length equal to its visible fraction.
        let mut renderer = in_furnace(&gpu, ground(code(), 0.5, 0.04, Some([0.0, 0.0, share, share])));
        let mut open = in_furnace(&gpu, ground(code(), 0.5, 0.04, None));
        for technique in TECHNIQUES {
            let hidden = seen(&mut renderer, technique, DiffuseModel::Lambert, Terms::DIFFUSE_ENVIRONMENT, 0.9).x;
            let whole = seen(&mut open, technique, DiffuseModel::Lambert, Terms::DIFFUSE_ENVIRONMENT, 0.9).x;
            let white = f64::from(leadr::maps::srgb::linear_from_srgb(f32::from(code()) / 255.0));
            let expected = interreflected_visibility(share.into(), DVec3::splat(white)).x;
            assert!((hidden / whole - expected).abs() < 0.01, "{technique:?} {share}: {} {expected}", hidden / whole);
            // The specular term loses more with narrower cones, and nothing with an open one.
            let mirrors = |renderer: &mut Renderer| {
                seen(renderer, technique, DiffuseModel::Lambert, Terms::SPECULAR_ENVIRONMENT, 0.9).x
            };
            let left = mirrors(&mut renderer) / mirrors(&mut open);
            let range = if share == 1.0 { 0.98..1.001 } else { f64::from(share) * 0.8..f64::from(share) * 1.6 };
            assert!(range.contains(&left), "{technique:?} {share}: {left}");
        }
    }
}
