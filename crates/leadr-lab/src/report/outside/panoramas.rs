//! The panoramas of the external truths. Four panoramas come from the shared data. One of the four also exists without its
//! sun. The formulas of `scripts/external-truth/panoramas.py` give four more.

use std::f64::consts::PI;

use crate::report::shared::shared;

use leadr_maps::{MapError, RgbImage, load_environment};

/// The names of all panoramas.
#[cfg(test)]
pub const NAMES: [&str; 9] = ["spiaggia", "spruit", "studio", "night", "soft", "pixel", "tubes", "lamps", "checks"];

const WIDTH: u32 = 1024;
const HEIGHT: u32 = 512;
/// The largest radiance in the soft panorama.
const CUT: f32 = 4.0;

/// Returns a panorama by name, or `None` if the name is unknown or its shared data is missing.
///
/// # Errors
/// Fails if a file of the shared data cannot be read.
pub fn panorama(name: &str) -> Result<Option<RgbImage>, MapError> {
    let file = match name {
        "pixel" => return Ok(Some(picture(|x, y, d| if (x, y) == (300, 150) { [1e5, 9e4, 8e4] } else { dusk(d) }))),
        "tubes" => return Ok(Some(picture(tubes))),
        "lamps" => return Ok(Some(picture(|_, _, d| lamps(d)))),
        "checks" => return Ok(Some(picture(|x, y, _| checks(x, y)))),
        "spiaggia" | "soft" => "spiaggia_di_mondello_1k",
        "spruit" => "spruit_sunrise_1k",
        "studio" => "studio_pmndrs_1k",
        "night" => "night_pmndrs_1k",
        _ => return Ok(None),
    };
    let Some(path) = shared(&format!("env/{file}.hdr")) else { return Ok(None) };
    let mut image = load_environment(path)?;
    if name == "soft" {
        for texel in &mut image.texels {
            let most = texel.iter().fold(1e-9f32, |a, &c| a.max(c));
            *texel = texel.map(|c| c * (CUT / most).min(1.0));
        }
    }
    Ok(Some(image))
}

/// Returns the panorama of a radiance function, whose arguments are texel and direction.
fn picture(radiance: impl Fn(u32, u32, [f64; 3]) -> [f64; 3]) -> RgbImage {
    let texels = (0..WIDTH * HEIGHT).map(|i| {
        let (x, y) = (i % WIDTH, i / WIDTH);
        let azimuth = (0.5 - (f64::from(x) + 0.5) / f64::from(WIDTH)) * 2.0 * PI;
        let polar = (f64::from(y) + 0.5) / f64::from(HEIGHT) * PI;
        let d = [polar.sin() * azimuth.cos(), polar.sin() * azimuth.sin(), polar.cos()];
        radiance(x, y, d).map(|c| c as f32)
    });
    RgbImage { width: WIDTH, height: HEIGHT, texels: texels.collect() }
}

/// Computes the radiance of a sky over brown ground. The sky is brighter near the zenith.
fn dusk([_, _, z]: [f64; 3]) -> [f64; 3] {
    if z > 0.0 { [0.25, 0.35, 0.55].map(|c| c * (0.4 + 0.6 * z)) } else { [0.20, 0.17, 0.13] }
}

/// Computes the radiance of a row of eight upright tubes, which are two texels wide.
fn tubes(x: u32, y: u32, d: [f64; 3]) -> [f64; 3] {
    let along = x.wrapping_sub(200);
    if (120..220).contains(&y) && along < 192 && along % 24 < 2 {
        return if (along / 24).is_multiple_of(2) { [160.0, 200.0, 240.0] } else { [240.0, 200.0, 160.0] };
    }
    dusk(d).map(|c| 0.2 * c)
}

/// Computes the radiance of discs in different colours, with equal flux and half angles from 1° to 16°.
fn lamps(d: [f64; 3]) -> [f64; 3] {
    const COLORS: [[f64; 3]; 5] = [[1.0, 0.3, 0.2], [0.3, 1.0, 0.3], [0.3, 0.4, 1.0], [1.0, 0.9, 0.3], [0.8; 3]];
    let mut radiance = dusk(d).map(|c| 0.05 * c);
    for (k, color) in COLORS.iter().enumerate() {
        let k = k as f64;
        let (azimuth, height) = ((70.0 * k - 150.0).to_radians(), (20.0 + 12.0 * k).to_radians());
        let edge = 2f64.powf(k).to_radians().cos();
        let centre = [height.cos() * azimuth.cos(), height.cos() * azimuth.sin(), height.sin()];
        if d.iter().zip(&centre).map(|(a, b)| a * b).sum::<f64>() > edge {
            radiance = color.map(|c| c / (1.0 - edge) / 10.0);
        }
    }
    radiance
}

/// Computes the radiance of bright and dark squares of 11.25°.
fn checks(x: u32, y: u32) -> [f64; 3] {
    if (y / 32 + x / 32).is_multiple_of(2) { [1.6, 1.5, 1.4] } else { [0.08, 0.1, 0.12] }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn generated_panoramas_match_their_names() {
        let made = |name: &str| panorama(name).unwrap().unwrap();
        assert_eq!(made("pixel").at(300, 150), [1e5, 9e4, 8e4]);
        let pixels = |name: &str, least: f32| made(name).texels.iter().filter(|t| t[1] > least).count();
        assert_eq!(pixels("pixel", 1.0), 1);
        assert_eq!(pixels("tubes", 100.0), 8 * 2 * 100);
        assert_eq!(pixels("checks", 1.0), 512 * 512);
        // The disc of 16° covers (1 − cos 16°) / 2 of the sphere.
        let white = |t: &&[f32; 3]| (t[0] - t[2]).abs() < 1e-6 && t[0] > 1.0;
        assert!(made("lamps").texels.iter().filter(white).count() > 1000);
        assert!(panorama("nowhere").unwrap().is_none());
    }
}
