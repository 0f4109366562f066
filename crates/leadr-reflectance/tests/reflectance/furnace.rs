//! Tests the white furnace: without shadowing and Fresnel, LEADR eq. 16 integrates to one over all light directions, for every view and
//! slope distribution. With shadowing the integral is less than one. Bounds are two-sided. The integration is over the sphere of `wi`, so
//! it does not depend on the renderer's change of variables to slopes.

use std::f64::consts::PI;

use glam::{DVec2, DVec3};
use leadr_reflectance::facets::projected_area::{face_viewer, meso_area, visible_area};
use leadr_reflectance::integrals::specular::leadr_specular_directional;
use leadr_reflectance::quadrature::composite_gauss;
use rayon::prelude::*;

/// Computes `∫ I(wo, wi) dwi` over the whole sphere, in polar coordinates about `wo`. The solid angle is `dwi = 4 cos θ_h dwh`, where `θ_h`
/// is the angle between `wo` and `wh`, so the integral covers every `wh` with `θ_h < 90°`.
fn albedo(wo: DVec3, m: DVec2, s: DVec3, shadowing: bool, panels: usize) -> f64 {
    let frame = leadr_reflectance::frame::frame_about(wo);
    let mut sum = 0.0;
    for (theta, wt) in composite_gauss(0.0, 0.5 * PI, panels, 8) {
        let (sin, cos) = theta.sin_cos();
        let mut ring = 0.0;
        for (phi, wp) in composite_gauss(0.0, 2.0 * PI, 2 * panels, 8) {
            let wh = frame.x * (sin * phi.cos()) + frame.y * (sin * phi.sin()) + wo * cos;
            let wi = 2.0 * cos * wh - wo;
            ring += wp * leadr_specular_directional(wo, wi, m, s, DVec3::ONE, shadowing).x;
        }
        sum += wt * sin * 4.0 * cos * ring;
    }
    sum
}

fn configurations() -> Vec<(DVec3, DVec2, DVec3)> {
    let mut all = Vec::new();
    for (sx, sy, r) in [(0.1, 0.1, 0.0), (0.5, 0.5, 0.0), (1.0, 0.4, 0.5), (0.15, 0.6, -0.8), (2.0, 2.0, 0.0)] {
        for m in [DVec2::ZERO, DVec2::new(0.5, -0.3), DVec2::new(-1.5, 1.0), DVec2::new(0.0, 3.0)] {
            for degrees in [0.0f64, 30.0, 60.0, 75.0, 85.0, 89.0] {
                for azimuth in [0.3f64, 2.5] {
                    let (sin, cos) = degrees.to_radians().sin_cos();
                    let wo = DVec3::new(sin * azimuth.cos(), sin * azimuth.sin(), cos);
                    let s = DVec3::new(sx * sx, sy * sy, r * sx * sy);
                    // Visible areas below MIN_AREA are divided by MIN_AREA, which would give an integral below one. Like the renderer, this
                    // test first tilts such mesosurfaces towards the viewer.
                    let seen = visible_area(wo, m, s) > 1e-5;
                    all.push((wo, if seen { m } else { face_viewer(wo, m, s, 1.8) }, s));
                }
            }
        }
    }
    all
}

#[test]
#[ignore = "long"]
fn masking_alone_conserves_energy() {
    let all = configurations();
    let away = all.iter().filter(|(wo, m, _)| meso_area(*wo, *m) < 0.0).count();
    let errors: Vec<(f64, String)> = all
        .par_iter()
        .map(|&(wo, m, s)| {
            let a = albedo(wo, m, s, false, 40);
            (a - 1.0, format!("wo {wo}, m {m}, S {s}"))
        })
        .collect();
    let low = errors.iter().min_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    let high = errors.iter().max_by(|a, b| a.0.total_cmp(&b.0)).unwrap();
    println!("{} configurations, {away} with a back-facing mesosurface", all.len());
    println!("lowest energy 1 {:+.2e} at {}\nhighest energy 1 {:+.2e} at {}", low.0, low.1, high.0, high.1);
    assert!(away > 20);
    assert!(low.0 > -1e-3 && high.0 < 1e-3);
}

#[test]
fn shadowing_only_removes_energy() {
    let (mut lowest, mut darkest) = (1.0f64, String::new());
    for (wo, m, s) in configurations().into_iter().step_by(3) {
        let a = albedo(wo, m, s, true, 30);
        assert!((0.0..1.0 + 2e-3).contains(&a), "energy {a} at wo {wo}, m {m}, S {s}");
        if a < lowest {
            (lowest, darkest) = (a, format!("wo {wo}, m {m}, S {s}"));
        }
    }
    println!("lowest energy with shadowing {lowest:.4} at {darkest}");
    // A nearly smooth surface has almost no shadowing.
    let wo = DVec3::new(0.6, 0.0, 0.8);
    let a = albedo(wo, DVec2::ZERO, DVec3::new(0.01, 0.01, 0.0), true, 60);
    assert!((a - 1.0).abs() < 2e-3, "{a}");
}

/// The furnace must detect a missing Λ, and a σ that is used as α.
#[test]
fn wrong_masking_term_is_detected() {
    let (wo, m, s) = (DVec3::new(0.995, 0.0, 0.1).normalize(), DVec2::new(0.1, 0.0), DVec3::new(0.25, 0.25, 0.0));
    let right = albedo(wo, m, s, false, 60);
    let area = visible_area(wo, m, s);
    let without_lambda = right * area / meso_area(wo, m);
    let alpha_for_sigma = right * area / visible_area(wo, m, 2.0 * s);
    assert!((right - 1.0).abs() < 1e-3);
    assert!((without_lambda - 1.0).abs() > 0.1 && (alpha_for_sigma - 1.0).abs() > 0.1);
}
