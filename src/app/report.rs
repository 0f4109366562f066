//! `leadr report`: the tables, pictures and plots of the papers, made again and taken further, on one page.
//!
//! Sections run one after another in a studio; everything they make is kept in memory and written
//! only when the last of them has succeeded: pictures first, `report.json`, and `index.html` last, each beside its
//! place and renamed into it. A section that fails ends the command, and an older report stays as it was.

mod case;
mod facts;
mod html;
mod look;
mod plot;
mod sections;
mod studio;
mod subject;
mod truth;
mod verdict;

use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::Serialize;

use self::facts::Facts;
use self::html::PageSection;
use self::sections::{Section, SectionName};
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
    let mut made: Vec<(SectionName, Section, f64)> = Vec::new();
    for (index, &name) in names.iter().enumerate() {
        output.say(&format!("[{}/{}] {}", index + 1, names.len(), name.title()));
        let start = Instant::now();
        let section = name.run(&mut studio).map_err(|e| AppError::Failed(format!("section {}: {e}", name.key())))?;
        if let Some(first) = gpu.take_validation_messages().first() {
            return Err(AppError::Failed(format!("section {}: Vulkan validation: {first}", name.key())));
        }
        let seconds = start.elapsed().as_secs_f64();
        output.say(&format!("[{}/{}] {}: {seconds:.0} s", index + 1, names.len(), name.key()));
        made.push((name, section, seconds));
    }
    write(folder, &facts, &made, studio)?;
    let sections = made
        .into_iter()
        .map(|(name, section, seconds)| SectionSummary {
            name: name.key(),
            title: name.title(),
            seconds,
            findings: section.findings,
        })
        .collect();
    Ok(ReportSummary { command: "report", facts, sections, page: folder.join("index.html") })
}

/// Writes pictures, data and, last of all, the page that shows them.
fn write(folder: &Path, facts: &Facts, made: &[(SectionName, Section, f64)], studio: Studio) -> Result<(), AppError> {
    let pictures = studio.into_pictures();
    let place = folder.join(studio::PICTURES);
    std::fs::create_dir_all(&place).map_err(|e| AppError::io("make the folder", &place, e))?;
    for (file, bytes) in &pictures {
        write_atomic(folder.join(file), bytes)?;
    }
    let data: serde_json::Map<String, serde_json::Value> = made
        .iter()
        .map(|(name, section, seconds)| {
            let section = serde_json::json!({
                "title": name.title(),
                "seconds": seconds,
                "findings": section.findings,
                "data": section.data,
            });
            (name.key().to_owned(), section)
        })
        .collect();
    let json = serde_json::json!({ "facts": facts, "sections": data });
    let json = serde_json::to_string_pretty(&json).map_err(|e| AppError::Failed(format!("cannot write JSON: {e}")))?;
    write_atomic(folder.join("report.json"), json.as_bytes())?;
    let sections: Vec<PageSection<'_>> = made
        .iter()
        .map(|(name, section, _)| PageSection { name: name.key(), title: name.title(), html: &section.html })
        .collect();
    let page = html::page("LEADR mapping: what was measured", &facts.rows(), &sections);
    write_atomic(folder.join("index.html"), page.as_bytes())?;
    Ok(())
}
