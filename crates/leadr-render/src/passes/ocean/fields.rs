//! Transforms the waves of all cascades into maps in every frame, with two passes of Fourier transforms and a mip pass.

use std::f64::consts::TAU;
use std::sync::Arc;

use glam::DVec2;

use crate::surfaces::ocean::waves::{Cascade, PERIOD};
use leadr_gpu::vk::Format;
use leadr_gpu::{
    Buffer, Commands, ComputePipeline, Descriptor, Gpu, GpuError, Image, ImageDesc, ImageView, Memory, Result,
    SharedStruct, SpecValue, Use, shared_struct,
};

/// The smallest and the largest resolution of a cascade. Two lines of a transform must fit into shared memory.
pub const RESOLUTIONS: std::ops::RangeInclusive<u32> = 16..=1024;

shared_struct! {
    /// A cascade as the shaders read it (`passes/ocean/cascade.glsl`).
    pub struct CascadeGpu for "Cascade" {
        /// The cosine and the sine of the tile's rotation.
        pub rotation: [f32; 2],
        /// The spacing of wave numbers, which is `2π / size`.
        pub wave_step: f32,
        /// The edge length of the tile in metres.
        pub size: f32,
    }
}

shared_struct! {
    struct Moment for "Push" {
        /// The elapsed fraction of the period, split into a multiple of 1/2048 and a remainder.
        moment: [f32; 2],
    }
}

shared_struct! {
    struct Choppiness for "Push" {
        /// The scale of the horizontal displacement.
        choppiness: f32,
    }
}

/// What the maps contain.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Content {
    /// Moments that can be filtered linearly, with mips. See [`OceanFields`].
    Moments,
    /// Fields that are linear in the waves, so that the fields of the cascades add up exactly, without mips. `displacement` has
    /// `Dx, Dy, height, ∂Dx/∂y`, `slopes` has `∂h/∂x, ∂h/∂y, ∂Dx/∂x, ∂Dy/∂y`, and `joint` is empty.
    Derivatives,
}

/// The maps of the sea at one moment, with one array layer per cascade and all mips.
///
/// In the following, `J` is the Jacobian of the horizontal displacement, `s` is the slope of the displaced surface, and `w = det J`
/// is the displaced area per area of sea at rest. Moments are per area of the displaced sea: `E[s] = Σ w s / Σ w`.
#[derive(Clone)]
pub struct OceanFields {
    rows: ComputePipeline,
    columns: ComputePipeline,
    mips: ComputePipeline,
    twiddles: Buffer,
    waves: Buffer,
    /// The [`CascadeGpu`] of every cascade.
    pub cascades: Buffer,
    lines: Buffer,
    /// The displacement `Dx, Dy, height` in metres, and `det J`.
    pub displacement: Image,
    /// The moments `w sx, w sy, w sx², w sy²`.
    pub slopes: Image,
    /// The moments `w sx sy, w, stretch, stretch²`. Foam is computed from the stretch of the sea, `1 + ∂Dx/∂x + ∂Dy/∂y`, weighted
    /// by [`foam_weight`](crate::surfaces::ocean::waves::foam_weight). The stretch is linear in the waves, so it is normally
    /// distributed, and the stretches of the cascades add up.
    pub joint: Image,
    levels: Vec<[ImageView; 3]>,
    resolution: u32,
    count: u32,
}

impl OceanFields {
    /// Creates pipelines and maps for these cascades, which must have the same resolution.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if there are no cascades, if their resolutions differ, or if the resolution is not a power of
    /// two in [`RESOLUTIONS`]. Also returns an error if memory is short or a pipeline fails.
    pub fn new(gpu: &Arc<Gpu>, cascades: &[Cascade], content: Content) -> Result<Self> {
        let wrong = |fault: &str| Err(GpuError::usage("ocean", fault));
        let Some(resolution) = cascades.first().map(|c| c.resolution) else {
            return wrong("a sea needs at least one cascade");
        };
        if !resolution.is_power_of_two() || !RESOLUTIONS.contains(&resolution) {
            return wrong(&format!("a resolution of {resolution} is not a power of two from 16 to 1024"));
        }
        let samples = resolution as usize * resolution as usize;
        if cascades.iter().any(|c| c.resolution != resolution || c.waves.len() != samples) {
            return wrong("cascades differ in resolution");
        }
        let count = cascades.len() as u32;
        let spec = [
            ("N", SpecValue::U32(resolution)),
            ("LOG_N", SpecValue::U32(resolution.ilog2())),
            ("LINES", SpecValue::U32(2)),
        ];
        let twiddles: Vec<[f32; 2]> = (0..resolution)
            .map(|j| DVec2::from_angle(TAU * f64::from(j) / f64::from(resolution)).as_vec2().to_array())
            .collect();
        let waves: Vec<[f32; 4]> = cascades.iter().flat_map(|c| c.waves.iter().copied()).collect();
        let blocks: Vec<CascadeGpu> = cascades
            .iter()
            .map(|c| CascadeGpu {
                rotation: DVec2::from_angle(c.rotation).as_vec2().to_array(),
                wave_step: (TAU / c.size) as f32,
                size: c.size as f32,
            })
            .collect();
        let desc = ImageDesc::new(Format::R32G32B32A32_SFLOAT, resolution, resolution).layers(count).storage();
        let desc = if content == Content::Moments { desc.full_mips() } else { desc };
        let image = |name: &str| Image::new(gpu, name, desc);
        let (displacement, slopes, joint) =
            (image("ocean displacement")?, image("ocean slopes")?, image("ocean joint")?);
        let levels = (0..desc.mips)
            .map(|mip| Ok([displacement.mip_array(mip)?, slopes.mip_array(mip)?, joint.mip_array(mip)?]))
            .collect::<Result<Vec<_>>>()?;
        Ok(Self {
            rows: ComputePipeline::new(gpu, "passes/ocean/rows.comp", &spec, &[Moment::LAYOUT, CascadeGpu::LAYOUT])?,
            columns: ComputePipeline::new(
                gpu,
                "passes/ocean/columns.comp",
                &[spec[0], spec[1], spec[2], ("DERIVATIVES", SpecValue::Bool(content == Content::Derivatives))],
                &[Choppiness::LAYOUT, CascadeGpu::LAYOUT],
            )?,
            mips: ComputePipeline::new(gpu, "passes/ocean/mips.comp", &[], &[])?,
            twiddles: Buffer::from_slice(gpu, "twiddles", &twiddles)?,
            waves: Buffer::from_slice(gpu, "waves", &waves)?,
            cascades: Buffer::from_slice(gpu, "cascades", &blocks)?,
            lines: Buffer::new(gpu, "ocean lines", (2 * 16 * samples) as u64 * u64::from(count), Memory::Device)?,
            displacement,
            slopes,
            joint,
            levels,
            resolution,
            count,
        })
    }

    /// Fills the maps for `time` by recording all three passes in order. Leaves the maps in [`Use::Sampled`].
    pub fn record(&self, cmd: &mut Commands, time: f64, choppiness: f32) {
        self.record_rows(cmd, time);
        self.record_columns(cmd, choppiness);
        self.record_mips(cmd);
    }

    /// Animates the waves to `time`, in seconds with the period [`PERIOD`], and transforms the rows.
    pub fn record_rows(&self, cmd: &mut Commands, time: f64) {
        // The column pass of an earlier frame may still be reading the buffer.
        cmd.memory_barrier(Use::Undefined, Use::ComputeWrite);
        cmd.bind(
            &self.rows,
            &[
                ("Twiddles", Descriptor::Storage(&self.twiddles)),
                ("Waves", Descriptor::Storage(&self.waves)),
                ("Cascades", Descriptor::Storage(&self.cascades)),
                ("Lines", Descriptor::Storage(&self.lines)),
            ],
        );
        let moment = time.rem_euclid(PERIOD) / PERIOD;
        let coarse = (moment * 2048.0).floor() / 2048.0;
        cmd.push_constants(&Moment { moment: [coarse as f32, (moment - coarse) as f32] });
        cmd.dispatch([self.resolution, self.count, 1]);
        cmd.memory_barrier(Use::ComputeWrite, Use::ComputeRead);
    }

    /// Transforms the columns and writes the finest level of the maps. `choppiness` scales the horizontal displacement: 1 for
    /// water, and 0 for purely vertical waves.
    pub fn record_columns(&self, cmd: &mut Commands, choppiness: f32) {
        for image in self.maps() {
            cmd.image_barrier(image, Use::Undefined, Use::ComputeReadWrite);
        }
        let [displacement, slopes, joint] = &self.levels[0];
        cmd.bind(
            &self.columns,
            &[
                ("Twiddles", Descriptor::Storage(&self.twiddles)),
                ("Lines", Descriptor::Storage(&self.lines)),
                ("displacement", Descriptor::StorageImage(displacement)),
                ("slopes", Descriptor::StorageImage(slopes)),
                ("joint", Descriptor::StorageImage(joint)),
                ("Cascades", Descriptor::Storage(&self.cascades)),
            ],
        );
        cmd.push_constants(&Choppiness { choppiness });
        cmd.dispatch([self.resolution, self.count, 1]);
    }

    /// Makes the coarser levels from the finest level, and leaves all levels in [`Use::Sampled`].
    pub fn record_mips(&self, cmd: &mut Commands) {
        for image in self.maps() {
            cmd.transition(image, Use::ComputeReadWrite);
        }
        for pair in self.levels.windows(2) {
            let [width, height] = pair[1][0].extent();
            let names =
                ["fine_displacement", "fine_slopes", "fine_joint", "displacement", "slopes", "joint"].into_iter();
            let images: Vec<_> = names.zip(pair.iter().flatten().map(Descriptor::StorageImage)).collect();
            cmd.bind(&self.mips, &images);
            cmd.dispatch_invocations(&self.mips, [width, height, self.count]);
            cmd.memory_barrier(Use::ComputeWrite, Use::ComputeRead);
        }
        for image in self.maps() {
            cmd.transition(image, Use::Sampled);
        }
    }

    fn maps(&self) -> [&Image; 3] {
        [&self.displacement, &self.slopes, &self.joint]
    }
}
