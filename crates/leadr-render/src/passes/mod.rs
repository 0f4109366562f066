//! The passes of a frame, one file each. `new` makes the pipelines of a pass, and `record` records its commands.

use std::sync::Arc;

use crate::surfaces::numbering::Numbering;
use leadr_gpu::{Gpu, Result};

pub mod accumulate;
pub mod edges;
pub mod environment_lights;
pub mod filter;
pub mod geometry;
pub mod msaa;
pub mod object_depth;
pub mod ocean;
pub mod present;
pub mod reference;
pub mod relief_shadow;
pub mod shade;
pub mod shadow;
pub mod targets;
pub mod tiles;

/// The passes of every frame, independent of settings.
pub struct CommonPasses {
    /// The shadow maps.
    pub shadow: shadow::ShadowPass,
    /// The content of each screen tile.
    pub tiles: tiles::TilePass,
    /// The object of each pixel, as a depth.
    pub objects: object_depth::ObjectDepthPass,
    /// Marks edge samples on their pixel's own surface.
    pub edges: edges::EdgePass,
}

impl CommonPasses {
    /// Makes the passes of a scene with these casters.
    pub fn new(gpu: &Arc<Gpu>, casters: geometry::CasterKinds, numbering: Numbering) -> Result<Self> {
        Ok(Self {
            shadow: shadow::ShadowPass::new(gpu, casters)?,
            tiles: tiles::TilePass::new(gpu, numbering)?,
            objects: object_depth::ObjectDepthPass::new(gpu, numbering)?,
            edges: edges::EdgePass::new(gpu, numbering)?,
        })
    }
}
