//! Compiles shader entry points to SPIR-V and checks their declarations.

use std::path::{Component, Path, PathBuf};

// This import links the archives that Debian's shaderc lacks.
use leadr_shaderc_debian as _;

use crate::{Stage, reflect};

/// Adds the entry points below `folder`. A folder that does not exist adds none.
///
/// # Errors
/// Fails if a folder cannot be read.
pub fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), String> {
    if !folder.is_dir() {
        return Ok(());
    }
    for entry in std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))? {
        let path = entry.map_err(|e| format!("{}: {e}", folder.display()))?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else if Stage::of(&path).is_some() {
            files.push(path);
        }
    }
    Ok(())
}

fn kind(stage: Stage) -> shaderc::ShaderKind {
    match stage {
        Stage::Vertex => shaderc::ShaderKind::Vertex,
        Stage::TessellationControl => shaderc::ShaderKind::TessControl,
        Stage::TessellationEvaluation => shaderc::ShaderKind::TessEvaluation,
        Stage::Fragment => shaderc::ShaderKind::Fragment,
        Stage::Compute => shaderc::ShaderKind::Compute,
    }
}

/// A compiler from GLSL files below a root folder to SPIR-V.
///
/// The optimiser is off, because it inlines every function. It makes modules three times as large, and takes ten times as long as the
/// translation. Drivers inline functions in any case.
pub struct Compiler {
    root: PathBuf,
    compiler: shaderc::Compiler,
    options: shaderc::CompileOptions<'static>,
}

impl Compiler {
    /// Creates a compiler for the files below `root`.
    ///
    /// # Errors
    /// Fails if shaderc cannot be started.
    pub fn new(root: &Path) -> Result<Self, String> {
        let failed = |e: shaderc::Error| format!("shaderc: {e}");
        let mut options = shaderc::CompileOptions::new().map_err(failed)?;
        options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_3 as u32);
        options.set_target_spirv(shaderc::SpirvVersion::V1_6);
        options.set_optimization_level(shaderc::OptimizationLevel::Zero);
        // Debug information preserves the names, by which all shared declarations are bound and checked.
        options.set_generate_debug_info();
        // The sources only name their resources. The pipelines assign the binding numbers.
        options.set_auto_bind_uniforms(true);
        options.set_warnings_as_errors();
        let folder = root.to_owned();
        options.set_include_callback(move |requested, kind, includer, _depth| {
            resolve_include(&folder, requested, kind, includer)
        });
        Ok(Self { root: root.to_owned(), compiler: shaderc::Compiler::new().map_err(failed)?, options })
    }

    /// Returns the SPIR-V of the entry point `name`, a path below the root.
    ///
    /// # Errors
    /// Returns the compiler's message, with file and line, or an error of [`interface`](reflect::interface).
    pub fn compile(&self, name: &str) -> Result<Vec<u32>, String> {
        let file = self.root.join(name);
        let shown =
            self.root.file_name().map_or_else(|| self.root.display().to_string(), |n| n.to_string_lossy().into());
        let source = std::fs::read_to_string(&file).map_err(|e| format!("{}: {e}", file.display()))?;
        let stage = Stage::of(&file)
            .ok_or_else(|| format!("{shown}/{name}: the file extension is not that of a shader stage"))?;
        let compiled = self
            .compiler
            .compile_into_spirv(&source, kind(stage), name, "main", Some(&self.options))
            .map_err(|e| e.to_string())?;
        let code = reflect::stripped(compiled.as_binary());
        reflect::interface(&code).map_err(|fault| format!("{shown}/{name}: {fault}"))?;
        Ok(code)
    }
}

/// Resolves an include. `#include "x"` is relative to the including file, or else to the root. `#include <x>` is relative to the root only.
fn resolve_include(
    root: &Path,
    requested: &str,
    kind: shaderc::IncludeType,
    includer: &str,
) -> Result<shaderc::ResolvedInclude, String> {
    let mut candidates = Vec::new();
    if matches!(kind, shaderc::IncludeType::Relative)
        && let Some(folder) = Path::new(includer).parent()
    {
        candidates.push(normal(&folder.join(requested)));
    }
    candidates.push(normal(Path::new(requested)));
    for candidate in &candidates {
        let path = root.join(candidate);
        if path.is_file() {
            let content = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            return Ok(shaderc::ResolvedInclude { resolved_name: slashes(candidate), content });
        }
    }
    Err(format!("{requested:?} exists neither beside {includer:?} nor below {}", root.display()))
}

/// Returns the path without `.` and `..`, so that all messages name a file in the same way.
pub fn normal(path: &Path) -> PathBuf {
    let mut result = PathBuf::new();
    for part in path.components() {
        match part {
            Component::CurDir => {}
            Component::ParentDir => {
                result.pop();
            }
            other => result.push(other),
        }
    }
    result
}

/// Returns the path with forward slashes, as in shader names.
pub fn slashes(path: &Path) -> String {
    path.to_string_lossy().replace('\\', "/")
}
