//! The output of the filter passes for each pixel.

use std::sync::Arc;

use glam::{DVec2, DVec3, Vec2, Vec3};
use half::f16;
use leadr_gpu::vk;

use super::begin::Begin;
use leadr_gpu::{Commands, Gpu, Image, ImageDesc, Result, Use};
use leadr_reflectance::frame::octahedral_decode;

/// The LEADR G-buffer, which holds all inputs for shading a pixel in 72 bytes (`passes/gbuffer.glsl`), except for the depth, which
/// is in [`VisibleSurface`](super::VisibleSurface).
#[derive(Clone)]
pub struct GBuffer {
    /// The octahedral displacement direction, the mean slope in its frame, and the covariance `sxy`, as RGBA32UI.
    pub slopes: Image,
    /// The linear albedo, the Beckmann roughness, and the variances `sxx` and `syy`, as RGBA32UI.
    pub material: Image,
    /// The accessibility, the level of detail, and the data for joining edge samples, as RG32UI.
    pub surface: Image,
    /// The horizon of the relief, packed as RG32UI.
    pub horizon: Image,
    /// The reflectance at normal incidence, the number of the measured material, and the reflectance of the diffuse base, as RGBA32UI.
    pub reflection: Image,
    /// The emission, as RG32UI.
    pub emission: Image,
}

/// The values of a [`GBuffer`] pixel that layers show.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct FilteredPixel {
    /// The displacement direction in world space, of unit length.
    pub normal: DVec3,
    /// The mean slope in the frame of `normal`.
    pub mean_slope: Vec2,
    /// The slope covariance `sxx, syy, sxy`.
    pub slope_covariance: Vec3,
    /// The linear albedo.
    pub albedo: Vec3,
    /// The Beckmann roughness of the base material.
    pub roughness: f32,
    /// The level of detail at which the maps were read.
    pub lod: f32,
}

impl GBuffer {
    /// The formats of the images, in attachment order.
    pub const FORMATS: [vk::Format; 6] = [
        vk::Format::R32G32B32A32_UINT,
        vk::Format::R32G32B32A32_UINT,
        vk::Format::R32G32_UINT,
        vk::Format::R32G32_UINT,
        vk::Format::R32G32B32A32_UINT,
        vk::Format::R32G32_UINT,
    ];

    /// Creates a G-buffer of `size` pixels.
    pub fn new(gpu: &Arc<Gpu>, size: (u32, u32)) -> Result<Self> {
        let color = |format| ImageDesc::new(format, size.0, size.1).color_target();
        let [slopes, material, surface, horizon, reflection, emission] = Self::FORMATS.map(color);
        // The join pass writes to `slopes` and `material`.
        Ok(Self {
            slopes: Image::new(gpu, "g-buffer slopes", slopes.storage())?,
            material: Image::new(gpu, "g-buffer material", material.storage())?,
            surface: Image::new(gpu, "g-buffer surface", surface)?,
            horizon: Image::new(gpu, "g-buffer horizon", horizon)?,
            reflection: Image::new(gpu, "g-buffer reflection", reflection)?,
            emission: Image::new(gpu, "g-buffer emission", emission)?,
        })
    }

    /// The images in attachment order.
    pub fn colors(&self) -> [&Image; 6] {
        let Self { slopes, material, surface, horizon, reflection, emission } = self;
        [slopes, material, surface, horizon, reflection, emission]
    }

    /// Runs `draw`, which filters the pixels of one kind of surface into the G-buffer, within the scissor (x, y, width, height).
    /// Leaves the G-buffer readable.
    pub fn draw(&self, cmd: &mut Commands, begin: Begin, scissor: Option<[u32; 4]>, draw: impl FnOnce(&mut Commands)) {
        let colors = self.colors().map(|image| begin.color(cmd, image));
        cmd.begin_rendering(&colors, None);
        if let Some(area) = scissor {
            cmd.scissor(area);
        }
        draw(cmd);
        cmd.end_rendering();
        for image in self.colors() {
            cmd.transition(image, Use::Sampled);
        }
    }

    /// Reads the pixels back, row by row.
    pub fn read(&self) -> Result<Vec<FilteredPixel>> {
        let slopes: Vec<[u32; 4]> = self.slopes.read(0, 0)?;
        let material: Vec<[u32; 4]> = self.material.read(0, 0)?;
        let surface: Vec<[u32; 2]> = self.surface.read(0, 0)?;
        let pixels = slopes.iter().zip(&material).zip(&surface);
        Ok(pixels.map(|((&slopes, &material), &surface)| FilteredPixel::unpack(slopes, material, surface)).collect())
    }
}

impl FilteredPixel {
    fn unpack(slopes: [u32; 4], material: [u32; 4], surface: [u32; 2]) -> Self {
        let snorm = |bits: u32| (f64::from(bits as u16 as i16) / 32767.0).max(-1.0);
        let half = |bits: u32| f16::from_bits(bits as u16).to_f32();
        let color = [material[0], material[0] >> 16, material[1], material[1] >> 16].map(half);
        Self {
            normal: octahedral_decode(DVec2::new(snorm(slopes[0]), snorm(slopes[0] >> 16))),
            mean_slope: Vec2::from([slopes[1], slopes[2]].map(f32::from_bits)),
            slope_covariance: Vec3::from([material[2], material[3], slopes[3]].map(f32::from_bits)),
            albedo: Vec3::new(color[0], color[1], color[2]),
            roughness: color[3],
            lod: half(surface[0] >> 16),
        }
    }
}
