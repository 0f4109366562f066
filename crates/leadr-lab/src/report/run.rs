//! Builds the report, section by section.
//!
//! Sections run one after another and are stored when finished, so an interrupted run can resume. The page is written only
//! after all sections succeed: pictures first, then `report.json`, then `index.html`. Each file gets its final name when it
//! is complete. If a section fails, the report ends and an older page stays in place.

use std::collections::BTreeMap;
use std::fmt;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::time::Instant;

use serde::Serialize;

use super::facts::Facts;
use super::kept::{self, Made, Origin};
use super::sections::{SECTIONS, SectionEntry};
use super::studio::Studio;
use leadr_gpu::Gpu;
use leadr_maps::new_file::{NewFile, remove_abandoned, write_atomic};
use leadr_maps::shown::shown_path;
use leadr_tools::command::output::Output;
use leadr_tools::error::LabError;
use leadr_tools::html::{PageSection, page};
use leadr_tools::program::Stamped;

/// The configuration of a report.
#[derive(Clone, Debug)]
pub struct ReportConfig {
    /// Whether to render small pictures with few samples.
    pub quick: bool,
    /// The sections to run. An empty list runs all sections.
    pub only: Vec<&'static SectionEntry>,
    /// Whether to reuse sections that an earlier run of this build on this device stored in the folder.
    pub resume: bool,
    /// The folder of the report.
    pub folder: PathBuf,
}

/// The findings and location of a report.
#[derive(Debug, Serialize)]
pub struct ReportSummary {
    command: &'static str,
    #[serde(flatten)]
    facts: Facts,
    sections: Vec<SectionSummary>,
    page: PathBuf,
}

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
        write!(f, "{}", shown_path(&self.page))
    }
}

/// Builds and writes the report. `open` opens the device, after the folder is known to be writable.
///
/// # Errors
/// Fails if the folder cannot be written, if the device is missing or lost, if a section fails (the error gives its name),
/// or if there is any validation message. After an error, the page is not written.
pub fn report(
    config: &ReportConfig,
    open: impl FnOnce() -> Result<Arc<Gpu>, LabError>,
    progress: &Output,
) -> Result<ReportSummary, LabError> {
    let folder = &config.folder;
    // An unwritable folder is reported now instead of after half an hour.
    let page_file = folder.join("index.html");
    remove_abandoned(&page_file);
    drop(NewFile::create(&page_file)?);
    let gpu = open()?;
    let facts = Facts::gather(&gpu, config.quick);
    let wanted = |entry: &&SectionEntry| config.only.is_empty() || config.only.iter().any(|only| only.key == entry.key);
    let entries: Vec<&'static SectionEntry> = SECTIONS.iter().filter(wanted).collect();
    let mut studio = Studio::new(gpu, config.quick, progress);
    let origin = Origin::of(&facts);
    let mut made: Vec<Made> = Vec::new();
    for (index, &entry) in entries.iter().enumerate() {
        let counter = format!("[{}/{}]", index + 1, entries.len());
        let again = config.resume && !entry.judges_others;
        if let Some(section) = again.then(|| kept::find(folder, &origin, entry)).flatten() {
            progress.say(&format!("{counter} {}: reused from an earlier run", entry.key));
            studio.cases.extend(section.cases.iter().cloned());
            made.push(section);
            continue;
        }
        progress.say(&format!("{counter} {}", entry.title));
        let section = make(entry, &mut studio)?;
        progress.say(&format!("{counter} {}: {:.0} s", entry.key, section.seconds));
        kept::keep(folder, &origin, &section)?;
        made.push(section);
    }
    write(folder, &facts, &made)?;
    let sections = made
        .into_iter()
        .map(|made| SectionSummary {
            name: made.entry.key,
            title: made.entry.title,
            seconds: made.seconds,
            findings: made.section.findings,
        })
        .collect();
    Ok(ReportSummary { command: "report", facts, sections, page: page_file })
}

fn make(entry: &'static SectionEntry, studio: &mut Studio) -> Result<Made, LabError> {
    let before = studio.cases.len();
    let start = Instant::now();
    let section = entry.run(studio);
    studio.end_section();
    let section = section.map_err(|e| LabError(format!("section {}: {e}", entry.key)))?;
    if let Some(first) = studio.gpu.take_validation_messages().first() {
        return Err(LabError(format!("section {}: Vulkan validation: {first}", entry.key)));
    }
    let seconds = start.elapsed().as_secs_f64();
    let (cases, pictures) = (studio.cases[before..].to_vec(), studio.take_pictures());
    Ok(Made { entry, section, seconds, cases, pictures })
}

/// Writes the pictures and the data, then the page.
fn write(folder: &Path, facts: &Facts, made: &[Made]) -> Result<(), LabError> {
    let mut pictures = BTreeMap::new();
    for (file, bytes) in made.iter().flat_map(|made| &made.pictures) {
        if pictures.insert(file, bytes).is_some() {
            return Err(LabError(format!("two pictures of the report are called {file}")));
        }
    }
    for (file, bytes) in pictures {
        write_atomic(folder.join(file), bytes)?;
    }
    let data: serde_json::Map<String, serde_json::Value> = made
        .iter()
        .map(|made| {
            let section = serde_json::json!({
                "title": made.entry.title,
                "seconds": made.seconds,
                "findings": made.section.findings,
                "data": made.section.data,
            });
            (made.entry.key.to_owned(), section)
        })
        .collect();
    let json = serde_json::json!({ "facts": facts, "sections": data });
    let json = serde_json::to_string_pretty(&Stamped::new(&json)).map_err(|e| LabError::json(&e))?;
    write_atomic(folder.join("report.json"), json.as_bytes())?;
    let sections: Vec<PageSection<'_>> = made
        .iter()
        .map(|made| PageSection { name: made.entry.key, title: made.entry.title, html: &made.section.html })
        .collect();
    let mut head = facts.rows();
    let seconds: f64 = made.iter().map(|made| made.seconds).sum();
    head.push(("took".to_owned(), format!("{:.1} minutes", seconds / 60.0)));
    let whole = page("LEADR mapping: measurements", &head, &sections);
    write_atomic(folder.join("index.html"), whole.as_bytes())?;
    Ok(())
}
