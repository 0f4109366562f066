//! Refits the exponentials of `reflectance::visible::diffuse`. Prints them next to the current exponentials, with the errors of both over
//! the fitted surfaces and over other surfaces.
//!
//! `cargo run --release --example 11_fit_diffuse_terms [SEED]`

use leadr::reflectance::visible::diffuse::visible_diffuse_terms;
use leadr_lab::quadrature_study::fit::{Training, fit_terms, plain_terms};

fn main() {
    let seed = std::env::args().nth(1).and_then(|s| s.parse().ok()).unwrap_or(100);
    let (training, others) = (Training::new(3000, 400, seed), Training::new(1000, 0, seed + 1000));
    for n in [2, 3] {
        let fitted = fit_terms(&training, &plain_terms(n), 200);
        for (name, terms) in
            [("start", plain_terms(n)), ("in use", visible_diffuse_terms(n as u32).to_vec()), ("fitted", fitted)]
        {
            println!(
                "{n} terms, {name}: weighted rms {:.3e}, other surfaces {:.3e}",
                training.error(&terms),
                others.error(&terms)
            );
            for t in terms {
                println!("    exponent {:.8?}, first {:.8?}, second {:.8?}", t.exponent, t.first, t.second);
            }
        }
    }
}
