//! Models on the CPU. Read glTF 2.0 files that nobody vouches for, pose them, and find where their vertices are.
//!
//! A [`Model`] is plain data in glTF's own coordinates (metres, y up, counter-clockwise fronts); its materials are those of
//! [`leadr_maps::material`]. Knows nothing of Vulkan.
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
//! A material's `extras` may name a displacement map, beside the model:
//! `"leadr_displacement": {"uri": "bark.png", "scale": 0.02, "middle": 0.5}`, where `scale` is metres from the map's 0 to its 1 and
//! `middle` the value that lies on the mesh. `scale` may be left out; `middle` is 0.5 then, too.

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
pub use gltf::EXTENSIONS_READ;
pub use load::LoadOptions;
pub use mesh::{Influences, Mesh, MorphTarget, Primitive};
pub use model::{Camera, Light, LightKind, Model, Node, Projection, SceneRoots, Skin, Transform};
pub use pose::Pose;
