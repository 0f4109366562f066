//! Minimises sums of squares by the Levenberg–Marquardt method with numerical or exact derivatives.

use rayon::prelude::*;

/// Solves `A x = b` for a symmetric positive definite `A` by Cholesky decomposition. Reads only the lower triangle of `A`, and returns
/// `None` if `A` is not positive definite.
fn solve(mut a: Vec<Vec<f64>>, mut b: Vec<f64>) -> Option<Vec<f64>> {
    let n = b.len();
    for i in 0..n {
        for j in 0..=i {
            let sum = a[i][j] - (0..j).map(|k| a[i][k] * a[j][k]).sum::<f64>();
            a[i][j] = if i == j { Some(sum).filter(|&s| s > 0.0)?.sqrt() } else { sum / a[j][j] };
        }
    }
    for i in 0..n {
        b[i] = (b[i] - (0..i).map(|k| a[i][k] * b[k]).sum::<f64>()) / a[i][i];
    }
    for i in (0..n).rev() {
        b[i] = (b[i] - (i + 1..n).map(|k| a[k][i] * b[k]).sum::<f64>()) / a[i][i];
    }
    Some(b)
}

/// Returns the parameters that minimise the sum of squared `residuals`. The search begins at `start` and takes at most
/// `steps` steps.
pub fn least_squares(start: Vec<f64>, steps: u32, residuals: impl Fn(&[f64]) -> Vec<f64>) -> Vec<f64> {
    let column = |p: &[f64], k: usize| {
        let h = 1e-5 * p[k].abs().max(0.1);
        let moved = |by: f64| {
            let mut q = p.to_vec();
            q[k] += by;
            residuals(&q)
        };
        moved(h).iter().zip(moved(-h)).map(|(a, b)| (a - b) / (2.0 * h)).collect()
    };
    least_squares_with(start, steps, &residuals, |p| (0..p.len()).map(|k| column(p, k)).collect())
}

/// Like [`least_squares`], with the exact derivatives of the residuals. `jacobian` returns one column per parameter. Parameters with an
/// infinite residual are never accepted.
pub fn least_squares_with(
    start: Vec<f64>,
    steps: u32,
    residuals: impl Fn(&[f64]) -> Vec<f64>,
    jacobian: impl Fn(&[f64]) -> Vec<Vec<f64>>,
) -> Vec<f64> {
    let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
    let mut p = start;
    let mut r = residuals(&p);
    let mut error: f64 = r.iter().map(|e| e * e).sum();
    let mut damping = 1e-2;
    for _ in 0..steps {
        let columns = jacobian(&p);
        let gradient: Vec<f64> = columns.iter().map(|j| -dot(j, &r)).collect();
        // The lower triangle of the normal matrix is all that the solver reads.
        let products: Vec<Vec<f64>> =
            (0..p.len()).into_par_iter().map(|i| columns[..=i].iter().map(|b| dot(&columns[i], b)).collect()).collect();
        let before = error;
        while damping < 1e8 {
            let mut normal = products.clone();
            normal.iter_mut().enumerate().for_each(|(i, row)| row[i] *= 1.0 + damping);
            let step = solve(normal, gradient.clone());
            let q: Option<Vec<f64>> = step.map(|s| p.iter().zip(s).map(|(p, s)| p + s).collect());
            let tried = q.map(|q| (residuals(&q), q));
            match tried.map(|(r, q)| (r.iter().map(|e| e * e).sum::<f64>(), r, q)) {
                Some((e, tried, q)) if e < error => {
                    (error, r, p) = (e, tried, q);
                    damping *= 0.2;
                    break;
                }
                _ => damping *= 4.0,
            }
        }
        if error > before * (1.0 - 1e-9) {
            break;
        }
    }
    p
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn cholesky_solves() {
        let x = solve(vec![vec![4.0, 1.0], vec![1.0, 3.0]], vec![1.0, 2.0]).unwrap();
        assert!((4.0 * x[0] + x[1] - 1.0).abs() < 1e-12 && (x[0] + 3.0 * x[1] - 2.0).abs() < 1e-12);
        assert!(solve(vec![vec![1.0, 2.0], vec![2.0, 1.0]], vec![1.0, 1.0]).is_none());
    }

    #[test]
    fn finds_a_curve_again() {
        let curve = |p: &[f64], x: f64| p[0] * (-p[1] * x).exp() + p[2];
        let wanted = [2.0, 0.7, -0.3];
        let residuals = |p: &[f64]| (0..20).map(|i| curve(p, f64::from(i)) - curve(&wanted, f64::from(i))).collect();
        let found = least_squares(vec![1.0, 0.2, 0.0], 50, residuals);
        assert!(found.iter().zip(wanted).all(|(a, b)| (a - b).abs() < 1e-6), "{found:?}");
    }
}
