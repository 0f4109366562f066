//! Measures colours that follow the relief, in whole pictures with one sample per pixel.

use glam::Vec3;
use serde::Serialize;

use crate::ray_cast::{Spectrum, Tile};
use crate::report::section::Section;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use crate::report::truth::Truth;
use crate::report::verdict::{Shot, judge, without_relief_noise};
use leadr_maps::{HeightMap, MapFault, RgbImage};
use leadr_render::camera::Camera;
use leadr_render::scene::{MaterialMap, Object};
use leadr_render::settings::{RenderSettings, ShadingOptions, Technique};
use leadr_render::surfaces::displacement::HeightField;
use leadr_scenes::plane::{even, plane};
use leadr_scenes::stage::{Stage, Views};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, number};
use leadr_tools::metrics::Mask;

const INTRO: &str = "A matte plane of Gaussian bumps (slope deviation .6), painted red on grey: on tops, in cracks, on slopes facing one \
    way, and nowhere. Near pixels cover about three bumps, far pixels about fifty. One sample of LEADR under sky and sun is compared with \
    the supersampled reference, whose bumps shadow each other. LEADR runs with classes for colours that follow the relief, and with colours and light \
    filtered independently (--relief-color off). The goal is a fifth of the independent filter's error. The mean colour is the fraction \
    of red, green and blue in the whole picture's light, so brightness and the positions of a few bumps do not matter. Pixel errors \
    include both. Each pixel covers few random bumps, so pictures of several similar reliefs are averaged; the error of a single relief \
    is listed beside. The goal's pixel errors exclude the remaining randomness and the truth's noise. Without paint, the remaining error \
    is the brightness error of the masking and shadowing model; no colour can be more accurate.";

/// The error goal, as a fraction of the error of independent filtering.
const GOAL: f64 = 0.2;
const RED: [u8; 4] = [200, 25, 20, 128];
const GREY: [u8; 4] = [110, 120, 130, 128];
/// The number of texels along the tile, which is one repeat of the plane.
const TEXELS: u32 = 256;
/// The pixel widths in texels. Truth pixels have the near width, and the far truth averages blocks of near pixels.
const DISTANCES: [(u32, &str); 2] = [(NEAR, "near"), (FAR, "far")];
const NEAR: u32 = 16;
const FAR: u32 = 64;
/// The number of samples per pixel of the truth. A pixel covers 256 texels or more.
const SAMPLES: u32 = 64;
const QUICK_SAMPLES: u32 = 16;
const SIGMA: f32 = 0.6;
/// The number of reliefs that are averaged. Single reliefs vary randomly, so even a quick report uses several reliefs.
const RELIEFS: u32 = 8;
const QUICK_RELIEFS: u32 = 3;
const DEGREES: [f32; 6] = [15.0, 30.0, 45.0, 60.0, 70.0, 80.0];

/// The part of the surface that is painted red.
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
    /// The mean error of single reliefs with colours that follow the relief.
    followed_one: f64,
    apart_one: f64,
    /// The error of the filter with colours that follow the relief ([`without_relief_noise`]).
    followed_filter: f64,
    apart_filter: f64,
}

/// A view of one relief: the truth, one sample with colours that follow the relief, and one with colours filtered
/// separately.
struct Shown {
    truth: Shot,
    followed: Shot,
    apart: Shot,
}

impl Shown {
    /// Returns the mean of views of several reliefs with independent truths.
    fn mean(all: &[Self]) -> Result<Self, MapFault> {
        let each = |of: fn(&Self) -> &Shot| all.iter().map(|one| of(one).clone()).collect::<Vec<_>>();
        Ok(Self {
            truth: Shot::mean_of_truths(&each(|one| &one.truth))?,
            followed: Shot::mean(&each(|one| &one.followed))?,
            apart: Shot::mean(&each(|one| &one.apart))?,
        })
    }

    /// Returns the relative RMSE over pixels with colours that follow the relief, and with colours filtered separately.
    fn errors(&self) -> Result<[f64; 2], MapFault> {
        let of = |shot| Ok(judge(&self.truth, shot, 1.0)?.object.rrmse);
        Ok([of(&self.followed)?, of(&self.apart)?])
    }
}

/// Computes the fraction of each colour channel in the light from the object.
fn mean_color(image: &RgbImage, object: &Mask) -> [f64; 3] {
    let inside = image.texels.iter().zip(&object.inside).filter(|&(_, &inside)| inside);
    let sums = inside.fold([0.0; 3], |sums, (texel, _)| [0, 1, 2].map(|c| sums[c] + f64::from(texel[c])));
    let all = sums.iter().sum::<f64>().max(f64::MIN_POSITIVE);
    sums.map(|sum| sum / all)
}

/// Returns the difference between two colours, relative to the first.
fn apart_by(truth: [f64; 3], found: [f64; 3]) -> f64 {
    let length = |v: [f64; 3]| v.iter().map(|v| v * v).sum::<f64>().sqrt();
    length([0, 1, 2].map(|c| found[c] - truth[c])) / length(truth)
}

/// Returns the painted plane, whose colours separate classes of facets if `follows` is true.
fn painted(tile: &Tile, paint: Paint, follows: bool) -> Object {
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
    let field = HeightField::repeating(HeightMap { width: TEXELS, height: TEXELS, texels: heights.to_vec() });
    // Half a repeat of relief around the visible repeat casts shadows into it.
    let plane = Object::new("painted plane", plane(0.75, 12, 1.0, [1.0; 4], even))
        .with_heights(field, SIGMA / TEXELS as f32)
        .with_material(MaterialMap::new(TEXELS, TEXELS, colors))
        .with_specular_f0(0.0);
    Object { follows_relief: follows, ..plane }
}

/// Returns the camera and the size of its far picture. Rays are nearly parallel, and the view shows about one repeat of the
/// relief.
fn seen(degrees: f32) -> (Camera, (u32, u32)) {
    let (sine, cosine) = degrees.to_radians().sin_cos();
    let columns = TEXELS / FAR;
    let rows = ((columns as f32 * cosine).round() as u32).max(1);
    let (toward, distance) = (Vec3::new(0.8 * sine, -0.6 * sine, cosine), 200.0);
    let fov = 2.0 * (0.5 * rows as f32 / columns as f32 / distance).atan().to_degrees();
    // The corners of a rotated repeat would lie outside the plane.
    let fov = 0.9 * fov;
    (Camera { near: 1.0, ..Camera::looking_at(toward * distance, Vec3::ZERO, fov) }, (columns, rows))
}

/// Renders a relief at `degrees` at all distances, with colours that follow the relief and with independent colours.
fn shown(
    studio: &Studio,
    [following, apart]: &mut [Subject; 2],
    degrees: f32,
    seed: u64,
) -> Result<[Shown; DISTANCES.len()], LabError> {
    let (camera, (columns, rows)) = seen(degrees);
    let state = following.seen_by(&camera);
    let size = |per_pixel: u32| (columns * FAR / per_pixel, rows * FAR / per_pixel);
    let settings = Truth::Shadowed.settings(size(NEAR), studio.pick(QUICK_SAMPLES, SAMPLES), seed);
    let truth = studio.shoot_truth(&mut following.renderer, &state, &RenderSettings { shadows: false, ..settings })?;
    let mut at = |per_pixel: u32| -> Result<Shown, LabError> {
        let shading = Technique::Leadr.with(ShadingOptions::default());
        let settings =
            RenderSettings { size: size(per_pixel), samples: 1, shading, shadows: false, ..Default::default() };
        let one = |subject: &mut Subject| studio.shoot(&mut subject.renderer, &state, &settings);
        let truth = truth.of_blocks(per_pixel / NEAR).map_err(fault)?;
        Ok(Shown { truth, followed: one(following)?, apart: one(apart)? })
    };
    Ok([at(NEAR)?, at(FAR)?])
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let (mut html, mut entries, mut findings) = (Html::new(), Vec::new(), Vec::new());
    let reliefs = studio.pick(QUICK_RELIEFS, RELIEFS);
    studio.steps(PAINTS.len() * DEGREES.len() * reliefs as usize);
    for (paint, name) in PAINTS {
        let mut pictures: [[Vec<Shown>; DEGREES.len()]; DISTANCES.len()] = Default::default();
        for relief in 1..=reliefs {
            let camera = seen(45.0).0;
            let tile = Tile::new(Spectrum::Gaussian, TEXELS, 4.0, u64::from(relief));
            let subject = |follows| {
                let views = Views { near: camera, mid: camera, far: camera };
                Subject::under_the_sky(studio, Stage::still(vec![painted(&tile, paint, follows)], views), 0.0)
            };
            let mut subjects = [subject(true)?, subject(false)?];
            for (angle, degrees) in DEGREES.into_iter().enumerate() {
                for (distance, shown) in
                    shown(studio, &mut subjects, degrees, u64::from(relief))?.into_iter().enumerate()
                {
                    pictures[distance][angle].push(shown);
                }
                studio.step();
            }
        }
        for ((per_pixel, distance), pictures) in DISTANCES.into_iter().zip(&pictures) {
            let mut table = Table::new(
                format!(
                    "Painted: {name}, {distance}; rRMSE of the whole picture, {reliefs} reliefs, against {} reference samples per pixel of {NEAR} texels",
                    studio.pick(QUICK_SAMPLES, SAMPLES)
                ),
                [
                    "seen from",
                    "truth",
                    "relief colours",
                    "independent",
                    "rRMSE",
                    "rRMSE, independent",
                    "without grain",
                    "independent",
                    "ratio",
                    "ratio, single reliefs",
                    "mean colour",
                    "mean colour, independent",
                    "ratio",
                    "noise",
                ],
            );
            let seen_there = entries.len();
            for (degrees, all) in DEGREES.into_iter().zip(pictures) {
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
                let [followed_filter, apart_filter] = [(0, followed), (1, apart)].map(|(i, mean)| {
                    without_relief_noise(mean, &singles.iter().map(|errors| errors[i]).collect::<Vec<_>>())
                });
                let part = mean_followed / mean_apart;
                let numbers = [
                    followed,
                    apart,
                    followed_filter,
                    apart_filter,
                    followed_filter / apart_filter,
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
                    followed_filter,
                    apart_filter,
                });
            }
            html.table(&table);
            findings.push(finding(&format!("{name}, {distance}"), &entries[seen_there..]));
        }
    }
    Section::new(INTRO, findings, &html, &entries)
}

/// Returns the finding for all views of a paint at a distance.
fn finding(name: &str, entries: &[Entry]) -> String {
    let rms = |error: fn(&Entry) -> f64| {
        (entries.iter().map(|entry| error(entry).powi(2)).sum::<f64>() / entries.len() as f64).sqrt()
    };
    let verdict = |followed: f64, apart: f64| {
        let kept = if followed <= GOAL * apart { "kept" } else { "missed" };
        format!("a ratio of {}; the goal of {} is {kept}", number(followed / apart), number(GOAL))
    };
    let (followed, apart) = (rms(|entry| entry.followed), rms(|entry| entry.apart));
    let (mean, mean_apart) = (rms(|entry| entry.mean_followed), rms(|entry| entry.mean_apart));
    let (filter, filter_apart) = (rms(|entry| entry.followed_filter), rms(|entry| entry.apart_filter));
    let verdicts = if entries.iter().all(|entry| entry.paint == Paint::Nothing) {
        ["which is the model's brightness error".to_owned(), "as expected without paint".to_owned()]
    } else {
        [verdict(filter, filter_apart), verdict(mean, mean_apart)]
    };
    format!(
        "Painted: {name}. From 15° to 80° the mean colour error of one sample is {} with colours that follow the relief and {} with \
         independent filtering, {}. The pixel errors are {} and {}; without grain and noise {} and {}, {} (noise of the truth {}); for a \
         single relief {} and {}.",
        number(mean),
        number(mean_apart),
        verdicts[1],
        number(followed),
        number(apart),
        number(filter),
        number(filter_apart),
        verdicts[0],
        number(rms(|entry| entry.noise)),
        number(rms(|entry| entry.followed_one)),
        number(rms(|entry| entry.apart_one))
    )
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paint_coverage_matches_its_setting() {
        let tile = Tile::new(Spectrum::Gaussian, TEXELS, 4.0, 1);
        for (paint, share) in [(Paint::Tops, 0.3), (Paint::Cracks, 0.3), (Paint::OneSide, 0.5), (Paint::Nothing, 0.0)] {
            let object = painted(&tile, paint, true);
            let colors = &object.material.as_ref().unwrap().colors;
            let red = colors.iter().filter(|texel| **texel == RED).count() as f32 / colors.len() as f32;
            assert!((red - share).abs() < 0.02, "{paint:?}: {red}");
        }
    }

    #[test]
    fn goals_are_kept_and_missed() {
        let entry = |followed, followed_filter| Entry {
            paint: Paint::Tops,
            texels_per_pixel: NEAR,
            degrees: 15.0,
            followed,
            apart: 0.5,
            mean_followed: followed / 10.0,
            mean_apart: 0.05,
            noise: 0.0,
            followed_one: followed,
            apart_one: 0.5,
            followed_filter,
            apart_filter: 0.5,
        };
        assert_eq!(finding("tops", &[entry(0.05, 0.05)]).matches("is kept").count(), 2);
        assert_eq!(finding("tops", &[entry(0.2, 0.2)]).matches("is missed").count(), 2);
        // The goal per pixel applies to the filter.
        assert_eq!(finding("tops", &[entry(0.11, 0.09)]).matches("is kept").count(), 1);
    }
}
