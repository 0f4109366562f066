//! Finds the sample count at which a reference has the same error, and the fraction of the error that neighbours share.

use serde::Serialize;

use leadr_maps::RgbImage;
use leadr_tools::html::number;
use leadr_tools::metrics::Mask;

/// The sample count that a picture is worth: the count of a reference with an equal error.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "bound", content = "samples", rename_all = "snake_case")]
pub enum Worth {
    /// The sample count, interpolated between measured counts by a power law.
    Equal(f64),
    /// The smallest measured sample count. The picture is worth less.
    Below(f64),
    /// The largest measured sample count. The picture is worth more.
    Above(f64),
    /// The worth is unknown, because there are no pixels to compare.
    Unknown,
}

impl Worth {
    /// Computes the sample count at which a reference has the error `error`, by a power law between the measured counts.
    /// `references` lists sample counts with their errors.
    pub fn of(references: &[(f64, f64)], error: f64) -> Self {
        let (Some(first), Some(last)) = (references.first(), references.last()) else { return Self::Unknown };
        if error.is_nan() {
            return Self::Unknown;
        }
        if first.1 <= error {
            return Self::Below(first.0);
        }
        let Some(pair) = references.windows(2).find(|pair| pair[0].1 > error && pair[1].1 <= error) else {
            return Self::Above(last.0);
        };
        // No sample count gives an error below the truth's noise.
        if pair[1].1 <= 0.0 {
            return Self::Above(pair[0].0);
        }
        let share = (pair[0].1 / error).ln() / (pair[0].1 / pair[1].1).ln();
        Self::Equal(pair[0].0 * (pair[1].0 / pair[0].0).powf(share))
    }

    /// Whether the worth is at least `samples`.
    pub fn reaches(self, samples: f64) -> bool {
        match self {
            Self::Equal(n) | Self::Above(n) => n >= samples,
            Self::Below(_) | Self::Unknown => false,
        }
    }
}

impl std::fmt::Display for Worth {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Equal(n) => write!(f, "{}", number(*n)),
            Self::Below(n) => write!(f, "below {}", number(*n)),
            Self::Above(n) => write!(f, "above {}", number(*n)),
            Self::Unknown => write!(f, "–"),
        }
    }
}

/// Subtracts the truth's noise from an error. The squares of independent errors add up.
pub fn own(error: f64, noise: f64) -> f64 {
    if error.is_nan() { error } else { (error * error - noise * noise).max(0.0).sqrt() }
}

/// Computes the correlation between the errors of adjacent pixels in `mask`. The correlation is the fraction of the squared
/// error that neighbours share: 0 for independent errors, 1 for equal errors, and NaN without adjacent pixels.
pub fn shared(reference: &RgbImage, test: &RgbImage, mask: &Mask) -> f64 {
    let width = mask.width as usize;
    let error = |i: usize, c: usize| f64::from(test.texels[i][c]) - f64::from(reference.texels[i][c]);
    let (mut products, mut squares) = (0.0, 0.0);
    for i in (0..mask.inside.len()).filter(|&i| mask.inside[i]) {
        let right = (i % width + 1 < width).then_some(i + 1);
        let below = Some(i + width).filter(|&j| j < mask.inside.len());
        for j in [right, below].into_iter().flatten().filter(|&j| mask.inside[j]) {
            for c in 0..3 {
                let (a, b) = (error(i, c), error(j, c));
                products += a * b;
                squares += 0.5 * (a * a + b * b);
            }
        }
    }
    products / squares
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_of_equal_error_are_interpolated() {
        let halves: Vec<(f64, f64)> = (0..5).map(|k| (4f64.powi(k), 0.5f64.powi(k))).collect();
        let equal = |error| match Worth::of(&halves, error) {
            Worth::Equal(n) => n,
            other => panic!("{other}"),
        };
        assert!((equal(0.25) - 16.0).abs() < 1e-9);
        assert!((equal(0.5f64.powf(1.5)) - 8.0).abs() < 1e-9);
        assert_eq!((Worth::of(&halves, 2.0), Worth::of(&halves, 0.01)), (Worth::Below(1.0), Worth::Above(256.0)));
        assert_eq!((Worth::of(&[], 1.0), Worth::of(&halves, f64::NAN)), (Worth::Unknown, Worth::Unknown));
        // Errors below the truth's noise cannot be resolved.
        let drowned = [(1.0, 0.2), (32.0, 0.1), (64.0, 0.0)];
        assert_eq!((Worth::of(&drowned, 0.05), Worth::of(&drowned, 0.0)), (Worth::Above(32.0), Worth::Above(32.0)));
        assert_eq!(Worth::of(&drowned[..2], 0.0), Worth::Above(32.0));
        assert!(Worth::Above(128.0).reaches(64.0) && Worth::Equal(64.0).reaches(64.0));
        assert!(!Worth::Below(64.0).reaches(64.0) && !Worth::Unknown.reaches(1.0));
    }

    #[test]
    fn noise_is_taken_off_by_squares() {
        assert!((own(0.05, 0.03) - 0.04).abs() < 1e-12);
        assert_eq!(own(0.03, 0.05), 0.0);
        assert!(own(f64::NAN, 0.1).is_nan());
    }

    #[test]
    fn shared_error_is_separated_from_independent_error() {
        let n = 64u32;
        let grey =
            |value: &dyn Fn(u32) -> f32| RgbImage::new(n, n, (0..n * n).map(|i| [value(i); 3]).collect()).unwrap();
        let flat = grey(&|_| 1.0);
        let mask = Mask::all(n, n);
        // Returns a random ±1 from the top bit of a mixed index.
        let own = |i: u32| {
            if (i.wrapping_mul(0x9e37_79b9) ^ i << 13).wrapping_mul(0x85eb_ca6b) >> 31 == 0 { 1.0 } else { -1.0 }
        };
        let all = shared(&flat, &grey(&|_| 1.1), &mask);
        let none = shared(&flat, &grey(&|i| 1.0 + 0.1 * own(i)), &mask);
        let half = shared(&flat, &grey(&|i| 1.1 + 0.1 * own(i)), &mask);
        assert!((all - 1.0).abs() < 1e-9 && none.abs() < 0.05 && (half - 0.5).abs() < 0.05, "{all} {none} {half}");
        assert!(shared(&flat, &flat, &flat_mask(n)).is_nan());
    }

    fn flat_mask(n: u32) -> Mask {
        Mask { width: n, height: n, inside: vec![false; (n * n) as usize] }
    }
}
