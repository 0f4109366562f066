#![doc = include_str!("README.md")]

/// Constants shared by Rust and the shaders, generated from `passes/constants.glsl`: change them there.
#[allow(missing_docs, reason = "some comments are about a group of constants")]
pub mod constants {
    include!(concat!(env!("OUT_DIR"), "/constants.rs"));
}

/// Constants of the atmosphere, generated from `passes/light/atmosphere.glsl`: change them there.
pub mod atmosphere {
    include!(concat!(env!("OUT_DIR"), "/atmosphere.rs"));
}

/// The shading functions, generated from the `FAMILY_` constants of `passes/shade/families.glsl`.
pub mod families {
    include!(concat!(env!("OUT_DIR"), "/families.rs"));
}

mod table {
    include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

    /// The entry points below `passes/`, sorted by name. A shader's name is its path from this folder.
    pub static SHADERS: &[Shader] = &TABLE;
}

pub use table::SHADERS;

#[cfg(test)]
mod tests {
    /// Drivers compile large modules slowly, and a program holds all of them.
    #[test]
    fn entry_points_are_small() {
        let largest = super::SHADERS.iter().max_by_key(|shader| shader.code.len()).unwrap();
        println!("{}: {} bytes of {} entry points", largest.name, largest.code.len(), super::SHADERS.len());
        assert!(largest.code.len() <= 11 << 16, "{}: {} bytes", largest.name, largest.code.len());
    }
}
