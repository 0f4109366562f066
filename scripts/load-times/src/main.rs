//! Times how long a model takes to load, images decoded: `cargo run --release --manifest-path scripts/load-times/Cargo.toml -- FILE...`
//!
//! Both loaders read every file in turn; the least of many rounds counts.

use std::path::{Path, PathBuf};
use std::time::Instant;

use leadr_models::{LoadOptions, Model};

/// Rounds and seconds that a file gets at most.
const ROUNDS: u32 = 200;
const SECONDS: f64 = 4.0;

/// Reads every attribute and every index once: what a program does before it can draw.
fn with_the_crate(path: &Path) -> Result<usize, String> {
    let (document, buffers, images) = gltf::import(path).map_err(|error| error.to_string())?;
    let mut numbers = images.iter().map(|image| image.pixels.len()).sum();
    for primitive in document.meshes().flat_map(|mesh| mesh.primitives().collect::<Vec<_>>()) {
        let reader = primitive.reader(|buffer| Some(&buffers[buffer.index()]));
        numbers += reader.read_positions().map_or(0, |all| all.collect::<Vec<_>>().len());
        numbers += reader.read_normals().map_or(0, |all| all.collect::<Vec<_>>().len());
        numbers += reader.read_tex_coords(0).map_or(0, |all| all.into_f32().collect::<Vec<_>>().len());
        numbers += reader.read_joints(0).map_or(0, |all| all.into_u16().collect::<Vec<_>>().len());
        numbers += reader.read_weights(0).map_or(0, |all| all.into_f32().collect::<Vec<_>>().len());
        numbers += reader.read_indices().map_or(0, |all| all.into_u32().collect::<Vec<_>>().len());
    }
    for channel in document.animations().flat_map(|animation| animation.channels().collect::<Vec<_>>()) {
        let reader = channel.reader(|buffer| Some(&buffers[buffer.index()]));
        numbers += reader.read_inputs().map_or(0, |all| all.collect::<Vec<_>>().len());
    }
    Ok(numbers)
}

fn with_leadr(path: &Path) -> Result<usize, String> {
    let model = Model::load(path, LoadOptions::default()).map_err(|error| error.to_string())?;
    Ok(model.materials.len())
}

/// Milliseconds of the fastest of many rounds in turn.
fn least(path: &Path) -> Result<[f64; 2], String> {
    let (start, mut least) = (Instant::now(), [f64::INFINITY; 2]);
    for round in 0..ROUNDS {
        for (least, load) in least.iter_mut().zip([with_leadr, with_the_crate]) {
            let start = Instant::now();
            std::hint::black_box(load(path)?);
            *least = least.min(1e3 * start.elapsed().as_secs_f64());
        }
        if round > 2 && start.elapsed().as_secs_f64() > SECONDS {
            break;
        }
    }
    Ok(least)
}

fn main() {
    println!("| file | leadr, ms | crate gltf, ms | ratio |\n|---|---|---|---|");
    for path in std::env::args().skip(1).map(PathBuf::from) {
        let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
        match least(&path) {
            Ok([ours, theirs]) => println!("| {name} | {ours:.2} | {theirs:.2} | {:.2} |", ours / theirs),
            Err(fault) => println!("| {name} | {fault} | | |"),
        }
    }
}
