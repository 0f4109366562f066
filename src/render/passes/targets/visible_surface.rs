//! The output of the geometry stages for each pixel.

use std::sync::Arc;

use ash::vk;

use super::begin::Begin;
use super::tiles::Tiles;
use crate::gpu::{Commands, Gpu, Image, ImageDesc, Result, Use};

/// Format of the image of objects.
pub const OBJECT_FORMAT: vk::Format = vk::Format::D16_UNORM;

/// The output of the geometry stages for each pixel: 30 bytes. Small triangles write many pixels more than once, so they write
/// little; the filter pass works out the rest.
#[derive(Clone)]
pub struct VisibleSurface {
    /// Object and patch (0 where there is no surface), place on them, displacement direction of edge samples; RGBA32UI.
    pub surface: Image,
    /// How far the place moves from pixel to pixel, for the sea and for edge samples; RG32UI.
    pub footprint: Image,
    /// Reversed depth, 0 where there is no surface; D32F.
    pub depth: Image,
    /// Which object each pixel shows, as a depth (`passes/object_depth.glsl`), once
    /// [`ObjectDepthPass`](crate::render::passes::object_depth::ObjectDepthPass) has run; D16.
    pub objects: Image,
    /// The content of its tiles, once [`TilePass`](crate::render::passes::tiles::TilePass) has run.
    pub tiles: Tiles,
}

impl VisibleSurface {
    /// Formats of the colour targets.
    pub const FORMATS: [vk::Format; 2] = [vk::Format::R32G32B32A32_UINT, vk::Format::R32G32_UINT];

    /// Targets of `size` pixels.
    ///
    /// # Errors
    /// Memory that is short.
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32)) -> Result<Self> {
        let color = |format| ImageDesc::new(format, size.0, size.1).color_target();
        let [surface, footprint] = Self::FORMATS.map(color);
        let depth = ImageDesc::new(vk::Format::D32_SFLOAT, size.0, size.1).depth_target();
        Ok(Self {
            // The edge pass writes its marks here.
            surface: Image::new(gpu, "visible surface", surface.storage())?,
            footprint: Image::new(gpu, "visible footprint", footprint)?,
            depth: Image::new(gpu, "depth", depth)?,
            objects: Image::new(gpu, "objects", ImageDesc::new(OBJECT_FORMAT, size.0, size.1).depth_target())?,
            tiles: Tiles::new(gpu, size)?,
        })
    }

    /// The colour targets, in the order of their attachments.
    #[must_use]
    pub fn colors(&self) -> [&Image; 2] {
        [&self.surface, &self.footprint]
    }

    /// Runs `draw`, which draws one kind of surface into the targets, and leaves them readable.
    pub fn draw(&self, cmd: &mut Commands, begin: Begin, draw: impl FnOnce(&mut Commands)) {
        let colors = self.colors().map(|image| begin.color(cmd, image));
        let depth = begin.depth(cmd, &self.depth);
        cmd.begin_rendering(&colors, Some(depth));
        draw(cmd);
        cmd.end_rendering();
        for image in self.colors() {
            cmd.transition(image, Use::Sampled);
        }
        cmd.transition(&self.depth, Use::Sampled);
    }
}
