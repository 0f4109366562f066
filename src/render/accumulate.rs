//! Accumulation pass: the running mean of a frame's jittered samples.

use std::sync::Arc;

use glam::Vec2;

use crate::gpu::{Commands, ComputePipeline, Descriptor, Filter, Gpu, Image, Result, Sampler, Use, Wrap};

/// The accumulation pipeline.
pub struct AccumulatePass {
    pipeline: ComputePipeline,
    nearest: Sampler,
}

impl AccumulatePass {
    /// The pass.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        Ok(Self {
            pipeline: ComputePipeline::new(gpu, "passes/accumulate.comp", &[])?,
            nearest: Sampler::new(gpu, "accumulate", Filter::Nearest, Wrap::Clamp)?,
        })
    }

    /// Mixes sample number `index` (from 0) into `mean`, which keeps its content between samples.
    pub fn record(&self, cmd: &mut Commands, sample: &Image, mean: &Image, index: u32) {
        cmd.transition(sample, Use::Sampled);
        if index == 0 {
            cmd.image_barrier(mean, Use::Undefined, Use::ComputeReadWrite);
        } else {
            cmd.transition(mean, Use::ComputeReadWrite);
        }
        cmd.bind(
            &self.pipeline,
            &[(0, Descriptor::Sampled(sample.whole(), &self.nearest)), (1, Descriptor::StorageImage(mean.whole()))],
        );
        cmd.push_constants(&(1.0f32 / (index + 1) as f32));
        let [width, height] = mean.mip_extent(0);
        cmd.dispatch_invocations(&self.pipeline, [width, height, 1]);
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

#[cfg(test)]
mod tests {
    use super::*;

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
}
