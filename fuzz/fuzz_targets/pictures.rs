//! PNG, JPEG, TIFF, WebP, TGA, BMP, PNM, KTX2 and DDS, as colours, heights and whatever else. Memory is reserved by the header, so the header must agree with the image.
#![no_main]

use leadr_maps::{ImageHeader, decode_color, decode_color_srgb8, decode_height_map, decode_raster};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let header = ImageHeader::read(bytes, bytes.len() as u64);
    if let Ok(raster) = decode_raster(bytes) {
        let header = header.expect("the header of an image that decodes");
        assert_eq!([header.width, header.height], raster.size());
    }
    let _ = decode_color(bytes);
    let _ = decode_color_srgb8(bytes);
    let _ = decode_height_map(bytes);
});
