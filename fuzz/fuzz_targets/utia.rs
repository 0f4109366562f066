//! UTIA's `.bin`: its numbers over and over, since a file of theirs has 2 MB.
#![no_main]

use leadr_measured::utia::{BYTES, Utia};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = Utia::read(bytes);
    if !bytes.is_empty() {
        let mut file = bytes.repeat(BYTES / bytes.len() + 1);
        file.truncate(BYTES);
        let _ = Utia::read(&file);
    }
});
