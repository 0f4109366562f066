//! Radiance HDR, and what else lights a scene: what is read has nothing in it that would spoil a sum.
#![no_main]

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(image) = leadr_maps::decode_environment(bytes) {
        image.check_radiance().expect("radiance");
        let header = leadr_maps::ImageHeader::read(bytes, bytes.len() as u64).expect("the header of an image that decodes");
        // A light probe becomes a panorama with twice as many texels.
        assert!(2 * header.texels() >= image.texels.len() as u64);
    }
});
