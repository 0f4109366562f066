//! Measures the sea. LEADR Figure 10 is compared with a ray-marched truth, and flicker is measured while the camera or the
//! waves move.

use glam::Vec3;
use serde::Serialize;

use crate::report::configuration::Configuration;
use crate::report::section::Section;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use crate::report::truth::Truth;
use crate::report::verdict::{Errors, Shot, judge};
use leadr_maps::RgbImage;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::camera::Camera;
use leadr_render::sampling::independent_seed;
use leadr_render::settings::{Technique, Terms};
use leadr_scenes::ocean::sea;
use leadr_scenes::ocean::spectrum::Sea;
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, number, percent};
use leadr_tools::metrics::Mask;
use leadr_tools::metrics::flicker::{change, excess, magnitude};

const INTRO: &str = "The open sea of the ocean scene, under a wind of 8 m/s, seen toward the sun. The truth casts rays at the displaced \
    waves, including horizontal movement, and shades each hit by its own slope. Only waves shorter than those of the finest map become \
    roughness, as in every technique. The truth masks facets from the viewer, but does not shadow them, and reflects light once. LEADR is \
    therefore shown with Smith's shadowing (of the sun alone) and with the default correlated shadowing of sun and sky. Errors are over \
    the sea's interior, without the horizon. Changes are per pixel between successive pictures, as fractions of the sea's mean radiance. \
    Excess is a technique's change beyond the truth, pixel by pixel. The change of the truth includes its own noise, which is listed.";

/// The number of frames per second of the animation.
const FPS: f64 = 24.0;
/// The field of view in degrees of the camera that looks at the horizon.
const TELEPHOTO: f32 = 6.0;

#[derive(Debug, Serialize)]
struct Picture {
    view: &'static str,
    look: String,
    errors: Errors,
    noise: f64,
}

#[derive(Debug, Default, Serialize)]
struct Track {
    look: String,
    /// The mean and largest change of a pixel in each step.
    change: Vec<[f64; 2]>,
    /// The mean and largest change of a pixel in each step, beyond the change of the truth.
    excess: Vec<[f64; 2]>,
}

#[derive(Debug, Serialize)]
struct Sequence {
    name: &'static str,
    size: (u32, u32),
    samples: u32,
    /// The changes of the truth, of its noise, and of every configuration.
    tracks: Vec<Track>,
}

#[derive(Debug, Serialize)]
struct Data {
    pictures: Vec<Picture>,
    zoom: Sequence,
    animation: Sequence,
    /// The number of animation frames of `every_frame`, which has the mean and the largest change of every configuration.
    frames: u32,
    every_frame: Vec<(String, [f64; 2])>,
}

/// Returns a camera that looks towards the default sun from `height`, at a point of the sea `distance` away. The field of
/// view is in degrees.
fn toward_the_sun(height: f32, distance: f32, fov: f32) -> Camera {
    let (sin, cos) = (-0.7f32).sin_cos();
    Camera::looking_at(Vec3::Z * height, Vec3::new(cos, sin, 0.0) * distance, fov)
}

fn configs() -> Vec<Configuration> {
    let correlated = Configuration::of(Technique::Leadr).with(Terms::ALL, Shadowing::Correlated);
    vec![
        Configuration::grid(5),
        Configuration { name: "leadr, correlated".to_owned(), ..correlated },
        Configuration::of(Technique::Lean),
        Configuration::of(Technique::NormalMip),
        Configuration::of(Technique::Constant),
    ]
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let mut subject = Subject::under_the_sky(studio, sea::stage(sea::ocean(&Sea::default(), sea::RESOLUTION, 1)), 5.0)?;
    let configs = configs();
    let mut html = Html::new();
    let pictures = figures(studio, &mut subject, &configs, &mut html)?;
    let size = studio.pick((48, 27), (96, 54));
    let samples = studio.pick(8, 48);
    let steps = studio.pick(2, 8);
    let ratio = 1.03f64;
    let zoom: Vec<_> = (0..=steps)
        .map(|step| {
            let camera = toward_the_sun(15.0, 70.0, 30.0);
            let distance = f64::from(camera.position.distance(camera.target));
            (5.0, camera.at_distance((distance * ratio.powi(step)) as f32))
        })
        .collect();
    let zoom = sequence(studio, &mut subject, &configs, "moving away", size, samples, &[zoom], ratio)?;
    let horizon = toward_the_sun(20.0, 1000.0, TELEPHOTO);
    let frames: u32 = studio.pick(6, 240);
    let pairs = studio.pick(1, 6);
    let pairs: Vec<Vec<_>> = (0..pairs)
        .map(|pair| {
            let first = f64::from(pair * frames / pairs) / FPS;
            vec![(first, horizon), (first + 1.0 / FPS, horizon)]
        })
        .collect();
    let animation = sequence(studio, &mut subject, &configs, "waves at the horizon", size, samples, &pairs, 1.0)?;
    let every_frame = all_frames(studio, &mut subject, &configs[..configs.len() - 1], horizon, size, frames)?;
    shown(&mut html, &zoom, &animation, frames, &every_frame);
    let data = Data { pictures, zoom, animation, frames, every_frame };
    Section::new(INTRO, findings(&data), &html, &data)
}

/// Renders Figure 10, which shows every configuration at four distances.
fn figures(
    studio: &mut Studio,
    subject: &mut Subject,
    configs: &[Configuration],
    html: &mut Html,
) -> Result<Vec<Picture>, LabError> {
    let size = studio.pick((48, 30), (160, 100));
    let samples = studio.pick(8, 96);
    let views = subject.stage.views;
    let views = [
        ("2.5 m", views.near),
        ("100 m", views.mid),
        ("1 km", views.far),
        ("horizon", toward_the_sun(20.0, 1000.0, TELEPHOTO)),
    ];
    let mut pictures = Vec::new();
    for (view, camera) in views {
        let state = subject.seen_by(&camera);
        let truth =
            studio.shoot_truth(&mut subject.renderer, &state, &Truth::Displacement.settings(size, samples, 1))?;
        let mut table = Table::new(
            format!("{view}: truth of {samples} samples per pixel, its noise {}", number(truth.noise)),
            ["technique", "picture", "FLIP errors", "FLIP", "rRMSE", "bias"],
        );
        let file = |kind: &str| format!("ocean-{}-{kind}", view.replace([' ', '.'], ""));
        let shown = studio.picture(&file("truth"), &truth.image, 1.0, "ray-marched truth", Vec::new())?;
        table.row([Cell::from("truth"), Cell::Figure(shown.enlarged(2))]);
        for config in configs {
            let shot = studio.shoot(&mut subject.renderer, &state, &config.settings(size, 1))?;
            let verdict = judge(&truth, &shot, 1.0).map_err(fault)?;
            let picture = studio.picture(&file(&config.file()), &shot.image, 1.0, &config.name, Vec::new())?;
            let errors = studio.error_picture(
                &file(&format!("{}-errors", config.file())),
                &verdict,
                "FLIP errors",
                Vec::new(),
            )?;
            let found = verdict.interior;
            let mut cells = vec![Cell::from(config.name.as_str())];
            cells.extend([picture, errors].map(|figure| Cell::Figure(figure.enlarged(2))));
            cells.extend([found.flip, found.rrmse, found.bias].map(Cell::from));
            table.row(cells);
            pictures.push(Picture { view, look: config.name.clone(), errors: found, noise: truth.noise });
        }
        html.heading(view);
        html.table(&table);
    }
    Ok(pictures)
}

/// Measures the changes between successive pictures, for each run of times and cameras. `ratio` is the ratio of neighbouring
/// distances.
fn sequence(
    studio: &Studio,
    subject: &mut Subject,
    configs: &[Configuration],
    name: &'static str,
    size: (u32, u32),
    samples: u32,
    runs: &[Vec<(f64, Camera)>],
    ratio: f64,
) -> Result<Sequence, LabError> {
    let names = ["truth", "noise of the truth"].into_iter().map(str::to_owned);
    let mut tracks: Vec<Track> =
        names.chain(configs.iter().map(|l| l.name.clone())).map(|look| Track { look, ..Track::default() }).collect();
    studio.steps(runs.iter().map(Vec::len).sum());
    for run in runs {
        let mut before: Option<Vec<Shot>> = None;
        for &(time, camera) in run {
            subject.set_time(time);
            let state = subject.seen_by(&camera);
            // Every picture uses the same sample positions, so only the sea changes.
            let mut settings = [1, independent_seed(samples / 2, 1)]
                .map(|seed| Truth::Displacement.settings(size, samples / 2, seed))
                .to_vec();
            settings.extend(configs.iter().map(|config| config.settings(size, 1)));
            let shots = settings.iter().map(|s| studio.shoot(&mut subject.renderer, &state, s));
            let mut after: Vec<Shot> = shots.collect::<Result<_, _>>()?;
            after[0] = Shot::mean_of(&after[0], &after[1]).map_err(fault)?;
            if let Some(before) = &before {
                add_step(&mut tracks, before, &after, ratio)?;
            }
            before = Some(after);
            studio.step();
        }
    }
    Ok(Sequence { name, size, samples, tracks })
}

fn add_step(tracks: &mut [Track], before: &[Shot], after: &[Shot], ratio: f64) -> Result<(), LabError> {
    let mask = seen_by_both(&before[0], &after[0], ratio)?;
    let unit = after[0].luminance(&mask).max(1e-9);
    let changes: Vec<RgbImage> = before
        .iter()
        .zip(after)
        .map(|(before, after)| change(&before.image, &after.image, ratio).map_err(fault))
        .collect::<Result<_, _>>()?;
    for (track, moved) in tracks.iter_mut().zip(&changes) {
        let (own, beyond) =
            (magnitude(moved, &mask).map_err(fault)?, excess(moved, &changes[0], &mask).map_err(fault)?);
        track.change.push([own.mean / unit, own.max / unit]);
        track.excess.push([beyond.mean / unit, beyond.max / unit]);
    }
    Ok(())
}

/// Returns the interior of the sea that both pictures show, in the frame of the second picture.
fn seen_by_both(before: &Shot, after: &Shot, ratio: f64) -> Result<Mask, LabError> {
    let (now, then) = (after.interior().map_err(fault)?, before.interior().map_err(fault)?);
    let flags = then.inside.iter().map(|&inside| [f32::from(u8::from(inside)); 3]).collect();
    let flags = RgbImage::new(then.width, then.height, flags).map_err(fault)?;
    let flags = leadr_tools::metrics::flicker::shrunk(&flags, ratio).map_err(fault)?;
    let coverage: Vec<f32> = flags.texels.iter().map(|t| t[0]).collect();
    Ok(now.and(&Mask::covered(then.width, then.height, &coverage, 0.999).map_err(fault)?))
}

/// Measures the mean and the largest change of every configuration between animation frames.
fn all_frames(
    studio: &Studio,
    subject: &mut Subject,
    configs: &[Configuration],
    camera: Camera,
    size: (u32, u32),
    frames: u32,
) -> Result<Vec<(String, [f64; 2])>, LabError> {
    let mut sums = vec![[0.0f64; 2]; configs.len()];
    let mut before: Option<Vec<Shot>> = None;
    studio.steps(frames as usize);
    for frame in 0..frames {
        subject.set_time(f64::from(frame) / FPS);
        let state = subject.seen_by(&camera);
        let shots = configs.iter().map(|l| studio.shoot(&mut subject.renderer, &state, &l.settings(size, 1)));
        let after: Vec<Shot> = shots.collect::<Result<_, _>>()?;
        for ((before, after), sum) in before.iter().flatten().zip(&after).zip(&mut sums) {
            let mask = after.interior().map_err(fault)?;
            let unit = after.luminance(&mask).max(1e-9);
            let moved = magnitude(&change(&before.image, &after.image, 1.0).map_err(fault)?, &mask).map_err(fault)?;
            sum[0] += moved.mean / unit / f64::from(frames - 1);
            sum[1] = sum[1].max(moved.max / unit);
        }
        before = Some(after);
        studio.step();
    }
    Ok(configs.iter().map(|l| l.name.clone()).zip(sums).collect())
}

/// Returns the mean over steps of the mean change, and the largest change of all steps.
fn summary(steps: &[[f64; 2]]) -> [f64; 2] {
    let mean = steps.iter().map(|s| s[0]).sum::<f64>() / steps.len().max(1) as f64;
    [mean, steps.iter().map(|s| s[1]).fold(0.0, f64::max)]
}

fn shown(html: &mut Html, zoom: &Sequence, animation: &Sequence, frames: u32, every_frame: &[(String, [f64; 2])]) {
    for sequence in [zoom, animation] {
        let steps = sequence.tracks.first().map_or(0, |t| t.change.len());
        let (width, height) = sequence.size;
        let mut table = Table::new(
            format!("{}: {steps} steps, {width}x{height} pixels, truth of {} samples", sequence.name, sequence.samples),
            ["technique", "change, mean", "change, largest", "excess, mean", "excess, largest"],
        );
        for track in &sequence.tracks {
            let numbers = [summary(&track.change), summary(&track.excess)].concat();
            table.row(std::iter::once(Cell::from(track.look.as_str())).chain(numbers.into_iter().map(Cell::from)));
        }
        html.heading(sequence.name);
        html.table(&table);
    }
    let mut table = Table::new(
        format!("waves at the horizon: all {frames} frames at {FPS} per second"),
        ["technique", "change, mean", "change, largest"],
    );
    for (look, [mean, largest]) in every_frame {
        table.row([Cell::from(look.as_str()), Cell::from(*mean), Cell::from(*largest)]);
    }
    html.table(&table);
}

fn findings(data: &Data) -> Vec<String> {
    let mut findings = Vec::new();
    for view in data.pictures.iter().map(|p| p.view).collect::<std::collections::BTreeSet<_>>() {
        let mut order: Vec<&Picture> = data.pictures.iter().filter(|p| p.view == view).collect();
        order.sort_by(|a, b| a.errors.rrmse.total_cmp(&b.errors.rrmse));
        let listed = order
            .iter()
            .map(|p| format!("{} {} (bias {})", p.look, number(p.errors.rrmse), percent(p.errors.bias, true)));
        let noise = order.first().map_or(0.0, |p| p.noise);
        findings.push(format!(
            "{view}, in order of rRMSE (noise of the truth {}): {}.",
            number(noise),
            listed.collect::<Vec<_>>().join(", ")
        ));
    }
    for sequence in [&data.zoom, &data.animation] {
        let of = |i: usize| summary(&sequence.tracks[i].change);
        let ([truth, _], [noise, _]) = (of(0), of(1));
        let listed = sequence.tracks[2..].iter().map(|t| format!("{} {}", t.look, number(summary(&t.change)[0])));
        findings.push(format!(
            "{}: mean change per pixel and step {} in the truth ({} with half its samples): {}.",
            sequence.name,
            number(truth),
            number(noise),
            listed.collect::<Vec<_>>().join(", ")
        ));
    }
    findings
}
