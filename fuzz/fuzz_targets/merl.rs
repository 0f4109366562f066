//! MERL's `.binary`: a head, and its numbers over and over, since a file of theirs has 35 MB.
#![no_main]

use leadr_measured::merl::Merl;

const HEAD: usize = 12;
const BYTES: usize = HEAD + 3 * 8 * 90 * 90 * 180;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = Merl::read(bytes);
    if let Some((head, numbers)) = bytes.split_at_checked(HEAD)
        && head[..4] == 90u32.to_le_bytes()
        && !numbers.is_empty()
    {
        let mut file = [head, &numbers.repeat(BYTES / numbers.len() + 1)].concat();
        file.truncate(BYTES);
        let _ = Merl::read(&file);
    }
});
