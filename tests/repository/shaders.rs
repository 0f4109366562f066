//! Shaders name their resources, and the include library stays free of bindings.

use std::fs;
use std::path::{Path, PathBuf};
use std::process::Command;
use std::sync::atomic::{AtomicUsize, Ordering};

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

/// The extensions of entry points, one per shader stage.
const STAGES: [&str; 5] = ["comp", "vert", "tesc", "tese", "frag"];

/// A tool's message about a file, if it refuses it.
fn refusal(command: &mut Command) -> Option<String> {
    let output =
        command.output().unwrap_or_else(|e| panic!("{:?}: {e} (`make setup` installs it)", command.get_program()));
    (!output.status.success())
        .then(|| [output.stdout, output.stderr].map(|text| String::from_utf8_lossy(&text).into_owned()).concat())
}

/// Compiles an entry point like another project, without this project's compiler. Includes are resolved below `library`.
fn glslang_refusal(entry: &Path, library: &Path, spirv: &Path) -> Option<String> {
    let mut compile = Command::new("glslangValidator");
    // Names instead of binding and location numbers: glslang assigns them.
    compile.args(["-V", "--target-env", "vulkan1.3", "--auto-map-bindings", "--auto-map-locations"]);
    refusal(compile.arg(format!("-I{}", library.display())).arg("-o").arg(spirv).arg(entry))
}

fn validator_refusal(spirv: &Path) -> Option<String> {
    refusal(Command::new("spirv-val").args(["--target-env", "vulkan1.3"]).arg(spirv))
}

#[test]
fn glslang_compiles_every_entry_point() {
    let library = root().join("shaders-glsl");
    let entries = files_under(&library, &STAGES);
    assert!(entries.len() > 100, "only {} entry points were found", entries.len());
    let folder = tempfile::tempdir().unwrap();
    let next = AtomicUsize::new(0);
    let work = |worker: usize| {
        let spirv = folder.path().join(format!("{worker}.spv"));
        let mut faults = Vec::new();
        while let Some(entry) = entries.get(next.fetch_add(1, Ordering::Relaxed)) {
            let fault = glslang_refusal(entry, &library, &spirv).or_else(|| validator_refusal(&spirv));
            faults.extend(fault.map(|fault| format!("{}: {fault}", entry.display())));
        }
        faults
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    let faults: Vec<String> = std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|worker| scope.spawn(move || work(worker))).collect();
        workers.into_iter().flat_map(|worker| worker.join().unwrap()).collect()
    });
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

/// A stage with another extension would be neither built nor compiled by the test above.
#[test]
fn every_shader_file_is_an_entry_point_or_an_include() {
    let all = files_under(&root().join("shaders-glsl"), &[&STAGES[..], &["glsl", "rs", "toml", "md"]].concat());
    let mut folders = vec![root().join("shaders-glsl")];
    while let Some(folder) = folders.pop() {
        for path in fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path()) {
            if path.is_dir() {
                folders.push(path);
            } else {
                assert!(all.contains(&path), "{}: no shader stage has this extension", path.display());
            }
        }
    }
}

/// Returns the macros that a shader's `#ifdef` lines test, and those that it defines without arguments. Include guards are `#ifndef`.
fn macros(source: &str) -> [Vec<&str>; 2] {
    let named = |directive: &str| -> Vec<&str> {
        let rest = source.lines().filter_map(|line| line.trim_start().strip_prefix(directive));
        rest.filter_map(|rest| rest.split_whitespace().next()).collect()
    };
    [named("#ifdef "), named("#define ")]
}

/// Code below `#ifdef` is compiled by the tests only if an entry point defines its macro.
#[test]
fn an_entry_point_defines_every_tested_macro() {
    let folder = root().join("shaders-glsl");
    let read = |file: &PathBuf| fs::read_to_string(file).unwrap();
    let entries: Vec<String> = files_under(&folder, &STAGES).iter().map(read).collect();
    let includes: Vec<String> = files_under(&folder, &["glsl"]).iter().map(read).collect();
    let defined: Vec<&str> = entries.iter().flat_map(|source| macros(source)[1].clone()).collect();
    let tested: Vec<&str> = includes.iter().chain(&entries).flat_map(|source| macros(source)[0].clone()).collect();
    // The stages of OpenGL ES are in the tests of examples/wgpu.
    let never: Vec<&str> = tested.iter().copied().filter(|name| *name != "GL_ES" && !defined.contains(name)).collect();
    assert!(tested.contains(&"LEADR_CLASS_OPENNESS") && never.is_empty(), "no entry point defines {never:?}");
    assert_eq!(macros("#ifdef A // b\n  #define B\n#define C 2"), [vec!["A"], vec!["B", "C"]]);
}

#[test]
fn a_shader_without_its_extension_or_with_a_wrong_type_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let (entry, spirv) = (folder.path().join("a.comp"), folder.path().join("a.spv"));
    let refused = |source: &str| {
        fs::write(&entry, source).unwrap();
        glslang_refusal(&entry, &root().join("shaders-glsl"), &spirv)
    };
    let with_include = "#include \"leadr/constants.glsl\"\n";
    let extension = "#extension GL_GOOGLE_include_directive : require\n";
    let start = "layout(local_size_x = 1) in;\nvoid main()";
    let error = refused(&format!("#version 460\n{with_include}{start} {{}}\n")).expect("refused");
    assert!(error.contains("GL_GOOGLE_include_directive"), "{error}");
    let error = refused(&format!("#version 460\n{extension}{with_include}{start} {{ int i = 0.5; }}\n"));
    assert!(error.as_ref().is_some_and(|error| error.contains("a.comp:5")), "{error:?}");
    assert_eq!(refused(&format!("#version 460\n{extension}{with_include}{start} {{}}\n")), None);
}

#[test]
fn spirv_with_too_small_a_bound_is_refused() {
    let folder = tempfile::tempdir().unwrap();
    let spirv = folder.path().join("a.spv");
    let library = root().join("shaders-glsl");
    assert_eq!(glslang_refusal(&library.join("passes/fullscreen.vert"), &library, &spirv), None);
    assert_eq!(validator_refusal(&spirv), None);
    // The bound of identifiers is the fourth word of a module.
    let mut module = fs::read(&spirv).unwrap();
    module[12..16].copy_from_slice(&2u32.to_le_bytes());
    fs::write(&spirv, module).unwrap();
    assert!(validator_refusal(&spirv).is_some_and(|error| error.contains("bound")), "{:?}", validator_refusal(&spirv));
}
