//! PNG and JPEG, as colours, heights and whatever else.
#![no_main]

use leadr_maps::{decode_color, decode_color_srgb8, decode_height_map, decode_raster};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let _ = decode_raster(bytes);
    let _ = decode_color(bytes);
    let _ = decode_color_srgb8(bytes);
    let _ = decode_height_map(bytes);
});
