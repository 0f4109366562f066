//! Deterministic pseudo-random numbers: SplitMix64 (Steele, Lea and Flood 2014).

use glam::DVec3;
use std::f64::consts::TAU;

/// A stream of pseudo-random numbers, determined by its seed.
#[derive(Clone, Debug)]
pub struct Random(pub u64);

impl Random {
    /// Creates the stream with this `index` among the streams of `seed`. Neighbouring indices give unrelated streams, so threads may draw
    /// numbers in any order.
    pub fn stream(seed: u64, index: u64) -> Self {
        let mixed = Self(seed ^ 0x5851_f42d_4c95_7f2d).bits();
        Self(Self(mixed ^ index.wrapping_mul(0xd605_1ccb_05a6_2b0f)).bits())
    }

    /// Returns 64 random bits.
    pub fn bits(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(STEP);
        mix(self.0)
    }

    /// Draws a uniform number in `[0, 1)`.
    pub fn unit(&mut self) -> f64 {
        unit_of_bits(self.bits())
    }

    /// Draws a uniform number in `[low, high)`.
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }

    /// Draws a log-uniform number in `[low, high)`. Both bounds must be positive.
    pub fn log(&mut self, low: f64, high: f64) -> f64 {
        self.range(low.ln(), high.ln()).exp()
    }

    /// Draws an exponential number with mean 1.
    pub fn exponential(&mut self) -> f64 {
        -(1.0 - self.unit()).ln()
    }

    /// Draws two independent standard normals (Box and Muller).
    pub fn normals(&mut self) -> [f64; 2] {
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        let (sin, cos) = (TAU * self.unit()).sin_cos();
        [radius * cos, radius * sin]
    }

    /// Draws a unit vector that is uniformly distributed on the sphere.
    pub fn on_sphere(&mut self) -> DVec3 {
        let (z, phi) = (self.range(-1.0, 1.0), self.range(0.0, TAU));
        let r = (1.0 - z * z).max(0.0).sqrt();
        DVec3::new(r * phi.cos(), r * phi.sin(), z)
    }
}

/// The increment of a stream's state: 2⁶⁴ divided by the golden ratio.
pub const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

/// Mixes a counter into random-looking bits, as [`Random`] does with its state.
pub const fn mix(mut z: u64) -> u64 {
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

/// Returns a number in `[0, 1)` from the upper 53 of 64 bits.
pub fn unit_of_bits(bits: u64) -> f64 {
    (bits >> 11) as f64 / (1u64 << 53) as f64
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The first outputs for the seed 1234567 are the same in every implementation of SplitMix64.
    #[test]
    fn is_splitmix64() {
        let mut random = Random(1_234_567);
        assert_eq!(
            [random.bits(), random.bits(), random.bits()],
            [6_457_827_717_110_365_317, 3_203_168_211_198_807_973, 9_817_491_932_198_370_423]
        );
    }

    #[test]
    fn streams_are_uniform_and_unrelated() {
        let n = 20_000u64;
        let (mut mean, mut square, mut cross) = (0.0, 0.0, 0.0);
        for i in 0..n {
            let a = Random::stream(5, i).unit() - 0.5;
            let b = Random::stream(5, i + 1).unit() - 0.5;
            mean += a / n as f64;
            square += a * a / n as f64;
            cross += a * b / n as f64;
        }
        // The tolerance is four standard errors of the mean.
        assert!(mean.abs() < 4.0 * (1.0 / 12.0 / n as f64).sqrt(), "{mean}");
        assert!((square * 12.0 - 1.0).abs() < 4.0 * (0.8 / n as f64).sqrt(), "{square}");
        assert!(cross.abs() < 4.0 / 12.0 / (n as f64).sqrt(), "{cross}");
    }
}
