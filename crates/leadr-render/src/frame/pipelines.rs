//! Pipelines that depend on how a frame is drawn, each made when a frame first asks for it.

use super::cache::Cache;
use crate::passes::accumulate::{AccumulatePass, PartsKind};
use crate::passes::edges::{JoinKind, JoinPass};
use crate::passes::msaa::MsaaPass;
use crate::passes::reference::{ReferenceKind, ReferencePass};
use crate::passes::shade::{ShadeKind, ShadePass, SkyBehindPass};

/// The pipelines that were asked for so far.
#[derive(Default)]
pub struct Pipelines {
    /// The shading of pixels or of edge samples.
    pub shade: Cache<ShadeKind, ShadePass>,
    /// The sky behind surfaces, of multisampled geometry or of other.
    pub sky: Cache<bool, SkyBehindPass>,
    /// What finds the surfaces of so many samples of each pixel.
    pub multisample: Cache<u32, MsaaPass>,
    /// The mean of samples that are put together from such parts.
    pub accumulate: Cache<PartsKind, AccumulatePass>,
    /// The joining of edge samples.
    pub join: Cache<JoinKind, JoinPass>,
    /// The reference with shadows of the relief.
    pub reference: Cache<ReferenceKind, ReferencePass>,
}
