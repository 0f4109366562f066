//! Compiles every shader entry point under `shaders-glsl/passes` and `shaders-glsl/probes` to SPIR-V, reads from it what
//! each declares, and writes both into the table that `gpu::shaders` embeds. Any error stops the build with the file's
//! name and the compiler's own message.

use std::fmt::Write as _;
use std::path::{Path, PathBuf};

use crate::compiler::{Compiled, Compiler, collect, slashes, stage};
use crate::reflect;

const ROOT: &str = "shaders-glsl";

/// Writes the table of shaders for this crate, or stops the build.
pub fn run() {
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
    let own = git(&["ls-files", "--error-unmatch", "build/main.rs"]).is_some();
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

    let compiler = Compiler::new(Path::new(ROOT))?;
    let mut table = String::from("/// Every entry point, sorted by name.\nstatic TABLE: &[Shader] = &[\n");
    let mut failures = String::new();
    for file in &files {
        let name = slashes(file.strip_prefix(ROOT).expect("collected below the root"));
        match compiler.compile(&name) {
            Ok(shader) => {
                let binary = out.join(name.replace('/', "-") + ".spv");
                std::fs::write(&binary, &shader.code).map_err(|e| format!("{}: {e}", binary.display()))?;
                entry(&mut table, &name, stage(file).expect("collected by its stage").1, &binary, &shader);
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

/// Writes an entry of the table.
fn entry(table: &mut String, name: &str, stage: &str, binary: &Path, shader: &Compiled) {
    let Compiled { declared, used, .. } = shader;
    let mut line = |text: String| writeln!(table, "{text}").expect("a String takes all");
    line(format!("    Shader {{\n        name: {name:?}, stage: vk::ShaderStageFlags::{stage},"));
    line(format!("        code: &Aligned(*include_bytes!({binary:?})).0, local_size: {:?},", used.local_size));
    line("        resources: &[".to_owned());
    for resource in &declared.resources {
        let word = used.resources.iter().find(|known| known.name == resource.name).and_then(|known| known.binding_word);
        let (name, kind) = (&resource.name, resource.kind);
        line(format!("            Resource {{ name: {name:?}, kind: ResourceKind::{kind}, binding_word: {word:?} }},"));
    }
    line("        ],\n        constants: &[".to_owned());
    for reflect::Constant { name, id, kind } in &declared.constants {
        line(format!("            Constant {{ name: {name:?}, id: {id}, kind: ConstantKind::{kind} }},"));
    }
    line("        ],".to_owned());
    let push = declared.push.as_ref().map(|push| {
        let bytes = used.push.as_ref().map_or(0, |push| push.bytes);
        format!("Push {{ block: {:?}, bytes: {bytes} }}", push.block)
    });
    line(format!("        push: {},", push.map_or("None".to_owned(), |push| format!("Some({push})"))));
    line("        structs: &[".to_owned());
    for found in &declared.structs {
        line(format!("            Struct {{ name: {:?}, pitch: {:?}, members: &[", found.name, found.pitch));
        for reflect::Member { name, offset, size } in &found.members {
            line(format!("                Member {{ name: {name:?}, offset: {offset}, size: {size} }},"));
        }
        line("            ] },".to_owned());
    }
    line("        ],\n    },".to_owned());
}
