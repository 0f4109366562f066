//! The device's direction-correlated masking and shadowed environments against the f64 reference. How arguments are compared: see
//! `parity/comparator.rs`.

mod common;
#[path = "parity/comparator.rs"]
mod comparator;

use comparator::{Numbers, Random, TUPLES, Tolerance, join, list, parity, v2, v3};
use glam::{DVec2, DVec3};
use leadr::reflectance::correlated_masking::{Visibility, direction_area, lit_fraction, visibility_factor};
use leadr::reflectance::frame::frame_about;
use leadr::reflectance::sh::sh_add_light;
use leadr::reflectance::shadowed_environment::{
    bent_normal, lit_probe, shadowed_diffuse_environment, visible_slope_shift,
};
use leadr::reflectance::slope_grid::{slope_cholesky, slope_sample};

/// Two directions: any, equal, or of one azimuth and of opposite ones where the surface is isotropic (ρ = ±1).
fn pair(r: &mut Random, s: DVec3) -> (DVec3, DVec3) {
    let wo = r.direction();
    let wi = match (r.unit() * 12.0) as u32 {
        0 => wo,
        1 => -wo,
        k @ 2..6 => {
            // Exactly the same or the opposite azimuth, or one that is off by little.
            let side = if k % 2 == 0 { 1.0 } else { -1.0 };
            let off = if k < 4 { 0.0 } else { r.log(1e-6, 0.3) };
            let c = slope_cholesky(s);
            let p = side * DVec2::new(c.x * wo.x + c.y * wo.y, c.z * wo.y);
            let turned = DVec2::from_angle(off).rotate(p) * r.log(0.1, 10.0);
            let y = turned.y / c.z.max(1e-9);
            let x = (turned.x - c.y * y) / c.x.max(1e-9);
            DVec3::new(x, y, r.range(-0.1, 1.0)).clamp_length(1e-6, 1e6).normalize()
        }
        _ => r.direction(),
    };
    (wo, wi)
}

#[test]
fn correlated_masking_parity() {
    parity::<11>(
        "correlated_masking",
        Tolerance { relative: 5e-6, floor: |k| if k < 5 { 1e-6 } else { 1e-4 }, unit: 0.0 },
        |r| {
            let (m, s) = (r.mean_slope(), r.covariance());
            let (wo, wi) = pair(r, s);
            join(&[&wo.to_array(), &wi.to_array(), &m.to_array(), &s.to_array()])
        },
        |x| {
            let (wo, wi, m, s) = (v3(x, 0), v3(x, 3), v2(x, 6), v3(x, 8));
            let cholesky = slope_cholesky(s);
            let (o, i) = (direction_area(wo, m, cholesky), direction_area(wi, m, cholesky));
            let lit = Visibility::ALL.map(|v| lit_fraction(v, &o, &i));
            let factors = [Visibility::Correlated, Visibility::CorrelatedSimple].map(|v| visibility_factor(v, &o, &i));
            list![o.whitened, [o.spread, o.meso, o.visible], lit, factors]
        },
    );
}

#[test]
fn shadowed_environment_parity() {
    parity::<12>(
        "shadowed_environment",
        Tolerance { relative: 1e-4, floor: |k| if k < 2 { 1e-2 } else { 0.1 }, unit: 0.0 },
        |r| {
            let (wo, m, s) = (r.direction(), r.mean_slope(), r.covariance());
            // Probes within the lobe, lines across of any direction, some of no extent.
            let p = DVec2::new(r.range(-2.5, 2.5), r.range(-2.5, 2.5));
            let slope = slope_sample(p, m, s);
            let q = DVec2::new(r.range(-1.0, 1.0), r.range(-1.0, 1.0));
            let across = if r.unit() < 0.1 { DVec2::ZERO } else { slope_sample(q, DVec2::ZERO, s) };
            join(&[&wo.to_array(), &m.to_array(), &s.to_array(), &slope.to_array(), &across.to_array()])
        },
        |x| {
            let (wo, m, s) = (v3(x, 0), v2(x, 3), v3(x, 5));
            let cholesky = slope_cholesky(s);
            let o = direction_area(wo, m, cholesky);
            let v = bent_normal(&o, m, cholesky);
            let mut c = [DVec3::ZERO; 9];
            c[0] = DVec3::new(2.0, 1.5, 1.0);
            sh_add_light(&mut c, DVec3::new(0.6, 0.0, 0.8), DVec3::new(1.0, 2.0, 3.0));
            let radiance = shadowed_diffuse_environment(&v, &frame_about(wo), &c);
            let lit = [Visibility::Smith, Visibility::Correlated, Visibility::CorrelatedSimple]
                .map(|visibility| lit_probe(visibility, &o, wo, v2(x, 8), v2(x, 10), m, cholesky));
            let shift = visible_slope_shift(&o, cholesky);
            list![shift, v.normal, [v.open], radiance, lit]
        },
    );
}

/// Arguments no scene should produce: everything is finite all the same.
#[test]
fn finite_at_the_extremes() {
    let Some(gpu) = common::test_gpu() else { return };
    let mut r = Random(7);
    let any = |r: &mut Random| r.pick([0.0, 1e-30, -1e-30, 1e-12, 1.0, -1.0, 0.5, 1e3, -1e3, 1e6, -1e6]) as f32;
    let axis = |r: &mut Random| {
        let v = DVec3::new(r.pick([0.0, 1.0, -1.0, 1e-7]), r.pick([0.0, 1.0, -1e-4]), r.pick([0.0, 1.0, -1.0, 1e-20]));
        v.try_normalize().unwrap_or(DVec3::NEG_Z).to_array().map(|v| v as f32)
    };
    let numbers = |r: &mut Random, n: usize| (0..n).map(|_| any(r)).collect::<Vec<f32>>();
    let masking: Vec<[f32; 11]> = (0..TUPLES)
        .map(|_| {
            let directions = [axis(&mut r), axis(&mut r)].concat();
            [directions, numbers(&mut r, 5)].concat().try_into().expect("11 numbers")
        })
        .collect();
    let environment: Vec<[f32; 12]> = (0..TUPLES)
        .map(|_| [axis(&mut r).to_vec(), numbers(&mut r, 9)].concat().try_into().expect("12 numbers"))
        .collect();
    check_finite(&gpu, "correlated_masking", &masking, 11);
    check_finite(&gpu, "shadowed_environment", &environment, 12);
}

fn check_finite<const N: usize>(gpu: &common::TestGpu, name: &str, items: &[[f32; N]], outputs: usize) {
    let got = common::run_probe::<N>(gpu, &format!("probes/{name}.comp"), items, outputs);
    assert_eq!(got.len(), items.len() * outputs);
    let bad: Vec<_> = got.iter().enumerate().filter(|(_, v)| !v.is_finite()).map(|(i, _)| i).collect();
    assert!(
        bad.is_empty(),
        "{name} on {}: {} values not finite, first output {} of {:?}",
        gpu.device_name(),
        bad.len(),
        bad[0] % outputs,
        items[bad[0] / outputs]
    );
}
