//! Embeds GLSL entry points in programs, as SPIR-V with the names of all declarations.
//!
//! A build script calls [`embed`], and the crate includes the generated file, which is a table of [`Shader`]s. Pipelines find resources,
//! constants and structs of a shader by name in its [`Interface`](reflect::Interface). A program that compiles changed sources at run time
//! uses [`compiler::Compiler`] and [`Shader::leaked`].

#[cfg(feature = "compile")]
pub mod compiler;
pub mod constants;
#[cfg(feature = "compile")]
mod embed;
pub mod reflect;
mod shader;
pub mod spirv;

#[cfg(feature = "compile")]
pub use embed::embed;
pub use shader::{Shader, Stage};
