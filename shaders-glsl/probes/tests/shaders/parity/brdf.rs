//! The device's BRDF functions against the f64 reference: masking variants, conductors, half/difference, and the whole
//! microfacet BRDF. `parity/comparator.rs` describes the comparison.

use super::comparator::{Arguments as _, Numbers, Tolerance, join, list, parity, v2, v3};
use super::extremes::finite;
use glam::{DVec2, DVec3};
use leadr_reflectance::facets::fresnel::fresnel_conductor;
use leadr_reflectance::integrals::specular::environment_sample;
use leadr_reflectance::masking::variants::{Masking, masking_factor};
use leadr_reflectance::materials::half_difference::{
    HalfDifference, directions_to_half_difference, half_difference_to_directions,
};
use leadr_reflectance::materials::microfacet::{half_vector, microfacet_eval_beckmann, microfacet_eval_ggx};
use leadr_reflectance::random::Random;
use leadr_testing::gpu::test_gpu;

/// Two directions, sometimes equal or opposite. Half of the lights are near the reflected direction of a facet in the lobe.
fn pair(r: &mut Random, m: DVec2, s: DVec3) -> (DVec3, DVec3) {
    let wo = r.direction();
    let wi = match (r.unit() * 20.0) as u32 {
        0 => wo,
        1 => -wo,
        2..10 => r.direction(),
        _ => environment_sample(wo, DVec2::new(r.range(-2.0, 2.0), r.range(-2.0, 2.0)), m, s).wi,
    };
    (wo, wi)
}

#[test]
fn fresnel_conductor_parity() {
    parity::<7>(
        "facets/fresnel_conductor",
        Tolerance { relative: 5e-6, floor: |_| 1e-3, unit: |_| 0.0 },
        |r| {
            let mut x = [0.0; 7];
            // Metals, dielectrics, and values in between.
            x[..6].fill_with(|| match (r.unit() * 12.0) as u32 {
                0 => 0.0,
                1 => 1.0,
                2 => r.log(1e-9, 1e9),
                _ => r.log(0.05, 8.0),
            });
            x[6] = if r.unit() < 0.2 { r.pick([0.0, 1.0, -1.0, 1e-6, 1.1]) } else { r.unit() };
            x
        },
        |x| list![fresnel_conductor(x[6], v3(x, 0), v3(x, 3))],
    );
}

#[test]
fn half_difference_parity() {
    parity::<6>(
        "materials/half_difference",
        Tolerance { relative: 2e-6, floor: |_| 1.0, unit: |_| 0.0 },
        |r| {
            let (wo, wi) = pair(r, DVec2::ZERO, DVec3::new(0.2, 0.2, 0.0));
            join(&[&wo.to_array(), &wi.to_array()])
        },
        |x| {
            let (wo, wi) = (v3(x, 0), v3(x, 3));
            let p = directions_to_half_difference(wo, wi);
            let (o, i) = half_difference_to_directions(&p);
            let (there, back) = half_difference_to_directions(&HalfDifference { wh: wo, wd: wi });
            list![p.wh, p.wd, o, i, there, back]
        },
    );
}

#[test]
fn masking_variants_parity() {
    parity::<16>(
        "masking/variants",
        Tolerance { relative: 5e-6, floor: |_| 1e-6, unit: |_| 0.0 },
        |r| {
            let (m, s) = (r.mean_slope(), r.covariance());
            let (wo, wi) = pair(r, m, s);
            let wh = half_vector(wo, wi);
            let areas = [wo, wi].map(|w| leadr_reflectance::facets::projected_area::visible_area(w, m, s));
            join(&[&wo.to_array(), &wi.to_array(), &wh.to_array(), &m.to_array(), &areas, &s.to_array()])
        },
        |x| {
            let (wo, wi, wh, m) = (v3(x, 0), v3(x, 3), v3(x, 6), v2(x, 9));
            list![Masking::ALL.map(|masking| masking_factor(masking, wo, wi, wh, m, x[11], x[12], v3(x, 13)))]
        },
    );
}

#[test]
fn microfacet_parity() {
    parity::<11>(
        "materials/microfacet",
        Tolerance { relative: 3e-5, floor: |_| 1e-5, unit: |_| 0.0 },
        |r| {
            let (m, s) = (r.mean_slope(), r.covariance());
            let (wo, wi) = pair(r, m, s);
            join(&[&wo.to_array(), &wi.to_array(), &m.to_array(), &s.to_array()])
        },
        |x| {
            let (wo, wi) = (v3(x, 0), v3(x, 3));
            let (m, s) = (v2(x, 6), v3(x, 8));
            let both =
                |masking| [microfacet_eval_beckmann(masking, wo, wi, m, s), microfacet_eval_ggx(masking, wo, wi, m, s)];
            Masking::ALL.map(both).concat()
        },
    );
}

/// Results are finite even for unreasonable arguments.
#[test]
fn finite_at_the_extremes() {
    let Some(gpu) = test_gpu() else { return };
    let r = &mut Random(7);
    finite::<11, 0>(&gpu, r, "materials/microfacet", 18, 2, |_| []);
    finite::<6, 0>(&gpu, r, "materials/half_difference", 18, 2, |_| []);
    finite::<7, 0>(&gpu, r, "facets/fresnel_conductor", 3, 0, |_| []);
}
