//! The repository: dependencies of its crates, layout of its sources, portability of its shaders.

mod dependencies;
mod links;
mod shaders;
mod source;
mod words;
