//! Surfaces that deform under maps that do not: LEADR's Figure 5.

use super::Section;
use crate::app::error::AppError;
use crate::app::report::case::Case;
use crate::app::report::html::{Cell, Html, Table, number};
use crate::app::report::look::Look;
use crate::app::report::studio::{Studio, fault};
use crate::app::report::subject::Subject;
use crate::app::report::truth::Truth;
use crate::app::report::verdict::judge;
use crate::scenes::deform::{Deformation, PERIOD, stage};
use crate::scenes::stage::Lights;
use crate::scenes::studio::studio as panorama;

const INTRO: &str = "The LEADR paper's Figure 5: a quad, a sphere and a cylinder are stretched, sheared or flattened while their maps \
    stay as they were baked; the moments follow the deformation (eq. 12). One sample of LEADR per pixel against \
    displacement-map truth of the deformed surface.";

const DEFORMATIONS: [(Deformation, &str, &str); 3] = [
    (Deformation::Stretch, "stretch", "Stretching"),
    (Deformation::Shear, "shear", "Shearing"),
    (Deformation::HeightScale, "height", "Height scale"),
];

pub fn run(studio: &mut Studio) -> Result<Section, AppError> {
    let size = studio.pick((128, 48), (384, 144));
    let samples = studio.pick(16, 128);
    let moments: &[f64] = if studio.quick { &[1.0] } else { &[0.0, 0.33, 0.67, 1.0] };
    let scale = studio.pick(2, 1);
    let panorama = panorama();
    let (mut html, mut cases) = (Html::new(), Vec::new());
    for (deformation, key, title) in DEFORMATIONS {
        let mut subject = Subject::in_panorama(studio, stage(deformation), &panorama, Lights::default())?;
        let head = [
            "how far",
            "truth",
            "LEADR, one sample",
            "FLIP errors",
            "rRMSE",
            "rRMSE inside",
            "bias inside",
            "FLIP",
            "noise of the truth",
        ];
        let mut table = Table::new(format!("{title}; truth of {samples} samples per pixel"), head);
        for &moment in moments {
            // Half a period leads from the surface as it was made to the fully deformed one.
            subject.set_time(moment * 0.5 * PERIOD);
            let state = subject.seen_by(&subject.stage.views.mid);
            let truth =
                studio.shoot_truth(&mut subject.renderer, &state, &Truth::Displacement.settings(size, samples, 1))?;
            let look = Look::best();
            let shot = studio.shoot(&mut subject.renderer, &state, &look.settings(size, 1))?;
            let verdict = judge(&truth, &shot, 1.0).map_err(fault)?;
            let name = |kind: &str| format!("shapes-{key}-{}-{kind}", (moment * 100.0) as u32);
            let figures = [
                studio.picture(&name("truth"), &truth.image, 1.0, "displacement-map truth", Vec::new())?,
                studio.picture(&name("leadr"), &shot.image, 1.0, &look.name, Vec::new())?,
                studio.error_picture(&name("errors"), &verdict, "FLIP errors", Vec::new())?,
            ]
            .map(|figure| figure.enlarged(scale));
            let mut cells = vec![Cell::from(format!("{:.0} %", moment * 100.0))];
            cells.extend(figures.iter().cloned().map(Cell::Figure));
            let (object, interior) = (verdict.object, verdict.interior);
            cells.extend([object.rrmse, interior.rrmse, interior.bias, object.flip, verdict.noise].map(Cell::from));
            table.row(cells);
            let subject = format!("{title} by {:.0} %", moment * 100.0);
            let mut case = Case::new("shapes", subject, &look.name, "displacement", &verdict);
            case.figures = figures.to_vec();
            cases.push((title, moment, case));
        }
        html.heading(title);
        html.table(&table);
    }
    let findings = DEFORMATIONS.iter().filter_map(|&(_, _, title)| finding(title, &cases)).collect();
    let data: Vec<&Case> = cases.iter().map(|c| &c.2).collect();
    let section = Section::new(INTRO, findings, &html, data)?;
    studio.cases.extend(cases.into_iter().map(|c| c.2));
    Ok(section)
}

/// Whether deforming makes it worse.
fn finding(title: &str, cases: &[(&str, f64, Case)]) -> Option<String> {
    let error = |c: &(&str, f64, Case)| c.2.interior.rrmse;
    let of: Vec<_> = cases.iter().filter(|c| c.0 == title).collect();
    if let [only] = of.as_slice() {
        let noise = number(only.2.noise);
        return Some(format!(
            "{title}: rRMSE inside is {} fully deformed; the truth's noise is {noise}.",
            number(error(only))
        ));
    }
    let (first, last) = (error(of.first()?), error(of.last()?));
    let verdict = match last / first {
        r if r > 1.25 => "deforming makes it worse",
        r if r < 0.8 => "deforming makes it better",
        _ => "deforming changes little",
    };
    Some(format!("{title}: rRMSE inside is {} before and {} fully deformed: {verdict}.", number(first), number(last)))
}
