//! Generates the files of `assets/`: a material, an environment and an animated model.
//!
//! ```sh
//! cargo run --release --example 16_make_assets            # writes into assets/
//! cargo run --release --example 16_make_assets -- FOLDER
//! ```

mod bricks;
mod gltf;
mod morning;
mod noise;
mod png;
mod shell;
mod skin;
mod snail;
mod sweep;

use std::path::Path;

/// Returns the relative path and the content of every file.
fn files() -> Vec<(String, Vec<u8>)> {
    let mut files = Vec::new();
    files.extend(bricks::files());
    files.push(("morning_lake.hdr".into(), morning::file()));
    files.push(("snail.glb".into(), snail::file()));
    files
}

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let folder = std::env::args().nth(1).unwrap_or_else(|| "assets".into());
    for (name, bytes) in files() {
        let path = Path::new(&folder).join(name);
        std::fs::create_dir_all(path.parent().expect("it is in the folder"))?;
        std::fs::write(&path, &bytes)?;
        println!("{} {} bytes", path.display(), bytes.len());
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Every closed part of the model encloses a positive volume with counter-clockwise triangles, and there are no open parts.
    #[test]
    fn every_part_of_the_snail_is_closed_and_faces_outwards() {
        let mut parts = snail::parts();
        parts.sort_by(|a, b| b.volume.total_cmp(&a.volume));
        // Body, shell with its lid, four stalks and two eyes.
        assert_eq!(parts.len(), 8, "{parts:?}");
        assert!(parts.iter().all(|part| part.open_edges == 0 && part.volume > 1e-10), "{parts:?}");
        let bodies: Vec<f32> = parts.iter().take(2).map(|part| part.lowest).collect();
        assert!(bodies.iter().any(|lowest| lowest.abs() < 1e-4), "nothing stands on the ground: {parts:?}");
    }

    #[test]
    #[ignore = "long"]
    fn the_files_of_assets_are_those_that_this_makes() {
        let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("assets");
        for (name, bytes) in files() {
            let there = std::fs::read(folder.join(&name)).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert!(there == bytes, "{name} is outdated; run the example 16_make_assets");
        }
    }
}
