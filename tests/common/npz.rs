//! Reads the arrays of an `.npz` file: a zip archive of `.npy` files.

use std::collections::BTreeMap;
use std::path::PathBuf;

use half::f16;

/// The arrays of `LEADR_SHARED/oracles/<file>` that hold 16- or 32-bit floats, by name; `None`, and a line that says so,
/// where the variable is not set.
pub fn npz(file: &str) -> Option<BTreeMap<String, Vec<f32>>> {
    let Some(root) = std::env::var_os("LEADR_SHARED") else {
        println!("skipped: LEADR_SHARED is not set, so oracles/{file} cannot be found");
        return None;
    };
    let path = PathBuf::from(root).join("oracles").join(file);
    let bytes = std::fs::read(&path).unwrap_or_else(|e| panic!("{}: {e}", path.display()));
    Some(members(&bytes).into_iter().filter_map(|(name, data)| Some((name, array(&data)?))).collect())
}

/// Names (without `.npy`) and contents, by the directory at the archive's end.
fn members(zip: &[u8]) -> Vec<(String, Vec<u8>)> {
    let u16_at = |at: usize| usize::from(u16::from_le_bytes([zip[at], zip[at + 1]]));
    let u32_at = |at: usize| u32::from_le_bytes(zip[at..at + 4].try_into().unwrap()) as usize;
    let end = (0..zip.len() - 21).rev().find(|&at| zip[at..].starts_with(b"PK\x05\x06")).expect("a zip archive");
    let (count, mut entry) = (u16_at(end + 10), u32_at(end + 16));
    let mut found = Vec::new();
    for _ in 0..count {
        let (method, size, start) = (u16_at(entry + 10), u32_at(entry + 20), u32_at(entry + 42));
        let name = String::from_utf8_lossy(&zip[entry + 46..entry + 46 + u16_at(entry + 28)]).into_owned();
        let data = start + 30 + u16_at(start + 26) + u16_at(start + 28);
        let packed = &zip[data..data + size];
        let unpacked = match method {
            0 => packed.to_vec(),
            8 => miniz_oxide::inflate::decompress_to_vec(packed).expect("deflated data"),
            other => panic!("{name}: zip method {other}"),
        };
        found.push((name.trim_end_matches(".npy").to_owned(), unpacked));
        entry += 46 + u16_at(entry + 28) + u16_at(entry + 30) + u16_at(entry + 32);
    }
    found
}

/// The values of an `.npy` file of little-endian floats.
fn array(npy: &[u8]) -> Option<Vec<f32>> {
    let header = usize::from(u16::from_le_bytes([npy[8], npy[9]]));
    let (text, data) = (String::from_utf8_lossy(&npy[10..10 + header]), &npy[10 + header..]);
    if text.contains("<f4") {
        Some(data.chunks_exact(4).map(|b| f32::from_le_bytes(b.try_into().unwrap())).collect())
    } else if text.contains("<f2") {
        Some(data.chunks_exact(2).map(|b| f16::from_le_bytes([b[0], b[1]]).to_f32()).collect())
    } else {
        None
    }
}
