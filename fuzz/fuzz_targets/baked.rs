//! KTX2 files of baked maps: what is read gives heights and moments.
#![no_main]

use leadr_maps::baked::BakedMap;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(map) = BakedMap::decode(bytes) {
        let _ = map.height_map();
        let _ = map.moments();
    }
});
