//! Fits the wide lobes' nodes of `reflectance::visible_specular` again, with the two constants of `reflectance::shadowed_specular`,
//! and prints them as they stand in the code, with their errors over the surfaces of the fit and over others. The nodes for
//! narrow lobes are held; `Free::narrow` would fit them too, which was tried and not better everywhere (docs/quadrature.md).
//!
//! `cargo run --release --example 12_fit_probes [SEED [SURFACES]]`

use leadr::reflectance::quadrature_study::fit_probes::{
    Free, ProbeTraining, Ring, RingRule, fit_probes, plain_rings, rings_of,
};
use leadr::reflectance::shadowed_specular::{LIFT, PART};
use leadr::reflectance::visible_specular::{ProbeNode, ProbeRule, probe_rule};
use std::f64::consts::TAU;

fn print(name: &str, rings: &[Ring], nodes: &[ProbeNode]) {
    println!("    {name}");
    for r in rings {
        println!("        {} at {:.3}, phase {:.3}", r.count, r.radius, r.phase.rem_euclid(TAU / r.count as f64));
    }
    for n in nodes {
        println!("        node({:.7}, {:.7}, {:.9}, {:.4}),", n.place.x, n.place.y, n.weight, n.cover);
    }
}

/// Errors over the surfaces of the fit and over others: radiance without shadows, with them, what is lit of a white room,
/// Fresnel term.
fn print_errors(name: &str, sets: [&ProbeTraining; 2], rule: ProbeRule<'_>, shadows: [f64; 2]) {
    let [here, there] = sets.map(|set| set.error(rule, shadows));
    println!("{name}: {here:.3?}, other surfaces {there:.3?}");
}

fn main() {
    let number = |i: usize, or: u64| std::env::args().nth(i).and_then(|s| s.parse().ok()).unwrap_or(or);
    let (seed, n) = (number(1, 300), number(2, 2500) as usize);
    let set = |ordinary, rough, seed| ProbeTraining::new(ordinary, rough, seed);
    let (training, others) = (set(n / 5, n, seed), set(n / 10, n / 2, seed + 1000));
    let sets = [&training, &others];

    let narrow = rings_of(&[1, 6, 9], probe_rule(16).narrow);
    let start = RingRule { narrow, wide: plain_rings(&[1, 6, 9, 9], &[0.0, 0.7, 1.3, 2.0]), shadows: [1.0, 2.0] };
    let fitted = fit_probes(&training, &start, Free { narrow: false, wide: true, shadows: true }, 40);
    for (name, rule) in [("16 probes, 25 in wide lobes: start", &start), ("fitted", &fitted)] {
        let (narrow, wide) = rule.nodes();
        print_errors(name, sets, ProbeRule { narrow: &narrow, wide: &wide }, rule.shadows);
    }
    print_errors("in use", sets, probe_rule(16), [PART, LIFT]);
    println!("    shadows: part {:.3}, lift {:.3}", fitted.shadows[0], fitted.shadows[1]);
    let (_, wide) = fitted.nodes();
    print("wide lobes", &fitted.wide, &wide);
}
