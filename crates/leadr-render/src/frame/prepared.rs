//! A frame that is ready to be drawn.

use std::sync::Arc;

use super::edge_samples::EdgeSamples;
use super::renderer::Renderer;
use super::surfaces::PreparedSurfaces;
use super::targets::Targets;
use crate::passes::accumulate::AccumulatePass;
use crate::passes::lamps::Lamp;
use crate::passes::msaa::MsaaPass;
use crate::passes::reference::{ReferencePass, ReliefLights};
use crate::passes::shade::{ShadePass, SkyBehindPass};
use crate::passes::shadow::{ShadowMaps, ShadowView};
use crate::passes::targets::MultisampleTargets;
use crate::scene::FrameState;
use crate::settings::RenderSettings;
use leadr_gpu::{Buffer, GpuError, Image, ResourceSet, Result};

/// A frame that is ready to be drawn. The scene is posed, and targets and pipelines exist. Only [`Renderer::prepare`] makes one.
pub struct PreparedFrame<'r> {
    pub(super) renderer: &'r mut Renderer,
    pub(super) plan: FramePlan,
}

/// A frame that is paused between two samples and does not borrow the renderer. A window pauses a frame to spread its samples over
/// many refreshes. [`Renderer::resume`] continues the frame.
pub struct PausedFrame(FramePlan);

/// The data of a frame that stay the same for all its samples.
pub(super) struct FramePlan {
    pub state: FrameState,
    pub settings: RenderSettings,
    pub surfaces: PreparedSurfaces,
    pub targets: Targets,
    pub path: FramePath,
    pub shadow_maps: ShadowMaps,
    /// The buffer of the [`LightingGpu`](crate::passes::shade::LightingGpu) block.
    pub lighting: Arc<Buffer>,
    pub lamps: FrameLamps,
    /// The descriptor set of the light.
    pub scene: ResourceSet,
    pub accumulate: AccumulatePass,
    /// The number of samples in the mean so far.
    pub drawn: u32,
    /// The renderer's frame counter when the frame was prepared.
    pub number: u64,
}

/// The lamps of a frame, and the buffer in which the shaders find them.
pub(super) struct FrameLamps {
    pub list: Vec<Lamp>,
    pub buffer: Arc<Buffer>,
}

/// The sequence of passes of a frame.
pub(super) enum FramePath {
    /// The filter passes also shade, in the same submission.
    Fused {
        lit: MappedLight,
        /// The multisampled geometry, if multisampling is on.
        multisample: Option<Multisample>,
    },
    /// Shading reads the G-buffer, after edge samples were joined there.
    Deferred { lit: MappedLight, shade: ShadePass, edges: Option<Box<EdgeSamples>> },
    /// The reference, whose lights are shadowed by the relief and drawn again for every sample.
    Reference { pass: ReferencePass, lights: Box<ReliefLights> },
}

/// The suns, lamps and environment, whose coarse shadows come from shadow maps.
pub(super) struct MappedLight {
    /// The views of the lights that cast shadows. Suns precede lamps.
    pub shadows: Vec<ShadowView>,
    pub behind: SkyBehindPass,
}

/// The multisampled targets and the pass that reads them.
pub(super) struct Multisample {
    pub pass: MsaaPass,
    pub targets: MultisampleTargets,
}

impl FramePath {
    /// Returns the lights with shadow maps, or `None` for the reference.
    pub fn lit(&self) -> Option<&MappedLight> {
        match self {
            Self::Fused { lit, .. } | Self::Deferred { lit, .. } => Some(lit),
            Self::Reference { .. } => None,
        }
    }

    /// Returns the views of the shadow maps.
    pub fn shadows(&self) -> &[ShadowView] {
        self.lit().map_or(&[], |lit| &lit.shadows)
    }

    /// Whether the filter passes write the G-buffer.
    pub fn fills_gbuffer(&self) -> bool {
        !matches!(self, Self::Fused { .. })
    }

    /// Returns the edge samples, if any.
    pub fn edges(&self) -> Option<&EdgeSamples> {
        match self {
            Self::Deferred { edges, .. } => edges.as_deref(),
            Self::Fused { .. } | Self::Reference { .. } => None,
        }
    }

    /// Returns the multisampled geometry, if multisampling is on.
    pub fn multisample(&self) -> Option<&Multisample> {
        match self {
            Self::Fused { multisample, .. } => multisample.as_ref(),
            Self::Deferred { .. } | Self::Reference { .. } => None,
        }
    }
}

impl PreparedFrame<'_> {
    /// Whether a sample is a single submission. The CPU can then prepare the next frame while the GPU draws this one.
    #[doc(hidden)]
    pub fn overlaps(&self) -> bool {
        self.plan.path.lit().is_some() && self.plan.path.edges().is_none()
    }

    /// Returns the image with the mean of the samples.
    #[doc(hidden)]
    pub fn image(&self) -> &Image {
        &self.plan.targets.mean
    }

    /// Returns the number of samples in the mean so far.
    pub fn samples(&self) -> u32 {
        self.plan.drawn
    }

    /// Pauses the frame and releases the renderer.
    #[must_use]
    pub fn pause(self) -> PausedFrame {
        PausedFrame(self.plan)
    }
}

impl PausedFrame {
    /// Returns the state, so that it can be prepared with different settings.
    pub fn state(&self) -> &FrameState {
        &self.0.state
    }

    /// Returns the number of samples in the mean so far.
    pub fn samples(&self) -> u32 {
        self.0.drawn
    }

    /// Returns the image with the mean of the samples.
    #[doc(hidden)]
    pub fn image(&self) -> &Image {
        &self.0.targets.mean
    }

    /// Returns an upper bound on the triangles of one sample over all views, and the number of patches drawn for the camera.
    #[doc(hidden)]
    pub fn counts(&self) -> (u64, u32) {
        self.0.surfaces.counts()
    }
}

impl Renderer {
    /// Prepares the state of a paused frame with different settings, in separate targets ([`swap_targets`](Self::swap_targets)).
    /// The two frames share the light and the waves, so each of them can be paused and resumed while the other is drawn.
    ///
    /// # Errors
    /// Returns the errors of [`prepare`](Self::prepare), and of [`resume`](Self::resume) for an outdated frame.
    #[doc(hidden)]
    pub fn prepare_second(&mut self, paused: &PausedFrame, settings: &RenderSettings) -> Result<PreparedFrame<'_>> {
        let number = self.check_current(paused)?;
        let frame = self.prepare(&paused.0.state, settings)?;
        frame.renderer.prepared = number;
        Ok(PreparedFrame { plan: FramePlan { number, ..frame.plan }, ..frame })
    }

    /// Continues a paused frame.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if this renderer has prepared another frame since, which overwrote shared data.
    pub fn resume(&mut self, paused: PausedFrame) -> Result<PreparedFrame<'_>> {
        self.check_current(&paused)?;
        Ok(PreparedFrame { renderer: self, plan: paused.0 })
    }

    /// Returns the number of a paused frame, if the data that it shares are still valid.
    fn check_current(&self, paused: &PausedFrame) -> Result<u64> {
        if paused.0.number != self.prepared {
            let fault = "another frame or environment overwrote it while it was paused: prepare it again".to_owned();
            return Err(GpuError::Usage { name: "frame".to_owned(), fault });
        }
        Ok(paused.0.number)
    }
}
