//! Filters the textures of materials and of glTF models for engines that read normals and roughness as if the surface under a pixel were
//! flat.
//!
//! Every texture gets mip levels that keep the look of the surface at a distance ([`leadr_maps::mips`]): colours are means of light, normals
//! have length 1, and roughness contains the spread of the normals that a level has lost. The levels are stored as KTX2, compressed in
//! blocks, or as DDS, so the engine needs no other shader.
//!
//! ```no_run
//! use leadr_models::{Document, LoadOptions};
//! use leadr_textures::engine::Engine;
//! use leadr_textures::model::filter_model;
//!
//! let document = Document::open("bricks.glb", &LoadOptions::default())?;
//! let filtered = filter_model(document, Engine::Gltf, &mut |_, _| {})?;
//! std::fs::write("bricks-filtered.glb", filtered.glb()?)?;
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

pub mod blocks;
pub mod dds_file;
pub mod engine;
pub mod ktx2_file;
pub mod material;
pub mod model;
