//! Pearson's test of a histogram against expected counts.

/// `ln Γ(x)` for `x > 0` (Stirling's series after shifting the argument).
fn ln_gamma(mut x: f64) -> f64 {
    let mut shift = 0.0;
    while x < 15.0 {
        shift -= x.ln();
        x += 1.0;
    }
    let y = 1.0 / (x * x);
    let series = (1.0 / 12.0 - y * (1.0 / 360.0 - y * (1.0 / 1260.0 - y / 1680.0))) / x;
    shift + (x - 0.5) * x.ln() - x + 0.5 * std::f64::consts::TAU.ln() + series
}

/// Upper regularised incomplete gamma function `Q(a, x)`.
fn upper_gamma(a: f64, x: f64) -> f64 {
    if x <= 0.0 {
        return 1.0;
    }
    let front = (a * x.ln() - x - ln_gamma(a)).exp();
    if x < a + 1.0 {
        let (mut term, mut sum, mut n) = (1.0 / a, 1.0 / a, a);
        while term > 1e-16 * sum {
            n += 1.0;
            term *= x / n;
            sum += term;
        }
        return 1.0 - front * sum;
    }
    // Lentz's method for the continued fraction.
    let mut b = x + 1.0 - a;
    let (mut c, mut d) = (1e300, 1.0 / b);
    let mut h = d;
    for i in 1..10_000 {
        let k = f64::from(i);
        let an = -k * (k - a);
        b += 2.0;
        d = 1.0 / (an * d + b);
        c = b + an / c;
        h *= d * c;
        if (d * c - 1.0).abs() < 1e-15 {
            break;
        }
    }
    front * h
}

/// Probability of a fit at least this bad if the samples follow the `expected` counts. Bins with expected counts below five are
/// pooled; samples in bins with no expected count fully reduce the fit.
pub fn p_value(observed: &[f64], expected: &[f64]) -> f64 {
    let (mut statistic, mut bins, mut pool) = (0.0, 0, (0.0, 0.0));
    for (&o, &e) in observed.iter().zip(expected) {
        if e >= 5.0 {
            statistic += (o - e) * (o - e) / e;
            bins += 1;
        } else {
            pool = (pool.0 + o, pool.1 + e);
        }
    }
    if pool.1 >= 5.0 || pool.0 > pool.1 + 6.0 * (pool.1 + 1.0).sqrt() {
        statistic += (pool.0 - pool.1) * (pool.0 - pool.1) / pool.1.max(1e-3);
        bins += 1;
    }
    assert!(bins > 20, "only {bins} bins");
    upper_gamma(0.5 * f64::from(bins - 1), 0.5 * statistic)
}

#[test]
fn tables_of_the_distribution() {
    // Abramowitz & Stegun, table 26.8: statistics of 5 % and 0.1 %.
    for (degrees, statistic, p) in
        [(1.0, 3.841_459, 0.05), (10.0, 18.307_04, 0.05), (10.0, 29.588_3, 0.001), (100.0, 149.449, 0.001)]
    {
        assert!((upper_gamma(0.5 * degrees, 0.5 * statistic) / p - 1.0).abs() < 1e-4, "{degrees}");
    }
    assert!((upper_gamma(1.0, 1.0) - (-1f64).exp()).abs() < 1e-12);
}
