//! Reads the bytes of buffers and images from data URIs or external files.

use std::path::{Component, Path, PathBuf};

use super::json::{Location, Read};
use super::log::Log;
use crate::fault::{ModelFault, shown};
use leadr_maps::folders::OutsideLinks;
use leadr_maps::{MapFault, limits};

/// The model's folder.
#[derive(Clone, Copy)]
pub(super) struct Folder<'a> {
    pub(super) path: &'a Path,
    pub(super) links: OutsideLinks,
}

/// The contents of a URI, before files are read.
pub(super) enum Contents {
    Data(Vec<u8>),
    File(PathBuf),
}

/// Decodes a `data:` URI, or finds a file inside the model's folder.
///
/// Other schemes, absolute paths, `..` and links out of the folder are refused, because an untrusted model must not read other
/// files.
pub(super) fn find(uri: &str, folder: Option<Folder<'_>>, location: Location, log: &Log) -> Read<Contents> {
    if let Some(data) = uri.strip_prefix("data:") {
        return decode_data(data).map(Contents::Data).map_err(|what| location.fault(what));
    }
    let missing = |what: &str| missing(uri, location, what.to_owned());
    let (path, oddity) = relative_path(uri).map_err(missing)?;
    let folder = folder.ok_or_else(|| missing("cannot be found, because the model was not loaded from a folder"))?;
    if let Some(oddity) = oddity {
        log.repair(
            location.fault(format!("the file {:?} {oddity}", shown(uri))),
            "it is read as a path of this system",
        )?;
    }
    let outside = |fault| ModelFault::Outside { location: format!("{location}: the file {:?}", shown(uri)), fault };
    folder.links.check(folder.path, &path).map_err(outside)?;
    let file = folder.path.join(path);
    if !file.exists()
        && uri.contains('%')
        && let Ok(raw) = relative(uri)
        && folder.path.join(&raw).exists()
    {
        folder.links.check(folder.path, &raw).map_err(outside)?;
        let fault = location.fault(format!("the file {:?} has a name that is not percent-encoded", shown(uri)));
        log.repair(fault, "it is read as it is written")?;
        return Ok(Contents::File(folder.path.join(raw)));
    }
    Ok(Contents::File(file))
}

/// Fetches the first `most` bytes of what [`find`] returns.
pub(super) fn fetch(uri: &str, folder: Option<Folder<'_>>, location: Location, most: u64, log: &Log) -> Read<Vec<u8>> {
    match find(uri, folder, location, log)? {
        Contents::Data(mut bytes) => {
            bytes.truncate(usize::try_from(most).unwrap_or(usize::MAX));
            Ok(bytes)
        }
        Contents::File(file) => limits::read_start(&file, most).map_err(|fault| {
            let what = match fault {
                MapFault::Io { doing, source } => format!("{doing} ({source})"),
                MapFault::NotAFile => "is not a regular file".into(),
                MapFault::Unsupported { what, remedy } => {
                    let what = format!("{location}: the file \"{}\": {what}", shown(uri));
                    return ModelFault::Unsupported { what, remedy };
                }
                _ => "is too large".into(),
            };
            missing(uri, location, what)
        }),
    }
}

fn missing(uri: &str, location: Location, what: String) -> ModelFault {
    ModelFault::Missing { location: location.to_string(), uri: shown(uri), what }
}

/// Returns the path of a URI and what is unusual in it, or the reason why the URI is refused.
///
/// Exporters forget to encode `%`, and write backslashes between folders.
fn relative_path(uri: &str) -> Result<(PathBuf, Option<&'static str>), &'static str> {
    let decoded = percent_decoded(uri).and_then(|bytes| String::from_utf8(bytes).ok());
    let mut oddity = decoded.is_none().then_some("has a name that is not percent-encoded UTF-8");
    let mut text = decoded.unwrap_or_else(|| uri.to_owned());
    if text.contains('\\') {
        oddity = oddity.or(Some("has a backslash in its name"));
        text = text.replace('\\', "/");
    }
    Ok((relative(&text)?, oddity))
}

/// Returns the path of a file inside the folder, or the reason why the name is refused.
fn relative(name: &str) -> Result<PathBuf, &'static str> {
    let scheme = name.split_once(':').map(|(scheme, _)| scheme);
    if scheme.is_some_and(|s| !s.contains('/')) {
        return Err("has a scheme; only relative paths are supported");
    }
    if name.contains('\0') {
        return Err("has a name with a zero byte");
    }
    let path = PathBuf::from(name);
    if path.as_os_str().is_empty() {
        return Err("has no name");
    }
    if !path.components().all(|part| matches!(part, Component::Normal(_) | Component::CurDir)) {
        return Err("lies outside the model's folder; only files inside it may be read");
    }
    Ok(path)
}

fn percent_decoded(text: &str) -> Option<Vec<u8>> {
    let mut bytes = Vec::with_capacity(text.len());
    let mut rest = text.as_bytes();
    while let Some((&byte, after)) = rest.split_first() {
        rest = after;
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let digits = rest.get(..2)?;
        rest = &rest[2..];
        let [high, low] = [digits[0], digits[1]].map(|d| char::from(d).to_digit(16));
        bytes.push((high? * 16 + low?) as u8);
    }
    Some(bytes)
}

/// Decodes `TYPE;base64,DATA`, or percent-encoded `TYPE,DATA`.
fn decode_data(data: &str) -> Result<Vec<u8>, &'static str> {
    let (kind, text) = data.split_once(',').ok_or("its data URI has no comma")?;
    if kind.contains(";;") {
        return Err("its data URI has an empty part");
    }
    if kind.ends_with(";base64") {
        return decode_base64(text.as_bytes()).ok_or("its data URI is not valid base64");
    }
    percent_decoded(text).ok_or("its data URI is not percent-encoded")
}

/// Decodes RFC 4648 base64 with the standard alphabet and optional padding.
fn decode_base64(text: &[u8]) -> Option<Vec<u8>> {
    const NOT_A_DIGIT: u8 = 0xff;
    const DIGITS: [u8; 256] = {
        let alphabet = b"ABCDEFGHIJKLMNOPQRSTUVWXYZabcdefghijklmnopqrstuvwxyz0123456789+/";
        let mut digits = [NOT_A_DIGIT; 256];
        let mut i = 0;
        while i < alphabet.len() {
            digits[alphabet[i] as usize] = i as u8;
            i += 1;
        }
        digits
    };
    let padding = text.iter().rev().take_while(|&&c| c == b'=').count();
    if padding > 2 || (padding > 0 && !text.len().is_multiple_of(4)) {
        return None;
    }
    let text = &text[..text.len() - padding];
    let mut bytes = Vec::with_capacity(text.len() / 4 * 3 + 3);
    for group in text.chunks(4) {
        let mut sum = 0u32;
        for &c in group {
            let digit = DIGITS[c as usize];
            if digit == NOT_A_DIGIT {
                return None;
            }
            sum = sum << 6 | u32::from(digit);
        }
        let octets = (sum << (6 * (4 - group.len()))).to_be_bytes();
        match group.len() {
            4 => bytes.extend(&octets[1..4]),
            3 => bytes.extend(&octets[1..3]),
            2 => bytes.push(octets[1]),
            _ => return None,
        }
    }
    Some(bytes)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn base64_by_the_examples_of_its_standard() {
        let cases =
            [("", ""), ("Zg==", "f"), ("Zm8=", "fo"), ("Zm9v", "foo"), ("Zm9vYg==", "foob"), ("Zm9vYmFy", "foobar")];
        for (text, bytes) in cases {
            assert_eq!(decode_base64(text.as_bytes()).unwrap(), bytes.as_bytes());
        }
        assert_eq!(decode_base64(b"Zm8").unwrap(), b"fo");
        for wrong in ["Z", "Zg=", "Zg===", "Zm9v!g==", "Zm 9v", "=Zm9"] {
            assert!(decode_base64(wrong.as_bytes()).is_none(), "{wrong}");
        }
    }

    #[test]
    fn data_of_both_encodings() {
        assert_eq!(decode_data("application/octet-stream;base64,AAEC").unwrap(), [0, 1, 2]);
        assert_eq!(decode_data(",a%00%ff").unwrap(), [b'a', 0, 255]);
        for wrong in ["base64", ";;base64,AA==", ",%f", ",%+1"] {
            assert!(decode_data(wrong).is_err(), "{wrong}");
        }
    }

    #[test]
    fn only_names_inside_the_folder_are_paths() {
        let path = |uri: &str| relative_path(uri).map(|(path, oddity)| (path, oddity.is_some()));
        assert_eq!(path("a%20b/c.png").unwrap(), ("a b/c.png".into(), false));
        assert_eq!(path("./é.bin").unwrap(), ("./é.bin".into(), false));
        assert_eq!(path("maps\\50%.png").unwrap(), ("maps/50%.png".into(), true));
        let wrong = [
            "",
            "/etc/passwd",
            "../a",
            "a/../../b",
            "%2e%2e/a",
            "http://x/a",
            "file:a",
            "c:\\a",
            "a\\..\\..\\b",
            "a%00",
        ];
        for wrong in wrong {
            assert!(relative_path(wrong).is_err(), "{wrong}");
        }
    }
}
