//! The repository itself: what its crates depend on, how its sources are laid out, that the shaders stay portable.

mod dependencies;
mod links;
mod shaders;
mod source;
mod words;
