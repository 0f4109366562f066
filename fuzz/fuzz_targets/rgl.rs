//! RGL's `.bsdf`: what is read has values.
#![no_main]

use leadr_measured::Measured;
use leadr_measured::rgl::Rgl;
use leadr_reflectance::materials::brdf::Brdf;

libfuzzer_sys::fuzz_target!(|bytes: &[u8]| {
    if let Ok(rgl) = Rgl::read(bytes) {
        let (wo, wi) = ([0.0, 0.6, 0.8].into(), [0.48, 0.36, 0.8].into());
        let value = Measured::Rgl(rgl).eval(wo, wi);
        assert!(value.min_element() >= 0.0, "{value}");
    }
});
