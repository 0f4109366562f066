//! Compiles entry points in a build script, and writes them as a table for the crate to include.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};

use crate::Stage;
use crate::compiler::{Compiled, Compiler, collect, slashes};
use crate::reflect;

/// Compiles the entry points of `folders` below `root`, and writes `shaders.rs` into the folder for the build's output: a constant
/// `TABLE` of all of them, sorted by name. Includes are looked for below `root`. The folders are watched for
/// changes, and so is the include library, `leadr`.
///
/// # Errors
/// Files that cannot be read or written, and the compiler's messages, with file and line.
pub fn embed(root: &Path, folders: &[&str]) -> Result<(), String> {
    for watched in folders.iter().chain(&["leadr"]) {
        println!("cargo:rerun-if-changed={}", root.join(watched).display());
    }
    let out = PathBuf::from(std::env::var_os("OUT_DIR").ok_or("cargo sets OUT_DIR, and it is missing")?);
    let mut files = Vec::new();
    for folder in folders {
        collect(&root.join(folder), &mut files)?;
    }
    let mut names: Vec<String> =
        files.iter().map(|file| slashes(file.strip_prefix(root).expect("collected below the root"))).collect();
    names.sort();

    let mut table = String::from(
        "use leadr_glsl::{Aligned, Constant, ConstantKind, Member, Push, Resource, ResourceKind, Shader, Stage, Struct};\n\n\
         /// Every entry point, sorted by name.\nstatic TABLE: &[Shader] = &[\n",
    );
    let mut failures = String::new();
    for (name, compiled) in names.iter().zip(compile_all(root, &names)?) {
        match compiled {
            Ok(shader) => {
                let binary = out.join(name.replace('/', "-") + ".spv");
                std::fs::write(&binary, bytes(&shader.code)).map_err(|e| format!("{}: {e}", binary.display()))?;
                entry(&mut table, name, Stage::of(name.as_ref()).expect("collected by its stage"), &binary, &shader);
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

/// Compiles the entry points side by side.
fn compile_all(root: &Path, names: &[String]) -> Result<Vec<Result<Compiled, String>>, String> {
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

fn bytes(words: &[u32]) -> Vec<u8> {
    words.iter().flat_map(|word| word.to_ne_bytes()).collect()
}

/// Writes an entry of the table.
fn entry(table: &mut String, name: &str, stage: Stage, binary: &Path, shader: &Compiled) {
    let Compiled { interface, .. } = shader;
    let mut line = |text: String| writeln!(table, "{text}").expect("a String takes all");
    line(format!("    Shader {{\n        name: {name:?}, stage: Stage::{stage:?},"));
    line(format!("        code: &Aligned(*include_bytes!({binary:?})).0, local_size: {:?},", interface.local_size));
    line("        resources: &[".to_owned());
    for reflect::Resource { name, kind, set, .. } in &interface.resources {
        line(format!("            Resource {{ name: {name:?}, kind: ResourceKind::{kind:?}, set: {set} }},"));
    }
    line("        ],\n        constants: &[".to_owned());
    for reflect::Constant { name, id, kind } in &interface.constants {
        line(format!("            Constant {{ name: {name:?}, id: {id}, kind: ConstantKind::{kind:?} }},"));
    }
    line("        ],".to_owned());
    let push = interface
        .push
        .as_ref()
        .map(|reflect::Push { block, bytes, .. }| format!("Push {{ block: {block:?}, bytes: {bytes} }}"));
    line(format!("        push: {},", push.map_or("None".to_owned(), |push| format!("Some({push})"))));
    line("        structs: &[".to_owned());
    for found in &interface.structs {
        line(format!("            Struct {{ name: {:?}, pitch: {:?}, members: &[", found.name, found.pitch));
        for reflect::Member { name, offset, size } in &found.members {
            line(format!("                Member {{ name: {name:?}, offset: {offset}, size: {size} }},"));
        }
        line("            ] },".to_owned());
    }
    line("        ],\n    },".to_owned());
}
