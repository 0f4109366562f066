//! Polynomials over polynomials in one or two variables, fitted to numbers (Chan 2018, section 3, after Schlick 1994).
//!
//! ```text
//! f = (c₀ t₀ + c₁ t₁ + …) / (1 + d₁ u₁ + …)
//! ```
//!
//! with terms `t`, `u` that are powers or sums of powers: a symmetric function of two variables has terms like `a² + b²`. The constant of the
//! denominator is 1 (Chan's eq. 39). Values that must be met exactly are linear in the coefficients, `N(p) − v D(p) = 0`, and are solved for
//! some of them before anything is fitted, as Chan's eq. 41 does by hand.
//!
//! The fit starts from a linear problem, `Σ w² (N − f D)² / D²` with the `D` of the step before (Sanathanan and Koerner 1963), goes on by Levenberg and Marquardt's
//! method, and may then weight samples by their errors until the largest one is as small as can be (Lawson 1961). A fit whose denominator is not proven positive on the whole box of
//! the samples is refused.

use super::least_squares::{least_squares, linear_least_squares};
use glam::DVec2;

/// Beyond it, 1e9, a coefficient says that the form does not suit.
const LARGEST_COEFFICIENT: f64 = 1e9;

/// A sum of powers `x^i y^j`, each with the coefficient 1.
pub type Term = Vec<[i32; 2]>;

/// Which terms a function has. The constant of the denominator is not among its terms.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct RationalForm {
    /// Of the numerator.
    pub numerator: Vec<Term>,
    /// Of the denominator, but its 1.
    pub denominator: Vec<Term>,
}

impl RationalForm {
    /// Powers of one variable, the first: up to `numerator` and `denominator`.
    #[must_use]
    pub fn powers(numerator: i32, denominator: i32) -> Self {
        let powers = |from: i32, to: i32| (from..=to).map(|k| vec![[k, 0]]).collect();
        Self { numerator: powers(0, numerator), denominator: powers(1, denominator) }
    }

    /// Symmetric terms in two variables up to these total degrees: `1, a + b, a² + b², ab, …`.
    #[must_use]
    pub fn symmetric(numerator: i32, denominator: i32) -> Self {
        let terms = |from: i32, to: i32| {
            let pairs = (from..=to).flat_map(|degree| (0..=degree / 2).map(move |j| [degree - j, j]));
            pairs.map(|[i, j]| if i == j { vec![[i, j]] } else { vec![[i, j], [j, i]] }).collect()
        };
        Self { numerator: terms(0, numerator), denominator: terms(1, denominator) }
    }

    /// All powers of two variables up to these total degrees.
    #[must_use]
    pub fn plane(numerator: i32, denominator: i32) -> Self {
        let terms = |from: i32, to: i32| {
            (from..=to).flat_map(|degree| (0..=degree).map(move |j| vec![[degree - j, j]])).collect()
        };
        Self { numerator: terms(0, numerator), denominator: terms(1, denominator) }
    }
}

/// A number to fit.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct RationalSample {
    /// Where; a function of one variable ignores `y`.
    pub at: DVec2,
    /// What the function should be.
    pub value: f64,
    /// By how much its error counts; 1 over the value for relative errors.
    pub weight: f64,
}

/// What to minimise.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Norm {
    /// The sum of squares of weighted errors.
    #[default]
    Squares,
    /// The largest weighted error.
    Largest,
}

/// A rational function.
#[derive(Clone, Debug, PartialEq)]
pub struct Rational {
    /// Its terms.
    pub form: RationalForm,
    /// Coefficients of the numerator.
    pub numerator: Vec<f64>,
    /// Coefficients of the denominator, without its 1.
    pub denominator: Vec<f64>,
}

/// Why there is no fit.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum RationalFault {
    /// Fewer numbers than coefficients, terms that the samples cannot tell apart, or none that suit a denominator that begins with 1.
    #[error("the samples do not determine the coefficients: give more of them, or fewer or other terms")]
    Undetermined,
    /// A number is not finite, or a weight is negative.
    #[error("samples and fixed values are finite numbers, and weights are not negative")]
    NotFinite,
    /// Fixed values contradict each other.
    #[error("the fixed values contradict each other or leave no coefficient to fit")]
    Contradiction,
    /// The denominator has a zero among the samples, or comes too near one.
    #[error("the denominator is not positive near ({x}, {y}): use fewer terms there")]
    Pole {
        /// First variable.
        x: f64,
        /// Second variable.
        y: f64,
    },
}

fn term(term: &Term, at: DVec2) -> f64 {
    term.iter().map(|[i, j]| at.x.powi(*i) * at.y.powi(*j)).sum()
}

fn sum(terms: &[Term], coefficients: &[f64], at: DVec2) -> f64 {
    terms.iter().zip(coefficients).map(|(t, c)| c * term(t, at)).sum()
}

impl Rational {
    fn of(form: &RationalForm, coefficients: &[f64]) -> Self {
        let (numerator, denominator) = coefficients.split_at(form.numerator.len());
        Self { form: form.clone(), numerator: numerator.to_vec(), denominator: denominator.to_vec() }
    }

    /// The value, of one variable at `(x, 0)`. Infinite or NaN at a pole, which a fit has none of within its samples.
    #[must_use]
    pub fn eval(&self, at: DVec2) -> f64 {
        sum(&self.form.numerator, &self.numerator, at) / self.divisor(at)
    }

    fn divisor(&self, at: DVec2) -> f64 {
        1.0 + sum(&self.form.denominator, &self.denominator, at)
    }

    /// Where between `low` and `high` the denominator is not positive, as far as intervals can tell.
    fn pole(&self, low: DVec2, high: DVec2) -> Option<DVec2> {
        let mut boxes = vec![(low, high)];
        let mut tried = 0;
        while let Some((low, high)) = boxes.pop() {
            let middle = 0.5 * (low + high);
            tried += 1;
            if self.divisor(middle) <= 0.0 || tried > 200_000 {
                return Some(middle);
            }
            if self.least_divisor(low, high) > 0.0 {
                continue;
            }
            let (mut first, mut second) = (high, low);
            if high.x - low.x >= high.y - low.y {
                (first.x, second.x) = (middle.x, middle.x);
            } else {
                (first.y, second.y) = (middle.y, middle.y);
            }
            if first == high && second == low {
                return Some(middle);
            }
            boxes.extend([(low, first), (second, high)]);
        }
        None
    }

    /// A lower bound of the denominator over a box: its value in the middle less what its derivatives may take away.
    fn least_divisor(&self, low: DVec2, high: DVec2) -> f64 {
        let range = |low: f64, high: f64, k: i32| {
            if k < 0 {
                // Of a derivative that is 0.
                return (0.0, 0.0);
            }
            let (a, b) = (low.powi(k), high.powi(k));
            if k > 0 && k % 2 == 0 && low < 0.0 && high > 0.0 { (0.0, a.max(b)) } else { (a.min(b), a.max(b)) }
        };
        let steepest = |dx: i32, dy: i32| {
            let (mut least, mut most) = (0.0, 0.0);
            for (terms, c) in self.form.denominator.iter().zip(&self.denominator) {
                for [i, j] in terms {
                    let ((xl, xh), (yl, yh)) = (range(low.x, high.x, i - dx), range(low.y, high.y, j - dy));
                    let factor = c * f64::from(if dx > 0 { *i } else { *j });
                    let products = [xl * yl, xl * yh, xh * yl, xh * yh].map(|p| factor * p);
                    least += products.into_iter().fold(f64::INFINITY, f64::min);
                    most += products.into_iter().fold(f64::NEG_INFINITY, f64::max);
                }
            }
            f64::max(-least, most)
        };
        let half = 0.5 * (high - low);
        self.divisor(0.5 * (low + high)) - half.x * steepest(1, 0) - half.y * steepest(0, 1)
    }
}

/// Coefficients as `fixed + free · y`: what is left to choose once some values are fixed.
struct Choice {
    fixed: Vec<f64>,
    /// One row per coefficient.
    free: Vec<Vec<f64>>,
}

impl Choice {
    /// Of `n` coefficients under `equations`, each a row and its right side.
    fn new(n: usize, mut equations: Vec<(Vec<f64>, f64)>) -> Option<Self> {
        let mut pivots = Vec::new();
        for k in 0..equations.len() {
            let candidates = (k..equations.len()).flat_map(|i| (0..n).map(move |j| (i, j)));
            let (i, j) = candidates
                .max_by(|&(i, j), &(k, l)| equations[i].0[j].abs().total_cmp(&equations[k].0[l].abs()))
                .filter(|&(i, j)| equations[i].0[j].abs() > 1e-12)
                .unwrap_or((k, n));
            if j == n {
                // The rest says nothing new, or the impossible.
                if equations[k..].iter().any(|e| e.1.abs() > 1e-9) {
                    return None;
                }
                break;
            }
            equations.swap(k, i);
            let scale = equations[k].0[j];
            equations[k].0.iter_mut().for_each(|v| *v /= scale);
            equations[k].1 /= scale;
            let (row, right) = equations[k].clone();
            for (_, other) in equations.iter_mut().enumerate().filter(|(i, _)| *i != k) {
                let by = other.0[j];
                other.0.iter_mut().zip(&row).for_each(|(v, r)| *v -= by * r);
                other.1 -= by * right;
            }
            pivots.push(j);
        }
        let open: Vec<usize> = (0..n).filter(|j| !pivots.contains(j)).collect();
        let (mut fixed, mut free) = (vec![0.0; n], vec![vec![0.0; open.len()]; n]);
        for (column, &j) in open.iter().enumerate() {
            free[j][column] = 1.0;
            for (pivot, equation) in pivots.iter().zip(&equations) {
                free[*pivot][column] = -equation.0[j];
            }
        }
        for (pivot, equation) in pivots.iter().zip(&equations) {
            fixed[*pivot] = equation.1;
        }
        (!open.is_empty()).then_some(Self { fixed, free })
    }

    fn coefficients(&self, y: &[f64]) -> Vec<f64> {
        let by = |row: &Vec<f64>| row.iter().zip(y).map(|(a, b)| a * b).sum::<f64>();
        self.fixed.iter().zip(&self.free).map(|(f, row)| f + by(row)).collect()
    }
}

/// A sample with its terms at hand.
struct Row {
    /// Terms of the numerator and of the denominator.
    terms: Vec<f64>,
    value: f64,
    weight: f64,
}

impl Row {
    /// Numerator and denominator.
    fn parts(&self, coefficients: &[f64], split: usize) -> (f64, f64) {
        let dot = |range: std::ops::Range<usize>| -> f64 { range.map(|k| coefficients[k] * self.terms[k]).sum() };
        (dot(0..split), 1.0 + dot(split..self.terms.len()))
    }

    /// The weighted error; huge where the denominator is not positive.
    fn error(&self, coefficients: &[f64], split: usize) -> f64 {
        let (n, d) = self.parts(coefficients, split);
        if d > 1e-9 { self.weight * (n / d - self.value) } else { 1e30 }
    }
}

/// The function of this form that is nearest to the samples and meets the `fixed` values, each a place and a value, exactly.
///
/// # Errors
/// A [`RationalFault`] for numbers that are not finite, too few samples, contradicting fixed values, and a denominator with a zero among the samples.
pub fn fit_rational(
    form: &RationalForm,
    samples: &[RationalSample],
    fixed: &[(DVec2, f64)],
    norm: Norm,
) -> Result<Rational, RationalFault> {
    let finite = |at: DVec2, value: f64| at.is_finite() && value.is_finite();
    let sound = samples.iter().all(|s| finite(s.at, s.value) && s.weight.is_finite() && s.weight >= 0.0);
    if !sound || !fixed.iter().all(|f| finite(f.0, f.1)) {
        return Err(RationalFault::NotFinite);
    }
    let split = form.numerator.len();
    let terms_at =
        |at: DVec2| -> Vec<f64> { form.numerator.iter().chain(&form.denominator).map(|t| term(t, at)).collect() };
    let equations = fixed
        .iter()
        .map(|&(at, value)| {
            let mut row = terms_at(at);
            row[split..].iter_mut().for_each(|v| *v *= -value);
            (row, value)
        })
        .collect();
    let choice = Choice::new(split + form.denominator.len(), equations).ok_or(RationalFault::Contradiction)?;
    let rows: Vec<Row> =
        samples.iter().map(|s| Row { terms: terms_at(s.at), value: s.value, weight: s.weight }).collect();
    let errors = |rows: &[Row], y: &[f64]| -> Vec<f64> {
        let coefficients = choice.coefficients(y);
        rows.iter().map(|row| row.error(&coefficients, split)).collect()
    };
    // Starts with a stiff denominator find their way where those without meet a pole.
    let starts = [0.0, 1e-4, 1e-2, 1.0].into_iter().filter_map(|stiffness| start(&rows, &choice, split, stiffness));
    let square = |y: &[f64]| errors(&rows, y).iter().map(|e| e * e).sum::<f64>();
    let ends = starts.map(|y| least_squares(y, 100, |y| errors(&rows, y))).map(|y| (square(&y), y));
    // A function whose denominator begins with 0 has no such form: its coefficients grow without end.
    let sound = ends.filter(|end| choice.coefficients(&end.1).iter().all(|c| c.abs() < LARGEST_COEFFICIENT));
    let mut ends: Vec<(f64, Vec<f64>)> = sound.collect();
    ends.sort_by(|a, b| a.0.total_cmp(&b.0));
    let corners = samples.iter().map(|s| (s.at, s.at)).reduce(|(l, h), (a, _)| (l.min(a), h.max(a)));
    let pole = |y: &[f64]| corners.and_then(|(low, high)| Rational::of(form, &choice.coefficients(y)).pole(low, high));
    let first = ends.first().ok_or(RationalFault::Undetermined)?;
    let mut y = match ends.iter().find(|end| pole(&end.1).is_none()) {
        Some(end) => end.1.clone(),
        None => {
            return Err(
                pole(&first.1).map_or(RationalFault::Undetermined, |at| RationalFault::Pole { x: at.x, y: at.y })
            );
        }
    };
    if norm == Norm::Largest {
        let asked: Vec<f64> = rows.iter().map(|row| row.weight).collect();
        let largest = |y: &[f64]| {
            let coefficients = choice.coefficients(y);
            let weighted = rows
                .iter()
                .zip(&asked)
                .map(|(row, w)| if *w > 0.0 { row.error(&coefficients, split).abs() } else { 0.0 });
            weighted.fold(0.0, f64::max)
        };
        let mut best = (largest(&y), y.clone());
        let mut shares = vec![1.0; rows.len()];
        for _ in 0..200 {
            let now: Vec<f64> = errors(&rows, &y).into_iter().map(f64::abs).collect();
            let top = now.iter().copied().fold(1e-300, f64::max);
            shares.iter_mut().zip(&now).for_each(|(s, e)| *s *= 0.02 + e / top);
            let most = shares.iter().copied().fold(1e-300, f64::max);
            shares.iter_mut().for_each(|s| *s = (*s / most).max(1e-12));
            y = least_squares(y, 6, |y| errors(&rows, y).iter().zip(&shares).map(|(e, s)| e * s.sqrt()).collect());
            let found = largest(&y);
            let sound = || choice.coefficients(&y).iter().all(|c| c.abs() < LARGEST_COEFFICIENT) && pole(&y).is_none();
            if found < best.0 && sound() {
                best = (found, y.clone());
            }
        }
        y = best.1;
    }
    Ok(Rational::of(form, &choice.coefficients(&y)))
}

/// What is free, from linear problems alone; the best of their steps. `stiffness`: how much coefficients of the denominator count as errors.
fn start(rows: &[Row], choice: &Choice, split: usize, stiffness: f64) -> Option<Vec<f64>> {
    let stiff = stiffness * rows.iter().map(|row| (row.weight * row.value).powi(2)).sum::<f64>().sqrt();
    let mut best: Option<(f64, Vec<f64>)> = None;
    let mut coefficients: Option<Vec<f64>> = None;
    for _ in 0..30 {
        let (mut system, mut right) = (Vec::new(), Vec::new());
        for row in rows {
            let divisor = coefficients.as_ref().map_or(1.0, |c| row.parts(c, split).1.abs().max(1e-3));
            let weight = row.weight / divisor;
            let scaled: Vec<f64> = row
                .terms
                .iter()
                .enumerate()
                .map(|(k, t)| weight * if k < split { *t } else { -row.value * t })
                .collect();
            let against =
                |column: usize| scaled.iter().zip(&choice.free).map(|(s, free)| s * free[column]).sum::<f64>();
            system.push((0..choice.free[0].len()).map(against).collect());
            right.push(weight * row.value - scaled.iter().zip(&choice.fixed).map(|(s, f)| s * f).sum::<f64>());
        }
        if stiff > 0.0 {
            for k in split..choice.fixed.len() {
                system.push(choice.free[k].iter().map(|v| stiff * v).collect());
                right.push(-stiff * choice.fixed[k]);
            }
        }
        let Some(y) = linear_least_squares(system, right) else { break };
        let found = choice.coefficients(&y);
        let error = rows.iter().map(|row| row.error(&found, split).powi(2)).sum::<f64>();
        if best.as_ref().is_none_or(|b| error < b.0) {
            best = Some((error, y));
        }
        coefficients = Some(found);
    }
    best.map(|b| b.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn line(n: usize, f: impl Fn(f64) -> f64) -> Vec<RationalSample> {
        (0..n)
            .map(|i| {
                let x = i as f64 / (n - 1) as f64;
                RationalSample { at: DVec2::new(x, 0.0), value: f(x), weight: 1.0 }
            })
            .collect()
    }

    #[test]
    fn finds_rational_functions_again() {
        let wanted = Rational {
            form: RationalForm::powers(3, 2),
            numerator: vec![0.66693, 0.0609009, 7.32398, 0.600464],
            denominator: vec![-1.13467, 8.78264],
        };
        let found =
            fit_rational(&wanted.form, &line(60, |x| wanted.eval(DVec2::new(x, 0.0))), &[], Norm::Squares).unwrap();
        for (a, b) in
            found.numerator.iter().chain(&found.denominator).zip(wanted.numerator.iter().chain(&wanted.denominator))
        {
            assert!((a - b).abs() < 1e-7, "{found:?}");
        }
        let wanted = Rational {
            form: RationalForm::symmetric(2, 1),
            numerator: vec![0.5, 1.0, -0.3, 2.0],
            denominator: vec![3.0],
        };
        let grid: Vec<RationalSample> = (0..100)
            .map(|i| {
                let at = DVec2::new(f64::from(i % 10), f64::from(i / 10)) / 9.0;
                RationalSample { at, value: wanted.eval(at), weight: 1.0 }
            })
            .collect();
        let found = fit_rational(&wanted.form, &grid, &[], Norm::Squares).unwrap();
        assert!(found.numerator.iter().zip(&wanted.numerator).all(|(a, b)| (a - b).abs() < 1e-9), "{found:?}");
        // Without symmetry in the form, the fit finds it.
        let plane = fit_rational(&RationalForm::plane(2, 1), &grid, &[], Norm::Squares).unwrap();
        assert!((plane.numerator[1] - plane.numerator[2]).abs() < 1e-9 && (plane.numerator[1] - 1.0).abs() < 1e-9);
    }

    #[test]
    fn fixed_values_are_met() {
        let fixed = [(DVec2::ZERO, 1.0), (DVec2::X, 1f64.exp())];
        let found = fit_rational(&RationalForm::powers(2, 2), &line(50, f64::exp), &fixed, Norm::Squares).unwrap();
        for (at, value) in fixed {
            assert!((found.eval(at) - value).abs() < 1e-13);
        }
        let free = fit_rational(&RationalForm::powers(2, 2), &line(50, f64::exp), &[], Norm::Squares).unwrap();
        let squares = |f: &Rational| line(50, f64::exp).iter().map(|s| (f.eval(s.at) - s.value).powi(2)).sum::<f64>();
        assert!(squares(&free) < squares(&found) && (free.eval(DVec2::ZERO) - 1.0).abs() > 1e-8);
    }

    /// Errors of the best fit alternate: four equal extremes for three coefficients.
    #[test]
    fn the_largest_error_is_as_small_as_can_be() {
        let samples = line(400, f64::exp);
        let form = RationalForm::powers(1, 1);
        let [squares, largest] = [Norm::Squares, Norm::Largest].map(|n| fit_rational(&form, &samples, &[], n).unwrap());
        let errors = |f: &Rational| samples.iter().map(|s| f.eval(s.at) - s.value).collect::<Vec<f64>>();
        let top = |f: &Rational| errors(f).into_iter().fold(0.0f64, |t, e| t.max(e.abs()));
        assert!(top(&largest) < 0.8 * top(&squares), "{} {}", top(&largest), top(&squares));
        let limit = 0.97 * top(&largest);
        let signs: Vec<bool> = errors(&largest).into_iter().filter(|e| e.abs() > limit).map(|e| e > 0.0).collect();
        assert_eq!(1 + signs.windows(2).filter(|w| w[0] != w[1]).count(), 4);
    }

    #[test]
    fn weights_move_the_error() {
        let error = |weight: f64| {
            let mut samples = line(50, f64::exp);
            samples[25].weight = weight;
            let found = fit_rational(&RationalForm::powers(1, 0), &samples, &[], Norm::Squares).unwrap();
            (found.eval(samples[25].at) - samples[25].value).abs()
        };
        assert!(error(100.0) < 0.1 * error(1.0));
    }

    #[test]
    fn what_cannot_be_fitted_is_refused() {
        let samples = line(40, f64::exp);
        let fit = |form: &RationalForm, samples: &[RationalSample], fixed: &[(DVec2, f64)]| {
            fit_rational(form, samples, fixed, Norm::Squares).unwrap_err()
        };
        let form = RationalForm::powers(2, 1);
        assert_eq!(fit(&form, &samples[..2], &[]), RationalFault::Undetermined);
        assert_eq!(fit(&form, &[], &[]), RationalFault::Undetermined);
        // Two values at one place: only 0/0 has them.
        assert!(matches!(fit(&form, &samples, &[(DVec2::X, 1.0), (DVec2::X, 2.0)]), RationalFault::Pole { .. }));
        let straight = RationalForm::powers(1, 0);
        assert_eq!(fit(&straight, &samples, &[(DVec2::X, 1.0), (DVec2::X, 2.0)]), RationalFault::Contradiction);
        let all: Vec<_> = (0..4).map(|i| (DVec2::new(f64::from(i), 0.0), f64::from(i * i))).collect();
        assert_eq!(fit(&form, &samples, &all), RationalFault::Contradiction);
        let mut odd = samples.clone();
        odd[3].value = f64::NAN;
        assert_eq!(fit(&form, &odd, &[]), RationalFault::NotFinite);
        odd[3] = RationalSample { weight: -1.0, ..samples[3] };
        assert_eq!(fit(&form, &odd, &[]), RationalFault::NotFinite);
        assert!(!RationalFault::Pole { x: 0.5, y: 0.0 }.to_string().contains('\n'));
        // 1/x begins with 0.
        let mut inverse = line(40, |x| 1.0 / (x + 1e-12));
        inverse[0].weight = 0.0;
        assert_eq!(fit(&RationalForm::powers(0, 1), &inverse, &[]), RationalFault::Undetermined);
        // A pole among the samples: what is found has none.
        let found = fit_rational(&RationalForm::powers(0, 1), &line(39, |x| 1.0 / (1.0 - 3.0 * x)), &[], Norm::Squares);
        assert!(found.is_ok_and(|f| f.pole(DVec2::ZERO, DVec2::X).is_none()));
    }

    #[test]
    fn poles_between_samples_are_found() {
        let rational =
            |denominator: Vec<f64>| Rational { form: RationalForm::symmetric(0, 2), numerator: vec![1.0], denominator };
        // (a + b − 1)² + ε, negative only for ε < 0 and along a thin line.
        for (epsilon, poles) in [(-1e-6, true), (1e-3, false)] {
            let scale = 1.0 + epsilon;
            let r = rational(vec![-2.0 / scale, 1.0 / scale, 2.0 / scale]);
            assert_eq!(r.pole(DVec2::ZERO, DVec2::ONE).is_some(), poles, "{epsilon}");
        }
        // Powers of negative numbers.
        assert!(rational(vec![0.0, -0.4, 0.0]).pole(DVec2::splat(-1.0), DVec2::splat(1.0)).is_none());
        assert!(rational(vec![0.0, -0.6, 0.0]).pole(DVec2::splat(-1.0), DVec2::splat(1.0)).is_some());
    }
}
