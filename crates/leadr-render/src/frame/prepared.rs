//! A frame that can be drawn.

use std::sync::Arc;

use super::edge_samples::EdgeSamples;
use super::renderer::Renderer;
use super::surfaces::PreparedSurfaces;
use super::targets::Targets;
use crate::passes::accumulate::AccumulatePass;
use crate::passes::msaa::MsaaPass;
use crate::passes::reference::{ReferencePass, ReliefLights};
use crate::passes::shade::{ShadePass, SkyBehindPass};
use crate::passes::shadow::{ShadowMaps, ShadowView};
use crate::passes::targets::MultisampleTargets;
use crate::scene::FrameState;
use crate::settings::RenderSettings;
use leadr_gpu::{Buffer, GpuError, Image, ResourceSet, Result};

/// A frame that is ready to be drawn, and the only thing that can be: its scene is posed, its targets and pipelines are made. Comes from
/// [`Renderer::prepare`].
pub struct PreparedFrame<'r> {
    pub(super) renderer: &'r mut Renderer,
    pub(super) plan: FramePlan,
}

/// A frame between two of its samples, while nothing borrows the renderer: a window keeps one whose samples it spreads over
/// many refreshes. [`Renderer::resume`] goes on with it.
pub struct PausedFrame(FramePlan);

/// What is known of a frame before its first sample.
pub(super) struct FramePlan {
    pub state: FrameState,
    pub settings: RenderSettings,
    pub surfaces: PreparedSurfaces,
    pub targets: Targets,
    pub path: FramePath,
    pub shadow_maps: ShadowMaps,
    /// The [`LightingGpu`](crate::passes::shade::LightingGpu) block.
    pub lighting: Arc<Buffer>,
    /// The set of its light.
    pub scene: ResourceSet,
    pub accumulate: AccumulatePass,
    /// Samples in the mean.
    pub drawn: u32,
    /// The renderer's count of prepared frames.
    pub number: u64,
}

/// The passes that a frame takes.
pub(super) enum FramePath {
    /// Filter passes shade what they filter, in one submission.
    Fused {
        lit: MappedLight,
        /// Where the geometry is multisampled.
        multisample: Option<Multisample>,
    },
    /// What is filtered goes through the G-buffer, where edge samples are joined to it before it is shaded.
    Deferred { lit: MappedLight, shade: ShadePass, edges: Option<Box<EdgeSamples>> },
    /// As the reference, by lights that the relief hides, drawn anew for every sample.
    Reference { pass: ReferencePass, lights: Box<ReliefLights> },
}

/// Suns, point lights and environment, whose coarse shadows are in maps.
pub(super) struct MappedLight {
    /// Where the lights look from, if they throw shadows: suns, then point lights.
    pub shadows: Vec<ShadowView>,
    pub behind: SkyBehindPass,
}

/// Several samples of the geometry in each pixel.
pub(super) struct Multisample {
    pub pass: MsaaPass,
    pub targets: MultisampleTargets,
}

impl FramePath {
    /// Lights with shadow maps, if it has such.
    pub fn lit(&self) -> Option<&MappedLight> {
        match self {
            Self::Fused { lit, .. } | Self::Deferred { lit, .. } => Some(lit),
            Self::Reference { .. } => None,
        }
    }

    /// The views of the shadow maps.
    pub fn shadows(&self) -> &[ShadowView] {
        self.lit().map_or(&[], |lit| &lit.shadows)
    }

    /// Whether what is filtered goes through the G-buffer.
    pub fn fills_gbuffer(&self) -> bool {
        !matches!(self, Self::Fused { .. })
    }

    /// Edge samples, if there are any.
    pub fn edges(&self) -> Option<&EdgeSamples> {
        match self {
            Self::Deferred { edges, .. } => edges.as_deref(),
            Self::Fused { .. } | Self::Reference { .. } => None,
        }
    }

    /// Multisampled geometry, if there is any.
    pub fn multisample(&self) -> Option<&Multisample> {
        match self {
            Self::Fused { multisample, .. } => multisample.as_ref(),
            Self::Deferred { .. } | Self::Reference { .. } => None,
        }
    }
}

impl PreparedFrame<'_> {
    /// Whether a sample is one submission, so that the processor can prepare the next frame while the device draws this one.
    #[doc(hidden)]
    pub fn overlaps(&self) -> bool {
        self.plan.path.lit().is_some() && self.plan.path.edges().is_none()
    }

    /// The image that holds the mean of the samples.
    #[doc(hidden)]
    pub fn image(&self) -> &Image {
        &self.plan.targets.mean
    }

    /// Samples in its mean so far.
    pub fn samples(&self) -> u32 {
        self.plan.drawn
    }

    /// Gives the renderer back for now.
    #[must_use]
    pub fn pause(self) -> PausedFrame {
        PausedFrame(self.plan)
    }
}

impl PausedFrame {
    /// The state that it shows, to be prepared with other settings.
    pub fn state(&self) -> &FrameState {
        &self.0.state
    }

    /// Samples in its mean so far.
    pub fn samples(&self) -> u32 {
        self.0.drawn
    }

    /// The image that holds the mean of the samples.
    #[doc(hidden)]
    pub fn image(&self) -> &Image {
        &self.0.targets.mean
    }

    /// Upper bound on the triangles of one sample, all views together, and patches drawn for the camera.
    #[doc(hidden)]
    pub fn counts(&self) -> (u64, u32) {
        self.0.surfaces.counts()
    }
}

impl Renderer {
    /// Prepares a picture of the state of a paused frame with other settings, in targets of its own
    /// ([`swap_targets`](Self::swap_targets)). What both share, light and waves, is the same in both, so each can be paused and resumed
    /// while the other is drawn.
    ///
    /// # Errors
    /// As [`prepare`](Self::prepare), and as [`resume`](Self::resume) for a frame that could not be resumed.
    #[doc(hidden)]
    pub fn prepare_beside(&mut self, paused: &PausedFrame, settings: &RenderSettings) -> Result<PreparedFrame<'_>> {
        let number = self.check_current(paused)?;
        let frame = self.prepare(&paused.0.state, settings)?;
        frame.renderer.prepared = number;
        Ok(PreparedFrame { plan: FramePlan { number, ..frame.plan }, ..frame })
    }

    /// Goes on with a paused frame.
    ///
    /// # Errors
    /// [`GpuError::Usage`] if this renderer prepared another frame since, which overwrote what this one needs.
    pub fn resume(&mut self, paused: PausedFrame) -> Result<PreparedFrame<'_>> {
        self.check_current(&paused)?;
        Ok(PreparedFrame { renderer: self, plan: paused.0 })
    }

    /// The number of a paused frame, if nothing has overwritten what it needs.
    fn check_current(&self, paused: &PausedFrame) -> Result<u64> {
        if paused.0.number != self.prepared {
            let fault = "the renderer has prepared another frame or got another environment since it was paused: prepare it again".to_owned();
            return Err(GpuError::Usage { name: "frame".to_owned(), fault });
        }
        Ok(paused.0.number)
    }
}
