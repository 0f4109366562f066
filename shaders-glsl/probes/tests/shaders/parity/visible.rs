//! The visible-slope rules on the device against their f64 twins.

use super::comparator::{Arguments as _, Numbers, Tolerance, join, list, parity, v2, v3};
use super::extremes::finite;
use glam::{DVec2, DVec3};
use leadr_reflectance::facets::complex_index::complex_index;
use leadr_reflectance::facets::fresnel::fresnel_schlick;
use leadr_reflectance::facets::normal_distribution::normal_ramp;
use leadr_reflectance::facets::projected_area::{meso_area, slope_spread};
use leadr_reflectance::frame::frame_about;
use leadr_reflectance::integrals::facet_specular::{facet_specular, facet_specular_density, facet_visibility};
use leadr_reflectance::integrals::sh::sh_add_light;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::grid::slope_cholesky;
use leadr_reflectance::slopes::statistics::{add_roughness, clamp_covariance};
use leadr_reflectance::visible::diffuse::{clamped_product, leadr_diffuse_light_visible, visible_diffuse_moments};
use leadr_reflectance::visible::horizon::{
    Horizon, diffuse_past_horizon, horizon_excess, horizon_hidden, horizon_visibility,
};
use leadr_reflectance::visible::kernel::kernel_lod;
use leadr_reflectance::visible::mapped::{
    mapped_diffuse_light, mapped_diffuse_moments, mapped_fresnel, mapped_fresnel_exact, mapped_slopes,
    mapped_specular_light,
};
use leadr_reflectance::visible::slopes::{VISIBLE_TAIL, visible_slopes};
use leadr_reflectance::visible::specular::{
    VisibleProbe, mapped_probes, probe_rule, towards_viewer, visible_probe, visible_probes,
};
use leadr_testing::gpu::test_gpu;

/// A viewer and slopes. With `tilted`, also mesosurfaces that face away so far that the rules tilt them back; these have no
/// singular covariances, for which only rounding errors would remain.
fn surface(r: &mut Random, tilted: bool) -> (DVec3, DVec2, DVec3) {
    loop {
        let (wo, m, s) = (r.direction(), r.mean_slope(), r.covariance());
        let regular = s.z * s.z < 0.98 * s.x * s.y;
        if tilted && regular || meso_area(wo, m) > 2e-3 - 0.95 * VISIBLE_TAIL * slope_spread(wo, clamp_covariance(s)) {
            return (wo, m, s);
        }
    }
}

fn slopes_parity(tilted: bool, relative: f64) {
    parity::<8>(
        "visible/slopes",
        // The third moment is a difference of terms of magnitude 10.
        Tolerance {
            relative,
            floor: |k| [1e-3, 1e-2, 0.1, 1.0][[3, 7, 12].iter().filter(|&&t| k >= t).count()],
            unit: |_| 0.0,
        },
        |r| {
            let (wo, m, s) = surface(r, tilted);
            join(&[&wo.to_array(), &m.to_array(), &s.to_array()])
        },
        |x| {
            let s = v3(x, 5);
            let v = visible_slopes(v3(x, 0), v2(x, 3), s);
            let cov = v.cov / (s.x + s.y).max(1e-8);
            let ramp = normal_ramp(x[3]).ramp;
            list![[v.a, v.b, v.area], v.axis, v.mean, cov, [v.facet, v.variance, v.third, ramp]]
        },
    );
}

#[test]
fn visible_slopes_parity() {
    slopes_parity(false, 2e-4);
    slopes_parity(true, 1e-3);
}

fn diffuse_parity(tilted: bool, relative: f64) {
    parity::<12>(
        "visible/diffuse",
        Tolerance { relative, floor: |k| if k == 11 { 0.1 } else { 1e-2 }, unit: |_| 0.0 },
        |r| {
            let ((wo, m, s), wi) = (surface(r, tilted), r.direction());
            join(&[&wo.to_array(), &wi.to_array(), &m.to_array(), &s.to_array(), &[r.pick([2.0, 3.0])]])
        },
        |x| {
            let (wo, wi, m, s, terms) = (v3(x, 0), v3(x, 3), v2(x, 6), v3(x, 8), x[11].round() as u32);
            let v = visible_diffuse_moments(wo, m, s, terms);
            let product = clamped_product(m.x, s.x.abs(), m.y, s.y.abs(), wi.x * s.x * s.y);
            let light = |shadowing| leadr_diffuse_light_visible(wo, wi, m, s, shadowing, terms);
            list![v.mean, v.diag, v.off, [light(false), light(true), product]]
        },
    );
}

#[test]
fn visible_diffuse_parity() {
    diffuse_parity(false, 5e-5);
    diffuse_parity(true, 2e-3);
}

fn specular_parity(tilted: bool, relative: f64) {
    parity::<9>(
        "visible/specular",
        // The level of detail; directions, where mean slopes of 8 nearly cancel.
        Tolerance {
            relative,
            floor: if tilted {
                |k| if k == 8 || (1..4).contains(&k) || (11..14).contains(&k) { 1.0 } else { 0.1 }
            } else {
                |k| if k == 8 { 1.0 } else { 0.1 }
            },
            unit: |_| 0.0,
        },
        |r| {
            let (wo, m, s) = surface(r, tilted);
            join(&[&wo.to_array(), &m.to_array(), &s.to_array(), &[r.pick([3.0, 5.0, 9.0, 16.0])]])
        },
        |x| {
            let (wo, m, s) = (v3(x, 0), v2(x, 3), v3(x, 5));
            let rule = probe_rule(x[8].round() as u32);
            let probes = visible_probes(Shadowing::None, wo, m, s, rule.kernel);
            let rotated = |node| if rule.nodes(0.0).count() == 3 { towards_viewer(&probes, wo, &node) } else { node };
            let all: Vec<_> = rule.nodes(probes.wide).map(|node| visible_probe(&probes, wo, &rotated(node))).collect();
            let last = all[all.len() - 1];
            let mean = |f: &dyn Fn(&VisibleProbe) -> DVec3| all.iter().map(|p| p.weight * f(p)).sum::<DVec3>();
            list![
                [mean(&|_| DVec3::ONE).x],
                mean(&|p| p.wi),
                mean(&|p| fresnel_schlick(DVec3::new(0.04, 0.5, 1.0), p.cosine)),
                [mean(&|p| DVec3::splat(p.cosine)).x, mean(&|p| DVec3::splat(kernel_lod(p.variance, 256.0))).x],
                (last.slope - m) / (s.x + s.y).max(1e-8).sqrt(),
                last.wi,
                [probes.area]
            ]
        },
    );
}

#[test]
fn visible_specular_parity() {
    specular_parity(false, 1.3e-3);
    specular_parity(true, 7e-3);
}

/// Normal maps and their bases. Probes, specular term and light in the order of `visible/mapped.comp`.
#[test]
fn mapped_parity() {
    parity::<12>(
        "visible/mapped",
        Tolerance { relative: 2e-3, floor: |k| if k == 25 { 1.0 } else { 0.1 }, unit: |_| 0.0 },
        |r| {
            let ((wo, m, s), wi) = (surface(r, false), r.direction());
            join(&[&wo.to_array(), &wi.to_array(), &m.to_array(), &s.to_array(), &[r.log(0.05, 1.0)]])
        },
        |x| {
            let (wo, wi, m, relief, alpha) = (v3(x, 0), v3(x, 3), v2(x, 6), v3(x, 8), x[11]);
            let all = add_roughness(relief, alpha);
            let v = mapped_slopes(wo, m, relief, all);
            let n = mapped_diffuse_moments(m, relief, 2);
            let rule = probe_rule(5);
            let probes = mapped_probes(wo, &v, rule.kernel);
            let found: Vec<_> = rule.nodes(probes.wide).map(|node| visible_probe(&probes, wo, &node)).collect();
            let mean = |f: &dyn Fn(&VisibleProbe) -> DVec3| found.iter().map(|p| p.weight * f(p)).sum::<DVec3>();
            let f = facet_specular(wo, wi, alpha, 0.0);
            let mapped = Shadowing::NormalMap;
            let f0 = DVec3::new(0.0, 0.04, 0.5);
            list![
                [v.facing, v.relief],
                v.slopes.mean,
                v.slopes.cov / (all.x + all.y).max(1e-8),
                [v.slopes.facet, v.slopes.variance, v.slopes.area, mapped_fresnel(&v, DVec3::splat(0.04)).x],
                n.mean,
                n.diag,
                n.off,
                [mapped_diffuse_light(wi, m, relief, 2)],
                [mapped_specular_light(wo, wi, m, all, DVec3::splat(0.04)).x],
                mean(&|p| p.wi),
                [mean(&|p| DVec3::splat(kernel_lod(p.variance, 256.0))).x, mean(&|p| DVec3::splat(p.cosine)).x],
                [facet_specular_density(&f, m, slope_cholesky(relief), mapped)],
                [facet_visibility(mapped, wo.z, wi.z, wo.dot(wi), f.base)],
                mapped_fresnel_exact(&v, f0, &complex_index(f0, DVec3::splat(3.0)))
            ]
        },
    );
    let Some(gpu) = test_gpu() else { return };
    finite::<12, 1>(&gpu, &mut Random(13), "visible/mapped", 32, 2, |r| [r.log(1e-3, 1.0) as f32]);
}

/// Results are finite even for unreasonable arguments.
#[test]
fn finite_at_the_extremes() {
    let Some(gpu) = test_gpu() else { return };
    let r = &mut Random(7);
    finite::<8, 0>(&gpu, r, "visible/slopes", 14, 1, |_| []);
    finite::<12, 1>(&gpu, r, "visible/diffuse", 12, 2, |r| [r.pick([2.0, 3.0]) as f32]);
    finite::<9, 1>(&gpu, r, "visible/specular", 15, 1, |r| [r.pick([3.0, 5.0, 9.0, 16.0]) as f32]);
}

#[test]
fn horizon_parity() {
    parity::<11>(
        "visible/horizon",
        Tolerance { relative: 1e-3, floor: |_| 0.1, unit: |_| 0.0 },
        |r| {
            let (m, spread) = (r.mean_slope(), r.covariance());
            let lean = r.mean_slope() * r.log(1e-3, 1.0);
            let deviation = r.log(0.01, 1.0);
            join(&[&r.direction().to_array(), &m.to_array(), &lean.to_array(), &spread.to_array(), &[deviation]])
        },
        |x| {
            let (wi, m, h) = (v3(x, 0), v2(x, 3), Horizon { lean: v2(x, 5), spread: v3(x, 7) });
            let excess = horizon_excess(wi.truncate(), &h);
            let hidden = horizon_hidden(m, &h);
            let mut c = [DVec3::ZERO; 9];
            c[0] = DVec3::new(2.0, 1.5, 1.0);
            sh_add_light(&mut c, DVec3::new(0.6, 0.0, 0.8), DVec3::new(1.0, 2.0, 3.0));
            let radiance = diffuse_past_horizon(DVec3::new(2.0, 0.5, 0.1), 0.8, &hidden, m, &frame_about(wi), &c);
            let visibility = horizon_visibility(wi, m, &h, x[10]);
            list![[excess, visibility], hidden.weight, [hidden.angle], radiance]
        },
    );
    let Some(gpu) = test_gpu() else { return };
    finite::<11, 0>(&gpu, &mut Random(11), "visible/horizon", 9, 1, |_| []);
}
