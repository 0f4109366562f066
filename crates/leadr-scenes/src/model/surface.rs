//! The surface of a model, which its objects share.

use super::parts::{Parts, Placement};
use super::places::Places;
use leadr_models::{Model, Pose};
use leadr_render::surfaces::patch_mesh::PosedVertices;

/// Where the surface of a model is, for all of its objects.
pub struct Surface {
    /// The places of its vertices, if any material is displaced.
    pub places: Option<Places>,
    /// The edges where an object ends and another goes on, for each object.
    pub rims: Vec<Vec<[u32; 2]>>,
    /// How it stands in the world.
    pub placement: Placement,
    /// Its diagonal, metres.
    pub size: f32,
}

impl Surface {
    /// The vertices of all objects in a pose.
    pub fn posed(&self, model: &Model, parts: &Parts, pose: &Pose) -> Vec<PosedVertices> {
        let mut posed = parts.all_posed(model, pose, &self.placement);
        if let Some(places) = &self.places {
            places.share(&mut posed);
        }
        posed
    }
}
