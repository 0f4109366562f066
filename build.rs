//! Build script of the programs: records the commit that they are built from.

use std::path::Path;
use std::process::Command;

fn main() {
    println!("cargo:rustc-env=LEADR_COMMIT={}", commit());
}

/// `LEADR_COMMIT` where that is set, otherwise what git answers, or `unknown`. `-dirty` marks a tree that differs from its
/// commit. Only release builds run this again whenever a source or the commit changes; others, which would be rebuilt after
/// every commit, say `-dev`: near there.
fn commit() -> String {
    println!("cargo:rerun-if-env-changed=LEADR_COMMIT");
    if let Some(given) = std::env::var("LEADR_COMMIT").ok().filter(|given| !given.is_empty()) {
        return given;
    }
    let git = |arguments: &[&str]| {
        let output = Command::new("git").args(arguments).output().ok()?;
        output.status.success().then(|| String::from_utf8_lossy(&output.stdout).trim().to_owned())
    };
    // A package unpacked inside somebody else's repository is none of its commits.
    let own = git(&["ls-files", "--error-unmatch", "Cargo.toml"]).is_some();
    let Some(commit) = git(&["rev-parse", "--short=12", "HEAD"]).filter(|_| own) else { return "unknown".to_owned() };
    if std::env::var("PROFILE").is_ok_and(|profile| profile == "release") {
        let head = git(&["symbolic-ref", "-q", "HEAD"]).unwrap_or_default();
        for file in ["HEAD", &head, "packed-refs"] {
            // Cargo reruns the script forever for a file that does not exist.
            if let Some(path) = git(&["rev-parse", "--git-path", file]).filter(|path| Path::new(path).is_file()) {
                println!("cargo:rerun-if-changed={path}");
            }
        }
        let Some(top) = git(&["rev-parse", "--show-toplevel"]) else { return commit + "-dirty" };
        for folder in ["src", "crates", "shaders-glsl"] {
            println!("cargo:rerun-if-changed={top}/{folder}");
        }
        let clean = git(&["status", "--porcelain", "--untracked-files=no"]).is_some_and(|changes| changes.is_empty());
        return if clean { commit } else { commit + "-dirty" };
    }
    commit + "-dev"
}
