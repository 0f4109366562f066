//! Fits the published models SGD ([`ShiftedGamma`]) and [`Abc`] to an isotropic material, for comparison with tabulated facets (thesis
//! Figure 4.3).
//!
//! Both models are linear in most of their parameters. A simplex search varies the others, and weighted least squares with nonnegative
//! unknowns finds the linear ones. The error is that of [`Misfit::perceptual`](super::samples::Misfit::perceptual). The authors published
//! parameters for the MERL materials only, and used other searches and error metrics.

use std::f64::consts::FRAC_1_PI;

use glam::DVec3;
use rayon::prelude::*;

use super::parametric::nearest;
use super::samples::Sample;
use super::simplex::minimise;
use crate::facets::fresnel::schlick_weight;
use crate::facets::parametric_curve::{Family, ParametricCurve};
use crate::facets::radial_table::RadialTable;
use crate::masking::variants::Masking;
use crate::materials::abc::Abc;
use crate::materials::microfacet::microfacet_eval;
use crate::materials::shifted_gamma::{ShiftedGamma, ShiftedGammaChannel};

/// The search uses every `STRIDE`-th sample. The stride is coprime to the numbers of steps of the sample grid.
const STRIDE: usize = 5;
/// The number of nodes of the slope tables in a search.
const COARSE: usize = 48;
/// The maximum number of steps of a simplex search.
const STEPS: u32 = 120;
/// The number of times that the weights of the least squares are updated.
const ROUNDS: usize = 4;
/// The number of sweeps over the unknowns of the least squares.
const SWEEPS: usize = 60;

/// Fits SGD. `slopes` are the slopes of another fit of the material, where the search starts. Returns `None` if the material has no samples.
pub fn fit_shifted_gamma(samples: &[Sample], slopes: &RadialTable) -> Option<ShiftedGamma> {
    let ParametricCurve::ShiftedGamma { alpha, p } = nearest(slopes, Family::ShiftedGamma) else { return None };
    let few: Vec<Sample> = samples.iter().copied().step_by(STRIDE).collect();
    let channel = |channel: usize| {
        let at = |&[width, p]: &[f64; 2], samples: &[Sample], nodes: Option<usize>| {
            let alpha = width.clamp(-20.0, 20.0).exp();
            let curve = ParametricCurve::ShiftedGamma { alpha, p };
            let table = nodes.map_or_else(|| curve.table(), |nodes| curve.table_of(nodes));
            let table = table.filter(|_| (-2.0..=20.0).contains(&p))?;
            Some(shifted_gamma_channel(samples, channel, [alpha, p], &table))
        };
        let error =
            |parameters: &[f64; 2]| at(parameters, &few, Some(COARSE)).map_or(f64::INFINITY, |(_, error)| error);
        let start = [alpha.ln(), p];
        let found = [start, [start[0] - 1.0, p + 0.5]].map(|start| minimise(start, [0.5, 0.3], STEPS, error));
        let best = found.into_iter().min_by(|a, b| a.1.total_cmp(&b.1))?.0;
        at(&best, samples, None).map(|(channel, _)| channel)
    };
    let all: Vec<Option<ShiftedGammaChannel>> = (0..3).into_par_iter().map(channel).collect();
    ShiftedGamma::new([all[0]?, all[1]?, all[2]?])
}

/// Returns the linear parameters of a channel, and the error.
fn shifted_gamma_channel(
    samples: &[Sample],
    channel: usize,
    [alpha, p]: [f64; 2],
    table: &RadialTable,
) -> (ShiftedGammaChannel, f64) {
    let rows: Vec<Row<4>> = samples
        .iter()
        .map(|s| {
            let ideal = 4.0 * FRAC_1_PI * microfacet_eval(Masking::SmithSeparable, table, s.wo, s.wi);
            let cosine = s.wo.dot(s.wh).clamp(0.0, 1.0);
            let grazing = schlick_weight(cosine);
            // ρ_s F = ρ_s F₀ (1 − grazing) + ρ_s grazing − ρ_s F₁ cos θ_d
            let basis = [FRAC_1_PI * s.wi.z, ideal * (1.0 - grazing), ideal * grazing, -ideal * cosine];
            Row { basis, value: s.value[channel] * s.wi.z, weight: s.weight }
        })
        .collect();
    let ([diffuse, f0, specular, f1], error) = cube_root_squares(&rows, [true, true, true, false]);
    let strength = specular.max(1e-12);
    (ShiftedGammaChannel { alpha, p, diffuse, specular: strength, fresnel: [f0 / strength, f1 / strength] }, error)
}

/// Fits ABC. `slopes` are the slopes of another fit of the material, where the search starts. Returns `None` if the material has no samples.
pub fn fit_abc(samples: &[Sample], slopes: &RadialTable) -> Option<Abc> {
    let ParametricCurve::Abc { b, c } = nearest(slopes, Family::Abc) else { return None };
    let few: Vec<Sample> = samples.iter().copied().step_by(STRIDE).collect();
    let at = |&[width, exponent, index]: &[f64; 3], samples: &[Sample]| {
        let inside = (0.0..=20.0).contains(&exponent) && width.abs() < 25.0 && (-4.0..=3.0).contains(&index);
        inside.then(|| {
            // The index is searched by its logarithm above 1, so it stays above 1.
            let shape =
                Abc { diffuse: DVec3::ZERO, a: DVec3::ONE, b: width.exp(), c: exponent, index: 1.0 + index.exp() };
            abc_colors(samples, &shape)
        })
    };
    let error = |parameters: &[f64; 3]| at(parameters, &few).map_or(f64::INFINITY, |(_, error)| error);
    let start = [b.ln(), c, 0.5f64.ln()];
    let starts = [start, [start[0] + 1.5, (0.5 * c).max(0.5), 0.0], [4.0, 1.0, 0.5f64.ln()]];
    let found = starts.map(|start| minimise(start, [0.5, 0.3, 0.5], 2 * STEPS, error));
    let best = found.into_iter().min_by(|a, b| a.1.total_cmp(&b.1))?.0;
    at(&best, samples).map(|(abc, _)| abc)
}

/// Returns the model with its linear parameters, and the error.
fn abc_colors(samples: &[Sample], shape: &Abc) -> (Abc, f64) {
    let basis: Vec<[f64; 2]> = samples.iter().map(|s| [FRAC_1_PI * s.wi.z, shape.specular(s.wo, s.wi)]).collect();
    let (mut abc, mut error) = (*shape, 0.0);
    for channel in 0..3 {
        let row = |(s, basis): (&Sample, &[f64; 2])| Row {
            basis: *basis,
            value: s.value[channel] * s.wi.z,
            weight: s.weight,
        };
        let rows: Vec<Row<2>> = samples.iter().zip(&basis).map(row).collect();
        let ([diffuse, a], wrong) = cube_root_squares(&rows, [true; 2]);
        (abc.diffuse[channel], abc.a[channel]) = (diffuse, a);
        error += wrong;
    }
    (abc, error)
}

/// One equation of the least squares.
struct Row<const N: usize> {
    basis: [f64; N],
    /// The measured `f_r cos θ_i`.
    value: f64,
    weight: f64,
}

/// Returns the coefficients of the basis that minimise the weighted squares of `∛model − ∛value`, and the minimum. Coefficients with
/// `nonnegative` set are at least 0.
///
/// `∛m − ∛v` is `(m − v) / (∛m² + ∛(m v) + ∛v²)`, so the problem becomes linear least squares whose weights depend on the last model.
fn cube_root_squares<const N: usize>(rows: &[Row<N>], nonnegative: [bool; N]) -> ([f64; N], f64) {
    let model = |row: &Row<N>, x: &[f64; N]| row.basis.iter().zip(x).map(|(b, x)| b * x).sum::<f64>().max(0.0);
    let mean =
        rows.iter().map(|row| row.weight * row.value).sum::<f64>() / rows.iter().map(|row| row.weight).sum::<f64>();
    // Dark values have a large but bounded weight.
    let least = (1e-3 * mean).max(1e-12).cbrt();
    let mut x = [0.0; N];
    for round in 0..ROUNDS {
        let (mut normal, mut right) = ([[0.0; N]; N], [0.0; N]);
        for row in rows {
            let v = row.value.cbrt();
            let m = if round == 0 { v } else { model(row, &x).cbrt() };
            let divisor = (m * m + m * v + v * v).max(3.0 * least * least);
            let weight = row.weight / (divisor * divisor);
            for ((line, sum), basis) in normal.iter_mut().zip(&mut right).zip(row.basis) {
                *sum += weight * basis * row.value;
                line.iter_mut().zip(row.basis).for_each(|(cell, other)| *cell += weight * basis * other);
            }
        }
        x = nonnegative_solution(&normal, &right, x, nonnegative);
    }
    let error = rows.iter().map(|row| row.weight * (model(row, &x).cbrt() - row.value.cbrt()).powi(2)).sum();
    (x, error)
}

/// Minimises `xᵀ N x / 2 − rᵀ x` by coordinate descent.
fn nonnegative_solution<const N: usize>(
    normal: &[[f64; N]; N],
    right: &[f64; N],
    mut x: [f64; N],
    nonnegative: [bool; N],
) -> [f64; N] {
    for _ in 0..SWEEPS * N {
        for i in 0..N {
            let others: f64 = (0..N).filter(|&j| j != i).map(|j| normal[i][j] * x[j]).sum();
            let best = if normal[i][i] > 0.0 { (right[i] - others) / normal[i][i] } else { 0.0 };
            x[i] = if nonnegative[i] { best.max(0.0) } else { best };
        }
    }
    x
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::extraction::samples::{misfit, samples};

    fn slopes(curve: ParametricCurve) -> RadialTable {
        curve.table().unwrap()
    }

    #[test]
    fn shifted_gamma_is_found_again() {
        let channel = |alpha, p, diffuse, specular, f0, f1| ShiftedGammaChannel {
            alpha,
            p,
            diffuse,
            specular,
            fresnel: [f0, f1],
        };
        let truth = ShiftedGamma::new([
            channel(0.05, 0.6, 0.3, 0.4, 0.1, 0.02),
            channel(0.08, 0.5, 0.1, 0.5, 0.2, 0.0),
            channel(0.05, 0.7, 0.02, 0.3, 0.3, -0.05),
        ])
        .unwrap();
        let samples = samples(&truth, true);
        let start = slopes(ParametricCurve::ShiftedGamma { alpha: 0.1, p: 0.8 });
        let found = fit_shifted_gamma(&samples, &start).unwrap();
        let wrong = misfit(&samples, &found);
        println!("{wrong:?} {:?}", found.channels());
        assert!(wrong.perceptual < 0.005 && wrong.rrmse < 0.02, "{wrong:?}");
        for (found, truth) in found.channels().iter().zip(truth.channels()) {
            assert!((found.diffuse - truth.diffuse).abs() < 0.005, "{found:?}");
            assert!((found.alpha / truth.alpha - 1.0).abs() < 0.1 && (found.p - truth.p).abs() < 0.05, "{found:?}");
        }
    }

    #[test]
    fn abc_is_found_again() {
        let truth =
            Abc { diffuse: DVec3::new(0.3, 0.1, 0.02), a: DVec3::new(20.0, 30.0, 10.0), b: 800.0, c: 1.4, index: 1.6 };
        let samples = samples(&truth, true);
        let start = slopes(ParametricCurve::Abc { b: 300.0, c: 2.0 });
        let found = fit_abc(&samples, &start).unwrap();
        let wrong = misfit(&samples, &found);
        println!("{wrong:?} {found:?}");
        assert!(wrong.perceptual < 0.005 && wrong.rrmse < 0.02, "{wrong:?}");
        assert!((found.diffuse - truth.diffuse).length() < 0.005 && (found.c - 1.4).abs() < 0.05, "{found:?}");
        assert!((found.index - 1.6).abs() < 0.1, "{found:?}");
    }
}
