//! How the window was left: its size, the panel and its sections.

use std::collections::BTreeMap;
use std::io::ErrorKind;
use std::ops::RangeInclusive;
use std::path::{Path, PathBuf};

use serde::{Deserialize, Serialize};

use leadr_maps::cache::user_folder;
use leadr_maps::new_file::write_atomic;
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::make_folder_of;

/// Points along a side of a window that is opened again.
const SIDES: RangeInclusive<u32> = 64..=16_384;
/// Bytes of a file that may be a layout.
const MOST_BYTES: u64 = 64 * 1024;

/// What of a window is the same when it opens again.
#[derive(Clone, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
#[serde(deny_unknown_fields)]
pub struct Layout {
    /// Width and height in points, 64 to 16384.
    pub size: Option<[u32; 2]>,
    /// Whether the panel is shown.
    pub panel: Option<bool>,
    /// Which of its sections are open, by their titles; the others are as usual.
    #[serde(default)]
    pub sections: BTreeMap<String, bool>,
}

impl Layout {
    /// Where it is kept: `$XDG_CONFIG_HOME/leadr/window.json`, or else below `~/.config`; `None` without either.
    pub fn file() -> Option<PathBuf> {
        user_folder("XDG_CONFIG_HOME", ".config").map(|folder| folder.join("window.json"))
    }

    /// What a file says; the usual layout if there is none.
    pub fn read(path: &Path) -> Result<Self, AppError> {
        let fault = |reason: String| {
            AppError::Failed(format!("'{}' is no layout of the window: {reason}; remove it", path.display()))
        };
        match std::fs::metadata(path) {
            Err(error) if error.kind() == ErrorKind::NotFound => return Ok(Self::default()),
            // Asked before reading: that would wait for the writer of a pipe.
            Ok(data) if !data.is_file() || data.len() > MOST_BYTES => return Err(fault("not a small file".to_owned())),
            _ => {}
        }
        let bytes = std::fs::read(path).map_err(|error| AppError::io("read", path, error))?;
        let layout: Self = serde_json::from_slice(&bytes).map_err(|error| fault(error.to_string()))?;
        match layout.size.filter(|size| !size.iter().all(|side| SIDES.contains(side))) {
            Some([width, height]) => {
                let (least, most) = SIDES.into_inner();
                Err(fault(format!("the size {width} x {height} is not within {least} and {most}")))
            }
            None => Ok(layout),
        }
    }

    /// Writes it to a file, all or nothing.
    pub fn write(&self, path: &Path) -> Result<(), AppError> {
        make_folder_of(path)?;
        let text = serde_json::to_string_pretty(self).map_err(|error| AppError::io("write", path, error))?;
        Ok(write_atomic(path, format!("{text}\n").as_bytes())?)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_layout_is_read_as_it_was_written_and_anything_else_is_refused() {
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
            let said = Layout::read(&path).unwrap_err().to_string();
            assert!(said.contains("window.json") && said.contains("remove it") && said.lines().count() == 1, "{said}");
        }
        assert!(Layout::read(folder.path()).is_err());
    }
}
