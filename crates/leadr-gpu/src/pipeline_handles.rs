//! The Vulkan objects of pipelines. Pipelines with the same code and the same state share them.

use std::hash::{DefaultHasher, Hash, Hasher};
use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;

use super::{Gpu, Result};

/// The Vulkan objects of a pipeline. They must be dropped before the device is destroyed.
pub(crate) struct PipelineHandles {
    device: ash::Device,
    pub(crate) raw: vk::Pipeline,
    pub(crate) layout: vk::PipelineLayout,
    pub(crate) set_layout: vk::DescriptorSetLayout,
}

impl PipelineHandles {
    /// Returns null handles, which are replaced one by one.
    pub(crate) fn new(gpu: &Gpu) -> Self {
        Self {
            device: gpu.raw().clone(),
            raw: vk::Pipeline::null(),
            layout: vk::PipelineLayout::null(),
            set_layout: vk::DescriptorSetLayout::null(),
        }
    }
}

impl Drop for PipelineHandles {
    fn drop(&mut self) {
        // SAFETY: commands that use the pipeline hold it until they are done. Null handles are ignored.
        unsafe {
            self.device.destroy_pipeline(self.raw, None);
            self.device.destroy_pipeline_layout(self.layout, None);
            self.device.destroy_descriptor_set_layout(self.set_layout, None);
        }
    }
}

/// The number of pipelines that [`KnownPipelines`] keeps alive.
const MOST_KNOWN: usize = 64;

/// The latest pipelines of a device. A scene that is opened again finds its pipelines here. Software drivers compile shaders for
/// seconds, and their own caches keep only a part of that work.
#[derive(Default)]
pub(crate) struct KnownPipelines(Mutex<Vec<(u128, Arc<PipelineHandles>)>>);

impl KnownPipelines {
    /// Returns the handles that were made for `key`, or makes them.
    pub(crate) fn find_or_make(
        &self,
        key: u128,
        make: impl FnOnce() -> Result<PipelineHandles>,
    ) -> Result<Arc<PipelineHandles>> {
        let all = || self.0.lock().unwrap_or_else(PoisonError::into_inner);
        let known = {
            let mut all = all();
            let found = all.iter().position(|(known, _)| *known == key);
            found.map(|index| {
                // The latest come last.
                let entry = all.remove(index);
                all.push(entry.clone());
                entry.1
            })
        };
        if let Some(handles) = known {
            return Ok(handles);
        }
        // Other threads make their pipelines meanwhile.
        let handles = Arc::new(make()?);
        let mut all = all();
        if all.len() == MOST_KNOWN {
            all.remove(0);
        }
        all.push((key, handles.clone()));
        Ok(handles)
    }

    /// Drops all handles that no pipeline holds.
    pub(crate) fn clear(&self) {
        self.0.lock().unwrap_or_else(PoisonError::into_inner).clear();
    }
}

/// Returns the hash of a value, with so many bits that different values have different hashes.
pub(crate) fn wide_hash(value: &impl Hash) -> u128 {
    let half = |seed: u8| {
        let mut hasher = DefaultHasher::new();
        seed.hash(&mut hasher);
        value.hash(&mut hasher);
        u128::from(hasher.finish())
    };
    half(0) << 64 | half(1)
}
