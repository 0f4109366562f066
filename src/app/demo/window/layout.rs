//! The stored layout of the window: its size, its panel, and the sections that are open.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use leadr_maps::cache::{UserFolder, user_folder};
use leadr_maps::new_file::write_atomic;
use leadr_maps::shown::shown_path;
use leadr_tools::command::error::AppError;

/// The valid side lengths of a stored window size, in points.
const SIDES: RangeInclusive<u32> = 64..=16_384;
/// The largest size of a layout file in bytes.
const MOST_BYTES: u64 = 64 * 1024;

/// The window layout that the next run restores.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Layout {
    /// The width and height of the window in points, 64 to 16384.
    pub size: Option<[u32; 2]>,
    /// Whether the panel is shown.
    pub panel: Option<bool>,
    /// Whether each section of the panel is open, by its title. A section that is not listed is in its default state.
    #[serde(default)]
    pub sections: BTreeMap<String, bool>,
}

impl Layout {
    /// Returns the path of the stored layout, `window.json` in the user's settings; `None` if that folder is unknown.
    pub fn file() -> Option<PathBuf> {
        user_folder(UserFolder::Settings).map(|folder| folder.join("window.json"))
    }

    /// Reads a layout. If there is no file, returns the default layout.
    pub fn read(path: &Path) -> Result<Self, AppError> {
        let fault = |reason: String| {
            AppError::Failed(format!("'{}' is not a valid window layout: {reason}; remove it", shown_path(path)))
        };
        match std::fs::metadata(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Self::default()),
            // Reading a pipe would block, so the file type is checked first.
            Ok(data) if !data.is_file() || data.len() > MOST_BYTES => {
                return Err(fault("it is not a file of at most 64 KiB".to_owned()));
            }
            _ => {}
        }
        let bytes = std::fs::read(path).map_err(|error| AppError::io("read", path, error))?;
        let layout: Self = serde_json::from_slice(&bytes).map_err(|error| fault(error.to_string()))?;
        match layout.size.filter(|size| !size.iter().all(|side| SIDES.contains(side))) {
            Some([width, height]) => {
                let (least, most) = SIDES.into_inner();
                Err(fault(format!("the size {width} x {height} is not between {least} and {most}")))
            }
            None => Ok(layout),
        }
    }

    /// Writes the layout to a file atomically.
    pub fn write(&self, path: &Path) -> Result<(), AppError> {
        let text = serde_json::to_string_pretty(self).map_err(|error| AppError::io("write", path, error))?;
        Ok(write_atomic(path, format!("{text}\n").as_bytes())?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn layout_round_trips_and_rejects_other_text() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("new/window.json");
        assert_eq!(Layout::read(&path).unwrap(), Layout::default());
        let sections = [("Light".to_owned(), false)].into();
        let layout = Layout { size: Some([800, 600]), panel: Some(true), sections };
        layout.write(&path).unwrap();
        assert_eq!(Layout::read(&path).unwrap(), layout);
        for wrong in [
            "",
            "{",
            "[]",
            r#"{"sizes": [800, 600]}"#,
            r#"{"size": [800, 600.5]}"#,
            r#"{"size": [0, 600]}"#,
            r#"{"size": [800, 99999]}"#,
            r#"{"panel": 1}"#,
            r#"{"sections": {"Light": "open"}}"#,
            &format!("{{}}{}", " ".repeat(MOST_BYTES as usize)),
        ] {
            std::fs::write(&path, wrong).unwrap();
            let message = Layout::read(&path).unwrap_err().to_string();
            assert!(
                message.contains("window.json") && message.contains("remove it") && message.lines().count() == 1,
                "{message}"
            );
        }
        assert!(Layout::read(folder.path()).is_err());
    }
}
