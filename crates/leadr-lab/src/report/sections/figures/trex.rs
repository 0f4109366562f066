//! Draws LEADR Figure 1, which shows the T-rex at three distances.

use crate::report::case::Case;
use crate::report::configuration::Configuration;
use crate::report::page::Page;
use crate::report::studio::{Studio, fault};
use crate::report::subject::{Subject, framed_from};
use crate::report::truth::Truth;
use crate::report::verdict::{Shot, judge};
use leadr_render::sampling::independent_seed;
use leadr_render::settings::{ShadingOptions, Technique};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Table, number};
use leadr_tools::metrics::compare::rrmse_over;

/// The distance of the far view relative to the middle view.
const FAR: u32 = 8;
/// The number of edge samples per pixel.
const EDGES: u32 = 64;

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "LEADR Figure 1",
        "The T-rex under the sky and its sun, near, in the middle and far: LEADR and mipmapped normals at one sample per pixel, and \
        displacement-map truth. Outlines have 64 edge samples, because a far T-rex is mostly outline. The far pictures are enlarged.",
    );
    let (width, height) = studio.pick((160, 128), (320, 256));
    let samples = studio.pick(8, 64);
    let mut subject = Subject::trex(studio, studio.pick(8, 32))?;
    let configs = [Configuration::best(), Configuration::of(Technique::NormalMip)].map(|config| Configuration {
        shading: config.shading.adjusted(|options| ShadingOptions { edge_samples: EDGES, ..options }),
        ..config
    });
    let mut table = Table::new(
        format!("Truth of {samples} samples per pixel; errors over the pixels that the T-rex touches"),
        ["", "LEADR", "mipmapped normals", "truth", "rRMSE, LEADR", "rRMSE, mipmapped normals", "noise of the truth"],
    );
    let views = subject.stage.views;
    for (distance, camera, factor) in
        [("near", views.near, 1), ("middle", views.mid, 1), ("far", framed_from(&views.mid, FAR as f32), FAR)]
    {
        let size = (width / factor, height / factor);
        let state = subject.seen_by(&camera);
        let half = |seed: u64| Truth::Displacement.settings(size, samples / 2, seed);
        let [a, b] =
            [1, independent_seed(samples / 2, 1)].map(|seed| studio.shoot(&mut subject.renderer, &state, &half(seed)));
        let (a, b) = (a?, b?);
        let truth = Shot::mean_of(&a, &b).map_err(fault)?;
        // At a distance, no pixel is interior. The noise is therefore also measured over all pixels that the T-rex touches.
        let touched = truth.object().map_err(fault)?;
        let noise = 0.5 * rrmse_over(&a.image, &b.image, &touched).map_err(fault)?;
        let name = |what: &str| format!("figures-trex-{distance}-{what}");
        let shown = studio.picture(&name("truth"), &truth.image, 1.0, "truth", Vec::new())?.enlarged(factor);
        let (mut pictures, mut errors) = (Vec::new(), Vec::new());
        for config in &configs {
            let shot = studio.shoot(&mut subject.renderer, &state, &config.settings(size, 1))?;
            let verdict = judge(&truth, &shot, 1.0).map_err(fault)?;
            let caption = vec![format!("rRMSE {}", number(verdict.object.rrmse))];
            let picture = studio.picture(&name(&config.file()), &shot.image, 1.0, &config.name, caption)?;
            let picture = picture.enlarged(factor);
            page.check(format!("rRMSE, {distance}, {}", config.name), verdict.object.rrmse);
            errors.push(verdict.object.rrmse);
            if config.shading.technique() == Technique::Leadr {
                let mut case =
                    Case::new("figures", format!("T-rex, {distance}"), &config.name, "displacement", &verdict);
                case.figures = vec![shown.clone(), picture.clone()];
                studio.cases.push(case);
            }
            pictures.push(picture);
        }
        page.find(&format!(
            "{distance}, the error of LEADR is {}, of mipmapped normals {} (noise of the truth {}).",
            number(errors[0]),
            number(errors[1]),
            number(noise)
        ));
        let cells = pictures.into_iter().chain([shown]).map(Cell::Figure);
        let numbers = [errors[0], errors[1], noise].map(Cell::from);
        table.row(std::iter::once(Cell::from(distance)).chain(cells).chain(numbers));
    }
    page.html.table(&table);
    Ok(())
}
