//! Prints a file of the include library with all its includes expanded, for compilers without `#include`: `cargo run --example 17_one_file
//! -- shaders-glsl/leadr/shading.glsl > shading.glsl`.

#[path = "wgpu/src/includes.rs"]
mod includes;

use std::path::Path;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let file = std::env::args().nth(1).ok_or("give a file of shaders-glsl/leadr")?;
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("shaders-glsl");
    print!("{}", includes::expand(&root, Path::new(&file))?);
    Ok(())
}
