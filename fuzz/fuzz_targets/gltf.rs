//! glTF and GLB, without files beside them: strictly and with repairs; what is read can be posed.
#![no_main]

use leadr_models::{LoadOptions, Model};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    for strict in [false, true] {
        let _ = Model::decode(bytes, "fuzzed", None, LoadOptions { strict, ..LoadOptions::default() });
    }
});
