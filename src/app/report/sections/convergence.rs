//! The reference against a longer run of itself: its error must fall as that of independent samples or faster.

use serde::Serialize;

use super::Section;
use crate::app::error::AppError;
use crate::app::report::html::{Html, Table, number};
use crate::app::report::plot::{Plot, Scale};
use crate::app::report::studio::{Studio, fault};
use crate::app::report::subject::Subject;
use crate::app::report::truth::Truth;
use crate::app::report::verdict::{Shot, judge};

const INTRO: &str = "The reference tessellates the surface down to the texels of its displacement map, shades every sample \
    with the base material and the surface's own normal, and moves the samples inside the pixel. This section holds runs \
    with few samples against one with many, of another seed. Errors are over the pixels that the sphere touches; \
    displacement-map truth displaces the geometry, normal-map truth leaves it smooth and keeps the slopes.";

/// The measured errors of one truth.
#[derive(Debug, Serialize)]
struct Curve {
    truth: &'static str,
    samples: Vec<u32>,
    rrmse: Vec<f64>,
    flip: Vec<f64>,
    /// Slope of `log(rrmse)` over `log(samples)`, by least squares.
    order: f64,
    converged_samples: u32,
}

pub fn run(studio: &mut Studio) -> Result<Section, AppError> {
    let size = studio.pick(96, 192);
    let counts: &[u32] = if studio.quick { &[1, 2, 4, 8, 16] } else { &[1, 2, 4, 8, 16, 32, 64, 128, 256] };
    let converged = studio.pick(64, 1024);
    let mut subject = Subject::rough_sphere(studio, studio.pick(16, 32))?;
    let state = subject.seen_by(&subject.stage.views.mid);
    let (mut html, mut curves, mut figures) = (Html::new(), Vec::new(), Vec::new());
    let mut plot =
        Plot::new("Error against samples per pixel", ("samples per pixel", Scale::Log), ("relative RMSE", Scale::Log));
    for truth in [Truth::Displacement, Truth::NormalMap] {
        let mut shoot = |samples, seed| -> Result<Shot, AppError> {
            let settings = truth.settings((size, size), samples, seed);
            studio.shoot(&mut subject.renderer, &state, &settings)
        };
        let best = shoot(converged, 1)?;
        let shots = counts.iter().map(|&samples| shoot(samples, 0)).collect::<Result<Vec<_>, _>>()?;
        let mut curve = Curve {
            truth: truth.name(),
            samples: counts.to_vec(),
            rrmse: Vec::new(),
            flip: Vec::new(),
            order: 0.0,
            converged_samples: converged,
        };
        for shot in &shots {
            let verdict = judge(&best, shot, 1.0).map_err(fault)?;
            curve.rrmse.push(verdict.object.rrmse);
            curve.flip.push(verdict.object.flip);
        }
        let points: Vec<(f64, f64)> = counts.iter().map(|&n| f64::from(n)).zip(curve.rrmse.iter().copied()).collect();
        curve.order = order(&points);
        for (shot, label) in [(&shots[0], "1 sample".to_owned()), (&best, format!("{converged} samples"))] {
            let name = format!("convergence-{}-{}", truth.name(), shot.samples);
            let caption = vec![truth.title().to_owned(), label];
            figures.push(studio.picture(&name, &shot.image, 1.0, "the rough sphere", caption)?);
        }
        plot.line(truth.title(), points);
        curves.push(curve);
    }
    let first = curves.iter().map(|c| c.rrmse[0]).fold(0.0, f64::max);
    let guide = |power: f64| counts.iter().map(|&n| (f64::from(n), first * f64::from(n).powf(power))).collect();
    plot.guide("independent samples, n^-1/2", guide(-0.5));
    html.figures(&figures);
    html.plot(&plot);
    let mut table = Table::new(
        format!("Error against {converged} samples of another seed, {size} x {size} pixels"),
        std::iter::once("samples".to_owned())
            .chain(curves.iter().flat_map(|c| [format!("{}: rRMSE", c.truth), format!("{}: FLIP", c.truth)])),
    );
    for (i, n) in counts.iter().enumerate() {
        let numbers = curves.iter().flat_map(|c| [c.rrmse[i].into(), c.flip[i].into()]);
        table.row(std::iter::once(n.to_string().into()).chain(numbers));
    }
    html.table(&table);
    let findings = curves.iter().map(finding).collect();
    Section::new(INTRO, findings, &html, &curves)
}

fn finding(curve: &Curve) -> String {
    let (first, last) = (curve.rrmse[0], curve.rrmse[curve.rrmse.len() - 1]);
    let n = curve.samples[curve.samples.len() - 1];
    let judgement = if curve.order <= -0.45 {
        "as fast as independent samples or faster"
    } else {
        "more slowly than independent samples"
    };
    format!(
        "{}: the error falls from {} at one sample to {} at {n}, with the power {} of the number of samples: {judgement}.",
        curve.truth,
        number(first),
        number(last),
        number(curve.order),
    )
}

/// The power of `x` by which `y` goes, by least squares over the logarithms.
fn order(points: &[(f64, f64)]) -> f64 {
    let logs: Vec<(f64, f64)> = points.iter().filter(|p| p.1 > 0.0).map(|p| (p.0.ln(), p.1.ln())).collect();
    let n = logs.len() as f64;
    let (mx, my) = (logs.iter().map(|p| p.0).sum::<f64>() / n, logs.iter().map(|p| p.1).sum::<f64>() / n);
    let (xy, xx) = logs.iter().fold((0.0, 0.0), |(xy, xx), p| (xy + (p.0 - mx) * (p.1 - my), xx + (p.0 - mx).powi(2)));
    xy / xx
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn powers_are_found() {
        for power in [-0.5, -0.75, 0.0] {
            let points: Vec<(f64, f64)> = (0..6).map(|k| (2f64.powi(k), 3.0 * 2f64.powi(k).powf(power))).collect();
            assert!((order(&points) - power).abs() < 1e-12);
        }
    }
}
