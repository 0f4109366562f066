//! `leadr bench`: the time of every pass on the device, or what many frames of the sea leave in memory.

pub mod args;

use self::args::BenchArgs;
use crate::app::error::AppError;
use crate::app::output::Output;
use crate::lab::bench::{BenchConfig, bench, soak};

/// Measures what the arguments ask for and prints it.
///
/// # Errors
/// Flags that contradict each other, wrong input files, no device, a device that fails.
pub fn run(arguments: &BenchArgs, output: &Output) -> Result<(), AppError> {
    let config = arguments.resolve()?;
    if let Some(frames) = arguments.soak {
        return run_soak(arguments, &config, frames, output);
    }
    let report = bench(&config, || Ok(arguments.device.open()?), output)?;
    output.result(&report)
}

fn run_soak(arguments: &BenchArgs, config: &BenchConfig, frames: u32, output: &Output) -> Result<(), AppError> {
    let [scene] = config.scenes.as_slice() else { return Err(AppError::Usage("--soak needs one --scene".into())) };
    if !scene.scene.has_sea {
        return Err(AppError::Usage(format!("--soak is for scenes with a sea, not {}", scene.scene.name)));
    }
    let report = soak(scene, &arguments.device.open()?, frames, arguments.technique, output)?;
    output.result(&report)
}
