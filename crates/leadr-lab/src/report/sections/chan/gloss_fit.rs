//! Measures section 5.7: how many coefficients a rational fit of the slice needs once gloss is an argument.

use std::f64::consts::PI;

use rayon::prelude::*;

use super::GLOSSES;
use super::laws::{Law, slice_pair};
use super::rational;
use crate::brdf_fit_study::quotient::polynomial_terms;
use crate::report::page::Page;
use crate::report::studio::Studio;
use leadr_reflectance::materials::multiscattering::{CHAN_RATIONAL, slice_quotient};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Table, number};

/// The largest `θ_h` and `θ_d` in degrees. Walks are noisy at the horizon.
const MOST: f64 = 80.0;

/// `n·h`, `l·h` and gloss, and `π f_r`.
type Sample = ([f64; 3], f64);

fn rms(samples: &[Sample], value: impl Fn(&[f64; 3]) -> f64) -> f64 {
    (samples.iter().map(|(at, wanted)| (value(at) - wanted).powi(2)).sum::<f64>() / samples.len() as f64).sqrt()
}

/// Fits a quotient of two polynomials of one degree. `lower` has the coefficients of the degree below, or none. Returns the coefficients and
/// the root mean square error.
fn fitted(samples: &[Sample], degree: usize, lower: &[f64]) -> (Vec<f64>, f64) {
    let points: Vec<(Vec<f64>, f64)> =
        samples.iter().map(|(at, value)| (polynomial_terms(at, degree), *value)).collect();
    let count = polynomial_terms(&[0.0; 3], degree).len();
    let sum = |terms: &[f64], c: &[f64]| terms.iter().zip(c).map(|(term, c)| term * c).sum::<f64>();
    // The constant of the denominator is 1.
    let parts = |terms: &Vec<f64>, c: &[f64]| [sum(terms, &c[..count]), 1.0 + sum(&terms[1..], &c[count..])];
    let value = |terms: &Vec<f64>, c: &[f64]| {
        let [above, below] = parts(terms, c);
        above / below
    };
    let error = |c: &[f64]| {
        let squares = points.iter().map(|(terms, wanted)| (value(terms, c) - wanted).powi(2));
        (squares.sum::<f64>() / points.len() as f64).sqrt()
    };
    // Fits have local minima. A second search begins with the lower degree, so that the error cannot grow with the degree.
    let mut start = vec![0.0; 2 * count - 1];
    let half = lower.len().div_ceil(2);
    start[..half].copy_from_slice(&lower[..half]);
    start[count..count + lower.len() - half].copy_from_slice(&lower[half..]);
    let found = [rational::fit(2 * count - 1, &points, parts), rational::refit(start, &points, value)];
    let [first, second] = found.map(|c| {
        let error = error(&c);
        (c, error)
    });
    if second.1 < first.1 { second } else { first }
}

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "Chan section 5.7",
        "Rational fits to the slice of the random walks at five glosses: eq. 63's form for each gloss alone, and quotients of polynomials of \
        n·h, l·h and gloss. Last, the published hand fit, and the noise of the walks.",
    );
    let (walks, side) = (studio.pick(400, 10_000), studio.pick(8, 16));
    let of_seed = |seed: u64| -> Vec<Sample> {
        let at = |i: usize| (MOST * ((i as f64) + 0.5) / side as f64).to_radians().cos();
        let sample = |i: usize| {
            let [x, y, g] = [at(i % side), at(i / side % side), GLOSSES[i / (side * side)] / 255.0];
            let [wo, wi] = slice_pair(x, y);
            ([x, y, g], Law::Walks(walks).value(wo, wi, g, seed ^ i as u64))
        };
        (0..side * side * GLOSSES.len()).into_par_iter().map(sample).collect()
    };
    let halves = [of_seed(0), of_seed(1 << 32)];
    let samples: Vec<Sample> = halves[0].iter().zip(&halves[1]).map(|(a, b)| (a.0, 0.5 * (a.1 + b.1))).collect();
    let noise = 0.5
        * (rms(&halves[0], |_| 0.0).powi(2) + rms(&halves[1], |_| 0.0).powi(2)
            - 2.0 * halves[0].iter().zip(&halves[1]).map(|(a, b)| a.1 * b.1).sum::<f64>() / samples.len() as f64)
            .max(0.0)
            .sqrt();
    let mut table = Table::new("Coefficients and errors of π f_r", ["", "coefficients", "rms"]);
    let mut row = |page: &mut Page, name: &str, count: usize, error: f64| {
        let count_cell = if count == 0 { String::new() } else { count.to_string() };
        table.row([Cell::from(name), Cell::from(count_cell), Cell::from(error)]);
        page.check(format!("{name}, rms"), error);
    };
    let mut squares = 0.0;
    for slice in samples.chunks(side * side) {
        let value = |at: &[f64; 3], c: &[f64]| {
            let [above, below] = slice_quotient(at[0], at[1], c);
            PI * above / below
        };
        let found = rational::refit(CHAN_RATIONAL.to_vec(), slice, value);
        let error = rms(slice, |at| value(at, &found));
        squares += error * error / GLOSSES.len() as f64;
        let gloss = (255.0 * slice[0].0[2]).round();
        row(page, &format!("eq. 63's form, gloss {gloss} alone"), 15, error);
    }
    let apart = squares.sqrt();
    row(page, "eq. 63's form, each gloss alone", 15 * GLOSSES.len(), apart);
    let (mut found, mut coefficients) = (Vec::new(), Vec::new());
    for degree in 1..=studio.pick(3, 4) {
        let error;
        (coefficients, error) = fitted(&samples, degree, &coefficients);
        let count = coefficients.len();
        row(page, &format!("three arguments, degree {degree}"), count, error);
        found.push(format!("{} with {count}", number(error)));
    }
    let published = rms(&samples, |at| {
        let [wo, wi] = slice_pair(at[0], at[1]);
        Law::Published.value(wo, wi, at[2], 0)
    });
    row(page, "listing 1", 0, published);
    row(page, "noise of the walks", 0, noise);
    page.html.table(&table);
    page.find(&format!(
        "the rms error of one function of three arguments is {} coefficients; with 15 for each gloss it is {}.",
        found.join(", "),
        number(apart)
    ));
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_quotient_of_three_arguments_is_found_again() {
        let at = |i: i32| [i % 5, i / 5 % 5, i / 25].map(|k| 0.25 * f64::from(k));
        let value = |[x, y, z]: [f64; 3]| (0.2 + x - 0.3 * y + 0.5 * z) / (1.0 + 0.4 * x + 0.7 * y - 0.2 * z);
        let samples: Vec<Sample> = (0..125).map(|i| (at(i), value(at(i)))).collect();
        let (found, error) = fitted(&samples, 1, &[]);
        assert!(found.len() == 7 && error < 1e-6, "{found:?}: {error}");
    }
}
