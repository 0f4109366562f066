//! The parameters of a sea, in the units of the command line.

use serde::Serialize;

use super::sea::{RESOLUTION, ocean};
use super::spectrum::Sea;
use leadr_render::surfaces::ocean::Ocean;

/// The parameters of a sea.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Waves {
    /// The wind speed 10 m above the water in m/s.
    pub wind: f64,
    /// The direction in which the wind blows, in degrees counter-clockwise from +x.
    pub wind_direction: f64,
    /// The fetch, which is the distance over which the wind has blown, in metres.
    pub fetch: f64,
    /// The depth of the water in metres.
    pub depth: f64,
    /// The factor, from 0 to 1, on the horizontal displacement that sharpens the crests.
    pub choppiness: f64,
    /// The number of samples along the edge of a wave tile: a power of two, 64 to 512.
    pub fft: u32,
}

impl Default for Waves {
    fn default() -> Self {
        let sea = Sea::default();
        Self {
            wind: sea.wind_speed,
            wind_direction: sea.wind_direction.to_degrees(),
            fetch: sea.fetch,
            depth: sea.depth,
            choppiness: 1.0,
            fft: RESOLUTION,
        }
    }
}

impl Waves {
    /// Builds the ocean for the renderer.
    pub fn ocean(&self) -> Ocean {
        Ocean { choppiness: self.choppiness as f32, ..ocean(&self.sea(), self.fft, 1) }
    }

    /// Returns the parameters of the spectrum.
    pub fn sea(&self) -> Sea {
        Sea {
            wind_speed: self.wind,
            wind_direction: self.wind_direction.to_radians(),
            fetch: self.fetch,
            depth: self.depth,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn defaults_match_the_spectrum() {
        let (sea, default) = (Waves::default().sea(), Sea::default());
        assert!((sea.wind_direction - default.wind_direction).abs() < 1e-12);
        assert_eq!(Sea { wind_direction: default.wind_direction, ..sea }, default);
    }
}
