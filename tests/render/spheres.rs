//! Filtering of spheres of known roughness.

use glam::{Affine3A, DVec3, Vec2, Vec3};
use leadr::maps::material::TextureWrap;
use leadr::reflectance::frame::{frame_about, to_frame};
use leadr::render::camera::Camera;
use leadr::render::frame::{Layer, Renderer};
use leadr::render::light::environment::Environment;
use leadr::render::light::sky::Sky;
use leadr::render::scene::{FrameState, Object, Pose};
use leadr::render::settings::RenderSettings;
use leadr::render::surfaces::object::with_same_maps;
use leadr::scenes::spheres::cell::{Facets, Lighting, ROTATION_PERIOD};
use leadr::scenes::spheres::surface::{Detail, Frequency, Surface};
use leadr_testing::gpu::{TestGpu, test_gpu};
use leadr_testing::render::under_sky;

/// Objects with reliefs that differ only in height share one set of maps, and match objects with their own maps.
#[test]
fn reliefs_of_several_heights_share_their_maps() {
    let Some(gpu) = test_gpu() else { return };
    let surface = Surface::bake(Vec2::ONE, Frequency::Low, Detail { patches: 2, tile: 16 });
    let sphere = |height: f32| surface.object("sphere", height, Facets::Diffuse);
    // The wrap beyond the tile edges is redundant here.
    let with_wrap = |object: Object| Object { slope_wrap: Some([TextureWrap::Clamp; 2]), ..object };
    let alike = vec![sphere(0.1), sphere(0.3), sphere(-0.2), sphere(0.2)];
    let apart = vec![sphere(0.1), with_wrap(sphere(0.3)), sphere(-0.2), sphere(0.2)];
    assert_eq!(with_same_maps(&alike), [None, Some(0), None, Some(0)]);
    assert_eq!(with_same_maps(&apart), [None, None, None, Some(0)]);
    let camera = Camera::looking_at(Vec3::new(3.0, -14.0, 3.0), Vec3::new(3.0, 0.0, 0.0), 40.0);
    let poses = (0..4).map(|i| Pose::Rigid(Affine3A::from_translation(Vec3::X * 2.1 * i as f32))).collect();
    let state = FrameState::new(camera, poses).under(&Sky::default());
    let settings = RenderSettings { size: (96, 32), ..RenderSettings::default() };
    let [shared, own] =
        [alike, apart].map(|objects| under_sky(&gpu, objects, 16).render(&state, &settings).unwrap().color);
    assert_eq!(shared, own);
    let other = vec![sphere(0.1), sphere(0.1), sphere(-0.2), sphere(0.2)];
    assert_ne!(under_sky(&gpu, other, 16).render(&state, &settings).unwrap().color, own, "heights count");
}

/// Mean over the disc of covariance and squared mean slope along (ω_θ, ω_φ) at the table's distance, with the LOD.
fn filtered(gpu: &TestGpu, surface: &Surface, sigma: Vec2, size: u32) -> ([f64; 3], [f64; 2], f64) {
    let lighting = Lighting::Environment;
    let mut stage = surface.stage(sigma.max_element(), lighting.facets());
    let environment = Environment::from_equirect(gpu, 32, &lighting.panorama()).unwrap();
    let mut renderer = Renderer::new(gpu, std::mem::take(&mut stage.objects), environment).unwrap();
    let settings = RenderSettings { size: (size, size), ..Default::default() };
    let (mut sum, mut means, mut lods, mut count) = ([0.0; 3], [0.0; 2], 0.0, 0.0);
    // Four sides of the sphere, for more bumps than in one view.
    for quarter in [0.0, 0.25, 0.5, 0.75] {
        renderer
            .render(&stage.state(ROTATION_PERIOD * quarter, &stage.views.mid, &lighting.lights()), &settings)
            .unwrap();
        let mut layer = |layer: Layer| renderer.layer(layer).unwrap();
        let (depth, normal) = (layer(Layer::Depth), layer(Layer::Normal));
        let (mean, covariance, lod) = (layer(Layer::MeanSlope), layer(Layer::Covariance), layer(Layer::Lod));
        for i in (0..depth.len()).filter(|&i| depth[i][0].is_finite()) {
            let n = DVec3::new(normal[i][0].into(), normal[i][1].into(), normal[i][2].into());
            // Only the middle of the disc: toward the rim a pixel covers more and more curvature.
            if n.y > -0.8 {
                continue;
            }
            let frame = frame_about(n);
            let east = to_frame(&frame, DVec3::Z.cross(n).normalize()).truncate();
            let south = to_frame(&frame, DVec3::Z.cross(n).normalize().cross(n)).truncate();
            let c = covariance[i].map(f64::from);
            let form =
                |a: glam::DVec2, b: glam::DVec2| c[0] * a.x * b.x + c[1] * a.y * b.y + c[2] * (a.x * b.y + a.y * b.x);
            let m = glam::DVec2::new(mean[i][0].into(), mean[i][1].into());
            for (s, v) in sum.iter_mut().zip([form(south, south), form(east, east), form(south, east)]) {
                *s += v;
            }
            means[0] += m.dot(south).powi(2);
            means[1] += m.dot(east).powi(2);
            lods += f64::from(lod[i][0]);
            count += 1.0;
        }
    }
    assert!(count > 100.0);
    (sum.map(|s| s / count), means.map(|m| m / count), lods / count)
}

#[test]
#[ignore = "long"]
fn the_covariance_of_a_pixel_is_the_prescribed_one() {
    let Some(gpu) = test_gpu() else { return };
    for (sigma, least) in [(Vec2::splat(0.5), [0.8, 0.8]), (Vec2::new(0.2, 0.8), [0.6, 0.8])] {
        let surface = Surface::bake(sigma, Frequency::High, Detail { patches: 12, tile: 64 });
        let (covariance, mean, lod) = filtered(&gpu, &surface, sigma, 48);
        let square = (sigma * sigma).as_dvec2().to_array();
        let share = [covariance[0] / square[0], covariance[1] / square[1]];
        let whole = [share[0] + mean[0] / square[0], share[1] + mean[1] / square[1]];
        let correlation = covariance[2] / (square[0] * square[1]).sqrt();
        println!(
            "{sigma}: covariance {share:.3?} of the prescribed, with the means {whole:.3?}, correlation {correlation:.3}, LOD {lod:.2}"
        );
        // Bumps resolved in the mean slopes of pixels are missing from their covariances.
        assert!(share[0] > least[0] && share[1] > least[1], "{share:?}");
        assert!(whole.iter().all(|w| (w - 1.0).abs() < 0.04), "{whole:?}");
        assert!(correlation.abs() < 0.05, "{correlation}");
    }
}
