//! The output of the geometry stages for each pixel.

use std::sync::Arc;

use ash::vk;

use super::begin::Begin;
use super::tiles::Tiles;
use crate::gpu::{Commands, Gpu, Image, ImageDesc, Result, Use};

/// The output of the geometry stages for each pixel: 52 bytes, all that filtering its maps needs.
#[derive(Clone)]
pub struct VisibleSurface {
    /// Texture coordinate and derivatives; RGBA32UI.
    pub texture: Image,
    /// Displacement direction and tangents; RGBA32UI.
    pub tangent: Image,
    /// Object and patch (0 where there is no surface), macro curvature, accessibility, colour; RGBA32UI.
    pub surface: Image,
    /// Reversed depth, 0 where there is no surface; D32F.
    pub depth: Image,
    /// The content of its tiles, once [`TilePass`](crate::render::passes::tiles::TilePass) has run.
    pub tiles: Tiles,
}

impl VisibleSurface {
    /// Format of the colour targets.
    pub const FORMAT: vk::Format = vk::Format::R32G32B32A32_UINT;

    /// Targets of `size` pixels.
    ///
    /// # Errors
    /// Memory that is short.
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32)) -> Result<Self> {
        let color = |name: &str| Image::new(gpu, name, ImageDesc::new(Self::FORMAT, size.0, size.1).color_target());
        // The edge pass writes its marks here.
        let surface = ImageDesc::new(Self::FORMAT, size.0, size.1).color_target().storage();
        let depth = ImageDesc::new(vk::Format::D32_SFLOAT, size.0, size.1).depth_target();
        Ok(Self {
            texture: color("visible texture")?,
            tangent: color("visible tangent")?,
            surface: Image::new(gpu, "visible surface", surface)?,
            depth: Image::new(gpu, "depth", depth)?,
            tiles: Tiles::new(gpu, size)?,
        })
    }

    /// The colour targets, in the order of their attachments.
    #[must_use]
    pub fn colors(&self) -> [&Image; 3] {
        [&self.texture, &self.tangent, &self.surface]
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
