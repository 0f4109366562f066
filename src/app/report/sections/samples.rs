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
use crate::app::report::verdict::{Errors, Shot, Verdict, judge};
use crate::maps::RgbImage;
use crate::render::accumulate::Accumulation;
use crate::render::scene::FrameState;
use crate::render::settings::RenderSettings;

const INTRO: &str = "How near to a converged reference is LEADR with one shaded sample per pixel, and how many samples of a \
    brute-force reference is it worth: at how many has the reference the same error? The truth has all shadows of the relief, of the sun \
    and of the sky, and LEADR is what the program draws by default. Edge samples look at the geometry only: they smooth outlines, and \
    inside them the one sample stands for all. Errors are relative RMSE and mean FLIP over the pixels that the object touches; \
    \"inside\" leaves out its outline. Times are of the device, of all passes; those of LEADR of the second of two runs.";

/// Edge samples of the picture that is judged; more change its errors little (docs/report.md).
const EDGE_SAMPLES: u32 = 16;
/// The goal: as near as a reference of so many samples,
const WORTH: u32 = 64;
/// in so many times less time than it takes.
const FASTER: f64 = 50.0;

/// One picture of a subject.
#[derive(Debug, Serialize)]
struct Row {
    look: String,
    samples: u32,
    edge_samples: u32,
    milliseconds: f64,
    object: Errors,
    interior: Errors,
}

/// A way to measure an error.
#[derive(Clone, Copy)]
struct Measure {
    name: &'static str,
    of: fn(&Row) -> f64,
}

const MEASURES: [Measure; 4] = [
    Measure { name: "rRMSE", of: |r| r.object.rrmse },
    Measure { name: "rRMSE inside", of: |r| r.interior.rrmse },
    Measure { name: "FLIP", of: |r| r.object.flip },
    Measure { name: "FLIP inside", of: |r| r.interior.flip },
];
/// Those of [`MEASURES`] that the goal is about: of the whole object.
const JUDGED: [usize; 2] = [0, 2];

/// Samples of the reference that a picture is worth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
#[serde(tag = "bound", content = "samples", rename_all = "snake_case")]
enum Worth {
    /// So many, between measured numbers by powers.
    Equal(f64),
    /// Even so few are nearer.
    Below(f64),
    /// Even so many are farther away.
    Above(f64),
    /// There are no such pixels.
    Unknown,
}

impl Worth {
    /// Whether that is at least `samples`.
    fn reaches(self, samples: f64) -> bool {
        match self {
            Self::Equal(n) | Self::Above(n) => n >= samples,
            Self::Below(_) | Self::Unknown => false,
        }
    }
}

impl std::fmt::Display for Worth {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        match self {
            Self::Equal(n) => write!(f, "{}", number(*n)),
            Self::Below(n) => write!(f, "below {}", number(*n)),
            Self::Above(n) => write!(f, "above {}", number(*n)),
            Self::Unknown => write!(f, "–"),
        }
    }
}

#[derive(Debug, Serialize)]
struct Race {
    subject: String,
    size: u32,
    converged_samples: u32,
    /// Noise of the converged reference over the object, relative RMSE.
    noise: f64,
    /// One sample with edge samples: what is judged.
    leadr: Row,
    /// LEADR without edge samples, and with many shaded ones.
    others: Vec<Row>,
    references: Vec<Row>,
    /// Per measure.
    worth: Vec<(&'static str, Worth)>,
    /// Time of a reference of [`WORTH`] samples over that of LEADR.
    faster: Option<f64>,
    met: bool,
}

pub fn run(studio: &mut Studio) -> Result<Section, AppError> {
    let mut races = Vec::new();
    let mut html = Html::new();
    let sphere = Subject::rough_sphere(studio, studio.pick(16, 32))?;
    races.push(race(studio, sphere, "rough sphere at 24 m", 24.0, &mut html)?);
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
    let counts: &[u32] = if studio.quick { &[1, 4, 16, 64] } else { &[1, 2, 4, 8, 16, 32, 64, 128] };
    let converged = studio.pick(64, 256);
    let state = subject.seen_by(&subject.stage.views.mid.at_distance(distance));
    let brute = |samples, seed| RenderSettings {
        relief_shadows: true,
        ..Truth::Displacement.settings((size, size), samples, seed)
    };
    let truth = studio.shoot_truth(&mut subject.renderer, &state, &brute(converged, 1))?;
    let row = |look: &str, shot: &Shot, edge_samples| -> Result<(Row, Verdict), AppError> {
        let verdict = judge(&truth, shot, 1.0).map_err(fault)?;
        let Verdict { object, interior, .. } = verdict;
        let (samples, milliseconds) = (shot.samples, shot.milliseconds);
        Ok((Row { look: look.to_owned(), samples, edge_samples, milliseconds, object, interior }, verdict))
    };
    let look = Look::default_of_the_program();
    let mut shade = |samples, edge_samples| -> Result<_, AppError> {
        let settings = RenderSettings { edge_samples, ..look.settings((size, size), samples) };
        // The first run builds pipelines.
        studio.shoot(&mut subject.renderer, &state, &RenderSettings { samples: 1, ..settings })?;
        let shot = studio.shoot(&mut subject.renderer, &state, &settings)?;
        let (row, verdict) = row(&look.name, &shot, edge_samples)?;
        Ok((row, shot, verdict))
    };
    let (leadr, shot, verdict) = shade(1, EDGE_SAMPLES)?;
    let others = vec![shade(1, 1)?.0, shade(WORTH, 1)?.0];
    let shots = growing(&mut subject, &state, brute(*counts.last().unwrap_or(&1), 0), counts)?;
    let references: Vec<Row> =
        shots.iter().map(|shot| Ok(row("reference", shot, 1)?.0)).collect::<Result<_, AppError>>()?;
    let key = title.split(' ').next().unwrap_or_default().to_lowercase();
    let caption = |text: String| vec![title.to_owned(), text];
    let name = |what: &str| format!("samples-{key}-{what}");
    let pictures = [
        studio.picture(&name("truth"), &truth.image, 1.0, title, caption(format!("{converged} samples")))?,
        studio.picture(&name("leadr"), &shot.image, 1.0, title, caption("LEADR, one shaded sample".to_owned()))?,
        studio.error_picture(&name("errors"), &verdict, title, caption("FLIP errors of LEADR".to_owned()))?,
    ];
    let pictures = pictures.map(|figure| figure.enlarged(2));
    let mut case = Case::new("samples", title, &look.name, "displacement, with shadows of the relief", &verdict);
    case.figures = pictures.to_vec();
    studio.cases.push(case);
    let worth: Vec<_> = MEASURES.iter().map(|m| (m.name, worth(&points(&references, m.of), (m.of)(&leadr)))).collect();
    let faster = references.iter().find(|r| r.samples == WORTH).map(|r| r.milliseconds / leadr.milliseconds);
    let met = JUDGED.iter().all(|&i| worth[i].1.reaches(f64::from(WORTH))) && faster.is_some_and(|f| f >= FASTER);
    let race = Race {
        subject: title.to_owned(),
        size,
        converged_samples: converged,
        noise: truth.noise,
        leadr,
        others,
        references,
        worth,
        faster,
        met,
    };
    html.heading(title);
    html.figures(&pictures);
    html.plot(&plot(&race));
    html.table(&table(&race));
    Ok(race)
}

/// Pictures of more and more samples of one sequence; each has those of the ones before it.
fn growing(
    subject: &mut Subject,
    state: &FrameState,
    settings: RenderSettings,
    counts: &[u32],
) -> Result<Vec<Shot>, AppError> {
    let (mut sum, mut done, mut milliseconds) = (Accumulation::default(), 0, 0.0);
    let mut shots = Vec::new();
    for &samples in counts {
        let part = subject.renderer.render_range(state, &settings, done..samples)?;
        milliseconds += part.times.iter().map(|t| t.milliseconds).sum::<f64>();
        sum.add(&part.color, samples - done);
        done = samples;
        let mean = sum.mean();
        let texels = mean.iter().map(|c| [c[0], c[1], c[2]]).collect();
        let image = RgbImage::new(part.size.0, part.size.1, texels).map_err(fault)?;
        image.check_finite().map_err(fault)?;
        shots.push(Shot { image, coverage: mean.iter().map(|c| c[3]).collect(), milliseconds, samples, noise: 0.0 });
    }
    Ok(shots)
}

/// Samples and errors.
fn points(rows: &[Row], of: fn(&Row) -> f64) -> Vec<(f64, f64)> {
    rows.iter().map(|r| (f64::from(r.samples), of(r))).collect()
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
    let leadr = &race.leadr;
    plot.line("LEADR, one shaded sample", vec![(leadr.milliseconds, leadr.object.rrmse)]);
    plot.line("LEADR, one shaded sample, inside", vec![(leadr.milliseconds, leadr.interior.rrmse)]);
    plot
}

fn table(race: &Race) -> Table {
    let mut table = Table::new(
        format!(
            "Against {} samples of other seeds (noise {} inside), {} x {} pixels",
            race.converged_samples,
            number(race.noise),
            race.size,
            race.size
        ),
        [
            "",
            "samples",
            "edge samples",
            "rRMSE",
            "rRMSE inside",
            "FLIP",
            "FLIP inside",
            "bias inside",
            "ms",
            "times LEADR",
        ],
    );
    for row in std::iter::once(&race.leadr).chain(&race.others).chain(&race.references) {
        let numbers = [
            row.object.rrmse,
            row.interior.rrmse,
            row.object.flip,
            row.interior.flip,
            row.interior.bias,
            row.milliseconds,
            row.milliseconds / race.leadr.milliseconds,
        ];
        let head = [row.look.clone(), row.samples.to_string(), row.edge_samples.to_string()].map(Cell::from);
        table.row(head.into_iter().chain(numbers.map(Cell::from)));
    }
    table
}

/// The number of samples at which a reference's error is `error`, between the measured ones by powers.
fn worth(references: &[(f64, f64)], error: f64) -> Worth {
    let (Some(first), Some(last)) = (references.first(), references.last()) else { return Worth::Unknown };
    if error.is_nan() {
        return Worth::Unknown;
    }
    if first.1 <= error {
        return Worth::Below(first.0);
    }
    let Some(pair) = references.windows(2).find(|pair| pair[0].1 > error && pair[1].1 <= error) else {
        return Worth::Above(last.0);
    };
    let share = (pair[0].1 / error).ln() / (pair[0].1 / pair[1].1).ln();
    Worth::Equal(pair[0].0 * (pair[1].0 / pair[0].0).powf(share))
}

fn findings(race: &Race) -> Vec<String> {
    let leadr = &race.leadr;
    let worth: Vec<String> = race.worth.iter().map(|(name, worth)| format!("{worth} by {name}")).collect();
    let mut findings = vec![format!(
        "{}: one shaded sample of LEADR is worth so many samples of the reference: {}.",
        race.subject,
        worth.join(", ")
    )];
    if let [without, many] = &race.others[..] {
        findings.push(format!(
            "{}: its rRMSE is {}; {} without edge samples, {} with {} shaded samples, which leave the model's own error.",
            race.subject,
            number(leadr.object.rrmse),
            number(without.object.rrmse),
            number(many.object.rrmse),
            many.samples
        ));
    }
    if let Some(faster) = race.faster {
        findings.push(format!(
            "{}: {WORTH} samples of the reference take {} times as long. The goal (worth {WORTH} samples by rRMSE and FLIP of the whole object, {FASTER} times faster) is {}.",
            race.subject,
            number(faster),
            if race.met { "met" } else { "not met" },
        ));
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn samples_of_equal_error_are_interpolated() {
        let halves: Vec<(f64, f64)> = (0..5).map(|k| (4f64.powi(k), 0.5f64.powi(k))).collect();
        let equal = |error| match worth(&halves, error) {
            Worth::Equal(n) => n,
            other => panic!("{other}"),
        };
        assert!((equal(0.25) - 16.0).abs() < 1e-9);
        assert!((equal(0.5f64.powf(1.5)) - 8.0).abs() < 1e-9);
        assert_eq!((worth(&halves, 2.0), worth(&halves, 0.01)), (Worth::Below(1.0), Worth::Above(256.0)));
        assert_eq!((worth(&[], 1.0), worth(&halves, f64::NAN)), (Worth::Unknown, Worth::Unknown));
        assert!(Worth::Above(128.0).reaches(64.0) && Worth::Equal(64.0).reaches(64.0));
        assert!(!Worth::Below(64.0).reaches(64.0) && !Worth::Unknown.reaches(1.0));
    }
}
