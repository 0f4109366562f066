//! The irradiance pass: the environment's nine order-2 spherical harmonics coefficients, every frame (LEADR section 5.3,
//! Algorithm 2), and up to three lights that need no masking per pixel.
//!
//! The coefficients are of *radiance*, in world space, in the order L00, L1-1, L10, L11, L2-2, L2-1, L20, L21, L22 (one
//! `vec4` each, w = 0): the cosine lobe's factors `A_l` are not applied, `sh_irradiance` of `leadr/integrals/sh.glsl` does that. A
//! light enters with its irradiance, as if it were a radiance delta.
//!
//! Sums are made in a fixed order: the same cube gives the same bytes on every run.

use std::sync::Arc;

use super::environment::Environment;
use crate::gpu::{
    AddressMode, Buffer, Commands, ComputePipeline, Descriptor, Filter, Gpu, GpuError, Memory, Result, Sampler,
    SharedStruct, Use, shared_struct,
};

/// Faces of at most this many texels are projected. Order-2 harmonics see nothing finer: the levels' means agree, and a
/// sun is displaced by less than a texel, 1.4°.
const FACE_SIZE: u32 = 64;

/// Most lights that [`IrradiancePass::record`] takes: as many as push constants hold.
pub const MAX_LIGHTS: usize = 3;

/// A light that is added to the environment, without shadowing or masking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum ShLight {
    /// From far away.
    Directional {
        /// Towards the light, world; need not be unit.
        direction: [f32; 3],
        /// RGB irradiance on a surface that faces it.
        irradiance: [f32; 3],
    },
    /// From a point.
    Point {
        /// World position, metres.
        position: [f32; 3],
        /// RGB radiant intensity: irradiance at one metre.
        intensity: [f32; 3],
    },
}

shared_struct! {
    #[derive(Default)]
    struct PushLight for "Light" {
        place: [f32; 4],
        power: [f32; 4],
    }
}

shared_struct! {
    struct Push for "Push" {
        lights: [PushLight; MAX_LIGHTS],
        origin: [f32; 3],
        scale: f32,
        rows: u32,
        light_count: u32,
    }
}

impl From<&ShLight> for PushLight {
    fn from(light: &ShLight) -> Self {
        let four = |[x, y, z]: [f32; 3], w| [x, y, z, w];
        match *light {
            ShLight::Directional { direction, irradiance } => {
                Self { place: four(direction, 0.0), power: four(irradiance, 0.0) }
            }
            ShLight::Point { position, intensity } => Self { place: four(position, 1.0), power: four(intensity, 0.0) },
        }
    }
}

/// The pass.
pub struct IrradiancePass {
    rows: ComputePipeline,
    sum: ComputePipeline,
    sampler: Sampler,
    partials: Buffer,
    coefficients: Buffer,
}

impl IrradiancePass {
    /// Creates the pipelines and buffers.
    ///
    /// # Errors
    /// [`GpuError::Allocation`] or a failed Vulkan call.
    pub fn new(gpu: &Arc<Gpu>) -> Result<Self> {
        Ok(Self {
            rows: ComputePipeline::new(gpu, "passes/light/irradiance_rows.comp", &[], &[])?,
            sum: ComputePipeline::new(gpu, "passes/light/irradiance.comp", &[], &[PushLight::LAYOUT, Push::LAYOUT])?,
            sampler: Sampler::new(gpu, "irradiance", Filter::Nearest, AddressMode::ClampToEdge)?,
            partials: Buffer::new(gpu, "irradiance partials", 9 * 16 * 6 * u64::from(FACE_SIZE), Memory::Device)?,
            coefficients: Buffer::new(gpu, "irradiance", 9 * 16, Memory::Device)?,
        })
    }

    /// Projects `environment` times `scale`, and adds `lights` as they arrive at `origin` (world, metres).
    /// [`coefficients`](Self::coefficients) may be read by compute and graphics afterwards. More than [`MAX_LIGHTS`]
    /// lights fail the submission.
    pub fn record(
        &self,
        cmd: &mut Commands,
        environment: &Environment,
        scale: f32,
        lights: &[ShLight],
        origin: [f32; 3],
    ) {
        if lights.len() > MAX_LIGHTS {
            let fault = format!("{} lights are more than {MAX_LIGHTS}", lights.len());
            return cmd.fail(GpuError::Usage { name: "irradiance".to_owned(), fault });
        }
        let level = environment.level(self.level(environment));
        let rows = 6 * level.extent()[0];
        // an earlier frame may still be reading
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
                ("Coefficients", Descriptor::Storage(&self.coefficients)),
            ],
        );
        let mut push = Push { lights: Default::default(), origin, scale, rows, light_count: lights.len() as u32 };
        push.lights.iter_mut().zip(lights).for_each(|(slot, light)| *slot = light.into());
        cmd.push_constants(&push);
        cmd.dispatch([1, 1, 1]);
        cmd.memory_barrier(Use::ComputeWrite, Use::GraphicsRead);
        cmd.memory_barrier(Use::ComputeWrite, Use::ComputeRead);
    }

    /// The mip level that is projected.
    #[must_use]
    pub fn level(&self, environment: &Environment) -> u32 {
        (environment.face_size() / FACE_SIZE).max(1).ilog2()
    }

    /// `vec4[9]`, device-local.
    #[must_use]
    pub fn coefficients(&self) -> &Buffer {
        &self.coefficients
    }
}
