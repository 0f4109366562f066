//! How files are laid out.

use crate::source::{files_under, root};

#[test]
fn a_module_with_a_folder_stands_in_it() {
    let files =
        files_under(&root().join("src"), &["rs"]).into_iter().chain(files_under(&root().join("tests"), &["rs"]));
    let faults: Vec<String> = files
        .filter(|file| file.with_extension("").is_dir())
        .map(|file| format!("{} belongs into its folder, as mod.rs", file.display()))
        .collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}
