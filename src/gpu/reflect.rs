//! Reads from SPIR-V what pipelines and tests must know: bindings, push constants, work group size, struct offsets.
//!
//! Numbers of opcodes, decorations and storage classes are those of the SPIR-V 1.6 specification.

use std::collections::HashMap;

use ash::vk;

use super::{GpuError, Result};

/// A descriptor that a shader uses in set 0.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Binding {
    /// Number of the binding.
    pub binding: u32,
    /// Kind of descriptor.
    pub kind: vk::DescriptorType,
    /// Array length, 1 for plain descriptors.
    pub count: u32,
    /// Stages that use it.
    pub stages: vk::ShaderStageFlags,
}

/// What one entry point needs of its pipeline.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Interface {
    /// Stage of the entry point.
    pub stage: vk::ShaderStageFlags,
    /// Descriptors of set 0, by binding number.
    pub bindings: Vec<Binding>,
    /// Bytes of the push constant block; 0 without one.
    pub push_constant_bytes: u32,
    /// Work group size of a compute entry point, spec constants at their defaults; otherwise 1.
    pub local_size: [u32; 3],
}

#[derive(Clone, Debug)]
enum Type {
    Scalar(u32),
    Vector(u32, u32),
    Matrix(u32),
    Image { sampled: u32, buffer: bool },
    SampledImage,
    Sampler,
    Array(u32, u32),
    RuntimeArray(u32),
    Struct(Vec<u32>),
    Pointer(u32),
}

#[derive(Default)]
struct Module {
    names: HashMap<u32, String>,
    member_names: HashMap<(u32, u32), String>,
    decorations: HashMap<(u32, u32), u32>,
    member_decorations: HashMap<(u32, u32, u32), u32>,
    types: HashMap<u32, Type>,
    constants: HashMap<u32, u32>,
    /// Identifier, pointer type, storage class.
    variables: Vec<(u32, u32, u32)>,
    stage: Option<u32>,
    local_size: Option<[u32; 3]>,
    local_size_ids: Option<[u32; 3]>,
}

const BLOCK: u32 = 2;
const BUFFER_BLOCK: u32 = 3;
const ARRAY_STRIDE: u32 = 6;
const MATRIX_STRIDE: u32 = 7;
const BINDING: u32 = 33;
const DESCRIPTOR_SET: u32 = 34;
const OFFSET: u32 = 35;

const UNIFORM_CONSTANT: u32 = 0;
const UNIFORM: u32 = 2;
const PUSH_CONSTANT: u32 = 9;
const STORAGE_BUFFER: u32 = 12;

fn fault(name: &str, fault: impl Into<String>) -> GpuError {
    GpuError::Shader { name: name.to_owned(), fault: fault.into() }
}

impl Module {
    fn parse(name: &str, words: &[u32]) -> Result<Self> {
        if words.len() < 5 || words[0] != 0x0723_0203 {
            return Err(fault(name, "not a SPIR-V module"));
        }
        let mut module = Self::default();
        let mut rest = &words[5..];
        while let Some(&head) = rest.first() {
            let length = (head >> 16) as usize;
            let Some(instruction) = rest.get(1..length) else {
                return Err(fault(name, "the SPIR-V module ends within an instruction"));
            };
            module.instruction(head & 0xffff, instruction);
            rest = &rest[length..];
        }
        Ok(module)
    }

    fn instruction(&mut self, opcode: u32, words: &[u32]) {
        match (opcode, words) {
            (5, [id, text @ ..]) => {
                self.names.insert(*id, string(text));
            }
            (6, [id, member, text @ ..]) => {
                self.member_names.insert((*id, *member), string(text));
            }
            (15, [stage, ..]) => self.stage = Some(*stage),
            // OpExecutionMode LocalSize, OpExecutionModeId LocalSizeId
            (16, [_, 17, x, y, z]) => self.local_size = Some([*x, *y, *z]),
            (331, [_, 38, x, y, z]) => self.local_size_ids = Some([*x, *y, *z]),
            (71, [id, decoration, rest @ ..]) => {
                self.decorations.insert((*id, *decoration), rest.first().copied().unwrap_or(1));
            }
            (72, [id, member, decoration, rest @ ..]) => {
                self.member_decorations.insert((*id, *member, *decoration), rest.first().copied().unwrap_or(1));
            }
            (21 | 22, [id, width, ..]) => self.add(*id, Type::Scalar(width / 8)),
            (23, [id, component, count]) => self.add(*id, Type::Vector(*component, *count)),
            (24, [id, _, count]) => self.add(*id, Type::Matrix(*count)),
            (25, [id, _, dim, _, _, _, sampled, ..]) => {
                self.add(*id, Type::Image { sampled: *sampled, buffer: *dim == 5 });
            }
            (26, [id]) => self.add(*id, Type::Sampler),
            (27, [id, _]) => self.add(*id, Type::SampledImage),
            (28, [id, element, length]) => self.add(*id, Type::Array(*element, *length)),
            (29, [id, element]) => self.add(*id, Type::RuntimeArray(*element)),
            (30, [id, members @ ..]) => self.add(*id, Type::Struct(members.to_vec())),
            (32, [id, _, target]) => self.add(*id, Type::Pointer(*target)),
            // OpConstant, OpSpecConstant
            (43 | 50, [_, id, value, ..]) => {
                self.constants.insert(*id, *value);
            }
            (59, [kind, id, storage, ..]) => self.variables.push((*id, *kind, *storage)),
            _ => {}
        }
    }

    fn add(&mut self, id: u32, kind: Type) {
        self.types.insert(id, kind);
    }

    fn pointee(&self, pointer: u32) -> Option<u32> {
        match self.types.get(&pointer)? {
            Type::Pointer(target) => Some(*target),
            _ => None,
        }
    }

    /// Bytes of a type with explicit layout; `None` for what has no fixed size.
    fn bytes(&self, id: u32) -> Option<u32> {
        Some(match self.types.get(&id)? {
            Type::Scalar(bytes) => *bytes,
            Type::Vector(component, count) => self.bytes(*component)? * count,
            Type::Array(_, length) => self.decorations.get(&(id, ARRAY_STRIDE))? * self.constants.get(length)?,
            Type::Struct(members) => {
                let last = u32::try_from(members.len().checked_sub(1)?).ok()?;
                let offset = self.member_decorations.get(&(id, last, OFFSET))?;
                let bytes = match self.types.get(&members[last as usize])? {
                    Type::Matrix(columns) => self.member_decorations.get(&(id, last, MATRIX_STRIDE))? * columns,
                    _ => self.bytes(members[last as usize])?,
                };
                offset + bytes
            }
            _ => return None,
        })
    }

    fn interface(&self, name: &str) -> Result<Interface> {
        let stage = match self.stage {
            Some(0) => vk::ShaderStageFlags::VERTEX,
            Some(1) => vk::ShaderStageFlags::TESSELLATION_CONTROL,
            Some(2) => vk::ShaderStageFlags::TESSELLATION_EVALUATION,
            Some(4) => vk::ShaderStageFlags::FRAGMENT,
            Some(5) => vk::ShaderStageFlags::COMPUTE,
            other => return Err(fault(name, format!("execution model {other:?} is not used here"))),
        };
        let mut bindings = Vec::new();
        let mut push_constant_bytes = 0;
        for &(variable, pointer, storage) in &self.variables {
            let target = self.pointee(pointer).ok_or_else(|| fault(name, "a variable has no pointer type"))?;
            match storage {
                PUSH_CONSTANT => {
                    push_constant_bytes =
                        self.bytes(target).ok_or_else(|| fault(name, "the push constants have no fixed size"))?;
                }
                UNIFORM_CONSTANT | UNIFORM | STORAGE_BUFFER => {
                    bindings.push(self.binding(name, variable, target, storage, stage)?);
                }
                _ => {}
            }
        }
        bindings.sort_by_key(|b: &Binding| b.binding);
        let local_size = match (self.local_size_ids, self.local_size) {
            (Some(ids), _) => ids.map(|id| self.constants.get(&id).copied().unwrap_or(1)),
            (None, Some(size)) => size,
            (None, None) => [1; 3],
        };
        Ok(Interface { stage, bindings, push_constant_bytes, local_size })
    }

    fn binding(
        &self,
        name: &str,
        variable: u32,
        target: u32,
        storage: u32,
        stages: vk::ShaderStageFlags,
    ) -> Result<Binding> {
        let label = self.names.get(&variable).filter(|n| !n.is_empty()).or_else(|| self.names.get(&target));
        let label = label.map_or("?", String::as_str);
        if self.decorations.get(&(variable, DESCRIPTOR_SET)).is_some_and(|set| *set != 0) {
            return Err(fault(name, format!("{label} is not in descriptor set 0")));
        }
        let binding = *self
            .decorations
            .get(&(variable, BINDING))
            .ok_or_else(|| fault(name, format!("{label} has no binding number")))?;
        let (element, count) = match self.types.get(&target) {
            Some(Type::Array(element, length)) => (*element, self.constants.get(length).copied().unwrap_or(1)),
            _ => (target, 1),
        };
        let kind = match (self.types.get(&element), storage) {
            (Some(Type::SampledImage), _) => vk::DescriptorType::COMBINED_IMAGE_SAMPLER,
            (Some(Type::Image { sampled: 2, buffer: false }), _) => vk::DescriptorType::STORAGE_IMAGE,
            (Some(Type::Struct(_)), STORAGE_BUFFER) => vk::DescriptorType::STORAGE_BUFFER,
            (Some(Type::Struct(_)), UNIFORM) if self.decorations.contains_key(&(element, BUFFER_BLOCK)) => {
                vk::DescriptorType::STORAGE_BUFFER
            }
            (Some(Type::Struct(_)), UNIFORM) if self.decorations.contains_key(&(element, BLOCK)) => {
                vk::DescriptorType::UNIFORM_BUFFER
            }
            (kind, _) => {
                return Err(fault(
                    name,
                    format!("{label} is {kind:?}; bind buffers, storage images and combined image samplers only"),
                ));
            }
        };
        Ok(Binding { binding, kind, count, stages })
    }

    /// The struct's members with their offsets, if it is laid out.
    fn offsets(&self, id: u32) -> Option<Vec<(String, u32)>> {
        let Some(Type::Struct(members)) = self.types.get(&id) else { return None };
        (0..u32::try_from(members.len()).ok()?)
            .map(|member| {
                let name = self.member_names.get(&(id, member)).cloned().unwrap_or_default();
                Some((name, *self.member_decorations.get(&(id, member, OFFSET))?))
            })
            .collect()
    }

    /// The laid-out structs of this name.
    fn structs(&self, wanted: &str) -> Vec<u32> {
        let mut ids: Vec<u32> = self
            .names
            .iter()
            .filter(|(id, name)| *name == wanted && self.offsets(**id).is_some())
            .map(|(id, _)| *id)
            .collect();
        ids.sort_unstable();
        ids
    }
}

/// A zero-terminated string in words, lowest byte first.
fn string(words: &[u32]) -> String {
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).take_while(|byte| *byte != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}

/// What the module's entry point needs of its pipeline. `name` is for messages.
///
/// # Errors
/// [`GpuError::Shader`] for what is not SPIR-V and for descriptors this renderer does not use (separate samplers, texel
/// buffers, sets other than 0).
pub fn interface(name: &str, spirv: &[u32]) -> Result<Interface> {
    Module::parse(name, spirv)?.interface(name)
}

/// Member names and byte offsets of a uniform, storage or push-constant block, or of a struct within one, by the name
/// of its type.
///
/// # Errors
/// [`GpuError::Shader`] when the module has no such struct with a memory layout (the optimiser drops unused blocks), or
/// has two that differ.
pub fn struct_offsets(spirv: &[u32], name: &str) -> Result<Vec<(String, u32)>> {
    let module = Module::parse(name, spirv)?;
    let mut layouts: Vec<_> = module.structs(name).into_iter().filter_map(|id| module.offsets(id)).collect();
    layouts.dedup();
    match layouts.len() {
        0 => Err(fault(name, "no struct of this name has a memory layout in the module")),
        1 => Ok(layouts.swap_remove(0)),
        _ => Err(fault(name, "several structs of this name have different layouts in the module")),
    }
}

/// Distance in bytes between elements of an array of the struct, which is Rust's `size_of` of its twin; `None` when no
/// array of it is laid out.
///
/// # Errors
/// [`GpuError::Shader`] for what is not SPIR-V.
pub fn struct_stride(spirv: &[u32], name: &str) -> Result<Option<u32>> {
    let module = Module::parse(name, spirv)?;
    let ids = module.structs(name);
    let stride = module.types.iter().find_map(|(array, kind)| match kind {
        Type::Array(element, _) | Type::RuntimeArray(element) if ids.contains(element) => {
            module.decorations.get(&(*array, ARRAY_STRIDE)).copied()
        }
        _ => None,
    });
    Ok(stride)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_not_spirv_is_refused() {
        assert!(interface("empty", &[]).is_err());
        assert!(interface("text", &[1, 2, 3, 4, 5, 6]).is_err());
        // An instruction that claims to be longer than the module, and one of length 0.
        for head in [0x0010_0005, 0x0000_0005] {
            assert!(interface("cut", &[0x0723_0203, 0x0001_0600, 0, 1, 0, head]).is_err());
        }
    }
}
