//! Prints the tables of docs/measurements/quadrature.md: the errors of the paper's grids and of the visible-slope rules against converged
//! integrals, the samplers that the papers compare with, what they print about their grid, and the largest steps between frames of slow sweeps.
//!
//! `cargo run --release --example 07_quadrature [SURFACES [specular|diffuse|light|samplers|printed|lod|oren-nayar|micronormal|sweeps|rational]]`

use leadr::reflectance::integrals::specular::{LOD_ALGORITHM_1, LOD_MATCHED, LOD_SUPPLEMENT, LOD_SUPPLEMENT_5};
use leadr_lab::brdf_fit_study::{Domain, FitRow, domain_rows};
use leadr_lab::oren_nayar_study::{SIGMAS, oren_nayar_row};
use leadr_lab::quadrature_study::Row;
use leadr_lab::quadrature_study::diffuse::DiffuseSet;
use leadr_lab::quadrature_study::light::LightSet;
use leadr_lab::quadrature_study::micronormal::micronormal_row;
use leadr_lab::quadrature_study::specular::{Sharpness, SpecularSet};
use leadr_lab::quadrature_study::sweep::{lod_bends, sweep_rows};

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
    if wanted("samplers") {
        print(&format!("samplers, diffuse, {n} surfaces x 16 environments"), &DiffuseSet::new(n, 16, 1).sampler_rows());
        print(&format!("samplers, one light on diffuse facets, {n} surfaces"), &LightSet::new(n, 1).sampler_rows());
        for (sharpness, name) in [(Sharpness::Smooth, "smooth"), (Sharpness::Sharp, "sharp")] {
            let set = SpecularSet::new(n, sharpness, 1);
            print(&format!("samplers, specular, {name} lobes, {n} surfaces"), &set.sampler_rows());
            print(&format!("constants of the level of detail, {name} lobes, {n} surfaces"), &set.lod_rows());
        }
    }
    if wanted("printed") {
        print(&format!("the printed grid, diffuse, {n} surfaces"), &DiffuseSet::new(n, 16, 1).printed_rows());
        print(&format!("the printed grid, one light, {n} surfaces"), &LightSet::new(n, 1).printed_rows());
        for (sharpness, name) in [(Sharpness::Smooth, "smooth"), (Sharpness::Sharp, "sharp")] {
            let set = SpecularSet::new(n, sharpness, 1);
            print(&format!("the printed grid, specular, {name} lobes, {n} surfaces"), &set.printed_rows());
        }
    }
    if wanted("lod") {
        println!("\nlargest second difference along slow sweeps of the 5x5 grid: constant, smooth lobes, sharp lobes");
        for constant in [LOD_SUPPLEMENT_5, LOD_MATCHED, LOD_SUPPLEMENT, LOD_ALGORITHM_1] {
            let [smooth, sharp] = lod_bends((n / 150).max(8), constant);
            println!("{constant} {smooth:.1e} {sharp:.1e}");
        }
    }
    if wanted("oren-nayar") {
        println!("\nLEADR's diffuse term and Oren-Nayar 1994");
        println!("sigma | one bounce: rms, max | both: rms, max | best tilt, rms | Lambert: rms | retro at 60 degrees");
        for sigma in SIGMAS {
            let r = oren_nayar_row(sigma);
            println!(
                "{sigma} | {:.4} {:.4} | {:.4} {:.4} | {:.3} {:.4} | {:.4} | {:.3?}",
                r.first[0], r.first[1], r.both[0], r.both[1], r.best[0], r.best[1], r.lambert, r.retro
            );
        }
    }
    if wanted("micronormal") {
        println!("\nback-facing mesonormals of a sphere: artificial micronormal, face_viewer, tilt_to_edge");
        println!("sigma relief | pixels away black | different | rms: specular, light | rms error of specular");
        for relief in [0.0, 0.3] {
            for sigma in [0.05, 0.2, 0.5] {
                let r = micronormal_row(sigma, relief, 1);
                println!("{sigma} {relief} | {} {} {}", r.pixels, r.away, r.black);
                for e in r.remedies {
                    println!("    {:>4} | {:.4} {:.4} | {:.4}", e.different, e.difference[0], e.difference[1], e.error);
                }
            }
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
    // Fits of hundreds of coefficients take minutes, so only this word starts them.
    if only.as_deref() == Some("rational") {
        for domain in Domain::ALL {
            println!("\nrational fits of the diffuse term, {domain:?}, {} surfaces, errors over {n} others", 4 * n);
            println!("{}", FitRow::HEADER);
            for row in domain_rows(domain, 4 * n, n) {
                println!("{}", row.line());
            }
        }
    }
}
