//! Finds the parametric curve that is nearest to extracted slopes.

use std::f64::consts::TAU;

use crate::facets::parametric_curve::{Family, ParametricCurve};
use crate::facets::radial_table::{RadialTable, angle_rule};

/// The step size at which the search stops.
const FINEST: f64 = 1e-5;
/// The range of the search for the exponent. Exponents outside this range do not describe realistic facets.
const EXPONENTS: (f64, f64) = (-2.0, 20.0);

/// Returns the maximum-likelihood curve of a family for the slopes of a table.
pub fn nearest(slopes: &RadialTable, family: Family) -> ParametricCurve {
    let rule: Vec<(f64, f64)> =
        angle_rule(slopes.nodes()).into_iter().map(|(theta, w)| (theta, TAU * w * theta.sin() * theta.cos())).collect();
    let masses: Vec<f64> = rule.iter().map(|&(theta, area)| area * slopes.density(theta)).collect();
    // This is the Kullback–Leibler divergence, without the terms that all curves share.
    let divergence = |curve: &ParametricCurve| {
        let (mut likelihood, mut norm) = (0.0, 0.0);
        for (&(theta, area), mass) in rule.iter().zip(&masses) {
            let ln = curve.ln_density(theta);
            likelihood += mass * ln;
            norm += area * ln.exp();
        }
        norm.ln() - likelihood
    };
    let width = slopes.variance().sqrt().clamp(1e-3, 1.0);
    let starts: &[[f64; 2]] = match family {
        Family::ShiftedGamma => &[[width.ln(), 0.5], [(0.1 * width).ln(), 1.5]],
        Family::Abc => &[[-2.0 * width.ln(), 2.0], [-2.0 * (0.1 * width).ln(), 1.0]],
    };
    let searched = starts.iter().map(|start| search(family, *start, &divergence));
    let best = searched.min_by(|a, b| a.1.total_cmp(&b.1));
    ParametricCurve::of(family, best.map_or(starts[0], |(parameters, _)| parameters))
}

/// Runs a pattern search from `parameters`. The step size is halved when no direction improves the divergence.
fn search(family: Family, mut parameters: [f64; 2], divergence: &impl Fn(&ParametricCurve) -> f64) -> ([f64; 2], f64) {
    let value = |parameters: [f64; 2]| {
        let inside = (EXPONENTS.0..=EXPONENTS.1).contains(&parameters[1]) && parameters[0].abs() < 20.0;
        let found = if inside { divergence(&ParametricCurve::of(family, parameters)) } else { f64::INFINITY };
        if found.is_nan() { f64::INFINITY } else { found }
    };
    let (mut best, mut step) = (value(parameters), 0.5);
    while step > FINEST {
        // Width and exponent are correlated, so the search also takes diagonal steps.
        let directions = [[1.0, 0.0], [0.0, 1.0], [0.7, 0.7], [0.7, -0.7], [0.9, 0.3], [0.9, -0.3]];
        let tried = directions
            .into_iter()
            .flat_map(|d| [1.0, -1.0].map(|sign| [0, 1].map(|k| parameters[k] + sign * step * d[k])));
        let better = tried.map(|p| (p, value(p))).min_by(|a, b| a.1.total_cmp(&b.1));
        match better {
            Some((p, v)) if v < best => (parameters, best) = (p, v),
            _ => step *= 0.5,
        }
    }
    (parameters, best)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::facets::ggx::Ggx;
    use crate::facets::radial_table::angle_at;
    use crate::facets::slope_distribution::SlopeDistribution as _;
    use glam::{DVec2, DVec3};

    #[test]
    fn curves_are_found_again() {
        for curve in [
            ParametricCurve::ShiftedGamma { alpha: 0.1, p: 0.6 },
            ParametricCurve::ShiftedGamma { alpha: 0.4, p: 1.2 },
            ParametricCurve::Abc { b: 300.0, c: 1.8 },
            ParametricCurve::Abc { b: 20.0, c: 4.0 },
        ] {
            let family = if matches!(curve, ParametricCurve::Abc { .. }) { Family::Abc } else { Family::ShiftedGamma };
            let found = nearest(&curve.table().unwrap(), family);
            let parameters = |c: &ParametricCurve| match *c {
                ParametricCurve::ShiftedGamma { alpha, p } => [alpha, p],
                ParametricCurve::Abc { b, c } => [b, c],
            };
            for (found, expected) in parameters(&found).into_iter().zip(parameters(&curve)) {
                assert!((found / expected - 1.0).abs() < 0.02, "{found} {expected}: {curve:?}");
            }
        }
    }

    /// Near its peak, GGX is `D ∝ (1 + 2 (1 − cos θ) / α²)⁻²`.
    #[test]
    fn ggx_is_nearly_an_abc_curve() {
        let alpha = 0.1;
        let ggx = Ggx::isotropic(DVec2::ZERO, alpha);
        let at = |i: usize| {
            let (sine, cosine) = angle_at(i as f64 / 90.0).sin_cos();
            ggx.ndf(DVec3::new(sine, 0.0, cosine))
        };
        let table = RadialTable::new(&(0..90).map(at).collect::<Vec<_>>()).unwrap();
        let ParametricCurve::Abc { b, c } = nearest(&table, Family::Abc) else { panic!("another family") };
        assert!((c - 2.0).abs() < 0.15 && (b * alpha * alpha / 2.0 - 1.0).abs() < 0.15, "{b} {c}");
    }
}
