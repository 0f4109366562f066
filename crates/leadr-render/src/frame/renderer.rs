//! The renderer, which holds a scene on a device and the passes that draw it.

use std::sync::Arc;

use super::drawing::{Purpose, drawing, shade_kind};
use super::pipelines::Pipelines;
use super::pool::Pool;
use super::scene_set::SceneTables;
use super::sky::SkyCache;
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
use crate::surfaces::classes::SceneClasses;
use crate::surfaces::fits::Fits;
use crate::surfaces::half_range::fill_half_range;
use crate::surfaces::media::Media;
use crate::surfaces::moments::MomentFormat;
use crate::surfaces::numbering::Numbering;
use crate::surfaces::object::Upload;
use crate::surfaces::placeholders::Placeholders;
use leadr_gpu::{Buffer, Gpu, Image, Result};
use rayon::prelude::*;

/// Renders a scene on a device.
pub struct Renderer {
    pub(super) gpu: Arc<Gpu>,
    pub(super) surfaces: Surfaces,
    /// The kinds of surfaces that cast shadows in the scene.
    pub(super) casters: CasterKinds,
    pub(super) environment: Environment,
    pub(super) irradiance: IrradiancePass,
    pub(super) tables: SceneTables,
    pub(super) sky: SkyCache,
    pub(super) common: CommonPasses,
    pub(super) pipelines: Pipelines,
    /// The buffers of [`LightingGpu`](crate::passes::shade::LightingGpu) blocks.
    pub(super) lighting: Pool<Buffer>,
    /// The buffers of [lamps](crate::passes::lamps).
    pub(super) lamps: Pool<Buffer>,
    pub(super) timer: PassTimer,
    /// The render targets, which frames of the same size share.
    pub(super) targets: Option<Targets>,
    pub(super) last: Option<LastSample>,
    pub(super) numbering: Numbering,
    pub(super) prepared: u64,
}

/// Render targets that are kept while a renderer uses other targets.
#[derive(Default)]
pub struct KeptTargets {
    targets: Option<Targets>,
    last: Option<LastSample>,
}

/// The sample that the render targets contain.
#[derive(Clone)]
pub(super) struct LastSample {
    pub state: FrameState,
    pub settings: RenderSettings,
    pub index: u32,
    /// Whether the G-buffer contains the sample.
    pub in_gbuffer: bool,
}

impl Renderer {
    /// Uploads a scene, which consists of objects, a sea, or both.
    ///
    /// # Errors
    /// Returns an error for more than `MAX_OBJECTS` objects, too many patches in an object, or invalid waves, if memory is short,
    /// or if a Vulkan call fails.
    pub fn new(gpu: &Arc<Gpu>, scene: impl Into<Scene>, environment: Environment) -> Result<Self> {
        Self::with(gpu, scene.into(), environment, None)
    }

    /// Uploads a scene and, at the same time, makes the pipelines for frames with this `state` and `settings`. Drivers take up to
    /// half a second to make these pipelines. All CPU threads share the work. The first frame makes any pipelines that are still
    /// missing.
    pub fn for_frames_like(
        gpu: &Arc<Gpu>,
        scene: impl Into<Scene>,
        environment: Environment,
        state: &FrameState,
        settings: &RenderSettings,
    ) -> Result<Self> {
        Self::with(gpu, scene.into(), environment, Some((state, settings)))
    }

    /// Uploads a scene. Also makes the pipelines for the frame `first`, if given.
    fn with(
        gpu: &Arc<Gpu>,
        Scene { mut objects, ocean, cache, map_precision }: Scene,
        environment: Environment,
        first: Option<(&FrameState, &RenderSettings)>,
    ) -> Result<Self> {
        if map_precision == MomentFormat::Float16 {
            objects.par_iter_mut().for_each(fill_half_range);
        }
        let numbering = Numbering::of(&objects)?;
        let mut pipelines = MeshPipelines::of(gpu, &objects, numbering);
        let shades_classes = first.is_some_and(|(_, settings)| settings.shading.has_classes());
        let height_scale = first.map_or(1.0, |(state, _)| state.height_scale);
        let classes = SceneClasses::of(&mut objects, cache.as_ref(), height_scale, shades_classes);
        if let SceneClasses::Found(found) = &classes {
            pipelines.add_classes(found);
        }
        let casters = pipelines.casters();
        let first = first.map(|(state, settings)| {
            let kind = shade_kind(state, settings, &environment, pipelines.demands(state, settings));
            (state, drawing(*settings, kind, Purpose::Picture))
        });
        let (fits, media) = (Fits::of(&objects)?, Media::of(&objects)?);
        let none = Placeholders::new(gpu)?;
        let upload = Upload { cache: cache.as_ref(), format: map_precision, fits: &fits, media: &media, none: &none };
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
            Ok((
                IrradiancePass::new(gpu)?,
                SceneTables::new(gpu, &fits, &media)?,
                CommonPasses::new(gpu, casters, numbering)?,
            ))
        };
        // Meshes are many small tasks, so they come last and fill the threads' idle time.
        let ((sea, passes), meshes) = rayon::join(
            || rayon::join(|| ocean.map(sea).transpose(), passes),
            || Meshes::new(pipelines, objects, classes, upload, of_meshes),
        );
        let (irradiance, tables, common) = passes?;
        Ok(Self {
            surfaces: Surfaces { meshes: meshes?, sea: sea? },
            casters,
            environment,
            irradiance,
            tables,
            sky: SkyCache::default(),
            common,
            pipelines: Pipelines::default(),
            lighting: Pool::default(),
            lamps: Pool::default(),
            timer: PassTimer::new(gpu)?,
            targets: None,
            last: None,
            prepared: 0,
            numbering,
            gpu: gpu.clone(),
        })
    }

    /// Whether the scene moves with time even in fixed poses, as a sea does.
    #[doc(hidden)]
    pub fn moves(&self) -> bool {
        self.surfaces.sea.is_some()
    }

    /// Returns the device.
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// Returns the environment's nine spherical harmonics coefficients in the last frame, each as rgb and 0. See `IrradiancePass`.
    #[doc(hidden)]
    pub fn radiance_sh(&self) -> Result<Vec<[f32; 4]>> {
        self.irradiance.coefficients().read(0, 9)
    }

    /// Updates the environment to a sky. Call it before the frame that shows this sky.
    pub fn show_sky(&mut self, sky: &Sky) -> Result<()> {
        let environment = &mut self.environment;
        let drawn = self.gpu.submit("sky", |cmd| environment.update_sky(cmd, sky)).map(|_| ());
        drawn.inspect_err(|_| environment.invalidate_sky())
    }

    /// Returns the environment.
    pub fn environment(&self) -> &Environment {
        &self.environment
    }

    /// Replaces the environment and returns the old one. Later frames use the new environment. Paused frames cannot be resumed.
    pub fn set_environment(&mut self, environment: Environment) -> Environment {
        self.prepared += 1;
        std::mem::replace(&mut self.environment, environment)
    }

    /// Exchanges the environments of two renderers. See [`set_environment`](Self::set_environment).
    pub fn swap_environments(&mut self, other: &mut Self) {
        self.prepared += 1;
        other.prepared += 1;
        std::mem::swap(&mut self.environment, &mut other.environment);
    }

    /// Exchanges the targets of the last frame with `kept`. Frames of several sizes can then alternate without new targets.
    pub fn swap_targets(&mut self, kept: &mut KeptTargets) {
        std::mem::swap(&mut self.targets, &mut kept.targets);
        std::mem::swap(&mut self.last, &mut kept.last);
    }

    /// Returns the image with the mean of the last frame's samples, for display in a window.
    #[doc(hidden)]
    pub fn image(&self) -> Option<&Image> {
        self.targets.as_ref().map(|targets| &targets.mean)
    }
}
