//! The shader functions of the older techniques and of the GGX form, on the device against the f64 reference.

use super::comparator::{Arguments as _, Numbers, Tolerance, join, list, parity, v2, v3};
use glam::DVec3;
use leadr_reflectance::facets::complex_index::complex_index;
use leadr_reflectance::integrals::facet_specular::{
    facet_specular, facet_specular_density, facet_specular_light, facet_visibility,
};
use leadr_reflectance::integrals::ggx_filtering::displaced_ggx;
use leadr_reflectance::integrals::ggx_lobes::{GGX_LOBES, displaced_ggx_area, displaced_ggx_light, ggx_lobe};
use leadr_reflectance::integrals::light_size::{light_normal_variance, light_slope_covariance};
use leadr_reflectance::integrals::phong::{phong_exponent, phong_lobe, phong_masking, phong_ndf, phong_p22};
use leadr_reflectance::masking::correlated::direction_area;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::materials::classic::{
    blinn_phong_exponent, blinn_phong_ndf, blinn_phong_variance, lobe_lod, normal_variance, toksvig_exponent,
    toksvig_variance,
};
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::grid::{slope_at, slope_cholesky};
use leadr_reflectance::slopes::statistics::clamp_covariance;
use leadr_reflectance::visible::clear_coat::{
    coat_average, coat_bands, coat_facet_reflectance, coat_reflectance, coat_reflectances, coated_base,
};
use leadr_reflectance::visible::fresnel::{visible_fresnel, visible_fresnel_exact};
use leadr_reflectance::visible::transmission::{
    attenuation, passed_solid, refracted, refracted_cosine, refracted_variance, thin_variance,
};

/// A direction above the macrosurface.
fn above(r: &mut Random) -> [f64; 3] {
    let d = r.direction();
    DVec3::new(d.x, d.y, d.z.abs().max(0.05)).normalize().to_array()
}

#[test]
fn classic_parity() {
    parity::<7>(
        "materials/classic",
        Tolerance { relative: 3e-4, floor: |k| if k == 6 { 1.0 } else { 1e-6 }, unit: |_| 0.0 },
        |r| {
            let head = [r.log(1e-4, 1.0), r.range(-0.2, 1.0)];
            join(&[&head, &r.mean_slope().to_array(), &r.covariance().to_array()])
        },
        |x| {
            let exponent = blinn_phong_exponent(x[0]);
            let variance = normal_variance(v2(x, 2), v3(x, 4));
            let filtered = toksvig_variance(variance);
            list![[
                exponent,
                blinn_phong_variance(exponent),
                blinn_phong_ndf(x[1], exponent),
                variance,
                filtered,
                toksvig_exponent(exponent, filtered),
                lobe_lod(variance, 256.0),
            ]]
        },
    );
}

#[test]
fn light_size_parity() {
    parity::<7>(
        "integrals/light_size",
        // Near the horizon the squares of steep slopes cancel: covariances are compared relative to their trace.
        Tolerance { relative: 1e-4, floor: |k| if k < 3 { 1.0 } else { 1e-9 }, unit: |_| 0.0 },
        |r| {
            let directions = [above(r), above(r)].concat();
            join(&[&directions, &[r.log(1e-6, 1e-2)]])
        },
        |x| {
            let (wo, wi) = (v3(x, 0), v3(x, 3));
            let s = light_slope_covariance(wo, wi, x[6]);
            let trace = s.x + s.y;
            list![s / trace, [trace, light_normal_variance(wo.dot(wi).abs(), x[6])]]
        },
    );
}

#[test]
fn facet_specular_parity() {
    parity::<13>(
        "integrals/facet_specular",
        Tolerance { relative: 4e-3, floor: |_| 1e-3, unit: |_| 0.0 },
        |r| {
            let directions = [above(r), above(r)].concat();
            let m = [r.range(-0.7, 0.7), r.range(-0.7, 0.7)];
            let base = [r.log(0.02, 1.0), r.log(1e-7, 1e-2)];
            join(&[&directions, &m, &r.covariance().to_array(), &base])
        },
        |x| {
            let (wo, wi, m) = (v3(x, 0), v3(x, 3), v2(x, 6));
            let cholesky = slope_cholesky(v3(x, 8));
            let f = facet_specular(wo, wi, x[11], x[12]);
            let [o, i] = [wo, wi].map(|w| direction_area(w, m, cholesky));
            let visible = facet_visibility(Shadowing::Correlated, wo.z, wi.z, wo.dot(wi), f.base);
            let density = |shadowing| facet_specular_density(&f, m, cholesky, shadowing);
            let light = facet_specular_light(Shadowing::Correlated, &o, &i, &f, m, cholesky, DVec3::splat(0.04)).x;
            let densities = [Shadowing::None, Shadowing::Smith, Shadowing::Correlated].map(density);
            list![f.deviation, [visible], densities, [light]]
        },
    );
}

#[test]
fn phong_parity() {
    parity::<10>(
        "integrals/phong",
        // Slopes far from a thin covariance cancel: 3.1e-3 at worst.
        Tolerance { relative: 4e-3, floor: |_| 1e-2, unit: |_| 0.0 },
        |r| {
            let (c, m) = (r.covariance().to_array(), r.mean_slope().to_array());
            join(&[&above(r), &m, &c, &[r.range(-4.0, 4.0), r.range(-4.0, 4.0)]])
        },
        |x| {
            let (wh, m, c) = (v3(x, 0), v2(x, 3), clamp_covariance(v3(x, 5)));
            let n = phong_exponent(c);
            let most = (n + 2.0) / std::f64::consts::TAU;
            let slope = slope_at(v2(x, 8), m, slope_cholesky(c));
            let [wide, narrow] = [0, 1].map(|k| phong_lobe(c, k));
            let sum = (c.x + c.y).max(1e-8);
            list![
                [n.log2(), phong_p22(slope, m, c) / most, phong_ndf(wh, m, c) * wh.z.powi(4) / most],
                phong_masking(c) / sum,
                [wide.weight, narrow.weight, wide.s.x / c.x.max(1e-8), narrow.s.y / c.y.max(1e-8), c.z / sum]
            ]
        },
    );
}

#[test]
fn visible_fresnel_parity() {
    parity::<8>(
        "visible/fresnel",
        // Seen along the thin axis of a nearly one-dimensional surface, wo.S.wo cancels: 1.4e-4 at worst.
        Tolerance { relative: 2e-4, floor: |_| 1.0, unit: |_| 0.0 },
        |r| join(&[&r.direction().to_array(), &r.mean_slope().to_array(), &r.covariance().to_array()]),
        |x| {
            let (wo, m, s, f0) = (v3(x, 0), v2(x, 3), clamp_covariance(v3(x, 5)), DVec3::new(0.0, 0.04, 0.5));
            let index = complex_index(f0, DVec3::new(0.0, 0.0, 3.0));
            list![visible_fresnel(wo, m, s, f0), visible_fresnel_exact(wo, m, s, f0, &index)]
        },
    );
}

#[test]
fn clear_coat_parity() {
    parity::<15>(
        "visible/clear_coat",
        Tolerance { relative: 3e-4, floor: |_| 1.0, unit: |_| 0.0 },
        |r| {
            let (wo, m, s) = (r.direction().to_array(), r.mean_slope().to_array(), r.covariance().to_array());
            let shares = [r.range(0.01, 1.0), r.range(0.0, 1.0), r.range(0.0, 1.0), r.range(0.0, 1.0)];
            join(&[&wo, &m, &s, &shares, &r.direction().to_array()])
        },
        |x| {
            let (s, weight, exact) = (clamp_covariance(v3(x, 5)), x[8], x[11] > 0.5);
            list![
                [
                    coat_reflectance(v3(x, 0), v2(x, 3), s, weight, exact),
                    coat_facet_reflectance(x[9], weight, exact),
                    coat_average(weight, exact),
                ],
                coated_base(x[9], x[10], x[11], DVec3::new(0.0, 0.5, 0.9)),
                coat_reflectances(v3(x, 0), v3(x, 12), v2(x, 3), s, weight, exact).to_array(),
                coat_bands(weight, exact),
            ]
        },
    );
}

#[test]
fn transmission_parity() {
    parity::<13>(
        "visible/transmission",
        // Near total reflection, a root magnifies rounding errors of directions.
        Tolerance { relative: 3e-3, floor: |_| 1.0, unit: |_| 0.0 },
        |r| {
            // Facets in front of the viewer, near the mean normal.
            let (w, offset) = (above(r), above(r));
            let n = DVec3::from(w) + 0.9 * DVec3::from(above(r));
            let facet = (n.normalize() + 0.2 * DVec3::from(offset)).normalize();
            let numbers = [r.range(1.05, 2.5), r.range(0.0, 0.2), r.range(0.0, 1.0), r.range(0.0, 1.0)];
            join(&[&w, &facet.to_array(), &n.normalize().to_array(), &numbers])
        },
        |x| {
            let (w, facet, eta) = (v3(x, 0), v3(x, 3), x[9]);
            let cosine = w.dot(facet);
            list![
                [refracted_cosine(cosine, eta)],
                refracted(w, facet, eta),
                passed_solid(w, facet, v3(x, 6), eta),
                [refracted_variance(x[10], cosine, eta), thin_variance(x[11], cosine)],
                attenuation(DVec3::new(0.0, 1.0, 5.0), x[12]),
            ]
        },
    );
}

#[test]
fn ggx_lobes_parity() {
    parity::<12>(
        "integrals/ggx_lobes",
        Tolerance {
            relative: 5e-5,
            floor: |k| {
                if k == 2 {
                    1.0
                } else if k < 18 {
                    1e-6
                } else {
                    1e-3
                }
            },
            unit: |_| 1e-3,
        },
        |r| {
            let (wo, wi) = (r.direction(), r.direction());
            let tail = [r.log(0.02, 1.0)];
            join(&[&wo.to_array(), &wi.to_array(), &r.mean_slope().to_array(), &r.covariance().to_array(), &tail])
        },
        |x| {
            let (wo, wi, m) = (v3(x, 0), v3(x, 3), v2(x, 6));
            let d = displaced_ggx(DVec3::new(x[11] * x[11], x[11] * x[11], 0.0), v3(x, 8));
            let cholesky = slope_cholesky(0.5 * d.roughness);
            let o = displaced_ggx_area(wo, m, &d, cholesky);
            let mut all = vec![o.spread, o.visible];
            for k in 0..GGX_LOBES {
                let lobe = ggx_lobe(&d, k);
                all.push(lobe.weight);
                all.extend(lobe.s.to_array());
            }
            for shadowing in [Shadowing::None, Shadowing::Smith, Shadowing::Correlated] {
                let f0 = DVec3::new(0.04, 0.5, 1.0);
                let light = displaced_ggx_light(shadowing, &o, wo, wi, m, &d, cholesky, f0);
                all.extend([light.x, light.y]);
            }
            all
        },
    );
}
