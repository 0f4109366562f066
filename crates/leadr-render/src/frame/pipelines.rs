//! Pipelines that depend on how a frame is drawn. Each is made on first use.

use super::cache::Cache;
use crate::passes::accumulate::{AccumulatePass, PartsKind};
use crate::passes::edges::{JoinKind, JoinPass};
use crate::passes::msaa::MsaaPass;
use crate::passes::reference::{ReferenceKind, ReferencePass};
use crate::passes::shade::{ShadeKind, ShadePass, SkyBehindPass};

/// The pipelines made so far.
#[derive(Default)]
pub struct Pipelines {
    /// Shading of pixels or edge samples.
    pub shade: Cache<ShadeKind, ShadePass>,
    /// The sky behind surfaces, keyed by whether the geometry is multisampled.
    pub sky: Cache<bool, SkyBehindPass>,
    /// Finding the surfaces of a pixel, by number of samples.
    pub multisample: Cache<u32, MsaaPass>,
    /// The mean of the samples, by the parts of a sample.
    pub accumulate: Cache<PartsKind, AccumulatePass>,
    /// Joining of edge samples.
    pub join: Cache<JoinKind, JoinPass>,
    /// The reference with relief shadows.
    pub reference: Cache<ReferenceKind, ReferencePass>,
}
