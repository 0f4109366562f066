//! The SPIR-V that `build.rs` compiled from `shaders-glsl/passes` and `shaders-glsl/probes`, by name.

use super::{GpuError, Result};

/// SPIR-V is read as 32-bit words; embedded bytes alone would have no alignment.
#[repr(C, align(4))]
struct Aligned<const N: usize>([u8; N]);

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

/// The SPIR-V words of an entry point, named by its path below `shaders-glsl/`, such as `"passes/shade.frag"`.
///
/// # Errors
/// [`GpuError::NoShader`] when no such entry point was compiled into this build.
pub fn spirv(name: &str) -> Result<&'static [u32]> {
    match TABLE.binary_search_by(|(known, _)| (*known).cmp(name)) {
        Ok(index) => Ok(bytemuck::cast_slice(TABLE[index].1)),
        Err(_) => Err(GpuError::NoShader { name: name.to_owned() }),
    }
}

/// The names of all entry points of this build, sorted.
pub fn names() -> impl Iterator<Item = &'static str> {
    TABLE.iter().map(|(name, _)| *name)
}
