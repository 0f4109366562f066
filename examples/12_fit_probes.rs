//! Fits the nodes of `reflectance::visible_specular` again, with the two constants of `reflectance::shadowed_specular`, and prints
//! their errors over the surfaces of the fit and over others, and the tables as they stand in the code.
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

fn main() {
    let number = |i: usize, or: u64| std::env::args().nth(i).and_then(|s| s.parse().ok()).unwrap_or(or);
    let (seed, n) = (number(1, 300), number(2, 600) as usize);
    let extra: usize = number(3, 9) as usize;
    let (training, others) = (ProbeTraining::new(n, n, seed), ProbeTraining::new(n, n, seed + 1000));
    let mut shadows = [1.0, 2.0];
    // The greatest first: its shadows are those of all.
    for (counts, narrow, wide) in [
        (vec![1, 6, 9, extra], vec![0.0, 1.0, 1.97], vec![0.0, 0.7, 1.3, 2.0]),
        (vec![4, 5], vec![0.79, 1.9], vec![0.7, 1.7]),
        (vec![1, 4], vec![0.0, 1.66], vec![0.0, 1.5]),
    ] {
        let size: usize = counts[..narrow.len()].iter().sum();
        let narrow = rings_of(&counts[..narrow.len()], probe_rule(size as u32).narrow);
        let start = RingRule { narrow, wide: plain_rings(&counts, &wide), shadows };
        let free = Free { narrow: false, wide: true, shadows: size == 16 };
        let fitted = fit_probes(&training, &start, free, 40);
        shadows = fitted.shadows;
        let print_errors = |name: &str, rule: ProbeRule<'_>, shadows| {
            let (here, there) = (training.error(rule, shadows), others.error(rule, shadows));
            println!("{size} probes, {name}: {here:.4?}, other surfaces {there:.4?}");
        };
        for (name, rule) in [("start", &start), ("fitted", &fitted)] {
            let (narrow, wide) = rule.nodes();
            print_errors(name, ProbeRule { narrow: &narrow, wide: &wide }, rule.shadows);
        }
        print_errors("in use", probe_rule(size as u32), [PART, LIFT]);
        println!("    shadows: part {:.3}, lift {:.3}", shadows[0], shadows[1]);
        let (narrow, wide) = fitted.nodes();
        print("narrow", &fitted.narrow, &narrow);
        print("wide", &fitted.wide, &wide);
    }
}
