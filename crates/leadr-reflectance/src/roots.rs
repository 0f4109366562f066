//! Finds roots of increasing functions of one variable.

/// Returns the point between `low` and `high` where `below` becomes false, after `steps` bisections.
pub(crate) fn bisect(mut low: f64, mut high: f64, steps: u32, below: impl Fn(f64) -> bool) -> f64 {
    for _ in 0..steps {
        let middle = 0.5 * (low + high);
        if below(middle) { low = middle } else { high = middle }
    }
    0.5 * (low + high)
}

/// Returns the root `x` in `[low, high]` of an increasing `f`, to rounding error. If the interval has no root, the result is the nearer
/// end.
///
/// The method is regula falsi with the Illinois modification (Dowell and Jarratt 1971). The bracket always holds the root, and nearly
/// linear functions take a few steps. Bisection takes over if regula falsi stalls.
pub(crate) fn increasing_root(low: f64, high: f64, f: impl Fn(f64) -> f64) -> f64 {
    let (mut a, mut b) = (low, high);
    let (mut fa, mut fb) = (f(a), f(b));
    let mut above = None;
    // A comparison with NaN is false, so the function then returns the upper end.
    if fa >= 0.0 {
        return low;
    }
    if fb <= 0.0 || fa.is_nan() || fb.is_nan() {
        return high;
    }
    for step in 0..120 {
        let chord = b - fb * ((b - a) / (fb - fa));
        let x = if step > 40 || !(chord > a && chord < b) { 0.5 * (a + b) } else { chord };
        let y = f(x);
        if y == 0.0 || x <= a || x >= b || (b - a) <= 2.0 * f64::EPSILON * x.abs() {
            return x;
        }
        // If one end of the bracket stays for two steps, halve its function value. The next chord then ends further from this end.
        let again = above == Some(y > 0.0);
        above = Some(y > 0.0);
        if y > 0.0 {
            (b, fb) = (x, y);
            fa *= if again { 0.5 } else { 1.0 };
        } else {
            (a, fa) = (x, y);
            fb *= if again { 0.5 } else { 1.0 };
        }
    }
    0.5 * (a + b)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn roots_are_found_and_ends_held() {
        assert!((increasing_root(0.0, 3.0, |x| x * x - 2.0) - 2f64.sqrt()).abs() < 1e-15);
        assert!((increasing_root(-9.0, 50.0, |x| x.exp() - 2.0) - 2f64.ln()).abs() < 1e-14);
        assert!((increasing_root(-1.0, 1.0, |x| (x - 0.2).cbrt()) - 0.2).abs() < 1e-12);
        assert_eq!(increasing_root(1.0, 2.0, |x| x), 1.0);
        assert_eq!(increasing_root(-2.0, -1.0, |x| x), -1.0);
        assert_eq!(increasing_root(0.0, 1.0, |_| f64::NAN), 1.0);
    }
}
