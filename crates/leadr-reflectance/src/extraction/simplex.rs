//! Minimises a function of a few parameters by the simplex method of Nelder and Mead (1965).

/// The size of the simplex, relative to the first step, at which the search stops.
const FINEST: f64 = 1e-3;

/// Returns the parameters that minimise `value`, and the minimum. The first simplex has a corner at `start` and one at a distance of `step`
/// along each axis. NaN counts as infinity.
pub fn minimise<const N: usize>(
    start: [f64; N],
    step: [f64; N],
    most: u32,
    value: impl Fn(&[f64; N]) -> f64,
) -> ([f64; N], f64) {
    let value = |at: &[f64; N]| Some(value(at)).filter(|v| !v.is_nan()).unwrap_or(f64::INFINITY);
    let corner = |axis: Option<usize>| {
        let mut at = start;
        if let Some(axis) = axis {
            at[axis] += step[axis];
        }
        (at, value(&at))
    };
    let mut corners: Vec<([f64; N], f64)> = std::iter::once(None).chain((0..N).map(Some)).map(corner).collect();
    for _ in 0..most {
        corners.sort_by(|a, b| a.1.total_cmp(&b.1));
        let (best, worst) = (corners[0].0, corners[N]);
        let spread = |axis: usize| corners.iter().map(|(at, _)| (at[axis] - best[axis]).abs()).fold(0.0, f64::max);
        if (0..N).all(|axis| spread(axis) <= FINEST * step[axis].abs()) {
            break;
        }
        let middle: [f64; N] =
            std::array::from_fn(|axis| corners[..N].iter().map(|(at, _)| at[axis]).sum::<f64>() / N as f64);
        let along = |t: f64| {
            let at = std::array::from_fn(|axis| middle[axis] + t * (worst.0[axis] - middle[axis]));
            (at, value(&at))
        };
        let reflected = along(-1.0);
        let replacement = if reflected.1 < corners[0].1 {
            Some([along(-2.0), reflected].into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).expect("two points"))
        } else if reflected.1 < corners[N - 1].1 {
            Some(reflected)
        } else {
            let inner = along(if reflected.1 < worst.1 { -0.5 } else { 0.5 });
            (inner.1 < worst.1.min(reflected.1)).then_some(inner)
        };
        match replacement {
            Some(better) => corners[N] = better,
            None => {
                for other in &mut corners[1..] {
                    let at = std::array::from_fn(|axis| 0.5 * (best[axis] + other.0[axis]));
                    *other = (at, value(&at));
                }
            }
        }
    }
    corners.into_iter().min_by(|a, b| a.1.total_cmp(&b.1)).expect("a simplex has corners")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_curved_valley_is_followed() {
        let rosenbrock = |&[x, y]: &[f64; 2]| (1.0 - x).powi(2) + 100.0 * (y - x * x).powi(2);
        let ([x, y], least) = minimise([-1.2, 1.0], [0.5, 0.5], 500, rosenbrock);
        assert!((x - 1.0).abs() < 0.01 && (y - 1.0).abs() < 0.01 && least < 1e-4, "{x} {y} {least}");
        let bounded = |&[x]: &[f64; 1]| if x < 0.3 { f64::NAN } else { x };
        assert!((minimise([1.0], [0.1], 500, bounded).0[0] - 0.3).abs() < 1e-3);
    }
}
