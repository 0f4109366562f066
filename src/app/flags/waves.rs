//! Flags of the sea.

use clap::Args;

use super::values::{fft, within};
use leadr_scenes::ocean::waves::Waves;
use leadr_scenes::registry::Scene;

/// Flags of the waves of scenes with a sea.
#[derive(Clone, Debug, Default, Args)]
pub struct WaveArgs {
    /// Wind speed 10 m above the water, m/s, 1 to 40 (ocean, shore) [default: 8; 6 off the shore]
    #[arg(long, value_name = "M/S", value_parser = |text: &str| within(text, 1.0, 40.0))]
    pub wind: Option<f64>,
    /// Where the wind blows to, degrees counter-clockwise from +x (ocean, shore) [default: 34; -20 off the shore]
    #[arg(long, value_name = "DEGREES", allow_negative_numbers = true, value_parser = |text: &str| within(text, -360.0, 360.0))]
    pub wind_direction: Option<f64>,
    /// Distance over which the wind has blown, metres, 1000 to 5000000 (ocean, shore) [default: 120000; 40000 off the shore]
    #[arg(long, value_name = "METRES", value_parser = |text: &str| within(text, 1e3, 5e6))]
    pub fetch: Option<f64>,
    /// Depth of the water, metres, 1 to 11000 (ocean, shore) [default: 200]
    #[arg(long, value_name = "METRES", value_parser = |text: &str| within(text, 1.0, 11e3))]
    pub depth: Option<f64>,
    /// How far waves move sideways, which sharpens their crests: 0 not at all, 1 like real water (ocean, shore) [default: 1]
    #[arg(long, value_name = "X", value_parser = |text: &str| within(text, 0.0, 1.0))]
    pub choppiness: Option<f64>,
    /// Samples along the edge of a tile of waves: 64, 128, 256 or 512 (ocean, shore) [default: 256]
    #[arg(long, value_name = "N", value_parser = fft)]
    pub fft: Option<u32>,
}

impl WaveArgs {
    /// Its flags, and whether each is given.
    pub fn flags(&self) -> [(&'static str, bool); 6] {
        [
            ("--wind", self.wind.is_some()),
            ("--wind-direction", self.wind_direction.is_some()),
            ("--fetch", self.fetch.is_some()),
            ("--depth", self.depth.is_some()),
            ("--choppiness", self.choppiness.is_some()),
            ("--fft", self.fft.is_some()),
        ]
    }

    /// The sea of `scene` as they change it.
    #[must_use]
    pub fn of(&self, scene: &Scene) -> Waves {
        let own = scene.waves();
        Waves {
            wind: self.wind.unwrap_or(own.wind),
            wind_direction: self.wind_direction.unwrap_or(own.wind_direction),
            fetch: self.fetch.unwrap_or(own.fetch),
            depth: self.depth.unwrap_or(own.depth),
            choppiness: self.choppiness.unwrap_or(own.choppiness),
            fft: self.fft.unwrap_or(own.fft),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn each_sea_has_its_own_waves_until_they_are_changed() {
        let args = WaveArgs { wind: Some(12.0), ..WaveArgs::default() };
        let (ocean, shore) = (Scene::find("ocean").unwrap(), Scene::find("shore").unwrap());
        assert_eq!(args.of(ocean), Waves { wind: 12.0, ..Waves::default() });
        let off_the_shore = args.of(shore);
        assert_eq!((off_the_shore.wind, off_the_shore.fetch), (12.0, 40e3));
        assert_eq!(args.flags().iter().filter(|flag| flag.1).collect::<Vec<_>>(), [&("--wind", true)]);
    }
}
