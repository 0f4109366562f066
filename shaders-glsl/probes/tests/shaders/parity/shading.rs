//! The device's recommended shading of a light against the f64 reference.

use super::comparator::{Arguments as _, Numbers, Tolerance, join, list, parity, v2, v3};
use super::extremes::finite;
use glam::DVec3;
use leadr_reflectance::random::Random;
use leadr_reflectance::shading::{Surface, light};
use leadr_testing::gpu::test_gpu;

#[test]
fn light_parity() {
    parity::<12>(
        "shading",
        Tolerance { relative: 1e-3, floor: |_| 1e-2, unit: |_| 0.0 },
        |r| {
            let (wo, wi) = (r.direction(), r.direction());
            let tail = [r.range(0.05, 1.0)];
            join(&[&wo.to_array(), &wi.to_array(), &r.mean_slope().to_array(), &r.covariance().to_array(), &tail])
        },
        |x| {
            let (wo, wi) = (v3(x, 0), v3(x, 3));
            let with = |albedo: DVec3, f0: DVec3| {
                let surface =
                    Surface { mean_slope: v2(x, 6), slope_covariance: v3(x, 8), roughness: x[11], albedo, f0 };
                light(&surface, wo, wi)
            };
            list![with(DVec3::new(0.8, 0.5, 0.2), DVec3::ZERO), with(DVec3::ZERO, DVec3::new(0.04, 0.5, 1.0))]
        },
    );
}

/// Results are finite even for unreasonable arguments.
#[test]
fn finite_at_the_extremes() {
    let Some(gpu) = test_gpu() else { return };
    finite::<12, 1>(&gpu, &mut Random(7), "shading", 6, 2, |r| [r.log(1e-4, 1e2) as f32]);
}
