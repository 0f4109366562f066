//! Compiles the shaders where the feature `gpu` asks for them; the mathematics needs none.

#[cfg(feature = "gpu")]
#[path = "../build.rs"]
mod shaders;

fn main() {
    println!("cargo:rerun-if-changed=build");
    #[cfg(feature = "gpu")]
    shaders::main();
}
