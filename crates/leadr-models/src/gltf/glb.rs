//! The GLB container, which has a 12-byte header, a JSON chunk, and an optional chunk with the first buffer.

use super::json::Read;
use crate::fault::ModelFault;

const MAGIC: &[u8] = b"glTF";
const JSON: u32 = 0x4e4f_534a;
const BIN: u32 = 0x004e_4942;

pub(super) struct Container<'a> {
    pub(super) json: &'a [u8],
    /// The first buffer, if the file is a GLB that contains it.
    pub(super) binary: Option<&'a [u8]>,
}

/// Opens a GLB or a plain JSON file as a container.
pub(super) fn open(bytes: &[u8]) -> Read<Container<'_>> {
    if bytes.starts_with(MAGIC) {
        return open_binary(bytes);
    }
    let text = bytes.trim_ascii_start();
    if text.is_empty() || text.starts_with(b"\xef\xbb\xbf{") {
        let what = if text.is_empty() { "it is empty" } else { "its JSON starts with a byte order mark" };
        return Err(ModelFault::damaged(what));
    }
    if !text.starts_with(b"{") {
        return Err(ModelFault::Unrecognised);
    }
    Ok(Container { json: bytes, binary: None })
}

fn word(bytes: &[u8], at: usize) -> Option<u32> {
    Some(u32::from_le_bytes(bytes.get(at..at + 4)?.try_into().ok()?))
}

fn open_binary(bytes: &[u8]) -> Read<Container<'_>> {
    let short = || ModelFault::damaged("its header ends early");
    let version = word(bytes, 4).ok_or_else(short)?;
    let length = word(bytes, 8).ok_or_else(short)? as usize;
    if version != 2 {
        let what = format!("it is a GLB of version {version}");
        return Err(ModelFault::unsupported(what, "export it as glTF 2.0"));
    }
    // Bytes after the declared length are not part of the model.
    let Some(bytes) = bytes.get(..length) else {
        return Err(ModelFault::damaged(format!("its header declares {length} bytes, but it has {}", bytes.len())));
    };
    let (mut json, mut binary, mut at, mut number) = (None, None, 12, 0);
    while at < bytes.len() {
        let ends = || ModelFault::damaged(format!("chunk {number} ends early"));
        let size = word(bytes, at).ok_or_else(ends)? as usize;
        let kind = word(bytes, at + 4).ok_or_else(ends)?;
        let body = bytes.get(at + 8..).and_then(|rest| rest.get(..size)).ok_or_else(ends)?;
        let misplaced = |what| Err(ModelFault::damaged(format!("chunk {number} is {what}")));
        match (kind, number) {
            (JSON, 0) => json = Some(body),
            (JSON, _) => return misplaced("a second JSON chunk"),
            (_, 0) => return misplaced("not the JSON, which must come first"),
            (BIN, 1) => binary = Some(body),
            (BIN, _) => return misplaced("a buffer, which must be the second chunk"),
            // Unknown chunk types are ignored.
            _ => {}
        }
        at += 8 + size;
        number += 1;
    }
    let json = json.ok_or_else(|| ModelFault::damaged("it has no JSON"))?;
    Ok(Container { json, binary })
}
