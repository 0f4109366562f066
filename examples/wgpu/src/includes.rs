//! Flattens GLSL includes into one file, for compilers without `#include`.

use std::collections::HashSet;
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Returns the text of `file`, in which the content of a file replaces each `#include "NAME"`. Each file is included only once. Names are
/// relative to the including file. If there is no such file, they are relative to `root`, the folder that contains `leadr`.
///
/// # Errors
/// If a file cannot be read; the message names this file and the including file.
pub fn expand(root: &Path, file: &Path) -> Result<String, String> {
    let mut text = String::new();
    append(root, file, &mut HashSet::new(), &mut text)?;
    Ok(text)
}

fn append(root: &Path, file: &Path, seen: &mut HashSet<PathBuf>, text: &mut String) -> Result<(), String> {
    let fault = |error: std::io::Error| format!("{}: {error}", file.display());
    if !seen.insert(file.canonicalize().map_err(fault)?) {
        return Ok(());
    }
    for line in std::fs::read_to_string(file).map_err(fault)?.lines() {
        match included(line) {
            None => writeln!(text, "{line}").expect("a String takes all"),
            Some(name) => {
                let beside = file.with_file_name(name);
                let name = if beside.is_file() { beside } else { root.join(name) };
                append(root, &name, seen, text).map_err(|error| format!("{error} (in {})", file.display()))?;
            }
        }
    }
    Ok(())
}

/// Returns the file name that a line includes.
fn included(line: &str) -> Option<&str> {
    line.trim_start().strip_prefix("#include")?.trim().strip_prefix('"')?.strip_suffix('"')
}
