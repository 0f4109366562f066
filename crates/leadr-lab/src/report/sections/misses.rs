//! Shows the pictures in which LEADR has the largest errors, and the causes of these errors.

use crate::report::case::Case;
use crate::report::section::Section;
use crate::report::studio::Studio;
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, number, percent};

const INTRO: &str = "The worst pictures of LEADR in the sections above, by relative RMSE inside the silhouette, and the likely causes. \
    Errors that disappear with a finer grid of samples come from the quadrature. Errors that disappear against normal-map truth come from \
    bumps that hide each other or stand out, which slope statistics cannot describe. Errors in the brightest pixels are highlights. \
    Errors on the silhouette are aliasing and bumps lost by the coarse geometry. A remaining even bias comes from the model's masking and \
    shadowing or from its Gaussian slopes.";

const SHOWN: usize = 12;

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let mut cases: Vec<Case> =
        studio.cases.iter().filter(|c| c.look.starts_with("leadr") && c.interior.rrmse.is_finite()).cloned().collect();
    if cases.is_empty() {
        let fault = "it judges the pictures of other sections; add some of them to --only";
        return Err(LabError(fault.to_owned()));
    }
    cases.sort_by(|a, b| b.interior.rrmse.total_cmp(&a.interior.rrmse));
    let mut html = Html::new();
    let mut table = Table::new(
        format!("The {} worst of {} pictures", SHOWN.min(cases.len()), cases.len()),
        ["what", "truth, picture, errors", "", "", "rRMSE inside", "bias inside", "FLIP", "why"],
    );
    let mut findings = Vec::new();
    for (rank, case) in cases.iter().take(SHOWN).enumerate() {
        let why = explain(case, &cases);
        let mut cells = vec![Cell::from(format!("{}: {}", case.subject, case.look))];
        cells.extend(case.figures.iter().cloned().map(Cell::Figure));
        cells.resize(4, Cell::from(""));
        cells.extend([case.interior.rrmse, case.interior.bias, case.object.flip].map(Cell::from));
        cells.push(Cell::from(why.join(" ")));
        table.row(cells);
        if rank < 5 {
            let error = number(case.interior.rrmse);
            findings.push(format!("{}, {}: rRMSE inside {error}. {}", case.subject, case.look, why.join(" ")));
        }
    }
    html.table(&table);
    let mut close = cases.iter().filter(|c| c.interior.rrmse < 0.05).count() as f64;
    close /= cases.len() as f64;
    findings.push(format!(
        "{} of {} pictures of LEADR are within 5 % inside the silhouette.",
        percent(close, false),
        cases.len()
    ));
    Section::new(INTRO, findings, &html, &cases)
}

/// Returns the likely causes of the error, derived from the numbers. The strongest cause comes first.
fn explain(case: &Case, all: &[Case]) -> Vec<String> {
    let mut why = Vec::new();
    let same =
        |look: &str| all.iter().find(|c| c.subject == case.subject && c.section == case.section && c.look == look);
    let largest = ["leadr 128×128", "leadr 32×32"].into_iter().find_map(same);
    if let Some(converged) = largest.filter(|c| c.look != case.look) {
        let left = converged.interior.rrmse / case.interior.rrmse;
        let share = match left {
            l if l < 0.5 => "mostly",
            l if l < 0.9 => "partly",
            _ => "not",
        };
        let samples = converged.look.replace("leadr ", "");
        why.push(format!(
            "{} of the error remains with {samples} samples: {share} the quadrature.",
            percent(left, false)
        ));
    }
    if let Some(normal_map) = case.normal_map {
        let left = normal_map.rrmse / case.interior.rrmse;
        if left < 0.6 {
            why.push(format!(
                "{} of the error remains against normal-map truth: the rest comes from bumps that hide each other or stand out.",
                percent(left, false)
            ));
        }
    }
    if case.noise > 0.5 * case.interior.rrmse {
        why.push(format!("The truth itself is uncertain by {}.", percent(case.noise, false)));
    }
    // A constant error has an rRMSE equal to its bias.
    let even = (case.interior.bias / case.interior.rrmse).abs();
    if even > 0.7 {
        let how = if case.interior.bias > 0.0 { "too bright" } else { "too dark" };
        why.push(format!(
            "The picture is {how} nearly everywhere: the model's masking and shadowing, or its slope distribution."
        ));
    }
    if case.anatomy.highlights > 0.5 {
        let share = percent(case.anatomy.highlights, false);
        why.push(format!("{share} of the squared error lies in the brightest twentieth: highlights or sparkles."));
    }
    if case.anatomy.outline > 0.5 {
        why.push(format!(
            "In addition, {} of the whole object's squared error lies on the silhouette.",
            percent(case.anatomy.outline, false)
        ));
    }
    if why.is_empty() {
        why.push(
            "The error is spread over the surface and has no common sign: detail is filtered or displaced differently."
                .to_owned(),
        );
    }
    why
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::verdict::{Anatomy, Errors};

    fn case(look: &str, rrmse: f64, bias: f64) -> Case {
        let errors = Errors { flip: 0.1, rrmse, bias };
        Case {
            section: "spheres".to_owned(),
            subject: "σ 1".to_owned(),
            look: look.to_owned(),
            truth: "displacement".to_owned(),
            object: errors,
            interior: errors,
            anatomy: Anatomy { outline: 0.1, highlights: 0.1 },
            normal_map: None,
            noise: 0.0,
            figures: Vec::new(),
        }
    }

    #[test]
    fn error_causes_follow_from_measures() {
        let grid = case("leadr 5×5", 0.2, 0.0);
        let all = [grid.clone(), case("leadr 128×128", 0.05, 0.0)];
        assert!(explain(&grid, &all)[0].contains("mostly the quadrature"));
        let all = [grid.clone(), case("leadr 128×128", 0.199, 0.0)];
        assert!(explain(&grid, &all)[0].contains("not the quadrature"));
        assert!(explain(&case("leadr", 0.2, -0.19), &[])[0].contains("too dark"));
        let sparkling = Case { anatomy: Anatomy { outline: 0.6, highlights: 0.9 }, ..case("leadr", 0.2, 0.0) };
        let why = explain(&sparkling, &[]);
        assert!(why[0].contains("highlights") && why[1].contains("silhouette"), "{why:?}");
        let shape = Case { normal_map: Some(Errors { flip: 0.0, rrmse: 0.01, bias: 0.0 }), ..case("leadr", 0.2, 0.0) };
        assert!(explain(&shape, &[])[0].contains("hide each other"));
        assert!(explain(&case("leadr", 0.2, 0.01), &[])[0].contains("spread over the surface"));
        assert!(explain(&Case { noise: 0.15, ..case("leadr", 0.2, 0.01) }, &[])[0].contains("uncertain"));
    }
}
