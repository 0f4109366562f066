//! Fits quotients of two polynomials of several arguments. A fit may have hundreds of coefficients.

use crate::least_squares::least_squares_with;
use rayon::prelude::*;

/// The largest number of terms of a polynomial, which is that of eight arguments and degree 3.
pub const MOST_TERMS: usize = 165;
/// The smallest denominator that a fit may have at its samples. The constant of the denominator is 1.
const SMALLEST: f64 = 0.05;
/// The largest number of steps of a fit.
const STEPS: u32 = 60;

/// The terms of a polynomial at one point, as working memory.
pub type Terms = [f64; MOST_TERMS];

/// A sample of a fit. The quotient at `at`, times `scale`, should be `value`.
#[derive(Clone, Debug)]
pub struct Sample {
    /// The arguments of the quotient.
    pub at: Vec<f64>,
    /// The known factor of the value.
    pub scale: f64,
    /// The value.
    pub value: f64,
}

/// A quotient of two polynomials, with all terms up to their total degrees. The constant of the denominator is 1.
#[derive(Clone, Debug)]
pub struct Quotient {
    degree: usize,
    above: Vec<f64>,
    below: Vec<f64>,
}

/// Writes the products of powers of `x` up to a total degree, the constant 1 first. Returns their number.
fn write_terms(x: &[f64], degree: usize, terms: &mut Terms) -> usize {
    // Every term of one degree is a term of the degree below times its first argument. `first` has the first term of the degree below
    // whose own first argument is this one or a later one.
    let mut first = [0; 8];
    terms[0] = 1.0;
    let mut count = 1;
    for _ in 0..degree {
        let end = count;
        for (x, first) in x.iter().zip(&mut first) {
            let start = std::mem::replace(first, count);
            for k in start..end {
                terms[count] = x * terms[k];
                count += 1;
            }
        }
    }
    count
}

/// Returns the products of powers of at most eight arguments up to a total degree, the constant 1 first.
///
/// # Panics
/// Panics if there are more than [`MOST_TERMS`] terms.
pub fn polynomial_terms(x: &[f64], degree: usize) -> Vec<f64> {
    let mut terms = [0.0; MOST_TERMS];
    let count = write_terms(x, degree, &mut terms);
    terms[..count].to_vec()
}

/// Sums in four lanes, because one chain of additions would be slower than the products.
fn dot(a: &[f64], b: &[f64]) -> f64 {
    let mut lanes = [0.0; 4];
    let (a, b) = (a.chunks_exact(4), b.chunks_exact(4));
    let rest: f64 = a.remainder().iter().zip(b.remainder()).map(|(x, y)| x * y).sum();
    for (a, b) in a.zip(b) {
        for (lane, (x, y)) in lanes.iter_mut().zip(a.iter().zip(b)) {
            *lane += x * y;
        }
    }
    lanes.iter().sum::<f64>() + rest
}

impl Quotient {
    /// Fits polynomials of the `degrees` above and below the line to samples, by least squares. Each step solves the problem that is linear
    /// in the coefficients, weighted by the inverse of the last denominator. The search begins with a constant, and rejects steps with a
    /// small or negative denominator at any sample. A fit may still have poles between the samples.
    ///
    /// # Panics
    /// Panics if there are no samples, or more than [`MOST_TERMS`] terms.
    pub fn fit(samples: &[Sample], degrees: [usize; 2]) -> Self {
        let degree = degrees[0].max(degrees[1]);
        let [above, below] = degrees.map(|degree| polynomial_terms(&samples[0].at, degree).len());
        let rows: Vec<Vec<f64>> = samples.iter().map(|sample| polynomial_terms(&sample.at, degree)).collect();
        let parts = |c: &[f64], row: &[f64]| [dot(&c[..above], &row[..above]), 1.0 + dot(&c[above..], &row[1..below])];
        let residuals = |c: &[f64]| -> Vec<f64> {
            let residual = |(sample, row): (&Sample, &Vec<f64>)| {
                let [p, q] = parts(c, row);
                if q > SMALLEST { sample.scale * p / q - sample.value } else { f64::INFINITY }
            };
            samples.par_iter().zip(&rows).map(residual).collect()
        };
        let jacobian = |c: &[f64]| -> Vec<Vec<f64>> {
            let derivatives = |(sample, row): (&Sample, &Vec<f64>)| {
                let [p, q] = parts(c, row);
                [sample.scale / q, -sample.scale * p / (q * q)]
            };
            let per: Vec<[f64; 2]> = samples.par_iter().zip(&rows).map(derivatives).collect();
            let column = |k: usize| {
                let (part, term) = if k < above { (0, k) } else { (1, k - above + 1) };
                rows.iter().zip(&per).map(|(row, per)| row[term] * per[part]).collect()
            };
            (0..c.len()).into_par_iter().map(column).collect()
        };
        let mut start = vec![0.0; above + below - 1];
        let [with, of] =
            samples.iter().fold([0.0; 2], |[with, of], s| [with + s.scale * s.value, of + s.scale * s.scale]);
        start[0] = with / of;
        let mut found = least_squares_with(start, STEPS, residuals, jacobian);
        let mut denominator = found.split_off(above);
        denominator.insert(0, 1.0);
        Self { degree, above: found, below: denominator }
    }

    /// Returns the number of free coefficients.
    pub fn coefficients(&self) -> usize {
        self.above.len() + self.below.len() - 1
    }

    /// Computes the numerator and the denominator.
    pub fn parts(&self, at: &[f64], terms: &mut Terms) -> [f64; 2] {
        write_terms(at, self.degree, terms);
        [&self.above, &self.below].map(|c| dot(c, &terms[..c.len()]))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn terms_are_products_of_powers() {
        assert_eq!(polynomial_terms(&[2.0, 3.0, 5.0], 2), [1.0, 2.0, 3.0, 5.0, 4.0, 6.0, 10.0, 9.0, 15.0, 25.0]);
        let counts = |x: &[f64], degrees: [usize; 3]| degrees.map(|degree| polynomial_terms(x, degree).len());
        assert_eq!(counts(&[0.5; 3], [1, 3, 4]), [4, 20, 35]);
        assert_eq!(counts(&[0.5; 8], [1, 2, 3]), [9, 45, MOST_TERMS]);
    }

    #[test]
    fn a_quotient_is_found_again() {
        let at = |i: i32| [i % 5, i / 5 % 5, i / 25].map(|k| 0.25 * f64::from(k));
        let value = |[x, y, z]: [f64; 3]| (0.2 + x - 0.3 * y + 0.5 * x * z) / (1.0 + 0.4 * x + 0.7 * y - 0.2 * z);
        let sample =
            |i| Sample { at: at(i).to_vec(), scale: f64::from(1 + i % 3), value: f64::from(1 + i % 3) * value(at(i)) };
        let samples: Vec<Sample> = (0..125).map(sample).collect();
        let found = Quotient::fit(&samples, [2, 1]);
        assert_eq!(found.coefficients(), 13);
        let mut terms = [0.0; MOST_TERMS];
        for point in [[0.3, 0.9, 0.1], [0.6, 0.05, 0.8]] {
            let [p, q] = found.parts(&point, &mut terms);
            assert!((p / q - value(point)).abs() < 1e-6, "{p} / {q} at {point:?}");
        }
    }
}
