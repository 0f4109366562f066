//! The irradiance pass, which computes the environment's nine spherical harmonics coefficients up to order 2 in every frame (LEADR
//! section 5.3, Algorithm 2).
//!
//! The coefficients are of *radiance*, in world space. The order of the coefficients is L00, L1-1, L10, L11, L2-2, L2-1, L20, L21,
//! L22, with one `vec4` each, whose w is 0. `sh_irradiance` of `leadr/integrals/sh.glsl` applies the factors `A_l` of the cosine
//! lobe.
//!
//! Sums have a fixed order, so the same cube always gives the same bytes.

use std::sync::Arc;

use super::environment::Environment;
use leadr_gpu::{
    AddressMode, Buffer, Commands, ComputePipeline, Descriptor, Filter, Gpu, Memory, Result, Sampler, SharedStruct,
    Use, shared_struct,
};

/// The largest face size, in texels, that is projected. Harmonics up to order 2 do not resolve finer detail. All levels have equal
/// means, and a sun shifts by less than a texel, which is 1.4°.
const FACE_SIZE: u32 = 64;

shared_struct! {
    struct Push for "Push" {
        /// The number of partial sums of each coefficient.
        rows: u32,
    }
}

/// The irradiance pass.
pub struct IrradiancePass {
    rows: ComputePipeline,
    sum: ComputePipeline,
    sampler: Sampler,
    partials: Buffer,
    coefficients: Buffer,
}

impl IrradiancePass {
    /// Creates the pipelines and buffers.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        Ok(Self {
            rows: ComputePipeline::new(gpu, "passes/light/irradiance_rows.comp", &[], &[])?,
            sum: ComputePipeline::new(gpu, "passes/light/irradiance.comp", &[], &[Push::LAYOUT])?,
            sampler: Sampler::new(gpu, Filter::Nearest, AddressMode::ClampToEdge)?,
            partials: Buffer::new(gpu, "irradiance partials", 9 * 16 * 6 * u64::from(FACE_SIZE), Memory::Device)?,
            coefficients: Buffer::new(gpu, "irradiance", 9 * 16, Memory::Device)?,
        })
    }

    /// Projects `environment`. Afterwards, compute and graphics passes may read the [`coefficients`](Self::coefficients).
    pub fn record(&self, cmd: &mut Commands, environment: &Environment) {
        let level = environment.level(self.level(environment));
        let rows = 6 * level.extent()[0];
        // An earlier frame may still be reading the coefficients.
        cmd.memory_barrier(Use::Undefined, Use::ComputeWrite);
        cmd.bind(
            &self.rows,
            &[("cube", Descriptor::Sampled(level, &self.sampler)), ("Partials", Descriptor::Storage(&self.partials))],
        );
        cmd.dispatch_invocations(&self.rows, [rows, 1, 1]);
        cmd.memory_barrier(Use::ComputeWrite, Use::ComputeRead);
        cmd.bind(
            &self.sum,
            &[
                ("Partials", Descriptor::Storage(&self.partials)),
                ("Harmonics", Descriptor::Storage(&self.coefficients)),
            ],
        );
        cmd.push_constants(&Push { rows });
        cmd.dispatch([1, 1, 1]);
        cmd.memory_barrier(Use::ComputeWrite, Use::GraphicsRead);
        cmd.memory_barrier(Use::ComputeWrite, Use::ComputeRead);
    }

    /// Returns the mip level that is projected.
    pub fn level(&self, environment: &Environment) -> u32 {
        (environment.face_size() / FACE_SIZE).max(1).ilog2()
    }

    /// Returns the buffer of the coefficients, which is a device-local `vec4[9]`.
    pub fn coefficients(&self) -> &Buffer {
        &self.coefficients
    }
}
