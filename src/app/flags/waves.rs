//! Flags of the open sea.

use clap::Args;

use super::values::{fft, within};
use crate::app::error::AppError;
use crate::scenes::ocean::waves::Waves;
use crate::scenes::registry::{Choice, Scene};

/// Flags of the waves of `--scene ocean`.
#[derive(Clone, Debug, Default, Args)]
pub struct WaveArgs {
    /// Wind speed 10 m above the water, m/s, 1 to 40 (ocean) [default: 8]
    #[arg(long, value_name = "M/S", value_parser = |text: &str| within(text, 1.0, 40.0))]
    pub wind: Option<f64>,
    /// Where the wind blows to, degrees counter-clockwise from +x (ocean) [default: 34]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = |text: &str| within(text, -360.0, 360.0))]
    pub wind_direction: Option<f64>,
    /// Distance over which the wind has blown, metres, 1000 to 5000000 (ocean) [default: 120000]
    #[arg(long, value_name = "METRES", value_parser = |text: &str| within(text, 1e3, 5e6))]
    pub fetch: Option<f64>,
    /// Depth of the water, metres, 1 to 11000 (ocean) [default: 200]
    #[arg(long, value_name = "METRES", value_parser = |text: &str| within(text, 1.0, 11e3))]
    pub depth: Option<f64>,
    /// How far waves move sideways, which sharpens their crests: 0 not at all, 1 like real water (ocean) [default: 1]
    #[arg(long, value_name = "X", value_parser = |text: &str| within(text, 0.0, 1.0))]
    pub choppiness: Option<f64>,
    /// Samples along the edge of a tile of waves: 64, 128, 256 or 512 (ocean) [default: 256]
    #[arg(long, value_name = "N", value_parser = fft)]
    pub fft: Option<u32>,
}

impl WaveArgs {
    /// The sea they ask for.
    ///
    /// # Errors
    /// [`AppError::Usage`] if one is given for a scene that is not the open sea.
    pub fn resolve(&self, scene: &Scene) -> Result<Waves, AppError> {
        let given = [
            ("--wind", self.wind.is_some()),
            ("--wind-direction", self.wind_direction.is_some()),
            ("--fetch", self.fetch.is_some()),
            ("--depth", self.depth.is_some()),
            ("--choppiness", self.choppiness.is_some()),
            ("--fft", self.fft.is_some()),
        ];
        if let Some((flag, _)) = given.iter().find(|(_, given)| *given && !scene.offers(Choice::Waves)) {
            let with = Choice::Waves.scenes().collect::<Vec<_>>().join(", ");
            let name = scene.name;
            return Err(AppError::Usage(format!(
                "{flag} is for --scene {with}: the waves of {name}, if any, are fixed"
            )));
        }
        let default = Waves::default();
        Ok(Waves {
            wind: self.wind.unwrap_or(default.wind),
            wind_direction: self.wind_direction.unwrap_or(default.wind_direction),
            fetch: self.fetch.unwrap_or(default.fetch),
            depth: self.depth.unwrap_or(default.depth),
            choppiness: self.choppiness.unwrap_or(default.choppiness),
            fft: self.fft.unwrap_or(default.fft),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn waves_are_the_open_seas() {
        let args = WaveArgs { wind: Some(12.0), ..WaveArgs::default() };
        let (ocean, shore) = (Scene::find("ocean").unwrap(), Scene::find("shore").unwrap());
        assert_eq!(args.resolve(ocean).unwrap(), Waves { wind: 12.0, ..Waves::default() });
        assert!(args.resolve(shore).unwrap_err().to_string().contains("--wind is for --scene ocean"));
    }
}
