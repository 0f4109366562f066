//! Samplers.

use std::sync::Arc;

use ash::vk;

use super::error::Doing;
use super::{Gpu, Result};

/// What a sampler returns outside [0, 1].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum AddressMode {
    /// The texture, repeated.
    Repeat,
    /// The same, every second repeat mirrored.
    Mirror,
    /// The nearest texel at the edge.
    ClampToEdge,
}

/// How texels and mip levels are mixed.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Filter {
    /// The nearest texel of the nearest level.
    Nearest,
    /// Bilinear within the nearest level.
    Bilinear,
    /// Bilinear, and linear between levels.
    Trilinear,
}

/// A sampler. Clones share the same sampler.
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
    /// A sampler with the same address mode on all axes. Cube maps are seamless whatever the mode.
    pub fn new(gpu: &Arc<Gpu>, name: &str, filter: Filter, mode: AddressMode) -> Result<Self> {
        Self::with_modes(gpu, name, filter, [mode; 2])
    }

    /// A sampler of images, with address modes across and down.
    pub fn with_modes(gpu: &Arc<Gpu>, name: &str, filter: Filter, modes: [AddressMode; 2]) -> Result<Self> {
        let [across, down] = modes.map(|mode| match mode {
            AddressMode::Repeat => vk::SamplerAddressMode::REPEAT,
            AddressMode::Mirror => vk::SamplerAddressMode::MIRRORED_REPEAT,
            AddressMode::ClampToEdge => vk::SamplerAddressMode::CLAMP_TO_EDGE,
        });
        let texels = if filter == Filter::Nearest { vk::Filter::NEAREST } else { vk::Filter::LINEAR };
        let levels = match filter {
            Filter::Nearest | Filter::Bilinear => vk::SamplerMipmapMode::NEAREST,
            Filter::Trilinear => vk::SamplerMipmapMode::LINEAR,
        };
        let info = vk::SamplerCreateInfo::default()
            .mag_filter(texels)
            .min_filter(texels)
            .mipmap_mode(levels)
            .address_mode_u(across)
            .address_mode_v(down)
            .address_mode_w(down)
            .max_lod(vk::LOD_CLAMP_NONE);
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
