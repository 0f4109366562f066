//! Renders the sphere grid of the LEADR supplement (tables 4 to 9).

use glam::{Vec2, Vec2Swizzles as _};
use serde::Serialize;

use crate::report::case::Case;
use crate::report::configuration::Configuration;
use crate::report::section::Section;
use crate::report::studio::{Studio, fault};
use crate::report::subject::Subject;
use crate::report::truth::Truth;
use crate::report::verdict::{Errors, Shot, Verdict, judge};
use leadr_reflectance::masking::shadowing::Shadowing;
use leadr_render::settings::{Probes, RenderSettings, ShadingOptions, Terms};
use leadr_scenes::spheres::cell::{Lighting, ROTATION_PERIOD};
use leadr_scenes::spheres::surface::{Detail, Frequency, Surface};
use leadr_scenes::spheres::{ANISOTROPIC, ISOTROPIC};
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Figure, Html, Table, number};
use leadr_tools::html::{Plot, Scale};

const INTRO: &str = "Spheres whose heights are Gaussian noise with known slopes and bumps smaller than a pixel, in the lighting of the \
    supplement's tables: white diffuse facets under one light from the camera, under the studio's irradiance, and mirror facets in the \
    studio. Columns are the two truths with large bumps (low) and with bumps smaller than a pixel (high), then LEADR at one sample per pixel with the paper's grids of slope samples and with the \
    visible-slope rules. Rows with σ_θ < σ_φ have scratches from pole to pole; the last rows, with σ_θ > σ_φ, have scratches parallel to \
    the equator, which the supplement describes without printing such a pair in table 5. Masking is on and shadowing off: light from the camera reaches everything that the camera sees, and the \
    rasterised truth does not block the environment by bumps. Under each picture: FLIP and relative RMSE against normal-map truth (n) and \
    displacement-map truth (d), over the pixels that the sphere touches (without the background) and, in brackets, inside its silhouette. \
    A single surface has only a few bumps in each pixel. Every picture is therefore the mean over rotations of the sphere about its \
    poles, which keep its statistics: the remaining error is that of the model, not of one random surface. The noise of the truth is the \
    difference between two halves of these rotations.";

const EXPOSURE: f32 = 0.8;

/// A light, and its pair of tables in the supplement.
struct Light {
    lighting: Lighting,
    terms: Terms,
    title: &'static str,
    key: &'static str,
}

const LIGHTS: [Light; 3] = [
    Light {
        lighting: Lighting::Front,
        terms: Terms::DIFFUSE_LIGHTS,
        title: "Tables 4 and 5: diffuse facets, one light from the camera",
        key: "front",
    },
    Light {
        lighting: Lighting::Irradiance,
        terms: Terms::DIFFUSE_ENVIRONMENT,
        title: "Tables 6 and 7: diffuse facets under irradiance",
        key: "irradiance",
    },
    Light {
        lighting: Lighting::Environment,
        terms: Terms::SPECULAR_ENVIRONMENT,
        title: "Tables 8 and 9: mirror facets in an environment",
        key: "environment",
    },
];

#[derive(Clone, Debug, Serialize)]
struct Entry {
    table: &'static str,
    sigma: [f32; 2],
    look: String,
    milliseconds: f64,
    normal_map: Errors,
    normal_map_inside: Errors,
    displacement: Errors,
    displacement_inside: Errors,
    /// The relative noise of the displacement-map truth in the interior.
    noise: f64,
}

/// Scratches parallel to the equator. The supplement describes this direction, and its table 5 prints only the other. These are pairs of
/// table 5 with swapped components, and have one ratio, so that they share baked surfaces.
const LATITUDINAL: [Vec2; 3] = [Vec2::new(0.04, 0.01), Vec2::new(0.2, 0.05), Vec2::new(0.8, 0.2)];

/// The rows of a quick report.
const QUICK: [Vec2; 5] =
    [Vec2::splat(0.05), Vec2::splat(0.5), Vec2::splat(1.0), Vec2::new(0.2, 0.8), Vec2::new(0.8, 0.2)];

/// Whether scratches are parallel to the equator.
fn is_latitudinal(sigma: Vec2) -> bool {
    sigma.x > sigma.y
}

/// Returns the smallest integers in the ratio of `sigma`, one of which is 1.
fn ratio(sigma: Vec2) -> Vec2 {
    (sigma / sigma.min_element()).round()
}

/// Returns groups of roughness pairs. The pairs of a group have the same ratio and share a baked surface.
fn groups(quick: bool) -> Vec<(Vec2, Vec<Vec2>)> {
    let mut groups: Vec<(Vec2, Vec<Vec2>)> = Vec::new();
    let pairs = ISOTROPIC.iter().map(|&s| Vec2::splat(s)).chain(ANISOTROPIC).chain(LATITUDINAL);
    for sigma in pairs.filter(|sigma| !quick || QUICK.contains(sigma)) {
        let ratio = ratio(sigma);
        match groups.iter_mut().find(|g| g.0 == ratio) {
            Some(group) => group.1.push(sigma),
            None => groups.push((ratio, vec![sigma])),
        }
    }
    groups
}

/// Returns the configurations that are compared with the truth. A quick run skips the largest grid, which takes most of the
/// time.
fn configs(quick: bool) -> Vec<Configuration> {
    let mut configs = vec![
        Configuration::grid(5),
        Configuration::grid(32),
        Configuration::grid(128),
        Configuration::visible(Probes::Nine),
    ];
    if quick {
        configs.remove(2);
    }
    configs
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let detail = studio.pick(Detail { patches: 8, tile: 32 }, Detail::PICTURE);
    let groups = groups(studio.quick);
    let total: usize = groups.iter().map(|g| g.1.len() * LIGHTS.len()).sum();
    studio.steps(total);
    let mut rows: Vec<(&'static str, Vec2, Vec<Cell>)> = Vec::new();
    let mut entries = Vec::new();
    for (ratio, sigmas) in &groups {
        let [high, low] = [Frequency::High, Frequency::Low].map(|frequency| Surface::bake(*ratio, frequency, detail));
        for light in &LIGHTS {
            let panorama = light.lighting.panorama();
            let upload = |surface: &Surface| {
                let stage = surface.stage(1.0, light.lighting.facets());
                Subject::in_panorama(studio, stage, &panorama, light.lighting.lights())
            };
            let (mut low, mut subject) = (upload(&low)?, upload(&high)?);
            for &sigma in sigmas {
                let large = low_frequency(studio, &mut low, light, sigma)?;
                let (small, made) = cell(studio, &mut subject, light, sigma)?;
                let mut cells = Vec::with_capacity(large.len() + small.len());
                let mut small = small.into_iter();
                // The supplement's order: low and high frequency for each truth.
                for figure in large {
                    cells.push(figure);
                    cells.extend(small.next());
                }
                cells.extend(small);
                rows.push((light.key, sigma, cells));
                entries.extend(made);
                studio.step();
            }
        }
    }
    let mut html = Html::new();
    for light in &LIGHTS {
        html.heading(light.title);
        html.plot(&plot(light, &configs(studio.quick), &entries));
        let truths = ["normal map, low", "normal map, high", "displacement, low", "displacement, high"];
        let head = std::iter::once("σ").chain(truths).map(str::to_owned);
        let head = head.chain(configs(studio.quick).into_iter().map(|l| l.name));
        let mut table = Table::new(light.title, head);
        let mut of_light: Vec<_> = rows.iter().filter(|r| r.0 == light.key).collect();
        // Isotropic rows come first. The anisotropic rows are in the supplement's order. Latitudinal rows come last.
        of_light.sort_by(|a, b| {
            let order = |s: Vec2| (s.x != s.y, is_latitudinal(s), s.x, s.y);
            order(a.1).partial_cmp(&order(b.1)).unwrap_or(std::cmp::Ordering::Equal)
        });
        for (_, sigma, cells) in of_light {
            table.row(std::iter::once(Cell::from(name_of(*sigma))).chain(cells.iter().cloned()));
        }
        html.table(&table);
    }
    let findings = LIGHTS.iter().flat_map(|light| findings(light, &configs(studio.quick), &entries)).collect();
    Section::new(INTRO, findings, &html, &entries)
}

fn name_of(sigma: Vec2) -> String {
    if sigma.x == sigma.y { format!("{}", sigma.x) } else { format!("{}, {}", sigma.x, sigma.y) }
}

/// Returns the settings of a truth in the light of a table.
fn truth_settings(truth: Truth, light: &Light, size: u32, samples: u32) -> RenderSettings {
    let mut settings = truth.settings((size, size), samples, 1);
    settings.shading = settings.shading.adjusted(|options| ShadingOptions { terms: light.terms, ..options });
    settings.shadows = false;
    settings
}

/// Renders both truths of a surface whose bumps are larger than a pixel.
fn low_frequency(
    studio: &mut Studio,
    subject: &mut Subject,
    light: &Light,
    sigma: Vec2,
) -> Result<Vec<Cell>, LabError> {
    let (size, samples) = studio.pick((64, 4), (128, 32));
    let mut state = subject.seen_by(&subject.stage.views.mid);
    state.height_scale = sigma.max_element();
    let row = format!("{}-{}-{}", light.key, sigma.x, sigma.y).replace('.', "_");
    let mut cells = Vec::new();
    for truth in [Truth::NormalMap, Truth::Displacement] {
        let shot = studio.shoot(&mut subject.renderer, &state, &truth_settings(truth, light, size, samples))?;
        let name = format!("spheres-{row}-{}-low", truth.name());
        let alt = format!("{}, low frequency", truth.title());
        cells.push(Cell::Figure(studio.picture(&name, &shot.image, EXPOSURE, &alt, Vec::new())?));
    }
    Ok(cells)
}

/// Renders and judges one row of a table.
fn cell(
    studio: &mut Studio,
    subject: &mut Subject,
    light: &Light,
    sigma: Vec2,
) -> Result<(Vec<Cell>, Vec<Entry>), LabError> {
    let size = studio.pick(64, 128);
    let (turns, samples) = studio.pick((6u32, 2), (16, 4));
    let camera = subject.stage.views.mid;
    // Returns the mean over rotations, whose two halves estimate the noise of the mean.
    let mut shoot = |settings: RenderSettings| -> Result<Shot, LabError> {
        let mut halves = [Vec::new(), Vec::new()];
        for turn in 0..turns {
            subject.set_time(f64::from(turn) / f64::from(turns) * ROTATION_PERIOD);
            let mut state = subject.seen_by(&camera);
            state.height_scale = sigma.max_element();
            let settings = RenderSettings { seed: settings.seed + u64::from(turn), ..settings };
            halves[turn as usize % 2].push(studio.shoot(&mut subject.renderer, &state, &settings)?);
        }
        let [a, b] = [&halves[0], &halves[1]].map(|half| Shot::mean(half).map_err(fault));
        Shot::mean_of(&a?, &b?).map_err(fault)
    };
    let row = format!("{}-{}-{}", light.key, sigma.x, sigma.y).replace('.', "_");
    let mut truths: Vec<(Truth, u32, Shot)> = Vec::new();
    let mut cells = Vec::new();
    for truth in [Truth::NormalMap, Truth::Displacement] {
        // The normal-map truth has more samples, because it aliases more, and its smooth geometry is cheap to draw.
        let samples = if truth == Truth::NormalMap { 4 * samples } else { samples };
        let shot = shoot(truth_settings(truth, light, size, samples))?;
        truths.push((truth, samples, shot));
    }
    let configs: Vec<(Configuration, Shot)> = configs(studio.quick)
        .into_iter()
        .map(|config| {
            let config = config.with(light.terms, Shadowing::None);
            let settings = RenderSettings { shadows: false, ..config.settings((size, size), 1) };
            Ok((config, shoot(settings)?))
        })
        .collect::<Result<_, LabError>>()?;
    for (truth, samples, shot) in &truths {
        let name = format!("spheres-{row}-{}", truth.name());
        let caption = vec![format!("{turns} × {samples} samples"), format!("noise {}", number(shot.noise))];
        cells.push(Cell::Figure(studio.picture(&name, &shot.image, EXPOSURE, truth.title(), caption)?));
    }
    let shown: Vec<Figure> =
        cells.iter().filter_map(|c| if let Cell::Figure(f) = c { Some(f.clone()) } else { None }).collect();
    let mut entries = Vec::new();
    for (config, shot) in configs {
        let verdicts: Vec<Verdict> =
            truths.iter().map(|(.., truth)| judge(truth, &shot, EXPOSURE).map_err(fault)).collect::<Result<_, _>>()?;
        let [normal_map, displacement] = [&verdicts[0], &verdicts[1]];
        let line = |sign: &str, v: &Verdict| {
            [
                format!("{sign} FLIP {} ({})", number(v.object.flip), number(v.interior.flip)),
                format!("{sign} rRMSE {} ({})", number(v.object.rrmse), number(v.interior.rrmse)),
            ]
        };
        let caption = [line("n", normal_map), line("d", displacement)].concat();
        let name = format!("spheres-{row}-{}", config.file());
        let picture = studio.picture(&name, &shot.image, EXPOSURE, &config.name, caption)?;
        let errors = studio.error_picture(&format!("{name}-errors"), displacement, "FLIP errors", Vec::new())?;
        let subject = format!("σ {}, {}", name_of(sigma), light.title);
        let mut case = Case::new("spheres", subject, &config.name, "displacement", displacement);
        case.normal_map = Some(normal_map.interior);
        case.figures = vec![shown[1].clone(), picture.clone(), errors];
        studio.cases.push(case);
        cells.push(Cell::Figure(picture));
        entries.push(Entry {
            table: light.key,
            sigma: sigma.to_array(),
            look: config.name,
            milliseconds: shot.milliseconds,
            normal_map: normal_map.object,
            normal_map_inside: normal_map.interior,
            displacement: displacement.object,
            displacement_inside: displacement.interior,
            noise: displacement.noise,
        });
    }
    Ok((cells, entries))
}

fn plot(light: &Light, configs: &[Configuration], entries: &[Entry]) -> Plot {
    let mut plot = Plot::new(
        &format!("{}: isotropic spheres", light.title),
        ("σ", Scale::Log),
        ("relative RMSE inside, against displacement truth", Scale::Log),
    );
    for config in configs {
        let of = entries.iter().filter(|e| e.table == light.key && e.look == config.name && e.sigma[0] == e.sigma[1]);
        plot.line(&config.name, of.map(|e| (f64::from(e.sigma[0]), e.displacement_inside.rrmse)).collect());
    }
    plot
}

fn findings(light: &Light, configs: &[Configuration], entries: &[Entry]) -> Vec<String> {
    let of = |name: &str| entries.iter().filter(|e| e.table == light.key && e.look == name).collect::<Vec<_>>();
    let rms_of = |name: &str, pick: &dyn Fn(Vec2) -> bool| {
        let list: Vec<_> = of(name).into_iter().filter(|e| pick(Vec2::from_array(e.sigma))).collect();
        (list.iter().map(|e| e.displacement_inside.rrmse.powi(2)).sum::<f64>() / list.len().max(1) as f64).sqrt()
    };
    let rms = |name: &str| rms_of(name, &|sigma| !is_latitudinal(sigma));
    let names: Vec<String> = configs.iter().map(|l| l.name.clone()).collect();
    let listed: Vec<String> = names.iter().map(|name| format!("{name} {}", number(rms(name)))).collect();
    let mut findings = vec![format!(
        "{}: root mean square of rRMSE inside over the supplement's rows: {}.",
        light.title,
        listed.join(", ")
    )];
    // On the largest grid, the only error left is the error of the model.
    let converged = configs.iter().rev().find(|l| l.is_grid());
    if let Some(config) = converged {
        let across = rms_of(&config.name, &|sigma| LATITUDINAL.contains(&sigma));
        let along = rms_of(&config.name, &|sigma| LATITUDINAL.contains(&sigma.yx()));
        findings.push(format!(
            "{}: with the samples of {}, the root mean square is {} for scratches parallel to the equator, and {} for the same pairs from \
            pole to pole.",
            light.title,
            config.name,
            number(across),
            number(along)
        ));
    }
    let rows = converged.map_or(Vec::new(), |config| of(&config.name));
    let error = |e: &&Entry| e.displacement_inside.rrmse;
    if let Some(worst) = rows.into_iter().max_by(|a, b| error(a).total_cmp(&error(b))) {
        findings.push(format!(
            "{}: with the samples of {} the model's error is {} at σ = {}, its worst row (bias {}, noise of the truth {}); against normal-map truth by {}.",
            light.title,
            worst.look,
            number(worst.displacement_inside.rrmse),
            name_of(Vec2::from_array(worst.sigma)),
            number(worst.displacement_inside.bias),
            number(worst.noise),
            number(worst.normal_map_inside.rrmse),
        ));
    }
    findings
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn groups_have_every_pair_with_its_ratio() {
        for quick in [false, true] {
            let groups = groups(quick);
            let count: usize = groups.iter().map(|g| g.1.len()).sum();
            assert_eq!(
                count,
                if quick { QUICK.len() } else { ISOTROPIC.len() + ANISOTROPIC.len() + LATITUDINAL.len() }
            );
            for (ratio, sigmas) in groups {
                assert_eq!(ratio.min_element(), 1.0);
                for sigma in sigmas {
                    let error = sigma / sigma.max_element() - ratio / ratio.max_element();
                    assert!(error.abs().max_element() < 1e-5, "{sigma} is not in the ratio {ratio}");
                }
            }
        }
    }

    #[test]
    fn latitudinal_pairs_are_swapped_pairs_of_the_supplement() {
        assert!(LATITUDINAL.iter().all(|s| is_latitudinal(*s) && ANISOTROPIC.contains(&s.yx())));
        assert!(!ANISOTROPIC.into_iter().any(is_latitudinal));
    }
}
