//! Renders deforming surfaces with fixed maps, and shapes that displacement creates (LEADR's Figures 5 and 9).

use crate::report::case::Case;
use crate::report::configuration::Configuration;
use crate::report::section::Section;
use crate::report::studio::{Studio, fault};
use crate::report::subject::{Subject, framed_from};
use crate::report::truth::Truth;
use crate::report::verdict::{Shot, judge};
use leadr_maps::RgbImage;
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::camera::Camera;
use leadr_render::settings::{ShadingOptions, Terms};
use leadr_scenes::deform::{self, Deformation, PERIOD};
use leadr_scenes::stage::Lights;
use leadr_scenes::studio::studio as panorama;
use leadr_scenes::{pillow, snake};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, number};

const INTRO: &str = "The LEADR paper's Figure 5: a quad, a sphere and a cylinder are stretched, sheared or flattened with their original \
    maps; the moments follow the deformation (eq. 12). Near rows are the paper's insets, which show the displaced bumps. In far rows, \
    bumps are smaller than a pixel; a far picture is enlarged. Then its Figure 9 with diffuse microfacets: a pillow in an environment, \
    and a snake in an environment with four point lights, each as a whole and near (the paper's insets). LEADR at one sample per pixel is \
    compared with displacement-map truth. There are no shadows, because there is no sun.";

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

/// A view of the deformed surfaces.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Distance {
    Mid,
    Near,
    Far,
}

impl Distance {
    const ALL: [Self; 3] = [Self::Mid, Self::Near, Self::Far];

    /// Returns the suffix of the row's name.
    fn name(self) -> &'static str {
        match self {
            Self::Mid => "",
            Self::Near => ", near",
            Self::Far => ", far",
        }
    }
}

/// A picture of the deformed surfaces.
struct Photograph {
    camera: Camera,
    size: (u32, u32),
    /// The number of samples of the truth.
    samples: u32,
    /// The factor by which the page enlarges the picture.
    scale: u32,
    /// The part of the file names that identifies the picture.
    file: String,
    what: String,
}

struct Measured {
    group: &'static str,
    distance: Distance,
    case: Case,
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let size = studio.pick((128, 48), (384, 144));
    let samples = studio.pick(8, 128);
    let scale = studio.pick(2, 1);
    // The distance of the far view, relative to the middle view.
    let far = studio.pick(2, 4);
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
            let views = subject.stage.views;
            for distance in Distance::ALL {
                let of_view = match distance {
                    Distance::Mid => (views.mid, size, samples, scale),
                    // The inset shows one surface, whose bumps need fewer samples.
                    Distance::Near => (views.near, (size.1 * 4 / 3, size.1), samples / 2, scale),
                    Distance::Far => {
                        let size = (size.0 / far, size.1 / far);
                        (framed_from(&views.mid, far as f32), size, samples, scale * far)
                    }
                };
                let (camera, size, samples, scale) = of_view;
                let name = format!("{:.0} %{}", moment * 100.0, distance.name());
                let file = format!("{key}-{:.0}{}", moment * 100.0, distance.name().replace(", ", "-"));
                let what = format!("{title} by {name}");
                let (cells, case) =
                    photograph(studio, &mut subject, Photograph { camera, size, samples, scale, file, what })?;
                table.row(std::iter::once(Cell::from(name)).chain(cells));
                measured.push(Measured { group: title, distance, case });
            }
        }
        html.heading(title);
        html.table(&table);
    }
    html.heading("LEADR Figure 9: a pillow and a snake of diffuse microfacets");
    let mut findings: Vec<String> = Vec::new();
    html.table(&figure_9(studio, &panorama, samples, &mut measured, &mut findings)?);
    findings.splice(0..0, DEFORMATIONS.iter().filter_map(|d| finding(d.2, &measured)));
    let cases: Vec<Case> = measured.into_iter().map(|m| m.case).collect();
    let section = Section::new(INTRO, findings, &html, &cases)?;
    studio.cases.extend(cases);
    Ok(section)
}

/// Renders LEADR's Figure 9 with its columns: both truths, the paper's grid and the default rules. All have diffuse terms only, because the
/// figure shows diffuse microfacets. Appends one case and one finding for each row.
fn figure_9(
    studio: &mut Studio,
    panorama: &RgbImage,
    samples: u32,
    measured: &mut Vec<Measured>,
    findings: &mut Vec<String>,
) -> Result<Table, LabError> {
    let terms = Terms::DIFFUSE_LIGHTS | Terms::DIFFUSE_ENVIRONMENT;
    let configs = [Configuration::grid(5), Configuration::best()].map(|config| config.with(terms, Shadowing::None));
    let head = [
        "",
        "normal-map truth",
        "displacement-map truth",
        "LEADR 5×5",
        "LEADR, default rules",
        "rRMSE inside: normal-map truth",
        "5×5",
        "default rules",
        "noise of the truth",
    ];
    let mut table =
        Table::new(format!("Truths of {samples} samples per pixel; errors against displacement-map truth"), head);
    let tile = studio.pick(16, 32);
    let size = studio.pick((80, 60), (320, 240));
    let scale = studio.pick(2, 1);
    for (key, title, stage) in
        [("pillow", "The pillow", pillow::stage(tile)), ("snake", "The snake", snake::stage(tile))]
    {
        let mut subject = Subject::in_panorama(studio, stage, panorama, Lights::default())?;
        let views = subject.stage.views;
        for (view, camera) in [("", views.mid), (", near", views.near)] {
            let state = subject.seen_by(&camera);
            let renderer = &mut subject.renderer;
            let truths = [Truth::NormalMap, Truth::Displacement].map(|truth| {
                let mut settings = truth.settings(size, samples, 1);
                settings.shading = settings.shading.adjusted(|options| ShadingOptions { terms, ..options });
                studio.shoot_truth(renderer, &state, &settings)
            });
            let [normal_map, displaced] = truths;
            let (normal_map, displaced) = (normal_map?, displaced?);
            let file = |what: &str| format!("shapes-{key}{}-{what}", view.replace(", ", "-"));
            let mut shown = |truth: Truth, shot: &Shot| {
                let figure = studio.picture(&file(truth.name()), &shot.image, 1.0, truth.title(), Vec::new());
                figure.map(|figure| figure.enlarged(scale))
            };
            let truths = [shown(Truth::NormalMap, &normal_map)?, shown(Truth::Displacement, &displaced)?];
            let mut cells = vec![Cell::from(format!("{title}{view}"))];
            cells.extend(truths.iter().cloned().map(Cell::Figure));
            let mut errors = vec![judge(&displaced, &normal_map, 1.0).map_err(fault)?.interior.rrmse];
            for config in &configs {
                let shot = studio.shoot(renderer, &state, &config.settings(size, 1))?;
                let verdict = judge(&displaced, &shot, 1.0).map_err(fault)?;
                let picture = studio.picture(&file(&config.file()), &shot.image, 1.0, &config.name, Vec::new())?;
                let picture = picture.enlarged(scale);
                errors.push(verdict.interior.rrmse);
                let mut case = Case::new("shapes", format!("{title}{view}"), &config.name, "displacement", &verdict);
                case.normal_map = Some(judge(&normal_map, &shot, 1.0).map_err(fault)?.interior);
                case.figures = vec![truths[1].clone(), picture.clone()];
                measured.push(Measured { group: title, distance: Distance::Mid, case });
                cells.push(Cell::Figure(picture));
            }
            findings.push(format!(
                "{title}{view}: rRMSE inside is {} of the normal-map truth, {} of LEADR with 5×5 samples and {} with the default rules (noise of \
                the truth {}).",
                number(errors[0]),
                number(errors[1]),
                number(errors[2]),
                number(displaced.noise)
            ));
            cells.extend(errors.into_iter().chain([displaced.noise]).map(Cell::from));
            table.row(cells);
        }
    }
    Ok(table)
}

/// Compares a picture with the truth. Returns the case, and the cells of a table row after the first.
fn photograph(studio: &mut Studio, subject: &mut Subject, of: Photograph) -> Result<(Vec<Cell>, Case), LabError> {
    let Photograph { camera, size, samples, scale, file, what } = of;
    let state = subject.seen_by(&camera);
    let truth = studio.shoot_truth(&mut subject.renderer, &state, &Truth::Displacement.settings(size, samples, 1))?;
    let config = Configuration::best().with(Terms::ALL, Shadowing::None);
    let shot = studio.shoot(&mut subject.renderer, &state, &config.settings(size, 1))?;
    let verdict = judge(&truth, &shot, 1.0).map_err(fault)?;
    let file = |kind: &str| format!("shapes-{file}-{kind}");
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
    let seen = |distance: Distance| -> Vec<&Case> {
        measured.iter().filter(|m| m.group == group && m.distance == distance).map(|m| &m.case).collect()
    };
    let (of, near, far) = (seen(Distance::Mid), seen(Distance::Near), seen(Distance::Far));
    let (first, last, near, far) = (of.first()?, of.last()?, near.last()?, far.last()?);
    let (error, noise) = (number(last.interior.rrmse), number(last.noise));
    let verdict = match last.interior.rrmse / first.interior.rrmse {
        r if r > 1.25 => "the deformation increases it",
        r if r < 0.8 => "the deformation reduces it",
        _ => "the deformation hardly changes it",
    };
    let before = number(first.interior.rrmse);
    Some(format!(
        "{group}: rRMSE inside is {before} before and {error} fully deformed (noise {noise}): {verdict}. Fully deformed, it is {} near and \
        {} far.",
        number(near.interior.rrmse),
        number(far.interior.rrmse)
    ))
}
