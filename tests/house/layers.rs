//! Dependencies only point down the floors, and the GLSL include library stays pure.
//!
//! Both checks read the sources as text, and each is shown to refuse what it should.

use std::fs;

use crate::source::{code_only, files_under, identifier, root, words};

/// The top-level modules and the floor each stands on. `maps` and `gpu` share one and may not use each other; nor may `models` use
/// `gpu`, which the next check holds it to.
const FLOORS: [(&str, u32); 9] = [
    ("reflectance", 1),
    ("maps", 2),
    ("gpu", 2),
    ("measured", 3),
    ("models", 3),
    ("render", 4),
    ("scenes", 5),
    ("lab", 6),
    ("app", 7),
];

/// Modules that stand lower but are none of a module's business.
const FORBIDDEN: [(&str, &str); 3] = [("models", "gpu"), ("measured", "gpu"), ("measured", "models")];

fn floor(module: &str) -> Option<u32> {
    FLOORS.iter().find(|(name, _)| *name == module).map(|&(_, floor)| floor)
}

/// What follows a `::` of the crate root: one name, the names of a `{…}` group, or `*`.
fn names_after(text: &str) -> Vec<&str> {
    let text = text.trim_start();
    if text.starts_with('*') {
        return vec!["*"];
    }
    let Some(group) = text.strip_prefix('{') else { return vec![identifier(text)] };
    let (mut depth, mut start, mut names) = (0, 0, Vec::new());
    for (i, c) in group.char_indices() {
        match c {
            '{' => depth += 1,
            '}' if depth > 0 => depth -= 1,
            ',' | '}' if depth == 0 => {
                let item = group[start..i].trim();
                if item.starts_with('*') {
                    names.push("*");
                } else if !item.is_empty() {
                    names.push(identifier(item));
                }
                start = i + 1;
                if c == '}' {
                    break;
                }
            }
            _ => {}
        }
    }
    names
}

/// Names that `source` takes from the crate root, each with its line. `depth` is the number of modules the file
/// is below the root, to see through `super::super::…`.
fn names_from_root(source: &str, depth: usize) -> Vec<(usize, String)> {
    let code = code_only(source);
    let mut found = Vec::new();
    for (start, word) in words(&code) {
        let after = &code[start + word.len()..];
        let tail = match word {
            "crate" | "leadr" => after.trim_start().strip_prefix("::"),
            "super" if !preceded_by_path(&code[..start]) => {
                let (mut supers, mut tail) = (1, after);
                while let Some(next) = tail.trim_start().strip_prefix("::").map(str::trim_start)
                    && identifier(next) == "super"
                {
                    supers += 1;
                    tail = &next["super".len()..];
                }
                // An inline module only adds depth: at or above the file's own, a floor's name can only be a floor.
                tail.trim_start().strip_prefix("::").filter(|_| supers >= depth)
            }
            _ => None,
        };
        let line = code[..start].matches('\n').count() + 1;
        if let Some(tail) = tail {
            let names = names_after(tail).into_iter().filter(|name| word != "super" || floor(name).is_some());
            found.extend(names.map(|name| (line, name.to_owned())));
        }
    }
    found
}

fn preceded_by_path(before: &str) -> bool {
    before.trim_end().ends_with("::")
}

/// Every arrow from a file of `module` that does not point down, as sentences.
fn upward_arrows(module: &str, path: &str, source: &str, depth: usize) -> Vec<String> {
    let own = floor(module).unwrap_or_else(|| panic!("{path}: `{module}` stands on no floor; add it to FLOORS"));
    names_from_root(source, depth)
        .into_iter()
        .filter_map(|(line, name)| match floor(&name) {
            _ if name == module => None,
            Some(_) if FORBIDDEN.contains(&(module, &name)) => {
                Some(format!("{path}:{line}: `{module}` uses `{name}`, which it must not know"))
            }
            Some(other) if other < own => None,
            Some(other) => Some(format!("{path}:{line}: `{module}` (floor {own}) uses `{name}` (floor {other})")),
            None => Some(format!("{path}:{line}: `{module}` uses `{name}` of the crate root, which is on no floor")),
        })
        .collect()
}

#[test]
fn arrows_only_point_down() {
    let source_folder = root().join("src");
    let files = files_under(&source_folder, &["rs"]);
    let mut faults = Vec::new();
    let mut modules_seen = Vec::new();
    for file in &files {
        let relative = file.strip_prefix(&source_folder).unwrap();
        let parts: Vec<_> = relative.iter().map(|part| part.to_str().unwrap()).collect();
        let (module, depth) = match parts.as_slice() {
            // The front door and the program that goes through it.
            ["lib.rs" | "main.rs"] => continue,
            [file] => (file.trim_end_matches(".rs"), 1),
            [module, .., file] => (*module, parts.len() - usize::from(*file == "mod.rs")),
            [] => unreachable!("a file has a name"),
        };
        modules_seen.push(module.to_owned());
        let source = fs::read_to_string(file).unwrap();
        faults.extend(upward_arrows(module, &relative.display().to_string(), &source, depth));
    }
    for (module, _) in FLOORS {
        assert!(modules_seen.iter().any(|seen| seen == module), "no source of `{module}` was read");
    }
    assert!(faults.is_empty(), "arrows that do not point down:\n{}", faults.join("\n"));
}

#[test]
fn upward_and_sideways_arrows_are_refused() {
    let refused =
        |module: &str, source: &str, depth: usize| !upward_arrows(module, "test.rs", source, depth).is_empty();
    assert!(refused("gpu", "use crate::render::Frame;", 2));
    assert!(refused("gpu", "use crate::maps::Image;", 2), "maps and gpu may not use each other");
    assert!(refused("maps", "use crate::gpu::Device;", 2), "nor the other way round");
    assert!(refused("models", "use crate::gpu::Device;", 2), "models are read without a device");
    assert!(refused("maps", "use crate::models::Model;", 2));
    assert!(!refused("models", "use crate::maps::material::Material;", 2));
    assert!(refused("reflectance", "fn f() { crate::app::run() }", 2));
    assert!(refused("render", "use crate::{gpu::{Device, Image}, maps, scenes::trex};", 2));
    assert!(refused("render", "use crate::{\n    gpu::Device,\n    scenes,\n};", 2));
    assert!(refused("maps", "use super::super::render::patch;", 2));
    assert!(refused("maps", "use super::render::patch;", 1));
    assert!(refused("scenes", "use crate::*;", 2), "a glob hides what is used");
    assert!(refused("render", "use crate::helpers::x;", 2), "a name on no floor");
    assert!(refused("render", "let q = '\"'; let s = \"//\"; use crate::app::x; // \"", 2));

    assert!(!refused("render", "use crate::{gpu::{Device, Image}, maps};\nuse super::patch::Patch;", 2));
    assert!(!refused("render", "// use crate::app::x\n/* crate::scenes */ let s = \"crate::app\";", 2));
    assert!(!refused("scenes", "use crate::render::surfaces::patch_mesh::PatchMesh;", 2));
    assert!(!refused("maps", "use super::super::maps::x;", 2));
    assert!(!refused("app", "use leadr::maps::x;", 1));
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
