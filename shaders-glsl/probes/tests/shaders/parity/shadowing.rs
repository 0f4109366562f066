//! The device's direction-correlated masking and shadowed environments against the f64 reference. `parity/comparator.rs`
//! describes the comparison.

use super::comparator::{Arguments as _, Numbers, Tolerance, join, list, parity, v2, v3};
use super::extremes::finite;
use glam::{DVec2, DVec3};
use leadr_reflectance::facets::projected_area::meso_area;
use leadr_reflectance::frame::frame_about;
use leadr_reflectance::integrals::sh::sh_add_light;
use leadr_reflectance::masking::correlated::{direction_area, lit_fraction, masking_shadowing_factor};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::random::Random;
use leadr_reflectance::slopes::grid::slope_cholesky;
use leadr_reflectance::visible::grazing::grazing_lobe;
use leadr_reflectance::visible::horizon::Horizon;
use leadr_reflectance::visible::shadowed_environment::{
    bent_normal, shadowed_diffuse_environment, visible_slope_shift,
};
use leadr_reflectance::visible::shadowed_specular::{lit_probe, visible_specular_environment};
use leadr_reflectance::visible::slopes::visible_slopes;
use leadr_reflectance::visible::specular::{VisibleProbe, probe_rule, visible_probes};
use leadr_testing::gpu::test_gpu;

/// Two directions: any, equal, or with the same or opposite azimuths (ρ = ±1 on an isotropic surface).
fn pair(r: &mut Random, s: DVec3) -> (DVec3, DVec3) {
    let wo = r.direction();
    let wi = match (r.unit() * 12.0) as u32 {
        0 => wo,
        1 => -wo,
        k @ 2..6 => {
            // Exactly the same or the opposite azimuth, or slightly off.
            let side = if k % 2 == 0 { 1.0 } else { -1.0 };
            let off = if k < 4 { 0.0 } else { r.log(1e-6, 0.3) };
            let c = slope_cholesky(s);
            let p = side * DVec2::new(c.x * wo.x + c.y * wo.y, c.z * wo.y);
            let rotated = DVec2::from_angle(off).rotate(p) * r.log(0.1, 10.0);
            let y = rotated.y / c.z.max(1e-9);
            let x = (rotated.x - c.y * y) / c.x.max(1e-9);
            DVec3::new(x, y, r.range(-0.1, 1.0)).clamp_length(1e-6, 1e6).normalize()
        }
        _ => r.direction(),
    };
    (wo, wi)
}

#[test]
fn correlated_masking_parity() {
    parity::<11>(
        "masking/correlated",
        Tolerance { relative: 5e-6, floor: |k| if k < 5 { 1e-6 } else { 1e-4 }, unit: |_| 0.0 },
        |r| {
            let (m, s) = (r.mean_slope(), r.covariance());
            let (wo, wi) = pair(r, s);
            join(&[&wo.to_array(), &wi.to_array(), &m.to_array(), &s.to_array()])
        },
        |x| {
            let (wo, wi, m, s) = (v3(x, 0), v3(x, 3), v2(x, 6), v3(x, 8));
            let cholesky = slope_cholesky(s);
            let (o, i) = (direction_area(wo, m, cholesky), direction_area(wi, m, cholesky));
            let lit = Shadowing::ALL.map(|v| lit_fraction(v, &o, &i));
            let factors =
                [Shadowing::Correlated, Shadowing::CorrelatedSimple].map(|v| masking_shadowing_factor(v, &o, &i));
            let round = slope_cholesky(DVec2::splat(s.x.max(1e-6)).extend(0.0));
            let (round_o, round_i) = (direction_area(wo, m, round), direction_area(wi, m, round));
            let round =
                [Shadowing::Smith, Shadowing::Correlated, Shadowing::CorrelatedSimple, Shadowing::SmithSeparable]
                    .map(|v| lit_fraction(v, &round_o, &round_i));
            list![o.whitened, [o.spread, o.meso, o.visible], lit, factors, round]
        },
    );
}

#[test]
fn shadowed_environment_parity() {
    parity::<8>(
        "visible/shadowed_environment",
        // Seen along the thin axis of a nearly one-dimensional surface, wo.S.wo cancels: 3.4e-4 at worst.
        Tolerance { relative: 4e-4, floor: |k| if k < 2 { 1e-2 } else { 0.1 }, unit: |_| 0.0 },
        |r| join(&[&r.direction().to_array(), &r.mean_slope().to_array(), &r.covariance().to_array()]),
        |x| {
            let (wo, m, s) = (v3(x, 0), v2(x, 3), v3(x, 5));
            let cholesky = slope_cholesky(s);
            let o = direction_area(wo, m, cholesky);
            let v = bent_normal(&o, m, cholesky);
            let mut c = [DVec3::ZERO; 9];
            c[0] = DVec3::new(2.0, 1.5, 1.0);
            sh_add_light(&mut c, DVec3::new(0.6, 0.0, 0.8), DVec3::new(1.0, 2.0, 3.0));
            let radiance = shadowed_diffuse_environment(&v, &frame_about(wo), &c, DVec3::new(0.1, -0.2, 0.3));
            list![visible_slope_shift(&o, cholesky), v.normal, [v.open], radiance]
        },
    );
}

#[test]
#[ignore = "long"]
fn shadowed_specular_parity() {
    parity::<12>(
        "visible/shadowed_specular",
        // Seen from straight above, the azimuth consists of rounding errors.
        Tolerance { relative: 1e-3, floor: |_| 0.1, unit: |_| 0.3 },
        |r| {
            // From behind its own horizon, a mesosurface is lit or not by the sign of a height, which rounding decides.
            let (wo, wi, m, s) = loop {
                let (m, s) = (r.mean_slope(), r.covariance());
                let (wo, wi) = pair(r, s);
                if meso_area(wo, m) > 0.01 && wo.truncate().length() > 0.02 {
                    break (wo, wi, m, s);
                }
            };
            join(&[&wo.to_array(), &wi.to_array(), &m.to_array(), &s.to_array(), &[r.log(1e-6, 2.0)]])
        },
        |x| {
            let (wo, wi, m, s) = (v3(x, 0), v3(x, 3), v2(x, 6), v3(x, 8));
            let probes = visible_probes(Shadowing::Smith, wo, m, s, probe_rule(16).kernel);
            let o = direction_area(wo, probes.m, probes.cholesky);
            let any = VisibleProbe { slope: DVec2::ZERO, mirror: wi, wi, cosine: 0.0, weight: 0.0, variance: x[11] };
            let lit = [Shadowing::Smith, Shadowing::Correlated, Shadowing::CorrelatedSimple]
                .map(|v| lit_probe(v, &probes, &o, wo, 0.04, &any, None));
            let h = Horizon { lean: m * 0.5, spread: DVec3::new(s.x, s.y, 0.0) };
            let past = lit_probe(Shadowing::Smith, &probes, &o, wo, 0.04, &any, Some(&h)).lit;
            let white = [5, 9, 16].map(|n| {
                let (v, rule) = (Shadowing::Correlated, probe_rule(n));
                visible_specular_environment(v, wo, m, s, DVec3::ONE, rule, |_| DVec3::ONE).reflected.x
            });
            list![lit.map(|l| l.lit), [lit[0].grazing], lit[0].wi, [probes.lit.mean, past], white]
        },
    );
}

#[test]
fn grazing_parity() {
    parity::<9>(
        "visible/grazing",
        Tolerance { relative: 1e-3, floor: |_| 0.1, unit: |_| 0.1 },
        |r| {
            // Of mesosurfaces that face away, only facets in the tails of the density are visible.
            let (wo, m, s) = loop {
                let (wo, m, s) = (r.direction(), r.mean_slope(), r.covariance());
                if meso_area(wo, m) > 0.01 && wo.truncate().length() > 0.02 {
                    break (wo, m, s);
                }
            };
            join(&[&wo.to_array(), &m.to_array(), &s.to_array(), &[r.log(1e-4, 1.0)]])
        },
        |x| {
            let (wo, m, base) = (v3(x, 0), v2(x, 3), x[8]);
            let v = visible_slopes(wo, m, v3(x, 5) + DVec3::new(base, base, 0.0));
            let up = (-0.5 * m).extend(1.0).normalize();
            let g = grazing_lobe(Shadowing::Correlated, wo, &v, up, base);
            list![[g.weight], g.weight * g.wi, [g.weight * g.variance, g.weight * g.spread]]
        },
    );
}

/// Results are finite even for unreasonable arguments.
#[test]
fn finite_at_the_extremes() {
    let Some(gpu) = test_gpu() else { return };
    let r = &mut Random(7);
    finite::<11, 0>(&gpu, r, "masking/correlated", 15, 2, |_| []);
    finite::<8, 0>(&gpu, r, "visible/shadowed_environment", 9, 1, |_| []);
    finite::<9, 1>(&gpu, r, "visible/grazing", 6, 1, |r| [r.log(1e-6, 4.0) as f32]);
    finite::<12, 1>(&gpu, r, "visible/shadowed_specular", 12, 2, |r| [r.log(1e-6, 4.0) as f32]);
}
