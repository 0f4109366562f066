//! The shaders of a device, from its tables and from newer shaders that replace table entries.

use std::collections::BTreeMap;
use std::sync::{PoisonError, RwLock, RwLockReadGuard};

use ash::vk;
pub use leadr_glsl::reflect::{ConstantKind, ResourceKind};
pub use leadr_glsl::{Shader, Stage};

use super::{GpuError, Result};

type Newer = BTreeMap<&'static str, &'static Shader>;

/// The shaders of a device, by name.
pub(crate) struct Shaders {
    tables: Vec<&'static [Shader]>,
    /// Shaders compiled since the build, which replace shaders of the same name in the tables.
    newer: RwLock<Newer>,
}

impl Shaders {
    pub(crate) fn new(tables: Vec<&'static [Shader]>) -> Self {
        Self { tables, newer: RwLock::default() }
    }

    /// Returns the entry point with this name, such as `"passes/shade.frag"`.
    ///
    /// # Errors
    /// Returns [`GpuError::NoShader`] if no table has the entry point.
    pub(crate) fn find(&self, name: &str) -> Result<&'static Shader> {
        if let Some(newer) = self.newer().get(name) {
            return Ok(*newer);
        }
        let in_table = |table: &&'static [Shader]| {
            table.binary_search_by(|shader| shader.name.cmp(name)).ok().map(|index| &table[index])
        };
        self.tables.iter().find_map(in_table).ok_or_else(|| GpuError::NoShader { name: name.to_owned() })
    }

    /// Returns the names of all entry points.
    pub(crate) fn names(&self) -> impl Iterator<Item = &'static str> {
        self.tables.iter().flat_map(|table| table.iter()).map(|shader| shader.name)
    }

    /// Sets the shaders that replace entries of the tables, and returns the previous replacements.
    pub(crate) fn replace(&self, shaders: Newer) -> Newer {
        std::mem::replace(&mut *self.newer.write().unwrap_or_else(PoisonError::into_inner), shaders)
    }

    /// Returns the shaders that replace entries of the tables.
    pub(crate) fn newer(&self) -> RwLockReadGuard<'_, Newer> {
        self.newer.read().unwrap_or_else(PoisonError::into_inner)
    }
}

pub(crate) fn stage_flags(stage: Stage) -> vk::ShaderStageFlags {
    match stage {
        Stage::Vertex => vk::ShaderStageFlags::VERTEX,
        Stage::TessellationControl => vk::ShaderStageFlags::TESSELLATION_CONTROL,
        Stage::TessellationEvaluation => vk::ShaderStageFlags::TESSELLATION_EVALUATION,
        Stage::Fragment => vk::ShaderStageFlags::FRAGMENT,
        Stage::Compute => vk::ShaderStageFlags::COMPUTE,
    }
}

pub(crate) fn descriptor_type(kind: ResourceKind) -> vk::DescriptorType {
    match kind {
        ResourceKind::Uniform => vk::DescriptorType::UNIFORM_BUFFER,
        ResourceKind::Storage => vk::DescriptorType::STORAGE_BUFFER,
        ResourceKind::Sampled => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
        ResourceKind::StorageImage => vk::DescriptorType::STORAGE_IMAGE,
    }
}
