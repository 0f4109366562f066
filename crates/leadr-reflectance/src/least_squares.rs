//! Least squares: linear ones by Householder's reflections, others by Levenberg and Marquardt's method with numerical derivatives.

/// The `x` of least `|A x − b|²`, `A` given by its rows, as many as `b` has numbers. `None` where the columns depend on each other, or if a number is
/// not finite.
#[must_use]
pub fn linear_least_squares(mut rows: Vec<Vec<f64>>, mut b: Vec<f64>) -> Option<Vec<f64>> {
    let n = rows.first()?.len();
    if rows.len() < n || rows.iter().flatten().chain(&b).any(|v| !v.is_finite()) {
        return None;
    }
    // Columns at length 1, so that what is small is small among its like.
    let norms: Vec<f64> = (0..n).map(|k| rows.iter().map(|r| r[k] * r[k]).sum::<f64>().sqrt()).collect();
    if norms.iter().any(|norm| *norm < 1e-150) {
        return None;
    }
    rows.iter_mut().for_each(|r| r.iter_mut().zip(&norms).for_each(|(v, norm)| *v /= norm));
    for k in 0..n {
        let length = rows[k..].iter().map(|r| r[k] * r[k]).sum::<f64>().sqrt();
        if length < 1e-14 {
            return None;
        }
        let end = if rows[k][k] > 0.0 { -length } else { length };
        // The mirror that takes the column to its first axis.
        let mut mirror: Vec<f64> = rows[k..].iter().map(|r| r[k]).collect();
        mirror[0] -= end;
        let square: f64 = mirror.iter().map(|v| v * v).sum();
        // By how much of the mirror each column, and the right side, moves.
        let along = |value: &dyn Fn(usize) -> f64| {
            2.0 * mirror.iter().enumerate().map(|(i, v)| v * value(k + i)).sum::<f64>() / square
        };
        let moves: Vec<f64> = (0..n).map(|j| along(&|i| rows[i][j])).collect();
        let moved = along(&|i| b[i]);
        for (i, v) in mirror.iter().enumerate() {
            rows[k + i].iter_mut().zip(&moves).skip(k).for_each(|(value, by)| *value -= by * v);
            b[k + i] -= moved * v;
        }
    }
    for k in (0..n).rev() {
        b[k] = (b[k] - (k + 1..n).map(|j| rows[k][j] * b[j]).sum::<f64>()) / rows[k][k];
    }
    Some(b[..n].iter().zip(&norms).map(|(x, norm)| x / norm).collect())
}

/// `x` with `A x = b` for a symmetric positive definite `A` (Cholesky); `None` if it is not.
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

/// Parameters of least squared `residuals`, from `start`, in at most `steps` steps.
#[must_use]
pub fn least_squares(start: Vec<f64>, steps: u32, residuals: impl Fn(&[f64]) -> Vec<f64>) -> Vec<f64> {
    let mut p = start;
    let mut r = residuals(&p);
    let mut error: f64 = r.iter().map(|e| e * e).sum();
    let mut damping = 1e-2;
    for _ in 0..steps {
        let jacobian: Vec<Vec<f64>> = (0..p.len())
            .map(|k| {
                let h = 1e-5 * p[k].abs().max(0.1);
                let moved = |by: f64| {
                    let mut q = p.clone();
                    q[k] += by;
                    residuals(&q)
                };
                moved(h).iter().zip(moved(-h)).map(|(a, b)| (a - b) / (2.0 * h)).collect()
            })
            .collect();
        let dot = |a: &[f64], b: &[f64]| a.iter().zip(b).map(|(x, y)| x * y).sum::<f64>();
        let gradient: Vec<f64> = jacobian.iter().map(|j| -dot(j, &r)).collect();
        let before = error;
        while damping < 1e8 {
            let normal = jacobian
                .iter()
                .enumerate()
                .map(|(i, a)| {
                    let row = jacobian.iter().enumerate();
                    row.map(|(j, b)| dot(a, b) * if i == j { 1.0 + damping } else { 1.0 }).collect()
                })
                .collect();
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
    fn linear_problems_have_their_normal_equations() {
        let rows: Vec<Vec<f64>> = (0..30).map(|i| (0..6).map(|k| (f64::from(i) / 29.0).powi(k)).collect()).collect();
        let b: Vec<f64> = (0..30).map(|i| f64::from(i).sin()).collect();
        let x = linear_least_squares(rows.clone(), b.clone()).unwrap();
        // What is left is at right angles to every column.
        for k in 0..6 {
            let along: f64 =
                rows.iter().zip(&b).map(|(r, b)| r[k] * (r.iter().zip(&x).map(|(a, x)| a * x).sum::<f64>() - b)).sum();
            assert!(along.abs() < 1e-11, "{k}: {along:e}");
        }
        assert!(linear_least_squares(vec![vec![1.0, 2.0], vec![2.0, 4.0], vec![3.0, 6.0]], vec![1.0; 3]).is_none());
        assert!(linear_least_squares(vec![vec![1.0, 2.0]], vec![1.0]).is_none());
        assert!(linear_least_squares(vec![vec![f64::NAN], vec![1.0]], vec![1.0; 2]).is_none());
        assert!(linear_least_squares(Vec::new(), Vec::new()).is_none());
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
