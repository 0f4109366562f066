//! Compiles the shaders where the feature `gpu` asks for them; the mathematics needs none.

#[cfg(feature = "gpu")]
mod constants;
#[cfg(feature = "gpu")]
mod reflect;
#[cfg(feature = "gpu")]
mod shaders;

fn main() {
    println!("cargo:rerun-if-changed=build");
    #[cfg(feature = "gpu")]
    shaders::run();
}
