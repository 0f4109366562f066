//! The standard normal distribution, to nearly full double precision. The device uses rational fits (4e-7 relative).

use std::f64::consts::PI;

/// `φ(x)`, the density.
#[must_use]
pub fn normal_pdf(x: f64) -> f64 {
    (-0.5 * x * x).exp() / (2.0 * PI).sqrt()
}

/// `E[max(0, u − x)] = φ(x) − x (1 − Φ(x))` for `u ~ N(0, 1)`: what the tail above `x ≥ 0` adds to a clamped mean.
/// Negative arguments count as 0.
#[must_use]
pub fn normal_tail_mean(x: f64) -> f64 {
    let x = x.max(0.0);
    if x > 40.0 {
        return 0.0;
    }
    if x < SERIES_END {
        normal_pdf(x) * (1.0 - x * mills_ratio(x))
    } else {
        // With K the tail of the continued fraction, 1 − x/(x + K) = K/(x + K): nothing cancels.
        let k = mills_tail(x);
        normal_pdf(x) * k / (x + k)
    }
}

/// `Φ(x)`, the cumulative distribution.
#[must_use]
pub fn normal_cdf(x: f64) -> f64 {
    let t = x.abs();
    let tail = if t > 40.0 { 0.0 } else { normal_pdf(t) * mills_ratio(t) };
    if x < 0.0 { tail } else { 1.0 - tail }
}

/// Where the power series of Mills' ratio hands over to its continued fraction.
const SERIES_END: f64 = 2.0;

/// `(1 − Φ(x)) / φ(x)` for `x ≥ 0`.
fn mills_ratio(x: f64) -> f64 {
    if x >= SERIES_END {
        return 1.0 / (x + mills_tail(x));
    }
    // Φ(x) − ½ = φ(x) Σ x^(2k+1) / (2k+1)!!
    let (mut term, mut sum, mut k) = (x, x, 1.0);
    while term > 1e-17 * sum {
        k += 2.0;
        term *= x * x / k;
        sum += term;
    }
    (0.5 * PI).sqrt() * (0.5 * x * x).exp() - sum
}

/// `K` of Laplace's continued fraction `1/(x + K)`, `K = 1/(x + 2/(x + 3/(x + …)))`, for `x ≥ 2`, to 1e-14.
fn mills_tail(x: f64) -> f64 {
    let mut k = 0.0;
    for n in (1..=14 + (300.0 / (x * x)) as u32).rev() {
        k = f64::from(n) / (x + k);
    }
    k
}

#[cfg(test)]
mod tests {
    use super::*;

    // Abramowitz & Stegun, table 26.1, and mpmath at 30 digits.
    #[test]
    fn known_values() {
        for (x, cdf) in [
            (0.0, 0.5),
            (1.0, 0.841_344_746_068_542_9),
            (2.0, 0.977_249_868_051_820_8),
            (-1.5, 0.066_807_201_268_858_07),
            (-4.0, 3.167_124_183_311_992e-5),
            (-10.0, 7.619_853_024_160_527e-24),
        ] {
            assert!((normal_cdf(x) / cdf - 1.0).abs() < 1e-13, "Φ({x}) = {} instead of {cdf}", normal_cdf(x));
        }
    }

    #[test]
    fn tail_mean_is_the_integral_of_the_tail() {
        // h'(x) = −(1 − Φ(x)), h(0) = φ(0).
        assert!((normal_tail_mean(0.0) - 0.398_942_280_401_432_7).abs() < 1e-16);
        for i in 0..1200 {
            let (x, d) = (0.01 * f64::from(i) + 0.001, 1e-4);
            let slope = (normal_tail_mean(x + d) - normal_tail_mean(x - d)) / (2.0 * d);
            let expected = -normal_cdf(-x);
            assert!((slope / expected - 1.0).abs() < 3e-6, "h'({x}) = {slope} instead of {expected}");
        }
    }
}
