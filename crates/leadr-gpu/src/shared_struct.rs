//! Structs that Rust writes and shaders read. Rust and GLSL declare each struct, and pipeline creation checks that the declarations
//! match.

use bytemuck::NoUninit;

use super::shaders::Shader;
use super::{GpuError, Result};
use leadr_glsl::reflect::{Member, Struct};

/// A struct in buffers and push constants, declared with `shared_struct!`.
pub trait SharedStruct: NoUninit {
    /// The memory layout of the struct.
    const LAYOUT: StructLayout;
}

/// The memory layout of a shared struct in Rust.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct StructLayout {
    /// The name of the struct or block in GLSL.
    pub glsl: &'static str,
    /// The path of the struct in Rust.
    pub rust: &'static str,
    /// The size in bytes, including padding.
    pub size: usize,
    /// The members in order. Members with names that begin with `padding` do not exist in GLSL.
    pub members: &'static [MemberLayout],
}

/// A member of a shared struct in Rust.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemberLayout {
    /// The name of the member.
    pub name: &'static str,
    /// The offset from the start of the struct in bytes.
    pub offset: usize,
    /// The size of the member in bytes.
    pub size: usize,
}

/// Declares a struct shared with shaders, and implements [`SharedStruct`](crate::SharedStruct) for it.
///
/// The name after `for` is the name of the struct or block in GLSL. Members must have the same names, offsets and sizes in both
/// languages. GLSL inserts padding by its own rules (`std140`, `std430`). In Rust, each gap is a member with a name that begins
/// with `padding`.
///
/// ```
/// leadr_gpu::shared_struct! {
///     /// Content of `uniform View { mat4 clip_from_world; vec3 eye; } view;`.
///     pub struct ViewGpu for "View" {
///         /// Column by column.
///         pub clip_from_world: [[f32; 4]; 4],
///         /// World position, metres.
///         pub eye: [f32; 3],
///         padding: u32,
///     }
/// }
/// assert_eq!(<ViewGpu as leadr_gpu::SharedStruct>::LAYOUT.members[1].offset, 64);
/// ```
#[macro_export]
macro_rules! shared_struct {
    (
        $(#[$meta:meta])*
        $vis:vis struct $name:ident for $glsl:literal {
            $($(#[$member_meta:meta])* $member_vis:vis $member:ident: $kind:ty),+ $(,)?
        }
    ) => {
        $(#[$meta])*
        #[repr(C)]
        #[derive(Clone, Copy, Debug, ::bytemuck::Pod, ::bytemuck::Zeroable)]
        $vis struct $name {
            $($(#[$member_meta])* $member_vis $member: $kind),+
        }

        impl $crate::SharedStruct for $name {
            const LAYOUT: $crate::StructLayout = $crate::StructLayout {
                glsl: $glsl,
                rust: concat!(module_path!(), "::", stringify!($name)),
                size: size_of::<Self>(),
                members: &[$($crate::MemberLayout {
                    name: stringify!($member),
                    offset: std::mem::offset_of!(Self, $member),
                    size: size_of::<$kind>(),
                }),+],
            };
        }
    };
}

/// Checks that every struct of these shaders is in `twins` and has the same memory layout as its twin.
///
/// # Errors
/// Returns [`GpuError::Shader`], which names the pipeline, the struct and the difference. A twin that no shader declares is also an
/// error.
pub(crate) fn check(pipeline: &str, shaders: &[&Shader], twins: &[StructLayout]) -> Result<()> {
    let fault = |fault: String| Err(GpuError::Shader { name: pipeline.to_owned(), fault });
    for shader in shaders {
        for found in &shader.interface().structs {
            let Some(twin) = twins.iter().find(|twin| twin.glsl == found.name) else {
                return fault(format!(
                    "struct {} of {} has no twin in Rust: add one to the pipeline's `structs`",
                    found.name, shader.name
                ));
            };
            if let Some(difference) = difference(found, twin) {
                return fault(format!(
                    "struct {} of {} does not match {}: {difference}",
                    found.name, shader.name, twin.rust
                ));
            }
        }
    }
    let declared =
        |name: &str| shaders.iter().flat_map(|shader| &shader.interface().structs).any(|found| found.name == name);
    match twins.iter().find(|twin| !declared(twin.glsl)) {
        Some(twin) => fault(format!("no shader declares a struct {} for {}", twin.glsl, twin.rust)),
        None => Ok(()),
    }
}

/// Describes the difference between a GLSL struct and its twin, if there is one.
fn difference(glsl: &Struct, rust: &StructLayout) -> Option<String> {
    let ours: Vec<&MemberLayout> = rust.members.iter().filter(|member| !member.name.starts_with("padding")).collect();
    for (i, theirs) in glsl.members.iter().enumerate() {
        let Member { name, offset, size } = theirs;
        match ours.get(i) {
            None => return Some(format!("Rust has no member {name}")),
            Some(ours) if ours.name != name => return Some(format!("member {name} is {} in Rust", ours.name)),
            Some(ours) if (ours.offset, ours.size) != (*offset as usize, *size as usize) => {
                let (there, bytes) = (ours.offset, ours.size);
                return Some(format!("{name} is {size} bytes at {offset} in GLSL, {bytes} bytes at {there} in Rust"));
            }
            Some(_) => {}
        }
    }
    if let Some(extra) = ours.get(glsl.members.len()) {
        return Some(format!("GLSL has no member {}", extra.name));
    }
    match glsl.pitch {
        Some(pitch) if pitch as usize != rust.size => {
            Some(format!("its elements are {pitch} bytes apart in GLSL, {} in Rust", rust.size))
        }
        _ => None,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MEMBERS: [MemberLayout; 2] =
        [MemberLayout { name: "position", offset: 0, size: 12 }, MemberLayout { name: "weight", offset: 12, size: 4 }];

    fn against(members: &'static [MemberLayout], size: usize) -> String {
        let twin = StructLayout { glsl: "Light", rust: "test::Light", size, members };
        let member =
            |m: &MemberLayout| Member { name: m.name.to_owned(), offset: m.offset as u32, size: m.size as u32 };
        let glsl = Struct { name: "Light".to_owned(), members: MEMBERS.iter().map(member).collect(), pitch: Some(16) };
        difference(&glsl, &twin).unwrap_or_default()
    }

    #[test]
    fn twins_agree_in_names_offsets_sizes_and_pitch() {
        assert_eq!(against(&MEMBERS, 16), "");
        const PADDED: [MemberLayout; 3] =
            [MEMBERS[0], MEMBERS[1], MemberLayout { name: "padding", offset: 16, size: 16 }];
        assert_eq!(against(&PADDED, 16), "", "padding has no part in GLSL");
        assert!(against(&PADDED, 32).contains("its elements are 16 bytes apart in GLSL, 32 in Rust"));
        const RENAMED: [MemberLayout; 2] = [MEMBERS[0], MemberLayout { name: "power", offset: 12, size: 4 }];
        assert!(against(&RENAMED, 16).contains("member weight is power in Rust"));
        const MOVED: [MemberLayout; 2] = [MEMBERS[0], MemberLayout { name: "weight", offset: 16, size: 4 }];
        assert!(against(&MOVED, 20).contains("weight is 4 bytes at 12 in GLSL, 4 bytes at 16 in Rust"));
        const WIDER: [MemberLayout; 2] = [MemberLayout { name: "position", offset: 0, size: 16 }, MEMBERS[1]];
        assert!(against(&WIDER, 16).contains("position is 12 bytes at 0 in GLSL, 16 bytes at 0 in Rust"));
        assert!(against(&MEMBERS[..1], 12).contains("Rust has no member weight"));
        const MORE: [MemberLayout; 3] = [MEMBERS[0], MEMBERS[1], MemberLayout { name: "radius", offset: 16, size: 4 }];
        assert!(against(&MORE, 20).contains("GLSL has no member radius"));
    }
}
