//! Stores finished sections next to the page, so that an interrupted run can resume.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use super::case::Case;
use super::facts::Facts;
use super::section::Section;
use super::sections::SectionEntry;
use super::studio::PICTURES;
use leadr_maps::limits::read_file;
use leadr_maps::new_file::write_atomic;
use leadr_tools::error::LabError;
use leadr_tools::program::build;

/// The name of the folder of the stored sections, which is inside the report's folder.
const FOLDER: &str = "kept";

/// A finished section with all its results.
#[derive(Debug)]
pub struct Made {
    /// The entry of the section in the list of sections.
    pub entry: &'static SectionEntry,
    /// The content of the section.
    pub section: Section,
    /// The time in seconds to build the section.
    pub seconds: f64,
    /// The comparisons of the section's pictures with the truth.
    pub cases: Vec<Case>,
    /// The pictures of the section: paths relative to the page, and PNG bytes.
    pub pictures: BTreeMap<String, Vec<u8>>,
}

/// The build, the device and the quick flag. Sections can share a page only if their origins are equal.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Origin {
    program: String,
    device: String,
    driver: String,
    quick: bool,
}

impl Origin {
    /// Returns the origin of a run with these facts.
    pub fn of(facts: &Facts) -> Self {
        Self { program: build(), device: facts.device.clone(), driver: facts.driver.clone(), quick: facts.quick }
    }
}

/// The content of the file of a stored section.
#[derive(Serialize, Deserialize)]
struct File {
    origin: Origin,
    section: Section,
    seconds: f64,
    cases: Vec<Case>,
    pictures: Vec<String>,
}

fn section_path(folder: &Path, entry: &SectionEntry) -> PathBuf {
    folder.join(FOLDER).join(entry.key).with_extension("json")
}

/// Stores a section. The pictures are written first, then the file that lists them.
///
/// # Errors
/// Fails if a file cannot be written.
pub fn keep(folder: &Path, origin: &Origin, made: &Made) -> Result<(), LabError> {
    for (file, bytes) in &made.pictures {
        write_atomic(folder.join(FOLDER).join(file), bytes)?;
    }
    let file = File {
        origin: origin.clone(),
        section: made.section.clone(),
        seconds: made.seconds,
        cases: made.cases.clone(),
        pictures: made.pictures.keys().cloned().collect(),
    };
    let json = serde_json::to_vec(&file).map_err(|e| LabError::json(&e))?;
    write_atomic(section_path(folder, made.entry), &json)?;
    Ok(())
}

/// Finds a section that an earlier run of the same origin has stored completely.
pub fn find(folder: &Path, origin: &Origin, entry: &'static SectionEntry) -> Option<Made> {
    let file: File = serde_json::from_slice(&read_file(&section_path(folder, entry)).ok()?).ok()?;
    let pictures = file.pictures.into_iter().map(|picture| {
        // Only names of pictures are read, and later written beside the page.
        picture.strip_prefix(PICTURES)?.strip_prefix('/').filter(|name| !name.contains(['/', '\\', '\0']))?;
        let bytes = read_file(&folder.join(FOLDER).join(&picture)).ok()?;
        Some((picture, bytes))
    });
    (file.origin == *origin).then_some(())?;
    Some(Made {
        entry,
        section: file.section,
        seconds: file.seconds,
        cases: file.cases,
        pictures: pictures.collect::<Option<_>>()?,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::verdict::{Anatomy, Errors};
    use leadr_tools::html::Html;

    #[test]
    fn kept_sections_are_found_by_origin() {
        let folder = tempfile::tempdir().unwrap();
        let folder = folder.path();
        let origin =
            Origin { program: "1 abc".to_owned(), device: "d".to_owned(), driver: "e".to_owned(), quick: true };
        let errors = Errors { flip: f64::NAN, rrmse: 0.3125, bias: -0.125 };
        let case = Case {
            section: "zoom".to_owned(),
            subject: "σ".to_owned(),
            look: "leadr".to_owned(),
            truth: "displacement".to_owned(),
            object: errors,
            interior: errors,
            anatomy: Anatomy { outline: 0.5, highlights: 0.25 },
            normal_map: None,
            noise: f64::NAN,
            figures: Vec::new(),
        };
        let mut html = Html::new();
        html.paragraph("a < b");
        let section = Section { html, data: serde_json::json!({ "a": [1, 2.5] }), findings: vec!["f".to_owned()] };
        let pictures = BTreeMap::from([("pictures/a.png".to_owned(), vec![1, 2, 3])]);
        let [zoom, spheres] = ["zoom", "spheres"].map(|key| SectionEntry::find(key).unwrap());
        let made = Made { entry: zoom, section, seconds: 2.5, cases: vec![case], pictures };
        assert!(find(folder, &origin, zoom).is_none(), "nothing is there yet");
        keep(folder, &origin, &made).unwrap();
        let found = find(folder, &origin, zoom).unwrap();
        assert_eq!(format!("{found:?}"), format!("{made:?}"), "NaN included");
        assert!(find(folder, &origin, spheres).is_none());
        for other in [
            Origin { program: "2".to_owned(), ..origin.clone() },
            Origin { device: "x".to_owned(), ..origin.clone() },
            Origin { driver: "x".to_owned(), ..origin.clone() },
            Origin { quick: false, ..origin.clone() },
        ] {
            assert!(find(folder, &other, zoom).is_none(), "{other:?}");
        }
        std::fs::remove_file(folder.join("kept/pictures/a.png")).unwrap();
        assert!(find(folder, &origin, zoom).is_none(), "a picture is missing");
    }
}
