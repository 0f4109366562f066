//! The passes of a frame, with one file for each pass. `new` makes the pipelines of a pass, and `record` records its commands.

use std::sync::Arc;

use crate::surfaces::numbering::Numbering;
use leadr_gpu::{Gpu, Result};

pub mod accumulate;
pub mod edges;
pub mod environment_lights;
pub mod filter;
pub mod geometry;
pub mod lamps;
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

/// The passes that run in every frame, whatever the settings are.
pub struct CommonPasses {
    /// The pass that draws the shadow maps.
    pub shadow: shadow::ShadowPass,
    /// The pass that records the content of each screen tile.
    pub tiles: tiles::TilePass,
    /// The pass that writes the object of each pixel as a depth.
    pub objects: object_depth::ObjectDepthPass,
    /// The pass that marks edge samples that lie on their pixel's own surface.
    pub edges: edges::EdgePass,
}

impl CommonPasses {
    /// Makes the passes for a scene with these shadow casters.
    pub fn new(gpu: &Arc<Gpu>, casters: geometry::CasterKinds, numbering: Numbering) -> Result<Self> {
        Ok(Self {
            shadow: shadow::ShadowPass::new(gpu, casters)?,
            tiles: tiles::TilePass::new(gpu, numbering)?,
            objects: object_depth::ObjectDepthPass::new(gpu, numbering)?,
            edges: edges::EdgePass::new(gpu, numbering)?,
        })
    }
}
