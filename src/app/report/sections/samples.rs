//! One sample of LEADR against references of many samples: how near to the truth, how much faster.

use serde::Serialize;

use super::Section;
use crate::app::error::AppError;
use crate::app::report::case::Case;
use crate::app::report::html::{Cell, Html, Table, number};
use crate::app::report::look::Look;
use crate::app::report::plot::{Plot, Scale};
use crate::app::report::studio::{Studio, fault};
use crate::app::report::subject::Subject;
use crate::app::report::truth::Truth;
use crate::app::report::verdict::{Errors, judge};
use crate::render::settings::RenderSettings;

const INTRO: &str = "How near to a converged reference is LEADR with one sample per pixel, and how many samples does a brute-force \
    reference need to be as near? Errors are relative RMSE over the pixels that the object touches; the column \"inside\" \
    leaves out its outline, which one sample per pixel cannot smooth whatever the shading. Times are of the device, of all \
    passes, the second of two runs.";

/// One picture of a subject.
#[derive(Debug, Serialize)]
struct Row {
    look: String,
    samples: u32,
    milliseconds: f64,
    object: Errors,
    interior: Errors,
}

#[derive(Debug, Serialize)]
struct Race {
    subject: String,
    size: u32,
    converged_samples: u32,
    leadr: Row,
    references: Vec<Row>,
}

pub fn run(studio: &mut Studio) -> Result<Section, AppError> {
    let mut races = Vec::new();
    let mut html = Html::new();
    let sphere = Subject::rough_sphere(studio, studio.pick(16, 32))?;
    let distance = 24.0;
    races.push(race(studio, sphere, "rough sphere at 24 m", distance, &mut html)?);
    let trex = Subject::trex(studio, studio.pick(8, 16))?;
    races.push(race(studio, trex, "T-rex at 90 m", 90.0, &mut html)?);
    let findings = races.iter().flat_map(findings).collect();
    Section::new(INTRO, findings, &html, &races)
}

fn race(
    studio: &mut Studio,
    mut subject: Subject,
    title: &str,
    distance: f32,
    html: &mut Html,
) -> Result<Race, AppError> {
    let size = studio.pick(96, 128);
    let counts: &[u32] = if studio.quick { &[1, 4, 16, 64] } else { &[1, 2, 4, 8, 16, 32, 64, 128, 256] };
    let converged = studio.pick(128, 1024);
    let state = subject.seen_by(&subject.stage.views.mid.at_distance(distance));
    let truth =
        studio.shoot(&mut subject.renderer, &state, &Truth::Displacement.settings((size, size), converged, 1))?;
    let mut measure = |look: &str, settings: &RenderSettings, twice: bool| {
        // The first run builds pipelines.
        let mut shot = studio.shoot(&mut subject.renderer, &state, settings)?;
        if twice {
            shot = studio.shoot(&mut subject.renderer, &state, settings)?;
        }
        let verdict = judge(&truth, &shot, 1.0).map_err(fault)?;
        let row = Row {
            look: look.to_owned(),
            samples: shot.samples,
            milliseconds: shot.milliseconds,
            object: verdict.object,
            interior: verdict.interior,
        };
        Ok::<_, AppError>((row, shot, verdict))
    };
    let look = Look::best();
    let (leadr, shot, verdict) = measure(&look.name, &look.settings((size, size), 1), true)?;
    let mut references = Vec::new();
    for &samples in counts {
        let settings = Truth::Displacement.settings((size, size), samples, 0);
        references.push(measure("reference", &settings, samples <= 4)?.0);
    }
    let key = title.split(' ').next().unwrap_or_default().to_lowercase();
    let caption = |text: String| vec![title.to_owned(), text];
    let pictures = [
        studio.picture(
            &format!("samples-{key}-truth"),
            &truth.image,
            1.0,
            title,
            caption(format!("{converged} samples")),
        )?,
        studio.picture(
            &format!("samples-{key}-leadr"),
            &shot.image,
            1.0,
            title,
            caption("LEADR, one sample".to_owned()),
        )?,
        studio.error_picture(
            &format!("samples-{key}-errors"),
            &verdict,
            title,
            caption("FLIP errors of LEADR".to_owned()),
        )?,
    ];
    let pictures = pictures.map(|figure| figure.enlarged(2));
    let mut case = Case::new("samples", title, &look.name, "displacement", &verdict);
    case.figures = pictures.to_vec();
    studio.cases.push(case);
    let race = Race { subject: title.to_owned(), size, converged_samples: converged, leadr, references };
    html.heading(title);
    html.figures(&pictures);
    html.plot(&plot(&race));
    html.table(&table(&race));
    Ok(race)
}

fn plot(race: &Race) -> Plot {
    let mut plot = Plot::new(
        &format!("{}: error against time", race.subject),
        ("milliseconds of the device", Scale::Log),
        ("relative RMSE", Scale::Log),
    );
    let points = |pick: fn(&Row) -> f64| race.references.iter().map(|r| (r.milliseconds, pick(r))).collect();
    plot.line("reference", points(|r| r.object.rrmse));
    plot.line("reference, inside", points(|r| r.interior.rrmse));
    plot.line("LEADR, one sample", vec![(race.leadr.milliseconds, race.leadr.object.rrmse)]);
    plot.line("LEADR, one sample, inside", vec![(race.leadr.milliseconds, race.leadr.interior.rrmse)]);
    plot
}

fn table(race: &Race) -> Table {
    let mut table = Table::new(
        format!("Against {} samples of another seed, {} x {} pixels", race.converged_samples, race.size, race.size),
        ["", "samples", "rRMSE", "rRMSE inside", "FLIP", "FLIP inside", "bias inside", "ms", "times LEADR"],
    );
    for row in std::iter::once(&race.leadr).chain(&race.references) {
        let numbers = [
            row.object.rrmse,
            row.interior.rrmse,
            row.object.flip,
            row.interior.flip,
            row.interior.bias,
            row.milliseconds,
            row.milliseconds / race.leadr.milliseconds,
        ];
        let head = [Cell::from(row.look.as_str()), Cell::from(row.samples.to_string())];
        table.row(head.into_iter().chain(numbers.map(Cell::from)));
    }
    table
}

/// The number of samples at which a reference's error is `error`, between the measured ones by powers; none if even
/// the most samples are worse, 1 if one sample is better.
fn worth(references: &[(f64, f64)], error: f64) -> Option<f64> {
    let (first, last) = (references.first()?, references.last()?);
    if first.1 <= error {
        return Some(first.0);
    }
    if last.1 > error {
        return None;
    }
    let pair = references.windows(2).find(|pair| pair[0].1 > error && pair[1].1 <= error)?;
    let share = (pair[0].1 / error).ln() / (pair[0].1 / pair[1].1).ln();
    Some(pair[0].0 * (pair[1].0 / pair[0].0).powf(share))
}

fn findings(race: &Race) -> Vec<String> {
    let mut findings = Vec::new();
    for (place, pick) in
        [("the outline included", (|r| r.object.rrmse) as fn(&Row) -> f64), ("inside", |r| r.interior.rrmse)]
    {
        let points: Vec<(f64, f64)> = race.references.iter().map(|r| (f64::from(r.samples), pick(r))).collect();
        let error = pick(&race.leadr);
        if error.is_nan() {
            findings.push(format!("{}: too small to have pixels {place}.", race.subject));
            continue;
        }
        let worth = match worth(&points, error) {
            Some(n) => format!("a reference needs {} samples to be as near", number(n)),
            None => format!("even {} samples of the reference are farther away", points.last().map_or(0.0, |p| p.0)),
        };
        findings.push(format!(
            "{}, {place}: one sample of LEADR has an error of {}; {worth}.",
            race.subject,
            number(error)
        ));
    }
    if let Some(reference) = race.references.iter().find(|r| r.samples == 64) {
        let (faster, inside) =
            (reference.milliseconds / race.leadr.milliseconds, race.leadr.interior.rrmse <= reference.interior.rrmse);
        let met = faster >= 50.0 && race.leadr.object.rrmse <= reference.object.rrmse;
        findings.push(format!(
            "{}: 64 samples of the reference take {} times as long as one of LEADR, with an error of {} against {} ({} against {} inside). The goal (as near, 50 times faster) is {}{}.",
            race.subject,
            number(faster),
            number(reference.object.rrmse),
            number(race.leadr.object.rrmse),
            number(reference.interior.rrmse),
            number(race.leadr.interior.rrmse),
            if met { "met" } else { "not met" },
            if !met && inside && faster >= 50.0 { ", but it is inside the outline" } else { "" },
        ));
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::worth;

    #[test]
    fn samples_of_equal_error_are_interpolated() {
        let halves: Vec<(f64, f64)> = (0..5).map(|k| (4f64.powi(k), 0.5f64.powi(k))).collect();
        assert!((worth(&halves, 0.25).unwrap() - 16.0).abs() < 1e-9);
        assert!((worth(&halves, 0.5f64.powf(1.5)).unwrap() - 8.0).abs() < 1e-9);
        assert_eq!((worth(&halves, 2.0), worth(&halves, 0.01), worth(&[], 1.0)), (Some(1.0), None, None));
    }
}
