//! Deforming surfaces with fixed LEADR maps (LEADR eq. 12).

use glam::{DVec2, DVec3};
use leadr::reflectance::frame::{frame_about, to_frame};
use leadr::render::frame::Layer;
use leadr::render::settings::RenderSettings;
use leadr::scenes::deform::{Deformation, PERIOD, SHEAR, STRETCH, stage};
use leadr::scenes::stage::Lights;
use leadr_testing::gpu::{TestGpu, test_gpu};
use leadr_testing::render::stage_under_sky;

/// Mean slope covariance (xx, yy, xy) of the quad at a distance, along world x and the quad's upward direction.
fn quad_covariance(gpu: &TestGpu, deformation: Deformation, time: f64) -> [f64; 3] {
    let mut stage = stage(deformation);
    let mut renderer = stage_under_sky(gpu, &mut stage, 32);
    let settings = RenderSettings { size: (640, 240), ..Default::default() };
    let camera = stage.views.far.at_distance(120.0);
    renderer.render(&stage.state(time, &camera, &Lights::default()), &settings).unwrap();
    let mut layer = |layer: Layer| renderer.layer(layer).unwrap();
    let (depth, normal, covariance) = (layer(Layer::Depth), layer(Layer::Normal), layer(Layer::Covariance));
    let (mut sum, mut count) = ([0.0; 3], 0.0);
    // The quad is the leftmost object.
    for i in (0..depth.len()).filter(|i| depth[*i][0].is_finite() && i % 640 < 311) {
        let frame = frame_about(DVec3::from_slice(&normal[i].map(f64::from)));
        let x = to_frame(&frame, DVec3::X).truncate();
        let up = DVec2::new(-x.y, x.x);
        let c = covariance[i].map(f64::from);
        let form = |a: DVec2, b: DVec2| c[0] * a.x * b.x + c[1] * a.y * b.y + c[2] * (a.x * b.y + a.y * b.x);
        for (s, v) in sum.iter_mut().zip([form(x, x), form(up, up), form(x, up)]) {
            *s += v;
        }
        count += 1.0;
    }
    assert!(count > 30.0, "{count} pixels");
    sum.map(|s| s / count)
}

#[test]
#[ignore = "long"]
fn slopes_follow_the_deformation() {
    let Some(gpu) = test_gpu() else { return };
    let rest = quad_covariance(&gpu, Deformation::Stretch, 0.0);
    println!("at rest {rest:?}");
    assert!(rest[0] > 0.1 && (rest[1] / rest[0] - 1.0).abs() < 0.15 && (rest[2] / rest[0]).abs() < 0.1, "{rest:?}");

    // The quad leans back by 10 degrees, so its upward direction is stretched less than the vertical.
    let up = DVec3::new(0.0, 80f64.to_radians().cos(), 80f64.to_radians().sin());
    let full = quad_covariance(&gpu, Deformation::Stretch, PERIOD / 2.0);
    let (wider, lower) = (f64::from(STRETCH), (up * DVec3::new(1.0, 1.0, 1.0 / f64::from(STRETCH))).length());
    let ratio = [full[0] / rest[0] * wider * wider, full[1] / rest[1] * lower * lower];
    println!("stretched: {full:?}, ratios to the slopes over the new lengths {ratio:?}");
    assert!(ratio.iter().all(|r| (r - 1.0).abs() < 0.06), "{ratio:?}");

    // h(x − k y, y): the slope along the quad's upward direction gains −k times that along x.
    let full = quad_covariance(&gpu, Deformation::Shear, PERIOD / 2.0);
    let k = f64::from(SHEAR) * up.z;
    let expected = [rest[0], rest[1] - 2.0 * k * rest[2] + k * k * rest[0], rest[2] - k * rest[0]];
    println!("sheared {full:?}, expected {expected:?}");
    assert!(full.iter().zip(expected).all(|(a, b)| (a - b).abs() < 0.06 * rest[0]), "{full:?} {expected:?}");

    let flat = quad_covariance(&gpu, Deformation::HeightScale, PERIOD / 2.0);
    assert!(flat.iter().all(|c| c.abs() < 1e-6), "{flat:?}");
}
