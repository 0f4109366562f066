//! Makes Rust modules of the constants that shaders share, and compiles the shaders if the feature `gpu` asks for them.

#[cfg(feature = "gpu")]
mod compiler;
mod constants;
#[cfg(feature = "gpu")]
mod reflect;
#[cfg(feature = "gpu")]
mod shaders;

fn main() {
    println!("cargo:rerun-if-changed=build");
    let out = std::path::PathBuf::from(std::env::var_os("OUT_DIR").expect("cargo sets OUT_DIR"));
    if let Err(fault) = constants::write(&out) {
        eprintln!("{fault}");
        std::process::exit(1);
    }
    #[cfg(feature = "gpu")]
    shaders::run();
}
