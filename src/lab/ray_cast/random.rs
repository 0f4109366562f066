//! Random numbers of the ray casts: counted, not drawn, so that threads need not agree on an order.

use std::f64::consts::TAU;

/// A stream of numbers that a key determines (SplitMix64; Steele, Lea, Flood 2014).
#[derive(Clone, Debug)]
pub struct Random(u64);

const STEP: u64 = 0x9e37_79b9_7f4a_7c15;

impl Random {
    /// The stream of `seed` and `index`; neighbouring indices give unrelated streams.
    #[must_use]
    pub fn new(seed: u64, index: u64) -> Self {
        let mut key = Self(seed ^ 0x5851_f42d_4c95_7f2d);
        let mixed = key.next();
        let mut stream = Self(mixed ^ index.wrapping_mul(0xd605_1ccb_05a6_2b0f));
        Self(stream.next())
    }

    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(STEP);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        z ^ (z >> 31)
    }

    /// Uniform in `[0, 1)`.
    pub fn uniform(&mut self) -> f64 {
        (self.next() >> 11) as f64 / (1u64 << 53) as f64
    }

    /// Two independent standard normals (Box and Muller).
    pub fn normals(&mut self) -> [f64; 2] {
        let radius = (-2.0 * (1.0 - self.uniform()).ln()).sqrt();
        let (sin, cos) = (TAU * self.uniform()).sin_cos();
        [radius * cos, radius * sin]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn streams_are_uniform_and_unrelated() {
        let n = 20_000u64;
        let (mut mean, mut square, mut cross) = (0.0, 0.0, 0.0);
        for i in 0..n {
            let a = Random::new(5, i).uniform() - 0.5;
            let b = Random::new(5, i + 1).uniform() - 0.5;
            mean += a / n as f64;
            square += a * a / n as f64;
            cross += a * b / n as f64;
        }
        // Four standard errors.
        assert!(mean.abs() < 4.0 * (1.0 / 12.0 / n as f64).sqrt(), "{mean}");
        assert!((square * 12.0 - 1.0).abs() < 4.0 * (0.8 / n as f64).sqrt(), "{square}");
        assert!(cross.abs() < 4.0 / 12.0 / (n as f64).sqrt(), "{cross}");
    }
}
