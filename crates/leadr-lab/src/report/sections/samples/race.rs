//! Runs LEADR with one shaded sample against references with increasing sample counts on one subject.

use serde::Serialize;

use super::worth::{Worth, own, shared};
use crate::report::case::Case;
use crate::report::configuration::Configuration;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use crate::report::truth::Truth;
use crate::report::verdict::{Errors, Shot, Verdict, judge};
use leadr_maps::RgbImage;
use leadr_render::camera::Camera;
use leadr_render::passes::accumulate::Accumulation;
use leadr_render::scene::FrameState;
use leadr_render::settings::{RenderSettings, ShadingOptions};
use leadr_tools::error::LabError;
use leadr_tools::html::Figure;
use leadr_tools::metrics::Mask;
use leadr_tools::metrics::compare::rrmse_over;

/// The number of edge samples per pixel of the judged picture. More edge samples hardly change its errors
/// (docs/measurements/samples.md).
const EDGE_SAMPLES: u32 = 64;
/// The sample count of the reference whose accuracy LEADR should match.
pub const WORTH: u32 = 64;
/// The goal for the speed of LEADR, as a factor over the reference of [`WORTH`] samples.
pub const FASTER: f64 = 50.0;

/// A subject and its settings.
pub struct Contest {
    /// The title on the page.
    pub title: String,
    /// The name of the subject in the file names of pictures.
    pub key: &'static str,
    /// Whether the goal applies to the subject.
    pub goal: bool,
    /// The uploaded stage with its lights.
    pub subject: Subject,
    /// The camera of all pictures.
    pub camera: Camera,
    /// The number of pixels along a side of the pictures.
    pub size: u32,
    /// The mean number of bumps per pixel, if known.
    pub bumps_per_pixel: Option<f64>,
    /// The largest number of vertices per pixel along each axis in a reference, which is enough to resolve the bumps.
    pub vertices_per_pixel: f32,
    /// The number of samples of the truth.
    pub converged: u32,
    /// The sample counts of the references.
    pub counts: &'static [u32],
}

/// The relative RMSE over the object and over its interior.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Pair {
    /// The relative RMSE over the pixels that the object touches.
    pub object: f64,
    /// The relative RMSE over the object's interior.
    pub interior: f64,
}

/// The settings and errors of one picture of a subject.
#[derive(Debug, Serialize)]
pub struct Row {
    /// The name of the technique.
    pub look: String,
    /// The number of shaded samples per pixel.
    pub samples: u32,
    /// The number of edge samples per pixel.
    pub edge_samples: u32,
    /// The device time of all passes in milliseconds.
    pub milliseconds: f64,
    /// The errors over the whole object.
    pub object: Errors,
    /// The errors over the object's interior.
    pub interior: Errors,
    /// The relative RMSE, after subtracting the truth's own noise.
    pub own: Pair,
    /// The part of the interior error that neighbouring pixels share, from their correlation.
    pub common: f64,
}

/// An error measure that the tables list.
#[derive(Clone, Copy)]
pub struct Measure {
    /// The name of the measure.
    pub name: &'static str,
    /// The function that returns the error.
    pub of: fn(&Row) -> f64,
}

/// All error measures of the tables.
pub const MEASURES: [Measure; 4] = [
    Measure { name: "rRMSE", of: |r| r.own.object },
    Measure { name: "rRMSE inside", of: |r| r.own.interior },
    Measure { name: "FLIP", of: |r| r.object.flip },
    Measure { name: "FLIP inside", of: |r| r.interior.flip },
];
/// The indices in [`MEASURES`] of the two measures that the goal uses. The two measures are over the whole object.
const JUDGED: [usize; 2] = [0, 2];

/// The result of a contest.
#[derive(Debug, Serialize)]
pub struct Race {
    pub subject: String,
    /// Whether the goal applies to the subject.
    pub goal: bool,
    pub size: u32,
    pub bumps_per_pixel: Option<f64>,
    pub converged_samples: u32,
    /// The noise of the converged reference, as relative RMSE.
    pub noise: Pair,
    /// The judged picture of LEADR, with one shaded sample and edge samples.
    pub leadr: Row,
    /// LEADR without edge samples, and LEADR with many shaded samples.
    pub others: Vec<Row>,
    pub references: Vec<Row>,
    /// What the judged picture is worth by each measure.
    pub worth: Vec<(&'static str, Worth)>,
    /// What the judged picture is worth by interior rRMSE, in a harder test: the reference's neighbouring pixels have
    /// independent errors.
    pub worth_apart: Worth,
    /// The time of a reference of [`WORTH`] samples, relative to LEADR's time.
    pub faster: Option<f64>,
    /// Whether the goal is met. LEADR must be worth [`WORTH`] samples by the judged measures, and be [`FASTER`] times as
    /// fast.
    pub met: bool,
}

impl Race {
    /// Returns the reference of [`WORTH`] samples.
    pub fn judge(&self) -> Option<&Row> {
        self.references.iter().find(|r| r.samples == WORTH)
    }
}

/// The pictures of a race: the truth, LEADR, and LEADR's errors.
pub struct Pictures {
    truth: RgbImage,
    leadr: RgbImage,
    verdict: Verdict,
}

impl Pictures {
    /// Stores the pictures for the page, and a case for the section of the worst pictures.
    pub fn keep(self, studio: &mut Studio, key: &str, race: &Race) -> Result<[Figure; 3], LabError> {
        let title = race.subject.as_str();
        let caption = |text: &str| vec![title.to_owned(), text.to_owned()];
        let name = |what: &str| format!("samples-{key}-{what}");
        let samples = format!("{} samples", race.converged_samples);
        let figures = [
            studio.picture(&name("truth"), &self.truth, 1.0, title, caption(&samples))?,
            studio.picture(&name("leadr"), &self.leadr, 1.0, title, caption("LEADR, one shaded sample"))?,
            studio.error_picture(&name("errors"), &self.verdict, title, caption("FLIP errors of LEADR"))?,
        ];
        let figures = figures.map(|figure| figure.enlarged((192 / race.size).max(1)));
        let mut case =
            Case::new("samples", title, &race.leadr.look, "displacement, with shadows of the relief", &self.verdict);
        case.figures = figures.to_vec();
        studio.cases.push(case);
        Ok(figures)
    }
}

struct Converged {
    shot: Shot,
    inside: Mask,
    noise: Pair,
    /// The value of [`Row::common`] for the interior noise.
    common: f64,
}

impl Converged {
    fn of(a: &Shot, b: &Shot) -> Result<Self, LabError> {
        let shot = Shot::mean_of(a, b).map_err(fault)?;
        let (object, inside) = (shot.object().map_err(fault)?, shot.interior().map_err(fault)?);
        // The difference of the two halves is twice the noise of their mean.
        let noise = |mask: &Mask| rrmse_over(&a.image, &b.image, mask).map(|error| 0.5 * error).map_err(fault);
        let noise = Pair { object: noise(&object)?, interior: noise(&inside)? };
        let common = shared(&a.image, &b.image, &inside) * noise.interior.powi(2);
        Ok(Self { shot, inside, noise, common })
    }

    fn row(&self, look: &str, shot: &Shot, edge_samples: u32) -> Result<(Row, Verdict), LabError> {
        let verdict = judge(&self.shot, shot, 1.0).map_err(fault)?;
        let Verdict { object, interior, .. } = verdict;
        let common = shared(&self.shot.image, &shot.image, &self.inside) * interior.rrmse.powi(2) - self.common;
        let own =
            Pair { object: own(object.rrmse, self.noise.object), interior: own(interior.rrmse, self.noise.interior) };
        let row = Row {
            look: look.to_owned(),
            samples: shot.samples,
            edge_samples,
            milliseconds: shot.milliseconds,
            object,
            interior,
            own,
            common: common.max(0.0).sqrt().min(own.interior),
        };
        Ok((row, verdict))
    }
}

/// Runs a contest. Returns the result and the pictures.
pub fn race(studio: &Studio, contest: Contest) -> Result<(Race, Pictures), LabError> {
    let Contest { title, goal, mut subject, camera, size, bumps_per_pixel, converged, counts, .. } = contest;
    let state = subject.seen_by(&camera);
    let brute = |samples, seed| {
        let mut settings = Truth::Shadowed.settings((size, size), samples, seed);
        settings.tessellation.vertices_per_pixel = contest.vertices_per_pixel;
        settings
    };
    let mut half = |seed| studio.shoot(&mut subject.renderer, &state, &brute(converged.div_ceil(2), seed));
    let truth = Converged::of(&half(3)?, &half(4)?)?;
    let config = Configuration::program_default();
    let mut shade = |samples, edge_samples| -> Result<_, LabError> {
        let shading = config.shading.adjusted(|options| ShadingOptions { edge_samples, ..options });
        let settings = RenderSettings { shading, ..config.settings((size, size), samples) };
        // The first run builds pipelines, so it is not measured.
        studio.shoot(&mut subject.renderer, &state, &RenderSettings { samples: 1, ..settings })?;
        let shot = studio.shoot(&mut subject.renderer, &state, &settings)?;
        let (row, verdict) = truth.row(&config.name, &shot, edge_samples)?;
        Ok((row, shot, verdict))
    };
    let (leadr, shot, verdict) = shade(1, EDGE_SAMPLES)?;
    let others = vec![shade(1, 1)?.0, shade(WORTH, 1)?.0];
    let shots = growing(&mut subject, &state, brute(*counts.last().unwrap_or(&1), 0), counts)?;
    let references: Vec<Row> =
        shots.iter().map(|shot| Ok(truth.row("reference", shot, 1)?.0)).collect::<Result<_, LabError>>()?;
    let race = Race {
        worth: MEASURES.iter().map(|m| (m.name, Worth::of(&points(&references, m.of), (m.of)(&leadr)))).collect(),
        worth_apart: Worth::of(&points(&references, |r| own(r.own.interior, r.common)), leadr.own.interior),
        faster: references.iter().find(|r| r.samples == WORTH).map(|r| r.milliseconds / leadr.milliseconds),
        met: false,
        subject: title,
        goal,
        size,
        bumps_per_pixel,
        converged_samples: truth.shot.samples,
        noise: truth.noise,
        leadr,
        others,
        references,
    };
    let race = Race { met: meets(&race.worth, race.faster), ..race };
    Ok((race, Pictures { truth: truth.shot.image, leadr: shot.image, verdict }))
}

/// Whether every judged measure and the time meet the goal.
fn meets(worth: &[(&str, Worth)], faster: Option<f64>) -> bool {
    JUDGED.iter().all(|&i| worth[i].1.reaches(f64::from(WORTH))) && faster.is_some_and(|f| f >= FASTER)
}

/// Renders pictures with increasing sample counts from one sequence. Each picture contains the samples of the previous
/// pictures.
fn growing(
    subject: &mut Subject,
    state: &FrameState,
    settings: RenderSettings,
    counts: &[u32],
) -> Result<Vec<Shot>, LabError> {
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

/// Returns the sample count and error of each row.
fn points(rows: &[Row], of: fn(&Row) -> f64) -> Vec<(f64, f64)> {
    rows.iter().map(|r| (f64::from(r.samples), of(r))).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Returns a picture of a disc. `value` gives the radiance of each pixel.
    fn disc(value: impl Fn(u32, u32) -> f32, samples: u32) -> Shot {
        let (mut texels, mut coverage) = (Vec::new(), Vec::new());
        for y in 0..40u32 {
            for x in 0..40u32 {
                let share = (17.0 - (x as f32 - 19.5).hypot(y as f32 - 19.5)).clamp(0.0, 1.0);
                texels.push([value(x, y) * share; 3]);
                coverage.push(share);
            }
        }
        Shot { image: RgbImage::new(40, 40, texels).unwrap(), coverage, milliseconds: 1.0, samples, noise: 0.0 }
    }

    fn sign(seed: u32, x: u32, y: u32) -> f32 {
        let mixed = (x.wrapping_mul(0x9e37_79b9) ^ y.wrapping_mul(0x85eb_ca6b) ^ seed.wrapping_mul(0xc2b2_ae35))
            .wrapping_mul(0x27d4_eb2f);
        if (mixed ^ mixed >> 15).wrapping_mul(0x2c1b_3c6d) >> 31 == 0 { 1.0 } else { -1.0 }
    }

    #[test]
    fn truth_noise_is_subtracted_and_common_errors_reported() {
        let noisy = |seed| disc(move |x, y| 1.0 + 0.1 * sign(seed, x, y), 32);
        let truth = Converged::of(&noisy(1), &noisy(2)).unwrap();
        let noise = 0.1 / 2f64.sqrt();
        assert!((truth.noise.interior / noise - 1.0).abs() < 0.1, "{:?}", truth.noise);
        let (exact, _) = truth.row("exact", &disc(|_, _| 1.0, 1), 1).unwrap();
        assert!(exact.interior.rrmse > 0.06 && exact.own.interior < 0.025, "{exact:?}");
        let (dim, _) = truth.row("dim", &disc(|_, _| 0.9, 1), 1).unwrap();
        assert!((dim.own.interior - 0.1).abs() < 0.02 && (dim.common - 0.1).abs() < 0.02, "{dim:?}");
        let (grainy, _) = truth.row("grainy", &disc(|x, y| 1.0 + 0.1 * sign(3, x, y), 1), 1).unwrap();
        assert!((grainy.own.interior - 0.1).abs() < 0.02 && grainy.common < 0.04, "{grainy:?}");
    }

    #[test]
    fn goal_requires_whole_object_and_time() {
        let worth = |object: f64, inside: f64, flip: f64| {
            [("rRMSE", object), ("rRMSE inside", inside), ("FLIP", flip), ("FLIP inside", inside)]
                .map(|(name, n)| (name, Worth::Equal(n)))
        };
        assert_eq!(MEASURES.map(|m| m.name), worth(0.0, 0.0, 0.0).map(|w| w.0));
        assert!(meets(&worth(64.0, 1.0, 70.0), Some(50.0)));
        assert!(!meets(&worth(63.0, 99.0, 99.0), Some(99.0)) && !meets(&worth(99.0, 99.0, 63.0), Some(99.0)));
        assert!(!meets(&worth(99.0, 99.0, 99.0), Some(49.0)) && !meets(&worth(99.0, 99.0, 99.0), None));
    }
}
