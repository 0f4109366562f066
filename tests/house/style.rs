//! How files are laid out, and that shaders name their resources.

use std::fs;

use crate::source::{code_only, files_under, root, words};

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

/// Places where GLSL numbers a binding. Numbers follow from names, so that no pass has to agree with its shader about them.
fn numbered_bindings(path: &str, source: &str) -> Vec<String> {
    let code = code_only(source);
    let numbered = words(&code).filter(|(_, word)| *word == "binding");
    numbered.map(|(at, _)| format!("{path}:{}", code[..at].matches('\n').count() + 1)).collect()
}

#[test]
fn shaders_number_no_bindings() {
    let folder = root().join("shaders-glsl");
    let files = files_under(&folder, &["glsl", "comp", "vert", "tesc", "tese", "frag"]);
    assert!(files.len() > 100, "only {} shaders were read", files.len());
    let faults: Vec<String> = files
        .iter()
        .flat_map(|file| numbered_bindings(&file.display().to_string(), &fs::read_to_string(file).unwrap()))
        .collect();
    assert!(faults.is_empty(), "bindings have names, not numbers:\n{}", faults.join("\n"));
}

#[test]
fn numbered_bindings_are_refused() {
    assert_eq!(numbered_bindings("x", "// binding = 1\nlayout(binding = 1) uniform sampler2D map;"), ["x:2"]);
    assert!(numbered_bindings("x", "layout(std430) readonly buffer Patches { uint patches[]; };").is_empty());
}
