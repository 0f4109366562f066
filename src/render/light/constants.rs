//! The numbers of the atmosphere, generated from `shaders-glsl/passes/light/atmosphere.glsl`: change them there.

include!(concat!(env!("OUT_DIR"), "/atmosphere.rs"));
