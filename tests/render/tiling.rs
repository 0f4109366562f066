//! Planes whose maps are shown without their repeats.

use crate::common::gpu::test_gpu;
use crate::common::render::under_sky;
use glam::Vec3;
use leadr::lab::metrics::repetition::repetition;
use leadr::maps::{LeadrMap, RgbImage, Wrap, procedural};
use leadr::render::camera::Camera;
use leadr::render::frame::Layer;
use leadr::render::scene::{FrameState, Object, Pose, Tiling};
use leadr::render::settings::RenderSettings;
use leadr::render::surfaces::displacement::HeightField;
use leadr::scenes::ground::ground;
use leadr::scenes::plane::{even, plane};

fn settings(size: u32) -> RenderSettings {
    RenderSettings { size: (size, size), samples: 1, shadows: false, ..Default::default() }
}

/// From above, with so many metres across the picture.
fn from_above(metres: f32) -> Camera {
    let eye = Vec3::new(3.0, -2.0, metres / 2.0 / 15f32.to_radians().tan());
    Camera { up: Vec3::Y, ..Camera::looking_at(eye, Vec3::new(3.0, -2.0, 0.0), 30.0) }
}

/// The device blends moments as tests/maps/tiling.rs does: mean and variance are those of the map, whatever a pixel covers.
#[test]
fn pixels_of_a_plane_by_example_have_the_statistics_of_its_map() {
    let Some(gpu) = test_gpu() else { return };
    let map = procedural::gaussian(256, 256, 4, 0.05, 0.01);
    let whole = LeadrMap::new(&map, Wrap::Repeat).mean();
    let object = Object::new("plane", plane(40.0, 16, 1.0, [0.5; 4], even))
        .with_heights(HeightField::repeating(map), 1.0)
        .with_tiling(Tiling::ByExample)
        .without_shadow();
    let mut renderer = under_sky(&gpu, vec![object], 16);
    for metres in [4.0, 12.0, 40.0] {
        let state = FrameState::new(from_above(metres), vec![Pose::REST]);
        renderer.render(&state, &settings(160)).unwrap();
        let means = renderer.layer(Layer::MeanSlope).unwrap();
        let covariances = renderer.layer(Layer::Covariance).unwrap();
        let count = means.len() as f64;
        for axis in 0..2 {
            let mean = means.iter().map(|m| f64::from(m[axis])).sum::<f64>() / count;
            let square = |(m, s): (&[f32; 4], &[f32; 4])| f64::from(m[axis] * m[axis] + s[axis]);
            let variance = means.iter().zip(&covariances).map(square).sum::<f64>() / count;
            let expected = f64::from(whole.second[axis]);
            assert!((variance / expected - 1.0).abs() < 0.05, "{metres} m, axis {axis}: {variance} {expected}");
            assert!(mean.abs() < 0.05 * expected.sqrt(), "{metres} m, axis {axis}: {mean}");
        }
    }
}

/// The far picture of the T-rex repeated itself every 5 m.
#[test]
fn the_ground_does_not_repeat_itself() {
    let Some(gpu) = test_gpu() else { return };
    let seen = |tiling: Tiling| {
        let mut renderer = under_sky(&gpu, vec![ground().with_tiling(tiling)], 16);
        let state = FrameState::new(from_above(30.0), vec![Pose::REST]);
        let output = renderer.render(&state, &settings(192)).unwrap();
        let picture = RgbImage::new(192, 192, output.color.iter().map(|c| [c[0], c[1], c[2]]).collect()).unwrap();
        [[32, 0], [0, 32]].map(|lag| repetition(&picture, lag)).into_iter().fold(f64::MIN, f64::max)
    };
    let (repeats, ground) = (seen(Tiling::Repeats), seen(Tiling::Ground));
    assert!(repeats > 0.6, "{repeats}");
    assert!(ground < 0.3, "{ground}");
}

/// What is on the ground stays where it is while the mesh follows somebody.
#[test]
fn the_ground_stays_in_the_world() {
    let Some(gpu) = test_gpu() else { return };
    let mut renderer = under_sky(&gpu, vec![ground()], 16);
    let mut albedo = |moved: f32| {
        let pose = Pose::Rigid(glam::Affine3A::from_translation(Vec3::new(moved, 2.0 * moved, 0.0)));
        renderer.render(&FrameState::new(from_above(12.0), vec![pose]), &settings(96)).unwrap();
        renderer.layer(Layer::Albedo).unwrap()
    };
    let apart = |a: &[[f32; 4]], b: &[[f32; 4]]| {
        a.iter().zip(b).map(|(a, b)| (a[0] - b[0]).abs()).sum::<f32>() / a.len() as f32
    };
    let [here, stepped, slid] = [0.0, 5.0, 0.37].map(&mut albedo);
    // The displaced triangles are others, and with them the places that pixels see, a little.
    let (stepped, slid) = (apart(&here, &stepped), apart(&here, &slid));
    assert!(stepped < 0.01 && slid < 0.01, "{stepped} {slid}");
}
