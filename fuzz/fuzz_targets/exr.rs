//! OpenEXR as pictures, heights and baked maps.
#![no_main]

use leadr_maps::{ImageHeader, decode_height_map, decode_picture};

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    let header = ImageHeader::read(bytes, bytes.len() as u64);
    if let Ok(picture) = decode_picture(bytes) {
        let header = header.expect("the header of an image that decodes");
        assert!(header.texels() >= picture.image.texels.len() as u64);
    }
    if let Ok(map) = decode_height_map(bytes) {
        assert!(map.texels.iter().all(|height| height.is_finite()));
    }
    let _ = leadr_maps::baked::BakedMap::decode(bytes);
});
