//! Accumulation pass: the running mean of a frame's jittered samples.

use std::sync::Arc;

use glam::Vec2;

use super::edges::JoinedEdges;
use crate::gpu::{Commands, ComputePipeline, Descriptor, Filter, Gpu, Image, Result, Sampler, SpecValue, Use, Wrap};

/// The accumulation pipeline.
pub struct AccumulatePass {
    /// Without and with edge samples.
    pipelines: [ComputePipeline; 2],
    nearest: Sampler,
}

impl AccumulatePass {
    /// The pass.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        Ok(Self {
            pipelines: [
                ComputePipeline::new(gpu, "passes/accumulate.comp", &[(0, SpecValue::Bool(false))])?,
                ComputePipeline::new(gpu, "passes/accumulate.comp", &[(0, SpecValue::Bool(true))])?,
            ],
            nearest: Sampler::new(gpu, "accumulate", Filter::Nearest, Wrap::Clamp)?,
        })
    }

    /// Mixes a `sample`, with so many joined edge samples if it has any, into the `mean` of the `before` before it.
    pub fn record(
        &self,
        cmd: &mut Commands,
        sample: &Image,
        edges: Option<(&JoinedEdges, u32)>,
        mean: &Image,
        before: u32,
    ) {
        cmd.transition(sample, Use::Sampled);
        if before == 0 {
            cmd.image_barrier(mean, Use::Undefined, Use::ComputeReadWrite);
        } else {
            cmd.transition(mean, Use::ComputeReadWrite);
        }
        let pipeline = &self.pipelines[usize::from(edges.is_some())];
        let (others, shares) = edges.map_or((sample, sample), |(joined, _)| (&joined.others, &joined.shares));
        cmd.bind(
            pipeline,
            &[
                (0, Descriptor::Sampled(sample.whole(), &self.nearest)),
                (1, Descriptor::StorageImage(mean.whole())),
                (2, Descriptor::Sampled(others.whole(), &self.nearest)),
                (3, Descriptor::Sampled(shares.whole(), &self.nearest)),
            ],
        );
        cmd.push_constants(&[1.0 / (before + 1) as f32, edges.map_or(0, |(_, count)| count) as f32]);
        let [width, height] = mean.mip_extent(0);
        cmd.dispatch_invocations(pipeline, [width, height, 1]);
    }
}

/// The mean of a frame's samples put together from parts of it, in 64 bits.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Accumulation {
    sums: Vec<[f64; 4]>,
    samples: u64,
}

impl Accumulation {
    /// Adds the mean `color` of `samples` samples, as [`render_range`](crate::render::frame::Renderer::render_range) gives it.
    ///
    /// # Panics
    /// When the pictures differ in their number of pixels.
    pub fn add(&mut self, color: &[[f32; 4]], samples: u32) {
        if self.sums.is_empty() {
            self.sums = vec![[0.0; 4]; color.len()];
        }
        assert_eq!(self.sums.len(), color.len(), "pixels of the parts");
        for (sum, part) in self.sums.iter_mut().zip(color) {
            for (sum, &value) in sum.iter_mut().zip(part) {
                *sum += f64::from(value) * f64::from(samples);
            }
        }
        self.samples += u64::from(samples);
    }

    /// Samples so far.
    #[must_use]
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Their mean.
    #[must_use]
    pub fn mean(&self) -> Vec<[f32; 4]> {
        let scale = 1.0 / self.samples.max(1) as f64;
        self.sums.iter().map(|sum| sum.map(|v| (v * scale) as f32)).collect()
    }
}

/// Offset of sample `index` inside its pixel, `[-½, ½)²`: the R2 low-discrepancy sequence, shifted by the seed. One
/// sample alone lies in the centre.
#[must_use]
pub fn jitter(index: u32, samples: u32, seed: u64) -> Vec2 {
    if samples <= 1 {
        return Vec2::ZERO;
    }
    // Reciprocals of the plastic number and of its square.
    let step = [0.754_877_666_246_692_7f64, 0.569_840_290_998_053_2];
    let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) ^ 0x5851_f42d_4c95_7f2d;
    let mut shift = || {
        state ^= state >> 30;
        state = state.wrapping_mul(0xbf58_476d_1ce4_e5b9);
        state ^= state >> 27;
        (state >> 11) as f64 / (1u64 << 53) as f64
    };
    let at = |step: f64, shift: f64| (f64::from(index).mul_add(step, shift).fract() - 0.5) as f32;
    Vec2::new(at(step[0], shift()), at(step[1], shift()))
}

/// Offset of edge sample `index` of the `count` in one cell, cells `[-½, ½)²`, for a pixel's sample at `offset`: a lattice with as
/// many columns as rows as points, moved by the offset around the cell's borders.
#[must_use]
pub fn edge_jitter(offset: Vec2, index: u32, count: u32) -> Vec2 {
    let count = count.max(1);
    // Rows are taken in steps without common divisor, near the golden section of them.
    let golden = (f64::from(count) * 0.618).round() as u32;
    let step = (golden.max(1)..).find(|&step| greatest_common_divisor(step, count) == 1).unwrap_or(1);
    let at = |place: u32, offset: f32| {
        let place = (f64::from(place) + 0.5) / f64::from(count) + f64::from(offset);
        (place.rem_euclid(1.0) - 0.5) as f32
    };
    Vec2::new(at(index, offset.x), at(index * step % count, offset.y))
}

fn greatest_common_divisor(a: u32, b: u32) -> u32 {
    if b == 0 { a } else { greatest_common_divisor(b, a % b) }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// The running mean of `passes/accumulate.comp`, in 32 bits, against the sum in 64.
    #[test]
    fn thousands_of_samples_do_not_wear_out_32_bits() {
        for (scale, count) in [(1.0f32, 4096u32), (1e4, 65_536)] {
            let (mut mean, mut sum) = (0.0f32, 0.0f64);
            for i in 0..count {
                // A sample in a hundred is a thousand times as bright as the others.
                let p = jitter(i, count, 3) + 0.5;
                let value = scale * if p.x < 0.01 { 1000.0 * p.y } else { p.y };
                mean += (value - mean) * (1.0 / (i + 1) as f32);
                sum += f64::from(value);
            }
            let error = f64::from(mean) * f64::from(count) / sum - 1.0;
            // Rounding walks at random: measured 2.7e-6 at 65,536.
            assert!(error.abs() < 4e-6, "{count} samples: {error:.1e}");
        }
    }

    #[test]
    fn parts_make_the_whole() {
        let mut whole = Accumulation::default();
        whole.add(&[[1.0, 2.0, 3.0, 1.0]], 3);
        whole.add(&[[5.0, 2.0, 7.0, 0.0]], 1);
        assert_eq!((whole.samples(), whole.mean()), (4, vec![[2.0, 2.0, 4.0, 0.75]]));
    }

    #[test]
    fn samples_cover_the_pixel_evenly() {
        assert_eq!(jitter(0, 1, 7), Vec2::ZERO);
        for seed in [0, 1, 99] {
            let mut cells = [0; 16];
            let mut mean = Vec2::ZERO;
            for i in 0..256 {
                let p = jitter(i, 256, seed);
                assert!(p.abs().max_element() <= 0.5);
                mean += p / 256.0;
                cells[((p.y + 0.5) * 4.0) as usize * 4 + ((p.x + 0.5) * 4.0) as usize] += 1;
            }
            assert!(mean.length() < 0.02, "{mean}");
            assert!(cells.iter().all(|&n| (12..=20).contains(&n)), "{cells:?}");
        }
        assert_ne!(jitter(0, 16, 0), jitter(0, 16, 1));
    }

    #[test]
    fn edge_samples_cover_their_cell() {
        assert_eq!(edge_jitter(Vec2::ZERO, 0, 1), Vec2::ZERO);
        for count in 1..=64 {
            for offset in [Vec2::ZERO, jitter(3, 8, 5), Vec2::splat(-0.5)] {
                let points: Vec<Vec2> = (0..count).map(|i| edge_jitter(offset, i, count)).collect();
                assert!(points.iter().all(|p| p.abs().max_element() <= 0.5));
                // Every row and every column has one.
                for axis in [0, 1] {
                    let mut places: Vec<f32> = points.iter().map(|p| p[axis]).collect();
                    places.sort_by(f32::total_cmp);
                    assert!(places.windows(2).all(|w| ((w[1] - w[0]) * count as f32 - 1.0).abs() < 1e-3), "{places:?}");
                }
            }
            let mean: Vec2 = (0..count).map(|i| edge_jitter(Vec2::ZERO, i, count)).sum::<Vec2>() / count as f32;
            assert!(mean.length() < 1e-5, "{count}: {mean}");
        }
    }
}
