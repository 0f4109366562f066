//! Compiles entry points in a build script, and writes them as a table for the crate to include.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::Stage;
use crate::compiler::{Compiler, collect, slashes};

/// Compiles the entry points of `folders` below `root`, and writes `shaders.rs` into the build's output folder. The file has a static
/// `TABLE` of all entry points, sorted by name. Includes are resolved below `root`. Cargo watches the folders and the include library,
/// `leadr`, for changes.
///
/// # Errors
/// Fails if a file cannot be read or written, or does not compile. The error is the compiler's message, with file and line.
pub fn embed(root: &Path, folders: &[&str]) -> Result<(), String> {
    for watched in folders.iter().chain(&["leadr"]) {
        println!("cargo:rerun-if-changed={}", root.join(watched).display());
    }
    let out = PathBuf::from(std::env::var_os("OUT_DIR").ok_or("OUT_DIR is not set: call it in a cargo build script")?);
    let mut files = Vec::new();
    for folder in folders {
        collect(&root.join(folder), &mut files)?;
    }
    let mut names: Vec<String> =
        files.iter().map(|file| slashes(file.strip_prefix(root).expect("collected below the root"))).collect();
    names.sort();

    let mut table = format!(
        "use leadr_glsl::{{Shader, Stage}};\n\n/// Every entry point, sorted by name.\nstatic TABLE: [Shader; {}] = [\n",
        names.len()
    );
    let mut failures = String::new();
    for (name, compiled) in names.iter().zip(compile_all(root, &names)?) {
        match compiled {
            Ok(words) => {
                let binary = out.join(name.replace('/', "-") + ".spv");
                let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_ne_bytes()).collect();
                std::fs::write(&binary, bytes).map_err(|e| format!("{}: {e}", binary.display()))?;
                let stage = Stage::of(name.as_ref()).expect("collected by its stage");
                writeln!(table, "    Shader::new({name:?}, Stage::{stage:?}, include_bytes!({binary:?})),")
                    .expect("writing to a String cannot fail");
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

fn compile_all(root: &Path, names: &[String]) -> Result<Vec<Result<Vec<u32>, String>>, String> {
    let results = Mutex::new(names.iter().map(|_| None).collect::<Vec<_>>());
    let next = AtomicUsize::new(0);
    let work = || {
        let compiler = Compiler::new(root)?;
        while let Some((i, name)) = Some(next.fetch_add(1, Ordering::Relaxed)).and_then(|i| Some((i, names.get(i)?))) {
            let compiled = compiler.compile(name);
            results.lock().expect("no thread panics")[i] = Some(compiled);
        }
        Ok::<_, String>(())
    };
    let threads = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        let workers: Vec<_> = (0..threads).map(|_| scope.spawn(work)).collect();
        workers.into_iter().try_for_each(|worker| worker.join().expect("the compiler does not panic"))
    })?;
    let results = results.into_inner().expect("no thread panics");
    Ok(results.into_iter().map(|result| result.expect("every name was taken")).collect())
}
