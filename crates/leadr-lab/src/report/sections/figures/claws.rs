//! Draws the claws of the T-rex, which LEADR section 6 names as the surface that its moments alone cannot filter.

use glam::Vec3;

use crate::report::configuration::Configuration;
use crate::report::page::Page;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use crate::report::truth::Truth;
use crate::report::verdict::{Shot, judge};
use leadr_render::camera::Camera;
use leadr_render::settings::{PixelKernel, ShadingOptions, Technique};
use leadr_scenes::trex::stage::walked;
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Table, number};
use leadr_tools::metrics::flicker::{difference, magnitude};

/// The height in the rest pose below which props are claws of the toes, and the distance in front of which they are those of the middle
/// toes, in metres.
const CLAWS_BELOW: f32 = 0.16;
const MIDDLE_FROM: f32 = 0.8;
/// The position of the camera relative to the claw, in metres, and its field of view in degrees.
const CAMERA: Vec3 = Vec3::new(2.4, -5.0, 1.1);
const FIELD: f32 = 4.0;
/// The number of positions of the camera, a quarter of a pixel apart.
const POSITIONS: u32 = 5;

/// The heights of the pictures in pixels. A claw is about half as high.
const SIZES: [u32; 2] = [48, 12];

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "LEADR section 6, claws",
        "The claw of a middle toe of the T-rex under the sky and its sun, large and small: without the curvature under a pixel, with the kernel of \
        the normal (the default), with one kernel per light (half-vector), and displacement-map truth. One sample per pixel; small pictures \
        are enlarged. Flicker is the change between cameras a quarter of a pixel apart, beyond the change of the truth.",
    );
    let samples = studio.pick(16, 128);
    let mut subject = Subject::claws(studio, studio.pick(8, 32))?;
    let mut table = Table::new(
        format!("Truth of {samples} samples per pixel; errors over the pixels that the claws touch"),
        ["pixels", "kernel", "picture", "truth", "rRMSE", "bias", "largest flicker", "mean flicker"],
    );
    let target = subject.claw;
    for pixels in SIZES {
        let size = (2 * pixels, pixels);
        let camera = |shift: f32| {
            let position = target + CAMERA;
            let right = (target - position).cross(Vec3::Z).normalize();
            let moved = right * shift;
            Camera::looking_at(position + moved, target + moved, FIELD)
        };
        let pixel = 2.0 * (0.5 * FIELD).to_radians().tan() * CAMERA.length() / pixels as f32;
        let cameras: Vec<Camera> = (0..POSITIONS).map(|i| camera(0.25 * pixel * i as f32)).collect();
        let truths: Vec<Shot> = cameras
            .iter()
            .map(|camera| {
                let state = subject.of.seen_by(camera);
                studio.shoot_truth(&mut subject.of.renderer, &state, &Truth::Displacement.settings(size, samples, 1))
            })
            .collect::<Result<_, _>>()?;
        let mask = truths[0].object().map_err(fault)?;
        let name = |what: &str| format!("figures-claws-{pixels}-{what}");
        let scale = SIZES[0] / pixels * studio.pick(2, 4);
        let shown = studio.picture(&name("truth"), &truths[0].image, 1.0, "truth", Vec::new())?.enlarged(scale);
        let mut errors = Vec::new();
        for kernel in [PixelKernel::Off, PixelKernel::Normal, PixelKernel::HalfVector] {
            let config = Configuration::of(Technique::Leadr);
            let shading = config.shading.adjusted(|options| ShadingOptions { pixel_kernel: kernel, ..options });
            let settings = Configuration { shading, ..config }.settings(size, 1);
            let shots: Vec<Shot> = cameras
                .iter()
                .map(|camera| {
                    let state = subject.of.seen_by(camera);
                    studio.shoot(&mut subject.of.renderer, &state, &settings)
                })
                .collect::<Result<_, _>>()?;
            let verdict = judge(&truths[0], &shots[0], 1.0).map_err(fault)?;
            let (mut largest, mut mean) = (0.0f64, 0.0);
            for (pair, truth) in shots.windows(2).zip(truths.windows(2)) {
                let change = |a: &Shot, b: &Shot| difference(&a.image, &b.image).map_err(fault);
                let [of, expected] = [change(&pair[0], &pair[1])?, change(&truth[0], &truth[1])?];
                let excess = difference(&of, &expected).and_then(|change| magnitude(&change, &mask)).map_err(fault)?;
                largest = largest.max(excess.max);
                mean += excess.mean / f64::from(POSITIONS - 1);
            }
            let what = match kernel {
                PixelKernel::Off => "off",
                PixelKernel::Normal => "on",
                PixelKernel::HalfVector => "half-vector",
            };
            let picture = studio.picture(&name(what), &shots[0].image, 1.0, what, Vec::new())?.enlarged(scale);
            let numbers = [verdict.object.rrmse, verdict.object.bias, largest, mean];
            for (of, number) in ["rRMSE", "bias", "largest flicker", "mean flicker"].iter().zip(numbers) {
                page.check(format!("{of}, {pixels} pixels, {what}"), number);
            }
            let head = [Cell::from(format!("{pixels}")), Cell::from(what), Cell::Figure(picture)];
            let cells = head.into_iter().chain([Cell::Figure(shown.clone())]).chain(numbers.map(Cell::from));
            table.row(cells);
            errors.push((verdict.object.rrmse, largest));
        }
        page.find(&format!(
            "at {pixels} pixels, rRMSE is {} without a kernel, {} with the kernel of the normal and {} with one kernel per light; the largest \
            flicker is {}, {} and {}.",
            number(errors[0].0),
            number(errors[1].0),
            number(errors[2].0),
            number(errors[0].1),
            number(errors[1].1),
            number(errors[2].1)
        ));
    }
    page.html.table(&table);
    Ok(())
}

/// The claws of the T-rex.
pub struct Claws {
    /// The claws, teeth and eyes of the T-rex.
    pub of: Subject,
    /// The middle of the claw of the right foot's middle toe.
    pub claw: Vec3,
}

impl Subject {
    /// Uploads only the claws, teeth and eyes of the T-rex in mid-step, with atlas tiles of `tile` texels for the body that is left out.
    fn claws(studio: &Studio, tile: u32) -> Result<Claws, LabError> {
        let mut stage = Self::trex_stage(tile)?;
        // The body comes first, and the ground last. Body and props have the same pose.
        stage.objects = stage.objects.drain(1..2).collect();
        let mesh = stage.objects[0].mesh.clone();
        let of = Self::under_the_sky(studio, stage, Self::MID_STEP)?;
        let state = of.seen_by(&of.stage.views.mid);
        let posed = state.poses[0].apply(&mesh);
        let of_foot = |rest: &Vec3| rest.z < CLAWS_BELOW && rest.x > MIDDLE_FROM && rest.y < 0.0;
        let claws: Vec<Vec3> =
            mesh.positions.iter().zip(&posed.positions).filter(|(rest, _)| of_foot(rest)).map(|(_, p)| *p).collect();
        // Cameras are relative to the walking animal.
        let claw = claws.iter().sum::<Vec3>() / claws.len().max(1) as f32 - Vec3::X * walked(Self::MID_STEP);
        Ok(Claws { of, claw })
    }
}
