//! Tests the properties of every slope distribution: `D` projects to one, visible normals integrate to one, and so does the white furnace
//! without shadowing (LEADR eq. 16). The tests cover Beckmann and GGX at every angle, with strong mean slopes and correlations near one.
//! Bounds are two-sided, and the tests print the worst errors.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use leadr_reflectance::facets::beckmann::Beckmann;
use leadr_reflectance::facets::ellipse::{Bivariate, Ellipse, bivariate_from_ellipse};
use leadr_reflectance::facets::ggx::Ggx;
use leadr_reflectance::facets::slope_distribution::SlopeDistribution;
use leadr_reflectance::frame::frame_about;
use leadr_reflectance::quadrature::composite_gauss;
use leadr_testing::standard::{Seen, direction, surfaces};
use rayon::prelude::*;

/// Integrates `f(wn)` over the solid angle of all normals with `wo·wn > 0`.
fn over_visible(seen: &Seen<'_>, f: impl Fn(DVec3) -> f64) -> f64 {
    let nodes = composite_gauss(0.0, 1.0, 24, 8);
    let mut sum = 0.0;
    for &(u, wu) in &nodes {
        for &(v, wv) in &nodes {
            let (p, area) = seen.from_square(DVec2::new(u, v));
            let (wn, solid_angle) = seen.normal(p);
            sum += wu * wv * area * solid_angle * f(wn);
        }
    }
    sum
}

/// The lowest and the highest deviation from one, each with its configuration.
#[derive(Clone, Debug)]
struct Range(f64, String, f64, String);

impl Range {
    fn of(errors: impl ParallelIterator<Item = (f64, String)>) -> Self {
        errors
            .map(|(e, at)| Self(e, at.clone(), e, at))
            .reduce_with(|a, b| {
                let (low, high) = (if a.0 < b.0 { &a } else { &b }, if a.2 > b.2 { &a } else { &b });
                Self(low.0, low.1.clone(), high.2, high.3.clone())
            })
            .expect("there are configurations")
    }

    fn check(&self, name: &str, bound: f64) {
        println!("{name}: 1 {:+.1e} ({}) to 1 {:+.1e} ({})", self.0, self.1, self.2, self.3);
        assert!(self.0 > -bound && self.2 < bound, "{name}: {self:?}");
    }
}

const ANGLES: [f64; 9] = [0.0, 15.0, 30.0, 45.0, 60.0, 75.0, 85.0, 88.0, 89.0];

fn both(m: DVec2, s: DVec3) -> (Beckmann, Ggx) {
    (Beckmann::new(m, s), Ggx::new(m, s))
}

#[test]
fn distributions_project_to_one() {
    let errors = surfaces().into_par_iter().flat_map_iter(|(m, s)| {
        let (beckmann, ggx) = both(m, s);
        // At normal incidence no facet is masked.
        let b = over_visible(&Seen::beckmann(&beckmann, DVec3::Z), |n| n.z * beckmann.ndf(n));
        let g = over_visible(&Seen::ggx(&ggx, DVec3::Z), |n| n.z * ggx.ndf(n));
        [(b - 1.0, format!("Beckmann {m} {s}")), (g - 1.0, format!("GGX {m} {s}"))]
    });
    Range::of(errors).check("∫ D cos θ dω", 1e-9);
}

#[test]
fn visible_normals_integrate_to_one() {
    let cases: Vec<_> =
        surfaces().into_iter().flat_map(|(m, s)| ANGLES.map(|t| (m, s, direction(t, 40.0 + 3.0 * t)))).collect();
    let away = cases.iter().filter(|(m, _, wo)| wo.z - wo.x * m.x - wo.y * m.y < 0.0).count();
    // Below ν = −10, less than 1e-26 of a Beckmann surface is visible.
    let errors = |use_ggx: bool| {
        cases.par_iter().filter_map(move |&(m, s, wo)| {
            let (beckmann, ggx) = both(m, s);
            let seen = if use_ggx { Seen::ggx(&ggx, wo) } else { Seen::beckmann(&beckmann, wo) };
            let counts = use_ggx || seen.nu > -10.0;
            let at = format!("ν {:.1} m {m} S {s} wo {wo:.2}", seen.nu);
            counts.then(|| (over_visible(&seen, |n| seen.distribution.vndf(wo, n)) - 1.0, at))
        })
    };
    let counted = errors(false).count();
    println!("{} configurations, {away} with a back-facing mesosurface; Beckmann is visible in {counted}", cases.len());
    assert!(away > 40 && counted > 200);
    Range::of(errors(false)).check("Beckmann: visible normals", 1e-9);
    Range::of(errors(true)).check("GGX: visible normals", 1e-9);
}

/// Computes `∫ D(wh) / (4 A(wo)) dwi` over the whole sphere of light directions, in polar coordinates about the viewer. The integral is
/// split where half vectors reach the horizon, because the noncentral GGX does not vanish there.
fn furnace(d: &dyn SlopeDistribution, wo: DVec3, panels: usize) -> f64 {
    let frame = frame_about(wo);
    let (up, horizon) = (frame.y.z.atan2(frame.x.z), frame.x.z.hypot(frame.y.z));
    let area = d.visible_area(wo);
    let touch = 0.5 * PI - wo.z.acos();
    let mut sum = 0.0;
    for (low, high) in [(0.0, touch), (touch, 0.5 * PI)] {
        for (theta, wt) in composite_gauss(low, high, panels, 8) {
            let (sin, cos) = theta.sin_cos();
            let half = (-wo.z * cos / (horizon * sin).max(1e-12)).clamp(-1.0, 1.0).acos();
            for (phi, wp) in composite_gauss(up - half, up + half, panels, 8) {
                let wh = frame.x * (sin * phi.cos()) + frame.y * (sin * phi.sin()) + wo * cos;
                // The solid angles are related by dwi = 4 cos θ dwh.
                sum += wt * wp * sin * 4.0 * cos * d.ndf(wh) / (4.0 * area);
            }
        }
    }
    sum
}

#[test]
fn white_furnace() {
    let mut cases = Vec::new();
    for e in [(0.4, 0.4, 0.0), (1.0, 0.3, 0.6), (0.3, 0.8, -1.2), (2.0, 2.0, 0.0)] {
        let e = Ellipse { radii: DVec2::new(e.0, e.1), angle: e.2 };
        for m in [DVec2::ZERO, DVec2::new(0.5, -0.3), DVec2::new(-1.5, 1.0)] {
            for t in ANGLES {
                let wo = direction(t, 20.0 + t);
                cases.push((Beckmann::from_ellipse(m, &e), Ggx::from_ellipse(m, &e), wo));
            }
        }
    }
    let beckmann = cases.par_iter().filter(|c| c.0.visible_area(c.2) > 1e-6);
    Range::of(beckmann.map(|(d, _, wo)| (furnace(d, *wo, 32) - 1.0, format!("{d:?} {wo:.2}"))))
        .check("Beckmann: white furnace", 1e-4);
    let ggx = cases.par_iter().map(|(_, d, wo)| (furnace(d, *wo, 32) - 1.0, format!("{d:?} {wo:.2}")));
    Range::of(ggx).check("GGX: white furnace", 1e-4);
}

/// The integrals must detect a missing `Λ`, a wrong roughness factor, and a missing correlation.
#[test]
fn wrong_areas_fail() {
    let (m, s, wo) = (DVec2::new(0.3, 0.1), DVec3::new(0.3, 0.2, 0.1), direction(80.0, 60.0));
    let (beckmann, ggx) = both(m, s);
    for seen in [Seen::beckmann(&beckmann, wo), Seen::ggx(&ggx, wo)] {
        let d = seen.distribution;
        let area = d.visible_area(wo);
        let right = over_visible(&seen, |n| d.vndf(wo, n));
        assert!((right - 1.0).abs() < 1e-9);
        let uncorrelated = both(m, DVec3::new(s.x, s.y, 0.0));
        let rougher = both(m, 1.1 * s);
        for wrong in [
            d.meso_area(wo),
            uncorrelated.0.visible_area(wo),
            uncorrelated.1.visible_area(wo),
            rougher.0.visible_area(wo),
            rougher.1.visible_area(wo),
        ] {
            assert!((right * area / wrong - 1.0).abs() > 5e-3, "{wrong} for {area}");
        }
    }
}

#[test]
fn parameterisations_describe_one_surface() {
    let e = Ellipse { radii: DVec2::new(0.9, 0.2), angle: 0.8 };
    let b = bivariate_from_ellipse(&e);
    let m = DVec2::new(0.1, -0.4);
    let slope = DVec2::new(0.5, 0.2);
    // The expected value is derived by hand from the slopes along and across the major axis, with α² = 2σ².
    let d = slope - m;
    let (u, v) = ((d.x * 0.8f64.cos() + d.y * 0.8f64.sin()) / 0.9, (d.y * 0.8f64.cos() - d.x * 0.8f64.sin()) / 0.2);
    let q = u * u + v * v;
    let plain = Bivariate::new(b.alpha, b.rho);
    for d in [Beckmann::from_ellipse(m, &e), Beckmann::from_bivariate(m, &b), Beckmann::from_bivariate(m, &plain)] {
        assert!((d.p22(slope) / ((-q).exp() / (PI * 0.18)) - 1.0).abs() < 1e-12);
        let (first, second) = d.moments();
        assert!((Beckmann::from_moments(first, second).covariance() - d.covariance()).length() < 1e-15);
    }
    for d in [Ggx::from_ellipse(m, &e), Ggx::from_bivariate(m, &b), Ggx::from_bivariate(m, &plain)] {
        assert!((d.p22(slope) * PI * 0.18 * (1.0 + q).powi(2) - 1.0).abs() < 1e-12);
    }
    assert!((Beckmann::isotropic(m, 0.4).covariance().x - 0.08).abs() < 1e-15);
    assert_eq!(Ggx::isotropic(m, 0.5).roughness(), DVec3::new(0.25, 0.25, 0.0));
}
