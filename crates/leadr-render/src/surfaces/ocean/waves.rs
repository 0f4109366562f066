//! The waves of one frequency band, as a tile of complex amplitudes that the device animates.

use glam::DVec2;
use leadr_reflectance::random::{STEP, mix, unit_of_bits};
use rayon::prelude::*;
use std::f64::consts::TAU;

/// The period in seconds. All frequencies are integer multiples of its reciprocal, so the sea repeats, and phases never lose
/// precision.
pub const PERIOD: f64 = 1024.0;

/// One band of waves on a periodic tile.
#[derive(Clone, Debug)]
pub struct Cascade {
    /// The side of the tile in metres.
    pub size: f64,
    /// The rotation of the tile in the world, in radians.
    pub rotation: f64,
    /// The number of samples along the side of the tile, which is a power of two.
    pub resolution: u32,
    /// The range of the wave numbers in rad/m, as `low ≤ |k| < high`.
    pub band: [f64; 2],
    /// The complex amplitude `a` and the cycles per [`PERIOD`] of each wave vector `(i, j)`, at index `j · resolution + i`.
    /// Negative wave numbers are in the upper half, as in a Fourier transform. The height is `Σ ĥ e^{ik·x}` with `ĥ(k) = a(k)
    /// e^{−iωt} + conj(a(−k)) e^{iωt}`, so each wave travels along its own vector.
    pub waves: Vec<[f32; 4]>,
}

impl Cascade {
    /// Creates the waves of `band` on a tile. Each wave vector has a random phase and its mean amplitude, so the variances match
    /// the spectrum at every time and for every seed. `density` is the height variance per area of world wave vectors (m⁴),
    /// `frequency` maps a wave number to rad/s, and `share` is the fraction of the variance that this cascade has.
    pub fn new(
        size: f64,
        rotation: f64,
        resolution: u32,
        band: [f64; 2],
        share: f64,
        seed: u64,
        density: impl Fn(f64, f64) -> f64 + Sync,
        frequency: impl Fn(f64) -> f64 + Sync,
    ) -> Self {
        let step = TAU / size;
        let waves = (0..resolution * resolution)
            .into_par_iter()
            .map(|index| {
                let k = wave_vector(index % resolution, index / resolution, resolution, size, rotation);
                let length = k.length();
                if length < band[0] || length >= band[1] || length <= 0.0 {
                    return [0.0; 4];
                }
                let amplitude = (0.5 * share * density(k.x, k.y)).sqrt() * step;
                let (sin, cos) = (TAU * unit(seed, index)).sin_cos();
                let cycles = (frequency(length) * PERIOD / TAU).round();
                [(amplitude * cos) as f32, (amplitude * sin) as f32, cycles as f32, 0.0]
            })
            .collect();
        Self { size, rotation, resolution, band, waves }
    }

    /// Returns the standard deviation of the height in metres, and the standard deviation of the slope.
    pub fn deviations(&self) -> [f64; 2] {
        let n = self.resolution;
        let (mut height, mut slope) = (0.0, 0.0);
        for (index, wave) in (0..n * n).zip(&self.waves) {
            let variance = 2.0 * (f64::from(wave[0]).powi(2) + f64::from(wave[1]).powi(2));
            height += variance;
            slope += variance * self.wave_vector(index % n, index / n).length_squared();
        }
        [height.sqrt(), slope.sqrt()]
    }

    /// Returns the same waves with `factor²` times as many samples. Interpolation is then closer to the exact sum of the waves.
    /// `factor` is a power of two.
    pub fn oversampled(&self, factor: u32) -> Self {
        let (n, resolution) = (self.resolution, self.resolution * factor);
        // Negative wave numbers stay in the upper half.
        let index_in = |i: u32| if i < n / 2 { i } else { i + resolution - n };
        let mut waves = vec![[0.0; 4]; resolution as usize * resolution as usize];
        for (index, wave) in (0..n * n).zip(&self.waves) {
            waves[(index_in(index / n) * resolution + index_in(index % n)) as usize] = *wave;
        }
        Self { resolution, waves, ..*self }
    }

    /// Returns the wave vector of an entry of [`waves`](Self::waves), in world space and in rad/m.
    pub fn wave_vector(&self, i: u32, j: u32) -> DVec2 {
        wave_vector(i, j, self.resolution, self.size, self.rotation)
    }
}

/// Returns the weight of a tile's horizontal divergence in the foam. The tile is `size` metres wide. Ripples do not trap air, but
/// they break up the foam of longer waves. `foam_weight` in `passes/ocean/cascade.glsl` is identical.
pub fn foam_weight(size: f64) -> f64 {
    if size >= 10.0 { 1.0 } else { 0.35 }
}

fn wave_vector(i: u32, j: u32, resolution: u32, size: f64, rotation: f64) -> DVec2 {
    let signed = |i: u32| f64::from(i) - if i < resolution / 2 { 0.0 } else { f64::from(resolution) };
    let local = DVec2::new(signed(i), signed(j)) * (TAU / size);
    DVec2::from_angle(rotation).rotate(local)
}

/// Returns a pseudorandom number in `[0, 1)` for a seed and an index.
fn unit(seed: u64, index: u32) -> f64 {
    unit_of_bits(mix(seed.wrapping_add(1).wrapping_mul(STEP) ^ (u64::from(index) << 20)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_variance_is_the_spectrums() {
        // If the spectrum is constant on an annulus, the variance is the density times the area.
        let cascade = Cascade::new(100.0, 0.4, 64, [0.3, 1.5], 0.5, 3, |_, _| 2.0, f64::sqrt);
        let variance: f64 = cascade.waves.iter().map(|w| 2.0 * f64::from(w[0].mul_add(w[0], w[1] * w[1]))).sum();
        let area = TAU / 2.0 * (1.5f64.powi(2) - 0.3f64.powi(2));
        assert!((variance / area - 1.0).abs() < 0.02, "{variance} {area}");
    }

    #[test]
    fn more_samples_carry_the_same_waves() {
        let cascade = Cascade::new(100.0, 0.4, 16, [0.0, 0.45], 0.5, 3, |x, _| 2.0 + x, f64::sqrt);
        let finer = cascade.oversampled(4);
        let waves = |c: &Cascade| -> Vec<([f64; 2], [f32; 4])> {
            let n = c.resolution;
            let all = (0..n * n).map(|i| (c.wave_vector(i % n, i / n).to_array(), c.waves[i as usize]));
            let mut waves: Vec<_> = all.filter(|(_, w)| w[0] != 0.0).collect();
            waves.sort_by(|a, b| a.0.partial_cmp(&b.0).unwrap());
            waves
        };
        assert!(waves(&cascade).len() > 50 && finer.resolution == 64);
        assert_eq!(waves(&cascade), waves(&finer));
    }

    #[test]
    fn wave_vectors_rotate_with_the_tile() {
        let cascade = Cascade::new(10.0, 0.5, 8, [0.0, 9.0], 1.0, 0, |_, _| 1.0, f64::sqrt);
        let k = cascade.wave_vector(7, 0);
        assert!((k - DVec2::from_angle(0.5) * (-TAU / 10.0)).length() < 1e-12);
    }
}
