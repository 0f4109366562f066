//! Compares every technique with the supersampled surface, on the rough sphere at several distances.

use crate::report::case::Case;
use crate::report::configuration::Configuration;
use crate::report::section::Section;
use crate::report::studio::{Studio, fault};
use crate::report::subject::{Subject, framed_from};
use crate::report::truth::Truth;
use crate::report::verdict::{Shot, judge};
use leadr_render::scene::FrameState;
use leadr_render::settings::Technique;
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Figure, Html, Table, number};
use leadr_tools::html::{Plot, Scale};

const INTRO: &str = "Every technique at one sample per pixel on the rough sphere under the sky and its sun, at several distances. A pixel \
    always covers the same angle, so the pictures shrink as the camera moves away. The displacement-map truth has only the sun's shadows, \
    and so does every technique that integrates over slopes. Techniques with a GGX base are compared with the truth of that base. Errors \
    are over the pixels that the sphere touches, or over its interior, which excludes silhouette aliasing. A positive bias means too \
    bright. Pictures of far views are enlarged.";

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let near = studio.pick(96, 256);
    let steps = studio.pick(3, 4);
    let samples = studio.pick(32, 256);
    let mut subject = Subject::rock(studio, studio.pick(16, 32))?;
    let configs = Configuration::techniques();
    let (mut html, mut cases) = (Html::new(), Vec::new());
    let mut lines = vec![Vec::new(); configs.len()];
    for step in 0..steps {
        let factor = 1u32 << step;
        let size = (near / factor, near / factor);
        let camera = framed_from(&subject.stage.views.mid, factor as f32);
        let distance = camera.position.distance(camera.target);
        let state = subject.seen_by(&camera);
        let truths = Truths::shoot(studio, &mut subject, &state, size, samples)?;
        let heading = format!("{} m, {} pixels across", number(f64::from(distance)), size.0);
        let mut table = Table::new(
            format!(
                "{heading}; truth of {samples} samples per pixel, its noise {} inside",
                number(truths.beckmann.noise)
            ),
            ["technique", "picture", "FLIP errors", "rRMSE", "rRMSE inside", "bias inside", "FLIP", "ms"],
        );
        let mut show = |file: &str, name: &'static str, truth: &Shot| -> Result<Figure, LabError> {
            let file = format!("techniques-{factor}-{file}");
            let caption = vec![format!("{samples} samples")];
            let shown = studio.picture(&file, &truth.image, 1.0, name, caption)?.enlarged(factor);
            table.row([Cell::from(name), Cell::Figure(shown.clone())]);
            Ok(shown)
        };
        let shown = show("truth", "truth", &truths.beckmann)?;
        let shown_ggx = show("truth-ggx", "truth, GGX base", &truths.ggx)?;
        let mut numbers = Vec::new();
        for (config, line) in configs.iter().zip(&mut lines) {
            let shot = studio.shoot(&mut subject.renderer, &state, &config.settings(size, 1))?;
            let verdict = judge(truths.of(config), &shot, 1.0).map_err(fault)?;
            let name = |kind: &str| format!("techniques-{factor}-{}-{kind}", config.file());
            let picture = studio.picture(&name("picture"), &shot.image, 1.0, &config.name, Vec::new())?;
            let errors = studio.error_picture(&name("errors"), &verdict, "FLIP errors", Vec::new())?;
            let figures: Vec<Figure> = vec![picture.enlarged(factor), errors.enlarged(factor)];
            line.push((f64::from(distance), verdict.interior.rrmse));
            numbers.push((config.name.clone(), verdict.object, verdict.interior, shot.milliseconds, figures.clone()));
            let mut case =
                Case::new("techniques", format!("rough sphere at {heading}"), &config.name, "displacement", &verdict);
            let truth = if config.shading.technique().has_ggx_base() { &shown_ggx } else { &shown };
            case.figures = [vec![truth.clone()], figures].concat();
            cases.push(case);
        }
        for (name, object, interior, milliseconds, figures) in numbers {
            let mut cells = vec![Cell::from(name)];
            cells.extend(figures.into_iter().map(Cell::Figure));
            cells.extend([object.rrmse, interior.rrmse, interior.bias, object.flip, milliseconds].map(Cell::from));
            table.row(cells);
        }
        html.heading(&heading);
        html.table(&table);
    }
    let mut plot = Plot::new(
        "Error inside the sphere against distance, one sample per pixel",
        ("distance, metres", Scale::Log),
        ("relative RMSE inside", Scale::Log),
    );
    for (config, line) in configs.iter().zip(&lines) {
        plot.line(&config.name, line.clone());
    }
    let mut shown = Html::new();
    shown.plot(&plot);
    shown.append(&html);
    let findings = findings(&configs, &lines);
    let section = Section::new(INTRO, findings, &shown, &cases)?;
    studio.cases.extend(cases);
    Ok(section)
}

struct Truths {
    beckmann: Shot,
    ggx: Shot,
}

impl Truths {
    fn shoot(
        studio: &Studio,
        subject: &mut Subject,
        state: &FrameState,
        size: (u32, u32),
        samples: u32,
    ) -> Result<Self, LabError> {
        let mut shoot = |technique: Technique| {
            let settings = Truth::Displacement.settings_for(technique, size, samples, 1);
            studio.shoot_truth(&mut subject.renderer, state, &settings)
        };
        Ok(Self { beckmann: shoot(Technique::Leadr)?, ggx: shoot(Technique::LeadrGgx)? })
    }

    fn of(&self, config: &Configuration) -> &Shot {
        if config.shading.technique().has_ggx_base() { &self.ggx } else { &self.beckmann }
    }
}

/// Finds the technique that is closest to the truth at a distance, and compares all others with this technique.
fn findings(configs: &[Configuration], lines: &[Vec<(f64, f64)>]) -> Vec<String> {
    let mut far: Vec<(&str, f64)> =
        configs.iter().zip(lines).filter_map(|(config, line)| Some((config.name.as_str(), line.last()?.1))).collect();
    far.sort_by(|a, b| a.1.total_cmp(&b.1));
    let distance = lines.first().and_then(|line| line.last()).map_or(0.0, |p| p.0);
    let listed: Vec<String> = far.iter().map(|(name, error)| format!("{name} {}", number(*error))).collect();
    let mut findings = vec![format!("At {} m, in order of rRMSE inside: {}.", number(distance), listed.join(", "))];
    let means: Vec<(&str, f64)> = configs
        .iter()
        .zip(lines)
        .map(|(config, line)| (config.name.as_str(), line.iter().map(|p| p.1.ln()).sum::<f64>() / line.len() as f64))
        .collect();
    let mean_of = |name: &str| means.iter().find(|m| m.0 == name).map(|m| m.1);
    let best = means.iter().min_by(|a, b| a.1.total_cmp(&b.1));
    if let (Some(best), Some(naive)) = (best, mean_of("normal-mip")) {
        findings.push(format!(
            "Over all distances {} has the smallest error (geometric mean {}); mipmapped normals have {} times as much.",
            best.0,
            number(best.1.exp()),
            number((naive - best.1).exp())
        ));
    }
    findings
}
