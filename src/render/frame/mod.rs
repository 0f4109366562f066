//! The renderer: owns the passes and runs them in order.

mod layers;
mod measure;
mod prepare;
mod record;
mod targets;

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use self::targets::Targets;
use super::light::environment::Environment;
use super::light::irradiance::IrradiancePass;
use super::light::sky::Sky;
use super::passes::accumulate::AccumulatePass;
use super::passes::edges::{EdgePass, JoinPass};
use super::passes::filter::FilterPass;
use super::passes::geometry::GeometryPass;
use super::passes::ocean::surface::OceanPass;
use super::passes::reference::ReferencePass;
use super::passes::shade::{LightSet, LightingGpu, ShadePass};
use super::passes::shadow::{ShadowPass, ShadowView};
use super::passes::tiles::TilePass;
use super::scene::{FrameState, Object};
use super::settings::{RenderSettings, Shading};
use super::surfaces::object::{GpuObject, MAX_OBJECTS, ViewBuffers};
use super::surfaces::ocean::Ocean;
use crate::gpu::{Buffer, Gpu, GpuError, Image, Memory, Result, Timestamps};

pub use self::layers::Layer;

/// Texels across the shadow map.
pub const SHADOW_SIZE: u32 = 2048;

/// The time a pass took on the device, summed over the samples of a frame.
#[derive(Clone, Debug, PartialEq)]
pub struct PassTime {
    /// Name of the pass.
    pub pass: String,
    /// Milliseconds.
    pub milliseconds: f64,
}

/// A finished frame.
#[derive(Clone, Debug)]
pub struct FrameOutput {
    /// Pixels across and down.
    pub size: (u32, u32),
    /// Linear radiance, and coverage in alpha; row by row from the top.
    pub color: Vec<[f32; 4]>,
    /// Time per pass.
    pub times: Vec<PassTime>,
    /// Upper bound on the triangles of one sample, all views together.
    pub triangles: u64,
    /// Patches drawn for the camera.
    pub patches: u32,
}

/// One object with its buffers for the camera and for the sun.
struct Drawn {
    object: GpuObject,
    camera: ViewBuffers,
    sun: Option<ViewBuffers>,
}

/// The passes that work pixel by pixel, for one set of settings and lights.
struct PixelPasses {
    filter: FilterPass,
    shade: ShadePass,
    /// Where there are edge samples.
    edges: Option<EdgePasses>,
}

/// What edge samples need besides.
struct EdgePasses {
    shade: ShadePass,
    join: JoinPass,
    /// Of the pixels, after it.
    shade_joined: ShadePass,
}

/// Renders a scene on a device.
pub struct Renderer {
    gpu: Arc<Gpu>,
    drawn: Vec<Drawn>,
    environment: Environment,
    irradiance: IrradiancePass,
    shadow: ShadowPass,
    shadow_view: Option<ShadowView>,
    accumulate: AccumulatePass,
    geometry: GeometryPass,
    ocean: Option<OceanPass>,
    pipelines: HashMap<(Shading, LightSet), PixelPasses>,
    edges: EdgePass,
    tiles: TilePass,
    reference: Option<ReferencePass>,
    targets: Option<Targets>,
    lighting: Buffer,
    timestamps: Timestamps,
    /// Near plane of the last frame's camera.
    near: f32,
    /// How often each pass is recorded: once, but by [`measure`](Self::measure).
    repeats: u32,
}

impl Renderer {
    /// Uploads a scene.
    ///
    /// # Errors
    /// Memory that is short, or a Vulkan call that failed.
    pub fn new(gpu: &Arc<Gpu>, objects: Vec<Object>, environment: Environment) -> Result<Self> {
        if objects.len() > MAX_OBJECTS {
            let fault = format!("{} objects are more than {MAX_OBJECTS}", objects.len());
            return Err(GpuError::Usage { name: "scene".to_owned(), fault });
        }
        let drawn = objects
            .into_iter()
            .enumerate()
            .map(|(index, object)| {
                let object = GpuObject::new(gpu, object, index)?;
                let camera = ViewBuffers::new(gpu, &object, "camera")?;
                let sun = object.object.casts_shadow.then(|| ViewBuffers::new(gpu, &object, "sun")).transpose()?;
                Ok(Drawn { object, camera, sun })
            })
            .collect::<Result<_>>()?;
        Ok(Self {
            drawn,
            environment,
            irradiance: IrradiancePass::new(gpu)?,
            shadow: ShadowPass::new(gpu, SHADOW_SIZE)?,
            shadow_view: None,
            accumulate: AccumulatePass::new(gpu)?,
            geometry: GeometryPass::new(gpu)?,
            ocean: None,
            pipelines: HashMap::new(),
            edges: EdgePass::new(gpu)?,
            tiles: TilePass::new(gpu)?,
            reference: None,
            targets: None,
            lighting: Buffer::new(gpu, "lighting", size_of::<LightingGpu>() as u64, Memory::Upload)?,
            timestamps: Timestamps::new(gpu, 32)?,
            near: 1.0,
            repeats: 1,
            gpu: gpu.clone(),
        })
    }

    /// Adds a sea, or takes it away.
    ///
    /// # Errors
    /// Unusable waves, memory that is short, a failed pipeline.
    pub fn set_ocean(&mut self, ocean: Option<Ocean>) -> Result<()> {
        self.ocean = ocean.map(|ocean| OceanPass::new(&self.gpu, ocean)).transpose()?;
        Ok(())
    }

    /// The device.
    #[must_use]
    pub fn gpu(&self) -> &Arc<Gpu> {
        &self.gpu
    }

    /// The environment's nine spherical harmonics coefficients as the last frame was lit by them, see
    /// `IrradiancePass`: rgb and 0 each.
    ///
    /// # Errors
    /// A lost device, or memory that is short.
    pub fn radiance_sh(&self) -> Result<Vec<[f32; 4]>> {
        self.irradiance.coefficients().read_all()
    }

    /// Brings the environment to a sky before the frame that shows it, so that the frame need not.
    ///
    /// # Errors
    /// A failed submission.
    pub fn show_sky(&mut self, sky: &Sky) -> Result<()> {
        let environment = &mut self.environment;
        self.gpu.submit("sky", |cmd| environment.update_sky(cmd, sky)).map(|_| ())
    }

    /// Renders a frame and reads it back.
    ///
    /// # Errors
    /// Memory that is short, a lost device, a failed pipeline.
    pub fn render(&mut self, state: &FrameState, settings: &RenderSettings) -> Result<FrameOutput> {
        self.render_range(state, settings, 0..settings.samples.max(1))
    }

    /// Renders some of the samples of a frame and gives their mean, so that a long frame can be made in parts and be put
    /// together by an [`Accumulation`](super::passes::accumulate::Accumulation). Samples are the same in whatever part they are.
    ///
    /// # Errors
    /// [`GpuError::Usage`] for a range without samples or beyond `settings.samples`; as [`render`](Self::render).
    pub fn render_range(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        range: Range<u32>,
    ) -> Result<FrameOutput> {
        if range.is_empty() || range.end > settings.samples.max(1) {
            let fault = format!("samples {range:?} are not among the {} of the frame", settings.samples);
            return Err(GpuError::Usage { name: "samples".to_owned(), fault });
        }
        let mut times = Vec::new();
        let posed = self.prepare(state, settings)?;
        for (drawn, index) in (0..).zip(range) {
            add_times(&mut times, self.draw_sample(state, settings, &posed, index, drawn)?);
        }
        let targets = self.targets.as_ref().expect("prepared");
        let color = targets.mean.read(0, 0)?;
        let sea = self.ocean.as_ref().map_or(0, OceanPass::triangles);
        let views = self.drawn.iter().map(|d| d.camera.triangles + d.sun.as_ref().map_or(0, |s| s.triangles));
        Ok(FrameOutput {
            size: settings.size,
            color,
            times,
            triangles: views.sum::<u64>() + sea,
            patches: self.drawn.iter().map(|d| d.camera.patches).sum::<u32>()
                + self.ocean.as_ref().map_or(0, OceanPass::patches),
        })
    }

    /// The image that holds the mean of the samples, for a window to show.
    #[must_use]
    pub fn image(&self) -> Option<&Image> {
        self.targets.as_ref().map(|t| &t.mean)
    }
}

/// Adds the times of further passes to those of passes of the same names.
fn add_times(times: &mut Vec<PassTime>, more: Vec<PassTime>) {
    for PassTime { pass, milliseconds } in more {
        match times.iter_mut().find(|time| time.pass == pass) {
            Some(time) => time.milliseconds += milliseconds,
            None => times.push(PassTime { pass, milliseconds }),
        }
    }
}
