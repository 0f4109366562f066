//! Paint that follows the relief: the whole picture at one sample.

use glam::Vec3;
use serde::Serialize;

use crate::lab::error::LabError;
use crate::lab::metrics::Mask;
use crate::lab::ray_cast::{Spectrum, Tile};
use crate::lab::report::html::{Cell, Html, Table, number};
use crate::lab::report::section::Section;
use crate::lab::report::studio::{Studio, fault};
use crate::lab::report::subject::Subject;
use crate::lab::report::truth::Truth;
use crate::lab::report::verdict::{Shot, judge};
use crate::maps::{MapFault, RgbImage};
use crate::render::camera::Camera;
use crate::render::scene::{MaterialMap, Object};
use crate::render::settings::{RenderSettings, ShadingOptions, Technique};
use crate::render::surfaces::displacement::{Border, HeightField};
use crate::scenes::plane::{even, plane};
use crate::scenes::stage::{Stage, Views};

const INTRO: &str = "A matte plane of Gaussian bumps (slopes of deviation .6), red on grey: on the tops, in the cracks, on the slopes that \
    face one way, and nowhere. Near, a pixel sees about three bumps, far about fifty. One sample of LEADR under sky and sun is compared with the supersampled \
    reference whose bumps shadow each other: with colours that follow the relief, and with colours and light filtered \
    apart from each other (--relief-color off). The goal is a fifth of that error. The mean colour is the share of red, green and blue in \
    the light of the whole picture, so that neither brightness nor the place of a few bumps counts. Over the pixels, both count. Pictures of \
    several reliefs of the same kind are averaged, so that the error is that of the filter, without the grain that the few bumps of a pixel \
    have; the error with the grain of a single relief stands beside it. The goal of the pixels is judged after the squared noise of the truth, which is no \
    error of a filter, has been taken off their squared errors. Where nothing is painted, what is left is what the model of masking \
    and shadowing gets wrong about brightness, and no colour can be nearer than that.";

/// The part of the error of independent filtering that is the goal.
const GOAL: f64 = 0.2;
const RED: [u8; 4] = [200, 25, 20, 128];
const GREY: [u8; 4] = [110, 120, 130, 128];
/// Texels of the tile, which is one repeat of the plane.
const TEXELS: u32 = 256;
/// How many of them a pixel is wide.
const DISTANCES: [(u32, &str); 2] = [(TRUTH, "near"), (64, "far")];
/// How many of them a pixel of the truth is wide, of which those of far pictures are blocks: with the samples of one pixel alone, the
/// mean colour of a far truth is off by more than a tenth.
const TRUTH: u32 = 16;
const SIGMA: f32 = 0.6;
/// Reliefs whose pictures are averaged.
const RELIEFS: u32 = 8;
const DEGREES: [f32; 6] = [15.0, 30.0, 45.0, 60.0, 70.0, 80.0];

/// What is red.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
enum Paint {
    Tops,
    Cracks,
    OneSide,
    Nothing,
}

const PAINTS: [(Paint, &str); 4] =
    [(Paint::Tops, "tops"), (Paint::Cracks, "cracks"), (Paint::OneSide, "one side"), (Paint::Nothing, "nothing")];

#[derive(Serialize)]
struct Entry {
    paint: Paint,
    texels_per_pixel: u32,
    degrees: f32,
    followed: f64,
    apart: f64,
    mean_followed: f64,
    mean_apart: f64,
    noise: f64,
    /// As `followed` and `apart`, with the grain of single reliefs: their mean.
    followed_one: f64,
    apart_one: f64,
}

/// A view of one relief: the truth, and one sample with colours that follow it and with colours filtered apart.
struct Shown {
    truth: Shot,
    followed: Shot,
    apart: Shot,
}

impl Shown {
    /// The mean of views of several reliefs, whose truths are independent.
    fn mean(all: &[Self]) -> Result<Self, MapFault> {
        let each = |of: fn(&Self) -> &Shot| all.iter().map(|one| of(one).clone()).collect::<Vec<_>>();
        Ok(Self {
            truth: Shot::mean_of_truths(&each(|one| &one.truth))?,
            followed: Shot::mean(&each(|one| &one.followed))?,
            apart: Shot::mean(&each(|one| &one.apart))?,
        })
    }

    /// Relative RMSE over the pixels of both.
    fn errors(&self) -> Result<[f64; 2], MapFault> {
        let of = |shot| Ok(judge(&self.truth, shot, 1.0)?.object.rrmse);
        Ok([of(&self.followed)?, of(&self.apart)?])
    }
}

/// The share of each channel in the light of the object.
fn mean_color(image: &RgbImage, object: &Mask) -> [f64; 3] {
    let inside = image.texels.iter().zip(&object.inside).filter(|&(_, &inside)| inside);
    let sums = inside.fold([0.0; 3], |sums, (texel, _)| [0, 1, 2].map(|c| sums[c] + f64::from(texel[c])));
    let all = sums.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    sums.map(|sum| sum / all)
}

/// The distance of two colours, relative to the first.
fn apart_by(truth: [f64; 3], found: [f64; 3]) -> f64 {
    let length = |v: [f64; 3]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
    length([0, 1, 2].map(|c| found[c] - truth[c])) / length(truth)
}

fn painted(tile: &Tile, paint: Paint) -> Object {
    let heights = tile.heights();
    let mut order: Vec<usize> = (0..heights.len()).collect();
    order.sort_by(|&a, &b| heights[a].total_cmp(&heights[b]));
    let n = tile.size() as usize;
    let mut colors = vec![GREY; heights.len()];
    for (below, &i) in order.iter().enumerate() {
        let rank = below as f32 / heights.len() as f32;
        let rise = heights[i / n * n + (i + 1) % n] - heights[i / n * n + (i + n - 1) % n];
        let red = match paint {
            Paint::Tops => rank > 0.7,
            Paint::Cracks => rank < 0.3,
            Paint::OneSide => rise > 0.0,
            Paint::Nothing => false,
        };
        if red {
            colors[i] = RED;
        }
    }
    let field = HeightField { width: TEXELS, height: TEXELS, texels: heights.to_vec(), border: Border::Wrap };
    // Half a repeat around the one that is seen throws its shadows.
    Object::new("painted plane", plane(0.75, 12, 1.0, [1.0; 4], even))
        .with_heights(field, SIGMA / TEXELS as f32)
        .with_material(MaterialMap::new(TEXELS, TEXELS, colors))
        .with_specular_f0(0.0)
        .with_relief_color()
}

/// From so far away that rays are parallel, about one repeat of the relief; and the picture's size.
fn seen(degrees: f32, per_pixel: u32) -> (Camera, (u32, u32)) {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let columns = TEXELS / per_pixel;
    let rows = ((columns as f32 * cosine).round() as u32).max(1);
    let (toward, distance) = (Vec3::new(0.8 * sine, -0.6 * sine, cosine), 200.0);
    let fov = 2.0 * (0.5 * rows as f32 / columns as f32 / distance).atan().to_degrees();
    // A repeat, turned, reaches beyond the plane's corners.
    let fov = 0.9 * fov;
    (Camera { near: 1.0, ..Camera::looking_at(toward * distance, Vec3::ZERO, fov) }, (columns, rows))
}

/// A view of a relief from `degrees`.
fn shown(studio: &Studio, subject: &mut Subject, degrees: f32, per_pixel: u32, seed: u64) -> Result<Shown, LabError> {
    let samples: u32 = studio.pick(32, 128 / RELIEFS);
    let ((camera, size), block) = (seen(degrees, per_pixel), per_pixel / TRUTH);
    let state = subject.seen_by(&camera);
    let settings = Truth::Shadowed.settings((size.0 * block, size.1 * block), samples, seed);
    let settings = RenderSettings { shadows: false, ..settings };
    let truth = studio.shoot_truth(&mut subject.renderer, &state, &settings)?.of_blocks(block).map_err(fault)?;
    let mut one = |relief_color| {
        let shading = Technique::Leadr.with(ShadingOptions { relief_color, ..Default::default() });
        let settings = RenderSettings { size, samples: 1, shading, shadows: false, ..Default::default() };
        studio.shoot(&mut subject.renderer, &state, &settings)
    };
    Ok(Shown { truth, followed: one(true)?, apart: one(false)? })
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let (mut html, mut entries, mut findings) = (Html::new(), Vec::new(), Vec::new());
    let reliefs = studio.pick(1, RELIEFS);
    let views: Vec<(u32, f32)> = DISTANCES.iter().flat_map(|&(d, _)| DEGREES.map(|degrees| (d, degrees))).collect();
    studio.steps(PAINTS.len() * views.len() * reliefs as usize);
    for (paint, name) in PAINTS {
        let mut pictures: Vec<Vec<Shown>> = views.iter().map(|_| Vec::new()).collect();
        for relief in 1..=reliefs {
            let camera = seen(45.0, DISTANCES[0].0).0;
            let tile = Tile::new(Spectrum::Gaussian, TEXELS, 4.0, u64::from(relief));
            let stage = Stage::still(vec![painted(&tile, paint)], Views { near: camera, mid: camera, far: camera });
            let mut subject = Subject::under_the_sky(studio, stage, 0.0)?;
            for (&(per_pixel, degrees), pictures) in views.iter().zip(&mut pictures) {
                pictures.push(shown(studio, &mut subject, degrees, per_pixel, u64::from(relief))?);
                studio.step();
            }
        }
        let mut pictures = views.iter().zip(&pictures);
        for (per_pixel, distance) in DISTANCES {
            let mut table = Table::new(
                format!(
                    "Painted: {name}, {distance}; rRMSE of the whole picture, reliefs: {reliefs}, against {} samples of the reference for each {TRUTH} texels",
                    studio.pick(32, 128)
                ),
                [
                    "seen from",
                    "truth",
                    "following the relief",
                    "apart",
                    "rRMSE",
                    "rRMSE apart",
                    "part",
                    "part of single reliefs",
                    "mean colour",
                    "mean colour apart",
                    "part",
                    "noise",
                ],
            );
            let seen_there = entries.len();
            for (&(_, degrees), all) in pictures.by_ref().take(DEGREES.len()) {
                let file = |what: &str| format!("colour-{}-{distance}-{degrees}-{what}", name.replace(' ', "-"));
                let mean = Shown::mean(all).map_err(fault)?;
                let mut figures = Vec::new();
                for (shot, word) in [(&mean.truth, "truth"), (&mean.followed, "following"), (&mean.apart, "apart")] {
                    let figure = studio.picture(&file(word), &shot.image, 1.0, word, vec![])?;
                    figures.push(Cell::Figure(figure.enlarged(per_pixel / 2)));
                }
                let object = mean.truth.object().map_err(fault)?;
                let color = mean_color(&mean.truth.image, &object);
                let [mean_followed, mean_apart] =
                    [&mean.followed, &mean.apart].map(|shot| apart_by(color, mean_color(&shot.image, &object)));
                let [followed, apart] = mean.errors().map_err(fault)?;
                let singles: Vec<_> = all.iter().map(Shown::errors).collect::<Result<_, _>>().map_err(fault)?;
                let [followed_one, apart_one] =
                    [0, 1].map(|i| singles.iter().map(|errors| errors[i]).sum::<f64>() / singles.len() as f64);
                let part = mean_followed / mean_apart;
                let numbers = [
                    followed,
                    apart,
                    followed / apart,
                    followed_one / apart_one,
                    mean_followed,
                    mean_apart,
                    part,
                    mean.truth.noise,
                ];
                table.row(
                    std::iter::once(Cell::from(format!("{degrees}°"))).chain(figures).chain(numbers.map(Cell::from)),
                );
                entries.push(Entry {
                    paint,
                    texels_per_pixel: per_pixel,
                    degrees,
                    followed,
                    apart,
                    mean_followed,
                    mean_apart,
                    noise: mean.truth.noise,
                    followed_one,
                    apart_one,
                });
            }
            html.table(&table);
            findings.push(finding(&format!("{name}, {distance}"), &entries[seen_there..]));
        }
    }
    Section::new(INTRO, findings, &html, &entries)
}

/// Of all views of a paint at a distance.
fn finding(name: &str, entries: &[Entry]) -> String {
    let rms = |error: fn(&Entry) -> f64| {
        (entries.iter().map(|entry| error(entry).powi(2)).sum::<f64>() / entries.len() as f64).sqrt()
    };
    let verdict = |followed: f64, apart: f64| {
        let kept = if followed <= GOAL * apart { "kept" } else { "missed" };
        format!("{} of it; the goal of {} is {kept}", number(followed / apart), number(GOAL))
    };
    let (followed, apart) = (rms(|entry| entry.followed), rms(|entry| entry.apart));
    let (mean, mean_apart) = (rms(|entry| entry.mean_followed), rms(|entry| entry.mean_apart));
    let noise = rms(|entry| entry.noise);
    let without_noise = |error: f64| (error * error - noise * noise).max(0.0).sqrt();
    let verdicts = if entries.iter().all(|entry| entry.paint == Paint::Nothing) {
        ["which is the model's error of brightness".to_owned(), "as they must where nothing is painted".to_owned()]
    } else {
        let pixels = verdict(without_noise(followed), without_noise(apart));
        [format!("without the truth's noise {pixels}"), verdict(mean, mean_apart)]
    };
    format!(
        "Painted: {name}. From 15° to 80° the mean colour of one sample errs by {} where colours follow the relief and by {} where they are \
         filtered apart, {}. Its pixels err by {} and by {}, {} (noise of the truth {}); with the grain of a single relief by {} and by {}.",
        number(mean),
        number(mean_apart),
        verdicts[1],
        number(followed),
        number(apart),
        verdicts[0],
        number(noise),
        number(rms(|entry| entry.followed_one)),
        number(rms(|entry| entry.apart_one))
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paint_covers_what_it_says() {
        let tile = Tile::new(Spectrum::Gaussian, TEXELS, 4.0, 1);
        for (paint, share) in [(Paint::Tops, 0.3), (Paint::Cracks, 0.3), (Paint::OneSide, 0.5), (Paint::Nothing, 0.0)] {
            let object = painted(&tile, paint);
            let colors = &object.material.as_ref().unwrap().colors;
            let red = colors.iter().filter(|texel| **texel == RED).count() as f32 / colors.len() as f32;
            assert!((red - share).abs() < 0.02, "{paint:?}: {red}");
        }
    }

    #[test]
    fn goals_are_kept_and_missed() {
        let entry = |followed, noise| Entry {
            paint: Paint::Tops,
            texels_per_pixel: 16,
            degrees: 15.0,
            followed,
            apart: 0.5,
            mean_followed: followed / 10.0,
            mean_apart: 0.05,
            noise,
            followed_one: followed,
            apart_one: 0.5,
        };
        assert_eq!(finding("tops", &[entry(0.05, 0.0)]).matches("is kept").count(), 2);
        assert_eq!(finding("tops", &[entry(0.2, 0.0)]).matches("is missed").count(), 2);
        // What is over the goal is the truth's noise.
        assert_eq!(finding("tops", &[entry(0.11, 0.06)]).matches("is kept").count(), 1);
        assert_eq!(finding("tops", &[entry(0.11, 0.0)]).matches("is missed").count(), 2);
    }
}
