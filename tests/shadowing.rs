//! Direction-correlated shadowing and shadowed environments: what must hold whatever the constants, and the models' own errors
//! against ray casts (`LEADR_SHARED/oracles`; skipped, with a line that says so, where they are absent).

#[path = "oracles/comparison.rs"]
mod comparison;
#[path = "shadowing/model.rs"]
mod model;

use comparison::{number, oracle};
use glam::{DVec2, DVec3};
use leadr::reflectance::correlated_masking::Visibility;
use model::Surface;
use rayon::prelude::*;
use serde_json::Value;
use std::collections::BTreeMap;

fn smooth(d: DVec3) -> f64 {
    1.0 + 0.4 * d.x - 0.25 * d.y + 0.3 * d.z + 0.2 * d.y * d.z + 0.15 * (d.x * d.x - d.y * d.y)
}

/// Relative root mean square errors in percent, by surface and quantity.
#[derive(Default)]
struct Errors(BTreeMap<(String, &'static str), Vec<f64>>);

impl Errors {
    fn add(&mut self, surface: &str, quantity: &'static str, got: f64, want: f64) {
        self.0.entry((surface.to_owned(), quantity)).or_default().push(got / want - 1.0);
    }

    fn rms(&self, surface: &str, quantity: &'static str) -> f64 {
        let values = &self.0[&(surface.to_owned(), quantity)];
        100.0 * (values.iter().map(|e| e * e).sum::<f64>() / values.len() as f64).sqrt()
    }
}

/// One line of the file: a surface from one direction.
fn patch_errors(row: &Value) -> Vec<(String, &'static str, f64, f64)> {
    let name = format!("{} {} {} m {}", row["kind"].as_str().unwrap(), row["sigma_x"], row["sigma_y"], row["mean_x"]);
    let wo = model::direction(number(&row["theta_o"]), number(&row["phi_o"]));
    let side = model::direction(45.0, number(&row["phi_o"]) + 90.0);
    let opposite = model::direction(60.0, number(&row["phi_o"]) + 180.0);
    let stats = row["stats"].as_array().unwrap();
    let surfaces: Vec<Surface> = stats
        .iter()
        .map(|s| {
            let (x, y) = (number(&s["sigma_x"]), number(&s["sigma_y"]));
            Surface {
                m: DVec2::new(number(&s["mean_x"]), number(&s["mean_y"])),
                s: DVec3::new(x * x, y * y, number(&s["c_xy"])),
            }
        })
        .collect();
    let mean = |f: &dyn Fn(&Surface) -> f64| surfaces.iter().map(f).sum::<f64>() / surfaces.len() as f64;
    let truth = |key: &str| number(&row["measured"][key]["shadow"][0]);
    let mut out = Vec::new();
    for (light, wi, names) in [
        ("diffuse_dir_front", wo, ["front smith", "front full", "front simple"]),
        ("diffuse_dir_side45", side, ["side smith", "side full", "side simple"]),
        ("diffuse_dir_opp60", opposite, ["opposite smith", "opposite full", "opposite simple"]),
    ] {
        for (visibility, quantity) in
            [Visibility::Smith, Visibility::Correlated, Visibility::CorrelatedSimple].into_iter().zip(names)
        {
            let got = mean(&|s| s.diffuse_light(visibility, wo, wi));
            out.push((name.clone(), quantity, got, truth(light)));
        }
    }
    for (key, radiance, names) in [
        ("const", (|_| 1.0) as fn(DVec3) -> f64, ["constant masking", "constant bent"]),
        ("smooth", smooth, ["smooth masking", "smooth bent"]),
    ] {
        let want = truth(&format!("diffuse_env_{key}"));
        let sh = model::order_two(radiance);
        out.push((name.clone(), names[0], mean(&|s| s.diffuse_environment_masked(wo, &sh)), want));
        out.push((name.clone(), names[1], mean(&|s| s.diffuse_environment(wo, &sh)), want));
    }
    for (key, radiance, names) in [
        ("const", (|_| 1.0) as fn(DVec3) -> f64, ["mirror masking", "mirror smith", "mirror full", "mirror simple"]),
        ("smooth", smooth, ["glossy masking", "glossy smith", "glossy full", "glossy simple"]),
    ] {
        let want = truth(&format!("spec_env_{key}"));
        for (visibility, quantity) in
            [Visibility::Masking, Visibility::Smith, Visibility::Correlated, Visibility::CorrelatedSimple]
                .into_iter()
                .zip(names)
        {
            out.push((name.clone(), quantity, mean(&|s| s.specular_environment(visibility, wo, radiance)), want));
        }
    }
    out
}

#[test]
fn patches() {
    let Some(data) = oracle("patch_ground_truth.json") else { return };
    let rows: Vec<&Value> = ["gauss", "ring"].iter().flat_map(|k| data[*k].as_array().unwrap()).collect();
    let all: Vec<_> = rows.par_iter().map(|row| patch_errors(row)).collect();
    let mut errors = Errors::default();
    for (surface, quantity, got, want) in all.into_iter().flatten() {
        errors.add(&surface, quantity, got, want);
    }
    let surfaces: std::collections::BTreeSet<String> = errors.0.keys().map(|k| k.0.clone()).collect();
    let quantities: std::collections::BTreeSet<&'static str> = errors.0.keys().map(|k| k.1).collect();
    for surface in &surfaces {
        println!("{surface}");
        for quantity in &quantities {
            print!("  {quantity} {:.2}", errors.rms(surface, quantity));
        }
        println!();
    }
}
