//! Measures flicker while the camera moves away.

use serde::Serialize;

use crate::report::configuration::Configuration;
use crate::report::section::Section;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use crate::report::truth::Truth;
use crate::report::verdict::Shot;
use leadr_maps::RgbImage;
use leadr_render::sampling::independent_seed;
use leadr_render::settings::Technique;
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, number};
use leadr_tools::html::{Plot, Scale};
use leadr_tools::metrics::Mask;
use leadr_tools::metrics::flicker::{change, excess, magnitude};

const INTRO: &str = "The camera moves away from the rough sphere in small steps, each by the same factor, at one sample per pixel. For \
    each comparison, the earlier picture is resampled into the frame of the later one (the mean over each later pixel's area). Even a \
    perfect renderer would show some change from the resampling filter, parallax, and changing light. That is the reference's own change; \
    flicker is a technique's change beyond it, pixel by pixel. The row with the reference's noise gives the uncertainty. A technique with \
    a GGX base is compared with the reference of that base. All numbers are over the interior of the sphere and relative to its mean \
    radiance.";

#[derive(Debug, Serialize)]
struct Track {
    look: String,
    /// The mean flicker per pixel in every step.
    mean: Vec<f64>,
    /// The largest flicker of a pixel in every step.
    max: Vec<f64>,
    /// The mean change per pixel in every step, including the change of the reference.
    own_mean: Vec<f64>,
    /// The largest change of a pixel in every step, including the change of the reference.
    own_max: Vec<f64>,
}

#[derive(Debug, Serialize)]
struct Sweep {
    distances: Vec<f64>,
    ratio: f64,
    size: u32,
    reference_samples: u32,
    tracks: Vec<Track>,
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let size = studio.pick(64, 128);
    let (steps, from, to) = studio.pick((8, 10.0, 13.0), (48, 5.0, 40.0f64));
    let samples = studio.pick(16, 64);
    let ratio = (to / from).powf(1.0 / f64::from(steps));
    let distances: Vec<f64> = (0..=steps).map(|i| from * ratio.powi(i)).collect();
    let mut subject = Subject::rock(studio, studio.pick(16, 32))?;
    let configs = Configuration::techniques();
    studio.steps(distances.len());
    // Each row has the pictures of one step: the reference, one half of the reference, every configuration, and the
    // reference of a GGX base.
    let mut rows: Vec<Vec<Shot>> = Vec::new();
    for &distance in &distances {
        let state = subject.seen_by(&subject.stage.views.mid.at_distance(distance as f32));
        let mut settings: Vec<_> = [1, independent_seed(samples, 1)]
            .map(|seed| Truth::Displacement.settings((size, size), samples, seed))
            .to_vec();
        settings.extend(configs.iter().map(|config| config.settings((size, size), 1)));
        settings.push(Truth::Displacement.settings_for(Technique::LeadrGgx, (size, size), 2 * samples, 1));
        let shots = settings.iter().map(|s| studio.shoot(&mut subject.renderer, &state, s));
        let mut shots: Vec<Shot> = shots.collect::<Result<_, _>>()?;
        // The reference is the mean of both seeds, and differs from each of them by its own error.
        shots[0] = Shot::mean_of(&shots[0], &shots[1]).map_err(fault)?;
        rows.push(shots);
        studio.step();
    }
    let names = ["reference".to_owned(), "noise of the reference".to_owned()]
        .into_iter()
        .chain(configs.iter().map(|l| l.name.clone()));
    let mut tracks: Vec<Track> =
        names.map(|look| Track { look, mean: vec![], max: vec![], own_mean: vec![], own_max: vec![] }).collect();
    for pair in rows.windows(2) {
        let mask = seen_by_both(&pair[0][0], &pair[1][0], ratio)?;
        let unit = pair[1][0].luminance(&mask).max(1e-9);
        let changes: Vec<RgbImage> = pair[0]
            .iter()
            .zip(&pair[1])
            .map(|(before, after)| change(&before.image, &after.image, ratio).map_err(fault))
            .collect::<Result<_, _>>()?;
        let of_ggx = &changes[changes.len() - 1];
        for (i, (track, moved)) in tracks.iter_mut().zip(&changes).enumerate() {
            let ggx = i.checked_sub(2).is_some_and(|config| configs[config].shading.technique().has_ggx_base());
            let reference = if ggx { of_ggx } else { &changes[0] };
            let (own, beyond) =
                (magnitude(moved, &mask).map_err(fault)?, excess(moved, reference, &mask).map_err(fault)?);
            track.mean.push(beyond.mean / unit);
            track.max.push(beyond.max / unit);
            track.own_mean.push(own.mean / unit);
            track.own_max.push(own.max / unit);
        }
    }
    let sweep = Sweep { distances, ratio, size, reference_samples: 2 * samples, tracks };
    let section = Section::new(INTRO, findings(&sweep), &shown(&sweep), &sweep)?;
    Ok(section)
}

/// Returns the interior of the object that both pictures show, in the frame of the second picture.
fn seen_by_both(before: &Shot, after: &Shot, ratio: f64) -> Result<Mask, LabError> {
    let (width, height) = (before.image.width, before.image.height);
    let inside = before.interior().map_err(fault)?;
    let flags = inside.inside.iter().map(|&i| [if i { 1.0 } else { 0.0 }; 3]).collect();
    let flags = RgbImage::new(width, height, flags).map_err(fault)?;
    let moved = leadr_tools::metrics::flicker::shrunk(&flags, ratio).map_err(fault)?;
    let coverage: Vec<f32> = moved.texels.iter().map(|t| t[0]).collect();
    let before = Mask::covered(width, height, &coverage, 0.999).map_err(fault)?;
    Ok(before.and(&after.interior().map_err(fault)?))
}

fn mean(values: &[f64]) -> f64 {
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn largest(values: &[f64]) -> f64 {
    values.iter().copied().fold(0.0, f64::max)
}

fn shown(sweep: &Sweep) -> Html {
    let mut html = Html::new();
    let middles: Vec<f64> = sweep.distances.windows(2).map(|p| (p[0] * p[1]).sqrt()).collect();
    for (title, pick) in [
        ("Mean flicker per pixel and step", (|t| &t.mean) as fn(&Track) -> &Vec<f64>),
        ("Largest flicker of a pixel in each step", |t| &t.max),
    ] {
        let mut plot = Plot::new(title, ("distance, metres", Scale::Log), ("share of the mean radiance", Scale::Log));
        for track in &sweep.tracks[1..] {
            plot.line(&track.look, middles.iter().copied().zip(pick(track).iter().copied()).collect());
        }
        html.plot(&plot);
    }
    let mut table = Table::new(
        format!(
            "{} steps of a ratio of {}, {} x {} pixels, reference of {} samples; shares of the mean radiance",
            middles.len(),
            number(sweep.ratio),
            sweep.size,
            sweep.size,
            sweep.reference_samples
        ),
        ["technique", "flicker, mean", "flicker, largest", "change, mean", "change, largest"],
    );
    for track in &sweep.tracks {
        let cells = [mean(&track.mean), largest(&track.max), mean(&track.own_mean), largest(&track.own_max)];
        table.row(std::iter::once(Cell::from(track.look.as_str())).chain(cells.map(Cell::from)));
    }
    html.table(&table);
    html
}

fn findings(sweep: &Sweep) -> Vec<String> {
    let mut order: Vec<(&str, f64, f64)> =
        sweep.tracks[2..].iter().map(|t| (t.look.as_str(), mean(&t.mean), largest(&t.max))).collect();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (Some(calm), Some(restless)) = (order.first(), order.last()) else { return Vec::new() };
    let noise = mean(&sweep.tracks[1].mean);
    let mut findings = vec![
        format!(
            "{} flickers least: {} of the mean radiance per pixel and step on average, {} at worst; {} flickers most: {} and {}.",
            calm.0,
            number(calm.1),
            number(calm.2),
            restless.0,
            number(restless.1),
            number(restless.2)
        ),
        format!(
            "The measurement is uncertain by {}, the noise of a reference of {} samples: {}.",
            number(noise),
            sweep.reference_samples,
            if noise < 0.3 * calm.1 {
                "the order of the techniques is certain"
            } else {
                "smaller differences are not significant"
            }
        ),
    ];
    let worst = |name: &str| order.iter().find(|t| t.0 == name);
    if let (Some(rules), Some(grid)) = (worst("leadr visible 9"), worst("leadr 5×5")) {
        findings.push(format!(
            "The visible-slope rules flicker {} times as much as the paper's 5×5 grid on average, and {} times in the worst pixel.",
            number(rules.1 / grid.1),
            number(rules.2 / grid.2)
        ));
    }
    findings
}
