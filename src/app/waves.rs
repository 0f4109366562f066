//! Flags of the sea, and what they resolve to.

use clap::Args;
use serde::Serialize;

use super::error::AppError;
use super::values::fft;
use crate::scenes::ocean::sea::RESOLUTION;
use crate::scenes::ocean::spectrum::Sea;

/// Flags of the waves of `--scene ocean`.
#[derive(Clone, Debug, Default, Args)]
pub struct WaveArgs {
    /// Of the ocean: wind speed 10 m above the water, m/s, 1 to 40 [default: 8]
    #[arg(long, value_name = "M/S", value_parser = |text: &str| within(text, 1.0, 40.0))]
    pub wind: Option<f64>,
    /// Of the ocean: where the wind blows to, degrees counter-clockwise from +x [default: 34]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = |text: &str| within(text, -360.0, 360.0))]
    pub wind_direction: Option<f64>,
    /// Of the ocean: distance over which the wind has blown, metres, 1000 to 5000000 [default: 120000]
    #[arg(long, value_name = "METRES", value_parser = |text: &str| within(text, 1e3, 5e6))]
    pub fetch: Option<f64>,
    /// Of the ocean: depth of the water, metres, 1 to 11000 [default: 200]
    #[arg(long, value_name = "METRES", value_parser = |text: &str| within(text, 1.0, 11e3))]
    pub depth: Option<f64>,
    /// Of the ocean: horizontal movement of the waves, which sharpens their crests: 0 none, 1 as water has it [default: 1]
    #[arg(long, value_name = "X", value_parser = |text: &str| within(text, 0.0, 1.0))]
    pub choppiness: Option<f64>,
    /// Of the ocean: samples along the edge of its tiles of waves: 64, 128, 256 or 512 [default: 256]
    #[arg(long, value_name = "N", value_parser = fft)]
    pub fft: Option<u32>,
}

/// The sea of a scene; units as in [`WaveArgs`].
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Waves {
    /// Wind speed, m/s.
    pub wind: f64,
    /// Where it blows to, degrees.
    pub wind_direction: f64,
    /// Fetch, metres.
    pub fetch: f64,
    /// Depth, metres.
    pub depth: f64,
    /// Factor on the horizontal movement.
    pub choppiness: f64,
    /// Samples along the edge of a tile.
    pub fft: u32,
}

impl WaveArgs {
    /// The sea they ask for.
    ///
    /// # Errors
    /// [`AppError::Usage`] if one is given for a scene that is not the open sea.
    pub fn resolve(&self, open_sea: bool) -> Result<Waves, AppError> {
        let given = [
            ("--wind", self.wind.is_some()),
            ("--wind-direction", self.wind_direction.is_some()),
            ("--fetch", self.fetch.is_some()),
            ("--depth", self.depth.is_some()),
            ("--choppiness", self.choppiness.is_some()),
            ("--fft", self.fft.is_some()),
        ];
        if let Some((flag, _)) = given.iter().find(|(_, given)| *given && !open_sea) {
            return Err(AppError::Usage(format!(
                "{flag} is for --scene ocean; the other scenes bring their own waves or none"
            )));
        }
        let sea = Sea::default();
        Ok(Waves {
            wind: self.wind.unwrap_or(sea.wind_speed),
            wind_direction: self.wind_direction.unwrap_or(sea.wind_direction.to_degrees()),
            fetch: self.fetch.unwrap_or(sea.fetch),
            depth: self.depth.unwrap_or(sea.depth),
            choppiness: self.choppiness.unwrap_or(1.0),
            fft: self.fft.unwrap_or(RESOLUTION),
        })
    }
}

impl Waves {
    /// The spectrum's parameters.
    #[must_use]
    pub fn sea(&self) -> Sea {
        Sea {
            wind_speed: self.wind,
            wind_direction: self.wind_direction.to_radians(),
            fetch: self.fetch,
            depth: self.depth,
        }
    }
}

fn within(text: &str, low: f64, high: f64) -> Result<f64, String> {
    match text.parse::<f64>() {
        Ok(value) if (low..=high).contains(&value) => Ok(value),
        _ => Err(format!("a number from {low} to {high}")),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_are_the_spectrums() {
        let waves = WaveArgs::default().resolve(false).unwrap();
        let (sea, default) = (waves.sea(), Sea::default());
        assert!((sea.wind_direction - default.wind_direction).abs() < 1e-12);
        assert_eq!(Sea { wind_direction: default.wind_direction, ..sea }, default);
    }

    #[test]
    fn waves_are_the_open_seas() {
        let args = WaveArgs { wind: Some(12.0), ..WaveArgs::default() };
        assert_eq!(args.resolve(true).unwrap().sea().wind_speed, 12.0);
        assert!(args.resolve(false).unwrap_err().to_string().contains("--wind is for --scene ocean"));
        assert!(
            within("nan", 0.0, 1.0).is_err() && within("41", 1.0, 40.0).is_err() && within("40", 1.0, 40.0).is_ok()
        );
    }
}
