//! The moments pass: turns heights on the GPU into LEADR maps (LEADR section 3) with all their mips, in three images:
//!
//! * slopes, RGBA: `E[hs], E[ht], E[hs²], E[ht²]`
//! * joint, R: `E[hs·ht]`
//! * heights, R: the mean
//!
//! No pass needs the last two together: the filter pass reads the moments, the geometry pass the heights.
//!
//! Slopes are per unit of texture coordinate, the whole image being `[0, 1]²`, in the heights' unit.
//! [`crate::maps::moments`] computes the same on the CPU in 64 bits.

use std::sync::Arc;

use half::f16;

use super::patch_mesh::TileLayout;
use crate::gpu::vk::Format;
use crate::gpu::{
    AddressMode, Commands, ComputePipeline, Descriptor, Filter, Gpu, GpuError, Image, ImageDesc, ImageView, Result,
    Sampler, SharedStruct, SpecValue, Use, shared_struct,
};
use crate::maps::{HeightMap, Wrap};
use crate::render::constants::{MOMENTS_ATLAS, MOMENTS_CLAMP, MOMENTS_REPEAT};

/// What lies beyond the edges of the height map.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Edges {
    /// The same as for the sampler that will read the map.
    Wrap(Wrap),
    /// Separate tiles: differences at the edge of a tile are one-sided, and the mips end where a tile is one texel.
    Atlas(TileLayout),
}

/// How the moments are stored.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum MomentFormat {
    /// RGBA32F and R32F.
    #[default]
    Float32,
    /// RGBA16F and R16F: half the memory. Heights keep 11 bits, moments beyond ±65504 are clamped, and a small variance
    /// under a large mean slope is lost (`E[x²] − E[x]²` cancels); `tests/render/moments.rs` measures the error.
    Float16,
}

impl MomentFormat {
    /// Formats of the slopes, and of the two maps with one channel.
    fn formats(self) -> [Format; 2] {
        match self {
            Self::Float32 => [Format::R32G32B32A32_SFLOAT, Format::R32_SFLOAT],
            Self::Float16 => [Format::R16G16B16A16_SFLOAT, Format::R16_SFLOAT],
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

/// Heights to upload, row-major, row 0 on top.
#[derive(Clone, Copy, Debug)]
pub struct HeightSource<'a> {
    /// Texels across.
    pub width: u32,
    /// Texels down.
    pub height: u32,
    /// `width · height` finite heights.
    pub texels: &'a [f32],
}

impl<'a> From<&'a HeightMap> for HeightSource<'a> {
    fn from(map: &'a HeightMap) -> Self {
        Self { width: map.width, height: map.height, texels: &map.texels }
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

/// The pass: pipelines for one kind of edge and one format, shared by any number of maps.
pub struct MomentsPass {
    level0: ComputePipeline,
    /// From levels of which a side is odd, and from others.
    mips: [ComputePipeline; 2],
    sampler: Sampler,
    edges: Edges,
    format: MomentFormat,
}

impl MomentsPass {
    /// Creates the pipelines.
    ///
    /// # Errors
    /// A failed Vulkan call.
    pub fn new(gpu: &Arc<Gpu>, edges: Edges, format: MomentFormat) -> Result<Self> {
        let kind = match edges {
            Edges::Wrap(Wrap::Repeat) => MOMENTS_REPEAT,
            Edges::Wrap(Wrap::Clamp) => MOMENTS_CLAMP,
            Edges::Atlas(_) => MOMENTS_ATLAS,
        };
        let [level0, mips] = format.shaders();
        let mip = |even| ComputePipeline::new(gpu, mips, &[("EVEN", SpecValue::Bool(even))], &[]);
        Ok(Self {
            level0: ComputePipeline::new(gpu, level0, &[("EDGES", SpecValue::U32(kind))], &[Push::LAYOUT])?,
            mips: [mip(false)?, mip(true)?],
            sampler: Sampler::new(gpu, "heights", Filter::Nearest, AddressMode::ClampToEdge)?,
            edges,
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
    /// Uploads heights and computes their maps with all mips; waits until it is done. Besides the maps it needs memory for
    /// one copy of the heights, which is freed on return.
    ///
    /// # Errors
    /// [`GpuError::Usage`] when the texels do not fill the size, or the size of the atlas differs; [`GpuError::Allocation`]
    /// when memory is short; a failed submission.
    pub fn new(gpu: &Arc<Gpu>, source: HeightSource<'_>, edges: Edges, format: MomentFormat) -> Result<Self> {
        Self::with_pass(gpu, &Arc::new(MomentsPass::new(gpu, edges, format)?), source)
    }

    /// Uploads heights whose slopes are told: `slopes`, per unit of texture coordinate in the heights' unit, one for each height. A
    /// texel has one slope, as a texel of a normal map is one facet; levels and interpolation are those of its moments.
    ///
    /// # Errors
    /// As [`new`](Self::new), and [`GpuError::Usage`] when there are not as many slopes as heights.
    pub fn with_slopes(
        gpu: &Arc<Gpu>,
        source: HeightSource<'_>,
        slopes: &[[f32; 2]],
        edges: Edges,
        format: MomentFormat,
    ) -> Result<Self> {
        let HeightSource { width, height, texels } = source;
        let expected = u64::from(width) * u64::from(height);
        if expected != texels.len() as u64 || expected != slopes.len() as u64 {
            let fault =
                format!("{} heights and {} slopes do not fill {width}x{height} texels", texels.len(), slopes.len());
            return Err(GpuError::Usage { name: "height map".to_owned(), fault });
        }
        let map = Self::empty(gpu, &Arc::new(MomentsPass::new(gpu, edges, format)?), width, height)?;
        // Within the format, as the pass has them.
        let limit = format.limit();
        let stored = |image: &Image, values: &mut dyn Iterator<Item = f32>| {
            let values = values.map(|v| v.clamp(-limit, limit));
            match format {
                MomentFormat::Float32 => image.write(0, 0, &values.collect::<Vec<f32>>()),
                MomentFormat::Float16 => image.write(0, 0, &values.map(f16::from_f32).collect::<Vec<f16>>()),
            }
        };
        stored(&map.slopes, &mut slopes.iter().flat_map(|&[x, y]| [x, y, x * x, y * y]))?;
        stored(&map.joint, &mut slopes.iter().map(|&[x, y]| x * y))?;
        stored(&map.heights, &mut texels.iter().copied())?;
        gpu.submit("moments of slopes", |cmd| {
            for image in [&map.slopes, &map.joint, &map.heights] {
                cmd.transition(image, Use::ComputeReadWrite);
            }
            map.record_mips(cmd);
        })?;
        Ok(map)
    }

    /// As [`new`](Self::new), with the pipelines of `pass`.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn with_pass(gpu: &Arc<Gpu>, pass: &Arc<MomentsPass>, source: HeightSource<'_>) -> Result<Self> {
        let HeightSource { width, height, texels } = source;
        if u64::from(width) * u64::from(height) != texels.len() as u64 {
            let fault = format!("{} heights do not fill {width}x{height} texels", texels.len());
            return Err(GpuError::Usage { name: "height map".to_owned(), fault });
        }
        let map = Self::empty(gpu, pass, width, height)?;
        let heights = Image::new(gpu, "heights", ImageDesc::new(Format::R32_SFLOAT, width, height))?;
        heights.write(0, 0, texels)?;
        gpu.submit("moments", |cmd| map.record(cmd, heights.whole()))?;
        Ok(map)
    }

    /// Maps of this size with undefined content, for [`record`](Self::record) to fill.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn empty(gpu: &Arc<Gpu>, pass: &Arc<MomentsPass>, width: u32, height: u32) -> Result<Self> {
        let [slopes, single] = pass.format.formats();
        let mut desc = ImageDesc::new(slopes, width, height).storage().full_mips();
        if let Edges::Atlas(tiles) = pass.edges {
            if tiles.size() != (width, height) || !tiles.tile.is_power_of_two() {
                let (w, h) = tiles.size();
                let fault = format!("{width}x{height} texels are not the atlas's {w}x{h} of tiles of {}", tiles.tile);
                return Err(GpuError::Usage { name: "height atlas".to_owned(), fault });
            }
            desc = desc.mips(tiles.tile.ilog2() + 1);
        }
        let slopes = Image::new(gpu, "LEADR slopes", desc)?;
        let joint = Image::new(gpu, "LEADR joint", ImageDesc { format: single, ..desc })?;
        let heights = Image::new(gpu, "LEADR heights", ImageDesc { format: single, ..desc })?;
        let levels = (0..desc.mips)
            .map(|mip| Ok([slopes.mip_layer(mip, 0)?, joint.mip_layer(mip, 0)?, heights.mip_layer(mip, 0)?]))
            .collect::<Result<Vec<_>>>()?;
        Ok(Self { pass: pass.clone(), slopes, joint, heights, levels })
    }

    /// Computes all levels from `heights` (R32F, of the maps' size, in [`Use::Sampled`]) and leaves the images in
    /// [`Use::Sampled`]. It may be recorded again whenever the heights change.
    pub fn record(&self, cmd: &mut Commands, heights: &ImageView) {
        let MomentsPass { level0, sampler, edges, format, .. } = &*self.pass;
        if heights.extent() != self.levels[0][0].extent() {
            let fault = format!("{:?} heights do not fill {:?} texels", heights.extent(), self.levels[0][0].extent());
            return cmd.fail(GpuError::Usage { name: "LEADR maps".to_owned(), fault });
        }
        for image in [&self.slopes, &self.joint, &self.heights] {
            // the earlier content is not needed, but its readers must be done
            cmd.image_barrier(image, Use::Undefined, Use::ComputeReadWrite);
        }
        let tile = if let Edges::Atlas(tiles) = edges { tiles.tile } else { 0 };
        let [slopes, joint, means] = &self.levels[0];
        let [width, height] = slopes.extent();
        cmd.bind(
            level0,
            &[
                ("heights", Descriptor::Sampled(heights, sampler)),
                ("slopes", Descriptor::StorageImage(slopes)),
                ("joint", Descriptor::StorageImage(joint)),
                ("mean_height", Descriptor::StorageImage(means)),
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
            let even = fine_slopes.extent().iter().all(|side| side % 2 == 0);
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
            cmd.dispatch_invocations(mips, [width, height, 1]);
        }
        for image in [&self.slopes, &self.joint, &self.heights] {
            cmd.transition(image, Use::Sampled);
        }
    }

    /// `E[hs], E[ht], E[hs²], E[ht²]` with mips, ready to be sampled.
    #[must_use]
    pub fn slopes(&self) -> &Image {
        &self.slopes
    }

    /// `E[hs·ht]` with mips, ready to be sampled.
    #[must_use]
    pub fn joint(&self) -> &Image {
        &self.joint
    }

    /// Mean heights with mips, ready to be sampled.
    #[must_use]
    pub fn heights(&self) -> &Image {
        &self.heights
    }

    /// Number of mip levels of the images.
    #[must_use]
    pub fn levels(&self) -> u32 {
        self.levels.len() as u32
    }
}
