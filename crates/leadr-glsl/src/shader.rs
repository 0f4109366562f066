//! Compiled entry points with their declarations.

/// Embedded SPIR-V, aligned to the 32-bit words that it is read as.
#[derive(Debug)]
#[repr(C, align(4))]
pub struct Aligned<const N: usize>(
    /// The bytes.
    pub [u8; N],
);

/// The stage of a pipeline that an entry point belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Stage {
    /// `.vert`
    Vertex,
    /// `.tesc`
    TessellationControl,
    /// `.tese`
    TessellationEvaluation,
    /// `.frag`
    Fragment,
    /// `.comp`
    Compute,
}

impl Stage {
    /// The stage that a file's extension names.
    pub fn of(path: &std::path::Path) -> Option<Self> {
        Some(match path.extension()?.to_str()? {
            "vert" => Self::Vertex,
            "tesc" => Self::TessellationControl,
            "tese" => Self::TessellationEvaluation,
            "frag" => Self::Fragment,
            "comp" => Self::Compute,
            _ => return None,
        })
    }
}

/// A compiled entry point.
#[derive(Debug)]
pub struct Shader {
    /// Its path inside `shaders-glsl/`.
    pub name: &'static str,
    /// Its stage.
    pub stage: Stage,
    /// SPIR-V.
    pub code: &'static [u8],
    /// Work group size of a compute shader, with specialization constants at their defaults; otherwise 1.
    pub local_size: [u32; 3],
    /// Descriptors.
    pub resources: &'static [Resource],
    /// Specialization constants.
    pub constants: &'static [Constant],
    /// The push constant block.
    pub push: Option<Push>,
    /// Every struct in its buffers and push constants.
    pub structs: &'static [Struct],
}

/// A resource that a shader declares.
#[derive(Debug)]
pub struct Resource {
    /// The name of the variable; that of the block if it has no instance name.
    pub name: &'static str,
    /// Its kind.
    pub kind: ResourceKind,
    /// Its descriptor set, 0 to 2.
    pub set: u32,
}

/// Kind of a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ResourceKind {
    /// A uniform buffer.
    Uniform,
    /// A storage buffer.
    Storage,
    /// An image with its sampler.
    Sampled,
    /// An image that is written.
    StorageImage,
}

impl ResourceKind {
    /// Every kind.
    pub const ALL: [Self; 4] = [Self::Uniform, Self::Storage, Self::Sampled, Self::StorageImage];

    /// Its name in messages.
    pub fn words(self) -> &'static str {
        match self {
            Self::Uniform => "a uniform buffer",
            Self::Storage => "a storage buffer",
            Self::Sampled => "a texture",
            Self::StorageImage => "a storage image",
        }
    }
}

/// A specialization constant that a shader declares.
#[derive(Debug)]
pub struct Constant {
    /// Its name.
    pub name: &'static str,
    /// `constant_id`.
    pub id: u32,
    /// Its type.
    pub kind: ConstantKind,
}

/// Type of a specialization constant.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ConstantKind {
    /// `bool`
    Bool,
    /// `uint`
    U32,
    /// `int`
    I32,
    /// `float`
    F32,
}

/// The push constant block that a shader declares.
#[derive(Debug)]
pub struct Push {
    /// Its name.
    pub block: &'static str,
    /// Up to the end of its last member.
    pub bytes: u32,
}

/// A struct with a memory layout in a shader.
#[derive(Debug)]
pub struct Struct {
    /// Its name.
    pub name: &'static str,
    /// All members except a runtime-sized array.
    pub members: &'static [Member],
    /// Bytes to the next struct of an array, or to the runtime-sized array that follows.
    pub pitch: Option<u32>,
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

impl Shader {
    /// Its SPIR-V in words.
    pub fn words(&self) -> Vec<u32> {
        self.code.as_chunks().0.iter().map(|bytes| u32::from_ne_bytes(*bytes)).collect()
    }
}

#[cfg(feature = "compile")]
mod compiled {
    use super::{Constant, Member, Push, Resource, Shader, Stage, Struct};
    use crate::compiler::Compiled;

    impl Shader {
        /// A shader that lasts as long as the program: pipelines refer to it, and a session compiles few.
        ///
        /// # Panics
        /// If the name has no extension of a stage; such a file does not compile.
        pub fn from_compiled(name: &str, compiled: Compiled) -> &'static Self {
            let Compiled { code, interface } = compiled;
            let resources = interface.resources.into_iter().map(|resource| Resource {
                name: text(resource.name),
                kind: resource.kind,
                set: resource.set,
            });
            let constants = interface.constants.into_iter().map(|constant| Constant {
                name: text(constant.name),
                id: constant.id,
                kind: constant.kind,
            });
            let member = |m: crate::reflect::Member| Member {
                name: text(m.name),
                offset: m.offset as usize,
                size: m.size as usize,
            };
            let structs = interface.structs.into_iter().map(|found| Struct {
                name: text(found.name),
                pitch: found.pitch,
                members: leaked(found.members.into_iter().map(member)),
            });
            let push = interface.push.map(|push| Push { block: text(push.block), bytes: push.bytes });
            Box::leak(Box::new(Self {
                name: text(name.to_owned()),
                stage: Stage::of(name.as_ref()).expect("compiled by its stage"),
                code: leaked(code.into_iter().flat_map(u32::to_ne_bytes)),
                local_size: interface.local_size,
                resources: leaked(resources),
                constants: leaked(constants),
                push,
                structs: leaked(structs),
            }))
        }
    }

    fn text(text: String) -> &'static str {
        Box::leak(text.into_boxed_str())
    }

    fn leaked<T>(items: impl Iterator<Item = T>) -> &'static [T] {
        Box::leak(items.collect::<Vec<_>>().into_boxed_slice())
    }
}
