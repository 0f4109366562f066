//! `leadr bake MODEL`: rewrites a glTF model with filtered textures.

use std::fmt;
use std::path::{Path, PathBuf};
use std::time::Instant;

use serde::Serialize;

use super::args::BakeArgs;
use super::textures::{TextureReport, engine_of, refuse_map_flags};
use leadr_maps::folders::OutsideLinks;
use leadr_maps::shown::shown_path;
use leadr_models::{Document, LoadOptions};
use leadr_textures::engine::Engine;
use leadr_textures::model::filter_model;
use leadr_tools::command::error::AppError;
use leadr_tools::command::files::{begin, extension, keep_inputs};
use leadr_tools::command::output::Output;

/// Filters the textures of a model, and prints what was filtered.
pub fn run(arguments: &BakeArgs, input: &Path, output: &Output) -> Result<(), AppError> {
    let start = Instant::now();
    refuse_map_flags(arguments, "models", &[])?;
    let engine = engine_of(arguments);
    let suffix = extension(&arguments.output);
    let in_files = match suffix.as_deref() {
        Some("gltf") => true,
        Some("glb") if engine != Engine::Godot => false,
        Some("glb") => {
            let what = "Godot makes new mip levels for the images of a .glb: name a .gltf";
            return Err(AppError::Usage(what.into()));
        }
        _ => {
            let what = format!("'{}' must end in .glb or .gltf for a model", shown_path(&arguments.output));
            return Err(AppError::Usage(what));
        }
    };
    // The file is opened first, so an unwritable folder is reported before any work.
    let file = begin(&arguments.output)?;
    let target = file.target().to_path_buf();
    keep_inputs([&*target], [input])?;
    let links = OutsideLinks::followed(arguments.follow_links);
    let document = Document::open(input, &LoadOptions { links, ..LoadOptions::default() });
    let document = document.map_err(|fault| AppError::Failed(fault.to_string()))?;
    let fault = |fault| AppError::Failed(format!("{} {fault}", shown_path(input)));
    let share = output.share(Some("filtering textures"));
    let filtered = filter_model(document, engine, &mut |done, all| share(done as f32 / all as f32)).map_err(fault)?;
    drop(share);
    for remark in &filtered.remarks {
        output.say(remark);
    }
    let (textures, remarks) = (filtered.textures.iter().map(TextureReport::new).collect(), filtered.remarks.clone());
    let mut files = vec![target.clone()];
    let bytes = if in_files {
        let name = target.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let mut parts = filtered.files(&name).map_err(fault)?;
        let bytes = parts.iter().map(|(_, bytes)| bytes.len() as u64).sum();
        let (_, model) = parts.pop().expect("a .gltf");
        let others: Vec<_> = parts.into_iter().map(|(name, bytes)| (target.with_file_name(name), bytes)).collect();
        keep_inputs(others.iter().map(|(path, _)| &**path), [input])?;
        for (path, bytes) in others {
            begin(&path)?.write(&bytes)?;
            files.push(path);
        }
        file.write(&model)?;
        bytes
    } else {
        let model = filtered.glb().map_err(fault)?;
        file.write(&model)?;
        model.len() as u64
    };
    output.result(&ModelReport {
        command: "bake",
        output: target,
        source: input.to_path_buf(),
        files,
        textures,
        remarks,
        bytes,
        seconds: start.elapsed().as_secs_f64(),
    })
}

/// The result for a model.
#[derive(Debug, Serialize)]
struct ModelReport {
    command: &'static str,
    output: PathBuf,
    source: PathBuf,
    /// The files that were written.
    files: Vec<PathBuf>,
    textures: Vec<TextureReport>,
    /// What is repaired or left as it is.
    remarks: Vec<String>,
    /// The size of all files together.
    bytes: u64,
    seconds: f64,
}

impl fmt::Display for ModelReport {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        self.textures.iter().try_for_each(|texture| writeln!(f, "{texture}"))?;
        let (path, size) = (shown_path(&self.output), self.bytes.div_ceil(1024));
        write!(f, "wrote {path}, {size} KiB in {:.1} s", self.seconds)?;
        match self.files.len() {
            0 | 1 => Ok(()),
            count => write!(f, ", with {} files beside it", count - 1),
        }
    }
}
