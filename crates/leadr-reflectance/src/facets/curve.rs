//! A smooth curve through evenly spaced values.

use crate::limits::held;

/// A monotone cubic interpolant, which has no extrema between its nodes (Fritsch and Carlson 1980). Its slopes are accurate to fourth order
/// where monotonicity allows.
#[derive(Clone, Debug, PartialEq)]
pub struct Curve {
    values: Vec<f64>,
    slopes: Vec<f64>,
}

impl Curve {
    /// Creates the curve through at least two `values` at the positions 0, 1, 2, ….
    ///
    /// # Panics
    /// If there are fewer than two values.
    pub fn new(values: Vec<f64>) -> Self {
        assert!(values.len() > 1, "a curve needs at least two values");
        let last = values.len() - 1;
        let step = |i: usize| values[i + 1] - values[i];
        let slopes = (0..=last).map(|i| {
            if i == 0 || i == last {
                let (end, next) =
                    if i == 0 { (step(0), step(1.min(last - 1))) } else { (step(last - 1), step(last.max(2) - 2)) };
                let slope = 1.5 * end - 0.5 * next;
                // Clamp the slope so that the cubic does not overshoot the end value.
                return if slope * end <= 0.0 { 0.0 } else { slope.clamp(-3.0 * end.abs(), 3.0 * end.abs()) };
            }
            let (before, after) = (step(i - 1), step(i));
            let slope = if i > 1 && i + 1 < last {
                (8.0 * (values[i + 1] - values[i - 1]) - (values[i + 2] - values[i - 2])) / 12.0
            } else {
                0.5 * (before + after)
            };
            let rising = before.signum();
            if before * after <= 0.0 {
                0.0
            } else {
                rising * (rising * slope).clamp(0.0, 3.0 * before.abs().min(after.abs()))
            }
        });
        let slopes = slopes.collect();
        Self { values, slopes }
    }

    /// Returns the interpolated values.
    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Returns an iterator over the pairs of a value and the slope at its position.
    pub fn knots(&self) -> impl Iterator<Item = [f64; 2]> {
        self.values.iter().zip(&self.slopes).map(|(value, slope)| [*value, *slope])
    }

    /// Returns the value of the curve at `x`, which is clamped to the ends of the curve.
    pub fn at(&self, x: f64) -> f64 {
        let last = self.values.len() - 1;
        let x = held(x, 0.0, last as f64);
        let i = (x as usize).min(last - 1);
        hermite(self.values[i], self.slopes[i], self.values[i + 1], self.slopes[i + 1], x - i as f64)
    }
}

/// Evaluates the cubic from `a` with slope `slope_a` to `b` with slope `slope_b`, at `t` in 0..1.
pub fn hermite(a: f64, slope_a: f64, b: f64, slope_b: f64, t: f64) -> f64 {
    let s = 1.0 - t;
    (1.0 + 2.0 * t) * s * s * a + t * s * s * slope_a + t * t * (3.0 - 2.0 * t) * b - t * t * s * slope_b
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn goes_through_its_values_and_between_them() {
        let values = vec![3.0, 3.0, 2.5, -4.0, -4.1, -60.0, -60.0, 1.0];
        let curve = Curve::new(values.clone());
        for (i, pair) in values.windows(2).enumerate() {
            assert_eq!(curve.at(i as f64), pair[0]);
            let (low, high) = (pair[0].min(pair[1]), pair[0].max(pair[1]));
            for k in 1..20 {
                let y = curve.at(i as f64 + f64::from(k) / 20.0);
                assert!(y >= low - 1e-12 && y <= high + 1e-12, "{i} {k}: {y}");
            }
        }
        assert_eq!((curve.at(-1.0), curve.at(99.0), curve.at(f64::NAN)), (3.0, 1.0, 3.0));
        assert_eq!(Curve::new(vec![1.0, 2.0]).at(0.25), 1.25);
    }

    #[test]
    fn is_of_fourth_order_where_it_is_smooth() {
        let error = |n: usize| {
            let f = |i: f64| (2.0 * i / n as f64).exp();
            let curve = Curve::new((0..=n).map(|i| f(i as f64)).collect());
            (0..n * 8)
                .map(|k| k as f64 / 8.0)
                .filter(|&x| x > 2.0 && x < n as f64 - 2.0)
                .fold(0.0f64, |worst, x| worst.max((curve.at(x) - f(x)).abs()))
        };
        let ratio = error(20) / error(40);
        assert!(ratio > 12.0, "{ratio}");
    }
}
