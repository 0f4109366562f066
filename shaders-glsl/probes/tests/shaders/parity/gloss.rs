//! The shader functions of gloss, shortened normals and blended normal maps, on the device against the f64 reference.

use super::comparator::{Arguments as _, Numbers, Tolerance, join, list, parity, v3};
use leadr_reflectance::facets::gloss::{
    GLOSS_ADVANCED_WARFARE, GLOSS_BLINN_PHONG, GLOSS_WWII, alpha_gloss, gloss_alpha, perceptual_alpha_gloss,
    perceptual_gloss_alpha,
};
use leadr_reflectance::facets::normal_spread::{toksvig_factor, toksvig_normal_variance, vmf_kappa_estimate};
use leadr_reflectance::facets::shortened_normals::{Shortening, chan_combine_gloss, ggx_alpha_of_shortening_fit};
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::normal_blending::{
    blend_linear, blend_partial_derivatives, blend_reoriented, blend_udn, blend_whiteout, blend_xy,
};

/// Roughness of all sizes; one in eight outside the usable range or exactly 1.
fn roughness(r: &mut Random) -> f64 {
    match (r.unit() * 8.0) as u32 {
        0 => r.pick([0.0, -1.0, 1e-6, 1.0, 1e6]),
        1 => r.range(0.8, 1.2),
        2 => r.log(1.0, 120.0),
        _ => r.log(1e-4, 1.0),
    }
}

#[test]
fn gloss_parity() {
    parity::<2>(
        "facets/gloss",
        Tolerance { relative: 2e-5, floor: |k| if k < 4 { 1e-9 } else { 0.05 }, unit: |_| 0.0 },
        |r| [r.range(-0.2, 1.2), roughness(r)],
        |x| {
            let curves = [GLOSS_ADVANCED_WARFARE, GLOSS_WWII, GLOSS_BLINN_PHONG];
            let (alphas, glosses) = (curves.map(|c| gloss_alpha(x[0], c)), curves.map(|c| alpha_gloss(x[1], c)));
            list![alphas, [perceptual_gloss_alpha(x[0])], glosses, [perceptual_alpha_gloss(x[1])]]
        },
    );
}

#[test]
fn shortened_normals_parity() {
    parity::<5>(
        "facets/shortened_normals",
        // A gloss near 0 is the small difference of the terms of eq. 35.
        Tolerance { relative: 2e-5, floor: |k| if k < 17 { 1e-12 } else { 0.05 }, unit: |_| 0.0 },
        |r| {
            let one_minus_length = match (r.unit() * 6.0) as u32 {
                0 => r.pick([0.0, -1.0, 1.0, 2.0, 1.0 / 3.0, 0.5]),
                1 => 1.0 - r.log(1e-4, 0.5),
                _ => r.log(1e-8, 1.0),
            };
            [roughness(r), roughness(r), one_minus_length, r.range(-0.2, 1.2), r.range(-0.2, 1.2)]
        },
        |x| {
            let of = |k: usize| {
                let s = Shortening::ALL[k];
                [s.one_minus_length(x[0]), s.length(x[0]), s.alpha_of_shortening(x[2]), s.combine(x[0], x[1])]
            };
            let fits = [ggx_alpha_of_shortening_fit(x[2]), chan_combine_gloss(x[3], x[4])];
            list![of(0), of(1), of(2), of(3), fits]
        },
    );
}

#[test]
fn normal_spread_parity() {
    parity::<2>(
        "facets/normal_spread",
        Tolerance { relative: 5e-6, floor: |_| 1e-12, unit: |_| 0.0 },
        |r| {
            let shortenings = [r.log(1e-7, 1.0), r.unit(), -0.5, 0.0, 1.0, 1.5];
            [r.pick(shortenings), r.log(1e-2, 1e6)]
        },
        |x| list![[vmf_kappa_estimate(x[0]), toksvig_factor(x[0], x[1]), toksvig_normal_variance(x[0])]],
    );
}

#[test]
fn normal_blending_parity() {
    parity::<6>(
        "slopes/normal_blending",
        Tolerance { relative: 1e-5, floor: |_| 1.0, unit: |_| 1e-3 },
        |r| {
            let [base, detail] = [0, 1].map(|_| r.direction().to_array());
            join(&[&base, &detail])
        },
        |x| {
            let (base, detail) = (v3(x, 0), v3(x, 3));
            let blends =
                [blend_reoriented, blend_whiteout, blend_udn, blend_xy, blend_partial_derivatives, blend_linear];
            blends.iter().flat_map(|blend| blend(base, detail).to_array()).collect()
        },
    );
}
