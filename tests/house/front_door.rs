//! What a program that depends on the crate gets: the names it can use, and the crates that each feature brings.

use std::fs;
use std::path::Path;

/// About what one screen of rustdoc shows.
const MOST_NAMES: usize = 57;

/// What the mathematics, the maps and the models are built with; everything else comes with a feature. The JSON of models is worth no
/// feature: its parser builds in seconds, and whoever embeds the renderer wants to open models.
const ALWAYS_BUILT: [&str; 11] =
    ["bytemuck", "exr", "glam", "half", "image", "ktx2", "rayon", "rustfft", "serde", "serde_json", "thiserror"];

/// What a program that embeds the renderer must not have to build.
const COMMAND_ONLY: [&str; 5] = ["clap", "indicatif", "nv-flip", "tracing-subscriber", "winit"];

fn text_of(file: &str) -> String {
    fs::read_to_string(Path::new(env!("CARGO_MANIFEST_DIR")).join(file)).unwrap()
}

/// The lines of a table of Cargo.toml, without comments.
fn table<'a>(manifest: &'a str, name: &str) -> Vec<(&'a str, &'a str)> {
    let header = format!("[{name}]");
    let after = manifest.lines().skip_while(|line| *line != header).skip(1);
    let lines = after.take_while(|line| !line.starts_with('['));
    lines.filter_map(|line| line.split_once(" = ").filter(|_| !line.starts_with('#'))).collect()
}

/// The last names of the `pub use` trees of a source file, and the names of its `pub mod`s that are not hidden.
fn public_names(source: &str) -> Vec<String> {
    let mut names = Vec::new();
    let mut hidden = false;
    let mut tree = None::<String>;
    for line in source.lines().map(str::trim).filter(|line| !line.starts_with("//")) {
        if let Some(open) = &mut tree {
            open.push_str(line);
        } else if let Some(start) = line.strip_prefix("pub use ") {
            tree = Some(start.to_owned());
        } else if let Some(module) = line.strip_prefix("pub mod ") {
            if !hidden {
                names.push(module.trim_end_matches([';', '{', ' ']).to_owned());
            }
            hidden = false;
        } else if line == "#[doc(hidden)]" {
            hidden = true;
        }
        if let Some(whole) = tree.take_if(|tree| tree.ends_with(';')) {
            names.extend(leaves(whole.trim_end_matches(';')));
        }
    }
    names
}

fn leaves(tree: &str) -> Vec<String> {
    let pieces = tree.split(['{', '}', ',']).map(str::trim).filter(|piece| !piece.is_empty() && !piece.ends_with("::"));
    pieces.map(|piece| piece.rsplit([':', ' ']).next().unwrap_or(piece).to_owned()).collect()
}

#[test]
fn the_front_door_fits_on_a_screen() {
    let names = public_names(&text_of("src/lib.rs"));
    for wanted in ["Renderer", "RenderSettings", "Camera", "Object", "reflectance", "maps"] {
        assert!(names.iter().any(|name| name == wanted), "{wanted} is not among {names:?}");
    }
    for private in ["gpu", "render", "scenes", "lab", "app"] {
        assert!(!names.iter().any(|name| name == private), "{private} is open to everybody");
    }
    assert!(names.len() <= MOST_NAMES, "{} names are more than {MOST_NAMES}: {names:?}", names.len());
    println!("{} names: {}", names.len(), names.join(" "));
}

#[test]
fn names_are_read_from_trees() {
    let source = "pub use a::{b::{C, D as E}, f::G};\n// pub use h::I;\n#[doc(hidden)]\npub mod j;\npub mod k {\n    pub use l::m;\n}";
    assert_eq!(public_names(source), ["C", "E", "G", "k", "m"]);
}

#[test]
fn the_mathematics_needs_no_vulkan_and_the_renderer_no_command() {
    let manifest = text_of("Cargo.toml");
    let dependencies = table(&manifest, "dependencies");
    let always: Vec<_> =
        dependencies.iter().filter(|(_, how)| !how.contains("optional = true")).map(|(name, _)| *name).collect();
    assert_eq!(always, ALWAYS_BUILT);
    for (name, how) in table(&manifest, "build-dependencies") {
        assert!(how.contains("optional = true"), "{name} is built for the mathematics too");
    }
    let features = table(&manifest, "features");
    let (_, renderer) = features.iter().find(|(name, _)| *name == "gpu").expect("a feature `gpu`");
    for name in COMMAND_ONLY {
        assert!(!renderer.contains(&format!("dep:{name}\"")), "the renderer brings {name}");
    }
}
