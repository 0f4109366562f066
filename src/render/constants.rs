//! Constants that Rust and the shaders share, generated from `shaders-glsl/passes/constants.glsl`: change them there.

include!(concat!(env!("OUT_DIR"), "/constants.rs"));
