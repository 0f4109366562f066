//! Renders deforming surfaces with fixed maps, and shapes that displacement creates (LEADR's Figures 5 and 9).

use crate::report::case::Case;
use crate::report::configuration::Configuration;
use crate::report::section::Section;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use crate::report::truth::Truth;
use crate::report::verdict::judge;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::settings::Terms;
use leadr_scenes::deform::{self, Deformation, PERIOD};
use leadr_scenes::stage::Lights;
use leadr_scenes::studio::studio as panorama;
use leadr_scenes::{pillow, snake};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, number};

const INTRO: &str = "The LEADR paper's Figure 5: a quad, a sphere and a cylinder are stretched, sheared or flattened with their original \
    maps; the moments follow the deformation (eq. 12). Then its Figure 9: a pillow in an environment, and a snake in an environment with \
    four point lights. LEADR at one sample per pixel is compared with displacement-map truth. There are no shadows, because there is no \
    sun.";

const DEFORMATIONS: [(Deformation, &str, &str); 3] = [
    (Deformation::Stretch, "stretch", "Stretching"),
    (Deformation::Shear, "shear", "Shearing"),
    (Deformation::HeightScale, "height", "Height scale"),
];

const HEAD: [&str; 9] = [
    "",
    "truth",
    "LEADR, one sample",
    "FLIP errors",
    "rRMSE",
    "rRMSE inside",
    "bias inside",
    "FLIP",
    "noise of the truth",
];

struct Measured {
    group: &'static str,
    case: Case,
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let size = studio.pick((128, 48), (384, 144));
    let samples = studio.pick(8, 128);
    let moments: &[f64] = if studio.quick { &[1.0] } else { &[0.0, 0.33, 0.67, 1.0] };
    let panorama = panorama();
    let (mut html, mut measured) = (Html::new(), Vec::new());
    for (deformation, key, title) in DEFORMATIONS {
        let stage = deform::stage(deformation);
        let mut subject = Subject::in_panorama(studio, stage, &panorama, Lights::default())?;
        let mut table = Table::new(format!("{title}; truth of {samples} samples per pixel"), HEAD);
        for &moment in moments {
            // The surface is fully deformed after half a period.
            subject.set_time(moment * 0.5 * PERIOD);
            let far = format!("{:.0} %", moment * 100.0);
            let name = format!("{key}-{:.0}", moment * 100.0);
            let (cells, case) = photograph(studio, &mut subject, size, samples, &name, &format!("{title} by {far}"))?;
            table.row(std::iter::once(Cell::from(far)).chain(cells));
            measured.push(Measured { group: title, case });
        }
        html.heading(title);
        html.table(&table);
    }
    let mut table = Table::new(format!("Figure 9; truth of {samples} samples per pixel"), HEAD);
    let tile = studio.pick(16, 32);
    let size = studio.pick((80, 60), (320, 240));
    for (key, title, stage) in
        [("pillow", "The pillow", pillow::stage(tile)), ("snake", "The snake", snake::stage(tile))]
    {
        let mut subject = Subject::in_panorama(studio, stage, &panorama, Lights::default())?;
        let (cells, case) = photograph(studio, &mut subject, size, samples, key, title)?;
        table.row(std::iter::once(Cell::from(title)).chain(cells));
        measured.push(Measured { group: title, case });
    }
    html.heading("A pillow and a snake");
    html.table(&table);
    let groups = DEFORMATIONS.iter().map(|d| d.2).chain(["The pillow", "The snake"]);
    let findings = groups.filter_map(|group| finding(group, &measured)).collect();
    let cases: Vec<Case> = measured.into_iter().map(|m| m.case).collect();
    let section = Section::new(INTRO, findings, &html, &cases)?;
    studio.cases.extend(cases);
    Ok(section)
}

/// Compares a picture with the truth. Returns the case, and the cells of a table row after the first.
fn photograph(
    studio: &mut Studio,
    subject: &mut Subject,
    size: (u32, u32),
    samples: u32,
    name: &str,
    what: &str,
) -> Result<(Vec<Cell>, Case), LabError> {
    let state = subject.seen_by(&subject.stage.views.mid);
    let truth = studio.shoot_truth(&mut subject.renderer, &state, &Truth::Displacement.settings(size, samples, 1))?;
    let config = Configuration::best().with(Terms::ALL, Shadowing::None);
    let shot = studio.shoot(&mut subject.renderer, &state, &config.settings(size, 1))?;
    let verdict = judge(&truth, &shot, 1.0).map_err(fault)?;
    let file = |kind: &str| format!("shapes-{name}-{kind}");
    let scale = studio.pick(2, 1);
    let figures = [
        studio.picture(&file("truth"), &truth.image, 1.0, "displacement-map truth", Vec::new())?,
        studio.picture(&file("leadr"), &shot.image, 1.0, &config.name, Vec::new())?,
        studio.error_picture(&file("errors"), &verdict, "FLIP errors", Vec::new())?,
    ]
    .map(|figure| figure.enlarged(scale));
    let mut cells: Vec<Cell> = figures.iter().cloned().map(Cell::Figure).collect();
    let (object, interior) = (verdict.object, verdict.interior);
    cells.extend([object.rrmse, interior.rrmse, interior.bias, object.flip, verdict.noise].map(Cell::from));
    let mut case = Case::new("shapes", what, &config.name, "displacement", &verdict);
    case.figures = figures.to_vec();
    Ok((cells, case))
}

/// Returns the error of a group, and whether the deformation increases it.
fn finding(group: &str, measured: &[Measured]) -> Option<String> {
    let of: Vec<&Case> = measured.iter().filter(|m| m.group == group).map(|m| &m.case).collect();
    let (first, last) = (of.first()?, of.last()?);
    let (error, noise) = (number(last.interior.rrmse), number(last.noise));
    if of.len() == 1 {
        let bias = number(last.interior.bias);
        return Some(format!("{}: rRMSE inside is {error}, bias {bias}; the truth's noise is {noise}.", last.subject));
    }
    let verdict = match last.interior.rrmse / first.interior.rrmse {
        r if r > 1.25 => "the deformation increases it",
        r if r < 0.8 => "the deformation reduces it",
        _ => "the deformation hardly changes it",
    };
    let before = number(first.interior.rrmse);
    Some(format!("{group}: rRMSE inside is {before} before and {error} fully deformed (noise {noise}): {verdict}."))
}
