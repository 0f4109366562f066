//! OpenEXR as pictures, heights and baked maps.
#![no_main]

use leadr_maps::{decode_height_map, decode_picture};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = decode_picture(bytes);
    if let Ok(map) = decode_height_map(bytes) {
        assert!(map.texels.iter().all(|height| height.is_finite()));
    }
    let _ = leadr_maps::baked::BakedMap::decode(bytes);
});
