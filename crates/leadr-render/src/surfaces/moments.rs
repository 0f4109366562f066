//! LEADR maps on the device (LEADR section 4.1), stored with all mips in three images:
//!
//! * slopes, RGBA: `E[hs], E[ht], E[hs²], E[ht²]`
//! * joint, R: `E[hs·ht]`
//! * heights, R: the mean height
//!
//! The moments pass computes the images from heights, or they come from a file.
//!
//! Heights are stored apart from the moments because no pass needs both. The filter pass reads the moments, and the geometry pass
//! reads the heights.
//!
//! Slopes are heights per unit of texture coordinate, where the whole image spans `[0, 1]²`. On the CPU, [`leadr_maps::moments`]
//! computes values that are identical to the last bit.

use std::sync::Arc;

use half::f16;

use super::displacement::{Border, HeightField};
use super::floats;
use crate::constants::{MOMENTS_ATLAS, MOMENTS_CLAMP, MOMENTS_REPEAT};
use leadr_gpu::vk::Format;
use leadr_gpu::{
    Commands, ComputePipeline, Descriptor, Gpu, GpuError, Image, ImageDesc, ImageView, Result, SharedStruct, SpecValue,
    Use, shared_struct,
};
use leadr_maps::{HeightMap, LeadrMap, halves};

/// The format in which the moments are stored. Heights always have 32 bits, because the geometry uses them.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MomentFormat {
    /// The moments are 32-bit floats, in RGBA32F and R32F images.
    #[default]
    Float32,
    /// The moments are 16-bit floats, in RGBA16F and R16F images, which need half the memory. Moments beyond ±65504 are clamped.
    /// Variances below about 2⁻¹² of the squared mean slope are lost, because `E[x²] − E[x]²` cancels. `tests/render/moments.rs`
    /// measures the error. Heights are rescaled so that slopes fill the range.
    Float16,
}

impl MomentFormat {
    /// Returns the image formats for the slope moments and for the mixed moment.
    fn formats(self) -> [Format; 2] {
        match self {
            Self::Float32 => [Format::R32G32B32A32_SFLOAT, Format::R32_SFLOAT],
            Self::Float16 => [Format::R16G16B16A16_SFLOAT, Format::R16_SFLOAT],
        }
    }

    /// Returns the number of bytes per texel, including the height.
    pub const fn texel_bytes(self) -> u64 {
        match self {
            Self::Float32 => 24,
            Self::Float16 => 14,
        }
    }

    /// Returns the name of the format on the command line.
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
        /// The number of texels along one side of an atlas tile.
        tile: u32,
        /// The largest magnitude that the format can store.
        limit: f32,
    }
}

shared_struct! {
    struct MipPush for "Push" {
        /// The reciprocals of the width and the height of the finer level.
        share: [f32; 2],
    }
}

/// LEADR maps on the device. Clones share the images.
#[derive(Clone)]
pub struct LeadrMapGpu {
    /// The moments `E[hs], E[ht], E[hs²], E[ht²]` with mips, ready to be sampled.
    pub slopes: Image,
    /// The mixed moment `E[hs·ht]` with mips, ready to be sampled.
    pub joint: Image,
    /// The mean heights with mips, ready to be sampled.
    pub heights: Image,
    format: MomentFormat,
}

impl LeadrMapGpu {
    /// Uploads heights, computes their maps with all mips, and waits until the maps are complete.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if the number of texels does not match the size, or if the size does not match the atlas.
    /// Returns [`GpuError::Allocation`] if memory is short.
    pub fn new(gpu: &Arc<Gpu>, heights: &HeightMap, border: Border, format: MomentFormat) -> Result<Self> {
        let &HeightMap { width, height, ref texels } = heights;
        if u64::from(width) * u64::from(height) != texels.len() as u64 {
            let fault = format!("{} heights do not match {width}x{height} texels", texels.len());
            return Err(GpuError::usage("height map", fault));
        }
        let map = Self::empty(gpu, [width, height], border, format)?;
        map.heights.write(0, 0, texels)?;
        let (kind, tile) = match border {
            Border::Wrap => (MOMENTS_REPEAT, 0),
            Border::Clamp => (MOMENTS_CLAMP, 0),
            Border::Tiles(tiles) => (MOMENTS_ATLAS, tiles.tile),
        };
        let [shader, _] = format.shaders();
        let finest = ComputePipeline::new(gpu, shader, &[("EDGES", SpecValue::U32(kind))], &[Push::LAYOUT])?;
        map.compute(gpu, |cmd, level| {
            cmd.bind(&finest, &bindings(["slopes", "joint", "heights"], level));
            cmd.push_constants(&Push { tile, limit: format.limit() });
            cmd.dispatch_invocations(&finest, [width, height, 1]);
        })?;
        Ok(map)
    }

    /// Uploads heights and `slopes`. There is one slope for each height, in height units per unit of texture coordinate. Each texel
    /// has a single slope, as in a normal map, and mips and interpolation use the moments of the slopes. `spread` is an additional
    /// variance `(ss, tt, st)` for each texel.
    ///
    /// # Errors
    /// Returns the errors of [`new`](Self::new). Returns [`GpuError::Usage`] if there are different numbers of slopes, spreads and
    /// heights.
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
                format!("{} heights and {} slopes do not match {width}x{height} texels", texels.len(), slopes.len());
            return Err(GpuError::usage("height map", fault));
        }
        let map = Self::empty(gpu, [width, height], border, format)?;
        let about = |i: usize| spread.map_or([0.0; 3], |spread| spread[i]);
        let moments = |(i, &[x, y]): (usize, &[f32; 2])| {
            let [ss, tt, st] = about(i);
            ([x, y, x * x + ss, y * y + tt], x * y + st)
        };
        map.write(0, slopes.iter().enumerate().map(moments))?;
        map.heights.write(0, 0, texels)?;
        map.compute(gpu, |_, _| ())?;
        Ok(map)
    }

    /// Uploads moments of all levels that were computed before.
    ///
    /// # Errors
    /// Returns the errors of [`new`](Self::new). Returns [`GpuError::Usage`] if levels are missing or have the wrong size.
    pub fn with_moments(gpu: &Arc<Gpu>, moments: &LeadrMap, border: Border, format: MomentFormat) -> Result<Self> {
        let wrong = |fault: String| GpuError::usage("LEADR map", fault);
        let Some(first) = moments.levels.first() else { return Err(wrong("it has no levels".to_owned())) };
        let map = Self::empty(gpu, [first.width, first.height], border, format)?;
        if moments.levels.len() != map.levels() as usize {
            return Err(wrong(format!("it has {} levels instead of {}", moments.levels.len(), map.levels())));
        }
        for (mip, level) in (0..).zip(&moments.levels) {
            let [width, height] = map.heights.mip_extent(mip);
            let texels = level.texels.len() as u64;
            if [level.width, level.height] != [width, height] || texels != u64::from(width) * u64::from(height) {
                return Err(wrong(format!("level {mip} has {texels} texels instead of {width}x{height}")));
            }
            let texels = level.texels.iter();
            map.write(mip, texels.map(|m| ([m.mean_slope[0], m.mean_slope[1], m.second[0], m.second[1]], m.cross)))?;
            map.heights.write(mip, 0, &level.texels.iter().map(|m| m.height).collect::<Vec<f32>>())?;
        }
        Ok(map)
    }

    /// Writes the moments of a level.
    fn write(&self, mip: u32, moments: impl Iterator<Item = ([f32; 4], f32)>) -> Result<()> {
        match self.format {
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

    /// Reads back the moments `E[hs], E[ht], E[hs²], E[ht²]` of a level.
    pub fn read_slopes(&self, mip: u32) -> Result<Vec<[f32; 4]>> {
        match self.format {
            MomentFormat::Float32 => self.slopes.read(mip, 0),
            MomentFormat::Float16 => floats(&self.slopes, mip),
        }
    }

    /// Reads back the mixed moment of a level.
    pub fn read_joint(&self, mip: u32) -> Result<Vec<f32>> {
        Ok(match self.format {
            MomentFormat::Float32 => self.joint.read(mip, 0)?,
            MomentFormat::Float16 => self.joint.read::<f16>(mip, 0)?.into_iter().map(f16::to_f32).collect(),
        })
    }

    /// Creates maps of this size, whose content is undefined.
    fn empty(gpu: &Arc<Gpu>, [width, height]: [u32; 2], border: Border, format: MomentFormat) -> Result<Self> {
        let [slopes, joint] = format.formats();
        let mut desc = ImageDesc::new(slopes, width, height).storage().full_mips();
        if let Border::Tiles(tiles) = border {
            if tiles.size() != (width, height) || !tiles.tile.is_power_of_two() {
                let (w, h) = tiles.size();
                let fault =
                    format!("the map has {width}x{height} texels; the atlas has {w}x{h} in tiles of {}", tiles.tile);
                return Err(GpuError::usage("height atlas", fault));
            }
            desc = desc.mips(tiles.tile.ilog2() + 1);
        }
        Ok(Self {
            slopes: Image::new(gpu, "LEADR slopes", desc)?,
            joint: Image::new(gpu, "LEADR joint", ImageDesc { format: joint, ..desc })?,
            heights: Image::new(gpu, "LEADR heights", ImageDesc { format: Format::R32_SFLOAT, ..desc })?,
            format,
        })
    }

    /// Calls `finest` to record the commands that complete the finest level. Then computes the other levels, and leaves the images
    /// in [`Use::Sampled`].
    fn compute(&self, gpu: &Arc<Gpu>, finest: impl FnOnce(&mut Commands, &[ImageView; 3])) -> Result<()> {
        let images = [&self.slopes, &self.joint, &self.heights];
        let level =
            |mip| Ok([images[0].mip_layer(mip, 0)?, images[1].mip_layer(mip, 0)?, images[2].mip_layer(mip, 0)?]);
        let levels = (0..self.levels()).map(level).collect::<Result<Vec<_>>>()?;
        let [_, shader] = self.format.shaders();
        let pipeline = |even| ComputePipeline::new(gpu, shader, &[("EVEN", SpecValue::Bool(even))], &[MipPush::LAYOUT]);
        // The first pipeline is for source levels with an odd width or height, and the second is for all others.
        let pipelines = [pipeline(false)?, pipeline(true)?];
        gpu.submit("moments", |cmd| {
            images.into_iter().for_each(|image| cmd.transition(image, Use::ComputeReadWrite));
            finest(cmd, &levels[0]);
            for pair in levels.windows(2) {
                let [fine, coarse] = pair else { continue };
                let size = fine[0].extent();
                let pipeline = &pipelines[usize::from(size.iter().all(|side| side % 2 == 0))];
                let [width, height] = coarse[0].extent();
                cmd.memory_barrier(Use::ComputeWrite, Use::ComputeRead);
                let sources = bindings(["fine_slopes", "fine_joint", "fine_height"], fine);
                cmd.bind(pipeline, &[sources, bindings(["slopes", "joint", "mean_height"], coarse)].concat());
                cmd.push_constants(&MipPush { share: size.map(|side| 1.0 / side as f32) });
                cmd.dispatch_invocations(pipeline, [width, height, 1]);
            }
            images.into_iter().for_each(|image| cmd.transition(image, Use::Sampled));
        })
    }

    /// Returns the number of mip levels of the images.
    pub fn levels(&self) -> u32 {
        self.slopes.desc().mips
    }
}

/// Returns the three images of a level, each with its name in the shaders.
fn bindings<'a>(names: [&'static str; 3], level: &'a [ImageView; 3]) -> [(&'static str, Descriptor<'a>); 3] {
    std::array::from_fn(|i| (names[i], Descriptor::StorageImage(&level[i])))
}

/// Creates the LEADR maps of a height field.
pub(super) fn field_maps(
    gpu: &Arc<Gpu>,
    field: &HeightField,
    slopes: Option<Vec<[f32; 2]>>,
    spread: Option<Vec<[f32; 3]>>,
    moments: Option<LeadrMap>,
    format: MomentFormat,
) -> Result<LeadrMapGpu> {
    let HeightField { map, border } = field;
    match (moments, slopes) {
        (Some(moments), _) => LeadrMapGpu::with_moments(gpu, &moments, *border, format),
        (None, Some(slopes)) => LeadrMapGpu::with_slopes(gpu, map, &slopes, spread.as_deref(), *border, format),
        (None, None) => LeadrMapGpu::new(gpu, map, *border, format),
    }
}
