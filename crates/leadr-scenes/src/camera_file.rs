//! Reads a camera from JSON: `{"position": [x, y, z], "target": [x, y, z], "up": [0, 0, 1], "fov_degrees": 40}`.
//!
//! Positions are in metres, with z up. `up` and `fov_degrees` are optional. The file is untrusted input.

use std::path::Path;

use serde_json::Value;

use crate::view::CameraPose;
use leadr_maps::MapFault;
use leadr_maps::limits::read_start;
use leadr_maps::shown::shown_path;

/// The largest accepted size of a camera file, in bytes.
const MAX_BYTES: u64 = 64 * 1024;
/// An example of a camera file, for error messages.
const EXAMPLE: &str = r#"{"position": [6, -8, 5], "target": [0, 0, 2]}"#;

/// Reads and checks a camera file.
///
/// # Errors
/// If the file cannot be read, is too long, is not JSON of the form in the module documentation, or holds no valid camera.
pub fn read(path: &Path) -> Result<CameraPose, String> {
    let bytes = read_start(path, MAX_BYTES + 1).map_err(|fault| match fault {
        MapFault::Io { doing, source } => format!("it {doing} ({source})"),
        MapFault::NotAFile => format!("it is not a regular file; give a JSON file such as {EXAMPLE}"),
        MapFault::Unsupported { what, remedy } => format!("{what}; {remedy}"),
        _ => too_long(),
    });
    bytes
        .and_then(|bytes| parse(&bytes))
        .map_err(|fault| format!("cannot read the camera '{}': {fault}", shown_path(path)))
}

fn too_long() -> String {
    format!("a camera file has at most {} KiB", MAX_BYTES / 1024)
}

/// Parses the content of a camera file.
///
/// # Errors
/// If the content is not a valid camera; the message gives the reason.
pub fn parse(bytes: &[u8]) -> Result<CameraPose, String> {
    if bytes.len() as u64 > MAX_BYTES {
        return Err(too_long());
    }
    // Some editors start the file with a byte order mark.
    let text = bytes.strip_prefix("\u{feff}".as_bytes()).unwrap_or(bytes);
    let value: Value = serde_json::from_slice(text).map_err(|e| {
        let location = format!("line {}, column {}", e.line(), e.column());
        let what = if e.is_eof() { "it ends too early, at" } else { "it is not valid JSON from" };
        format!("{what} {location}; an example is {EXAMPLE}")
    })?;
    let Some(camera) = value.as_object() else { return Err(format!("it is not a JSON object such as {EXAMPLE}")) };
    const FIELDS: [&str; 4] = ["position", "target", "up", "fov_degrees"];
    if let Some(odd) = camera.keys().find(|key| !FIELDS.contains(&key.as_str())) {
        return Err(format!("{odd:?} is not a field; the fields are {}", FIELDS.join(", ")));
    }
    let point = |name: &str| {
        let Some(value) = camera.get(name) else { return Ok(None) };
        let numbers: Option<Vec<f32>> =
            value.as_array().and_then(|array| array.iter().map(|v| v.as_f64().map(|v| v as f32)).collect());
        let point = numbers.and_then(|numbers| <[f32; 3]>::try_from(numbers).ok());
        point.map(Some).ok_or_else(|| format!("{name} must be three numbers, such as [6, -8, 5]"))
    };
    let required = |name: &str| point(name)?.ok_or_else(|| format!("it has no {name}; an example is {EXAMPLE}"));
    let (position, target) = (required("position")?, required("target")?);
    let up = point("up")?.unwrap_or_else(|| CameraPose::usual_up(position, target));
    let fov_degrees = match camera.get("fov_degrees") {
        None => CameraPose::FOV_DEGREES,
        Some(value) => value.as_f64().ok_or("fov_degrees must be a number, such as 40")? as f32,
    };
    let pose = CameraPose { position, target, up, fov_degrees };
    pose.check().map(|()| pose)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn up_and_field_of_view_may_be_left_out() {
        let pose = parse(br#"{"position": [0, -10, 3], "target": [0, 0, 3]}"#).unwrap();
        assert_eq!((pose.up, pose.fov_degrees), ([0.0, 0.0, 1.0], 35.0));
        for height in ["9", "-9"] {
            let text = format!(r#"{{"position": [0, 0, {height}], "target": [0, 0, 3]}}"#);
            assert_eq!(parse(text.as_bytes()).unwrap().up, [0.0, 1.0, 0.0], "straight down and up");
        }
    }

    #[test]
    fn byte_order_mark_is_accepted() {
        let text = "\u{feff}{\"position\": [0, -10, 3], \"target\": [0, 0, 3]}";
        assert_eq!(parse(text.as_bytes()).unwrap().position, [0.0, -10.0, 3.0]);
    }

    #[test]
    fn invalid_cameras_are_refused() {
        let cases = [
            ("", "ends too early"),
            (r#"{"position": [0, 0"#, "ends too early, at line 1"),
            ("camera", "not valid JSON from line 1"),
            ("[]", "not a JSON object"),
            (r#"{"position": [0, 0, 0]}"#, "no target"),
            (r#"{"position": [0, 0], "target": [0, 0, 3]}"#, "position must be three numbers"),
            (r#"{"position": "here", "target": [0, 0, 3]}"#, "position must be three numbers"),
            (r#"{"position": [0, 0, null], "target": [0, 0, 3]}"#, "position must be three numbers"),
            (r#"{"position": [0, 0, 3], "target": [0, 0, 3]}"#, "same point"),
            (r#"{"position": [0, 0, 9], "target": [0, 0, 3], "up": [0, 0, 1]}"#, "up must not"),
            (r#"{"position": [1, 0, 9], "target": [0, 0, 3], "up": [0, 0, 0]}"#, "no direction"),
            (r#"{"position": [1e39, 0, 9], "target": [0, 0, 3]}"#, "within"),
            (r#"{"position": [1e9, 0, 9], "target": [0, 0, 3]}"#, "within"),
            (r#"{"position": [1, 0, 9], "target": [0, 0, 3], "fov_degrees": 0}"#, "1 to 170"),
            (r#"{"position": [1, 0, 9], "target": [0, 0, 3], "fov_degrees": "wide"}"#, "fov_degrees must be a number"),
            (r#"{"position": [1, 0, 9], "target": [0, 0, 3], "fov": 40}"#, "\"fov\""),
        ];
        for (text, reason) in cases {
            let fault = parse(text.as_bytes()).expect_err(text);
            assert!(fault.contains(reason), "{text}: {fault}");
            for word in ["invalid type", "EOF", "expected", "unknown field", "f32"] {
                assert!(!fault.contains(word), "{text}: {fault}");
            }
        }
    }

    #[cfg(unix)]
    #[test]
    fn pipes_are_refused_without_waiting() {
        let folder = tempfile::tempdir().unwrap();
        let pipe = folder.path().join("pipe.json");
        assert!(std::process::Command::new("mkfifo").arg(&pipe).status().unwrap().success());
        let fault = read(&pipe).unwrap_err().to_string();
        assert!(fault.contains("pipe.json") && fault.contains("not a regular file"), "{fault}");
    }
}
