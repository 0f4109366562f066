//! LEADR Figure 1: the T-rex from near to far.

use super::page::Page;
use crate::report::case::Case;
use crate::report::look::Look;
use crate::report::studio::{Studio, fault};
use crate::report::subject::{Subject, framed_from};
use crate::report::truth::Truth;
use crate::report::verdict::{Shot, judge};
use leadr_render::sampling::seed_apart;
use leadr_render::settings::{ShadingOptions, Technique};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Table, number};
use leadr_tools::metrics::compare::rrmse_over;

/// How many times as far the far view is as the middle one.
const FAR: u32 = 8;
/// Edge samples of each pixel.
const EDGES: u32 = 64;

pub fn draw(studio: &mut Studio, page: &mut Page) -> Result<(), LabError> {
    page.begin(
        "LEADR Figure 1",
        "The T-rex under the sky and its sun, near, in the middle and far: LEADR and mipmapped normals at one sample per pixel, and \
        displacement-map truth. Outlines have 64 edge samples, because a far T-rex is little else. The far pictures are enlarged.",
    );
    let (width, height) = studio.pick((160, 128), (320, 256));
    let samples = studio.pick(8, 64);
    let mut subject = Subject::trex(studio, studio.pick(8, 32))?;
    let looks = [Look::best(), Look::of(Technique::NormalMip)].map(|look| Look {
        shading: look.shading.adjusted(|options| ShadingOptions { edge_samples: EDGES, ..options }),
        ..look
    });
    let mut table = Table::new(
        format!("Truth of {samples} samples per pixel; errors over the pixels that the T-rex touches"),
        ["", "LEADR", "mipmapped normals", "truth", "rRMSE, LEADR", "rRMSE, mipmapped normals", "noise of the truth"],
    );
    let views = subject.stage.views;
    for (place, camera, factor) in
        [("near", views.near, 1), ("middle", views.mid, 1), ("far", framed_from(&views.mid, FAR as f32), FAR)]
    {
        let size = (width / factor, height / factor);
        let state = subject.seen_by(&camera);
        let half = |seed: u64| Truth::Displacement.settings(size, samples / 2, seed);
        let [a, b] =
            [1, seed_apart(samples / 2, 1)].map(|seed| studio.shoot(&mut subject.renderer, &state, &half(seed)));
        let (a, b) = (a?, b?);
        let truth = Shot::mean_of(&a, &b).map_err(fault)?;
        // From afar nothing is inside: noise, too, is that of all pixels that the T-rex touches.
        let touched = truth.object().map_err(fault)?;
        let noise = 0.5 * rrmse_over(&a.image, &b.image, &touched).map_err(fault)?;
        let name = |what: &str| format!("figures-trex-{place}-{what}");
        let shown = studio.picture(&name("truth"), &truth.image, 1.0, "truth", Vec::new())?.enlarged(factor);
        let (mut pictures, mut errors) = (Vec::new(), Vec::new());
        for look in &looks {
            let shot = studio.shoot(&mut subject.renderer, &state, &look.settings(size, 1))?;
            let verdict = judge(&truth, &shot, 1.0).map_err(fault)?;
            let caption = vec![format!("rRMSE {}", number(verdict.object.rrmse))];
            let picture = studio.picture(&name(&look.file()), &shot.image, 1.0, &look.name, caption)?;
            let picture = picture.enlarged(factor);
            page.check(format!("rRMSE, {place}, {}", look.name), verdict.object.rrmse);
            errors.push(verdict.object.rrmse);
            if look.shading.technique() == Technique::Leadr {
                let mut case = Case::new("figures", format!("T-rex, {place}"), &look.name, "displacement", &verdict);
                case.figures = vec![shown.clone(), picture.clone()];
                studio.cases.push(case);
            }
            pictures.push(picture);
        }
        page.find(&format!(
            "{place}, LEADR errs by {} and mipmapped normals by {} (noise of the truth {}).",
            number(errors[0]),
            number(errors[1]),
            number(noise)
        ));
        let cells = pictures.into_iter().chain([shown]).map(Cell::Figure);
        let numbers = [errors[0], errors[1], noise].map(Cell::from);
        table.row(std::iter::once(Cell::from(place)).chain(cells).chain(numbers));
    }
    page.html.table(&table);
    Ok(())
}
