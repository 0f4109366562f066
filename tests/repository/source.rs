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
