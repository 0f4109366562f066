//! What techniques make of the slopes under a pixel, on every kind of surface.

use glam::Vec3;
use leadr::render::camera::Camera;
use leadr::render::frame::{Layer, Renderer};
use leadr::render::light::sky::Sky;
use leadr::render::scene::FrameState;
use leadr::render::settings::Technique;
use leadr::scenes::ocean::sea::ocean;
use leadr::scenes::ocean::spectrum::Sea;

use crate::common::render::seascape;
use crate::edges::{rock, settings_of};

/// A windy sea seen from above.
fn sea(gpu: &crate::common::gpu::TestGpu) -> (Renderer, FrameState) {
    let sea = Sea { wind_speed: 9.0, wind_direction: 0.4, ..Sea::default() };
    let renderer = seascape(gpu, ocean(&sea, 64, 2));
    let camera = Camera::looking_at(Vec3::Z * 300.0, Vec3::new(230.0, 0.0, 107.0), 40.0);
    (renderer, FrameState::new(camera, Vec::new()).under(&Sky::default()))
}

/// CLEAN's covariance is LEAN's with one variance, their mean, for all directions: where pixels are filtered, where edge
/// samples are joined, and on the sea.
#[test]
fn clean_has_one_variance_on_every_surface() {
    let Some(gpu) = crate::common::gpu::test_gpu() else { return };
    for (name, (mut renderer, state), edge_samples) in
        [("skin", rock(&gpu, 6.0), 1), ("joined edges", rock(&gpu, 20.0), 16), ("sea", sea(&gpu), 1)]
    {
        let mut covariance = |technique| {
            renderer.render(&state, &settings_of(technique, 1, edge_samples)).unwrap();
            renderer.layer(Layer::Covariance).unwrap()
        };
        let (lean, clean) = (covariance(Technique::Lean), covariance(Technique::Clean));
        let (mut pixels, mut stretched) = (0, 0);
        for ([xx, yy, xy, _], clean) in lean.into_iter().zip(clean).filter(|(lean, _)| lean[0] + lean[1] > 1e-5) {
            pixels += 1;
            stretched += u32::from((xx - yy).abs().max(xy.abs()) > 0.1 * (xx + yy));
            let ([x, y, mixed, _], mean) = (clean, 0.5 * (xx + yy));
            assert!((x, mixed) == (y, 0.0), "{name}: {clean:?} is not isotropic");
            // Joined samples are isotropic before they are turned and joined.
            assert!((x - mean).abs() < if edge_samples > 1 { 0.1 } else { 1e-5 } * mean, "{name}: {x}, not {mean}");
        }
        println!("{name}: {pixels} pixels, {stretched} of them stretched");
        assert!(pixels > 100 && 4 * stretched > pixels, "{name}: {stretched} of {pixels}");
    }
}

/// What a pixel sees: nothing or a place on a patch of an object, and of its bumps what their distribution says.
#[test]
fn layers_tell_patches_and_visible_areas() {
    let Some(gpu) = crate::common::gpu::test_gpu() else { return };
    let (mut renderer, state) = rock(&gpu, 20.0);
    renderer.render(&state, &settings_of(Technique::Leadr, 1, 1)).unwrap();
    let mut layer = |layer| renderer.layer(layer).unwrap();
    let (depth, patches, areas) = (layer(Layer::Depth), layer(Layer::Patch), layer(Layer::VisibleArea));
    let (normals, covariances) = (layer(Layer::Normal), layer(Layer::Covariance));
    let (mut seen, mut different) = (0, std::collections::BTreeSet::new());
    let mut steepest = [(1.0f32, 0.0f32), (0.0, 0.0)];
    for (i, [object, patch, u, v]) in patches.iter().enumerate() {
        assert_eq!(depth[i][0].is_finite(), *object > 0.0, "pixel {i}");
        if *object == 0.0 {
            assert_eq!(areas[i][0], 0.0);
            continue;
        }
        seen += 1;
        different.insert(*patch as u32);
        // Pixels at an edge lie beyond it by what rasterisers interpolate.
        assert!([u, v].iter().all(|place| (-0.01..=1.01).contains(*place)), "{u} {v}");
        assert!(areas[i][0].is_finite() && areas[i][0] > 0.0, "{:?}", areas[i]);
        let normal = Vec3::new(normals[i][0], normals[i][1], normals[i][2]);
        let cosine = normal.dot((state.camera.position - state.camera.target).normalize());
        assert!(covariances[i][0] > 0.0);
        // The one that is seen most steeply, and the one that is seen least so.
        if cosine < steepest[0].0 {
            steepest[0] = (cosine, areas[i][0]);
        }
        if cosine > steepest[1].0 {
            steepest[1] = (cosine, areas[i][0]);
        }
    }
    println!("{seen} pixels of {} patches; areas {steepest:?}", different.len());
    assert!(seen > 50 && different.len() > 10, "{seen} {different:?}");
    // From in front all of the bumps is seen and they are as large as what they lie on; from the side they stand out of it.
    assert!((steepest[1].1 - 1.0).abs() < 0.1 && steepest[0].1 > 1.1, "{steepest:?}");
}
