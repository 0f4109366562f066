//! Fits rational functions to LEADR's diffuse term under one light. LEADR §6 reports such a fit with more than 70 coefficients, which was
//! slower than the 5×5 grid. `docs/measurements/quadrature.md` has the table.
//!
//! Only the diffuse term is fitted, because the specular term under one light has a closed form. The fitted value is the mean cosine of
//! the visible facets, `E[⟨wo·N⟩ ⟨wi·N⟩ / |N|] / A(wo)` with `N = (−slope, 1)`. Masking and shadowing are closed factors and need no fit.
//! The value depends on nine numbers. Two properties reduce them:
//!
//! * A rotation about the displacement direction changes nothing, so eight numbers are left. These are the paper's.
//! * A linear map of the slopes, with the inverse map of both directions, changes only `|N|`. Without `|N|`, the value divided by the
//!   visible area `A(wi)` depends on three numbers: the ratio `a/b` of projected area and spread for both directions, and the correlation
//!   of the two projected areas. [`Form::Areas`] has these three and two for the effect of `|N|`.

pub mod forms;
pub mod quotient;

use crate::quadrature_study::Row;
use crate::quadrature_study::light::{LightSet, grid_cosine, random_lights};
use crate::quadrature_study::surfaces::{Surface, spherical, surfaces};
use forms::{Fit, Form, principal};
use glam::{DVec2, DVec3};
use leadr_reflectance::random::Random;
use leadr_reflectance::visible::diffuse::leadr_diffuse_light_visible;
use quotient::MOST_TERMS;
use std::f64::consts::{PI, TAU};
use std::hint::black_box;
use std::time::Instant;

/// The degrees above and below the line.
pub const DEGREES: [[usize; 2]; 6] = [[1, 1], [2, 1], [2, 2], [3, 1], [3, 2], [3, 3]];
/// Relative errors are measured where the mean cosine is larger than this.
const LIT: f64 = 0.1;
/// The number of rounds of a time. The shortest counts.
const ROUNDS: u32 = 50;

/// The surfaces, viewers and lights of a fit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Domain {
    /// The [`surfaces`] and [`random_lights`] of the other tables.
    Whole,
    /// Viewers and lights up to 60°, deviations in .1–.7, and mean slopes up to .5.
    Narrow,
    /// Viewers, lights and deviations of the whole domain, for centred isotropic slopes.
    Centred,
}

impl Domain {
    /// All domains.
    pub const ALL: [Self; 3] = [Self::Whole, Self::Narrow, Self::Centred];

    /// Returns `n` random surfaces and lights of the domain in the axes of [`principal`].
    pub fn set(self, n: usize, seed: u64) -> LightSet {
        let wide = || surfaces(n, seed).into_iter().zip(random_lights(n, seed + 2));
        let pairs: Vec<(Surface, DVec3)> = match self {
            Self::Whole => wide().collect(),
            Self::Narrow => {
                let mut r = Random(seed);
                (0..n).map(|_| narrow(&mut r)).collect()
            }
            Self::Centred => {
                let centred = |s: Surface| Surface { m: DVec2::ZERO, s: DVec3::new(s.s.x, s.s.x, 0.0), ..s };
                wide().map(|(s, wi)| (centred(s), wi)).collect()
            }
        };
        let (surfaces, lights) = pairs.iter().map(|(s, wi)| principal(s, *wi)).unzip();
        LightSet::of(surfaces, lights)
    }

    /// Returns the forms that are fitted to this domain.
    fn forms(self) -> &'static [Form] {
        if self == Self::Centred {
            &[Form::Centred, Form::Areas]
        } else {
            &[Form::Paper, Form::Invariants, Form::Areas]
        }
    }
}

fn narrow(r: &mut Random) -> (Surface, DVec3) {
    let [wo, wi] = [(); 2].map(|()| spherical(r.range(0.0, 60f64.to_radians()), r.range(0.0, TAU)));
    let (x, y) = (r.log(0.1, 0.7), r.log(0.1, 0.7));
    let m = 0.5 * r.unit().sqrt() * DVec2::from_angle(r.range(0.0, TAU));
    (Surface { wo, m, s: DVec3::new(x * x, y * y, 0.0) }, wi)
}

/// The errors and the time of a fit or of a quadrature rule.
#[derive(Clone, Debug, PartialEq)]
pub struct FitRow {
    /// The absolute errors of the mean cosine. The number of evaluations is that of coefficients, nodes or terms.
    pub row: Row,
    /// The RMS of the relative errors where the mean cosine is larger than .1.
    pub relative: f64,
    /// The smallest denominator per mean denominator, at surfaces that the fit has not seen. Quadrature rules have none.
    pub smallest: Option<f64>,
    /// The time of one evaluation on one core in double precision.
    pub nanoseconds: f64,
}

impl FitRow {
    /// The header line for [`FitRow::line`].
    pub const HEADER: &str = "rule                             n      rms     95 %      max  relative  smallest   ns";

    fn new(
        name: &str,
        count: usize,
        set: &LightSet,
        smallest: Option<f64>,
        mut rule: impl FnMut(&Surface, DVec3) -> f64,
    ) -> Self {
        let samples: Vec<(&Surface, DVec3, f64)> = set.samples().collect();
        let values: Vec<f64> = samples.iter().map(|(s, wi, _)| rule(s, *wi)).collect();
        let errors: Vec<Vec<f64>> = samples.iter().zip(&values).map(|((.., truth), v)| vec![v - truth]).collect();
        let lit = samples.iter().zip(&values).filter(|((.., truth), _)| *truth > LIT);
        let (sum, count_lit) =
            lit.fold((0.0, 0u32), |(sum, n), ((.., truth), v)| (sum + (v / truth - 1.0).powi(2), n + 1));
        let surfaces: Vec<Surface> = samples.iter().map(|(s, ..)| **s).collect();
        let mut round = || {
            let start = Instant::now();
            samples.iter().for_each(|(s, wi, _)| _ = black_box(rule(s, *wi)));
            start.elapsed().as_secs_f64() * 1e9 / samples.len() as f64
        };
        Self {
            row: Row::new(name, count as u32, &surfaces, &errors),
            relative: (sum / f64::from(count_lit)).sqrt(),
            smallest,
            nanoseconds: (0..ROUNDS).map(|_| round()).fold(f64::INFINITY, f64::min),
        }
    }

    /// Measures a fit to `training` over `set`.
    pub fn of_fit(form: Form, degrees: [usize; 2], training: &LightSet, set: &LightSet) -> Self {
        let fit = Fit::new(form, degrees, training);
        let mut terms = [0.0; MOST_TERMS];
        let name = format!("{}, {}/{}", form.name(), degrees[0], degrees[1]);
        Self::new(&name, fit.quotient.coefficients(), set, Some(fit.smallest_denominator(set)), |s, wi| {
            fit.cosine(s, wi, &mut terms)
        })
    }

    /// Formats one line of text, with the columns of [`FitRow::HEADER`].
    pub fn line(&self) -> String {
        let Row { rule, evaluations, rms, p95, max, .. } = &self.row;
        let smallest = self.smallest.map_or(String::new(), |q| format!("{q:.2}"));
        format!(
            "{rule:<28} {evaluations:>5} {rms:>8.2e} {p95:>8.2e} {max:>8.2e} {:>9.2e} {smallest:>9} {:>4.0}",
            self.relative, self.nanoseconds
        )
    }
}

/// Measures the paper's grids and the rules of two and three terms over `set`.
pub fn rule_rows(set: &LightSet) -> Vec<FitRow> {
    let grid =
        |n: u32| FitRow::new(&format!("paper {n}x{n}"), (n * n) as usize, set, None, |s, wi| grid_cosine(s, wi, n));
    let terms = |n: u32| {
        FitRow::new(&format!("visible {n} terms"), n as usize, set, None, |s, wi| {
            PI * leadr_diffuse_light_visible(s.wo, wi, s.m, s.s, false, n)
        })
    };
    vec![grid(3), grid(5), grid(7), terms(2), terms(3)]
}

/// Measures fits of all degrees for one domain, to `training` samples, over `n` other samples. The rules come last.
pub fn domain_rows(domain: Domain, training: usize, n: usize) -> Vec<FitRow> {
    let [training, set] = [(training, 101), (n, 1)].map(|(n, seed)| domain.set(n, seed));
    let fit = |form: &Form| DEGREES.map(|degrees| FitRow::of_fit(*form, degrees, &training, &set));
    domain.forms().iter().flat_map(fit).chain(rule_rows(&set)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn closed_areas_make_a_fit_as_accurate_as_the_grid() {
        let [training, set] = [(1500, 101), (600, 1)].map(|(n, seed)| Domain::Whole.set(n, seed));
        let measured =
            [(Form::Paper, [2, 2], 89, 0.08), (Form::Invariants, [2, 1], 53, 0.038), (Form::Areas, [2, 1], 26, 8.7e-3)];
        println!("{}", FitRow::HEADER);
        let rows = measured.map(|(form, degrees, count, rms)| {
            let fit = FitRow::of_fit(form, degrees, &training, &set);
            println!("{}", fit.line());
            assert_eq!(fit.row.evaluations, count);
            assert!(fit.row.rms < rms && fit.row.rms > 0.9 * rms, "{} is not near {rms}", fit.line());
            assert!(fit.smallest.is_some_and(|q| q > 0.0), "{} has a pole", fit.line());
            fit
        });
        let rules = rule_rows(&set);
        rules.iter().for_each(|rule| println!("{}", rule.line()));
        let [grid, terms] = ["paper 5x5", "visible 2 terms"]
            .map(|name| rules.iter().find(|r| r.row.rule == name).expect("a row per rule").row.rms);
        let [paper, _, areas] = rows.map(|fit| fit.row.rms);
        assert!(paper > 8.0 * grid && areas < 1.15 * grid && areas > 6.0 * terms, "{paper} {areas} {grid} {terms}");
    }

    #[test]
    fn centred_isotropic_slopes_need_fewer_coefficients() {
        let [training, set] = [(1500, 101), (600, 1)].map(|(n, seed)| Domain::Centred.set(n, seed));
        let fit = FitRow::of_fit(Form::Centred, [2, 2], &training, &set);
        println!("{}", fit.line());
        assert!(fit.row.evaluations == 29 && (0.018..0.0205).contains(&fit.row.rms), "{}", fit.line());
    }
}
