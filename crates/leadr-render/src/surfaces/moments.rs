//! LEADR maps on the device (LEADR section 3) with all their mips, in three images:
//!
//! * slopes, RGBA: `E[hs], E[ht], E[hs²], E[ht²]`
//! * joint, R: `E[hs·ht]`
//! * heights, R: the mean
//!
//! The moments pass makes them of heights, or they come from a file.
//!
//! No pass needs the last two together: the filter pass reads the moments, the geometry pass the heights.
//!
//! Slopes are per unit of texture coordinate, the whole image being `[0, 1]²`, in the heights' unit.
//! [`leadr_maps::moments`] computes the same on the CPU, to the last bit.

use std::sync::Arc;

use half::f16;

use super::displacement::{Border, HeightField};
use crate::constants::{MOMENTS_ATLAS, MOMENTS_CLAMP, MOMENTS_REPEAT};
use leadr_gpu::vk::Format;
use leadr_gpu::{
    Commands, ComputePipeline, Descriptor, Gpu, GpuError, Image, ImageDesc, ImageView, Result, SharedStruct, SpecValue,
    Use, shared_struct,
};
use leadr_maps::{HeightMap, LeadrMap, halves};

/// How the moments are stored. Heights have 32 bits always: the geometry follows them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MomentFormat {
    /// RGBA32F and R32F.
    #[default]
    Float32,
    /// RGBA16F and R16F: half the memory. Moments beyond ±65504 are clamped, and a variance below some 2⁻¹² of the square of the mean
    /// slope is lost (`E[x²] − E[x]²` cancels); `tests/render/moments.rs` measures the error. Objects scale their heights so that
    /// slopes fill the range.
    Float16,
}

impl MomentFormat {
    /// Formats of the slopes, and of their mixed moment.
    fn formats(self) -> [Format; 2] {
        match self {
            Self::Float32 => [Format::R32G32B32A32_SFLOAT, Format::R32_SFLOAT],
            Self::Float16 => [Format::R16G16B16A16_SFLOAT, Format::R16_SFLOAT],
        }
    }

    /// Bytes of a texel, its height included.
    pub const fn texel_bytes(self) -> u64 {
        match self {
            Self::Float32 => 24,
            Self::Float16 => 14,
        }
    }

    /// Its name on the command line.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Float32 => "f32",
            Self::Float16 => "f16",
        }
    }

    fn limit(self) -> f32 {
        match self {
            Self::Float32 => f32::MAX,
            Self::Float16 => 65504.0,
        }
    }

    fn shaders(self) -> [&'static str; 2] {
        match self {
            Self::Float32 => ["passes/surfaces/moments.comp", "passes/surfaces/moments_mips.comp"],
            Self::Float16 => ["passes/surfaces/moments_half.comp", "passes/surfaces/moments_mips_half.comp"],
        }
    }
}

shared_struct! {
    struct Push for "Push" {
        /// Texels along a tile of an atlas.
        tile: u32,
        /// Largest magnitude of the format.
        limit: f32,
    }
}

shared_struct! {
    struct MipPush for "Push" {
        /// One over the texels of the finer level, across and down.
        share: [f32; 2],
    }
}

/// The pass: pipelines for one kind of border and one format, shared by any number of maps.
pub struct MomentsPass {
    level0: ComputePipeline,
    /// From levels of which a side is odd, and from others.
    mips: [ComputePipeline; 2],
    border: Border,
    format: MomentFormat,
}

impl MomentsPass {
    /// Creates the pipelines.
    pub fn new(gpu: &Arc<Gpu>, border: Border, format: MomentFormat) -> Result<Self> {
        let kind = match border {
            Border::Wrap => MOMENTS_REPEAT,
            Border::Clamp => MOMENTS_CLAMP,
            Border::Tiles(_) => MOMENTS_ATLAS,
        };
        let [level0, mips] = format.shaders();
        let mip = |even| ComputePipeline::new(gpu, mips, &[("EVEN", SpecValue::Bool(even))], &[MipPush::LAYOUT]);
        Ok(Self {
            level0: ComputePipeline::new(gpu, level0, &[("EDGES", SpecValue::U32(kind))], &[Push::LAYOUT])?,
            mips: [mip(false)?, mip(true)?],
            border,
            format,
        })
    }
}

/// LEADR maps on the GPU.
pub struct LeadrMapGpu {
    pass: Arc<MomentsPass>,
    slopes: Image,
    joint: Image,
    heights: Image,
    /// Views of every level of the images, for the dispatches.
    levels: Vec<[ImageView; 3]>,
}

impl LeadrMapGpu {
    /// Uploads heights and computes their maps with all mips; waits until it is done.
    ///
    /// # Errors
    /// [`GpuError::Usage`] when the texels do not fill the size, or the size of the atlas differs; [`GpuError::Allocation`]
    /// when memory is short; a failed submission.
    pub fn new(gpu: &Arc<Gpu>, heights: &HeightMap, border: Border, format: MomentFormat) -> Result<Self> {
        let &HeightMap { width, height, ref texels } = heights;
        if u64::from(width) * u64::from(height) != texels.len() as u64 {
            let fault = format!("{} heights do not fill {width}x{height} texels", texels.len());
            return Err(GpuError::Usage { name: "height map".to_owned(), fault });
        }
        let map = Self::empty(gpu, &Arc::new(MomentsPass::new(gpu, border, format)?), width, height)?;
        map.heights.write(0, 0, texels)?;
        gpu.submit("moments", |cmd| map.record(cmd))?;
        Ok(map)
    }

    /// Uploads heights whose slopes are told: `slopes`, per unit of texture coordinate in the heights' unit, one for each height. A
    /// texel has one slope, as a texel of a normal map is one facet; levels and interpolation are those of its moments. `spread`: further
    /// variance about each, `(ss, tt, st)`.
    ///
    /// # Errors
    /// As [`new`](Self::new), and [`GpuError::Usage`] when there are not as many slopes as heights, or another number of spreads.
    pub fn with_slopes(
        gpu: &Arc<Gpu>,
        heights: &HeightMap,
        slopes: &[[f32; 2]],
        spread: Option<&[[f32; 3]]>,
        border: Border,
        format: MomentFormat,
    ) -> Result<Self> {
        let &HeightMap { width, height, ref texels } = heights;
        let expected = u64::from(width) * u64::from(height);
        let spreads = spread.map_or(slopes.len(), <[_]>::len);
        if [texels.len(), slopes.len(), spreads].iter().any(|&count| count as u64 != expected) {
            let fault =
                format!("{} heights and {} slopes do not fill {width}x{height} texels", texels.len(), slopes.len());
            return Err(GpuError::Usage { name: "height map".to_owned(), fault });
        }
        let map = Self::empty(gpu, &Arc::new(MomentsPass::new(gpu, border, format)?), width, height)?;
        let about = |i: usize| spread.map_or([0.0; 3], |spread| spread[i]);
        let moments = |(i, &[x, y]): (usize, &[f32; 2])| {
            let [ss, tt, st] = about(i);
            ([x, y, x * x + ss, y * y + tt], x * y + st)
        };
        map.write(0, slopes.iter().enumerate().map(moments))?;
        map.heights.write(0, 0, texels)?;
        gpu.submit("moments of slopes", |cmd| {
            for image in [&map.slopes, &map.joint, &map.heights] {
                cmd.transition(image, Use::ComputeReadWrite);
            }
            map.record_mips(cmd);
        })?;
        Ok(map)
    }

    /// Uploads moments that are ready on all levels.
    ///
    /// # Errors
    /// As [`new`](Self::new), and [`GpuError::Usage`] when levels are missing or of other sizes.
    pub fn with_moments(gpu: &Arc<Gpu>, moments: &LeadrMap, border: Border, format: MomentFormat) -> Result<Self> {
        let wrong = |fault: String| GpuError::Usage { name: "LEADR map".to_owned(), fault };
        let Some(first) = moments.levels.first() else { return Err(wrong("it has no levels".to_owned())) };
        let pass = Arc::new(MomentsPass::new(gpu, border, format)?);
        let map = Self::empty(gpu, &pass, first.width, first.height)?;
        if moments.levels.len() != map.levels.len() {
            return Err(wrong(format!("it has {} levels, not {}", moments.levels.len(), map.levels.len())));
        }
        for (mip, level) in (0..).zip(&moments.levels) {
            let [width, height] = map.heights.mip_extent(mip);
            let texels = level.texels.len() as u64;
            if [level.width, level.height] != [width, height] || texels != u64::from(width) * u64::from(height) {
                return Err(wrong(format!("level {mip} has {texels} texels, not those of {width}x{height}")));
            }
            let texels = level.texels.iter();
            map.write(mip, texels.map(|m| ([m.mean_slope[0], m.mean_slope[1], m.second[0], m.second[1]], m.cross)))?;
            map.heights.write(mip, 0, &level.texels.iter().map(|m| m.height).collect::<Vec<f32>>())?;
        }
        Ok(map)
    }

    /// Stores the moments of a level.
    fn write(&self, mip: u32, moments: impl Iterator<Item = ([f32; 4], f32)>) -> Result<()> {
        match self.pass.format {
            MomentFormat::Float32 => {
                let (slopes, joint): (Vec<[f32; 4]>, Vec<f32>) = moments.unzip();
                self.slopes.write(mip, 0, &slopes)?;
                self.joint.write(mip, 0, &joint)
            }
            MomentFormat::Float16 => {
                let (slopes, joint): (Vec<[f16; 4]>, Vec<f16>) =
                    moments.map(|(slopes, joint)| halves::nearest(slopes, joint)).unzip();
                self.slopes.write(mip, 0, &slopes)?;
                self.joint.write(mip, 0, &joint)
            }
        }
    }

    /// Reads the slopes of a level back: `E[hs], E[ht], E[hs²], E[ht²]`.
    pub fn read_slopes(&self, mip: u32) -> Result<Vec<[f32; 4]>> {
        Ok(match self.pass.format {
            MomentFormat::Float32 => self.slopes.read(mip, 0)?,
            MomentFormat::Float16 => {
                self.slopes.read::<[f16; 4]>(mip, 0)?.into_iter().map(|texel| texel.map(f16::to_f32)).collect()
            }
        })
    }

    /// Reads their mixed moments back.
    pub fn read_joint(&self, mip: u32) -> Result<Vec<f32>> {
        Ok(match self.pass.format {
            MomentFormat::Float32 => self.joint.read(mip, 0)?,
            MomentFormat::Float16 => self.joint.read::<f16>(mip, 0)?.into_iter().map(f16::to_f32).collect(),
        })
    }

    /// Maps of this size with undefined content, for [`record`](Self::record) to fill.
    pub fn empty(gpu: &Arc<Gpu>, pass: &Arc<MomentsPass>, width: u32, height: u32) -> Result<Self> {
        let [slopes, joint] = pass.format.formats();
        let mut desc = ImageDesc::new(slopes, width, height).storage().full_mips();
        if let Border::Tiles(tiles) = pass.border {
            if tiles.size() != (width, height) || !tiles.tile.is_power_of_two() {
                let (w, h) = tiles.size();
                let fault = format!("{width}x{height} texels are not the atlas's {w}x{h} of tiles of {}", tiles.tile);
                return Err(GpuError::Usage { name: "height atlas".to_owned(), fault });
            }
            desc = desc.mips(tiles.tile.ilog2() + 1);
        }
        let slopes = Image::new(gpu, "LEADR slopes", desc)?;
        let joint = Image::new(gpu, "LEADR joint", ImageDesc { format: joint, ..desc })?;
        let heights = Image::new(gpu, "LEADR heights", ImageDesc { format: Format::R32_SFLOAT, ..desc })?;
        let levels = (0..desc.mips)
            .map(|mip| Ok([slopes.mip_layer(mip, 0)?, joint.mip_layer(mip, 0)?, heights.mip_layer(mip, 0)?]))
            .collect::<Result<Vec<_>>>()?;
        Ok(Self { pass: pass.clone(), slopes, joint, heights, levels })
    }

    /// Computes the moments, and all levels but the finest of the heights, from that; and leaves the images in [`Use::Sampled`]. It may
    /// be recorded again whenever the heights change.
    pub fn record(&self, cmd: &mut Commands) {
        let MomentsPass { level0, border, format, .. } = &*self.pass;
        for image in [&self.slopes, &self.joint] {
            // the earlier content is not needed, but its readers must be done
            cmd.image_barrier(image, Use::Undefined, Use::ComputeReadWrite);
        }
        cmd.transition(&self.heights, Use::ComputeReadWrite);
        let tile = if let Border::Tiles(tiles) = border { tiles.tile } else { 0 };
        let [slopes, joint, heights] = &self.levels[0];
        let [width, height] = slopes.extent();
        cmd.bind(
            level0,
            &[
                ("heights", Descriptor::StorageImage(heights)),
                ("slopes", Descriptor::StorageImage(slopes)),
                ("joint", Descriptor::StorageImage(joint)),
            ],
        );
        cmd.push_constants(&Push { tile, limit: format.limit() });
        cmd.dispatch_invocations(level0, [width, height, 1]);
        self.record_mips(cmd);
    }

    /// Computes the levels below the finest, which compute passes may still be writing, and leaves the images in
    /// [`Use::Sampled`].
    fn record_mips(&self, cmd: &mut Commands) {
        for pair in self.levels.windows(2) {
            let [[fine_slopes, fine_joint, fine_means], [slopes, joint, means]] = pair else { continue };
            let fine = fine_slopes.extent();
            let even = fine.iter().all(|side| side % 2 == 0);
            let mips = &self.pass.mips[usize::from(even)];
            let [width, height] = slopes.extent();
            cmd.memory_barrier(Use::ComputeWrite, Use::ComputeRead);
            cmd.bind(
                mips,
                &[
                    ("fine_slopes", Descriptor::StorageImage(fine_slopes)),
                    ("fine_joint", Descriptor::StorageImage(fine_joint)),
                    ("fine_height", Descriptor::StorageImage(fine_means)),
                    ("slopes", Descriptor::StorageImage(slopes)),
                    ("joint", Descriptor::StorageImage(joint)),
                    ("mean_height", Descriptor::StorageImage(means)),
                ],
            );
            cmd.push_constants(&MipPush { share: fine.map(|side| 1.0 / side as f32) });
            cmd.dispatch_invocations(mips, [width, height, 1]);
        }
        for image in [&self.slopes, &self.joint, &self.heights] {
            cmd.transition(image, Use::Sampled);
        }
    }

    /// `E[hs], E[ht], E[hs²], E[ht²]` with mips, ready to be sampled.
    pub fn slopes(&self) -> &Image {
        &self.slopes
    }

    /// `E[hs·ht]` with mips, ready to be sampled.
    pub fn joint(&self) -> &Image {
        &self.joint
    }

    /// Mean heights with mips, ready to be sampled.
    pub fn heights(&self) -> &Image {
        &self.heights
    }

    /// Number of mip levels of the images.
    pub fn levels(&self) -> u32 {
        self.levels.len() as u32
    }
}

/// The LEADR maps of a height field; without one, a placeholder with a single zero height that is never sampled.
pub(super) fn field_maps(
    gpu: &Arc<Gpu>,
    field: Option<&HeightField>,
    slopes: Option<Vec<[f32; 2]>>,
    spread: Option<Vec<[f32; 3]>>,
    moments: Option<LeadrMap>,
    format: MomentFormat,
) -> Result<LeadrMapGpu> {
    let none = HeightField { map: HeightMap { width: 1, height: 1, texels: vec![0.0] }, border: Border::Clamp };
    let HeightField { map, border } = field.unwrap_or(&none);
    match (moments, slopes) {
        (Some(moments), _) => LeadrMapGpu::with_moments(gpu, &moments, *border, format),
        (None, Some(slopes)) => LeadrMapGpu::with_slopes(gpu, map, &slopes, spread.as_deref(), *border, format),
        (None, None) => LeadrMapGpu::new(gpu, map, *border, format),
    }
}
