//! The shading pass as a whole: energy, and every pixel against the reflectance library.

use glam::{DVec2, DVec3, Vec3};
use leadr::reflectance::facets::base_roughness::add_facet_roughness;
use leadr::reflectance::facets::beckmann::beckmann_ndf;
use leadr::reflectance::facets::fresnel::{fresnel_dielectric, fresnel_edge_tint, fresnel_schlick};
use leadr::reflectance::facets::metals::Metal;
use leadr::reflectance::facets::projected_area;
use leadr::reflectance::frame;
use leadr::reflectance::integrals::facet_specular::{facet_specular, facet_specular_light};
use leadr::reflectance::integrals::phong::{phong_area, phong_masking, phong_ndf};
use leadr::reflectance::integrals::slope_nodes::{
    NodePlacement, node_diffuse_light, node_normal_moments, node_specular_environment,
};
use leadr::reflectance::integrals::specular::{EnvironmentSample, leadr_specular_environment};
use leadr::reflectance::integrals::{diffuse, sh_projection};
use leadr::reflectance::masking::correlated::{direction_area, lit_fraction, masking_shadowing_factor};
use leadr::reflectance::masking::grooves::groove_factor;
use leadr::reflectance::masking::shadowing::Shadowing;
use leadr::reflectance::masking::variants::half_facet_area;
use leadr::reflectance::materials::microfacet::half_vector;
use leadr::reflectance::slopes::geometric_antialiasing::{filter_covariance, half_vector_kernel};
use leadr::reflectance::slopes::grid as slope_grid;
use leadr::reflectance::visible::diffuse::{leadr_diffuse_light_visible, visible_diffuse_moments};
use leadr::reflectance::visible::shadowed_environment::{bent_normal, shadowed_diffuse_environment};
use leadr::reflectance::visible::shadowed_specular::visible_specular_environment;
use leadr::reflectance::visible::specular as visible_specular;
use leadr::render::camera::Camera;
use leadr::render::frame::{Layer, Renderer};
use leadr::render::light::environment::Environment;
use leadr::render::light::panorama::LightExtraction;
use leadr::render::scene::{Cone, FrameState, Object, PointLight, Pose, Sun};
use leadr::render::settings::{
    DiffuseLights, FresnelForm, GridLod, PixelKernel, Probes, Quadrature, RenderSettings, Shading, ShadingOptions,
    Technique, Terms,
};
use leadr::scenes::plane::{even, plane};
use leadr::scenes::sphere::{cube_sphere, displaced_sphere};
use leadr_testing::cube::panorama;
use leadr_testing::gpu::test_gpu;
use leadr_testing::render::{bumps, in_room};

const SIZE: u32 = 96;

fn bumpy_sphere(color: [f32; 4], specular_f0: f32) -> Object {
    let (mesh, heights) = displaced_sphere(&bumps(128, 4.0, 11), 1.0, 6, 32, color);
    Object::new("bumpy sphere", mesh).with_heights(heights, 0.5).with_specular_f0(specular_f0).without_shadow()
}

fn state(distance: f32, sun: Option<Sun>, point_lights: Vec<PointLight>) -> FrameState {
    let camera = Camera::looking_at(Vec3::new(0.5, -0.8, 0.3).normalize() * distance, Vec3::ZERO, 30.0);
    FrameState { sun, point_lights, ..FrameState::new(camera, vec![Pose::REST]) }
}

fn settings(shading: Shading) -> RenderSettings {
    RenderSettings { size: (SIZE, SIZE), shading, shadows: false, ..Default::default() }
}

/// Without shadowing, a white surface is invisible in a white furnace, because LEADR eq. 16 integrates to one.
#[test]
#[ignore = "long"]
fn a_white_surface_vanishes_in_a_white_room() {
    let Some(gpu) = test_gpu() else { return };
    let (grid, few) = (Quadrature::Grid(5), Quadrature::VisibleSlopes(Probes::Five));
    let cases = [
        (Technique::Leadr, grid),
        (Technique::Leadr, few),
        (Technique::LeadrGgx, grid),
        (Technique::LeadrGgx, few),
        (Technique::LeadrPhong, grid),
        (Technique::LeadrPhong, few),
        (Technique::NormalMip, few),
        // With one mean normal: one lookup for the specular and one for the diffuse term.
        (Technique::Lean, grid),
        (Technique::Toksvig, grid),
    ];
    for (f0, what, fresnel) in [
        (0.0, "diffuse under grazing Fresnel", FresnelForm::Schlick),
        (0.3, "both", FresnelForm::Schlick),
        (0.3, "both", FresnelForm::Exact),
        (1.0, "specular", FresnelForm::Schlick),
        (1.0, "specular", FresnelForm::Exact),
    ] {
        let object = bumpy_sphere([1.0, 1.0, 1.0, 0.3], f0);
        let mut renderer = in_room(&gpu, vec![object], [1.0; 3]);
        for distance in [3.0, 12.0, 60.0] {
            for (technique, quadrature) in cases {
                // Neither facets nor resolved bumps occlude the furnace.
                let options =
                    ShadingOptions { shadowing: Shadowing::None, relief_occlusion: false, ..Default::default() };
                let shading = technique.with(ShadingOptions { quadrature, fresnel, ..options });
                let output = renderer.render(&state(distance, None, Vec::new()), &settings(shading)).unwrap();
                let object = output.color.iter().filter(|c| c[3] > 0.0);
                assert!(object.clone().count() > 10);
                let worst = object.map(|c| (c[0] - 1.0).abs()).fold(0.0, f32::max);
                println!("{shading}, {fresnel:?}, {what} at distance {distance}: off by {worst:.1e} at most");
                assert!(worst < 5e-4, "{shading}");
            }
        }
    }
}

/// Shadowing removes some of that light and never creates any.
#[test]
fn shadowing_only_removes_light() {
    let Some(gpu) = test_gpu() else { return };
    let object = bumpy_sphere([1.0, 1.0, 1.0, 0.3], 1.0);
    let mut renderer = in_room(&gpu, vec![object], [1.0; 3]);
    let output = renderer.render(&state(12.0, None, Vec::new()), &settings(Shading::default())).unwrap();
    let radiances: Vec<f32> = output.color.iter().filter(|c| c[3] > 0.0).map(|c| c[0]).collect();
    let (low, high) = radiances.iter().fold((f32::MAX, f32::MIN), |(l, h), &v| (l.min(v), h.max(v)));
    println!("{low} .. {high}");
    assert!(high <= 1.0001 && low < 0.99 && low > 0.3);
}

/// The tangent-frame quantities of a pixel.
struct Pixel {
    position: DVec3,
    frame: frame::Frame,
    wo: DVec3,
    m: DVec2,
    diffuse_s: DVec3,
    specular_s: DVec3,
    alpha: f64,
    albedo: DVec3,
}

/// Every pixel that shows the object in the last frame of `renderer`, with its index.
fn pixels(
    renderer: &mut Renderer,
    state: &FrameState,
    nodes: NodePlacement,
    color: &[[f32; 4]],
) -> Vec<(usize, Pixel)> {
    let layers = [Layer::Depth, Layer::Normal, Layer::MeanSlope, Layer::Covariance, Layer::Albedo, Layer::Roughness];
    let layers = layers.map(|layer| renderer.layer(layer).unwrap());
    let [ray_x, ray_y, ray_z] = state.camera.rays((SIZE, SIZE), glam::Vec2::ZERO).map(|r| r.as_dvec3());
    let shown = (0..color.len()).filter(|&i| color[i][3] > 0.0);
    shown
        .map(|i| {
            let [depth, normal, slope, covariance, albedo, roughness] = layers.each_ref().map(|l| l[i].map(f64::from));
            let (x, y) = ((i as u32 % SIZE) as f64 + 0.5, (i as u32 / SIZE) as f64 + 0.5);
            let ndc = DVec2::new(x, y) / f64::from(SIZE) * 2.0 - 1.0;
            let ray = ray_z + ray_x * ndc.x + ray_y * ndc.y;
            let frame = frame::frame_about(DVec3::new(normal[0], normal[1], normal[2]));
            let wo = frame::to_frame(&frame, -ray.normalize());
            let m = DVec2::new(slope[0], slope[1]);
            let tilts = nodes != NodePlacement::Micronormal;
            let tilt = if tilts { projected_area::tilt_to_edge(wo, m) } else { DVec2::ZERO };
            let diffuse_s =
                DVec3::new(covariance[0], covariance[1], covariance[2]) + (tilt * tilt).extend(tilt.x * tilt.y);
            let pixel = Pixel {
                position: state.camera.position.as_dvec3() + ray * depth[0],
                wo,
                frame,
                m: m + tilt,
                diffuse_s,
                specular_s: add_facet_roughness(diffuse_s, roughness[0], wo, m + tilt),
                alpha: roughness[0],
                albedo: DVec3::new(albedo[0], albedo[1], albedo[2]),
            };
            (i, pixel)
        })
        .collect()
}

impl Pixel {
    /// Reflected radiance in a white furnace, and mean Fresnel reflectance.
    fn specular_terms(&self, integral: ShadingOptions, f0: DVec3) -> [DVec3; 2] {
        let (wo, s, shadowing) = (self.wo, self.specular_s, integral.shadowing);
        match integral.quadrature {
            Quadrature::Grid(n) => {
                let lambda = slope_grid::grid_lambda(n);
                let white = |_: &EnvironmentSample| DVec3::ONE;
                if integral.grid_nodes != NodePlacement::Grid {
                    let placement = integral.grid_nodes;
                    let term = node_specular_environment(placement, shadowing, wo, self.m, s, f0, n, white);
                    return [term.reflected, term.fresnel];
                }
                let specular_terms = leadr_specular_environment(shadowing, wo, self.m, s, f0, n, lambda, white);
                [specular_terms.reflected, specular_terms.fresnel]
            }
            Quadrature::VisibleSlopes(probes) => {
                let rule = visible_specular::probe_rule(probes.count());
                let specular_terms = visible_specular_environment(shadowing, wo, self.m, s, f0, rule, |_| DVec3::ONE);
                [specular_terms.reflected, specular_terms.fresnel]
            }
        }
    }

    /// Moments of the visible normals.
    fn normals(&self, integral: ShadingOptions) -> diffuse::NormalMoments {
        match integral.quadrature {
            Quadrature::Grid(n) if integral.grid_nodes != NodePlacement::Grid => {
                node_normal_moments(integral.grid_nodes, self.wo, self.m, self.diffuse_s, n)
            }
            Quadrature::Grid(n) => {
                let lambda = slope_grid::grid_lambda(n);
                let m = projected_area::face_viewer(self.wo, self.m, self.diffuse_s, lambda);
                if integral.shadowing == Shadowing::VGroove {
                    return diffuse::groove_normal_moments(self.wo, m, self.diffuse_s, n, lambda);
                }
                diffuse::visible_normal_moments(self.wo, m, self.diffuse_s, n, lambda)
            }
            Quadrature::VisibleSlopes(_) => visible_diffuse_moments(self.wo, self.m, self.diffuse_s, 2),
        }
    }

    /// Diffuse radiance of a light per unit of irradiance and albedo.
    fn diffuse_light(&self, integral: ShadingOptions, wi: DVec3) -> f64 {
        let (wo, s) = (self.wo, self.diffuse_s);
        let cholesky = slope_grid::slope_cholesky(s);
        let areas = [wo, wi].map(|w| direction_area(w, self.m, cholesky));
        let light = match (integral.diffuse_lights, integral.quadrature) {
            (DiffuseLights::Sh, _) => {
                diffuse::leadr_diffuse_light_sh(&self.normals(integral), wo, wi, self.m, s, false)
            }
            (_, Quadrature::Grid(n)) if integral.grid_nodes != NodePlacement::Grid => {
                node_diffuse_light(integral.grid_nodes, wo, wi, self.m, s, false, n)
            }
            (_, Quadrature::Grid(n)) => {
                let lambda = slope_grid::grid_lambda(n);
                let m = projected_area::face_viewer(wo, self.m, s, lambda);
                if integral.shadowing == Shadowing::VGroove {
                    return diffuse::groove_diffuse_light(wo, wi, m, s, n, lambda);
                }
                diffuse::leadr_diffuse_light(wo, wi, m, s, false, n, lambda)
            }
            (_, Quadrature::VisibleSlopes(_)) => leadr_diffuse_light_visible(wo, wi, self.m, s, false, 2),
        };
        light * lit_fraction(integral.shadowing, &areas[0], &areas[1])
    }

    /// Specular radiance of a light per unit of irradiance.
    fn specular_light(&self, integral: ShadingOptions, wi: DVec3, f0: DVec3) -> DVec3 {
        let (wo, m) = (self.wo, self.m);
        if let (Shadowing::VGroove, Quadrature::Grid(n)) = (integral.shadowing, integral.quadrature) {
            let m = projected_area::face_viewer(wo, m, self.specular_s, slope_grid::grid_lambda(n));
            let wh = half_vector(wo, wi);
            let [ao, ai] = [wo, wi].map(|w| projected_area::meso_area(w, m).max(0.0));
            let factor = groove_factor(half_facet_area(wo, wi, wh), ao, ai);
            return fresnel_schlick(f0, wi.dot(wh)) * (0.25 * beckmann_ndf(wh, m, self.specular_s) * factor);
        }
        let cholesky = slope_grid::slope_cholesky(self.diffuse_s);
        let areas = [wo, wi].map(|w| direction_area(w, m, cholesky));
        let lobe = facet_specular(wo, wi, self.alpha, 0.0);
        facet_specular_light(integral.shadowing, &areas[0], &areas[1], &lobe, m, cholesky, f0)
    }
}

/// The integration methods that the tests below cover.
fn integrals() -> Vec<(Shading, ShadingOptions)> {
    let with = |quadrature, shadowing, diffuse_lights| {
        // tests/render/relief.rs tests the occlusion of resolved bumps.
        let options =
            ShadingOptions { quadrature, shadowing, diffuse_lights, relief_occlusion: false, ..Default::default() };
        let shading = Technique::Leadr.with(options);
        (shading, shading.options())
    };
    let placed = |side, shadowing, grid_nodes| {
        let (_, options) = with(Quadrature::Grid(side), shadowing, DiffuseLights::Cosine);
        let shading = Technique::Leadr.with(ShadingOptions { grid_nodes, ..options });
        (shading, shading.options())
    };
    vec![
        placed(5, Shadowing::Correlated, NodePlacement::Pruned),
        placed(5, Shadowing::Smith, NodePlacement::Micronormal),
        placed(3, Shadowing::Smith, NodePlacement::CentredNormals),
        placed(5, Shadowing::None, NodePlacement::CentredNormals),
        with(Quadrature::Grid(5), Shadowing::Smith, DiffuseLights::Cosine),
        with(Quadrature::Grid(3), Shadowing::None, DiffuseLights::Cosine),
        with(Quadrature::Grid(1), Shadowing::Smith, DiffuseLights::Cosine),
        with(Quadrature::Grid(5), Shadowing::Correlated, DiffuseLights::Sh),
        with(Quadrature::VisibleSlopes(Probes::Nine), Shadowing::Correlated, DiffuseLights::Cosine),
        with(Quadrature::VisibleSlopes(Probes::Five), Shadowing::Smith, DiffuseLights::Cosine),
        with(Quadrature::VisibleSlopes(Probes::Five), Shadowing::None, DiffuseLights::Sh),
        with(Quadrature::Grid(5), Shadowing::SmithSeparable, DiffuseLights::Cosine),
        with(Quadrature::VisibleSlopes(Probes::Nine), Shadowing::SmithSeparable, DiffuseLights::Cosine),
        with(Quadrature::Grid(5), Shadowing::VGroove, DiffuseLights::Cosine),
        with(Quadrature::Grid(9), Shadowing::VGroove, DiffuseLights::Cosine),
    ]
}

/// Returns the direction to a light and its irradiance, as in `KHR_lights_punctual`.
fn sent(light: &PointLight, position: DVec3) -> (DVec3, DVec3) {
    let away = light.position.as_dvec3() - position;
    let (distance, direction) = (away.length(), away.normalize());
    let fading = light.range.map_or(1.0, |range| (1.0 - (distance / f64::from(range)).powi(4)).clamp(0.0, 1.0));
    let cone = light.cone.map_or(1.0, |cone| {
        let [inner, outer] = [cone.inner_angle, cone.outer_angle].map(|angle| f64::from(angle).cos());
        let cosine = (-direction).dot(cone.axis.as_dvec3());
        ((cosine - outer) / (inner - outer)).clamp(0.0, 1.0).powi(2)
    });
    (direction, light.intensity.as_dvec3() * (fading * cone / (distance * distance)))
}

/// Directional lights, point lights and spots on every pixel of a G-buffer, against the 64-bit reference.
#[test]
fn lights_agree_with_the_reference_at_every_pixel() {
    let Some(gpu) = test_gpu() else { return };
    let (albedo, alpha, f0) = ([0.5f32, 0.4, 0.3], 0.25, 0.06);
    let object = bumpy_sphere([albedo[0], albedo[1], albedo[2], alpha], f0);
    let mut renderer = in_room(&gpu, vec![object], [0.0; 3]);
    let sun = Sun { direction: Vec3::new(0.6, -0.1, 0.7).normalize(), irradiance: Vec3::new(3.0, 2.5, 2.0) };
    let point = PointLight::new(Vec3::new(-1.5, -2.5, 0.5), Vec3::new(2.0, 4.0, 6.0));
    // The lights after the fourth have no shadow maps, and their own loop.
    let cone = |from: Vec3| Cone { axis: -from.normalize(), inner_angle: 0.1, outer_angle: 0.5 };
    let spot = |from: Vec3, rgb: Vec3| PointLight { cone: Some(cone(from)), ..PointLight::new(from, rgb) };
    let points = [
        point,
        spot(Vec3::new(0.5, -2.0, 1.0), Vec3::new(3.0, 1.0, 1.0)),
        PointLight { range: Some(2.5), ..PointLight::new(Vec3::new(1.5, -1.5, -0.5), Vec3::new(1.0, 3.0, 1.0)) },
        PointLight::new(Vec3::new(0.0, -1.5, -1.5), Vec3::new(0.5, 0.5, 2.0)),
        spot(Vec3::new(2.0, -1.5, 0.5), Vec3::new(0.0, 4.0, 2.0)),
        PointLight { range: Some(3.0), ..PointLight::new(Vec3::new(-0.5, -1.8, 1.8), Vec3::new(3.0, 0.0, 1.0)) },
    ];
    let second_sun = Sun { direction: Vec3::new(-0.3, -0.8, 0.2).normalize(), irradiance: Vec3::new(0.2, 0.4, 0.6) };
    let (mut worst, mut count) = (0.0f64, 0);
    for distance in [4.0, 14.0] {
        for (shading, integral) in integrals() {
            let state = FrameState { more_suns: vec![second_sun], ..state(distance, Some(sun), points.to_vec()) };
            let output = renderer.render_in_two_passes(&state, &settings(shading)).unwrap();
            let mut worst_here = 0.0f64;
            for (i, pixel) in pixels(&mut renderer, &state, integral.grid_nodes, &output.color) {
                let f0 = DVec3::splat(f64::from(f0));
                let albedo = pixel.albedo * (1.0 - pixel.specular_terms(integral, f0)[1]);
                let lights = [sun, second_sun].map(|sun| (sun.direction.as_dvec3(), sun.irradiance.as_dvec3()));
                let lights = lights.into_iter().chain(points.iter().map(|light| sent(light, pixel.position)));
                let mut expected = DVec3::ZERO;
                for (direction, irradiance) in lights {
                    let wi = frame::to_frame(&pixel.frame, direction);
                    let specular = pixel.specular_light(integral, wi, f0);
                    expected += irradiance * (albedo * pixel.diffuse_light(integral, wi) + specular);
                }
                let actual = DVec3::new(
                    f64::from(output.color[i][0]),
                    f64::from(output.color[i][1]),
                    f64::from(output.color[i][2]),
                );
                let error = (actual - expected).length() / (expected.length() + 0.02);
                worst_here = worst_here.max(error);
                count += 1;
            }
            println!("{shading}, {:?}: worst relative error {worst_here:.2e}", integral.diffuse_lights);
            worst = worst.max(worst_here);
        }
    }
    assert!(count > 10_000);
    assert!(worst < 2e-4, "{worst}");
}

/// Kernels of half vectors on a smooth sphere, where the rotation of the normal has a closed form: every pixel against the 64-bit reference.
#[test]
fn kernels_per_light_agree_with_the_reference_at_every_pixel() {
    let Some(gpu) = test_gpu() else { return };
    let (alpha, f0) = (0.1, 0.5);
    let object = Object::new("sphere", cube_sphere(24, [0.0, 0.0, 0.0, alpha])).with_specular_f0(f0).without_shadow();
    let mut renderer = in_room(&gpu, vec![object], [0.0; 3]);
    let sun = Sun { direction: Vec3::new(0.6, -0.4, 0.7).normalize(), irradiance: Vec3::splat(3.0) };
    let lamp = PointLight::new(Vec3::new(-0.7, -1.2, 0.5), Vec3::splat(0.5));
    let state = state(20.0, Some(sun), vec![lamp]);
    let [ray_x, ray_y, ray_z] = state.camera.rays((SIZE, SIZE), glam::Vec2::ZERO).map(|r| r.as_dvec3());
    let terms = Terms::SPECULAR_LIGHTS;
    let mut sums = [0.0f64; 4];
    for (n, pixel_kernel) in [PixelKernel::HalfVector, PixelKernel::Normal].into_iter().enumerate() {
        let options = ShadingOptions { pixel_kernel, terms, shadowing: Shadowing::None, ..Default::default() };
        let output = renderer.render(&state, &settings(Technique::Leadr.with(options))).unwrap();
        for (i, pixel) in
            pixels(&mut renderer, &state, NodePlacement::Grid, &output.color).into_iter().filter(|p| p.1.wo.z > 0.2)
        {
            let frame = pixel.frame;
            let local = |v: DVec3| frame::to_frame(&frame, v);
            let (wo, reach) = (pixel.wo, pixel.position - state.camera.position.as_dvec3());
            let along = reach.dot(ray_z) / ray_z.length_squared();
            let moved = [ray_x, ray_y].map(|ray| local(ray) * (2.0 / f64::from(SIZE) * along));
            let on_surface = moved.map(|d| d - wo * (d.z / wo.z));
            let across = |w: DVec3, d: DVec3| (w * w.dot(d) - d).reject_from(w);
            let alpha = f64::from(alpha);
            let mut want = 0.0;
            let to_lamp = lamp.position.as_dvec3() - pixel.position;
            let lights = [
                (local(sun.direction.as_dvec3()), 0.0, f64::from(sun.irradiance.x)),
                (
                    local(to_lamp.normalize()),
                    1.0 / to_lamp.length(),
                    f64::from(lamp.intensity.x) / to_lamp.length_squared(),
                ),
            ];
            for (wi, nearness, irradiance) in lights {
                let h = wo + wi;
                let wh = h.normalize();
                let changes = [0, 1].map(|k| {
                    let directions = across(wo, moved[k]) / reach.length() + across(wi, on_surface[k]) * nearness;
                    let rotation = on_surface[k].truncate();
                    directions.reject_from(wh) / h.length() + (-rotation * wh.z).extend(rotation.dot(wh.truncate()))
                });
                let s = filter_covariance(DVec3::ZERO, half_vector_kernel(wh, changes[0], changes[1]));
                let lobe = facet_specular(wo, wi, alpha, 0.0);
                let cholesky = slope_grid::slope_cholesky(s);
                let areas = direction_area(wo, DVec2::ZERO, cholesky);
                let f0 = DVec3::splat(f64::from(f0));
                want += irradiance
                    * facet_specular_light(Shadowing::None, &areas, &areas, &lobe, DVec2::ZERO, cholesky, f0).x;
            }
            sums[n] += (f64::from(output.color[i][0]) - want).powi(2);
            sums[2] += want * want;
            sums[3] += 1.0;
        }
    }
    let [half_vector, normal] = [sums[0], sums[1]].map(|e| (2.0 * e / sums[2]).sqrt());
    println!("relative error {half_vector:.4}, of the kernel of the normal {normal:.4}, {} pixels", sums[3]);
    assert!(sums[3] > 400.0 && half_vector < 0.03 && normal > 3.0 * half_vector, "{half_vector} {normal}");
}

/// Reflections of a white furnace, with shadowing: every pixel against the 64-bit reference.
#[test]
fn the_specular_environment_agrees_with_the_reference_at_every_pixel() {
    let Some(gpu) = test_gpu() else { return };
    let f0 = 0.5;
    let object = bumpy_sphere([0.0, 0.0, 0.0, 0.25], f0);
    let mut renderer = in_room(&gpu, vec![object], [1.0; 3]);
    let state = state(6.0, None, Vec::new());
    for (shading, integral) in integrals() {
        let output = renderer.render_in_two_passes(&state, &settings(shading)).unwrap();
        let mut worst = 0.0f64;
        for (i, pixel) in pixels(&mut renderer, &state, integral.grid_nodes, &output.color) {
            let [expected, _] = pixel.specular_terms(integral, DVec3::splat(f64::from(f0)));
            worst = worst.max((f64::from(output.color[i][0]) - expected.x).abs() / (expected.x + 0.02));
        }
        println!("{shading}: worst relative error {worst:.2e}");
        // 32 bits against 64: one pixel of the five probes with Smith's shadowing differs by up to 8e-4, depending on its filtering.
        assert!(worst > 0.0 && worst < 1.2e-3, "{shading}: {worst}");
    }
}

/// A lamp off all axes, with a deviation of 6°, reflected in a smooth specular sphere: every pixel against the integral of the lamp over
/// its lobe. Unlike a uniform furnace, this fails if the cube is rotated or its levels are off by one.
#[test]
fn lamp_reflection_has_right_position_and_width() {
    let Some(gpu) = test_gpu() else { return };
    let towards = DVec3::new(0.75, -0.5, 0.43).normalize();
    let lamp = |d: DVec3| 0.1 + 30.0 * (90.0 * (d.dot(towards) - 1.0)).exp();
    let image = panorama(512, |d| DVec3::splat(lamp(d)));
    let none = LightExtraction { count: 0, ..Default::default() };
    let f0 = 0.04;
    for (alpha, bound) in [(0.1, 0.02), (0.3, 0.06), (0.6, 0.07)] {
        let environment = Environment::from_panorama(&gpu, 128, &image, none).unwrap();
        let object =
            Object::new("sphere", cube_sphere(16, [0.0, 0.0, 0.0, alpha])).with_specular_f0(f0).without_shadow();
        let mut renderer = Renderer::new(&gpu, vec![object], environment).unwrap();
        let state = state(6.0, None, Vec::new());
        let output = renderer.render_in_two_passes(&state, &settings(Shading::default())).unwrap();
        let (mut error, mut rotated, mut whole, mut count) = (0.0, 0.0, 0.0, 0);
        for (i, pixel) in pixels(&mut renderer, &state, NodePlacement::Grid, &output.color)
            .into_iter()
            .filter(|p| p.1.wo.z > 0.3)
            .step_by(5)
        {
            let lambda = slope_grid::grid_lambda(48);
            let seen = |light: &dyn Fn(DVec3) -> f64| {
                let radiance = |e: &EnvironmentSample| DVec3::splat(light(frame::from_frame(&pixel.frame, e.wi)));
                let (shadowing, f0) = (Shadowing::Correlated, DVec3::splat(f64::from(f0)));
                let s = pixel.specular_s;
                leadr_specular_environment(shadowing, pixel.wo, pixel.m, s, f0, 48, lambda, radiance).reflected.x
            };
            let (want, got) = (seen(&lamp), f64::from(output.color[i][0]));
            error += (got - want).powi(2);
            rotated += (got - seen(&|d| lamp(DVec3::new(-d.y, d.x, d.z)))).powi(2);
            whole += want * want;
            count += 1;
        }
        let [error, rotated] = [error, rotated].map(|e: f64| (e / whole).sqrt());
        println!("α {alpha}: {count} pixels, relative error {error:.4}, of a turned lamp {rotated:.4}");
        assert!(count > 300 && error < bound && rotated > 0.3, "α {alpha}: {error}, {rotated}");
    }
}

/// A fine pattern, reflected in a smooth sphere: nodes of a grid that see coarser levels blur it.
#[test]
fn constants_of_the_grids_level_of_detail_blur_in_their_order() {
    let Some(gpu) = test_gpu() else { return };
    let image = panorama(512, |d| DVec3::splat(if (40.0 * d.x).sin() * (40.0 * d.z).sin() > 0.0 { 1.0 } else { 0.0 }));
    let none = LightExtraction { count: 0, ..Default::default() };
    let environment = Environment::from_panorama(&gpu, 256, &image, none).unwrap();
    let object = Object::new("sphere", cube_sphere(16, [0.0, 0.0, 0.0, 0.1])).with_specular_f0(1.0).without_shadow();
    let mut renderer = Renderer::new(&gpu, vec![object], environment).unwrap();
    let state = state(6.0, None, Vec::new());
    let deviations =
        [GridLod::Algorithm1, GridLod::Derivation, GridLod::Matched, GridLod::Banding32, GridLod::Banding5].map(
            |grid_lod| {
                let options = ShadingOptions { quadrature: Quadrature::PAPER, grid_lod, ..Default::default() };
                let color = renderer.render(&state, &settings(Technique::Leadr.with(options))).unwrap().color;
                let shown: Vec<f64> = color.iter().filter(|c| c[3] > 0.0).map(|c| f64::from(c[0])).collect();
                let mean = shown.iter().sum::<f64>() / shown.len() as f64;
                (shown.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / shown.len() as f64).sqrt()
            },
        );
    println!("{deviations:.4?}");
    assert!(deviations.windows(2).all(|pair| pair[1] < pair[0]), "{deviations:?}");
    assert!(deviations[4] < 0.8 * deviations[0], "{deviations:?}");
}

/// Every placement of the grid's samples gives a picture of its own. All are near a dense grid, and the thesis's points are the farthest.
#[test]
fn placements_of_grid_samples_differ() {
    let Some(gpu) = test_gpu() else { return };
    let image = panorama(64, |d| DVec3::splat(1.0 + d.dot(DVec3::new(0.3, 0.6, 0.5))));
    let none = LightExtraction { count: 0, ..Default::default() };
    let environment = Environment::from_panorama(&gpu, 64, &image, none).unwrap();
    let object = Object::new("sphere", cube_sphere(16, [0.5, 0.5, 0.5, 0.6])).with_specular_f0(0.5).without_shadow();
    let mut renderer = Renderer::new(&gpu, vec![object], environment).unwrap();
    let state = state(6.0, None, Vec::new());
    let mut drawn = |side, grid_nodes| {
        let quadrature = Quadrature::Grid(side);
        let options = ShadingOptions { quadrature, grid_nodes, shadowing: Shadowing::None, ..Default::default() };
        let color = renderer.render(&state, &settings(Technique::Leadr.with(options))).unwrap().color;
        color.iter().filter(|c| c[3] > 0.0).map(|c| f64::from(c[0])).collect::<Vec<f64>>()
    };
    let truth = drawn(32, NodePlacement::Grid);
    let errors = NodePlacement::ALL.map(|placement| {
        let squares: f64 = drawn(5, placement).iter().zip(&truth).map(|(a, b)| (a / b - 1.0).powi(2)).sum();
        (squares / truth.len() as f64).sqrt()
    });
    println!("{errors:.4?}");
    let [even, pruned, _, thesis, centred] = errors;
    assert!(errors.iter().all(|&error| error < 0.2), "{errors:?}");
    assert!(thesis > 1.5 * centred && (even - pruned).abs() > 1e-5 && (even - centred).abs() > 1e-5, "{errors:?}");
}

/// Without reflectance at normal incidence nothing is reflected, even at grazing angles.
#[test]
fn diffuse_surface_has_no_specular_term() {
    let Some(gpu) = test_gpu() else { return };
    for f0 in [0.0, 0.04] {
        let object = bumpy_sphere([1.0, 1.0, 1.0, 0.25], f0);
        let mut renderer = in_room(&gpu, vec![object], [1.0; 3]);
        let sun = Sun { direction: Vec3::new(0.6, -0.1, 0.7).normalize(), irradiance: Vec3::splat(3.0) };
        for technique in [Technique::Lean, Technique::Leadr, Technique::LeadrGgx] {
            let terms = Terms::SPECULAR_LIGHTS | Terms::SPECULAR_ENVIRONMENT;
            let shading = technique.with(ShadingOptions { terms, ..Default::default() });
            let output = renderer.render_in_two_passes(&state(6.0, Some(sun), Vec::new()), &settings(shading)).unwrap();
            let most = output.color.iter().filter(|c| c[3] > 0.0).map(|c| c[0]).fold(0.0, f32::max);
            assert_eq!(most > 0.0, f0 > 0.0, "{shading}: {most}");
        }
    }
}

/// A sun on a flat plane of Phong facets, against the 64-bit formula. Rough facets have heavier tails than Gaussian ones.
#[test]
fn phong_facets_reflect_a_sun() {
    let Some(gpu) = test_gpu() else { return };
    for alpha in [0.2f32, 0.8] {
        let plane = Object::new("plane", plane(2.0, 2, 1.0, [0.0, 0.0, 0.0, alpha], even)).without_shadow();
        let mut renderer = in_room(&gpu, vec![plane.with_specular_f0(0.5)], [0.0; 3]);
        let camera = Camera::looking_at(Vec3::new(0.0, -1.5, 2.6), Vec3::ZERO, 4.0);
        let wo = camera.position.as_dvec3().normalize();
        for direction in [Vec3::new(0.0, 0.5, 0.86), Vec3::new(0.6, 0.6, 0.4), Vec3::new(-0.9, 0.1, 0.3)] {
            let sun = Sun { direction: direction.normalize(), irradiance: Vec3::ONE };
            let state = FrameState { sun: Some(sun), ..FrameState::new(camera, vec![Pose::REST]) };
            let mut lit = |technique: Technique| {
                let options = ShadingOptions { terms: Terms::SPECULAR_LIGHTS, ..Default::default() };
                let settings = RenderSettings { size: (9, 9), ..settings(technique.with(options)) };
                f64::from(renderer.render(&state, &settings).unwrap().color[40][0])
            };
            let (found, gaussian) = (lit(Technique::LeadrPhong), lit(Technique::Leadr));
            let (wi, c) = (sun.direction.as_dvec3(), DVec3::new(0.5, 0.5, 0.0) * f64::from(alpha).powi(2));
            let (wh, cholesky) = (half_vector(wo, wi), slope_grid::slope_cholesky(phong_masking(c)));
            let [o, i] = [wo, wi].map(|w| phong_area(w, DVec2::ZERO, c, cholesky));
            let lit = masking_shadowing_factor(Shadowing::Correlated, &o, &i);
            let f = fresnel_schlick(DVec3::splat(0.5), wi.dot(wh)).x;
            let expected = f * 0.25 * phong_ndf(wh, DVec2::ZERO, c) * lit;
            assert!((found / expected - 1.0).abs() < 2e-3, "α {alpha}, {direction}: {found} for {expected}");
            if wh.z < 0.75 && alpha < 0.5 {
                assert!(found > 2.0 * gaussian, "{direction}: {found} beside {gaussian}");
            }
        }
    }
}

/// Under a sun, the forms of the Fresnel term differ by their quotient at the angle of the half vector.
#[test]
fn lights_have_the_exact_fresnel_term() {
    let Some(gpu) = test_gpu() else { return };
    let metal = Metal::named("chromium").unwrap();
    let plane = Object::new("plane", plane(2.0, 2, 1.0, [0.0, 0.0, 0.0, 0.5], even)).without_shadow();
    let (glass, tint) = (plane.clone().with_specular_f0(0.04), metal.edge_tint().as_vec3().to_array());
    let chromium = plane.with_specular_f0(metal.f0().x as f32).with_edge_tint([tint[0]; 3]);
    for (object, reflectance) in [
        (glass, &(|c| fresnel_dielectric(c, 1.5)) as &dyn Fn(f64) -> f64),
        (chromium, &(|c| metal.reflectance(c).x) as &dyn Fn(f64) -> f64),
    ] {
        let mut renderer = in_room(&gpu, vec![object], [0.0; 3]);
        let camera = Camera::looking_at(Vec3::new(0.0, -2.9, 0.6), Vec3::ZERO, 4.0);
        let sun = Sun { direction: Vec3::new(0.1, 0.9, 0.25).normalize(), irradiance: Vec3::ONE };
        let state = FrameState { sun: Some(sun), ..FrameState::new(camera, vec![Pose::REST]) };
        let wo = camera.position.as_dvec3().normalize();
        let cosine = (0.5 + 0.5 * wo.dot(sun.direction.as_dvec3())).sqrt();
        for technique in [
            Technique::Leadr,
            Technique::LeadrGgx,
            Technique::LeadrPhong,
            Technique::Lean,
            Technique::Gloss,
            Technique::BlinnPhong,
        ] {
            let mut lit = |fresnel| {
                let options = ShadingOptions { fresnel, terms: Terms::SPECULAR_LIGHTS, ..Default::default() };
                let settings = RenderSettings { size: (9, 9), ..settings(technique.with(options)) };
                f64::from(renderer.render(&state, &settings).unwrap().color[40][0])
            };
            let [schlick, exact] = [FresnelForm::Schlick, FresnelForm::Exact].map(&mut lit);
            let f0 = reflectance(1.0);
            let tint = if f0 > 0.1 { metal.edge_tint().x } else { 0.0 };
            let drawn = fresnel_edge_tint(DVec3::splat(f0), DVec3::splat(tint), cosine).x;
            let (found, expected) = (exact / schlick, reflectance(cosine) / drawn);
            assert!((found - expected).abs() < 0.005, "{technique:?}: {found} for {expected}");
            assert!((expected - 1.0).abs() > 0.02, "the test must tell the forms apart: {expected}");
        }
    }
}

/// A picture is the sum of its terms. Diffuse terms lose the specular reflection: the probes' mean Fresnel reflectance if the specular
/// environment is drawn, and its closed form otherwise. With either, the rest is a sum.
#[test]
#[ignore = "long"]
fn terms_sum_to_the_whole() {
    let Some(gpu) = test_gpu() else { return };
    let object = bumpy_sphere([0.5, 0.5, 0.5, 0.25], 0.05);
    let mut renderer = in_room(&gpu, vec![object], [1.0; 3]);
    let sun = Sun { direction: Vec3::new(0.6, -0.1, 0.7).normalize(), irradiance: Vec3::splat(3.0) };
    let state = state(6.0, Some(sun), Vec::new());
    let rest = [Terms::SPECULAR_LIGHTS, Terms::DIFFUSE_LIGHTS, Terms::DIFFUSE_ENVIRONMENT];
    for technique in Technique::ALL.into_iter().filter(|t| *t != Technique::Constant) {
        let mut picture = |terms: Terms| {
            let shading = technique.with(ShadingOptions { terms, ..Default::default() });
            renderer.render(&state, &settings(shading)).unwrap().color
        };
        let black = picture(Terms::NONE);
        let specular_terms = picture(Terms::SPECULAR_ENVIRONMENT);
        let with_specular = rest.map(|term| picture(term | Terms::SPECULAR_ENVIRONMENT));
        let alone = rest.map(&mut picture);
        let wholes = [picture(Terms::ALL), picture(rest[0] | rest[1] | rest[2])];
        let (mut worst, mut fresnel, mut most, mut count) = (0.0f32, 0.0f32, [0.0f32; 4], 0);
        for i in (0..black.len()).filter(|&i| black[i][3] > 0.0) {
            assert_eq!(black[i][0], 0.0);
            let specular_only = specular_terms[i][0];
            let sums = [
                specular_only + with_specular.iter().map(|p| p[i][0] - specular_only).sum::<f32>(),
                alone.iter().map(|p| p[i][0]).sum(),
            ];
            for (sum, whole) in sums.iter().zip(&wholes) {
                worst = worst.max((sum - whole[i][0]).abs() / whole[i][0]);
            }
            // Difference of the Fresnel term's closed form from the probes', relative to the diffuse light.
            for term in 1..3 {
                let (a, b) = (with_specular[term][i][0] - specular_only, alone[term][i][0]);
                fresnel = fresnel.max(if a > 0.02 { (b / a - 1.0).abs() } else { 0.0 });
            }
            most[0] = most[0].max(specular_only);
            for (most, part) in most[1..].iter_mut().zip(&alone) {
                *most = most.max(part[i][0]);
            }
            count += 1;
        }
        let name = technique.name();
        println!("{name}: sums are off by {worst:.1e}, Fresnel terms by {fresnel:.3}; most {most:?}");
        assert!(count > 1000 && worst < 1e-5, "{name}: {worst}");
        let bound = if technique.integrates() { 0.15 } else { 1e-5 };
        assert!(fresnel < bound, "{name}: {fresnel}");
        assert!(most.iter().all(|&m| m > 0.01), "{name}: a term is missing: {most:?}");
    }
}

/// In a panorama of order-2 radiance, which nine coefficients represent exactly: the diffuse part of every pixel (the difference between a
/// white and a black surface) against the 64-bit reference.
#[test]
fn the_diffuse_environment_agrees_with_the_reference_at_every_pixel() {
    let Some(gpu) = test_gpu() else { return };
    let radiance =
        |d: DVec3| DVec3::new(1.0 + 0.5 * d.x, 1.2 + 0.4 * d.y * d.z, 0.8 + 0.3 * d.z + 0.3 * (d.x * d.x - d.y * d.y));
    let image = panorama(256, radiance);
    let coefficients = sh_projection::project_function(8, radiance);
    let f0 = 0.04;
    let mut renderers = [1.0, 0.0].map(|albedo| {
        let environment = Environment::from_equirect(&gpu, 64, &image).unwrap();
        let object = bumpy_sphere([albedo, albedo, albedo, 0.3], f0);
        Renderer::new(&gpu, vec![object], environment).unwrap()
    });
    let state = state(5.0, None, Vec::new());
    for (shading, integral) in integrals() {
        let [white, black] =
            renderers.each_mut().map(|r| r.render_in_two_passes(&state, &settings(shading)).unwrap().color);
        let (mut worst, mut count) = (0.0f64, 0);
        for (i, pixel) in pixels(&mut renderers[0], &state, integral.grid_nodes, &white) {
            let [_, fresnel] = pixel.specular_terms(integral, DVec3::splat(f64::from(f0)));
            let diffuse = if integral.shadowing == Shadowing::Correlated {
                let cholesky = slope_grid::slope_cholesky(pixel.diffuse_s);
                let bent = bent_normal(&direction_area(pixel.wo, pixel.m, cholesky), pixel.m, cholesky);
                shadowed_diffuse_environment(&bent, &pixel.frame, &coefficients, DVec3::ZERO)
            } else {
                diffuse::leadr_diffuse_environment(&pixel.normals(integral), &pixel.frame, &coefficients, DVec3::ZERO)
            };
            let expected = (1.0 - fresnel) * diffuse;
            let actual = DVec3::from_array(std::array::from_fn(|k| f64::from(white[i][k] - black[i][k])));
            worst = worst.max((actual - expected).length() / (expected.length() + 0.02));
            count += 1;
        }
        println!("{shading}: {count} pixels, worst relative error {worst:.2e}");
        assert!(count > 1_000);
        assert!(worst < 3e-4, "{shading}: {worst}");
    }
}
