//! Compiles the probes.

fn main() {
    if let Err(fault) = leadr_glsl::embed(std::path::Path::new(".."), &["probes"]) {
        eprintln!("{fault}");
        std::process::exit(1);
    }
}
