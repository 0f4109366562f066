//! The renderer: a scene on a device, and the passes that draw it.

use std::sync::Arc;

use super::drawing::{Purpose, drawing, shade_kind};
use super::pipelines::Pipelines;
use super::pool::Pool;
use super::scene_set::SceneTables;
use super::sky::SkyPast;
use super::surfaces::Surfaces;
use super::surfaces::meshes::{MeshPipelines, Meshes};
use super::surfaces::sea::Sea;
use super::targets::Targets;
use super::timing::PassTimer;
use crate::light::environment::Environment;
use crate::light::irradiance::IrradiancePass;
use crate::light::sky::Sky;
use crate::passes::CommonPasses;
use crate::passes::geometry::CasterKinds;
use crate::scene::{FrameState, Scene};
use crate::settings::RenderSettings;
use crate::surfaces::fits::Fits;
use crate::surfaces::numbering::Numbering;
use crate::surfaces::object::Upload;
use crate::surfaces::placeholders::Placeholders;
use leadr_gpu::{Buffer, Gpu, Image, Result};

/// Renders a scene on a device.
pub struct Renderer {
    pub(super) gpu: Arc<Gpu>,
    pub(super) surfaces: Surfaces,
    /// What there is among them that throws shadows.
    pub(super) casters: CasterKinds,
    pub(super) environment: Environment,
    pub(super) irradiance: IrradiancePass,
    pub(super) tables: SceneTables,
    /// What large shapes hide of the surroundings.
    pub(super) sky: SkyPast,
    pub(super) common: CommonPasses,
    pub(super) pipelines: Pipelines,
    /// [`LightingGpu`](crate::passes::shade::LightingGpu) blocks.
    pub(super) lighting: Pool<Buffer>,
    pub(super) timer: PassTimer,
    /// Targets that frames of the same size share.
    pub(super) targets: Option<Targets>,
    /// The last sample in the targets.
    pub(super) last: Option<LastSample>,
    pub(super) numbering: Numbering,
    /// Frames prepared so far.
    pub(super) prepared: u64,
}

/// Targets that a renderer does not use at the moment.
#[derive(Default)]
pub struct KeptTargets {
    targets: Option<Targets>,
    last: Option<LastSample>,
}

/// What the targets show.
#[derive(Clone)]
pub(super) struct LastSample {
    pub state: FrameState,
    pub settings: RenderSettings,
    pub index: u32,
    /// Whether the G-buffer holds it.
    pub in_gbuffer: bool,
}

impl Renderer {
    /// Uploads a scene: objects, a sea, or both.
    ///
    /// # Errors
    /// More objects than `MAX_OBJECTS`, an object with more patches than there are numbers for, unusable waves, memory that is short, or
    /// a Vulkan call that failed.
    pub fn new(gpu: &Arc<Gpu>, scene: impl Into<Scene>, environment: Environment) -> Result<Self> {
        Self::with(gpu, scene.into(), environment, None)
    }

    /// Uploads a scene, and meanwhile makes the pipelines of frames like this one, which take drivers up to half a second; the first
    /// frame makes what is missing. The processor's threads share the work.
    pub fn for_frames_like(
        gpu: &Arc<Gpu>,
        scene: impl Into<Scene>,
        environment: Environment,
        state: &FrameState,
        settings: &RenderSettings,
    ) -> Result<Self> {
        Self::with(gpu, scene.into(), environment, Some((state, settings)))
    }

    /// `first`: a frame for which pipelines are made.
    fn with(
        gpu: &Arc<Gpu>,
        Scene { objects, ocean, cache, map_precision }: Scene,
        environment: Environment,
        first: Option<(&FrameState, &RenderSettings)>,
    ) -> Result<Self> {
        let numbering = Numbering::of(&objects)?;
        let pipelines = MeshPipelines::of(gpu, &objects, numbering);
        let casters = pipelines.casters();
        let first = first.map(|(state, settings)| {
            let kind = shade_kind(state, settings, &environment, pipelines.demands(state));
            (state, drawing(*settings, kind, Purpose::Picture))
        });
        let fits = Fits::of(&objects)?;
        let none = Placeholders::new(gpu)?;
        let upload = Upload { cache: cache.as_ref(), format: map_precision, fits: &fits, none: &none };
        let of_meshes = |pipelines: &mut MeshPipelines| match &first {
            Some((state, (settings, drawing))) => pipelines.prepare(state, settings, *drawing).map(|_| ()),
            None => Ok(()),
        };
        let sea = |ocean| {
            let mut sea = Sea::new(gpu, ocean, numbering)?;
            if let Some((_, (settings, drawing))) = &first {
                sea.make_pipelines(settings, *drawing)?;
            }
            Ok(sea)
        };
        let passes = || {
            Ok((IrradiancePass::new(gpu)?, SceneTables::new(gpu, &fits)?, CommonPasses::new(gpu, casters, numbering)?))
        };
        // Meshes last: they are many pieces of work, which fill the time that one thread would wait for another.
        let ((sea, passes), meshes) = rayon::join(
            || rayon::join(|| ocean.map(sea).transpose(), passes),
            || Meshes::new(pipelines, objects, upload, of_meshes),
        );
        let (irradiance, tables, common) = passes?;
        Ok(Self {
            surfaces: Surfaces { meshes: meshes?, sea: sea? },
            casters,
            environment,
            irradiance,
            tables,
            sky: SkyPast::default(),
            common,
            pipelines: Pipelines::default(),
            lighting: Pool::default(),
            timer: PassTimer::new(gpu)?,
            targets: None,
            last: None,
            prepared: 0,
            numbering,
            gpu: gpu.clone(),
        })
    }

    /// Whether anything moves by itself as time goes on, whatever its poses: a sea does.
    #[doc(hidden)]
    pub fn moves(&self) -> bool {
        self.surfaces.sea.is_some()
    }

    /// The device.
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// The environment's nine spherical harmonics coefficients as the last frame was lit by them, see
    /// `IrradiancePass`: rgb and 0 each.
    #[doc(hidden)]
    pub fn radiance_sh(&self) -> Result<Vec<[f32; 4]>> {
        self.irradiance.coefficients().read(0, 9)
    }

    /// Brings the environment to a sky before the frame that shows it, so that the frame need not.
    pub fn show_sky(&mut self, sky: &Sky) -> Result<()> {
        let environment = &mut self.environment;
        let drawn = self.gpu.submit("sky", |cmd| environment.update_sky(cmd, sky)).map(|_| ());
        drawn.inspect_err(|_| environment.forget_sky())
    }

    /// The light from all around.
    pub fn environment(&self) -> &Environment {
        &self.environment
    }

    /// Puts the scene under another environment and returns the old one, which may be put back. Frames prepared from now on show
    /// it; one that is paused cannot be resumed.
    pub fn set_environment(&mut self, environment: Environment) -> Environment {
        self.prepared += 1;
        std::mem::replace(&mut self.environment, environment)
    }

    /// Puts the scene under the environment of another renderer, and that one's under its own; as [`set_environment`](Self::set_environment).
    pub fn exchange_environments(&mut self, other: &mut Self) {
        self.prepared += 1;
        other.prepared += 1;
        std::mem::swap(&mut self.environment, &mut other.environment);
    }

    /// Puts the targets of the last frame aside and takes others back, so that pictures of several sizes can be drawn in turn
    /// without making their targets anew.
    pub fn swap_targets(&mut self, kept: &mut KeptTargets) {
        std::mem::swap(&mut self.targets, &mut kept.targets);
        std::mem::swap(&mut self.last, &mut kept.last);
    }

    /// The image that holds the mean of the last frame's samples, for a window to show.
    #[doc(hidden)]
    pub fn image(&self) -> Option<&Image> {
        self.targets.as_ref().map(|targets| &targets.mean)
    }
}
