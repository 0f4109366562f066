//! Constants that shaders and Rust share. A build script generates Rust source from the GLSL declarations.

use std::fmt::Write as _;

/// The precision of floating-point constants in Rust.
#[derive(Clone, Copy)]
pub enum Floats {
    /// `f32`
    F32,
    /// `f64`
    F64,
}

/// Generates Rust source for the lines `const int PREFIX… = VALUE;` of a GLSL file, without the prefix.
///
/// # Errors
/// Fails if there is no such line, or if two have the same value.
pub fn enum_from_glsl(glsl: &str, prefix: &str) -> Result<String, String> {
    let start = format!("const int {prefix}");
    let mut rust = String::new();
    let mut values = Vec::new();
    for line in glsl.lines().filter_map(|line| line.strip_prefix(&start)) {
        let (name, rest) = line.split_once('=').ok_or_else(|| format!("{prefix}{line}: no value"))?;
        let value = rest.split(';').next().unwrap_or_default().trim();
        if values.contains(&value) {
            return Err(format!("two constants {prefix}… have the value {value}"));
        }
        values.push(value);
        writeln!(rust, "/// `{prefix}{0}`\npub const {0}: isize = {value};", name.trim())
            .expect("writing to a String cannot fail");
    }
    if values.is_empty() { Err(format!("no constant {prefix}…")) } else { Ok(rust) }
}

/// Generates Rust source for a GLSL file that contains only comments, preprocessor lines and `const TYPE NAME = VALUE;`. The
/// comments above a constant become its documentation.
///
/// # Errors
/// Returns the number and the text of the first line that has another form.
pub fn rust_from_glsl(glsl: &str, floats: Floats) -> Result<String, String> {
    let mut rust = String::new();
    let mut comments = Vec::new();
    for (i, line) in glsl.lines().enumerate() {
        let line = line.trim();
        if let Some(comment) = line.strip_prefix("//") {
            comments.push(comment.trim());
        } else if line.is_empty() || line.starts_with('#') {
            comments.clear();
        } else {
            let declaration = declaration(line, floats)
                .ok_or_else(|| format!("line {}: expected `const TYPE NAME = VALUE;`: {line}", i + 1))?;
            for comment in comments.drain(..) {
                writeln!(rust, "/// {comment}").expect("writing to a String cannot fail");
            }
            writeln!(rust, "{declaration}").expect("writing to a String cannot fail");
        }
    }
    Ok(rust)
}

fn declaration(line: &str, floats: Floats) -> Option<String> {
    let (declared, value) = line.strip_prefix("const ")?.strip_suffix(';')?.split_once('=')?;
    let (kind, name) = declared.trim().split_once(' ')?;
    let (kind, value) = match (kind, floats) {
        ("int", _) => ("i32", value.trim().to_owned()),
        ("uint", _) => ("u32", without_suffixes(value.trim())),
        ("bool", _) => ("bool", value.trim().to_owned()),
        ("float", Floats::F32) => ("f32", value.trim().to_owned()),
        ("float", Floats::F64) => ("f64", value.trim().to_owned()),
        ("vec3", Floats::F64) => ("glam::DVec3", value.trim().replace("vec3(", "glam::DVec3::new(")),
        ("vec3", Floats::F32) => ("glam::Vec3", value.trim().replace("vec3(", "glam::Vec3::new(")),
        _ => return None,
    };
    Some(format!("pub const {}: {kind} = {value};", name.trim()))
}

/// Returns the expression without GLSL's `u` suffixes. Spaces separate the words of the result.
fn without_suffixes(value: &str) -> String {
    let plain = |word: &str| match word.starts_with(|c: char| c.is_ascii_digit()) {
        true => word.trim_end_matches('u').to_owned(),
        false => word.to_owned(),
    };
    value.split_whitespace().map(plain).collect::<Vec<_>>().join(" ")
}
