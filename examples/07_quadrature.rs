//! The tables of docs/quadrature.md: errors of the paper's grids and of the visible-slope rules against converged
//! integrals, and the largest steps of slow sweeps.
//!
//! `cargo run --release --example 07_quadrature [SURFACES [specular|diffuse|light|sweeps]]`

use leadr::reflectance::quadrature_study::Row;
use leadr::reflectance::quadrature_study::diffuse::DiffuseSet;
use leadr::reflectance::quadrature_study::light::LightSet;
use leadr::reflectance::quadrature_study::specular::{Sharpness, SpecularSet};

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
}
