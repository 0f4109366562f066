//! Gauss–Legendre quadrature rules for reference integrals.

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

#[cfg(test)]
mod tests {
    use super::*;

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
