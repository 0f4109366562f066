//! Prints the tables of docs/measurements/shadowing.md, with the errors of the shadowing models and of shadowed environments compared with
//! ray casts. The example needs no data.
//!
//! `cargo run --release --example 09_shadowing_errors [seed]`

use glam::{DVec2, DVec3};
use leadr_lab::ray_cast::Spectrum;
use leadr_lab::shadowed_reference::Surface;
use leadr_lab::shadowing_errors::{ShadowingSettings, lit_facets, shadowing_errors};

fn main() {
    let seed = std::env::args().nth(1).map_or(1, |s| s.parse().expect("the seed is a whole number"));
    let isotropic = |sigma: f64| (DVec2::ZERO, DVec3::new(sigma * sigma, sigma * sigma, 0.0));
    let surfaces = [
        ("σ 0.05", isotropic(0.05), Spectrum::Gaussian),
        ("σ 0.25", isotropic(0.25), Spectrum::Gaussian),
        ("σ 0.5", isotropic(0.5), Spectrum::Gaussian),
        ("σ 1", isotropic(1.0), Spectrum::Gaussian),
        ("σ 1.5", isotropic(1.5), Spectrum::Gaussian),
        ("σ 0.2, 0.8", (DVec2::ZERO, DVec3::new(0.04, 0.64, 0.0)), Spectrum::Gaussian),
        ("σ 0.4, 0.05", (DVec2::ZERO, DVec3::new(0.16, 0.0025, 0.0)), Spectrum::Gaussian),
        ("σ 1, 0.25", (DVec2::ZERO, DVec3::new(1.0, 0.0625, 0.0)), Spectrum::Gaussian),
        (
            "σ 0.7, 0.5, r 0.6, mean 0.3, −0.2",
            (DVec2::new(0.3, -0.2), DVec3::new(0.49, 0.25, 0.21)),
            Spectrum::Gaussian,
        ),
        ("waves σ 0.5", isotropic(0.5), Spectrum::Ring),
        ("waves σ 1", isotropic(1.0), Spectrum::Ring),
    ];
    for (name, (m, s), spectrum) in surfaces {
        println!("{name}: relative RMSE % (bias %, at the rim %)");
        let rows = shadowing_errors(Surface { m, s }, &ShadowingSettings { spectrum, seed, ..Default::default() });
        let mut light = None;
        for row in rows {
            if light != Some(row.light) {
                print!("{}  {:?}: ", if light.is_some() { "\n" } else { "" }, row.light);
                light = Some(row.light);
            }
            let e = row.error;
            print!("{:?} {:.1} ({:+.1}, {:+.1})  ", row.model, 100.0 * e.rmse, 100.0 * e.bias, 100.0 * e.rim_bias);
        }
        println!();
        if m == DVec2::ZERO {
            let settings = ShadowingSettings { spectrum, seed: seed + 1, ..Default::default() };
            print!("  Light on visible facets, casts (model): ");
            for degrees in [15.0, 45.0, 75.0] {
                let l = lit_facets(s, degrees, &settings);
                print!("{degrees}° open {:.3} ({:.3}) bend {:.3} ({:.3})  ", l.open.0, l.open.1, l.bend.0, l.bend.1);
            }
            println!();
        }
    }
}
