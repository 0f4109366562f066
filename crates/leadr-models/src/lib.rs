//! Models on the CPU: reads untrusted glTF 2.0 files, poses them, and computes vertex positions.
//!
//! A [`Model`] is plain data in glTF coordinates (metres, y up, counter-clockwise fronts). The materials are those of
//! [`leadr_maps::material`]. The crate does not depend on Vulkan.
//!
//! ```no_run
//! use leadr_models::{LoadOptions, Model};
//!
//! let model = Model::load("fox.glb", LoadOptions::default())?;
//! let pose = model.pose(model.animation_named("Walk"), 0.35);
//! for node in model.shown_nodes() {
//!     if let Some(mesh) = model.nodes[node].mesh {
//!         for primitive in 0..model.meshes[mesh].primitives.len() {
//!             println!("{:?}", model.posed_vertices(&pose, node, primitive).positions.first());
//!         }
//!     }
//! }
//! # Ok::<(), leadr_models::ModelError>(())
//! ```
//!
//! A material's `extras` may refer to a displacement map beside the model: `"leadr_displacement": {"uri": "bark.png", "scale":
//! 0.02, "middle": 0.5}`. `scale` is metres from the map's 0 to its 1 and is optional. `middle` is the value at the mesh surface,
//! 0.5 by default.

mod animation;
mod deform;
mod fault;
mod gltf;
pub mod limits;
mod load;
mod mesh;
mod model;
mod pose;

pub use animation::{Animation, Channel, Curve, Interpolation, Property};
pub use deform::PosedVertices;
pub use fault::{ModelError, ModelFault};
pub use gltf::{Document, DocumentImage, EXTENSIONS_READ};
pub use load::LoadOptions;
pub use mesh::{Influences, Mesh, MorphTarget, Primitive};
pub use model::{Camera, Light, LightKind, Model, Node, Projection, SceneRoots, Skin, Transform};
pub use pose::Pose;
