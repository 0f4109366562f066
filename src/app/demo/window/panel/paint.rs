//! Draws the triangles of the panel over a picture.

#![allow(unsafe_code)]

use std::sync::Arc;

use egui::{ClippedPrimitive, TexturesDelta};
use egui_ash_renderer::allocator::GpuAllocator;
use egui_ash_renderer::{DynamicRendering, Options, RenderMode, Renderer, RendererError};
use leadr_gpu::vk;

use leadr_gpu::{ColorTarget, Commands, FRAMES_IN_FLIGHT, Gpu, Image, Load};
use leadr_tools::command::error::AppError;

/// The triangles and texture changes of one frame of the panel.
pub struct Painted {
    /// The triangles of the panel, with their textures.
    pub primitives: Vec<ClippedPrimitive>,
    /// The new, changed and freed textures.
    pub textures: TexturesDelta,
    /// The number of pixels per point of the layout.
    pub pixels_per_point: f32,
}

impl Drop for Painted {
    /// Clears the texture changes, because egui asserts that no changes are dropped before they are applied. A frame that is not drawn does
    /// not need them.
    fn drop(&mut self) {
        self.textures.clear();
    }
}

/// The pipeline, the textures, and the vertices for the frames in flight.
pub struct PanelPainter {
    // The renderer must be dropped before the device.
    renderer: Renderer<GpuAllocator>,
    pool: vk::CommandPool,
    gpu: Arc<Gpu>,
}

fn fault(error: RendererError) -> AppError {
    AppError::Failed(format!("the panel cannot be drawn: {error}"))
}

impl PanelPainter {
    /// Creates a painter for images of `format`.
    ///
    /// # Errors
    /// If memory runs out or the pipeline cannot be created.
    pub fn new(gpu: &Arc<Gpu>, format: vk::Format) -> Result<Self, AppError> {
        let mode = RenderMode::DynamicRendering(DynamicRendering {
            color_attachment_format: format,
            depth_attachment_format: None,
            stencil_attachment_format: None,
        });
        let options = Options {
            in_flight_frames: FRAMES_IN_FLIGHT,
            srgb_framebuffer: matches!(format, vk::Format::B8G8R8A8_SRGB | vk::Format::R8G8B8A8_SRGB),
            ..Options::default()
        };
        let renderer =
            Renderer::with_gpu_allocator(gpu.shared_allocator(), gpu.raw().clone(), mode, options).map_err(fault)?;
        let info = vk::CommandPoolCreateInfo::default()
            .queue_family_index(gpu.queue_family())
            .flags(vk::CommandPoolCreateFlags::TRANSIENT);
        // SAFETY: the device is alive, and `drop` destroys the pool.
        let pool = unsafe { gpu.raw().create_command_pool(&info, None) }
            .map_err(|error| AppError::Failed(format!("the panel cannot be drawn: {error}")))?;
        Ok(Self { renderer, pool, gpu: gpu.clone() })
    }

    /// Applies the texture changes. No frame in flight may use a texture that is changed or freed.
    ///
    /// # Errors
    /// If memory runs out or the device is lost.
    pub fn update(&mut self, textures: &mut TexturesDelta) -> Result<(), AppError> {
        let queue = self.gpu.queue();
        for (id, deltas) in textures.set.drain() {
            for delta in &deltas {
                self.renderer.set_texture(*queue, self.pool, id, delta).map_err(fault)?;
            }
        }
        for id in textures.free.drain() {
            self.renderer.free_texture(id).map_err(fault)?;
        }
        Ok(())
    }

    /// Records the drawing of the panel over `target`. The image must be in the colour target state, and remains in this state.
    ///
    /// # Errors
    /// If memory runs out.
    pub fn record(&mut self, cmd: &mut Commands, target: &Image, painted: &Painted) -> Result<(), AppError> {
        let [width, height] = target.mip_extent(0);
        cmd.begin_rendering(&[ColorTarget { view: target.whole(), load: Load::Keep }], None);
        let extent = vk::Extent2D { width, height };
        let drawn = self.renderer.cmd_draw(cmd.raw(), extent, painted.pixels_per_point, &painted.primitives);
        cmd.end_rendering();
        drawn.map_err(fault)
    }
}

impl Drop for PanelPainter {
    fn drop(&mut self) {
        let _ = self.gpu.wait_idle();
        // SAFETY: the device is idle, and no other code uses the pool.
        unsafe { self.gpu.raw().destroy_command_pool(self.pool, None) };
    }
}
