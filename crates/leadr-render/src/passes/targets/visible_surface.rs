//! The output of the geometry stages for each pixel, and the targets of these stages.

use std::sync::Arc;

use leadr_gpu::vk;

use super::begin::Begin;
use super::tiles::Tiles;
use leadr_gpu::{Commands, Gpu, Image, ImageDesc, Result, Use};

/// The format of the object depth.
pub const OBJECT_FORMAT: vk::Format = vk::Format::D16_UNORM;

const DEPTH_FORMAT: vk::Format = vk::Format::D32_SFLOAT;

/// The targets of the geometry stages. Clones share the images.
#[derive(Clone)]
pub struct GeometryTargets {
    /// The image of [`VisibleSurface::surface`].
    pub surface: Image,
    /// The image of [`VisibleSurface::footprint`].
    pub footprint: Image,
    /// The reversed depth, which is 0 where there is no surface, as D32F.
    pub depth: Image,
}

impl GeometryTargets {
    /// The formats of the colour targets.
    pub const FORMATS: [vk::Format; 2] = [vk::Format::R32G32B32A32_UINT, vk::Format::R32G32_UINT];

    /// Creates targets of `size` pixels, with `samples` samples in each pixel.
    ///
    /// # Errors
    /// Returns an error if memory is short, or if the device does not support the sample count.
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32), samples: u32) -> Result<Self> {
        let image = |format| ImageDesc::new(format, size.0, size.1).samples(samples);
        let [surface, footprint] = Self::FORMATS.map(|format| image(format).color_target());
        // The edge pass writes its marks into this image.
        let surface = if samples == 1 { surface.storage() } else { surface };
        let depth = image(DEPTH_FORMAT).depth_target();
        Ok(Self {
            surface: Image::new(gpu, "visible surface", surface)?,
            footprint: Image::new(gpu, "visible footprint", footprint)?,
            depth: Image::new(gpu, "depth", depth)?,
        })
    }

    /// Returns a bit mask of the supported sample counts, which are powers of two.
    pub fn possible_samples(gpu: &Gpu) -> u32 {
        let colors = Self::FORMATS.map(|format| ImageDesc::new(format, 1, 1).color_target());
        let all = colors.into_iter().chain([ImageDesc::new(DEPTH_FORMAT, 1, 1).depth_target()]);
        all.map(|desc| gpu.image_samples(desc.format, desc.usage)).fold(u32::MAX, |all, some| all & some)
    }

    /// Runs `draw`, which draws one kind of surface into the targets. Leaves the targets readable.
    pub fn draw(&self, cmd: &mut Commands, begin: Begin, draw: impl FnOnce(&mut Commands)) {
        let colors = [&self.surface, &self.footprint].map(|image| begin.color(cmd, image));
        let depth = begin.depth(cmd, &self.depth);
        cmd.begin_rendering(&colors, Some(depth));
        draw(cmd);
        cmd.end_rendering();
        for image in [&self.surface, &self.footprint, &self.depth] {
            cmd.transition(image, Use::Sampled);
        }
    }
}

/// The output of the geometry stages, with 30 bytes per pixel. Small triangles overwrite many pixels, so the geometry stages write
/// little data, and the filter pass computes all further inputs.
#[derive(Clone)]
pub struct VisibleSurface {
    /// An RGBA32UI image with the object and patch (0 in empty pixels), the position on the patch (two words), and one more word: a
    /// word for the pixel, the displacement direction of an edge sample, or the depth of multisampled geometry at the centre of the
    /// pixel.
    pub surface: Image,
    /// An RG32UI image with the derivative of the position by pixel for the sea and for edge samples, or the displacement direction
    /// of further multisampled surfaces.
    pub footprint: Image,
    /// The reversed depth, which is 0 in empty pixels.
    pub depth: Image,
    /// A D16 image with the object of each pixel as a depth (`passes/object_depth.glsl`).
    /// [`ObjectDepthPass`](crate::passes::object_depth::ObjectDepthPass) writes it.
    pub objects: Image,
    /// The contents of the tiles, which [`TilePass`](crate::passes::tiles::TilePass) writes.
    pub tiles: Tiles,
}

impl VisibleSurface {
    /// Creates images of `size` pixels into which the geometry stages draw.
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32)) -> Result<Self> {
        Self::with(gpu, size, GeometryTargets::new(gpu, size, 1)?)
    }

    /// Creates images of `size` pixels that the [`MsaaPass`](crate::passes::msaa::MsaaPass) writes.
    pub fn stored(gpu: &Arc<Gpu>, size: (u32, u32)) -> Result<Self> {
        let image = |name, format| Image::new(gpu, name, ImageDesc::new(format, size.0, size.1).storage());
        let [surface, footprint] = GeometryTargets::FORMATS;
        let stored = GeometryTargets {
            surface: image("visible surface", surface)?,
            footprint: image("visible footprint", footprint)?,
            depth: image("depth", vk::Format::R32_SFLOAT)?,
        };
        Self::with(gpu, size, stored)
    }

    fn with(gpu: &Arc<Gpu>, size: (u32, u32), geometry: GeometryTargets) -> Result<Self> {
        let GeometryTargets { surface, footprint, depth } = geometry;
        let objects = Image::new(gpu, "objects", ImageDesc::new(OBJECT_FORMAT, size.0, size.1).depth_target())?;
        Ok(Self { surface, footprint, depth, objects, tiles: Tiles::new(gpu, size)? })
    }

    /// Returns the targets of the geometry stages.
    pub fn geometry(&self) -> GeometryTargets {
        let Self { surface, footprint, depth, .. } = self;
        GeometryTargets { surface: surface.clone(), footprint: footprint.clone(), depth: depth.clone() }
    }
}
