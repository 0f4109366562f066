//! The standard normal distribution, to nearly full double precision. The shaders use rational fits with a relative error of 4e-7.

use std::f64::consts::{PI, SQRT_2};

/// Returns the density `φ(x)` of the standard normal distribution.
pub fn normal_pdf(x: f64) -> f64 {
    (-0.5 * x * x).exp() / (2.0 * PI).sqrt()
}

/// Returns `E[max(0, u − x)] = φ(x) − x (1 − Φ(x))` for `u ~ N(0, 1)`, the mean excess of the tail above `x ≥ 0`. A negative `x` counts
/// as 0.
pub fn normal_tail_mean(x: f64) -> f64 {
    let x = x.max(0.0);
    if x > 40.0 { 0.0 } else { normal_pdf(x) * tail_mean_ratio(x) }
}

/// Returns `1 − x (1 − Φ(x)) / φ(x)` for `x ≥ 0`, which is [`normal_tail_mean`] divided by the density, without underflow.
pub fn tail_mean_ratio(x: f64) -> f64 {
    if x < SERIES_END {
        1.0 - x * mills_ratio(x)
    } else {
        // With K, the tail of the continued fraction, 1 − x/(x + K) = K/(x + K) avoids cancellation.
        let k = mills_tail(x);
        k / (x + k)
    }
}

/// Returns the cumulative distribution `Φ(x)` of the standard normal distribution.
pub fn normal_cdf(x: f64) -> f64 {
    let t = x.abs();
    let tail = if t > 40.0 { 0.0 } else { normal_pdf(t) * mills_ratio(t) };
    if x < 0.0 { tail } else { 1.0 - tail }
}

/// The density, the cumulative distribution and the ramp of the standard normal distribution at one point.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct NormalRamp {
    /// The density `φ(x)`.
    pub pdf: f64,
    /// The cumulative distribution `Φ(x)`.
    pub cdf: f64,
    /// The ramp `E[max(0, x + u)] = x Φ(x) + φ(x)` for `u ~ N(0, 1)`.
    pub ramp: f64,
}

/// Computes [`normal_pdf`], [`normal_cdf`] and the ramp together, because in shaders they share one exponential.
pub fn normal_ramp(x: f64) -> NormalRamp {
    NormalRamp { pdf: normal_pdf(x), cdf: normal_cdf(x), ramp: x.max(0.0) + normal_tail_mean(x.abs()) }
}

/// Returns `Φ(x) / (x Φ(x) + φ(x))`, the mean of `u ~ N(0, 1)` weighted by the visible area `max(0, x + u)`. The mean tends to `1/x` for
/// large `x` and to `−x` for very negative `x`. Arguments below −13, where the total visible area is 1e-40, are treated as −13.
pub fn clamped_lean(x: f64) -> f64 {
    if x >= 0.0 {
        let cdf = normal_cdf(x);
        return cdf / (x * cdf + normal_pdf(x));
    }
    mills_ratio(-x.max(-13.0)) / tail_mean_ratio(-x.max(-13.0))
}

/// Returns the quantile `Φ⁻¹(u)` of `u` in (0, 1). `u` is clamped to `[2⁻³², 1 − 2⁻³²]` (±6.2).
///
/// The starting value is Giles' polynomial for the inverse error function (2010, 2e-7 in single precision). Two Halley steps refine the
/// quantile to full precision.
pub fn normal_quantile(u: f64) -> f64 {
    let u = u.clamp(MIN_PROBABILITY, 1.0 - MIN_PROBABILITY);
    let w = -(4.0 * u * (1.0 - u)).ln();
    let (w, coefficients) = if w < 5.0 { (w - 2.5, &CENTRE) } else { (w.sqrt() - 3.0, &TAIL) };
    let mut x = SQRT_2 * (2.0 * u - 1.0) * coefficients.iter().fold(0.0, |p, c| p * w + c);
    for _ in 0..2 {
        // Use the smaller tail to avoid cancellation.
        let excess = if u < 0.5 { normal_cdf(x) - u } else { (1.0 - u) - normal_cdf(-x) };
        let step = excess / normal_pdf(x);
        x -= step / (1.0 + 0.5 * x * step);
    }
    x
}

/// The smallest distance of a probability from 0 or 1, `2⁻³²`. (Shaders clamp probabilities to 2⁻²⁵ and 1 − 2⁻²⁴.)
pub const MIN_PROBABILITY: f64 = 1.0 / 4_294_967_296.0;

/// Giles' coefficients for `w = −ln(1 − x²) < 5`, as a polynomial in `w − 2.5`, with the highest power first.
const CENTRE: [f64; 9] = [
    2.810_226_36e-8,
    3.432_739_39e-7,
    -3.523_387_7e-6,
    -4.391_506_54e-6,
    0.000_218_580_87,
    -0.001_253_725_03,
    -0.004_177_681_64,
    0.246_640_727,
    1.501_409_41,
];

/// Giles' coefficients for `w ≥ 5`, as a polynomial in `√w − 3`, with the highest power first.
const TAIL: [f64; 9] = [
    -0.000_200_214_257,
    0.000_100_950_558,
    0.001_349_343_22,
    -0.003_673_428_44,
    0.005_739_507_73,
    -0.007_622_461_3,
    0.009_438_870_47,
    1.001_674_06,
    2.832_976_82,
];

/// The argument of Mills' ratio below which a power series replaces the continued fraction.
const SERIES_END: f64 = 2.0;

/// Returns Mills' ratio `(1 − Φ(x)) / φ(x)` for `x ≥ 0`.
pub fn mills_ratio(x: f64) -> f64 {
    if x >= SERIES_END {
        return 1.0 / (x + mills_tail(x));
    }
    // The power series is Φ(x) − ½ = φ(x) Σ x^(2k+1) / (2k+1)!!.
    let (mut term, mut sum, mut k) = (x, x, 1.0);
    while term > 1e-17 * sum {
        k += 2.0;
        term *= x * x / k;
        sum += term;
    }
    (0.5 * PI).sqrt() * (0.5 * x * x).exp() - sum
}

/// Returns the value `K = 1/(x + 2/(x + 3/(x + …)))` of Laplace's continued fraction `1/(x + K)`, for `x ≥ 2`. The error is below 1e-14.
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

    // The expected values are from Abramowitz & Stegun, table 26.1, and from mpmath at 30 digits.
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
    fn quantile_inverts_the_distribution() {
        let mut worst = 0.0f64;
        for i in 0..4000 {
            let u = if i % 2 == 0 { f64::from(i) / 4000.0 + 1e-4 } else { 10f64.powf(-9.5 * f64::from(i) / 4000.0) };
            let u = u.min(1.0 - 1e-9);
            for (p, x) in [(u, normal_quantile(u)), (1.0 - u, -normal_quantile(1.0 - u))] {
                let x = if p == u { x } else { -x };
                let error = if p < 0.5 { normal_cdf(x) - p } else { (1.0 - p) - normal_cdf(-x) };
                worst = worst.max((error / p.min(1.0 - p)).abs());
            }
        }
        println!("worst relative error of Φ(Φ⁻¹(u)): {worst:.1e}");
        assert!(worst < 1e-13);
        assert!(normal_quantile(0.0) < -6.2 && normal_quantile(1.0) > 6.2 && normal_quantile(0.5).abs() < 1e-15);
    }

    #[test]
    fn tail_mean_is_the_integral_of_the_tail() {
        // The tail mean h satisfies h'(x) = −(1 − Φ(x)) and h(0) = φ(0).
        assert!((normal_tail_mean(0.0) - 0.398_942_280_401_432_7).abs() < 1e-16);
        for i in 0..1200 {
            let (x, d) = (0.01 * f64::from(i) + 0.001, 1e-4);
            let slope = (normal_tail_mean(x + d) - normal_tail_mean(x - d)) / (2.0 * d);
            let expected = -normal_cdf(-x);
            assert!((slope / expected - 1.0).abs() < 3e-6, "h'({x}) = {slope} instead of {expected}");
        }
    }
}
