//! Prints the tables of docs/measurements/quadrature.md: the errors of the paper's grids and of the visible-slope rules against converged
//! integrals, and the largest steps between frames of slow sweeps.
//!
//! `cargo run --release --example 07_quadrature [SURFACES [specular|diffuse|light|sweeps]]`

use leadr_lab::quadrature_study::Row;
use leadr_lab::quadrature_study::diffuse::DiffuseSet;
use leadr_lab::quadrature_study::light::LightSet;
use leadr_lab::quadrature_study::specular::{Sharpness, SpecularSet};
use leadr_lab::quadrature_study::sweep::sweep_rows;

fn print(title: &str, rows: &[Row]) {
    println!("\n{title}\n{}", Row::HEADER);
    for row in rows {
        println!("{}", row.line());
    }
}

fn main() {
    let mut arguments = std::env::args().skip(1);
    let n: usize = arguments.next().and_then(|n| n.parse().ok()).unwrap_or(3000);
    let only = arguments.next();
    let wanted = |what: &str| only.as_deref().is_none_or(|o| o == what);
    if wanted("diffuse") {
        print(&format!("diffuse, {n} surfaces x 16 environments"), &DiffuseSet::new(n, 16, 1).rows());
    }
    if wanted("light") {
        print(&format!("one light on diffuse facets, {n} surfaces"), &LightSet::new(n, 1).rows());
    }
    if wanted("specular") {
        for (sharpness, name) in [(Sharpness::Smooth, "smooth"), (Sharpness::Sharp, "sharp")] {
            print(&format!("specular, {name} lobes, {n} surfaces"), &SpecularSet::new(n, sharpness, 1).rows());
        }
    }
    if wanted("sweeps") {
        let starts = (n / 150).max(8);
        println!("\nlargest step and second difference along slow sweeps, {starts} starts");
        println!("{:<11} {:<13} {:<16} {:>8} {:>8}", "path", "integral", "rule", "step", "second");
        for r in sweep_rows(starts) {
            let (step, bend) = (r.steps.step, r.steps.bend);
            println!("{:<11} {:<13} {:<16} {step:>8.1e} {bend:>8.1e}", r.path.name(), r.integral, r.rule);
        }
    }
}
