//! The accumulation pass, which computes the running mean of a frame's jittered samples.

use std::sync::Arc;

use super::targets::{JoinedEdges, MultisampleTargets, SampleTargets};
use leadr_gpu::{
    AddressMode, Commands, ComputePipeline, Descriptor, Filter, Gpu, Image, Result, Sampler, SharedStruct, SpecValue,
    Use, shared_struct,
};

shared_struct! {
    struct Weights for "Weights" {
        /// The weight of the new sample in the mean.
        weight: f32,
        /// The number of edge samples per pixel, or 0 without edge samples.
        edge_samples: f32,
    }
}

/// The parts from which the sample of a pixel is made.
#[derive(Clone, Copy)]
pub enum Parts<'a> {
    /// The sample is the pixel's own surface alone.
    One,
    /// The sample consists of all surfaces at the pixel's geometry samples.
    Multisampled(&'a MultisampleTargets),
    /// The sample consists of the pixel's own surface and its edge samples.
    Edges {
        /// The joined sums of the edge samples.
        joined: &'a JoinedEdges,
        /// The number of edge samples per pixel.
        samples: u32,
    },
}

/// Which parts the samples of a frame have.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum PartsKind {
    /// The kind of [`Parts::One`].
    One,
    /// The kind of [`Parts::Multisampled`] with this many geometry samples per pixel.
    Multisampled(u32),
    /// The kind of [`Parts::Edges`].
    Edges,
}

/// The accumulation pass for one kind of parts.
#[derive(Clone)]
pub struct AccumulatePass {
    pipeline: ComputePipeline,
    nearest: Sampler,
}

impl AccumulatePass {
    /// Creates the pass.
    pub fn new(gpu: &Arc<Gpu>, kind: PartsKind) -> Result<Self> {
        let msaa = if let PartsKind::Multisampled(count) = kind { count } else { 1 };
        let edges = kind == PartsKind::Edges;
        let spec = [("EDGES", SpecValue::Bool(edges)), ("MSAA", SpecValue::I32(msaa.cast_signed()))];
        Ok(Self {
            pipeline: ComputePipeline::new(gpu, "passes/accumulate.comp", &spec, &[Weights::LAYOUT])?,
            nearest: Sampler::new(gpu, Filter::Nearest, AddressMode::ClampToEdge)?,
        })
    }

    /// Adds a `sample` to the `mean` of `before` earlier samples. The `parts` of the sample must match the `kind` of the pass.
    pub fn record(&self, cmd: &mut Commands, sample: &SampleTargets, parts: Parts<'_>, mean: &Image, before: u32) {
        let radiance = &sample.radiance;
        cmd.transition(radiance, Use::Sampled);
        if before == 0 {
            cmd.image_barrier(mean, Use::Undefined, Use::ComputeReadWrite);
        } else {
            cmd.transition(mean, Use::ComputeReadWrite);
        }
        // A pipeline needs an image for every part, so missing parts have placeholders.
        let (plain, visible) = ([radiance, radiance], &sample.visible.surface);
        let ([others, shares], slots) = match parts {
            Parts::One => (plain, visible),
            Parts::Multisampled(seen) => (plain, &seen.others),
            Parts::Edges { joined, .. } => ([&joined.others, &joined.shares], visible),
        };
        cmd.bind(
            &self.pipeline,
            &[
                ("sample_image", Descriptor::Sampled(radiance.whole(), &self.nearest)),
                ("mean_image", Descriptor::StorageImage(mean.whole())),
                ("others", Descriptor::Sampled(others.whole(), &self.nearest)),
                ("others_of_pixels", Descriptor::Sampled(slots.whole(), &self.nearest)),
                ("shares", Descriptor::Sampled(shares.whole(), &self.nearest)),
            ],
        );
        cmd.push_constants(&Weights {
            weight: 1.0 / (before + 1) as f32,
            edge_samples: if let Parts::Edges { samples, .. } = parts { samples as f32 } else { 0.0 },
        });
        let [width, height] = mean.mip_extent(0);
        cmd.dispatch_invocations(&self.pipeline, [width, height, 1]);
    }
}

/// The mean of a frame's samples, accumulated in 64 bits from means of groups.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Accumulation {
    sums: Vec<[f64; 4]>,
    samples: u64,
}

impl Accumulation {
    /// Adds the mean `color` of `samples` samples, as returned by [`render_range`](crate::frame::Renderer::render_range).
    ///
    /// # Panics
    /// Panics if the images differ in their number of pixels.
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

    /// Returns the number of samples so far.
    pub fn samples(&self) -> u64 {
        self.samples
    }

    /// Returns the mean of all samples so far.
    pub fn mean(&self) -> Vec<[f32; 4]> {
        let scale = 1.0 / self.samples.max(1) as f64;
        self.sums.iter().map(|sum| sum.map(|v| (v * scale) as f32)).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::sampling::jitter;

    /// Compares the 32-bit running mean of `passes/accumulate.comp` with a sum in 64 bits.
    #[test]
    fn thousands_of_samples_do_not_wear_out_32_bits() {
        for (scale, count) in [(1.0f32, 4096u32), (1e4, 65_536)] {
            let (mut mean, mut sum) = (0.0f32, 0.0f64);
            for i in 0..count {
                // One sample in a hundred is a thousand times as bright as the others.
                let p = jitter(i, count, 3) + 0.5;
                let value = scale * if p.x < 0.01 { 1000.0 * p.y } else { p.y };
                mean += (value - mean) * (1.0 / (i + 1) as f32);
                sum += f64::from(value);
            }
            let error = f64::from(mean) * f64::from(count) / sum - 1.0;
            // Rounding errors accumulate like a random walk. The measured error is 2.7e-6 after 65,536 samples.
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
}
