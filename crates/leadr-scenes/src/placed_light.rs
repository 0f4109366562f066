//! The point lights that the user places with `--light`.

use std::str::FromStr;

use glam::Vec3;
use serde::Serialize;

use leadr_maps::shown::shown_line;
use leadr_maps::srgb::linear_from_srgb;
use leadr_render::scene::PointLight;
use leadr_render::settings::numbers::{finite, within};

/// A point light that shines in all directions.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct PlacedLight {
    /// The position in metres.
    pub position: [f32; 3],
    /// The colour in linear RGB, 0 to 1.
    pub color: [f32; 3],
    /// The intensity in candela. At a distance of `d` metres, the illuminance is `power / d²` lux. A white surface under π lux is as bright
    /// as the white of the picture.
    pub power: f32,
}

/// The form of a light, for errors.
const FORM: &str = "write X,Y,Z,COLOUR,POWER, such as 1,-2,3,#ffb46b,20 or 1,-2,3,2700K,20";
/// The largest coordinate in metres.
const FARTHEST: f32 = 1e5;
/// The largest intensity in candela.
const STRONGEST: f32 = 1e9;
/// The lowest and the highest colour temperature in kelvins.
const KELVINS: [f32; 2] = [1700.0, 25_000.0];

impl PlacedLight {
    /// Returns the light for the renderer. `white` is the radiance of the white of the picture.
    pub fn lit(&self, white: f32) -> PointLight {
        PointLight::new(Vec3::from(self.position), Vec3::from(self.color) * (self.power * white))
    }
}

impl FromStr for PlacedLight {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let parts: Vec<&str> = text.split(',').map(str::trim).collect();
        let [x, y, z, color, power] = parts[..] else {
            return Err(format!("{} values instead of 5; {FORM}", parts.len()));
        };
        let coordinate = |text: &str| match finite(text).map_err(|fault| format!("{fault}; {FORM}"))? {
            metres if metres.abs() <= FARTHEST => Ok(metres),
            metres => Err(format!("the coordinate {metres} is not from -{FARTHEST} to {FARTHEST} metres")),
        };
        let power = finite(power).map_err(|fault| format!("POWER: {fault}; {FORM}"))?;
        if !(0.0..=STRONGEST).contains(&power) {
            return Err(format!("the power {power} is not from 0 to {STRONGEST} candela"));
        }
        Ok(Self { position: [coordinate(x)?, coordinate(y)?, coordinate(z)?], color: color_of(color)?, power })
    }
}

/// Parses an sRGB colour of six hexadecimal digits, or a colour temperature.
pub(super) fn color_of(text: &str) -> Result<[f32; 3], String> {
    if let Some(kelvins) = text.strip_suffix(['K', 'k']) {
        let [low, high] = KELVINS;
        return within(kelvins, low, high)
            .map(color_of_temperature)
            .map_err(|fault| format!("the temperature '{}' {fault} kelvins", shown_line(text)));
    }
    let digits = text.strip_prefix('#').unwrap_or(text);
    let code = u32::from_str_radix(digits, 16).ok().filter(|_| digits.len() == 6 && !digits.starts_with('+'));
    let Some(code) = code else {
        let text = shown_line(text);
        return Err(format!("no such colour: '{text}'; use six hexadecimal digits, such as ffb46b, or 2700K"));
    };
    Ok([16, 8, 0].map(|shift| linear_from_srgb((code >> shift & 255) as f32 / 255.0)))
}

/// Returns the linear sRGB colour of a black body, whose largest component is 1. The chromaticity is the fit of Kim et al. (US patent
/// 7024034, 2006). Colours outside sRGB are clamped.
fn color_of_temperature(kelvins: f32) -> [f32; 3] {
    let cubic = |c: [f64; 4], x: f64| ((c[0] * x + c[1]) * x + c[2]) * x + c[3];
    let thousands = 1000.0 / f64::from(kelvins);
    let x = match kelvins <= 4000.0 {
        true => cubic([-0.266_123_9, -0.234_358_9, 0.877_695_6, 0.179_910], thousands),
        false => cubic([-3.025_846_9, 2.107_037_9, 0.222_634_7, 0.240_390], thousands),
    };
    let y = match kelvins {
        ..=2222.0 => cubic([-1.106_381_4, -1.348_110_2, 2.185_558_32, -0.202_196_83], x),
        ..=4000.0 => cubic([-0.954_947_6, -1.374_185_93, 2.091_370_15, -0.167_488_67], x),
        _ => cubic([3.081_758_0, -5.873_386_7, 3.751_129_97, -0.370_014_83], x),
    };
    let (x, z) = (x / y, (1.0 - x - y) / y);
    let rgb = [
        3.240_454_2 * x - 1.537_138_5 - 0.498_531_4 * z,
        -0.969_266 * x + 1.876_010_8 + 0.041_556 * z,
        0.055_643_4 * x - 0.204_025_9 + 1.057_225_2 * z,
    ];
    let largest = rgb.iter().copied().fold(0.0, f64::max);
    rgb.map(|c| (c / largest).clamp(0.0, 1.0) as f32)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lights_are_read() {
        let light: PlacedLight = "-1, 2.5,3,#ff8000,20".parse().unwrap();
        assert_eq!((light.position, light.power), ([-1.0, 2.5, 3.0], 20.0));
        assert_eq!((light.color[0], light.color[2]), (1.0, 0.0));
        assert!((light.color[1] - 0.2159).abs() < 1e-4, "{:?}", light.color);
        assert_eq!("-1,2.5,3,FF8000,20".parse(), Ok(light));
        assert_eq!(light.lit(2.0).intensity, Vec3::from(light.color) * 40.0);
        assert_eq!(light.lit(2.0).position, Vec3::new(-1.0, 2.5, 3.0));
    }

    #[test]
    fn temperatures_are_colours_of_black_bodies() {
        let of = |text: &str| color_of(text).unwrap();
        // The white of sRGB is close to a black body of 6504 K.
        assert!(of("6504K").iter().all(|&c| c > 0.93), "{:?}", of("6504K"));
        // Linear values of tables of black bodies (Mitchell Charity): 2700 K is #ffa95f on average over several tables.
        let [r, g, b] = of("2700k");
        assert!(r == 1.0 && (g - 0.40).abs() < 0.04 && (b - 0.09).abs() < 0.04, "{g} {b}");
        let [r, _, b] = of("15000K");
        assert!(b == 1.0 && r < 0.6);
        for kelvins in [1700.0, 2222.0, 4000.0, 25_000.0f32] {
            let near = [kelvins - 0.5, kelvins + 0.5].map(color_of_temperature);
            assert!((0..3).all(|c| (near[0][c] - near[1][c]).abs() < 0.02), "{kelvins}: {near:?}");
        }
    }

    #[test]
    fn invalid_lights_are_refused() {
        for text in [
            "",
            "1",
            "1,2,3",
            "1,2,3,ffffff",
            "1,2,3,ffffff,1,1",
            "nan,0,0,ffffff,1",
            "0,inf,0,ffffff,1",
            "0,0,1e9,ffffff,1",
            "0,0,0,ffffff,nan",
            "0,0,0,ffffff,-1",
            "0,0,0,ffffff,inf",
            "0,0,0,ffffff,1e30",
            "0,0,0,red,1",
            "0,0,0,fff,1",
            "0,0,0,+fffff,1",
            "0,0,0,#gggggg,1",
            "0,0,0,K,1",
            "0,0,0,nanK,1",
            "0,0,0,100K,1",
            "0,0,0,1e9K,1",
            "0,0,0,,1",
            "0,0,0,é\u{1b}[31m,1",
        ] {
            let fault = text.parse::<PlacedLight>().unwrap_err();
            assert!(!fault.contains('\n') && fault.len() < 200, "{text}: {fault}");
        }
    }
}
