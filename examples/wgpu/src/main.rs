//! Draws the plane with a material filtered by `leadr bake`:
//!
//! ```sh
//! leadr bake assets/bricks -o bricks.ktx2
//! cargo run --release -p leadr-wgpu -- bricks.ktx2 bricks.png 960x540
//! ```
//!
//! An `.exr` picture contains linear radiance. A fourth argument writes the light as a panorama, so that other renderers can draw
//! the same scene.

use std::path::Path;
use std::process::ExitCode;

use leadr_wgpu::baked::Baked;
use leadr_wgpu::picture::draw;
use leadr_wgpu::view::View;

/// The number of rows of the light's panorama.
const LIGHT_ROWS: u32 = 512;

fn run(arguments: &[String]) -> Result<(), String> {
    let usage = "give a KTX2 file of leadr bake, a PNG or EXR output file, and optionally a size (640x360) and an EXR file for the light";
    let [baked, picture, rest @ ..] = arguments else { return Err(usage.into()) };
    let size = match rest {
        [] => [640, 360],
        [size] | [size, _] => {
            let sides = size.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
            sides.filter(|sides| sides.iter().all(|side| (1..=8192).contains(side))).ok_or(usage)?
        }
        _ => return Err(usage.into()),
    };
    let shaders = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders-glsl");
    let view = View::morning(size);
    let drawn = draw(&Baked::load(Path::new(baked))?, &view, &shaders)?;
    drawn.save(Path::new(picture), 0.8)?;
    println!("{picture}");
    if let [_, light] = rest {
        view.panorama(LIGHT_ROWS).save(Path::new(light), 1.0)?;
        println!("{light}");
    }
    Ok(())
}

fn main() -> ExitCode {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    match run(&arguments) {
        Ok(()) => ExitCode::SUCCESS,
        Err(error) => {
            eprintln!("leadr-wgpu: {error}");
            ExitCode::FAILURE
        }
    }
}
