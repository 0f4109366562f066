//! Pipelines that depend on how a frame is drawn. Each pipeline is made on first use.

use super::cache::Cache;
use crate::passes::accumulate::{AccumulatePass, PartsKind};
use crate::passes::edges::{JoinKind, JoinPass};
use crate::passes::msaa::MsaaPass;
use crate::passes::reference::{ReferenceKind, ReferencePass};
use crate::passes::shade::{ShadeKind, ShadePass, SkyBehindPass};

/// The pipelines that frames have used so far.
#[derive(Default)]
pub struct Pipelines {
    /// Pipelines that shade pixels or edge samples.
    pub shade: Cache<ShadeKind, ShadePass>,
    /// Pipelines for the sky behind surfaces. The key is whether the geometry is multisampled.
    pub sky: Cache<bool, SkyBehindPass>,
    /// Pipelines that find the surfaces of a pixel, by the number of samples per pixel.
    pub multisample: Cache<u32, MsaaPass>,
    /// Pipelines that update the mean of the samples, by the parts that make up a sample.
    pub accumulate: Cache<PartsKind, AccumulatePass>,
    /// Pipelines that join edge samples.
    pub join: Cache<JoinKind, JoinPass>,
    /// Pipelines of the reference with relief shadows.
    pub reference: Cache<ReferenceKind, ReferencePass>,
}
