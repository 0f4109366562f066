//! Compares the reference with a longer run. The error of the reference must fall at least as fast as the error of
//! independent samples.

use serde::Serialize;

use crate::report::section::Section;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use crate::report::truth::Truth;
use crate::report::verdict::{Shot, judge};
use leadr_render::sampling::independent_seed;
use leadr_tools::error::LabError;
use leadr_tools::html::{Figure, Html, Table, number};
use leadr_tools::html::{Plot, Scale};

const INTRO: &str = "The reference tessellates the surface to the texels of its displacement map. It shades every sample with the base \
    material and the surface normal, at a different position in the pixel. This section compares one run with another of as many samples \
    and other seeds. The noise of that other run, estimated from its two halves, is listed and subtracted: squares of independent errors \
    add. Errors are over the pixels that the sphere touches. Displacement-map truth displaces the geometry; normal-map truth keeps it \
    smooth and uses only the slopes.";

#[derive(Debug, Default, Serialize)]
struct Curve {
    truth: &'static str,
    samples: Vec<u32>,
    /// The relative RMSE against the truth.
    rrmse: Vec<f64>,
    /// The relative RMSE against the truth, after subtracting the truth's noise.
    own: Vec<f64>,
    flip: Vec<f64>,
    /// The relative RMSE of the truth, computed from its two halves.
    noise: f64,
    /// The least-squares slope of `log(own)` over `log(samples)`, where `own` is above the noise.
    order: f64,
}

fn picture(studio: &mut Studio, truth: Truth, shot: &Shot) -> Result<Figure, LabError> {
    let name = format!("convergence-{}-{}", truth.name(), shot.samples);
    let label = if shot.samples == 1 { "1 sample".to_owned() } else { format!("{} samples", shot.samples) };
    studio.picture(&name, &shot.image, 1.0, "the rough sphere", vec![truth.title().to_owned(), label])
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let size = studio.pick(96, 128);
    let most = studio.pick(16, 1024u32);
    // Tiles have half the resolution of other sections, to afford thousands of samples.
    let mut subject = Subject::rock(studio, 16)?;
    let state = subject.seen_by(&subject.stage.views.mid);
    let counts: Vec<u32> = (0..=most.ilog2()).map(|k| 1 << k).collect();
    let (mut html, mut curves, mut figures) = (Html::new(), Vec::new(), Vec::new());
    let mut plot = Plot::new(
        "Error against samples per pixel, with the truth's own noise subtracted",
        ("samples per pixel", Scale::Log),
        ("relative RMSE", Scale::Log),
    );
    for truth in [Truth::Displacement, Truth::NormalMap] {
        let mut half =
            |seed| studio.shoot(&mut subject.renderer, &state, &truth.settings((size, size), most / 2, seed));
        let (a, b) = (half(1)?, half(independent_seed(most / 2, 1))?);
        let best = Shot::mean_of(&a, &b).map_err(fault)?;
        let noise = 0.5 * judge(&a, &b, 1.0).map_err(fault)?.object.rrmse;
        // One run with another seed is compared at each step.
        let settings = truth.settings((size, size), most, 3);
        let mut curve = Curve { truth: truth.name(), samples: counts.clone(), noise, ..Curve::default() };
        let mut run = Shot { samples: 0, ..best.clone() };
        for &samples in &counts {
            let part = studio.shoot_range(&mut subject.renderer, &state, &settings, run.samples..samples)?;
            run = run.joined(&part).map_err(fault)?;
            let verdict = judge(&best, &run, 1.0).map_err(fault)?;
            curve.rrmse.push(verdict.object.rrmse);
            curve.own.push((verdict.object.rrmse.powi(2) - noise * noise).max(0.0).sqrt());
            curve.flip.push(verdict.object.flip);
            if samples == 1 {
                figures.push(picture(studio, truth, &run)?);
            }
        }
        figures.push(picture(studio, truth, &best)?);
        let points = || counts.iter().map(|&n| f64::from(n)).zip(curve.own.iter().copied());
        curve.order = order(&points().filter(|p| p.1 > noise).collect::<Vec<_>>());
        plot.line(truth.title(), points().filter(|p| p.1 > 0.0).collect());
        curves.push(curve);
    }
    let first = curves.iter().map(|c| c.own[0]).fold(0.0, f64::max);
    let guide = |power: f64| counts.iter().map(|&n| (f64::from(n), first * f64::from(n).powf(power))).collect();
    plot.guide("independent samples, n^-1/2", guide(-0.5));
    html.figures(&figures);
    html.plot(&plot);
    let mut table = Table::new(
        format!(
            "Error against {most} samples of other seeds, {size} x {size} pixels; own: with their noise subtracted"
        ),
        std::iter::once("samples".to_owned()).chain(
            curves.iter().flat_map(|c| ["rRMSE", "rRMSE, own", "FLIP"].map(|kind| format!("{}: {kind}", c.truth))),
        ),
    );
    for (i, n) in counts.iter().enumerate() {
        let numbers = curves.iter().flat_map(|c| [c.rrmse[i].into(), c.own[i].into(), c.flip[i].into()]);
        table.row(std::iter::once(n.to_string().into()).chain(numbers));
    }
    html.table(&table);
    let findings = curves.iter().map(finding).collect();
    Section::new(INTRO, findings, &html, &curves)
}

fn finding(curve: &Curve) -> String {
    let last = curve.own.len() - 1;
    let judgement = if curve.order <= -0.45 {
        "as fast as independent samples or faster"
    } else {
        "more slowly than independent samples"
    };
    format!(
        "{}: the error falls from {} at one sample to {} at {} samples (against a truth of as many, whose own error is {}), with power {} of the number of samples: {judgement}.",
        curve.truth,
        number(curve.own[0]),
        number(curve.own[last]),
        curve.samples[last],
        number(curve.noise),
        number(curve.order),
    )
}

/// Computes the exponent of the power law from `x` to `y`, by least squares over the logarithms.
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
