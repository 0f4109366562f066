//! The JSON of a fitted material.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(value) = serde_json::from_slice(bytes) {
        let _ = leadr_measured::fit_file::FitFile::from_json(&value);
    }
});
