//! Fits rational functions, as in section 3 of the paper.

use crate::least_squares::least_squares;

/// Fits a rational function to samples, each a point and a value. `parts` returns the numerator and the denominator at a point for
/// `count` coefficients, and is linear in the coefficients, up to a constant.
pub fn fit<P>(count: usize, samples: &[(P, f64)], parts: impl Fn(&P, &[f64]) -> [f64; 2]) -> Vec<f64> {
    // Multiplied by the denominator, the problem is linear. Its solution is near that of the quotient.
    let linear = |c: &[f64]| {
        let residual = |(point, value): &(P, f64)| {
            let [above, below] = parts(point, c);
            above - value * below
        };
        samples.iter().map(residual).collect()
    };
    refit(least_squares(vec![0.0; count], 50, linear), samples, |point, c| {
        let [above, below] = parts(point, c);
        above / below
    })
}

/// Fits the coefficients of a function to samples, beginning with `start`. Fits of many terms have local minima.
pub fn refit<P>(start: Vec<f64>, samples: &[(P, f64)], value: impl Fn(&P, &[f64]) -> f64) -> Vec<f64> {
    least_squares(start, 400, |c| samples.iter().map(|(point, wanted)| value(point, c) - wanted).collect())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_rational_function_is_found_again() {
        let parts = |x: &f64, c: &[f64]| [c[0] + c[1] * x, 1.0 + c[2] * x * x];
        let wanted = [0.3, 1.2, 4.0];
        let samples: Vec<(f64, f64)> = (0..30)
            .map(|i| {
                let x = f64::from(i) / 29.0;
                let [above, below] = parts(&x, &wanted);
                (x, above / below)
            })
            .collect();
        let found = fit(3, &samples, parts);
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    }
}
