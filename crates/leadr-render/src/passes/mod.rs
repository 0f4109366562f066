//! The passes of a frame, one file each: `new` makes a pass's pipelines, `record` records its commands.

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

/// The passes that every frame has, whatever its settings.
pub struct CommonPasses {
    /// The sun's shadow map.
    pub shadow: shadow::ShadowPass,
    /// The content of each tile of the screen.
    pub tiles: tiles::TilePass,
    /// Which object each pixel shows.
    pub objects: object_depth::ObjectDepthPass,
    /// The edge samples that see their pixel's own surface.
    pub edges: edges::EdgePass,
}

impl CommonPasses {
    /// Makes the passes of a scene with such casters.
    pub fn new(gpu: &Arc<Gpu>, casters: geometry::CasterKinds, numbering: Numbering) -> Result<Self> {
        Ok(Self {
            shadow: shadow::ShadowPass::new(gpu, casters)?,
            tiles: tiles::TilePass::new(gpu, numbering)?,
            objects: object_depth::ObjectDepthPass::new(gpu, numbering)?,
            edges: edges::EdgePass::new(gpu, numbering)?,
        })
    }
}
