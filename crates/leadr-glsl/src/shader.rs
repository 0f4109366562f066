//! Shader entry points in compiled form.

use std::path::Path;
use std::sync::OnceLock;

use crate::reflect::{Interface, interface};

/// The pipeline stage of an entry point.
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
    /// Returns the stage for a file's extension.
    pub fn of(path: &Path) -> Option<Self> {
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
    /// The path of the entry point inside `shaders-glsl/`.
    pub name: &'static str,
    /// The stage of the entry point.
    pub stage: Stage,
    /// The SPIR-V of the entry point.
    pub code: &'static [u8],
    interface: OnceLock<Interface>,
}

impl Shader {
    /// Creates an entry point from the output of this crate's compiler, which has checked its declarations.
    pub const fn new(name: &'static str, stage: Stage, code: &'static [u8]) -> Self {
        Self { name, stage, code, interface: OnceLock::new() }
    }

    /// Creates an entry point that is never freed. Pipelines refer to it, and a session compiles only a few entry points.
    ///
    /// # Panics
    /// Panics if the name does not have the extension of a stage. Such a file does not compile.
    pub fn leaked(name: &str, code: &[u32]) -> &'static Self {
        let stage = Stage::of(name.as_ref()).expect("compiled by its stage");
        let code: Vec<u8> = code.iter().flat_map(|word| word.to_ne_bytes()).collect();
        Box::leak(Box::new(Self::new(name.to_owned().leak(), stage, code.leak())))
    }

    /// Returns the SPIR-V in words.
    pub fn words(&self) -> Vec<u32> {
        self.code.as_chunks().0.iter().map(|bytes| u32::from_ne_bytes(*bytes)).collect()
    }

    /// Returns the declarations in the SPIR-V, read at the first call.
    ///
    /// # Panics
    /// Panics if the SPIR-V does not come from the compiler, which rejects unreadable modules.
    pub fn interface(&self) -> &Interface {
        self.interface.get_or_init(|| interface(&self.words()).expect("the compiler has read it"))
    }
}
