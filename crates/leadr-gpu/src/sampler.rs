//! Samplers.

use std::collections::HashMap;
use std::sync::{Arc, Mutex, PoisonError, Weak};

use ash::vk;

use super::error::Doing;
use super::{Gpu, Result};

/// How texture coordinates outside [0, 1] are mapped to texels.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum AddressMode {
    /// The texture repeats.
    Repeat,
    /// The texture repeats, and every second repeat is mirrored.
    Mirror,
    /// The nearest texel at the edge is used.
    ClampToEdge,
}

/// How texels and mip levels are interpolated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Filter {
    /// Takes the nearest texel of the nearest level.
    Nearest,
    /// Interpolates bilinearly within the nearest level.
    Bilinear,
    /// Interpolates bilinearly within levels, and linearly between levels.
    Trilinear,
}

/// The properties of a sampler: its filter, and its horizontal and vertical address modes.
type Kind = (Filter, [AddressMode; 2]);

/// The samplers of a device that are in use. Samplers are shared, because some devices support only 4,000 samplers.
#[derive(Default)]
pub(crate) struct Samplers(Mutex<HashMap<Kind, Weak<SamplerInner>>>);

/// A sampler. Samplers with equal properties are shared.
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
    /// Creates a sampler with the same address mode on all axes. Cube maps are seamless in every mode.
    pub fn new(gpu: &Arc<Gpu>, filter: Filter, mode: AddressMode) -> Result<Self> {
        Self::with_modes(gpu, filter, [mode; 2])
    }

    /// Creates a sampler for 2D images, with separate horizontal and vertical address modes.
    pub fn with_modes(gpu: &Arc<Gpu>, filter: Filter, modes: [AddressMode; 2]) -> Result<Self> {
        let mut known = gpu.samplers().0.lock().unwrap_or_else(PoisonError::into_inner);
        if let Some(inner) = known.get(&(filter, modes)).and_then(Weak::upgrade) {
            return Ok(Self { inner });
        }
        let inner = Arc::new(SamplerInner { gpu: gpu.clone(), raw: create(gpu, filter, modes)? });
        known.insert((filter, modes), Arc::downgrade(&inner));
        Ok(Self { inner })
    }

    /// Returns the raw handle.
    pub fn raw(&self) -> vk::Sampler {
        self.inner.raw
    }
}

fn create(gpu: &Gpu, filter: Filter, modes: [AddressMode; 2]) -> Result<vk::Sampler> {
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
    let raw = unsafe { gpu.raw().create_sampler(&info, None) }.doing("creating a sampler")?;
    gpu.name(raw, &format!("{filter:?}, {modes:?}"));
    Ok(raw)
}
