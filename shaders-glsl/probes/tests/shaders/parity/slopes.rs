//! The slope distributions and the samplers of visible normals on the device against the f64 reference.

use super::comparator::{Arguments as _, Numbers, TUPLES, Tolerance, join, list, parity, v2, v3};
use super::extremes::finite;
use glam::{DVec2, DVec3, IVec2};
use leadr_reflectance::facets::beckmann::beckmann_vndf;
use leadr_reflectance::facets::beckmann_sampling::{beckmann_sample_visible, visible_slope_quantile};
use leadr_reflectance::facets::ellipse::{
    Ellipse, bivariate_from_ellipse, ellipse_from_bivariate, ellipse_from_roughness, roughness_from_bivariate,
    roughness_from_ellipse,
};
use leadr_reflectance::facets::ggx::{
    ggx_lambda, ggx_masking, ggx_masking_shadowing, ggx_ndf, ggx_p22, ggx_visible_area, ggx_vndf,
};
use leadr_reflectance::facets::ggx_sampling::ggx_sample_visible;
use leadr_reflectance::facets::normal_distribution::{normal_cdf, normal_pdf, normal_quantile, normal_tail_mean};
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::grid::{normal_of_slope, slope_sample};
use leadr_reflectance::slopes::moments::SlopeMoments;
use leadr_reflectance::slopes::tiling::{add_variant, merged_variants, tiling_fade, tiling_variants, variant_offset};
use leadr_testing::gpu::{run_probe, test_gpu};

/// Half of the normals lie in the lobe, half anywhere.
fn normal(r: &mut Random, m: DVec2, s: DVec3) -> DVec3 {
    if r.unit() < 0.5 {
        r.direction()
    } else {
        normal_of_slope(slope_sample(DVec2::new(r.range(-3.0, 3.0), r.range(-3.0, 3.0)), m, s))
    }
}

/// A number in the unit interval; a quarter of them near its ends.
fn number(r: &mut Random) -> f64 {
    match (r.unit() * 8.0) as u32 {
        0 => r.log(4e-8, 0.1),
        1 => 1.0 - r.log(1e-6, 0.1),
        _ => r.unit(),
    }
}

#[test]
fn ggx_parity() {
    parity::<14>(
        "facets/ggx",
        Tolerance { relative: 1e-5, floor: |k| if k < 2 || k == 6 { 1e-12 } else { 1e-6 }, unit: |_| 0.0 },
        |r| {
            let (wo, wi, m, a) = (r.direction(), r.direction(), r.mean_slope(), r.covariance());
            let wn = normal(r, m, a);
            join(&[&wo.to_array(), &wi.to_array(), &wn.to_array(), &m.to_array(), &a.to_array()])
        },
        |x| {
            let (wo, wi, wn, m, a) = (v3(x, 0), v3(x, 3), v3(x, 6), v2(x, 9), v3(x, 11));
            list![[
                ggx_p22(DVec2::new(wn.x, wn.y), m, a),
                ggx_ndf(wn, m, a),
                ggx_visible_area(wo, m, a),
                ggx_lambda(wo, m, a),
                ggx_masking(wo, m, a),
                ggx_masking_shadowing(wo, wi, m, a, true),
                ggx_vndf(wo, wn, m, a),
            ]]
        },
    );
}

#[test]
fn slope_distribution_parity() {
    parity::<11>(
        "facets/slope_distribution",
        Tolerance { relative: 1e-4, floor: |_| 1e-3, unit: |_| 0.0 },
        |r| {
            let (wo, m, s) = (r.direction(), r.mean_slope(), r.covariance());
            let wn = if r.unit() < 0.3 {
                normal(r, m, s)
            } else {
                beckmann_sample_visible(wo, DVec2::new(r.unit(), r.unit()), m, s)
            };
            join(&[&wo.to_array(), &wn.to_array(), &m.to_array(), &s.to_array()])
        },
        |x| list![[beckmann_vndf(v3(x, 0), v3(x, 3), v2(x, 6), v3(x, 8))]],
    );
}

#[test]
fn ggx_sampling_parity() {
    parity::<10>(
        "facets/ggx_sampling",
        Tolerance { relative: 2e-5, floor: |_| 0.1, unit: |_| 0.0 },
        |r| {
            let (wo, m, a) = (r.direction(), r.mean_slope(), r.covariance());
            join(&[&wo.to_array(), &[number(r), r.unit()], &m.to_array(), &a.to_array()])
        },
        |x| list![ggx_sample_visible(v3(x, 0), v2(x, 3), v2(x, 5), v3(x, 7))],
    );
}

fn sampling_arguments(r: &mut Random) -> [f64; 11] {
    let (wo, m, s) = (r.direction(), r.mean_slope(), r.covariance());
    let nu = match (r.unit() * 6.0) as u32 {
        0 => r.log(1e-3, 1e9),
        1 => -r.log(1e-3, 12.0),
        2 => r.range(-0.01, 0.01),
        _ => r.range(-10.0, 10.0),
    };
    join(&[&wo.to_array(), &[number(r), number(r)], &m.to_array(), &s.to_array(), &[nu]])
}

#[test]
fn beckmann_sampling_parity() {
    parity::<11>(
        "facets/beckmann_sampling",
        Tolerance { relative: 2e-5, floor: |k| if k < 3 { 0.1 } else { 1.0 }, unit: |_| 0.0 },
        sampling_arguments,
        |x| {
            let (wo, u, m, s) = (v3(x, 0), v2(x, 3), v2(x, 5), v3(x, 7));
            let wn = beckmann_sample_visible(wo, u, m, s);
            list![wn, [visible_slope_quantile(u.x, x[10]), normal_quantile(u.y)]]
        },
    );
}

/// Compares quantiles by probability: that of the device's quantile, in f64, with `u`.
#[test]
fn device_quantiles_have_their_probabilities() {
    let Some(gpu) = test_gpu() else { return };
    let mut random = Random(0x51de);
    let inputs: Vec<[f32; 11]> = (0..TUPLES).map(|_| sampling_arguments(&mut random).map(|v| v as f32)).collect();
    let got = run_probe(&gpu, "probes/facets/beckmann_sampling.comp", &inputs, 5);
    let (mut visible, mut plain) = ((0.0f64, 0), (0.0f64, 0));
    for (i, input) in inputs.iter().enumerate() {
        let (u, v, nu) = (f64::from(input[3]), f64::from(input[4]), f64::from(input[10]));
        let (x, y) = (f64::from(got[5 * i + 3]), f64::from(got[5 * i + 4]));
        let part =
            if x <= 0.0 { normal_tail_mean(-x) + (nu - x) * normal_cdf(x) } else { nu * normal_cdf(x) + normal_pdf(x) };
        let p = part / (nu.max(0.0) + normal_tail_mean(nu.abs()));
        // Relative to the smaller tail, unless that is below the rounding of u.
        let error = (p - u).abs() / u.min(1.0 - u).max(1e-2);
        if error > visible.0 {
            visible = (error, i);
        }
        let error = (normal_cdf(y) - v).abs() / v.min(1.0 - v).max(1e-2);
        if error > plain.0 {
            plain = (error, i);
        }
    }
    println!("worst probability: visible slopes {:.1e} ({:?})", visible.0, &inputs[visible.1][3..]);
    println!("worst probability: normal {:.1e} (u = {})", plain.0, inputs[plain.1][4]);
    assert!(visible.0 < 3e-4 && plain.0 < 1e-5, "on {}", gpu.device_name());
}

#[test]
fn ellipse_parity() {
    parity::<6>(
        "facets/ellipse",
        Tolerance {
            relative: 1e-5,
            floor: |k| if k == 6 || k == 15 { 1.0 } else { 1e-3 },
            unit: |k| if k == 2 { 4.0 } else { 0.0 },
        },
        |r| {
            let a = r.covariance();
            let major = r.log(0.02, 2.0);
            let minor = major * r.pick([0.0, 1e-3, 0.3, 0.9, 1.0]);
            join(&[&[major, minor, r.range(-1.57, 1.57)], &a.to_array()])
        },
        |x| {
            let e = Ellipse { radii: v2(x, 0), angle: x[2] };
            let b = bivariate_from_ellipse(&e);
            let (back, other) = (ellipse_from_bivariate(&b), ellipse_from_roughness(v3(x, 3)));
            list![
                b.alpha,
                [b.rho, b.independence],
                back.radii,
                [back.angle],
                roughness_from_ellipse(&e),
                roughness_from_bivariate(&b),
                other.radii,
                [other.angle],
            ]
        },
    );
}

/// Results are finite even for unreasonable arguments.
#[test]
fn finite_at_the_extremes() {
    let Some(gpu) = test_gpu() else { return };
    let r = || Random(11);
    finite::<14, 0>(&gpu, &mut r(), "facets/ggx", 7, 3, |_| []);
    finite::<11, 0>(&gpu, &mut r(), "facets/slope_distribution", 1, 2, |_| []);
    finite::<10, 0>(&gpu, &mut r(), "facets/ggx_sampling", 3, 1, |_| []);
    finite::<11, 0>(&gpu, &mut r(), "facets/beckmann_sampling", 5, 1, |_| []);
    finite::<6, 0>(&gpu, &mut r(), "facets/ellipse", 16, 0, |_| []);
}

/// A map of one wave, and its slope. The blend is continuous where the variants of a point change.
fn wave(at: DVec2) -> (f64, DVec2) {
    let phase = std::f64::consts::TAU * (at.x + 2.0 * at.y);
    (phase.sin(), std::f64::consts::TAU * phase.cos() * DVec2::new(1.0, 2.0))
}

#[test]
fn tiling_parity() {
    parity::<6>(
        "slopes/tiling",
        // Lattice coordinates reach a few hundred, and weights change ten times as fast as the position near the centre of three
        // variants.
        Tolerance { relative: 1e-4, floor: |k| if k < 2 { 1.0 } else { 30.0 }, unit: |_| 4.0 },
        |r| {
            let corner = [r.range(-900.0, 900.0).floor() + 0.5, r.range(-900.0, 900.0).floor() + 0.5];
            let texcoord = [r.range(-30.0, 30.0), r.range(-30.0, 30.0)];
            join(&[&texcoord, &[r.range(1.0, 4.0), r.range(0.0, 3.0)], &corner])
        },
        |x| {
            let (texcoord, cells, corner) = (v2(x, 0), x[2], IVec2::new(x[4].floor() as i32, x[5].floor() as i32));
            let part = tiling_fade(x[3], 16.0, cells);
            let (mut height, mut squares, mut blend) = (0.0, 0.0, SlopeMoments::default());
            for variant in merged_variants(tiling_variants(texcoord, cells), x[3]) {
                let (seen, slope) = wave(texcoord - texcoord.floor() + variant_offset(variant.corner));
                height += variant.weight * seen;
                squares += variant.weight * variant.weight;
                let moments = SlopeMoments { first: slope, second: DVec3::new(90.0, 300.0, 120.0) };
                blend = add_variant(blend, moments, variant.weight, part);
                blend.first += variant.slope * seen;
            }
            let offset = variant_offset(corner);
            list![[height, squares], blend.first.to_array(), blend.second.to_array(), [part], offset.to_array()]
        },
    );
}
