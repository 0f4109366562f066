//! Refits the rings for wide lobes of `reflectance::visible::specular`. Prints them next to the current rings, with the errors of both over
//! the fitted surfaces and over other surfaces. The rings for narrow lobes do not change (docs/measurements/quadrature.md).
//!
//! `cargo run --release --example 12_fit_probes [SEED [SURFACES]]`

use leadr::reflectance::visible::specular::probe_rule;
use leadr_lab::quadrature_study::fit_probes::{FittedRule, ProbeTraining, fit_probes};

fn main() {
    let number = |i: usize, or: u64| std::env::args().nth(i).and_then(|s| s.parse().ok()).unwrap_or(or);
    let (seed, n) = (number(1, 300), number(2, 1000) as usize);
    let set = |rough: usize, seed| ProbeTraining::new(rough / 5, rough, seed);
    let sets = [set(n, seed), set(n / 2, seed + 1000)];
    println!("errors: directional light, with shadows, lobes, with shadows, lit fraction, Fresnel term");
    for probes in [5, 9, 16] {
        let rule = probe_rule(probes);
        let in_use = FittedRule { kernel: rule.kernel, rings: rule.rings.to_vec() };
        let mut start = in_use.clone();
        start.rings.iter_mut().for_each(|r| r.wide = r.narrow);
        let fitted = fit_probes(&sets[0], &start, 30);
        for (name, rule) in [("as if narrow", &start), ("fitted", &fitted), ("in use", &in_use)] {
            let [here, there] = [0, 1].map(|k| sets[k].error(rule.rule()));
            println!("{probes} probes, {name}: {here:.3?}, other surfaces {there:.3?}");
        }
        println!("    share {:.4}", fitted.kernel.share[1]);
        for r in &fitted.rings {
            println!("    ring({}, ..., [{:.4}, {:.6}, {:.4}]),", r.count, r.wide.radius, r.wide.weight, r.wide.cover);
        }
    }
}
