//! The dialog that opens files: a path, and the entries of its folder.

use std::path::{Path, PathBuf};

use egui::Ui;

use super::facts::Request;
use super::overlay;
use leadr_tools::command::files::extension;

/// Extensions of the files that the window opens.
const KINDS: [&str; 5] = ["exr", "glb", "gltf", "hdr", "json"];
/// Maximum number of listed entries.
const MOST: usize = 500;

/// The state of the dialog.
#[derive(Debug, Default)]
pub struct FileDialog {
    /// The typed path: a file, or a folder and the first letters of its entries.
    path: String,
    /// Whether the dialog was shown before, because the field takes the focus only once.
    is_shown: bool,
    /// The entries of a folder, which are read when the folder changes.
    listed: Option<(PathBuf, Vec<Entry>)>,
}

/// An entry of a folder.
#[derive(Clone, Debug, PartialEq, Eq, PartialOrd, Ord)]
struct Entry {
    is_file: bool,
    name: String,
}

impl FileDialog {
    /// Shows the dialog and returns whether it stays open. A chosen file closes it.
    pub fn show(&mut self, ui: &Ui, left: f32, requests: &mut Vec<Request>) -> bool {
        let mut chosen = None;
        let open = overlay::window(ui, "Open a file (l)", left, |ui| {
            ui.label("A model (.glb, .gltf), an environment (.hdr, .exr) or a material (FIT.json, a folder):");
            let field = egui::TextEdit::singleline(&mut self.path).hint_text("path").desired_width(f32::INFINITY);
            let field = ui.add(field).on_hover_text("The path of the file or folder; press Enter to open it");
            let entered = field.lost_focus() && ui.input(|input| input.key_pressed(egui::Key::Enter));
            if !std::mem::replace(&mut self.is_shown, true) {
                field.request_focus();
            }
            let open = ui.button("open").on_hover_text("Open the file or the folder of a material").clicked();
            if (entered || open) && !self.path.is_empty() {
                chosen = Some(PathBuf::from(&self.path));
            }
            ui.separator();
            let (folder, start) = split(&self.path);
            for entry in self.entries(&folder).iter().filter(|entry| entry.name.starts_with(&start)) {
                let name = if entry.is_file { entry.name.clone() } else { format!("{}/", entry.name) };
                let what = if entry.is_file { "Open this file" } else { "Show this folder" };
                if ui.selectable_label(false, &name).on_hover_text(what).clicked() {
                    let path = if self.path.contains('/') { folder.join(&name) } else { PathBuf::from(&name) };
                    self.path = path.to_string_lossy().into_owned();
                    self.is_shown = false;
                    chosen = entry.is_file.then_some(path);
                }
            }
        });
        let stays = open && chosen.is_none();
        requests.extend(chosen.map(Request::Open));
        stays
    }

    /// Returns the folders and the files of known kinds in a folder, sorted; empty if the folder cannot be read.
    fn entries(&mut self, folder: &Path) -> Vec<Entry> {
        if self.listed.as_ref().is_none_or(|(known, _)| known != folder) {
            self.listed = Some((folder.to_owned(), read(folder)));
        }
        self.listed.as_ref().map(|(_, entries)| entries.clone()).unwrap_or_default()
    }
}

/// Splits a path into the folder to list and the first letters of its entries.
fn split(path: &str) -> (PathBuf, String) {
    match path.rsplit_once('/') {
        Some((folder, start)) => (PathBuf::from(format!("{folder}/")), start.to_owned()),
        None => (PathBuf::from("."), path.to_owned()),
    }
}

fn read(folder: &Path) -> Vec<Entry> {
    let entry = |entry: std::fs::DirEntry| {
        let (path, name) = (entry.path(), entry.file_name().into_string().ok()?);
        let is_file = !path.is_dir();
        let known = !is_file || extension(&path).is_some_and(|kind| KINDS.contains(&kind.as_str()));
        (known && !name.starts_with('.')).then_some(Entry { is_file, name })
    };
    let mut entries: Vec<Entry> =
        std::fs::read_dir(folder).into_iter().flatten().flatten().filter_map(entry).take(MOST).collect();
    entries.sort_unstable();
    entries
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn folders_and_known_files_are_listed() {
        let folder = tempfile::tempdir().unwrap();
        for name in ["b.glb", "a.HDR", "notes.txt", ".hidden.glb"] {
            std::fs::write(folder.path().join(name), "").unwrap();
        }
        std::fs::create_dir(folder.path().join("maps")).unwrap();
        let mut dialog = FileDialog::default();
        let names: Vec<String> = dialog.entries(folder.path()).into_iter().map(|entry| entry.name).collect();
        assert_eq!(names, ["maps", "a.HDR", "b.glb"]);
        assert!(dialog.entries(&folder.path().join("none")).is_empty());
        assert_eq!(split("models/sn"), ("models/".into(), "sn".to_owned()));
        assert_eq!(split("sn"), (".".into(), "sn".to_owned()));
        assert_eq!(split("/"), ("/".into(), String::new()));
    }
}
