//! Shaders name their resources, and the include library stays free of bindings.

use std::fs;
use std::path::Path;
use std::process::Command;

use crate::source::{code_only, files_under, root, words};

/// GLSL lines with binding numbers. Numbers are derived from names, so that passes and shaders need not agree on them.
fn numbered_bindings(path: &str, source: &str) -> Vec<String> {
    let code = code_only(source);
    let numbered = words(&code).filter(|(_, word)| *word == "binding");
    numbered.map(|(at, _)| format!("{path}:{}", code[..at].matches('\n').count() + 1)).collect()
}

#[test]
fn shaders_have_no_binding_numbers() {
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

/// Words that tie GLSL to one program's resources; pure functions need none of them.
const IMPURE_GLSL: [&str; 6] = ["binding", "uniform", "buffer", "layout", "shared", "push_constant"];

fn impure_glsl(path: &str, source: &str) -> Vec<String> {
    let code = code_only(source);
    let impure = words(&code).filter(|(_, word)| IMPURE_GLSL.contains(word));
    impure.map(|(at, word)| format!("{path}:{}: `{word}`", code[..at].matches('\n').count() + 1)).collect()
}

#[test]
fn the_glsl_include_library_has_no_bindings() {
    let folder = root().join("shaders-glsl/leadr");
    let files = files_under(&folder, &["glsl", "h", "comp", "vert", "frag", "tesc", "tese"]);
    assert!(!files.is_empty(), "no GLSL was read");
    let mut faults = Vec::new();
    for file in &files {
        faults.extend(impure_glsl(&file.display().to_string(), &fs::read_to_string(file).unwrap()));
    }
    assert!(faults.is_empty(), "shaders-glsl/leadr must be pure functions:\n{}", faults.join("\n"));
}

#[test]
fn glsl_with_a_binding_is_refused() {
    assert!(!impure_glsl("x", "layout(set = 0, binding = 1) uniform sampler2D map;").is_empty());
    assert!(!impure_glsl("x", "float f();\nuniform float scale;").is_empty());
    assert!(impure_glsl("x", "// a uniform distribution\nfloat f(in vec2 uniformity, out float layout_x);").is_empty());
}

/// A tool's message about a file, if it refuses it.
fn refusal(command: &mut Command) -> Option<String> {
    let output =
        command.output().unwrap_or_else(|e| panic!("{:?}: {e} (`make setup` installs it)", command.get_program()));
    (!output.status.success())
        .then(|| [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat())
}

/// Compiles an entry point like another project, without this project's compiler, and validates the result.
fn glslang_refusal(entry: &Path, spirv: &Path) -> Option<String> {
    let mut compile = Command::new("glslangValidator");
    // Names instead of binding and location numbers: glslang assigns them.
    compile.args(["-V", "--target-env", "vulkan1.3", "--auto-map-bindings", "--auto-map-locations"]);
    compile.arg(format!("-I{}", root().join("shaders-glsl").display())).arg("-o").arg(spirv).arg(entry);
    refusal(&mut compile).or_else(|| refusal(Command::new("spirv-val").args(["--target-env", "vulkan1.3"]).arg(spirv)))
}

#[test]
#[ignore = "long"]
fn glslang_compiles_every_entry_point() {
    let entries = files_under(&root().join("shaders-glsl"), &["comp", "vert", "tesc", "tese", "frag"]);
    assert!(entries.len() > 100, "only {} entry points were found", entries.len());
    let folder = tempfile::tempdir().unwrap();
    let spirv = folder.path().join("entry.spv");
    let faults: Vec<String> = entries.iter().filter_map(|entry| glslang_refusal(entry, &spirv)).collect();
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn an_include_without_its_extension_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let entry = folder.path().join("a.comp");
    fs::write(&entry, "#version 460\n#include \"leadr/constants.glsl\"\nvoid main() {}\n").unwrap();
    let refused = glslang_refusal(&entry, &folder.path().join("a.spv")).expect("refused");
    assert!(refused.contains("GL_GOOGLE_include_directive"), "{refused}");
}
