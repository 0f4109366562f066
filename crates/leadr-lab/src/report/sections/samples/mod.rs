//! Compares the accuracy and speed of one sample of LEADR with references of many samples.

mod race;
mod rough_sphere;
mod worth;

use serde::Serialize;

use self::race::{Contest, FASTER, MEASURES, Race, Row, WORTH, race};
use self::rough_sphere::RoughSphere;
use crate::report::section::Section;
use crate::report::studio::Studio;
use crate::report::subject::Subject;
use leadr_render::surfaces::tessellation::TessellationSettings;
use leadr_scenes::spheres::surface::Detail;
use leadr_tools::error::LabError;
use leadr_tools::html::{Cell, Html, Table, number, percent};
use leadr_tools::html::{Plot, Scale};

const INTRO: &str = "How accurate is LEADR with one shaded sample per pixel, and how many samples does a brute-force reference need for \
    the same error? The truth has all shadows of the bumps, from the sun and from the sky; LEADR uses its default settings. The goal \
    applies to a sphere whose bumps match the model, Gaussian and finer than the pixels, and to the T-rex at a distance. A rock with a \
    few large bumps in each pixel is harder. Edge samples test only the geometry: they smooth silhouettes and give the one shaded sample \
    the pixel's contents. Errors are relative RMSE with the truth's own noise subtracted (squares of independent errors add), and mean \
    FLIP (from which noise cannot be subtracted), over the pixels that the object touches; \"inside\" excludes its silhouette. \"Common\" \
    is the part of the interior error that neighbouring pixels share: each sample of the reference uses one direction of the sky for the \
    whole picture. Times are those of all passes on the device; for LEADR those of the second of two runs.";

#[derive(Debug, Serialize)]
struct Data {
    subjects: Vec<Race>,
    /// The results for the Gaussian sphere with several bump sizes, starting with the largest.
    bumps: Vec<Race>,
}

pub fn run(studio: &mut Studio) -> Result<Section, LabError> {
    let mut html = Html::new();
    let mut show = |studio: &mut Studio, contest: Contest| -> Result<Race, LabError> {
        let key = contest.key;
        let (race, pictures) = race(studio, contest)?;
        html.heading(&race.subject);
        html.figures(&pictures.keep(studio, key, &race)?);
        html.plot(&plot(&race));
        html.table(&table(&race));
        Ok(race)
    };
    // The goal applies to the finest bumps. Tiles with fewer texels have larger and fewer bumps.
    let tiles = studio.pick(&[16, 32][..], &[16, 32, 64]);
    let (&finest, coarser) = tiles.split_last().expect("tiles");
    let sphere = gaussian_sphere(studio, finest)?;
    let sphere = show(studio, sphere)?;
    let trex = Subject::trex(studio, studio.pick(8, 16))?;
    let trex = at_a_distance(studio, "T-rex", 90.0, true, trex);
    let trex = show(studio, trex)?;
    let rock = Subject::rock(studio, studio.pick(16, 32))?;
    let rock = at_a_distance(studio, "rock", 24.0, false, rock);
    let rock = show(studio, rock)?;
    let mut bumps = Vec::new();
    for &tile in coarser {
        let contest = gaussian_sphere(studio, tile)?;
        bumps.push(race(studio, contest)?.0);
    }
    let order: Vec<&Race> = bumps.iter().chain([&sphere]).collect();
    html.heading("Required number of bumps per pixel");
    html.table(&bumps_table(&order));
    let mut findings = verdict(&[&sphere, &trex, &rock]);
    findings.extend([&sphere, &trex, &rock].into_iter().flat_map(findings_of));
    findings.push(bumps_finding(&order));
    Section::new(INTRO, findings, &html, Data { subjects: vec![sphere, trex, rock], bumps })
}

/// Returns the Gaussian sphere with atlas tiles of `tile` texels, which determine its bump size.
fn gaussian_sphere(studio: &Studio, tile: u32) -> Result<Contest, LabError> {
    // Tens of bumps per pixel are affordable only in a small picture, because each has vertices and shadows.
    let size = studio.pick(16, 24);
    let sphere = RoughSphere::new(Detail { patches: 8, tile });
    let bumps = sphere.bumps_per_pixel(size);
    let subject = Subject::under_the_sky(studio, sphere.stage, 0.0)?;
    Ok(Contest {
        title: format!("Gaussian sphere, {} bumps per pixel", number(bumps)),
        key: "sphere",
        goal: true,
        camera: subject.stage.views.mid,
        subject,
        size,
        bumps_per_pixel: Some(bumps),
        // Every texel has a vertex. Bumps cast shadows, so errors from missing bumps would not average out.
        vertices_per_pixel: f32::INFINITY,
        converged: studio.pick(64, 128),
        counts: counts(studio),
    })
}

/// Returns a subject at a camera distance of `distance` metres.
fn at_a_distance(studio: &Studio, name: &'static str, distance: f32, goal: bool, subject: Subject) -> Contest {
    Contest {
        title: format!("{name} at {distance} m"),
        key: name,
        goal,
        camera: subject.stage.views.mid.at_distance(distance),
        subject,
        size: studio.pick(96, 128),
        bumps_per_pixel: None,
        vertices_per_pixel: TessellationSettings::default().vertices_per_pixel,
        converged: studio.pick(64, 128),
        counts: counts(studio),
    }
}

fn counts(studio: &Studio) -> &'static [u32] {
    studio.pick(&[1, 4, 16, 32, 64], &[1, 2, 4, 8, 16, 32, 64, 96])
}

fn plot(race: &Race) -> Plot {
    let mut plot = Plot::new(
        &format!("{}: error against time", race.subject),
        ("milliseconds on the device", Scale::Log),
        ("relative RMSE", Scale::Log),
    );
    // Errors below the truth's noise become 0, which a logarithmic scale cannot show.
    let line = |rows: &[&Row], pick: fn(&Row) -> f64| {
        rows.iter().map(|r| (r.milliseconds, pick(r))).filter(|p| p.1 > 0.0).collect::<Vec<_>>()
    };
    let references: Vec<&Row> = race.references.iter().collect();
    plot.line("reference", line(&references, |r| r.own.object));
    plot.line("reference, inside", line(&references, |r| r.own.interior));
    plot.line("LEADR, one shaded sample", line(&[&race.leadr], |r| r.own.object));
    plot.line("LEADR, one shaded sample, inside", line(&[&race.leadr], |r| r.own.interior));
    plot
}

fn table(race: &Race) -> Table {
    let mut table = Table::new(
        format!(
            "{} x {} pixels, against {} samples of other seeds, whose noise ({}, inside {}) is subtracted from the rRMSE",
            race.size,
            race.size,
            race.converged_samples,
            number(race.noise.object),
            number(race.noise.interior),
        ),
        [
            "",
            "samples",
            "edge samples",
            "rRMSE",
            "rRMSE inside",
            "FLIP",
            "FLIP inside",
            "bias inside",
            "common inside",
            "ms",
            "times LEADR",
        ],
    );
    for row in std::iter::once(&race.leadr).chain(&race.others).chain(&race.references) {
        let numbers = [
            row.own.object,
            row.own.interior,
            row.object.flip,
            row.interior.flip,
            row.interior.bias,
            row.common,
            row.milliseconds,
            row.milliseconds / race.leadr.milliseconds,
        ];
        let head = [row.look.clone(), row.samples.to_string(), row.edge_samples.to_string()].map(Cell::from);
        table.row(head.into_iter().chain(numbers.map(Cell::from)));
    }
    table
}

/// Returns a table that lists how many samples one sample is worth, by the number of bumps per pixel.
fn bumps_table(races: &[&Race]) -> Table {
    let errors = ["LEADR: rRMSE", "inside", "reference of 64: rRMSE", "inside"].map(str::to_owned);
    let head = ["".to_owned(), "truth's noise inside".to_owned()].into_iter().chain(errors);
    let mut table = Table::new(
        "One sample of LEADR by bump size",
        head.chain(MEASURES.map(|m| format!("worth by {}", m.name))).chain(["times faster".to_owned()]),
    );
    for race in races {
        let judge = race.judge().map_or([f64::NAN; 2], |r| [r.own.object, r.own.interior]);
        let numbers = [race.noise.interior, race.leadr.own.object, race.leadr.own.interior].into_iter().chain(judge);
        let worth = race.worth.iter().map(|(_, worth)| Cell::from(worth.to_string()));
        table.row(
            std::iter::once(Cell::from(race.subject.as_str()))
                .chain(numbers.map(Cell::from))
                .chain(worth)
                .chain([Cell::from(race.faster.unwrap_or(f64::NAN))]),
        );
    }
    table
}

/// Returns sentences that say whether the goal's subjects, and harder subjects, meet the goal.
fn verdict(races: &[&Race]) -> Vec<String> {
    let names = |goal: bool, met: bool| -> Vec<&str> {
        races.iter().filter(|r| r.goal == goal && r.met == met).map(|r| r.subject.as_str()).collect()
    };
    let message = |goal: bool| -> String {
        let parts = [("met by", names(goal, true)), ("missed by", names(goal, false))];
        let parts = parts.iter().filter(|p| !p.1.is_empty()).map(|(verb, who)| format!("{verb} {}", who.join(" and ")));
        parts.collect::<Vec<_>>().join(", ")
    };
    [(true, "its subjects"), (false, "subjects harder than the goal's")]
        .into_iter()
        .filter(|&(goal, _)| races.iter().any(|r| r.goal == goal))
        .map(|(goal, which)| {
            format!(
                "The goal (worth {WORTH} samples by rRMSE and FLIP of the whole object, {FASTER} times faster), {which}: {}.",
                message(goal)
            )
        })
        .collect()
}

fn findings_of(race: &Race) -> Vec<String> {
    let leadr = &race.leadr;
    let worth: Vec<String> = race.worth.iter().map(|(name, worth)| format!("{worth} by {name}")).collect();
    let mut findings = vec![format!(
        "{}: one shaded sample of LEADR is worth this many samples of the reference: {}.",
        race.subject,
        worth.join(", ")
    )];
    if let [without, many] = &race.others[..] {
        findings.push(format!(
            "{}: rRMSE of LEADR is {}; {} without edge samples, {} with {} shaded samples and no edge samples.",
            race.subject,
            number(leadr.own.object),
            number(without.own.object),
            number(many.own.object),
            many.samples
        ));
    }
    if let (Some(judge), Some(faster)) = (race.judge(), race.faster) {
        findings.push(format!(
            "{}: {WORTH} samples of the reference take {} times as long.",
            race.subject,
            number(faster)
        ));
        // A picture with only silhouette pixels has no interior.
        if judge.own.interior > 0.0 {
            findings.push(format!(
                "{}: of the squared error inside with {WORTH} samples, {} are common to neighbouring pixels; compared with the rest alone, LEADR would be worth {} by rRMSE inside.",
                race.subject,
                percent((judge.common / judge.own.interior).powi(2), false),
                race.worth_apart,
            ));
        }
    }
    findings
}

fn bumps_finding(races: &[&Race]) -> String {
    let parts: Vec<String> = races
        .iter()
        .map(|race| format!("{}: {} inside, {} in all", race.subject, race.worth[1].1, race.worth[0].1))
        .collect();
    format!("Worth of one sample by rRMSE, by bumps per pixel: {}.", parts.join("; "))
}

#[cfg(test)]
mod tests {
    use super::race::Pair;
    use super::worth::Worth;
    use super::*;
    use crate::report::verdict::Errors;

    fn row(samples: u32, error: f64, milliseconds: f64) -> Row {
        let errors = Errors { flip: error, rrmse: error, bias: 0.0 };
        let own = Pair { object: error, interior: error };
        let look = "a look".to_owned();
        Row { look, samples, edge_samples: 1, milliseconds, object: errors, interior: errors, own, common: 0.5 * error }
    }

    fn example(subject: &str, goal: bool, met: bool) -> Race {
        Race {
            subject: subject.to_owned(),
            goal,
            size: 24,
            bumps_per_pixel: None,
            converged_samples: 64,
            noise: Pair { object: 0.01, interior: 0.01 },
            leadr: row(1, 0.02, 1.0),
            others: vec![row(1, 0.03, 1.0), row(64, 0.01, 64.0)],
            references: vec![row(1, 0.2, 2.0), row(64, 0.04, 128.0)],
            worth: MEASURES.iter().map(|m| (m.name, Worth::Above(64.0))).collect(),
            worth_apart: Worth::Equal(33.0),
            faster: Some(128.0),
            met,
        }
    }

    #[test]
    fn goal_subjects_are_separated_from_harder_one() {
        let races = [example("ball", true, true), example("beast", true, false), example("stone", false, false)];
        let lines = verdict(&races.iter().collect::<Vec<_>>());
        assert_eq!(lines.len(), 2);
        assert!(lines[0].ends_with("its subjects: met by ball, missed by beast."), "{}", lines[0]);
        assert!(lines[1].ends_with("harder than the goal's: missed by stone."), "{}", lines[1]);
        assert_eq!(verdict(&[&races[0]]).len(), 1);
    }

    #[test]
    fn findings_report_shared_neighbours() {
        let findings = findings_of(&example("ball", true, true));
        assert_eq!(findings.len(), 4);
        assert!(findings[2].contains("128 times as long"), "{}", findings[2]);
        // The common half of the error is a quarter of the squared error.
        assert!(findings[3].contains("25.0 % are common") && findings[3].contains("worth 33.0"), "{}", findings[3]);
        let mut outline = example("ball", true, true);
        outline.references.iter_mut().for_each(|r| r.own.interior = f64::NAN);
        assert_eq!(findings_of(&outline).len(), 3);
    }
}
