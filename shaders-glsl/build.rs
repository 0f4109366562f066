//! Compiles the renderer's shaders, and generates Rust modules from the shared constants.

use std::path::Path;

use leadr_glsl::constants::{Floats, enum_from_glsl, rust_from_glsl};

fn main() {
    if let Err(fault) = constants().and_then(|()| leadr_glsl::embed(Path::new("."), &["passes"])) {
        eprintln!("{fault}");
        std::process::exit(1);
    }
}

fn constants() -> Result<(), String> {
    module("passes/constants.glsl", "constants", |glsl| rust_from_glsl(glsl, Floats::F32))?;
    module("passes/light/atmosphere.glsl", "atmosphere", |glsl| rust_from_glsl(glsl, Floats::F64))?;
    module("passes/shade/families.glsl", "families", |glsl| enum_from_glsl(glsl, "FAMILY_"))
}

/// Writes a Rust module with the constants of a GLSL file.
fn module(file: &str, name: &str, rust: impl Fn(&str) -> Result<String, String>) -> Result<(), String> {
    let glsl = std::fs::read_to_string(file).map_err(|e| format!("{file}: {e}"))?;
    let rust = rust(&glsl).map_err(|e| format!("{file}: {e}"))?;
    let out = std::env::var_os("OUT_DIR").ok_or("OUT_DIR is not set: run this as a cargo build script")?;
    std::fs::write(Path::new(&out).join(name).with_extension("rs"), rust).map_err(|e| format!("{name}.rs: {e}"))
}
