//! Fits the rings for wide lobes of `reflectance::visible::specular` again, with the two constants of
//! `reflectance::visible::shadowed_specular`, and prints them in the form the code has them, with their errors over the
//! surfaces of the fit and over others. The rings for narrow lobes stay fixed (docs/measurements/quadrature.md).
//!
//! `cargo run --release --example 12_fit_probes [SEED [SURFACES]]`

use leadr::lab::quadrature_study::fit_probes::{ProbeTraining, WideProbes, fit_probes};
use leadr::reflectance::visible::shadowed_specular::{LIFT, PART};
use leadr::reflectance::visible::specular::{WideRing, probe_rule};

/// Errors over the surfaces of the fit and over others: radiance without shadows, with shadows, the lit part of a white room,
/// the Fresnel term.
fn print_errors(name: &str, sets: [&ProbeTraining; 2], wide: &WideProbes) {
    let [here, there] = sets.map(|set| set.error(probe_rule(16).nodes, wide));
    println!("{name}: {here:.3?}, other surfaces {there:.3?}");
}

fn main() {
    let number = |i: usize, or: u64| std::env::args().nth(i).and_then(|s| s.parse().ok()).unwrap_or(or);
    let (seed, n) = (number(1, 300), number(2, 2500) as usize);
    let set = |ordinary, rough, seed| ProbeTraining::new(ordinary, rough, seed);
    let (training, others) = (set(n / 5, n, seed), set(n / 10, n / 2, seed + 1000));
    let sets = [&training, &others];

    let nodes = probe_rule(16).nodes;
    let ring = |(count, radius, weight, cover)| WideRing { count, radius, weight, cover };
    let rings = [(1, 1.0, 0.1, 0.05), (6, 0.9, 0.07, 0.05), (9, 0.9, 0.05, 0.25)].map(ring).to_vec();
    let start = WideProbes { rings, shadows: [1.0, 2.0] };
    let fitted = fit_probes(&training, nodes, &start, 40);
    for (name, probes) in [("start", &start), ("fitted", &fitted)] {
        print_errors(name, sets, probes);
    }
    let in_use = WideProbes { rings: probe_rule(16).wide.to_vec(), shadows: [PART, LIFT] };
    print_errors("in use", sets, &in_use);
    for r in &fitted.rings {
        println!("    ring({}, {:.4}, {:.7}, {:.4}),", r.count, r.radius, r.weight, r.cover);
    }
    println!("    shadows: part {:.3}, lift {:.3}", fitted.shadows[0], fitted.shadows[1]);
}
