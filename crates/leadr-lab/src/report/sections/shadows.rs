//! Compares truths with and without shadows between bumps, and the closest of LEADR's shadowing models.

use crate::report::case::Case;
use crate::report::configuration::Configuration;
use crate::report::section::Section;
use crate::report::studio::{Studio, fault};
use crate::report::subject::{Subject, framed_from};
use crate::report::truth::Truth;
use crate::report::verdict::{Shot, judge};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::settings::Terms;
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, number};

const INTRO: &str = "In the other sections only the sun's coarse shadow map casts shadows, in the truth and in LEADR: light of the sky \
    reaches every facet through the bumps in front of it. Here the bumps of the truth cast shadows, from the sun and from the sky \
    (sampled lights with depth maps as fine as the bumps; leadr capture --relief-shadows). LEADR's shadowing models are compared with it \
    at one sample per pixel. The model called masking has no shadows; smith has shadows that depend on heights alone; in correlated, \
    light from behind the viewer also casts no visible shadows. The first row is the truth of the other sections, judged like a \
    technique.";

const HEAD: [&str; 8] = ["", "picture", "FLIP errors", "rRMSE", "rRMSE inside", "bias inside", "FLIP", "FLIP inside"];

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let near = studio.pick(64, 192);
    let samples = studio.pick(16, 64);
    // Tiles have half the resolution of other sections, because every sample draws the bumps once per light.
    let mut subject = Subject::rock(studio, 16)?;
    let (mut html, mut cases, mut findings) = (Html::new(), Vec::new(), Vec::new());
    for factor in [1u32, 4] {
        let size = (near / factor, near / factor);
        let camera = framed_from(&subject.stage.views.mid, factor as f32);
        let state = subject.seen_by(&camera);
        let distance = number(f64::from(camera.position.distance(camera.target)));
        let heading = format!("rough sphere at {distance} m, {} pixels across", size.0);
        let truth = studio.shoot_truth(&mut subject.renderer, &state, &Truth::Shadowed.settings(size, samples, 1))?;
        let open =
            studio.shoot_truth(&mut subject.renderer, &state, &Truth::Displacement.settings(size, samples, 3))?;
        let mut rows: Vec<(String, Shot)> = vec![("truth without shadows of the bumps".to_owned(), open)];
        for shadowing in Shadowing::MAIN {
            let config = Configuration::program_default().with(Terms::ALL, shadowing);
            let shot = studio.shoot(&mut subject.renderer, &state, &config.settings(size, 1))?;
            rows.push((format!("leadr, {}", shadowing.name()), shot));
        }
        let mut table = Table::new(
            format!("{heading}; truth of {samples} samples per pixel, its noise {} inside", number(truth.noise)),
            HEAD,
        );
        let name = format!("shadows-{factor}-truth");
        let caption = vec![format!("{samples} samples")];
        let shown = studio.picture(&name, &truth.image, 1.0, Truth::Shadowed.title(), caption)?.enlarged(factor);
        table.row([Cell::from("truth"), Cell::Figure(shown.clone())]);
        let mut errors = Vec::new();
        for (look, shot) in rows {
            let verdict = judge(&truth, &shot, 1.0).map_err(fault)?;
            let file = |kind: &str| {
                let word = look.rsplit(' ').next().unwrap_or_default();
                format!("shadows-{factor}-{word}-{kind}")
            };
            let figures = [
                studio.picture(&file("picture"), &shot.image, 1.0, &look, Vec::new())?.enlarged(factor),
                studio.error_picture(&file("errors"), &verdict, "FLIP errors", Vec::new())?.enlarged(factor),
            ];
            let (object, inside) = (verdict.object, verdict.interior);
            let numbers = [object.rrmse, inside.rrmse, inside.bias, object.flip, inside.flip].map(Cell::from);
            let pictures = figures.iter().cloned().map(Cell::Figure);
            table.row(std::iter::once(Cell::from(look.as_str())).chain(pictures).chain(numbers));
            errors.push(format!("{look} {} (bias {})", number(inside.rrmse), number(inside.bias)));
            let mut case = Case::new("shadows", heading.as_str(), look, Truth::Shadowed.name(), &verdict);
            case.figures = std::iter::once(shown.clone()).chain(figures).collect();
            cases.push(case);
        }
        findings.push(format!(
            "{heading}, rRMSE inside against the truth with all its shadows (noise {}): {}.",
            number(truth.noise),
            errors.join(", ")
        ));
        html.heading(&heading);
        html.table(&table);
    }
    let section = Section::new(INTRO, findings, &html, &cases)?;
    // Masking and Smith are shown only for comparison. The section of the worst pictures takes recommended settings only.
    studio.cases.extend(cases.into_iter().filter(|case| case.look.ends_with(Shadowing::Correlated.name())));
    Ok(section)
}
