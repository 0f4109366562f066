//! Fits the rational functions of Chan's *Material Advances in Call of Duty: WWII* (2018, eq. 40, 42 and 35–37) again and prints them beside the printed ones, with
//! their errors; then fits of the roughness by the length of a mean normal, for shaders.
//!
//! `cargo run --release --no-default-features --example 19_rational_fits`

use leadr::reflectance::DVec2;
use leadr::reflectance::facets::combined_gloss::{CombinedGloss, combine_gloss_fit, combine_gloss_short};
use leadr::reflectance::facets::gloss::Gloss;
use leadr::reflectance::facets::shortened_normals::Shortening;
use leadr::reflectance::rational_fit::{Norm, Rational, RationalFault, RationalForm, RationalSample, fit_rational};

/// Chan's: GGX by macrosurface area.
const SHORTENING: Shortening = Shortening::ALL[0];

fn main() -> Result<(), RationalFault> {
    length_of_gloss()?;
    combined_gloss()?;
    alpha_of_lack()
}

fn sample(x: f64, y: f64, value: f64, weight: f64) -> RationalSample {
    RationalSample { at: DVec2::new(x, y), value, weight }
}

fn print_coefficients(name: &str, f: &Rational) {
    println!("{name}: {:.7?} / 1, {:.7?}", f.numerator, f.denominator);
}

/// Eq. 40 and 42: the length of the mean normal by gloss.
fn length_of_gloss() -> Result<(), RationalFault> {
    let exact = |gloss: f64| SHORTENING.length(Gloss::Wwii.alpha(gloss));
    let samples: Vec<RationalSample> =
        (0..256).map(|i| f64::from(i) / 255.0).map(|g| sample(g, 0.0, exact(g), 1.0)).collect();
    let form = RationalForm::powers(3, 2);
    let ends = [(DVec2::ZERO, exact(0.0)), (DVec2::X, exact(1.0))];
    let printed = |numerator: [f64; 4], denominator: [f64; 2]| Rational {
        form: form.clone(),
        numerator: numerator.to_vec(),
        denominator: denominator.to_vec(),
    };
    println!("Length of the mean normal by gloss (WWII)");
    for (name, f) in [
        ("eq. 40", printed([0.66693, 0.0609009, 7.32398, 0.600464], [-1.13467, 8.78264])),
        ("free", fit_rational(&form, &samples, &[], Norm::Squares)?),
        ("eq. 42", printed([0.66667, 0.0942205, 7.41935, 0.567111], [-1.0881, 8.83582])),
        ("ends fixed", fit_rational(&form, &samples, &ends, Norm::Squares)?),
        ("ends fixed, least largest error", fit_rational(&form, &samples, &ends, Norm::Largest)?),
    ] {
        let (mut worst, mut decoded, mut squares) = ((0.0f64, 0.0), (0.0f64, 0.0), 0.0);
        for i in 0..=2000 {
            let gloss = f64::from(i) / 2000.0;
            let got = f.eval(DVec2::new(gloss, 0.0));
            let error = (got - exact(gloss)).abs();
            let read = (Gloss::Wwii.gloss(SHORTENING.alpha_of_length(got)) - gloss).abs();
            squares += error * error / 2001.0;
            worst = if error > worst.0 { (error, gloss) } else { worst };
            decoded = if read > decoded.0 { (read, gloss) } else { decoded };
        }
        print_coefficients(name, &f);
        println!(
            "    off by {:.2e} at most (gloss {:.3}), rms {:.2e}; f(1) - L(1) {:.1e}; read back as gloss off by {:.3} (at {:.3})",
            worst.0,
            worst.1,
            squares.sqrt(),
            f.eval(DVec2::X) - exact(1.0),
            decoded.0,
            decoded.1
        );
    }
    Ok(())
}

/// Eq. 35–37: gloss of a detail on a base.
fn combined_gloss() -> Result<(), RationalFault> {
    let exact = |at: DVec2| SHORTENING.combine_gloss(at.x, at.y, Gloss::Wwii);
    let grid = |n: i32| (0..n * n).map(move |i| DVec2::new(f64::from(i % n), f64::from(i / n)) / f64::from(n - 1));
    println!("\nGloss of a detail on a base (WWII)");
    let report = |name: &str, f: &dyn Fn(DVec2) -> f64| {
        let (mut worst, mut squares) = ((0.0f64, DVec2::ZERO), 0.0);
        for at in grid(129) {
            let error = (f(at) - exact(at)).abs();
            squares += error * error / 129.0 / 129.0;
            worst = if error > worst.0 { (error, at) } else { worst };
        }
        let rms = f64::sqrt(squares);
        println!("    {name}: off by {:.5} at most, at {:.3} and {:.3}; rms {rms:.5}", worst.0, worst.1.x, worst.1.y);
    };
    report("product, short way back", &|at| combine_gloss_short(at.x, at.y, Gloss::Wwii));
    let table = |size| CombinedGloss::new(SHORTENING, Gloss::Wwii, size);
    for size in [16, 32, 64, 128] {
        let (whole, coded) = (table(size), table(size).in_8_bits());
        report(&format!("table of {size} x {size}"), &|at| whole.at(at.x, at.y));
        report(&format!("table of {size} x {size}, 8 bits"), &|at| coded.at(at.x, at.y));
    }
    let table = table(CombinedGloss::PAPER_SIZE);
    report("eq. 35-37", &|at| combine_gloss_fit(at.x, at.y));
    for (name, degrees, norm) in [
        ("degrees 2, 2", (2, 2), Norm::Squares),
        ("degrees 2, 2, least largest error", (2, 2), Norm::Largest),
        ("degrees 3, 3", (3, 3), Norm::Squares),
        ("degrees 3, 3, least largest error", (3, 3), Norm::Largest),
    ] {
        match table.fit(&RationalForm::symmetric(degrees.0, degrees.1), norm) {
            Ok(f) => {
                print_coefficients(name, &f);
                report(name, &|at| f.eval(at).clamp(0.0, 1.0));
            }
            Err(fault) => println!("{name}: {fault}"),
        }
    }
    Ok(())
}

/// `α² / (1 − L)` over a root of `1 − L`.
fn alpha_of_lack() -> Result<(), RationalFault> {
    println!("\nalpha^2 / (1 - L) over a root of 1 - L, for alpha from .0028 (gloss 1) to 1");
    for (root, n, d) in [(2.0, 3, 3), (4.0, 2, 2), (4.0, 3, 2), (4.0, 3, 3)] {
        let samples: Vec<RationalSample> = (0..600)
            .map(|i| {
                let alpha = 0.0027f64.powf(f64::from(i) / 599.0);
                let lack = SHORTENING.lack(alpha);
                let value = alpha * alpha / lack;
                sample(lack.powf(1.0 / root), 0.0, value, 1.0 / value)
            })
            .collect();
        match fit_rational(&RationalForm::powers(n, d), &samples, &[], Norm::Largest) {
            Ok(f) => {
                print_coefficients(&format!("root {root}, degrees {n}, {d}"), &f);
                let worst = samples.iter().map(|s| (f.eval(s.at) / s.value - 1.0).abs()).fold(0.0, f64::max);
                println!("    alpha^2 off by {worst:.1e} of itself at most");
            }
            Err(fault) => println!("root {root}, degrees {n}, {d}: {fault}"),
        }
    }
    Ok(())
}
