//! Reflectances as text.
#![no_main]

libfuzzer_sys::fuzz_target!(|text: &str| {
    let _ = leadr_measured::table::Table::read(text);
});
