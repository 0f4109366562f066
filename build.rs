//! Compiles every shader entry point under `shaders-glsl/passes` and `shaders-glsl/probes` to SPIR-V and writes the table
//! that `gpu::shaders` embeds. Any error stops the build with the compiler's own message.

use std::fmt::Write as _;
use std::path::{Component, Path, PathBuf};

const ROOT: &str = "shaders-glsl";

pub fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed={ROOT}");
    println!("cargo:rustc-env=LEADR_COMMIT={}", commit());
    let out = PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    match build(&out) {
        Ok(()) => {}
        Err(report) => {
            eprintln!("{report}");
            std::process::exit(1);
        }
    }
}

/// The commit this is built from, for reports of measurements: `LEADR_COMMIT` where that is set, otherwise what git says,
/// or `unknown`. `-dirty` marks a tree that differs from its commit. Only release builds run this again whenever a
/// source or the commit changes; others, which would be rebuilt as a whole after every commit, say `-dev`: near there.
fn commit() -> String {
    println!("cargo:rerun-if-env-changed=LEADR_COMMIT");
    if let Some(given) = std::env::var("LEADR_COMMIT").ok().filter(|given| !given.is_empty()) {
        return given;
    }
    let git = |arguments: &[&str]| {
        let output = std::process::Command::new("git").args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    // A package unpacked inside somebody else's repository is none of its commits.
    let own = git(&["ls-files", "--error-unmatch", "build.rs"]).is_some();
    let Some(commit) = git(&["rev-parse", "--short=12", "HEAD"]).filter(|_| own) else { return "unknown".to_owned() };
    if std::env::var("PROFILE").is_ok_and(|profile| profile == "release") {
        let head = git(&["symbolic-ref", "-q", "HEAD"]).unwrap_or_default();
        for file in ["HEAD", &head, "packed-refs"] {
            // Cargo reruns the script forever for a file that does not exist.
            if let Some(path) = git(&["rev-parse", "--git-path", file]).filter(|path| Path::new(path).is_file()) {
                println!("cargo:rerun-if-changed={path}");
            }
        }
        println!("cargo:rerun-if-changed=src");
        let clean = git(&["status", "--porcelain", "--untracked-files=no"]).is_some_and(|changes| changes.is_empty());
        return if clean { commit } else { commit + "-dirty" };
    }
    commit + "-dev"
}

fn build(out: &Path) -> Result<(), String> {
    let mut files = Vec::new();
    for folder in ["passes", "probes"] {
        collect(&Path::new(ROOT).join(folder), &mut files)?;
    }
    files.sort();

    let compiler = shaderc::Compiler::new().map_err(|e| format!("shaderc: {e}"))?;
    let mut options = shaderc::CompileOptions::new().map_err(|e| format!("shaderc: {e}"))?;
    options.set_target_env(shaderc::TargetEnv::Vulkan, shaderc::EnvVersion::Vulkan1_3 as u32);
    options.set_target_spirv(shaderc::SpirvVersion::V1_6);
    options.set_optimization_level(shaderc::OptimizationLevel::Performance);
    // Keeps OpName and OpMemberName, which reflection and the shared-struct test read.
    options.set_generate_debug_info();
    options.set_warnings_as_errors();
    options.set_include_callback(resolve_include);

    let mut table = String::from(
        "/// Name and SPIR-V of every entry point, sorted by name.\nstatic TABLE: &[(&str, &[u8])] = &[\n",
    );
    let mut failures = String::new();
    for file in &files {
        let name = slashes(file.strip_prefix(ROOT).expect("collected below the root"));
        match compile(&compiler, &options, file, &name) {
            Ok(spirv) => {
                let binary = out.join(name.replace('/', "-") + ".spv");
                std::fs::write(&binary, spirv).map_err(|e| format!("{}: {e}", binary.display()))?;
                writeln!(table, "    ({name:?}, &Aligned(*include_bytes!({binary:?})).0),")
                    .expect("a String takes all");
            }
            Err(message) => {
                failures.push_str(&message);
                failures.push('\n');
            }
        }
    }
    table.push_str("];\n");
    if !failures.is_empty() {
        return Err(failures);
    }
    std::fs::write(out.join("shaders.rs"), table).map_err(|e| format!("shaders.rs: {e}"))
}

/// Adds the entry points below `folder`; a folder that does not exist holds none.
fn collect(folder: &Path, files: &mut Vec<PathBuf>) -> Result<(), String> {
    if !folder.is_dir() {
        return Ok(());
    }
    for entry in std::fs::read_dir(folder).map_err(|e| format!("{}: {e}", folder.display()))? {
        let path = entry.map_err(|e| format!("{}: {e}", folder.display()))?.path();
        if path.is_dir() {
            collect(&path, files)?;
        } else if stage(&path).is_some() {
            files.push(path);
        }
    }
    Ok(())
}

fn stage(path: &Path) -> Option<shaderc::ShaderKind> {
    match path.extension()?.to_str()? {
        "vert" => Some(shaderc::ShaderKind::Vertex),
        "tesc" => Some(shaderc::ShaderKind::TessControl),
        "tese" => Some(shaderc::ShaderKind::TessEvaluation),
        "frag" => Some(shaderc::ShaderKind::Fragment),
        "comp" => Some(shaderc::ShaderKind::Compute),
        _ => None,
    }
}

fn compile(
    compiler: &shaderc::Compiler,
    options: &shaderc::CompileOptions<'_>,
    file: &Path,
    name: &str,
) -> Result<Vec<u8>, String> {
    let source = std::fs::read_to_string(file).map_err(|e| format!("{}: {e}", file.display()))?;
    let kind = stage(file).expect("collected by its stage");
    compiler
        .compile_into_spirv(&source, kind, name, "main", Some(options))
        .map(|artifact| artifact.as_binary_u8().to_vec())
        .map_err(|e| e.to_string())
}

/// `#include "x"` is looked for beside the including file, then below `shaders-glsl`; `#include <x>` only there.
fn resolve_include(
    requested: &str,
    kind: shaderc::IncludeType,
    includer: &str,
    _depth: usize,
) -> Result<shaderc::ResolvedInclude, String> {
    let mut candidates = Vec::new();
    if matches!(kind, shaderc::IncludeType::Relative)
        && let Some(folder) = Path::new(includer).parent()
    {
        candidates.push(normal(&folder.join(requested)));
    }
    candidates.push(normal(Path::new(requested)));
    for candidate in &candidates {
        let path = Path::new(ROOT).join(candidate);
        if path.is_file() {
            let content = std::fs::read_to_string(&path).map_err(|e| format!("{}: {e}", path.display()))?;
            return Ok(shaderc::ResolvedInclude { resolved_name: slashes(candidate), content });
        }
    }
    Err(format!("{requested:?} is neither beside {includer:?} nor below {ROOT}/"))
}

/// The path without `.` and `..`, so that one file has one name in messages.
fn normal(path: &Path) -> PathBuf {
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

fn slashes(path: &Path) -> String {
    path.to_string_lossy().replace('\\', "/")
}
