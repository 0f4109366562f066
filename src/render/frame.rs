//! The renderer: owns the passes and runs them in order.

mod measure;

use std::collections::HashMap;
use std::ops::Range;
use std::sync::Arc;

use glam::Vec3;

use super::accumulate::{AccumulatePass, jitter};
use super::environment::Environment;
use super::filter::{FilterPass, GBuffer};
use super::geometry::{GeometryPass, VisibleSurface};
use super::irradiance::IrradiancePass;
use super::object::{GpuObject, MAX_OBJECTS, ViewBuffers};
use super::ocean::surface::{Ocean, OceanPass};
use super::patch_mesh::PosedVertices;
use super::reference::ReferencePass;
use super::scene::{FrameState, Object};
use super::settings::{Quadrature, RenderSettings, ShadingSettings};
use super::shade::{LightSet, LightingGpu, ShadeInputs, ShadePass};
use super::shadow::{ShadowPass, ShadowView};
use super::tessellation::TessellationSettings;
use crate::gpu::{Buffer, Commands, Gpu, GpuError, Image, ImageDesc, Memory, Result, Timestamps};

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

/// What else of the G-buffer can be read back: the last sample's.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Layer {
    /// Distance along the view axis, metres; infinity where nothing is.
    Depth,
    /// World displacement direction.
    Normal,
    /// Mean slope in the frame about it.
    MeanSlope,
    /// Slope covariance `sxx, syy, sxy`.
    Covariance,
    /// Level of detail of the maps.
    Lod,
    /// Linear albedo.
    Albedo,
    /// Beckmann roughness of the base material.
    Roughness,
}

/// Image targets of one size.
struct Targets {
    size: (u32, u32),
    visible: VisibleSurface,
    gbuffer: GBuffer,
    sample: Image,
    mean: Image,
}

impl Targets {
    fn new(gpu: &Arc<Gpu>, size: (u32, u32)) -> Result<Self> {
        let desc = ImageDesc::new(ShadePass::FORMAT, size.0, size.1);
        Ok(Self {
            size,
            visible: VisibleSurface::new(gpu, size)?,
            gbuffer: GBuffer::new(gpu, size)?,
            sample: Image::new(gpu, "sample", desc.color_target())?,
            mean: Image::new(gpu, "mean", desc.storage())?,
        })
    }
}

/// One object with its buffers for the camera and for the sun.
struct Drawn {
    object: GpuObject,
    camera: ViewBuffers,
    sun: Option<ViewBuffers>,
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
    pipelines: HashMap<(ShadingSettings, LightSet), (FilterPass, ShadePass)>,
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

    /// Renders a frame and reads it back.
    ///
    /// # Errors
    /// Memory that is short, a lost device, a failed pipeline.
    pub fn render(&mut self, state: &FrameState, settings: &RenderSettings) -> Result<FrameOutput> {
        self.render_range(state, settings, 0..settings.samples.max(1))
    }

    /// Renders some of the samples of a frame and gives their mean, so that a long frame can be made in parts and be put
    /// together by an [`Accumulation`](super::accumulate::Accumulation). Samples are the same in whatever part they are.
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
        let mut times: Vec<PassTime> = Vec::new();
        let posed = self.prepare(state, settings)?;
        for (count, index) in (0..).zip(range) {
            self.prepare_camera(state, settings, &posed, index)?;
            let gpu = self.gpu.clone();
            gpu.submit("frame", |cmd| {
                let timestamps = self.timestamps.clone();
                cmd.reset_timestamps(&timestamps);
                self.record(cmd, state, settings, count, &timestamps);
            })?;
            for (pass, milliseconds) in self.timestamps.intervals()? {
                match times.iter_mut().find(|t| t.pass == pass) {
                    Some(time) => time.milliseconds += milliseconds,
                    None => times.push(PassTime { pass, milliseconds }),
                }
            }
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

    /// Makes targets and pipelines for these settings, poses the scene, and prepares the sun's view. The device must be
    /// idle.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub fn prepare(&mut self, state: &FrameState, settings: &RenderSettings) -> Result<Vec<PosedVertices>> {
        if self.targets.as_ref().is_none_or(|t| t.size != settings.size) {
            self.targets = None;
            self.targets = Some(Targets::new(&self.gpu, settings.size)?);
        }
        settings.shading.check().map_err(|fault| GpuError::Usage { name: "shading".to_owned(), fault })?;
        if let Some(limit) = self.gpu.loop_iterations_per_invocation() {
            // One walk over the grid for the visible normals, one for the environment, one per light.
            let walks = 2 + u32::from(state.sun.is_some()) + state.point_lights.len() as u32;
            if let Quadrature::Grid(grid) = settings.shading.quadrature
                && grid * grid * walks >= limit
            {
                let fault =
                    format!("{grid} x {grid} samples with {walks} walks exceed this driver's {limit} iterations");
                return Err(GpuError::Usage { name: "slope grid".to_owned(), fault });
            }
        }
        let height_scale = settings.geometry_scale(state.height_scale);
        let posed: Vec<PosedVertices> =
            self.drawn.iter().zip(&state.poses).map(|(d, pose)| pose.apply(&d.object.object.mesh)).collect();
        self.shadow_view = None;
        if settings.shadows_of_relief() {
            self.prepare_reference(state)?;
            self.prepare_pipelines(state, settings)?;
            return Ok(posed);
        }
        if let Some(sun) = state.sun.filter(|_| settings.shadows)
            && let Some((centre, radius)) = self.casters_sphere(&posed, height_scale)
        {
            self.shadow_view = Some(ShadowView::around(sun.direction.normalize(), centre, radius, SHADOW_SIZE));
        }
        self.prepare_pipelines(state, settings)?;
        if let Some(view) = self.shadow_view {
            // Casters are divided as the camera's surface is: a finer one would stand out of it and shade it.
            let lens = state.camera.lens(settings.size.1);
            let casters = TessellationSettings {
                cull: false,
                max_vertices_per_draw: self.vertices_per_draw(),
                ..settings.tessellation
            };
            for (drawn, posed) in self.drawn.iter_mut().zip(&posed) {
                if let Some(buffers) = &mut drawn.sun {
                    let (clip, eye) = (view.clip_from_world, view.eye);
                    buffers.update(&drawn.object, posed, height_scale, clip, eye, lens, &casters)?;
                }
            }
        }
        Ok(posed)
    }

    /// Points the camera's buffers at sample `index` of a prepared frame. The device must be idle.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub fn prepare_camera(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        posed: &[PosedVertices],
        index: u32,
    ) -> Result<()> {
        let offset = jitter(index, settings.samples.max(1), settings.seed);
        let camera = &state.camera;
        let clip_from_world = camera.clip_from_world(settings.size, offset);
        self.near = camera.near;
        let lens = camera.lens(settings.size.1);
        let tessellation =
            TessellationSettings { max_vertices_per_draw: self.vertices_per_draw(), ..settings.tessellation };
        for (drawn, posed) in self.drawn.iter_mut().zip(posed) {
            let (scale, clip) = (settings.geometry_scale(state.height_scale), clip_from_world);
            drawn.camera.update(&drawn.object, posed, scale, clip, camera.position, lens, &tessellation)?;
        }
        if let Some(ocean) = &mut self.ocean {
            let technique = settings.shading.technique;
            ocean.update(&self.gpu, technique, clip_from_world, camera.position, lens, &tessellation)?;
        }
        let cube_size = self.environment.face_size();
        if settings.shadows_of_relief() {
            let bounds = self.casters_sphere(posed, settings.geometry_scale(state.height_scale));
            let most = self.vertices_per_draw();
            let casters: Vec<_> = self.drawn.iter().zip(posed).filter(|(d, _)| d.sun.is_some()).collect();
            let casters: Vec<_> = casters.into_iter().map(|(d, posed)| (&d.object, posed)).collect();
            let reference = self.reference.as_mut().expect("prepared");
            return reference.prepare(state, settings, &casters, bounds, cube_size, index, most);
        }
        let shadow = self.shadow_view.as_ref();
        let block = LightingGpu::new(state, settings.size, offset, cube_size, shadow);
        self.lighting.write(0, &[block])
    }

    /// Records a prepared sample, the `index`-th since the picture was last begun (at 0): LEADR's Figure 3 from top to bottom.
    pub fn record(
        &mut self,
        cmd: &mut Commands,
        state: &FrameState,
        settings: &RenderSettings,
        index: u32,
        timestamps: &Timestamps,
    ) {
        let lights = LightSet::new(state, self.shadow_view.is_some());
        let (Some(targets), Some((filter, shade))) = (&self.targets, self.pipelines.get(&(settings.shading, lights)))
        else {
            return;
        };
        let repeats = self.repeats;
        let height_scale = settings.geometry_scale(state.height_scale);
        let relief = self.reference.as_ref().filter(|_| settings.shadows_of_relief());
        cmd.timestamp(timestamps, "begin");
        if let Some(ocean) = self.ocean.as_ref().filter(|_| index == 0) {
            ocean.record_waves(cmd, state.time, repeats, timestamps);
        }
        if let Some(relief) = relief {
            let casters: Vec<_> = self.drawn.iter().filter(|d| d.sun.is_some()).map(|d| &d.object).collect();
            cmd.label("shadow", |cmd| relief.record_maps(cmd, &casters, height_scale));
            cmd.timestamp(timestamps, "shadow");
        } else if index == 0 {
            if let Some(sky) = &state.sky {
                cmd.label("sky", |cmd| self.environment.update_sky(cmd, sky));
                cmd.timestamp(timestamps, "sky");
            }
            cmd.label_times("irradiance", repeats, |cmd| {
                self.irradiance.record(cmd, &self.environment, 1.0, &[], [0.0; 3])
            });
            cmd.timestamp(timestamps, "irradiance");
            let casters: Vec<_> =
                self.drawn.iter().filter_map(|d| d.sun.as_ref().map(|sun| (&d.object, sun))).collect();
            let casters = if self.shadow_view.is_some() { casters } else { Vec::new() };
            cmd.label_times("shadow", repeats, |cmd| self.shadow.record(cmd, &casters, height_scale));
            cmd.timestamp(timestamps, "shadow");
        }
        let objects: Vec<_> = self.drawn.iter().map(|d| (&d.object, &d.camera)).collect();
        cmd.label_times("geometry", repeats, |cmd| {
            self.geometry.record(cmd, &targets.visible, &objects, height_scale, settings.mark_inside)
        });
        cmd.timestamp(timestamps, "geometry");
        if let Some(ocean) = &self.ocean {
            cmd.label_times("sea geometry", repeats, |cmd| ocean.record_geometry(cmd, &targets.visible));
            cmd.timestamp(timestamps, "sea geometry");
        }
        cmd.label_times("filter", repeats, |cmd| {
            let objects = objects.iter().filter(|(_, view)| !view.draws.is_empty()).map(|(object, _)| *object);
            filter.record(cmd, &targets.visible, &targets.gbuffer, objects, state.height_scale)
        });
        cmd.timestamp(timestamps, "filter");
        if let Some(ocean) = &self.ocean {
            cmd.label_times("sea filter", repeats, |cmd| ocean.record_filter(cmd, &targets.visible, &targets.gbuffer));
            cmd.timestamp(timestamps, "sea filter");
        }
        let inputs = ShadeInputs {
            visible: &targets.visible,
            gbuffer: &targets.gbuffer,
            lighting: &self.lighting,
            cube: self.environment.cube(),
            radiance_sh: self.irradiance.coefficients(),
            shadow_map: &self.shadow.map,
        };
        cmd.label_times("shade", repeats, |cmd| match relief {
            Some(pass) => pass.record(cmd, &targets.visible, &targets.gbuffer, &self.environment, &targets.sample),
            None => shade.record(cmd, inputs, &targets.sample),
        });
        cmd.timestamp(timestamps, "shade");
        cmd.label_times("accumulate", repeats, |cmd| {
            self.accumulate.record(cmd, &targets.sample, &targets.mean, index)
        });
        cmd.timestamp(timestamps, "accumulate");
    }

    /// The image that holds the mean of the samples, for a window to show.
    #[must_use]
    pub fn image(&self) -> Option<&Image> {
        self.targets.as_ref().map(|t| &t.mean)
    }

    /// Reads a layer of the last sample's G-buffer; unused channels are zero.
    ///
    /// # Errors
    /// A lost device, or memory that is short.
    pub fn layer(&self, layer: Layer) -> Result<Vec<[f32; 4]>> {
        let Some(targets) = &self.targets else { return Ok(Vec::new()) };
        let gbuffer = &targets.gbuffer;
        Ok(match layer {
            Layer::Depth => {
                let depth: Vec<f32> = targets.visible.depth.read(0, 0)?;
                let distance = |z: f32| if z > 0.0 { self.near / z } else { f32::INFINITY };
                depth.iter().map(|&z| [distance(z), 0.0, 0.0, 0.0]).collect()
            }
            Layer::Normal => {
                let frame: Vec<[f32; 4]> = gbuffer.frame.read(0, 0)?;
                frame
                    .iter()
                    .map(|f| {
                        let n = crate::reflectance::frame::octahedral_decode(glam::DVec2::new(
                            f64::from(f[0]),
                            f64::from(f[1]),
                        ));
                        n.as_vec3().extend(0.0).to_array()
                    })
                    .collect()
            }
            Layer::MeanSlope => {
                let frame: Vec<[f32; 4]> = gbuffer.frame.read(0, 0)?;
                frame.iter().map(|f| [f[2], f[3], 0.0, 0.0]).collect()
            }
            Layer::Covariance => {
                let covariance: Vec<[f32; 4]> = gbuffer.covariance.read(0, 0)?;
                covariance.iter().map(|c| [c[0], c[1], c[2], 0.0]).collect()
            }
            Layer::Lod => {
                let covariance: Vec<[f32; 4]> = gbuffer.covariance.read(0, 0)?;
                covariance.iter().map(|c| [c[3], 0.0, 0.0, 0.0]).collect()
            }
            Layer::Albedo | Layer::Roughness => {
                let material: Vec<[half::f16; 4]> = gbuffer.material.read(0, 0)?;
                material
                    .iter()
                    .map(|m| {
                        let m = m.map(f32::from);
                        if layer == Layer::Albedo { [m[0], m[1], m[2], 0.0] } else { [m[3], 0.0, 0.0, 0.0] }
                    })
                    .collect()
            }
        })
    }

    /// Makes the pipelines of these settings and of the lights there are.
    fn prepare_pipelines(&mut self, state: &FrameState, settings: &RenderSettings) -> Result<()> {
        let key = (settings.shading, LightSet::new(state, self.shadow_view.is_some()));
        if !self.pipelines.contains_key(&key) {
            let filter = FilterPass::new(&self.gpu, key.0.technique)?;
            let shade = ShadePass::new(&self.gpu, key.0, key.1)?;
            self.pipelines.insert(key, (filter, shade));
        }
        Ok(())
    }

    /// Makes what the shadows of the reference need: its pass, and an environment that can be drawn from.
    fn prepare_reference(&mut self, state: &FrameState) -> Result<()> {
        if let Some(sky) = &state.sky {
            let environment = &mut self.environment;
            self.gpu.submit("sky", |cmd| {
                environment.update_sky(cmd, sky);
            })?;
        }
        let pass = match &mut self.reference {
            Some(pass) => pass,
            none => none.insert(ReferencePass::new(&self.gpu)?),
        };
        pass.read_environment(&self.environment)
    }

    /// A sphere around everything that throws shadows.
    fn casters_sphere(&self, posed: &[PosedVertices], height_scale: f32) -> Option<(Vec3, f32)> {
        let casters = self.drawn.iter().zip(posed).filter(|(d, _)| d.sun.is_some());
        let spheres: Vec<(Vec3, f32)> = casters.map(|(d, posed)| d.object.bounds(posed, height_scale)).collect();
        enclosing_sphere(&spheres)
    }

    fn vertices_per_draw(&self) -> u32 {
        self.gpu.tessellated_vertices_per_draw().unwrap_or(u32::MAX)
    }
}

/// A sphere around spheres: about the middle of their box.
fn enclosing_sphere(spheres: &[(Vec3, f32)]) -> Option<(Vec3, f32)> {
    let (low, high) =
        spheres.iter().map(|&(c, r)| (c - r, c + r)).reduce(|(low, high), (l, h)| (low.min(l), high.max(h)))?;
    let centre = (low + high) * 0.5;
    let radius = spheres.iter().map(|&(c, r)| c.distance(centre) + r).fold(0.0, f32::max);
    Some((centre, radius.max(1e-6)))
}
