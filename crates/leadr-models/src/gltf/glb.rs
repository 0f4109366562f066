//! The GLB container, which has a 12-byte header, a JSON chunk, and an optional chunk with the first buffer.

use super::json::Read;
use super::log::Log;
use crate::fault::ModelFault;

const MAGIC: &[u8] = b"glTF";
const JSON: u32 = 0x4e4f_534a;
const BIN: u32 = 0x004e_4942;
const BYTE_ORDER_MARK: &[u8] = b"\xef\xbb\xbf";

pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    /// The first buffer, if the file is a GLB that contains it.
    pub(super) binary: Option<&'a [u8]>,
}

/// Opens a GLB or a plain JSON file as a container.
pub(super) fn open<'a>(bytes: &'a [u8], log: &Log) -> Read<Container<'a>> {
    if bytes.starts_with(MAGIC) {
        return open_binary(bytes, log);
    }
    let json = text(bytes, log)?;
    match json.trim_ascii_start().first() {
        None => Err(ModelFault::damaged("it is empty")),
        Some(b'{') => Ok(Container { json, binary: None }),
        Some(_) => Err(ModelFault::Unrecognised),
    }
}

/// Returns JSON text without a byte order mark and without zeros at its end.
fn text<'a>(bytes: &'a [u8], log: &Log) -> Read<&'a [u8]> {
    let mut text = bytes;
    if let Some(rest) = text.strip_prefix(BYTE_ORDER_MARK) {
        log.repair(ModelFault::damaged("its JSON starts with a byte order mark"), "the mark is ignored")?;
        text = rest;
    }
    let end = text.iter().rposition(|&byte| byte != 0 && !byte.is_ascii_whitespace()).map_or(0, |last| last + 1);
    if text[end..].contains(&0) {
        log.repair(ModelFault::damaged("its JSON ends in zero bytes"), "the zero bytes are ignored")?;
    }
    Ok(&text[..end])
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at.checked_add(4)?)?.try_into().ok()?))
}

fn open_binary<'a>(bytes: &'a [u8], log: &Log) -> Read<Container<'a>> {
    let short = || ModelFault::damaged("its header ends early");
    let version = word(bytes, 4).ok_or_else(short)?;
    let length = word(bytes, 8).ok_or_else(short)? as usize;
    if version != 2 {
        let what = format!("it is a GLB of version {version}");
        return Err(ModelFault::unsupported(what, "export it as glTF 2.0"));
    }
    // Bytes after the declared length are not part of the model.
    if length > bytes.len() {
        let fault = ModelFault::damaged(format!("its header declares {length} bytes, but it has {}", bytes.len()));
        log.repair(fault, "its parts are read as far as they are there")?;
    }
    let (mut json, mut binary, mut at, mut number) = (None, None, 12, 0);
    while let (Some(size), Some(kind)) = (word(bytes, at), word(bytes, at + 4)) {
        // A declared length that is too short may cut the buffer off.
        if number >= 2 && at >= length {
            break;
        }
        let start = at + 8;
        let end = start.saturating_add(size as usize);
        let body = &bytes[start..end.min(bytes.len())];
        if end > length.min(bytes.len()) {
            let fault = ModelFault::damaged(format!("chunk {number} ends early"));
            log.repair(fault, "it is read as far as it is there")?;
        }
        let misplaced = |what| log.repair(ModelFault::damaged(format!("chunk {number} is {what}")), "it is ignored");
        match (kind, number) {
            (JSON, 0) => json = Some(body),
            (JSON, _) => misplaced("a second JSON chunk")?,
            (_, 0) => return Err(ModelFault::damaged("chunk 0 is not the JSON, which must come first")),
            (BIN, 1) => binary = Some(body),
            (BIN, _) => misplaced("a buffer, which must be the second chunk")?,
            // Unknown chunk types are ignored.
            _ => {}
        }
        // Some writers count the padding of a chunk in its length, and others leave it out.
        let next = end.next_multiple_of(4);
        at = if end == next || matches!(word(bytes, end.saturating_add(4)), Some(JSON | BIN)) { end } else { next };
        number += 1;
    }
    let json = json.ok_or_else(|| ModelFault::damaged("it has no JSON"))?;
    Ok(Container { json: text(json, log)?, binary })
}
