//! `leadr report`: the tables, pictures and plots of the papers, made again and taken further, on one page.
//!
//! Sections run one after another in a studio. Each is put aside as soon as it is made, for `--resume`; the page is
//! written only when the last of them has succeeded: pictures first, `report.json`, and `index.html` last, each beside its
//! place and renamed into it. A section that fails ends the command, and an older page stays as it was.

mod case;
mod facts;
mod html;
mod kept;
mod look;
mod plot;
mod sections;
mod studio;
mod subject;
mod truth;
mod verdict;

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::Serialize;

use self::facts::Facts;
use self::html::PageSection;
use self::kept::{Made, Origin};
use self::sections::SectionName;
use self::studio::Studio;
use super::cli::ReportArgs;
use super::error::AppError;
use super::output::Output;
use crate::gpu::{Gpu, GpuOptions};
use crate::maps::save::write_atomic;

pub use self::sections::SectionName as ReportSection;

/// What a report found, and where it is.
#[derive(Debug, Serialize)]
pub struct ReportSummary {
    command: &'static str,
    #[serde(flatten)]
    facts: Facts,
    sections: Vec<SectionSummary>,
    page: PathBuf,
}

/// One section of a [`ReportSummary`].
#[derive(Debug, Serialize)]
struct SectionSummary {
    name: &'static str,
    title: &'static str,
    seconds: f64,
    findings: Vec<String>,
}

impl fmt::Display for ReportSummary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        for section in &self.sections {
            writeln!(f, "{} ({:.0} s)", section.title, section.seconds)?;
            for finding in &section.findings {
                writeln!(f, "  - {finding}")?;
            }
        }
        write!(f, "{}", self.page.display())
    }
}

/// Makes the report that `arguments` ask for and writes it.
///
/// # Errors
/// A folder that cannot be written, no device, a lost device, a section whose work fails (it is named); with
/// `--validation`, any validation message. Nothing is written then.
pub fn report(arguments: &ReportArgs, output: &Output) -> Result<ReportSummary, AppError> {
    let folder = &arguments.output;
    // Found out now, not after half an hour.
    std::fs::create_dir_all(folder).map_err(|e| AppError::io("make the folder", folder, e))?;
    let device = &arguments.device;
    let options = GpuOptions { device: device.device.clone(), validation: device.validation, ..Default::default() };
    let gpu = Gpu::new(&options)?;
    let facts = Facts::gather(&gpu, arguments.quick);
    let mut names = arguments.only.clone();
    names.sort_unstable();
    names.dedup();
    if names.is_empty() {
        names = SectionName::ALL.to_vec();
    }
    let mut studio = Studio::new(gpu.clone(), device.clone(), arguments.quick, *output);
    let origin = Origin::of(&facts);
    let mut made: Vec<Made> = Vec::new();
    for (index, &name) in names.iter().enumerate() {
        let place = format!("[{}/{}]", index + 1, names.len());
        // The worst of all pictures depend on what the others are: found anew, in no time.
        let again = arguments.resume && name != SectionName::Misses;
        if let Some(section) = again.then(|| kept::find(folder, &origin, name)).flatten() {
            output.say(&format!("{place} {}: kept from an earlier run", name.key()));
            studio.cases.extend(section.cases.iter().cloned());
            made.push(section);
            continue;
        }
        output.say(&format!("{place} {}", name.title()));
        let before = studio.cases.len();
        let start = Instant::now();
        let section = name.run(&mut studio).map_err(|e| AppError::Failed(format!("section {}: {e}", name.key())))?;
        if let Some(first) = gpu.take_validation_messages().first() {
            return Err(AppError::Failed(format!("section {}: Vulkan validation: {first}", name.key())));
        }
        let seconds = start.elapsed().as_secs_f64();
        output.say(&format!("{place} {}: {seconds:.0} s", name.key()));
        let (cases, pictures) = (studio.cases[before..].to_vec(), studio.take_pictures());
        let section = Made { name, section, seconds, cases, pictures };
        kept::keep(folder, &origin, &section)?;
        made.push(section);
    }
    write(folder, &facts, &made)?;
    let sections = made
        .into_iter()
        .map(|made| SectionSummary {
            name: made.name.key(),
            title: made.name.title(),
            seconds: made.seconds,
            findings: made.section.findings,
        })
        .collect();
    Ok(ReportSummary { command: "report", facts, sections, page: folder.join("index.html") })
}

/// Writes pictures, data and, last of all, the page that shows them.
fn write(folder: &Path, facts: &Facts, made: &[Made]) -> Result<(), AppError> {
    let mut pictures = BTreeMap::new();
    for (file, bytes) in made.iter().flat_map(|made| &made.pictures) {
        if pictures.insert(file, bytes).is_some() {
            return Err(AppError::Failed(format!("two pictures of the report are called {file}")));
        }
    }
    let place = folder.join(studio::PICTURES);
    std::fs::create_dir_all(&place).map_err(|e| AppError::io("make the folder", &place, e))?;
    for (file, bytes) in pictures {
        write_atomic(folder.join(file), bytes)?;
    }
    let data: serde_json::Map<String, serde_json::Value> = made
        .iter()
        .map(|made| {
            let section = serde_json::json!({
                "title": made.name.title(),
                "seconds": made.seconds,
                "findings": made.section.findings,
                "data": made.section.data,
            });
            (made.name.key().to_owned(), section)
        })
        .collect();
    let json = serde_json::json!({ "facts": facts, "sections": data });
    let json = serde_json::to_string_pretty(&json).map_err(|e| AppError::Failed(format!("cannot write JSON: {e}")))?;
    write_atomic(folder.join("report.json"), json.as_bytes())?;
    let sections: Vec<PageSection<'_>> = made
        .iter()
        .map(|made| PageSection { name: made.name.key(), title: made.name.title(), html: &made.section.html })
        .collect();
    let mut head = facts.rows();
    let seconds: f64 = made.iter().map(|made| made.seconds).sum();
    head.push(("took".to_owned(), format!("{:.1} minutes", seconds / 60.0)));
    let page = html::page("LEADR mapping: what was measured", &head, &sections);
    write_atomic(folder.join("index.html"), page.as_bytes())?;
    Ok(())
}
