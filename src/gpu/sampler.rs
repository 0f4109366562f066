//! Samplers.

use std::sync::Arc;

use ash::vk;

use super::error::Doing;
use super::{Gpu, Result};

/// What lies outside [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Wrap {
    /// The texture repeats.
    Repeat,
    /// The edge texel goes on for ever.
    Clamp,
}

/// How texels and mip levels are mixed.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Filter {
    /// The nearest texel of the nearest level.
    Nearest,
    /// Bilinear within the nearest level.
    Bilinear,
    /// Bilinear, and linear between levels.
    Trilinear,
    /// Trilinear with up to this many samples along the footprint; drivers differ, so never in reference images.
    Anisotropic(f32),
}

/// A sampler. Clones share the one sampler.
#[derive(Clone)]
pub struct Sampler {
    pub(crate) inner: Arc<SamplerInner>,
}

pub(crate) struct SamplerInner {
    gpu: Arc<Gpu>,
    pub(crate) raw: vk::Sampler,
}

impl Drop for SamplerInner {
    fn drop(&mut self) {
        // SAFETY: commands that use the sampler hold an Arc of it until they are done.
        unsafe { self.gpu.raw().destroy_sampler(self.raw, None) };
    }
}

impl Sampler {
    /// A sampler with the same wrapping on all axes. Cube maps are seamless whatever the wrapping.
    ///
    /// # Errors
    /// A failed Vulkan call.
    pub fn new(gpu: &Arc<Gpu>, name: &str, filter: Filter, wrap: Wrap) -> Result<Self> {
        let wrap = match wrap {
            Wrap::Repeat => vk::SamplerAddressMode::REPEAT,
            Wrap::Clamp => vk::SamplerAddressMode::CLAMP_TO_EDGE,
        };
        let texels = if filter == Filter::Nearest { vk::Filter::NEAREST } else { vk::Filter::LINEAR };
        let levels = match filter {
            Filter::Nearest | Filter::Bilinear => vk::SamplerMipmapMode::NEAREST,
            Filter::Trilinear | Filter::Anisotropic(_) => vk::SamplerMipmapMode::LINEAR,
        };
        let mut info = vk::SamplerCreateInfo::default()
            .mag_filter(texels)
            .min_filter(texels)
            .mipmap_mode(levels)
            .address_mode_u(wrap)
            .address_mode_v(wrap)
            .address_mode_w(wrap)
            .max_lod(vk::LOD_CLAMP_NONE);
        if let Filter::Anisotropic(samples) = filter
            && gpu.max_anisotropy() > 1.0
        {
            info = info.anisotropy_enable(true).max_anisotropy(samples.clamp(1.0, gpu.max_anisotropy()));
        }
        // SAFETY: the device is alive.
        let raw = unsafe { gpu.raw().create_sampler(&info, None) }.doing(format!("creating sampler {name}"))?;
        gpu.name(raw, name);
        Ok(Self { inner: Arc::new(SamplerInner { gpu: gpu.clone(), raw }) })
    }

    /// The raw handle.
    pub fn raw(&self) -> vk::Sampler {
        self.inner.raw
    }
}
