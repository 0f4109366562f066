//! Prints the table of docs/measurements/panoramas.md: lights extracted from panoramas, and the errors of nine spherical harmonics with and
//! without these lights.
//!
//! `cargo run --release --example 14_panorama_lights FILE.hdr ...`

use leadr::maps::load_environment;
use leadr::render::light::panorama::LightExtraction;
use leadr_lab::panorama_study::irradiance_errors;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    for file in std::env::args().skip(1) {
        let image = load_environment(&file)?;
        println!("{file}: {} x {}", image.width, image.height);
        for count in [0, LightExtraction::default().count] {
            let errors = irradiance_errors(&image, LightExtraction { count, ..LightExtraction::default() });
            let percent = [errors.rms, errors.worst, errors.level].map(|e| 100.0 * e);
            let [rms, worst, level] = percent;
            println!(
                "  at most {count} lights: irradiance error {rms:.2} % RMS, {worst:+.1} % maximum, {level:+.2} % level"
            );
            for light in &errors.lights {
                let (d, e, r) = (light.direction, light.irradiance, light.radius_degrees());
                println!(
                    "    direction {:.4} {:.4} {:.4}, irradiance {:.4} {:.4} {:.4}, radius {r:.3} degrees",
                    d.x, d.y, d.z, e.x, e.y, e.z
                );
            }
        }
    }
    Ok(())
}
