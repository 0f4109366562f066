//! Gauss–Legendre quadrature rules for reference integrals, and Gauss–Hermite rules.

/// Returns the `(node, weight)` pairs of the `n`-point Gauss–Legendre rule on `[−1, 1]`, in ascending order.
pub fn gauss_legendre(n: usize) -> Vec<(f64, f64)> {
    let count = n as f64;
    (0..n)
        .rev()
        .map(|i| {
            // Newton's method starts from Tricomi's estimate of the root.
            let mut x = (std::f64::consts::PI * (i as f64 + 0.75) / (count + 0.5)).cos();
            let mut derivative = 1.0;
            for _ in 0..100 {
                let (mut p0, mut p1) = (1.0, x);
                for k in 2..=n {
                    let k = k as f64;
                    (p0, p1) = (p1, ((2.0 * k - 1.0) * x * p1 - (k - 1.0) * p0) / k);
                }
                derivative = count * (x * p1 - p0) / (x * x - 1.0);
                let step = p1 / derivative;
                x -= step;
                if step.abs() < 1e-16 {
                    break;
                }
            }
            (x, 2.0 / ((1.0 - x * x) * derivative * derivative))
        })
        .collect()
}

/// Returns a composite rule on `[a, b]` with `panels` equal panels of an `order`-point rule. The rule is empty when `b ≤ a`.
pub fn composite_gauss(a: f64, b: f64, panels: usize, order: usize) -> Vec<(f64, f64)> {
    if b <= a {
        return Vec::new();
    }
    let rule = gauss_legendre(order);
    let half = 0.5 * (b - a) / panels as f64;
    (0..panels)
        .flat_map(|p| {
            let middle = a + half * (2 * p + 1) as f64;
            rule.iter().map(move |&(x, w)| (middle + half * x, half * w)).collect::<Vec<_>>()
        })
        .collect()
}

/// Returns the `(node, weight)` pairs of the `n`-point Gauss–Hermite rule for the standard normal density, in ascending order.
/// The weights sum to 1, and polynomials up to degree `2n − 1` are exact. `n` must be from 1 to 200.
///
/// The nodes are the roots of the Hermite polynomial `He_n`. Between the roots of `He_(k−1)` lies one root of `He_k` each, so the
/// roots are found by bisection from `k = 1` to `n`.
pub fn gauss_hermite(n: usize) -> Vec<(f64, f64)> {
    // The normalised polynomials `He_k / √k!` neither overflow nor underflow.
    let values = |x: f64, k: usize| {
        let (mut before, mut value) = (0.0, 1.0);
        for j in 0..k {
            let j = j as f64;
            (before, value) = (value, (x * value - j.sqrt() * before) / (j + 1.0).sqrt());
        }
        (before, value)
    };
    let mut roots: Vec<f64> = Vec::new();
    for k in 1..=n {
        let end = 2.0 * (k as f64).sqrt() + 1.0;
        let ends: Vec<f64> = [-end].into_iter().chain(roots.iter().copied()).chain([end]).collect();
        roots = ends
            .windows(2)
            .map(|pair| {
                let (mut low, mut high) = (pair[0], pair[1]);
                let sign = values(high, k).1;
                for _ in 0..100 {
                    let middle = 0.5 * (low + high);
                    *(if values(middle, k).1 * sign > 0.0 { &mut high } else { &mut low }) = middle;
                }
                0.5 * (low + high)
            })
            .collect();
    }
    roots.into_iter().map(|x| (x, 1.0 / (n as f64 * values(x, n).0.powi(2)))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn hermite_rules_are_exact_for_polynomials() {
        for n in [1, 2, 3, 5, 9, 40] {
            let rule = gauss_hermite(n);
            let mut moment = 1.0;
            for power in 0..n.min(10) as i32 * 2 {
                // The moments of the normal distribution are 1, 0, 1, 0, 3, 0, 15 …
                if power >= 2 && power % 2 == 0 {
                    moment *= f64::from(power - 1);
                }
                let exact = if power % 2 == 1 { 0.0 } else { moment };
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power)).sum();
                let scale: f64 = rule.iter().map(|(x, w)| w * x.abs().powi(power)).sum();
                assert!((sum - exact).abs() < 1e-12 * scale.max(1.0), "n {n} power {power}: {sum}");
            }
        }
        let three = gauss_hermite(3);
        assert!((three[2].0 - 3f64.sqrt()).abs() < 1e-14 && (three[1].1 - 2.0 / 3.0).abs() < 1e-14);
    }

    #[test]
    fn exact_for_polynomials() {
        for n in [1, 2, 5, 8, 40] {
            let rule = gauss_legendre(n);
            for power in 0..2 * n as i32 {
                let sum: f64 = rule.iter().map(|(x, w)| w * x.powi(power)).sum();
                let exact = if power % 2 == 1 { 0.0 } else { 2.0 / f64::from(power + 1) };
                assert!((sum - exact).abs() < 1e-13, "n {n} power {power}: {sum}");
            }
        }
        let sum: f64 = composite_gauss(1.0, 3.0, 7, 4).iter().map(|(x, w)| w * x * x).sum();
        assert!((sum - 26.0 / 3.0).abs() < 1e-13);
    }
}
