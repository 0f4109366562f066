//! The shaders that the build compiled from `shaders-glsl/passes` and `shaders-glsl/probes`, by name, with their
//! declarations.

use std::collections::BTreeMap;
use std::sync::{PoisonError, RwLock, RwLockReadGuard};

use ash::vk;

use super::{GpuError, Result};

/// SPIR-V is read as 32-bit words; plain embedded bytes would have no alignment.
#[repr(C, align(4))]
struct Aligned<const N: usize>([u8; N]);

/// A compiled entry point.
pub(crate) struct Shader {
    /// Its path inside `shaders-glsl/`.
    pub(crate) name: &'static str,
    pub(crate) stage: vk::ShaderStageFlags,
    pub(crate) code: &'static [u8],
    /// Work group size of a compute shader, with specialization constants at their defaults; otherwise 1.
    pub(crate) local_size: [u32; 3],
    pub(crate) resources: &'static [Resource],
    pub(crate) constants: &'static [Constant],
    pub(crate) push: Option<Push>,
    /// Every struct in its buffers and push constants.
    pub(crate) structs: &'static [Struct],
}

/// A resource that a shader declares.
pub(crate) struct Resource {
    /// The name of the variable; that of the block if it has no instance name.
    pub(crate) name: &'static str,
    pub(crate) kind: ResourceKind,
    /// Which word of the SPIR-V holds the binding number; `None` where the resource is unused and was optimised away.
    pub(crate) binding_word: Option<usize>,
}

/// Kind of a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ResourceKind {
    Uniform,
    Storage,
    Sampled,
    StorageImage,
}

impl ResourceKind {
    pub(crate) fn descriptor_type(self) -> vk::DescriptorType {
        match self {
            Self::Uniform => vk::DescriptorType::UNIFORM_BUFFER,
            Self::Storage => vk::DescriptorType::STORAGE_BUFFER,
            Self::Sampled => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            Self::StorageImage => vk::DescriptorType::STORAGE_IMAGE,
        }
    }

    /// Its name in messages.
    pub(crate) fn words(self) -> &'static str {
        match self {
            Self::Uniform => "a uniform buffer",
            Self::Storage => "a storage buffer",
            Self::Sampled => "a texture",
            Self::StorageImage => "a storage image",
        }
    }
}

/// A specialization constant that a shader declares.
pub(crate) struct Constant {
    pub(crate) name: &'static str,
    pub(crate) id: u32,
    pub(crate) kind: ConstantKind,
}

/// Type of a specialization constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum ConstantKind {
    Bool,
    U32,
    I32,
    F32,
}

/// The push constant block that a shader declares.
pub(crate) struct Push {
    pub(crate) block: &'static str,
    /// 0 where it is unused and was optimised away.
    pub(crate) bytes: u32,
}

/// A struct with a memory layout in a shader.
pub(crate) struct Struct {
    pub(crate) name: &'static str,
    /// All members except a runtime-sized array.
    pub(crate) members: &'static [Member],
    /// Bytes to the next struct of an array, or to the runtime-sized array that follows.
    pub(crate) pitch: Option<u32>,
}

/// A member of a struct, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Member {
    /// Its name.
    pub name: &'static str,
    /// From the start of the struct.
    pub offset: usize,
    /// Including the padding between elements of arrays.
    pub size: usize,
}

include!(concat!(env!("OUT_DIR"), "/shaders.rs"));

impl Shader {
    /// The entry point with this name, such as `"passes/shade.frag"`.
    ///
    /// # Errors
    /// [`GpuError::NoShader`] when no such entry point was compiled into this build.
    pub(crate) fn find(name: &str) -> Result<&'static Self> {
        if let Some(newer) = newer().get(name) {
            return Ok(*newer);
        }
        match TABLE.binary_search_by(|shader| shader.name.cmp(name)) {
            Ok(index) => Ok(&TABLE[index]),
            Err(_) => Err(GpuError::NoShader { name: name.to_owned() }),
        }
    }

    /// Its SPIR-V, with each resource bound to the number that `number` returns for its name.
    pub(crate) fn spirv(&self, number: impl Fn(&str) -> Option<u32>) -> Vec<u32> {
        let mut words = bytemuck::cast_slice(self.code).to_vec();
        for resource in self.resources {
            if let (Some(word), Some(number)) = (resource.binding_word, number(resource.name)) {
                words[word] = number;
            }
        }
        words
    }
}

/// Shaders that were compiled since the build, in place of those of the same name.
static NEWER: RwLock<BTreeMap<&'static str, &'static Shader>> = RwLock::new(BTreeMap::new());

fn newer() -> RwLockReadGuard<'static, BTreeMap<&'static str, &'static Shader>> {
    NEWER.read().unwrap_or_else(PoisonError::into_inner)
}

/// Puts shaders in place of those of the same name, and returns what was there instead of those of the build.
pub(crate) fn replace(shaders: BTreeMap<&'static str, &'static Shader>) -> BTreeMap<&'static str, &'static Shader> {
    std::mem::replace(&mut *NEWER.write().unwrap_or_else(PoisonError::into_inner), shaders)
}

/// The shaders that are in place of those of the build.
pub(crate) fn replaced() -> BTreeMap<&'static str, &'static Shader> {
    newer().clone()
}

/// The names of all entry points of this build, sorted.
pub fn names() -> impl Iterator<Item = &'static str> {
    TABLE.iter().map(|shader| shader.name)
}
