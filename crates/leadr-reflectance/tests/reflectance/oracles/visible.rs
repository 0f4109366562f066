//! Compares the visible-slope rules with an independent dense quadrature (`crates/leadr-testing/data/leadr_integrals.json`), the oracle.

use glam::{DVec2, DVec3};
use leadr_reflectance::frame::Frame;
use leadr_reflectance::integrals::diffuse::{leadr_diffuse_environment, leadr_diffuse_light_sh};
use leadr_reflectance::integrals::sh::Sh9;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_reflectance::visible::diffuse::{leadr_diffuse_light_visible, visible_diffuse_moments};
use leadr_reflectance::visible::shadowed_specular::visible_specular_environment;
use leadr_reflectance::visible::specular::{VisibleProbe, probe_rule};
use leadr_testing::comparison::{number, oracle, rows, smooth, vector};
use serde_json::Value;
use std::f64::consts::PI;

/// The rms error and the largest error.
#[derive(Default)]
struct Errors {
    square: f64,
    worst: f64,
    n: f64,
}

impl Errors {
    fn add(&mut self, error: f64) {
        self.square += error * error;
        self.worst = self.worst.max(error.abs());
        self.n += 1.0;
    }

    fn check(&self, what: &str, rms: f64, worst: f64) {
        let got = (self.square / self.n).sqrt();
        println!("{what}: rms {got:.2e}, worst {:.2e} of {}", self.worst, self.n);
        assert!(self.n > 40.0 && got < rms && self.worst < worst, "{what} exceeds {rms:.1e}, {worst:.1e}");
        assert!(got > 0.5 * rms, "{what}: the bound {rms:.1e} is too loose");
    }
}

/// Returns the viewer, mean slope, covariance and data entry of each configuration.
fn configurations(data: &Value) -> Vec<(DVec3, DVec2, DVec3, &Value)> {
    rows(&data["configs"])
        .iter()
        .map(|c| {
            let (sx, sy) = (number(&c["sigma_x"]), number(&c["sigma_y"]));
            let s = DVec3::new(sx * sx, sy * sy, number(&c["c_xy"]));
            (vector(&c["o"]), DVec2::new(number(&c["mean_x"]), number(&c["mean_y"])), s, c)
        })
        .collect()
}

#[test]
fn diffuse() {
    let data = oracle("leadr_integrals.json");
    let sh: Vec<f64> = rows(&data["sh_smooth"]).iter().map(number).collect();
    let sh: Sh9 = std::array::from_fn(|i| DVec3::splat(sh[i]));
    let frame = Frame { x: DVec3::X, y: DVec3::Y, z: DVec3::Z };
    for (terms, environment, light) in [(2, (6e-4, 2.6e-3), (1.7e-3, 7.5e-3)), (3, (5e-5, 1.5e-4), (1.8e-4, 7.5e-4))] {
        let (mut env, mut sun, mut by_sh) = (Errors::default(), Errors::default(), Errors::default());
        for (wo, m, s, c) in configurations(&data) {
            let wi = vector(&c["light"]);
            let v = visible_diffuse_moments(wo, m, s, terms);
            env.add(
                leadr_diffuse_environment(&v, &frame, &sh, DVec3::ZERO).x - number(&c["diffuse_sh"]["smooth_mask"]),
            );
            for (key, shadowing) in [("mask", false), ("shadow", true)] {
                let i = leadr_diffuse_light_visible(wo, wi, m, s, shadowing, terms);
                sun.add(PI * (i - number(&c["diffuse_directional"][key])));
                let i = leadr_diffuse_light_sh(&v, wo, wi, m, s, shadowing);
                let want = number(&c["diffuse_sh"][&format!("dirlight_{key}")]);
                // This library clamps the radiance at 0, but the oracle does not.
                by_sh.add(PI * (i - want.max(0.0)));
            }
        }
        env.check(&format!("environment, {terms} terms"), environment.0, environment.1);
        sun.check(&format!("light, {terms} terms"), light.0, light.1);
        by_sh.check(&format!("light by harmonics, {terms} terms"), light.0, light.1);
    }
}

/// Evaluates the oracle's polynomial, filtered like a probe lookup. The kernel scales band `l` by `exp(−v l (l + 1)/2)`.
fn smooth_lookup(p: &VisibleProbe) -> DVec3 {
    let v = p.variance;
    let (one, two) = ((-v).exp(), (-3.0 * v).exp());
    let first = 0.4 * p.wi.x - 0.25 * p.wi.y + 0.3 * p.wi.z;
    DVec3::splat(1.0 + one * first + two * (smooth(p.wi) - 1.0 - first))
}

/// Tests the directions and weights of the probes in a smooth environment with closed-form filtering.
#[test]
fn specular() {
    let data = oracle("leadr_integrals.json");
    for (n, bound) in [(5, (1.95e-2, 0.06)), (9, (1.15e-2, 0.039)), (16, (6.1e-3, 0.023))] {
        let rule = probe_rule(n);
        let mut errors = Errors::default();
        for (wo, m, s, c) in configurations(&data) {
            let i =
                visible_specular_environment(Shadowing::None, wo, m, s, DVec3::ONE, rule, smooth_lookup).reflected.x;
            errors.add(i - number(&c["specular_env"]["smooth"]["mask"]));
            let i =
                visible_specular_environment(Shadowing::Smith, wo, m, s, DVec3::ONE, rule, |_| DVec3::ONE).reflected;
            assert!((0.0..=1.0 + 1e-7).contains(&i.x), "shadowing must only remove light");
        }
        errors.check(&format!("specular, smooth environment, {n} probes"), bound.0, bound.1);
    }
}

/// Tests the probes with Smith shadowing, in a smooth environment and in a white room. The white room gives the mean lit fraction of the
/// visible facets.
#[test]
fn shadowed_specular() {
    let data = oracle("leadr_integrals.json");
    let cases = [
        (5, (2.8e-2, 0.07), (2.5e-2, 0.077)),
        (9, (1.4e-2, 0.046), (1.4e-2, 0.046)),
        (16, (1.15e-2, 0.039), (1.1e-2, 0.034)),
    ];
    for (n, smooth_bound, white_bound) in cases {
        let (mut smooth, mut white) = (Errors::default(), Errors::default());
        for (wo, m, s, c) in configurations(&data) {
            let reflected = |lookup: fn(&VisibleProbe) -> DVec3| {
                visible_specular_environment(Shadowing::Smith, wo, m, s, DVec3::ONE, probe_rule(n), lookup).reflected.x
            };
            smooth.add(reflected(smooth_lookup) - number(&c["specular_env"]["smooth"]["shadow"]));
            white.add(reflected(|_| DVec3::ONE) - number(&c["specular_env"]["const"]["shadow"]));
        }
        smooth.check(&format!("shadowed specular, smooth environment, {n} probes"), smooth_bound.0, smooth_bound.1);
        white.check(&format!("shadowed specular, white room, {n} probes"), white_bound.0, white_bound.1);
    }
}
