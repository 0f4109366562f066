//! Reads a shader's interface from SPIR-V: resources, constants and structs by name, and the work group size.
//!
//! Opcodes, decorations and storage classes are numbered as in the SPIR-V 1.6 specification.

use std::collections::{HashMap, HashSet};

use crate::spirv::{HEADER, all_instructions};

/// The declarations of one entry point.
#[derive(Debug, Default, PartialEq, Eq)]
pub struct Interface {
    /// The work group size of a compute entry point, with specialization constants at their defaults. All other entry points have the
    /// size 1.
    pub local_size: [u32; 3],
    /// The descriptors, sorted by name.
    pub resources: Vec<Resource>,
    /// The specialization constants, sorted by number.
    pub constants: Vec<Constant>,
    /// The push constant block, if the entry point has one.
    pub push: Option<Push>,
    /// The structs in buffers and push constants.
    pub structs: Vec<Struct>,
}

/// A descriptor.
#[derive(Debug, PartialEq, Eq)]
pub struct Resource {
    /// The name of the variable, or the name of the block if the block has no instance name.
    pub name: String,
    /// The kind of the resource.
    pub kind: ResourceKind,
    /// The descriptor set, from 0 to 2.
    pub set: u32,
    /// The index of the word in the module that holds the binding number, or `None` if the resource is unused.
    pub binding_word: Option<usize>,
}

/// The kind of a resource.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum ResourceKind {
    /// A uniform buffer.
    Uniform,
    /// A storage buffer.
    Storage,
    /// An image that is combined with a sampler.
    Sampled,
    /// A storage image.
    StorageImage,
}

impl ResourceKind {
    /// All kinds.
    pub const ALL: [Self; 4] = [Self::Uniform, Self::Storage, Self::Sampled, Self::StorageImage];

    /// Returns the name of the kind for messages.
    pub fn words(self) -> &'static str {
        match self {
            Self::Uniform => "a uniform buffer",
            Self::Storage => "a storage buffer",
            Self::Sampled => "a texture",
            Self::StorageImage => "a storage image",
        }
    }
}

/// A specialization constant.
#[derive(Debug, PartialEq, Eq)]
pub struct Constant {
    /// The name of the constant.
    pub name: String,
    /// The `constant_id` of the constant.
    pub id: u32,
    /// The type of the constant.
    pub kind: ConstantKind,
}

/// The type of a specialization constant.
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

/// A push constant block.
#[derive(Debug, PartialEq, Eq)]
pub struct Push {
    /// The name of the block.
    pub block: String,
    /// The number of bytes up to the end of the last member.
    pub bytes: u32,
    /// Whether the shader uses the block.
    pub used: bool,
}

/// A struct with a memory layout.
#[derive(Debug, PartialEq, Eq)]
pub struct Struct {
    /// The name of the type.
    pub name: String,
    /// All members except a trailing unsized array.
    pub members: Vec<Member>,
    /// The stride in bytes of an array of this struct. If an unsized array follows the members, the offset of that array.
    pub pitch: Option<u32>,
}

/// A member of a struct. Lengths are in bytes.
#[derive(Debug, PartialEq, Eq)]
pub struct Member {
    /// The name of the member.
    pub name: String,
    /// The offset from the start of the struct.
    pub offset: u32,
    /// The size, including the padding between array elements.
    pub size: u32,
}

/// Reads the declarations of the module's entry point.
///
/// # Errors
/// Fails on unsupported declarations: two specialization constants with one number, arrays of descriptors, separate samplers and texel
/// buffers, descriptor sets beyond 2, arrays that need padding between plain numbers, and a used resource without a binding.
pub fn interface(words: &[u32]) -> Result<Interface, String> {
    Module::parse(words)?.interface()
}

/// Returns the module without source text and line information, and without the names of functions and of their contents. Function names
/// are long, because they contain the types of all parameters.
pub fn stripped(words: &[u32]) -> Vec<u32> {
    // OpSourceContinued, OpSource, OpSourceExtension, OpString, OpLine, OpNoLine, OpModuleProcessed
    const LINES: [u32; 7] = [2, 3, 4, 7, 8, 317, 330];
    const NAME: u32 = 5;
    const FUNCTION: u32 = 54;
    const PARAMETER: u32 = 55;
    const VARIABLE: u32 = 59;
    let in_functions = all_instructions(words).skip_while(|i| i.operation != FUNCTION);
    let named = in_functions.filter(|i| [FUNCTION, PARAMETER, VARIABLE].contains(&i.operation));
    let local: HashSet<u32> = named.filter_map(|i| i.words.get(2).copied()).collect();
    let is_kept = |operation: u32, words: &[u32]| match operation {
        NAME => words.get(1).is_none_or(|id| !local.contains(id)),
        _ => !LINES.contains(&operation),
    };
    let kept = all_instructions(words).filter(|i| is_kept(i.operation, i.words)).flat_map(|i| i.words);
    words.iter().take(HEADER).chain(kept).copied().collect()
}

#[derive(Clone, Debug)]
enum Type {
    Number { bytes: u32, kind: ConstantKind },
    Bool,
    Vector(u32, u32),
    Matrix(u32),
    Image { sampled: u32, buffer: bool },
    SampledImage,
    Array(u32, u32),
    RuntimeArray(u32),
    Struct(Vec<u32>),
    Pointer(u32),
}

#[derive(Default)]
struct Module {
    names: HashMap<u32, String>,
    member_names: HashMap<(u32, u32), String>,
    /// The operand of each decoration, and the word index of the operand.
    decorations: HashMap<(u32, u32), (u32, usize)>,
    member_decorations: HashMap<(u32, u32, u32), u32>,
    types: HashMap<u32, Type>,
    /// The type and the value of each constant.
    constants: HashMap<u32, (u32, u32)>,
    /// The identifier, pointer type and storage class of each variable.
    variables: Vec<(u32, u32, u32)>,
    entry: u32,
    /// The current function. The field `named` holds the variables and functions that each function uses.
    function: u32,
    named: HashMap<u32, Vec<u32>>,
    local_size: Option<[u32; 3]>,
    local_size_ids: Option<[u32; 3]>,
}

const SPEC_ID: u32 = 1;
const BUFFER_BLOCK: u32 = 3;
const ARRAY_STRIDE: u32 = 6;
const MATRIX_STRIDE: u32 = 7;
const BINDING: u32 = 33;
const DESCRIPTOR_SET: u32 = 34;
const OFFSET: u32 = 35;

/// The index of the last descriptor set, which holds the resources of an object.
const MOST_SETS: u32 = 2;

const UNIFORM_CONSTANT: u32 = 0;
const UNIFORM: u32 = 2;
const PUSH_CONSTANT: u32 = 9;
const STORAGE_BUFFER: u32 = 12;

impl Module {
    fn parse(words: &[u32]) -> Result<Self, String> {
        if words.len() < HEADER || words[0] != 0x0723_0203 {
            return Err("not a SPIR-V module".to_owned());
        }
        let mut module = Self::default();
        for i in all_instructions(words) {
            if i.words.len() != (i.words[0] >> 16) as usize {
                return Err("the SPIR-V module ends in the middle of an instruction".to_owned());
            }
            module.instruction(i.operation, &i.words[1..], i.at + 1);
        }
        Ok(module)
    }

    fn instruction(&mut self, opcode: u32, words: &[u32], at: usize) {
        match (opcode, words) {
            (5, [id, text @ ..]) => {
                self.names.insert(*id, string(text));
            }
            (6, [id, member, text @ ..]) => {
                self.member_names.insert((*id, *member), string(text));
            }
            // OpExecutionMode LocalSize, OpExecutionModeId LocalSizeId
            (16, [_, 17, x, y, z]) => self.local_size = Some([*x, *y, *z]),
            (331, [_, 38, x, y, z]) => self.local_size_ids = Some([*x, *y, *z]),
            (71, [id, decoration, rest @ ..]) => {
                self.decorations.insert((*id, *decoration), (rest.first().copied().unwrap_or(1), at + 2));
            }
            (72, [id, member, decoration, rest @ ..]) => {
                self.member_decorations.insert((*id, *member, *decoration), rest.first().copied().unwrap_or(1));
            }
            (20, [id]) => self.add(*id, Type::Bool),
            (21, [id, width, signed]) => {
                let kind = if *signed == 0 { ConstantKind::U32 } else { ConstantKind::I32 };
                self.add(*id, Type::Number { bytes: width / 8, kind });
            }
            (22, [id, width, ..]) => self.add(*id, Type::Number { bytes: width / 8, kind: ConstantKind::F32 }),
            (23, [id, component, count]) => self.add(*id, Type::Vector(*component, *count)),
            (24, [id, _, count]) => self.add(*id, Type::Matrix(*count)),
            (25, [id, _, dim, _, _, _, sampled, ..]) => {
                self.add(*id, Type::Image { sampled: *sampled, buffer: *dim == 5 });
            }
            (27, [id, _]) => self.add(*id, Type::SampledImage),
            (28, [id, element, length]) => self.add(*id, Type::Array(*element, *length)),
            (29, [id, element]) => self.add(*id, Type::RuntimeArray(*element)),
            (30, [id, members @ ..]) => self.add(*id, Type::Struct(members.to_vec())),
            (32, [id, _, target]) => self.add(*id, Type::Pointer(*target)),
            // OpSpecConstantTrue, OpSpecConstantFalse
            (48 | 49, [kind, id]) => {
                self.constants.insert(*id, (*kind, u32::from(opcode == 48)));
            }
            // OpConstant, OpSpecConstant
            (43 | 50, [kind, id, value, ..]) => {
                self.constants.insert(*id, (*kind, *value));
            }
            // OpEntryPoint, OpFunction
            (15, [_, id, ..]) => self.entry = *id,
            (54, [_, id, ..]) => self.function = *id,
            // OpImageTexelPointer, OpLoad, OpAccessChain, OpArrayLength; OpStore; OpFunctionCall
            (60 | 61 | 65 | 68, [_, _, base, ..]) | (62, [base, ..]) => self.names(&[*base]),
            (57, [_, _, called_with @ ..]) => self.names(called_with),
            (59, [kind, id, storage, ..]) if self.function == 0 => self.variables.push((*id, *kind, *storage)),
            _ => {}
        }
    }

    fn names(&mut self, ids: &[u32]) {
        self.named.entry(self.function).or_default().extend(ids);
    }

    /// Returns the functions that may be called, and the variables that they use.
    fn reached(&self) -> HashSet<u32> {
        let (mut reached, mut next) = (HashSet::from([self.entry]), vec![self.entry]);
        while let Some(named) = next.pop().map(|function| self.named.get(&function)) {
            next.extend(named.into_iter().flatten().filter(|id| reached.insert(**id)));
        }
        reached
    }

    fn add(&mut self, id: u32, kind: Type) {
        self.types.insert(id, kind);
    }

    fn decoration(&self, id: u32, decoration: u32) -> Option<u32> {
        self.decorations.get(&(id, decoration)).map(|(operand, _)| *operand)
    }

    fn name(&self, id: u32) -> Option<&str> {
        self.names.get(&id).map(String::as_str).filter(|name| !name.is_empty())
    }

    fn interface(&self) -> Result<Interface, String> {
        let mut result = Interface { local_size: self.work_group(), ..Interface::default() };
        let reached = self.reached();
        for &(variable, pointer, storage) in &self.variables {
            if ![UNIFORM_CONSTANT, UNIFORM, PUSH_CONSTANT, STORAGE_BUFFER].contains(&storage) {
                continue;
            }
            let Some(&Type::Pointer(target)) = self.types.get(&pointer) else {
                return Err("a variable has no pointer type".to_owned());
            };
            if storage == PUSH_CONSTANT {
                let block = self.name(target).ok_or("the push constant block has no name")?.to_owned();
                let bytes =
                    self.bytes(target).ok_or_else(|| format!("push constant block {block} has no fixed size"))?;
                self.layout(target, None, &mut result.structs)?;
                result.push = Some(Push { block, bytes, used: reached.contains(&variable) });
                continue;
            }
            let resource = self.resource(variable, target, storage, reached.contains(&variable))?;
            if storage != UNIFORM_CONSTANT {
                self.block(&resource.name, target, &mut result.structs)?;
            }
            result.resources.push(resource);
        }
        result.constants = self.specialization_constants()?;
        result.resources.sort_by(|a, b| a.name.cmp(&b.name));
        if let Some(pair) = result.resources.windows(2).find(|pair| pair[0].name == pair[1].name) {
            return Err(format!("two resources are named {}", pair[0].name));
        }
        Ok(result)
    }

    fn work_group(&self) -> [u32; 3] {
        match (self.local_size_ids, self.local_size) {
            (Some(ids), _) => ids.map(|id| self.constants.get(&id).map_or(1, |(_, value)| *value)),
            (None, Some(size)) => size,
            (None, None) => [1; 3],
        }
    }

    fn specialization_constants(&self) -> Result<Vec<Constant>, String> {
        let mut constants = Vec::new();
        for (&(id, decoration), &(number, _)) in &self.decorations {
            let Some((kind, _)) = self.constants.get(&id).filter(|_| decoration == SPEC_ID) else { continue };
            let name = self.name(id).ok_or_else(|| format!("the constant of constant_id {number} has no name"))?;
            let kind = match self.types.get(kind) {
                Some(Type::Bool) => ConstantKind::Bool,
                Some(Type::Number { bytes: 4, kind }) => *kind,
                other => return Err(format!("specialization constant {name} has the unsupported type {other:?}")),
            };
            constants.push(Constant { name: name.to_owned(), id: number, kind });
        }
        constants.sort_by(|a: &Constant, b: &Constant| (a.id, &a.name).cmp(&(b.id, &b.name)));
        if let Some(pair) = constants.windows(2).find(|pair| pair[0].id == pair[1].id) {
            return Err(format!("{} and {} share constant_id {}", pair[0].name, pair[1].name, pair[0].id));
        }
        Ok(constants)
    }

    fn resource(&self, variable: u32, target: u32, storage: u32, reached: bool) -> Result<Resource, String> {
        let name = self.name(variable).or_else(|| self.name(target)).ok_or("a resource has no name")?.to_owned();
        let set = self.decoration(variable, DESCRIPTOR_SET).unwrap_or(0);
        if set > MOST_SETS {
            return Err(format!("{name} is in descriptor set {set}, beyond {MOST_SETS}"));
        }
        let kind = match (self.types.get(&target), storage) {
            (Some(Type::SampledImage), _) => ResourceKind::Sampled,
            (Some(Type::Image { sampled: 2, buffer: false }), _) => ResourceKind::StorageImage,
            (Some(Type::Struct(_)), STORAGE_BUFFER) => ResourceKind::Storage,
            (Some(Type::Struct(_)), UNIFORM) if self.decoration(target, BUFFER_BLOCK).is_none() => {
                ResourceKind::Uniform
            }
            (Some(Type::Array(..)), _) => return Err(format!("{name} is an array; use an array texture")),
            _ => return Err(format!("{name} is not a buffer, storage image or combined image sampler")),
        };
        let binding_word = match self.decorations.get(&(variable, BINDING)) {
            Some((_, word)) if reached => Some(*word),
            None if reached => return Err(format!("the compiler assigned no binding to {name}")),
            _ => None,
        };
        Ok(Resource { name, kind, set, binding_word })
    }

    /// Adds the structs of a buffer's block. A block that only wraps an array or one struct is not added itself.
    fn block(&self, name: &str, id: u32, structs: &mut Vec<Struct>) -> Result<(), String> {
        if let Some(Type::Struct(members)) = self.types.get(&id)
            && let [member] = members[..]
        {
            match self.types.get(&member) {
                Some(Type::Struct(_)) => return self.layout(member, None, structs),
                Some(Type::Array(element, _) | Type::RuntimeArray(element)) => {
                    let stride = self.decoration(member, ARRAY_STRIDE);
                    if matches!(self.types.get(element), Some(Type::Struct(_))) {
                        return self.layout(*element, stride, structs);
                    }
                    if stride != self.bytes(*element) {
                        return Err(format!("elements of {name} are padded to {stride:?} bytes: declare the padding"));
                    }
                    return Ok(());
                }
                _ => {}
            }
        }
        self.layout(id, None, structs)
    }

    fn layout(&self, id: u32, mut pitch: Option<u32>, structs: &mut Vec<Struct>) -> Result<(), String> {
        let name = self.name(id).ok_or("a struct has no name")?;
        let Some(Type::Struct(types)) = self.types.get(&id) else { return Err(format!("{name} is not a struct")) };
        let mut members = Vec::new();
        for (i, kind) in (0u32..).zip(types) {
            let label = self.member_names.get(&(id, i)).ok_or_else(|| format!("a member of {name} has no name"))?;
            let unknown = || format!("{name}.{label} has no memory layout");
            let offset = *self.member_decorations.get(&(id, i, OFFSET)).ok_or_else(unknown)?;
            match self.types.get(kind) {
                Some(Type::Struct(_)) => self.layout(*kind, None, structs)?,
                Some(Type::Array(element, _) | Type::RuntimeArray(element))
                    if matches!(self.types.get(element), Some(Type::Struct(_))) =>
                {
                    self.layout(*element, self.decoration(*kind, ARRAY_STRIDE), structs)?;
                }
                _ => {}
            }
            if matches!(self.types.get(kind), Some(Type::RuntimeArray(_))) {
                pitch = Some(offset);
                continue;
            }
            let size = self.member_bytes(id, i, *kind).ok_or_else(unknown)?;
            members.push(Member { name: label.clone(), offset, size });
        }
        let found = Struct { name: name.to_owned(), members, pitch };
        if !structs.contains(&found) {
            structs.push(found);
        }
        Ok(())
    }

    fn member_bytes(&self, id: u32, member: u32, kind: u32) -> Option<u32> {
        match self.types.get(&kind)? {
            Type::Matrix(columns) => Some(self.member_decorations.get(&(id, member, MATRIX_STRIDE))? * columns),
            _ => self.bytes(kind),
        }
    }

    /// Returns the size in bytes of a type with an explicit layout, or `None` for a type without a fixed size.
    fn bytes(&self, id: u32) -> Option<u32> {
        Some(match self.types.get(&id)? {
            Type::Number { bytes, .. } => *bytes,
            Type::Vector(component, count) => self.bytes(*component)? * count,
            Type::Array(_, length) => self.decoration(id, ARRAY_STRIDE)? * self.constants.get(length)?.1,
            Type::Struct(members) => {
                let last = u32::try_from(members.len().checked_sub(1)?).ok()?;
                let offset = self.member_decorations.get(&(id, last, OFFSET))?;
                offset + self.member_bytes(id, last, members[last as usize])?
            }
            _ => return None,
        })
    }
}

/// Decodes a zero-terminated string from words, with the lowest byte first.
fn string(words: &[u32]) -> String {
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).take_while(|byte| *byte != 0).collect();
    String::from_utf8_lossy(&bytes).into_owned()
}
