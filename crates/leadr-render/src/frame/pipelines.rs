//! Pipelines that depend on how a frame is drawn, each made when a frame first asks for it.

use std::sync::Arc;

use super::cache::Cache;
use crate::passes::accumulate::{AccumulatePass, PartsKind};
use crate::passes::edges::{JoinKind, JoinPass};
use crate::passes::msaa::MsaaPass;
use crate::passes::reference::{ReferenceKind, ReferencePass};
use crate::passes::shade::{ShadeKind, ShadePass, SkyBehindPass};
use crate::surfaces::numbering::Numbering;
use leadr_gpu::{Gpu, Result};

/// The pipelines that were asked for so far.
#[derive(Default)]
pub struct Pipelines {
    shade: Cache<ShadeKind, ShadePass>,
    sky: Cache<bool, SkyBehindPass>,
    multisample: Cache<u32, MsaaPass>,
    accumulate: Cache<PartsKind, AccumulatePass>,
    join: Cache<JoinKind, JoinPass>,
    reference: Cache<ReferenceKind, ReferencePass>,
}

impl Pipelines {
    /// The shading of pixels or of edge samples.
    pub fn shade(&mut self, gpu: &Arc<Gpu>, kind: ShadeKind) -> Result<ShadePass> {
        self.shade.get(kind, || ShadePass::new(gpu, kind))
    }

    /// The sky behind surfaces, of multisampled geometry or of other.
    pub fn sky(&mut self, gpu: &Arc<Gpu>, multisampled: bool) -> Result<SkyBehindPass> {
        self.sky.get(multisampled, || SkyBehindPass::new(gpu, multisampled))
    }

    /// What finds the surfaces of multisampled pixels.
    pub fn multisample(&mut self, gpu: &Arc<Gpu>, samples: u32, numbering: Numbering) -> Result<MsaaPass> {
        self.multisample.get(samples, || MsaaPass::new(gpu, samples, numbering))
    }

    /// The mean of samples that are put together from such parts.
    pub fn accumulate(&mut self, gpu: &Arc<Gpu>, kind: PartsKind) -> Result<AccumulatePass> {
        self.accumulate.get(kind, || AccumulatePass::new(gpu, kind))
    }

    /// The joining of edge samples.
    pub fn join(&mut self, gpu: &Arc<Gpu>, kind: JoinKind) -> Result<JoinPass> {
        self.join.get(kind, || JoinPass::new(gpu, kind))
    }

    /// The reference with shadows of the relief; see [`ReferencePass::new`].
    pub fn reference(&mut self, gpu: &Arc<Gpu>, kind: ReferenceKind) -> Result<ReferencePass> {
        self.reference.get(kind, || ReferencePass::new(gpu, kind))
    }
}
