//! Clear coats: furnaces, light from the sun, and the same picture by every path of the renderer.

use glam::{DVec2, DVec3, Vec3};
use leadr::maps::material::{TextureWrap, alpha_code};
use leadr::maps::srgb::{linear_from_srgb, srgb8_from_linear};
use leadr::reflectance::masking::shadowing::Shadowing;
use leadr::reflectance::visible::clear_coat::{coat_average, coat_reflectance, coated_base};
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::scene::{ClearCoat, CoatRelief, CoatTexel, FrameState, MaterialMap, Object, Pose, PropertyMap, Sun};
use leadr::render::settings::{FresnelForm, RenderSettings, ShadingOptions, Technique, Terms};
use leadr::scenes::plane::{even, plane};
use leadr_testing::gpu::test_gpu;
use leadr_testing::render::{bumps, in_room};

const COSINES: [f32; 3] = [0.2, 0.5, 0.98];
const ALPHA: f32 = 0.1;

fn coat(weight: f32, relief: CoatRelief) -> Option<ClearCoat> {
    Some(ClearCoat { weight, alpha: ALPHA, relief })
}

/// A plane of this albedo, whose base reflects `f0` at normal incidence.
fn ground(albedo: f32, f0: f32, coat: Option<ClearCoat>) -> Object {
    let code = srgb8_from_linear(albedo);
    let map = MaterialMap::new(1, 1, vec![[code, code, code, alpha_code(0.3)]]);
    Object::new("plane", plane(2.0, 2, 1.0, [1.0; 4], even)).with_material(map).with_specular_f0(f0).with_coat(coat)
}

/// The same plane with bumps smaller than a pixel.
fn bumpy(coat: Option<ClearCoat>) -> Object {
    Object { mesh: plane(2.0, 2, 0.05, [1.0; 4], even), ..ground(0.5, 0.04, coat) }
        .with_heights(bumps(64, 4.0, 3), 0.002)
}

fn options() -> ShadingOptions {
    ShadingOptions { shadowing: Shadowing::None, ..Default::default() }
}

/// The red radiance in the centre, from this cosine.
fn seen(renderer: &mut Renderer, settings: RenderSettings, cosine: f32, sun: Option<Vec3>) -> f64 {
    let sine = (1.0 - cosine * cosine).sqrt();
    let camera = Camera::looking_at(Vec3::new(0.0, -sine, cosine) * 3.0, Vec3::ZERO, 4.0);
    let sun = sun.map(|direction| Sun { direction, irradiance: Vec3::ONE });
    let state = FrameState { sun, ..FrameState::new(camera, vec![Pose::REST]) };
    let settings = RenderSettings { size: (9, 9), ..settings };
    f64::from(renderer.render(&state, &settings).unwrap().color[40][0])
}

fn settings(options: ShadingOptions) -> RenderSettings {
    RenderSettings { shading: Technique::Leadr.with(options), ..Default::default() }
}

/// What a coat does not reflect, a white base returns. Darker bases agree with the formula.
#[test]
fn a_coat_keeps_the_energy_of_a_furnace() {
    let Some(gpu) = test_gpu() else { return };
    let s = DVec3::new(0.5, 0.5, 0.0) * f64::from(ALPHA).powi(2);
    for (albedo, weight, fresnel) in [
        (1.0, 1.0, FresnelForm::Schlick),
        (1.0, 1.0, FresnelForm::Exact),
        (0.5, 1.0, FresnelForm::Schlick),
        (0.5, 0.4, FresnelForm::Exact),
    ] {
        let (exact, options) = (fresnel == FresnelForm::Exact, ShadingOptions { fresnel, ..options() });
        let mut renderer = in_room(&gpu, vec![ground(albedo, 0.0, coat(weight, CoatRelief::Base))], [1.0; 3]);
        let albedo = DVec3::splat(linear_from_srgb(f32::from(srgb8_from_linear(albedo)) / 255.0).into());
        for cosine in COSINES {
            let wo = DVec3::new(0.0, -(1.0 - f64::from(cosine).powi(2)).sqrt(), cosine.into());
            let (weight, found) = (f64::from(weight), seen(&mut renderer, settings(options), cosine, None));
            let outward = coat_reflectance(wo, DVec2::ZERO, s, weight, exact);
            let mean = coat_average(weight, exact);
            let expected = outward + albedo.x * coated_base(outward, mean, mean, albedo).x;
            assert!((found - expected).abs() < 0.01, "albedo {albedo}, cos {cosine}: {found} for {expected}");
            if albedo.x == 1.0 {
                assert!((found - 1.0).abs() < 0.01, "cos {cosine}: {found}");
            }
        }
    }
    // A perfect mirror below the coat.
    let mut renderer = in_room(&gpu, vec![ground(0.0, 1.0, coat(1.0, CoatRelief::Base))], [1.0; 3]);
    for cosine in COSINES {
        let found = seen(&mut renderer, settings(options()), cosine, None);
        assert!((found - 1.0).abs() < 0.03, "cos {cosine}: {found}");
    }
}

/// A coat adds a highlight where the sun is reflected, and darkens the base elsewhere. Over relief, a smooth coat keeps a sharp highlight.
#[test]
fn coats_reflect_the_sun() {
    let Some(gpu) = test_gpu() else { return };
    let (mirrored, aside) = (Vec3::new(0.0, 0.6, 0.8), Vec3::new(-0.6, 0.0, 0.8));
    let options = ShadingOptions { terms: Terms::SPECULAR_LIGHTS | Terms::DIFFUSE_LIGHTS, ..options() };
    let lit = |coat, sun| seen(&mut in_room(&gpu, vec![bumpy(coat)], [0.0; 3]), settings(options), 0.8, Some(sun));
    let [bare, base, smooth] = [None, coat(1.0, CoatRelief::Base), coat(1.0, CoatRelief::Smooth)]
        .map(|coat| [mirrored, aside].map(|sun| lit(coat, sun)));
    assert!(base[0] > 1.02 * bare[0] && smooth[0] > 1.1 * base[0], "{bare:?} {base:?} {smooth:?}");
    assert!(smooth[1] < 0.98 * bare[1] && smooth[1] > 0.9 * bare[1], "{bare:?} {smooth:?}");
    // The lobe of a flat, smooth coat is the microfacet formula.
    let terms = ShadingOptions { terms: Terms::SPECULAR_LIGHTS, ..options };
    let mut flat = in_room(&gpu, vec![ground(0.0, 0.0, coat(1.0, CoatRelief::Smooth))], [0.0; 3]);
    let found = seen(&mut flat, settings(terms), 0.8, Some(mirrored));
    let (wo, wi) = (DVec3::new(0.0, -0.6, 0.8), DVec3::new(0.0, 0.6, 0.8));
    let s = DVec3::new(0.5, 0.5, 0.0) * f64::from(ALPHA).powi(2);
    let expected = leadr::reflectance::integrals::specular::leadr_specular_directional(
        wo,
        wi,
        DVec2::ZERO,
        s,
        DVec3::splat(0.04),
        false,
    )
    .x;
    assert!((found / expected - 1.0).abs() < 0.03, "{found} for {expected}");
}

/// The G-buffer holds a coat in few bits, so edge samples give the same picture as shading at once.
#[test]
fn every_path_draws_the_coat() {
    let Some(gpu) = test_gpu() else { return };
    for relief in [CoatRelief::Base, CoatRelief::Smooth] {
        let mut renderer = in_room(&gpu, vec![bumpy(coat(0.7, relief))], [1.0; 3]);
        let sun = Some(Vec3::new(0.0, 0.6, 0.8));
        let at_once = seen(&mut renderer, settings(options()), 0.8, sun);
        let edges = seen(&mut renderer, settings(ShadingOptions { edge_samples: 16, ..options() }), 0.8, sun);
        assert!((edges / at_once - 1.0).abs() < 0.02, "{relief:?}: {edges} for {at_once}");
        let bare = seen(&mut in_room(&gpu, vec![bumpy(None)], [1.0; 3]), settings(options()), 0.8, sun);
        assert!((at_once / bare - 1.0).abs() > 0.05, "{relief:?}: the coat changes nothing");
        // The reference draws the facets themselves.
        let reference =
            RenderSettings { samples: 64, shading: Technique::Reference.with(options()), ..Default::default() };
        let reference = seen(&mut renderer, reference, 0.8, sun);
        assert!((at_once / reference - 1.0).abs() < 0.1, "{relief:?}: {at_once} for {reference}");
    }
}

/// A map gives the weight, the roughness and the slopes. A constant map equals the factors of the object.
#[test]
fn maps_replace_the_factors() {
    let Some(gpu) = test_gpu() else { return };
    let mapped = |texel: CoatTexel| {
        let mut object = ground(0.5, 0.04, coat(1.0, CoatRelief::Smooth));
        let plate = PropertyMap { width: 1, height: 1, texels: vec![texel], wrap: [TextureWrap::Repeat; 2] };
        object.material.as_mut().unwrap().coat = Some(plate);
        object
    };
    let sun = Some(Vec3::new(0.0, 0.6, 0.8));
    let lit = |object| seen(&mut in_room(&gpu, vec![object], [0.2; 3]), settings(options()), 0.8, sun);
    let same = lit(mapped(CoatTexel { weight: 0.6, alpha: ALPHA, slope: [0.0; 2] }));
    let factor = lit(ground(0.5, 0.04, coat(0.6, CoatRelief::Smooth)));
    assert!((same / factor - 1.0).abs() < 2e-3, "{same} for {factor}");
    // A slope moves the highlight away.
    let tilted = lit(mapped(CoatTexel { weight: 0.6, alpha: ALPHA, slope: [0.0, 0.5] }));
    assert!(tilted < 0.8 * same, "{tilted} for {same}");
}
