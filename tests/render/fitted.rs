//! Measured materials in the renderer: a table of Beckmann slopes must match Beckmann's own lobe, in every technique that supports it.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::{DMat2, DVec2, DVec3, Vec3};
use leadr::maps::material::{Anisotropy, Input, Material, Relief, RoughnessMeaning, alpha_code, alpha_of};
use leadr::maps::{HeightMap, RgbImage};
use leadr::reflectance::facets::fresnel::Fresnel;
use leadr::reflectance::facets::gaussian_mixture::{GaussianMixture, Lobe};
use leadr::reflectance::facets::ggx::Ggx;
use leadr::reflectance::facets::polar_table::PolarTable;
use leadr::reflectance::facets::radial_table::{RadialTable, angle_at};
use leadr::reflectance::facets::slope_distribution::SlopeDistribution;
use leadr::reflectance::facets::tabulated::Tabulated;
use leadr::reflectance::masking::shadowing::Shadowing;
use leadr::reflectance::masking::variants::Masking;
use leadr::reflectance::materials::fitted::FittedBrdf;
use leadr::reflectance::materials::fitted_table::FittedTable;
use leadr::reflectance::materials::microfacet::Microfacet;
use leadr::render::camera::Camera;
use leadr::render::frame::Renderer;
use leadr::render::light::sky::Sky;
use leadr::render::scene::{FrameState, MaterialMap, Object, Pose};
use leadr::render::settings::{Probes, Quadrature, RenderSettings, ShadingOptions, Technique};
use leadr::render::surfaces::displacement::HeightField;
use leadr::scenes::dressed;
use leadr::scenes::sphere::displaced_sphere;
use leadr_testing::gpu::{TestGpu, test_gpu};
use leadr_testing::render::{bumps, under_sky};
use leadr_tools::metrics::Mask;
use leadr_tools::metrics::compare::{bias_over, rrmse_over};

const SIZE: u32 = 32;
const F0: f64 = 0.3;
/// Ratio of the measured reflectances to Schlick's form of [`F0`].
const COPPER: DVec3 = DVec3::new(1.0, 0.6, 0.3);

fn lobe(share: f64, alpha: f64) -> Lobe {
    let variance = 0.5 * alpha * alpha;
    Lobe { share, covariance: DVec3::new(variance, variance, 0.0) }
}

/// The density of normals along an azimuth, in table form.
fn row(slopes: &dyn SlopeDistribution, azimuth: f64) -> Vec<f64> {
    let at = |i: usize| {
        let (sine, cosine) = angle_at(i as f64 / 90.0).sin_cos();
        slopes.ndf((sine * DVec2::from_angle(azimuth)).extend(cosine))
    };
    (0..90).map(at).collect()
}

/// A table of facets with these round lobes.
fn table(lobes: &[Lobe], fresnel: Fresnel, alpha: f32) -> FittedTable {
    let slopes = GaussianMixture::new(DVec2::ZERO, lobes);
    fitted(Tabulated::Radial(RadialTable::new(&row(&slopes, 0.0)).unwrap()), lobes, fresnel, alpha)
}

/// A table of one lobe with deviation `wide` along a direction and `narrow` across it.
fn brushed_table([wide, narrow]: [f64; 2], direction: f64) -> FittedTable {
    let turn = DMat2::from_angle(direction);
    let half = turn * DMat2::from_diagonal(0.5 * DVec2::new(wide * wide, narrow * narrow)) * turn.transpose();
    let lobe = Lobe { share: 1.0, covariance: DVec3::new(half.x_axis.x, half.y_axis.y, half.x_axis.y) };
    let slopes = GaussianMixture::new(DVec2::ZERO, &[lobe]);
    let rows: Vec<_> = (0..72).map(|k| row(&slopes, TAU * f64::from(k) / 72.0)).collect();
    fitted(Tabulated::Polar(PolarTable::new(&rows).unwrap()), &[lobe], schlick(), kept(narrow as f32))
}

fn fitted(distribution: Tabulated, lobes: &[Lobe], fresnel: Fresnel, alpha: f32) -> FittedTable {
    let facets = Microfacet { distribution, masking: Masking::SmithDirectionCorrelated, fresnel };
    FittedTable::new(&FittedBrdf { facets, diffuse: DVec3::ZERO }, lobes, alpha)
}

/// The roughness after 8-bit quantisation in a map.
fn kept(alpha: f32) -> f32 {
    alpha_of(alpha_code(alpha))
}

/// A black sphere, smooth or with a relief, with a specular term of roughness `alpha` or of a fit.
fn sphere(relief: f32, alpha: f32, fit: Option<FittedTable>) -> Object {
    sphere_of(&bumps(256, 5.0, 3), relief, alpha, fit)
}

fn sphere_of(bumps: &HeightField, relief: f32, alpha: f32, fit: Option<FittedTable>) -> Object {
    let (mesh, heights) = displaced_sphere(bumps, 1.0, 8, 16, [1.0; 4]);
    let map = MaterialMap {
        fit: fit.map(Arc::new),
        ..MaterialMap::new(
            heights.map.width,
            heights.map.height,
            vec![[0, 0, 0, alpha_code(alpha)]; (heights.map.width * heights.map.height) as usize],
        )
    };
    Object::new("sphere", mesh)
        .with_heights(heights, relief)
        .with_material(map)
        .with_specular_f0(F0 as f32)
        .without_shadow()
}

fn settings(technique: Technique, samples: u32, relief_shadows: bool) -> RenderSettings {
    RenderSettings {
        size: (SIZE, SIZE),
        samples,
        // As in the reference without shadows, where bumps do not shadow each other.
        shading: technique.with(ShadingOptions {
            relief_shadows,
            shadowing: Shadowing::None,
            relief_occlusion: false,
            ..Default::default()
        }),
        shadows: false,
        ..Default::default()
    }
}

fn state() -> FrameState {
    let camera = Camera::looking_at(Vec3::new(0.6, -0.7, 0.3).normalize() * 8.0, Vec3::ZERO, 16.0);
    FrameState::new(camera, vec![Pose::REST]).under(&Sky::default())
}

fn image(color: &[[f32; 4]]) -> RgbImage {
    RgbImage::new(SIZE, SIZE, color.iter().map(|c| [c[0], c[1], c[2]]).collect()).unwrap()
}

fn picture(gpu: &TestGpu, object: Object, settings: &RenderSettings) -> RgbImage {
    let mut renderer = under_sky(gpu, vec![object], 64);
    image(&renderer.render(&state(), settings).unwrap().color)
}

/// Far from the silhouette of the sphere.
fn inside() -> Mask {
    let coverage: Vec<f32> = (0..SIZE * SIZE)
        .map(|i| {
            let [x, y] = [i % SIZE, i / SIZE].map(|k| k as f32 + 0.5 - 0.5 * SIZE as f32);
            if x.hypot(y) < 0.3 * SIZE as f32 { 1.0 } else { 0.0 }
        })
        .collect();
    Mask::covered(SIZE, SIZE, &coverage, 0.5).unwrap()
}

/// Interior rRMSE and bias of a fit's picture against that of the equivalent lobe.
fn errors(expected: &RgbImage, found: &RgbImage) -> (f64, f64) {
    (rrmse_over(expected, found, &inside()).unwrap(), bias_over(expected, found, &inside()).unwrap())
}

fn schlick() -> Fresnel {
    Fresnel::Schlick(DVec3::splat(F0))
}

#[test]
fn one_lobe_is_beckmanns() {
    let Some(gpu) = test_gpu() else { return };
    for (relief, alpha) in [(0.0, 0.2), (0.1, 0.2), (0.1, 0.5)] {
        let one = [lobe(1.0, f64::from(kept(alpha)))];
        let fit = table(&one, schlick(), kept(alpha));
        let leadr = settings(Technique::Leadr, 1, false);
        let (rrmse, bias) = errors(
            &picture(&gpu, sphere(relief, alpha, None), &leadr),
            &picture(&gpu, sphere(relief, alpha, Some(fit)), &leadr),
        );
        println!("LEADR, relief {relief}, α {alpha}: rRMSE {rrmse:.4}, bias {bias:.4}");
        assert!(rrmse < 0.01, "{relief} {alpha}: {rrmse} {bias}");
    }
}

/// A fit of GGX facets is drawn with its GGX roughness and its own Fresnel term.
#[test]
fn a_ggx_base_has_the_facets_and_the_reflectance_of_the_fit() {
    let Some(gpu) = test_gpu() else { return };
    let alpha = 0.3;
    let slopes = Ggx::isotropic(DVec2::ZERO, f64::from(kept(alpha)));
    let fit = |fresnel| {
        let distribution = Tabulated::Radial(RadialTable::new(&row(&slopes, 0.0)).unwrap());
        fitted(distribution, &[lobe(1.0, 0.5)], fresnel, kept(alpha))
    };
    for relief in [0.0, 0.1] {
        let ggx = settings(Technique::LeadrGgx, 1, false);
        let expected = picture(&gpu, sphere(relief, alpha, None), &ggx);
        let found = picture(&gpu, sphere(relief, alpha, Some(fit(schlick()))), &ggx);
        let (rrmse, bias) = errors(&expected, &found);
        println!("relief {relief}: rRMSE {rrmse:.4}, bias {bias:.4}");
        assert!(rrmse < 0.01, "{relief}: {rrmse} {bias}");
        // The object keeps its reflectance, so only the fit can change the colour.
        let copper = picture(&gpu, sphere(relief, alpha, Some(fit(Fresnel::Schlick(F0 * COPPER)))), &ggx);
        let channel = |k: usize| {
            let sum = |image: &RgbImage| image.texels.iter().map(|t| f64::from(t[k])).sum::<f64>();
            sum(&copper) / sum(&found)
        };
        let [red, blue] = [channel(0), channel(2)];
        assert!((red - 1.0).abs() < 0.01 && (0.3..0.6).contains(&blue), "{relief}: {red} {blue}");
    }
}

/// Where a surface is rougher than its fit, the measured slopes are scaled up.
#[test]
fn roughness_scales_a_fit() {
    let Some(gpu) = test_gpu() else { return };
    let (measured, alpha) = (kept(0.2), 0.4);
    let fit = || table(&[lobe(1.0, f64::from(measured))], schlick(), measured);
    for (technique, samples, most) in [(Technique::Leadr, 1, 0.015), (Technique::Reference, 32, 0.08)] {
        let settings = settings(technique, samples, false);
        let expected = picture(&gpu, sphere(0.1, alpha, None), &settings);
        let (rrmse, bias) = errors(&expected, &picture(&gpu, sphere(0.1, alpha, Some(fit())), &settings));
        println!("{technique:?}: rRMSE {rrmse:.4}, bias {bias:.4}");
        assert!(rrmse < most && bias.abs() < 0.01, "{technique:?}: {rrmse} {bias}");
        // The measured material itself must differ.
        let (other, _) = errors(&expected, &picture(&gpu, sphere(0.1, 0.2, Some(fit())), &settings));
        assert!(other > 2.0 * rrmse, "{other} {rrmse}");
    }
}

/// The references evaluate the table, with and without shadows of the relief.
#[test]
#[ignore = "long"]
fn references_see_the_table() {
    let Some(gpu) = test_gpu() else { return };
    let alpha = 0.3;
    let fit = || table(&[lobe(1.0, f64::from(kept(alpha)))], schlick(), kept(alpha));
    for (relief_shadows, samples, most) in [(false, 32, 0.08), (true, 16, 0.1)] {
        let settings = settings(Technique::Reference, samples, relief_shadows);
        let expected = picture(&gpu, sphere(0.1, alpha, None), &settings);
        let (rrmse, bias) = errors(&expected, &picture(&gpu, sphere(0.1, alpha, Some(fit())), &settings));
        println!("shadows {relief_shadows}: rRMSE {rrmse:.4}, bias {bias:.4}");
        assert!(rrmse < most && bias.abs() < 0.015, "{relief_shadows}: {rrmse} {bias}");
        // A table with facets a tenth rougher must fail.
        let rougher = table(&[lobe(1.0, 1.25 * f64::from(kept(alpha)))], schlick(), kept(alpha));
        let (other, _) = errors(&expected, &picture(&gpu, sphere(0.1, alpha, Some(rougher)), &settings));
        assert!(other > rrmse, "{other} {rrmse}");
    }
}

/// Bumps as narrow as texels: the slope variance between texels widens a table's facets like a lobe.
#[test]
#[ignore = "long"]
fn references_include_variance_between_texels() {
    let Some(gpu) = test_gpu() else { return };
    let alpha = 0.12;
    let rugged = bumps(256, 2.0, 3);
    let picture = |relief: f32, fit: bool, relief_shadows: bool, samples: u32| {
        let fit = fit.then(|| table(&[lobe(1.0, f64::from(kept(alpha)))], schlick(), kept(alpha)));
        let settings = settings(Technique::Reference, samples, relief_shadows);
        picture(&gpu, sphere_of(&rugged, relief, alpha, fit), &settings)
    };
    for (relief_shadows, samples) in [(false, 256), (true, 64)] {
        let expected = picture(0.1, false, relief_shadows, samples);
        let (rrmse, bias) = errors(&expected, &picture(0.1, true, relief_shadows, samples));
        let (lower, _) = errors(&expected, &picture(0.08, false, relief_shadows, samples));
        println!("shadows {relief_shadows}: rRMSE {rrmse:.4}, bias {bias:.4}; of a lower relief {lower:.4}");
        // Each sample draws one facet, so noise dominates: it halves with four times the samples.
        assert!(rrmse < 0.7 * lower && bias.abs() < 0.02, "{relief_shadows}: {rrmse} {bias} {lower}");
    }
}

/// Anisotropy along a direction is the same in both references, for every direction of the table: a flat relief casts no shadows.
#[test]
fn shadows_of_the_relief_leave_the_direction_of_a_table() {
    let Some(gpu) = test_gpu() else { return };
    let alphas = [0.5, 0.12];
    let plane = |direction: f64| {
        let mut material = Material::new("brushed");
        let map = HeightMap { width: 16, height: 16, texels: vec![0.0; 256] };
        material.relief = Some(Relief { map, scale: Some(0.01), in_widths: false, middle: 0.0 });
        material.base_color = Input::constant([0.0; 3]);
        material.roughness = Input::constant(kept(alphas[1] as f32));
        material.roughness_meaning = RoughnessMeaning::Alpha;
        material.fit = Some(Arc::new(brushed_table(alphas, 0.4)));
        material.anisotropy =
            Some(Anisotropy { strength: Input::constant(0.65), rotation: direction as f32, direction: None });
        dressed::plane_stage(&material, None).objects.remove(0)
    };
    let picture = |direction: f64, relief_shadows: bool| {
        let settings = settings(Technique::Reference, 32, relief_shadows);
        let camera = Camera::looking_at(Vec3::new(0.5, -0.8, 0.5) * 4.0, Vec3::ZERO, 16.0);
        let mut renderer = under_sky(&gpu, vec![plane(direction)], 64);
        let state = FrameState::new(camera, vec![Pose::REST]).under(&Sky::default());
        image(&renderer.render(&state, &settings).unwrap().color)
    };
    let expected = picture(1.5, false);
    let (rrmse, bias) = errors(&expected, &picture(1.5, true));
    let (as_in_table, _) = errors(&expected, &picture(0.4, false));
    println!("rRMSE {rrmse:.4}, bias {bias:.4}; along the table's own direction {as_in_table:.4}");
    assert!(rrmse < 0.1 && bias.abs() < 0.02 && as_in_table > 3.0 * rrmse, "{rrmse} {bias} {as_in_table}");
}

/// Two lobes, on a smooth sphere and on a relief: LEADR with both against the reference with the table.
#[test]
#[ignore = "long"]
fn lobes_are_near_the_table() {
    let Some(gpu) = test_gpu() else { return };
    let lobes = [lobe(0.6, 0.12), lobe(0.4, 0.6)];
    let alpha = kept(0.4);
    let fit = |lobes: &[Lobe]| table(lobes, Fresnel::Schlick(F0 * COPPER), alpha);
    let reference = settings(Technique::Reference, 48, false);
    // LEADR's error of the relief under one Beckmann lobe, as narrow as the narrower one.
    let own = |relief| {
        let truth = picture(&gpu, sphere(relief, 0.12, None), &reference);
        errors(&truth, &picture(&gpu, sphere(relief, 0.12, None), &settings(Technique::Leadr, 8, false))).0
    };
    for relief in [0.0, 0.1] {
        let truth = picture(&gpu, sphere(relief, 0.4, Some(fit(&lobes))), &reference);
        let leadr = |lobes: &[Lobe]| {
            picture(&gpu, sphere(relief, 0.4, Some(fit(lobes))), &settings(Technique::Leadr, 8, false))
        };
        let (two, _) = errors(&truth, &leadr(&lobes));
        let mean = (0.6 * 0.12f64.powi(2) + 0.4 * 0.6f64.powi(2)).sqrt();
        let (one, _) = errors(&truth, &leadr(&[lobe(1.0, mean)]));
        let own = if relief > 0.0 { own(relief) } else { 0.0 };
        println!("relief {relief}: two lobes {two:.4}, one of the mean variance {one:.4}; a Beckmann base {own:.4}");
        assert!(two < 1.5 * own.max(0.03) && two < 0.5 * one, "{relief}: {two} {one} {own}");
        let redder = truth.texels.iter().filter(|t| t[0] > 1.5 * t[2]).count();
        assert!(redder > 100, "the table of reflectances has a colour: {redder}");
    }
}

/// When one pass shades all kinds of surfaces, they share the lobe loop of measured materials, where each lobe has its own probes.
#[test]
#[ignore = "long"]
fn surfaces_next_to_a_fit_are_unchanged() {
    let Some(gpu) = test_gpu() else { return };
    let away = Pose::Rigid(glam::Affine3A::from_translation(Vec3::new(-40.0, 0.0, 0.0)));
    let state = FrameState { poses: vec![Pose::REST, away], ..state() };
    let mut renderers = [0, 2, 3, 4].map(|count| {
        let lobes: Vec<Lobe> = (1..=count).map(|i| lobe(1.0 / f64::from(count), 0.15 * f64::from(i))).collect();
        let fit = (count > 0).then(|| table(&lobes, schlick(), kept(0.3)));
        under_sky(&gpu, vec![sphere(0.1, 0.3, None), sphere(0.1, 0.3, fit)], 64)
    });
    for (probes, shadowing) in [(Probes::Nine, Shadowing::None), (Probes::Sixteen, Shadowing::Correlated)] {
        let shading = ShadingOptions { quadrature: Quadrature::VisibleSlopes(probes), shadowing, ..Default::default() };
        let settings =
            RenderSettings { shading: Technique::Leadr.with(shading), ..settings(Technique::Leadr, 1, false) };
        let [alone, beside @ ..] = renderers
            .each_mut()
            .map(|renderer| image(&renderer.render_in_two_passes(&state, &settings).unwrap().color));
        for (lobes, picture) in (2..).zip(&beside) {
            let (rrmse, _) = errors(&alone, picture);
            println!("{} probes beside {lobes} lobes: rRMSE {rrmse:.1e}", probes.count());
            assert!(rrmse < 1e-4, "{probes:?} beside {lobes} lobes: {rrmse}");
        }
    }
}

/// Frames filtered and shaded in one pass, and frames with a G-buffer; two fits in one scene.
#[test]
fn g_buffer_stores_the_fit_index() {
    let Some(gpu) = test_gpu() else { return };
    let fits = [lobe(1.0, 0.1), lobe(1.0, 0.5)].map(|lobe| table(&[lobe], Fresnel::Schlick(F0 * COPPER), kept(0.3)));
    let [a, b] = fits.map(|fit| sphere(0.1, 0.3, Some(fit)));
    let mut renderer: Renderer = under_sky(&gpu, vec![a, b], 64);
    let beside = |x: f32| Pose::Rigid(glam::Affine3A::from_translation(Vec3::new(x, 0.0, 0.0)));
    let state = FrameState { poses: vec![beside(-1.1), beside(1.1)], ..state() };
    let settings = settings(Technique::Leadr, 1, false);
    let at_once = renderer.render_in_two_passes(&state, &settings).unwrap().color;
    let through = renderer.render_in_two_passes(&state, &settings).unwrap().color;
    let all = Mask::covered(SIZE, SIZE, &vec![1.0; (SIZE * SIZE) as usize], 0.5).unwrap();
    let error = rrmse_over(&image(&at_once), &image(&through), &all).unwrap();
    println!("rRMSE through the G-buffer {error:.5}");
    assert!(error < 0.05, "{error}");
    // Each half of the picture shows one sphere, and they differ.
    let half = |left: bool| {
        let of = (0..SIZE * SIZE).filter(|i| (i % SIZE < SIZE / 2) == left).map(|i| through[i as usize]);
        of.map(|c| c[0]).fold(0.0f32, f32::max)
    };
    assert!(half(true) > 1.3 * half(false) || half(false) > 1.3 * half(true), "{} {}", half(true), half(false));
}
