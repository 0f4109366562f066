//! Functions of a covariance do not panic on NaN, and return NaN.

use glam::{DMat2, DVec2, DVec3};
use leadr_maps::Moments;
use leadr_reflectance::facets::beckmann::{Beckmann, beckmann_ndf, beckmann_p22, beckmann_vndf};
use leadr_reflectance::facets::beckmann_sampling::beckmann_sample_visible;
use leadr_reflectance::facets::ggx::{Ggx, ggx_ndf, ggx_p22};
use leadr_reflectance::facets::ggx_sampling::ggx_sample_visible;
use leadr_reflectance::facets::projected_area::{face_viewer, slope_spread, visible_area};
use leadr_reflectance::facets::slope_distribution::SlopeDistribution as _;
use leadr_reflectance::integrals::diffuse::{leadr_diffuse_light, visible_normal_moments};
use leadr_reflectance::integrals::specular::{leadr_specular_directional, leadr_specular_environment};
use leadr_reflectance::masking::correlated::{direction_area, lit_fraction};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::masking::smith::{masking, masking_shadowing, shadowing_given_masking, smith_lambda};
use leadr_reflectance::slopes::geometric_antialiasing::{filter_covariance, half_vector_kernel, tilt_kernel};
use leadr_reflectance::slopes::grid::{slope_cholesky, slope_sample};
use leadr_reflectance::slopes::map::{SlopeMap, map_covariance};
use leadr_reflectance::slopes::statistics::{clamp_covariance, covariance_from_moments};
use leadr_reflectance::visible::diffuse::{clamped_product, leadr_diffuse_light_visible, visible_diffuse_moments};
use leadr_reflectance::visible::fresnel::visible_fresnel;
use leadr_reflectance::visible::shadowed_environment::bent_normal;
use leadr_reflectance::visible::shadowed_specular::visible_specular_environment;
use leadr_reflectance::visible::slopes::visible_slopes;
use leadr_reflectance::visible::specular::probe_rule;

/// Returns the results of every function that takes a covariance, by name.
fn results(s: DVec3) -> Vec<(&'static str, DVec3)> {
    let (wo, wi) = (DVec3::new(0.3, 0.4, 0.7).normalize(), DVec3::new(-0.5, 0.2, 0.8).normalize());
    let (m, f0, one) = (DVec2::new(0.2, -0.1), DVec3::splat(0.04), |x: f64| DVec3::splat(x));
    let two = |x: DVec2| x.extend(x.x);
    let wh = (wo + wi).normalize();
    let map = SlopeMap { linear: DMat2::from_cols_array(&[1.3, -0.4, 0.8, 0.6]), offset: m };
    let cholesky = slope_cholesky(s);
    let [o, i] = [wo, wi].map(|w| direction_area(w, m, cholesky));
    let visible = visible_slopes(wo, m, s);
    let moments = visible_diffuse_moments(wo, m, s, 2);
    let texel = |s: DVec3| Moments { second: [s.x as f32, s.y as f32], cross: s.z as f32, ..Moments::default() };
    let mut all = vec![
        ("clamp_covariance", clamp_covariance(s)),
        ("covariance_from_moments", covariance_from_moments(m, s)),
        ("Moments::slope_covariance", DVec3::from(texel(s).slope_covariance())),
        ("map_covariance", map_covariance(&map, s)),
        ("half_vector_kernel", half_vector_kernel(wh, s, DVec3::X)),
        ("tilt_kernel", tilt_kernel(s, m)),
        ("filter_covariance", filter_covariance(s, DVec3::new(0.1, 0.1, 0.0))),
        ("slope_cholesky", cholesky),
        ("slope_sample", two(slope_sample(DVec2::new(0.3, 0.4), m, s))),
        ("slope_spread", one(slope_spread(wo, s))),
        ("visible_area", one(visible_area(wo, m, s))),
        ("smith_lambda", one(smith_lambda(wo, m, s))),
        ("masking", one(masking(wo, m, s))),
        ("masking_shadowing", one(masking_shadowing(wo, wi, m, s, true))),
        ("shadowing_given_masking", one(shadowing_given_masking(wo, wi, m, s, true))),
        ("beckmann_p22", one(beckmann_p22(m, m, s))),
        ("beckmann_ndf", one(beckmann_ndf(wh, m, s))),
        ("beckmann_vndf", one(beckmann_vndf(wo, wh, m, s))),
        ("ggx_p22", one(ggx_p22(DVec2::new(0.5, 0.5), m, s))),
        ("ggx_ndf", one(ggx_ndf(wh, m, s))),
        ("Beckmann", one(Beckmann::new(m, s).ndf(wh))),
        ("Ggx", one(Ggx::new(m, s).ndf(wh))),
        ("visible_slopes mean", two(visible.mean)),
        ("visible_slopes cov", visible.cov),
        ("visible_slopes area", one(visible.area)),
        ("visible_fresnel", visible_fresnel(wo, m, s, f0)),
        ("visible_diffuse_moments", moments.mean + moments.diag + moments.off),
        ("clamped_product", one(clamped_product(0.3, s.x + s.y + s.z, 0.2, 0.1, 0.0))),
        ("leadr_diffuse_light_visible", one(leadr_diffuse_light_visible(wo, wi, m, s, true, 2))),
        ("leadr_diffuse_light", one(leadr_diffuse_light(wo, wi, m, s, true, 5, 1.8))),
        ("visible_normal_moments", visible_normal_moments(wo, m, s, 5, 1.8).mean),
        ("leadr_specular_directional", leadr_specular_directional(wo, wi, m, s, f0, true)),
        ("bent_normal", bent_normal(&o, m, cholesky).normal),
        ("beckmann_sample_visible", beckmann_sample_visible(wo, DVec2::new(0.3, 0.6), m, s)),
        ("ggx_sample_visible", ggx_sample_visible(wo, DVec2::new(0.3, 0.6), m, s)),
        ("face_viewer", two(face_viewer(DVec3::new(0.9, 0.0, -0.3), DVec2::ZERO, s, 2.0))),
    ];
    for shadowing in Shadowing::ALL {
        let radiance = DVec3::ONE;
        let grid = leadr_specular_environment(shadowing, wo, m, s, f0, 5, 1.8, |e| radiance + 0.0 * e.wi);
        let probes = visible_specular_environment(shadowing, wo, m, s, f0, probe_rule(16), |p| radiance + 0.0 * p.wi);
        all.push(("leadr_specular_environment", grid.reflected));
        all.push(("visible_specular_environment", probes.reflected));
        if !matches!(shadowing, Shadowing::None | Shadowing::NormalMap | Shadowing::VGroove) {
            all.push(("lit_fraction", one(lit_fraction(shadowing, &o, &i))));
        }
    }
    all
}

#[test]
fn nan_covariance_gives_nan_without_panic() {
    let sound = DVec3::new(0.3, 0.2, 0.1);
    for (name, value) in results(sound) {
        assert!(value.is_finite(), "{name} is {value} for a sound covariance");
    }
    let nan = f64::NAN;
    let mut swallowed = Vec::new();
    for s in [DVec3::new(nan, 0.2, 0.1), DVec3::new(0.3, nan, 0.1), DVec3::new(0.3, 0.2, nan), DVec3::splat(nan)] {
        swallowed.extend(
            results(s).into_iter().filter(|(_, value)| !value.is_nan()).map(|(name, v)| format!("{name}({s}) = {v}")),
        );
    }
    assert!(swallowed.is_empty(), "{} results hide the NaN:\n{}", swallowed.len(), swallowed.join("\n"));
}
