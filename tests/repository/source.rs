//! Rust and GLSL sources as text: code without comments, words, and the paths in a Rust file.

use std::fs;
use std::path::{Path, PathBuf};

/// The repository root.
pub fn root() -> &'static Path {
    Path::new(env!("CARGO_MANIFEST_DIR"))
}

/// All files below a folder with one of these extensions, in order.
pub fn files_under(folder: &Path, extensions: &[&str]) -> Vec<PathBuf> {
    let mut files = Vec::new();
    let Ok(entries) = fs::read_dir(folder) else { return files };
    for entry in entries {
        let path = entry.expect("a readable folder").path();
        if path.is_dir() {
            files.extend(files_under(&path, extensions));
        } else if path.extension().is_some_and(|e| extensions.iter().any(|wanted| e == *wanted)) {
            files.push(path);
        }
    }
    files.sort();
    files
}

/// Lines of a Markdown text outside of fences.
pub fn prose(text: &str) -> impl Iterator<Item = (usize, &str)> {
    let mut fenced = false;
    text.lines().enumerate().filter(move |(_, line)| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        !fenced && !fence
    })
}

/// Blanks comments, strings and characters, keeping line breaks.
pub fn code_only(source: &str) -> String {
    let mut code = String::with_capacity(source.len());
    let mut rest = source;
    let keep_lines = |text: &str, code: &mut String| code.extend(text.chars().filter(|&c| c == '\n'));
    while let Some(c) = rest.chars().next() {
        let skipped = if rest.starts_with("//") {
            rest.find('\n').unwrap_or(rest.len())
        } else if rest.starts_with("/*") {
            rest.find("*/").map_or(rest.len(), |end| end + 2)
        } else if let Some(length) = character_length(rest) {
            length
        } else if c == '"' {
            let mut escaped = false;
            let end = rest[1..].find(|c| {
                let closes = c == '"' && !escaped;
                escaped = c == '\\' && !escaped;
                closes
            });
            end.map_or(rest.len(), |end| end + 2)
        } else {
            code.push(c);
            rest = &rest[c.len_utf8()..];
            continue;
        };
        keep_lines(&rest[..skipped], &mut code);
        code.push(' ');
        rest = &rest[skipped..];
    }
    code
}

/// Length of the character literal at the start of a text; `None` for a lifetime.
fn character_length(text: &str) -> Option<usize> {
    let inside = text.strip_prefix('\'')?;
    let first = inside.chars().next()?;
    let body = if first == '\\' { 1 + inside[1..].chars().next()?.len_utf8() } else { first.len_utf8() };
    inside[body..].starts_with('\'').then_some(body + 2)
}

/// The identifier at the start of a text.
pub fn identifier(text: &str) -> &str {
    &text[..text.find(|c: char| !c.is_alphanumeric() && c != '_').unwrap_or(text.len())]
}

/// The identifiers and keywords of some code, with their positions.
pub fn words(code: &str) -> impl Iterator<Item = (usize, &str)> {
    code.char_indices().filter_map(move |(i, c)| {
        let starts = (c.is_alphabetic() || c == '_')
            && !code[..i].chars().next_back().is_some_and(|p| p.is_alphanumeric() || p == '_' || p == '$');
        starts.then(|| (i, identifier(&code[i..])))
    })
}

/// The code of the product in a Rust file, without its unit tests. Tests that are files of their own are empty.
fn product_code(path: &Path, source: &str) -> String {
    if path.ends_with("tests.rs") || path.to_string_lossy().ends_with("_tests.rs") {
        return String::new();
    }
    code_only(source.split("mod tests {").next().unwrap_or_default())
}

/// Calls that panic if stderr or stdout is closed or full, or if the system refuses a thread, and calls that print foreign names raw.
const REFUSED: [(&str, &str); 7] = [
    ("println!", "writeln! and `command::output`"),
    ("print!", "write! and `command::output`"),
    ("eprintln!", "`command::output`"),
    ("eprint!", "`command::output`"),
    ("dbg!", "tracing::debug!"),
    ("thread::spawn(", "thread::Builder, which returns an error"),
    (".display()", "`leadr_maps::shown::shown_path`"),
];

fn refused_calls(code: &str) -> Vec<&'static str> {
    let starts = |at: usize| !code[..at].ends_with(|c: char| c.is_alphanumeric() || c == '_');
    let found = |call: &str| code.match_indices(call).any(|(at, _)| call.starts_with('.') || starts(at));
    REFUSED.iter().filter(|(call, _)| found(call)).map(|(call, _)| *call).collect()
}

#[test]
fn product_code_neither_panics_in_print_nor_shows_names_raw() {
    // These crates run in build scripts and tests.
    let others = ["crates/leadr-glsl", "crates/leadr-testing", "crates/leadr-shaderc-debian"];
    // This crate is below leadr-maps, and `command::output` shows its messages.
    let below = "crates/leadr-gpu";
    let mut folders: Vec<PathBuf> =
        fs::read_dir(root().join("crates")).unwrap().map(|entry| entry.unwrap().path().join("src")).collect();
    folders.push(root().join("src"));
    let mut faults = Vec::new();
    for file in folders.iter().flat_map(|folder| files_under(folder, &["rs"])) {
        let name = file.strip_prefix(root()).unwrap().to_string_lossy().into_owned();
        if others.iter().any(|other| name.starts_with(other)) {
            continue;
        }
        let code = product_code(&file, &fs::read_to_string(&file).unwrap());
        let refused = refused_calls(&code).into_iter();
        for call in refused.filter(|call| *call != ".display()" || !name.starts_with(below)) {
            let better = REFUSED.iter().find(|(refused, _)| *refused == call).unwrap().1;
            faults.push(format!("{name}: `{call}`; use {better}"));
        }
    }
    assert!(faults.is_empty(), "{}", faults.join("\n"));
}

#[test]
fn refused_calls_are_found_in_code_alone() {
    assert_eq!(refused_calls("eprintln!(x); a.display()"), ["eprintln!", ".display()"]);
    assert_eq!(refused_calls("std::thread::spawn(|| ())"), ["thread::spawn("]);
    assert!(refused_calls("my_println!(x)").is_empty());
    assert!(
        product_code(Path::new("a.rs"), "// println!\nlet a = \"println!\";\nmod tests { println!() }")
            .contains("let a")
    );
    assert!(refused_calls(&product_code(Path::new("a.rs"), "\"println!\" mod tests { println!() }")).is_empty());
}
