//! Rewrites the textures of glTF models for engines that read normals and roughness as if the surface under a pixel were flat.
//!
//! Every texture gets mip levels that keep the look of the surface at a distance ([`leadr_maps::mips`]): colours are means of light, normals
//! have length 1, and roughness contains the spread of the normals that a level has lost. The levels are compressed in blocks and stored as
//! KTX2, so the engine needs no other shader.
//!
//! ```no_run
//! use leadr_models::{Document, LoadOptions};
//! use leadr_textures::model::{Engine, filter_model};
//!
//! let document = Document::open("bricks.glb", &LoadOptions::default())?;
//! let filtered = filter_model(document, Engine::Gltf, &mut |_, _| {})?;
//! std::fs::write("bricks-filtered.glb", filtered.glb()?)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod blocks;
pub mod ktx2_file;
pub mod model;
