//! Test-only compute shaders: each evaluates one function of the include library over an array.

mod table {
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

    /// The entry points, sorted by name, such as `"probes/facets/beckmann.comp"`.
    pub static PROBES: &[Shader] = &TABLE;
}

pub use table::PROBES;
