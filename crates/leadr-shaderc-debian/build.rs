//! Finds the archives next to the one that the `shaderc` crate finds.

use std::path::{Path, PathBuf};
use std::process::Command;

/// Archives missing from Debian's.
const LEFT_OUT: [&str; 8] = [
    "glslang",
    "MachineIndependent",
    "GenericCodeGen",
    "OSDependent",
    "OGLCompiler",
    "SPIRV",
    "SPIRV-Tools-opt",
    "SPIRV-Tools",
];

fn main() {
    println!("cargo:rerun-if-changed=build.rs");
    let elsewhere = ["SHADERC_LIB_DIR", "VULKAN_SDK"];
    elsewhere.iter().for_each(|variable| println!("cargo:rerun-if-env-changed={variable}"));
    if elsewhere.iter().any(|variable| std::env::var_os(variable).is_some()) {
        return;
    }
    let Some(folder) = debian() else { return };
    println!("cargo:rerun-if-changed={}", folder.join("libglslang.a").display());
    println!("cargo:rustc-link-search=native={}", folder.display());
    for name in LEFT_OUT.iter().filter(|name| folder.join(format!("lib{name}.a")).is_file()) {
        println!("cargo:rustc-link-lib=static={name}");
    }
}

/// The folder of Debian's archives, if they are installed.
fn debian() -> Option<PathBuf> {
    let output = Command::new("gcc").arg("-print-file-name=libshaderc_combined.a").output().ok()?;
    let archive = PathBuf::from(String::from_utf8(output.stdout).ok()?.trim());
    // Without an archive gcc returns the bare name.
    let folder = archive.parent().filter(|folder| *folder != Path::new(""))?.canonicalize().ok()?;
    folder.join("libglslang.a").is_file().then_some(folder)
}
