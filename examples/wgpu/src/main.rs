//! Draws the plane in a material that `leadr bake` has filtered:
//!
//! ```sh
//! leadr bake assets/bricks -o bricks.ktx2
//! cargo run --release -p leadr-wgpu -- bricks.ktx2 bricks.png 960x540
//! ```

use std::path::Path;
use std::process::ExitCode;

use leadr_wgpu::baked::Baked;
use leadr_wgpu::picture::draw;
use leadr_wgpu::view::View;

fn run(arguments: &[String]) -> Result<(), String> {
    let usage = "give a KTX2 file of leadr bake, a PNG file to write, and a size such as 640x360 if you like";
    let [baked, picture, rest @ ..] = arguments else { return Err(usage.into()) };
    let size = match rest {
        [] => [640, 360],
        [size] => {
            let sides = size.split_once('x').and_then(|(w, h)| Some([w.parse().ok()?, h.parse().ok()?]));
            sides.filter(|sides| sides.iter().all(|side| (1..=8192).contains(side))).ok_or(usage)?
        }
        _ => return Err(usage.into()),
    };
    let shaders = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shaders-glsl");
    let drawn = draw(&Baked::load(Path::new(baked))?, &View::morning(size), &shaders)?;
    drawn.save(Path::new(picture), 0.8)?;
    println!("{picture}");
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
