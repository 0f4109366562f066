//! What is made and written before the first sample of a frame: poses, targets, the lights' views, pipelines.

use super::drawing::{Demands, Purpose, drawing, shade_kind};
use super::edge_samples::{EdgeSamples, area_of};
use super::prepared::{FramePlan, Light, PreparedFrame};
use super::renderer::Renderer;
use super::scene_set::FrameLight;
use super::surfaces::{PreparedSurface, Surface, SurfaceDrawing};
use super::targets::{EdgeTargets, TargetShape, Targets};
use crate::passes::accumulate::PartsKind;
use crate::passes::edges::{JoinKind, edge_grid};
use crate::passes::filter::FilterInto;
use crate::passes::reference::{ReferenceKind, ReliefLights};
use crate::passes::shade::{Edges, LightingGpu, ShadeKind, suns_of};
use crate::passes::shadow::{ShadowView, map_size};
use crate::scene::{FrameState, MAX_POINT_LIGHTS};
use crate::settings::{Quadrature, RenderSettings};
use crate::surfaces::material::Bases;
use crate::surfaces::posed::PosedObject;
use crate::surfaces::sphere::Sphere;
use crate::surfaces::tessellation::TessellationSettings;
use leadr_gpu::{Buffer, GpuError, Memory, Result};

impl Renderer {
    /// Poses the scene and makes everything a frame is drawn with. It may draw into the images of the last frame; the device may
    /// still be drawing that.
    ///
    /// # Errors
    /// [`GpuError::Usage`] for settings that make no picture or that the device cannot draw; memory that is short, a lost
    /// device, a failed pipeline.
    pub fn prepare(&mut self, state: &FrameState, settings: &RenderSettings) -> Result<PreparedFrame<'_>> {
        self.prepare_for(state, settings, Purpose::Picture)
    }

    /// The same for any purpose.
    pub(super) fn prepare_for(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        purpose: Purpose,
    ) -> Result<PreparedFrame<'_>> {
        settings.check().map_err(|fault| GpuError::Usage { name: "settings".to_owned(), fault })?;
        self.check_loops(state, settings)?;
        self.prepared += 1;
        let max_vertices_per_draw = self.gpu.tessellated_vertices_per_draw().unwrap_or(u32::MAX);
        let tessellation = TessellationSettings { max_vertices_per_draw, ..settings.tessellation };
        let settings = RenderSettings { tessellation, ..*settings };
        let demands = Demands {
            relief: self.surfaces.iter().any(|surface| surface.has_relief(state)),
            casters: !self.casters.is_empty(),
            bases: self.surfaces.iter().fold(Bases::default(), |all, surface| all.and(surface.bases())),
            relief_color: self.surfaces.iter().any(|surface| surface.has_relief_color()),
        };
        let tells_light = purpose == Purpose::Light;
        let kind = ShadeKind { tells_light, ..shade_kind(state, &settings, &self.environment, demands) };
        let (settings, drawing) = drawing(settings, kind, purpose);
        let filter = drawing.filter;
        let prepare = |surface: &mut Box<dyn Surface>| surface.prepare(state, &settings, drawing);
        let mut surfaces = self.surfaces.iter_mut().map(prepare).collect::<Result<Vec<_>>>()?;
        let targets = self.targets_for(&surfaces, &settings, drawing)?;
        let light = self.prepare_light(state, &settings, kind, filter, &mut surfaces)?;
        let edges = match (settings.edges(), targets.edges.clone()) {
            (Some(samples), Some(targets)) => {
                Some(self.prepare_edges(state, &settings, kind, &surfaces, samples, targets)?)
            }
            _ => None,
        };
        let multisample = match &targets.multisample {
            Some(targets) => Some(self.pipelines.multisample(&self.gpu, targets.count, self.numbering)?),
            None => None,
        };
        let parts = match (&edges, &multisample) {
            (Some(_), _) => PartsKind::Edges,
            (None, Some(_)) => PartsKind::Multisampled(settings.msaa),
            (None, None) => PartsKind::One,
        };
        let accumulate = self.pipelines.accumulate(&self.gpu, parts)?;
        let block = || Buffer::new(&self.gpu, "lighting", size_of::<LightingGpu>() as u64, Memory::Upload);
        let lighting = self.lighting.take(block)?;
        let shadow_maps = self.common.shadow.maps(&self.gpu, map_size(settings.size), light.shadows().len() as u32)?;
        let sky = match light {
            Light::Mapped { .. } if kind.shading.options().sky_occlusion => {
                self.sky.around(&self.gpu, &casters(&surfaces))?
            }
            _ => None,
        };
        let frame_light = FrameLight { lighting: &lighting, shadow_maps: shadow_maps.array(), sky: sky.as_ref() };
        let scene = self.tables.set(&self.gpu, &self.environment, &self.irradiance, &frame_light)?;
        let (state, number) = (state.clone(), self.prepared);
        let plan = FramePlan {
            state,
            settings,
            surfaces,
            targets,
            light,
            shadow_maps,
            lighting,
            scene,
            multisample,
            edges,
            accumulate,
            drawn: 0,
            number,
        };
        Ok(PreparedFrame { renderer: self, plan })
    }

    /// Whether the device can run the loops of a slope grid.
    fn check_loops(&self, state: &FrameState, settings: &RenderSettings) -> Result<()> {
        let Some(limit) = self.gpu.loop_iterations_per_invocation() else { return Ok(()) };
        // One walk over the grid for the visible normals, one for the environment, one per light.
        let suns = suns_of(state, &self.environment).count();
        let walks = 2 + (suns + state.point_lights.len()) as u32;
        match settings.shading.quadrature() {
            Some(Quadrature::Grid(grid)) if grid * grid * walks >= limit => {
                let fault =
                    format!("{grid} x {grid} samples with {walks} walks exceed this driver's {limit} iterations");
                Err(GpuError::Usage { name: "slope grid".to_owned(), fault })
            }
            _ => Ok(()),
        }
    }

    /// The targets of the last frame if they suit, or new ones.
    fn targets_for(
        &mut self,
        surfaces: &[Box<dyn PreparedSurface>],
        settings: &RenderSettings,
        drawing: SurfaceDrawing,
    ) -> Result<Targets> {
        let finest = surfaces.iter().map(|surface| surface.finest_grid()).min().unwrap_or(1);
        let grid = settings.edges().map(|samples| edge_grid(samples, settings.size, finest));
        let shape = TargetShape {
            size: settings.size,
            grid,
            msaa: settings.msaa,
            gbuffer: drawing.filter == FilterInto::GBuffer,
            sun_maps: drawing.sun_maps,
        };
        if let Some(kept) = &self.targets
            && kept.suit(shape)
        {
            return Ok(kept.clone());
        }
        // Unsuitable targets are dropped first: there may be no room for both.
        self.gpu.wait_idle()?;
        let mean = self.targets.take().map(|targets| targets.mean);
        self.last = None;
        Ok(self.targets.insert(Targets::new(&self.gpu, shape, mean)?).clone())
    }

    /// Points the shadow maps at the casters, or makes the lights of the reference.
    fn prepare_light(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        kind: ShadeKind,
        filter: FilterInto,
        surfaces: &mut [Box<dyn PreparedSurface>],
    ) -> Result<Light> {
        if settings.shadows_of_relief() {
            if let Some(sky) = &state.sky {
                self.show_sky(sky)?;
            }
            let lights = ReliefLights::new(&self.gpu, state, &self.environment, &casters(surfaces))?;
            let kind = ReferenceKind {
                terms: settings.shading.terms(),
                facet_frame: settings.shading.facet_frame(),
                bases: kind.bases,
                casters: self.casters,
                displaced: settings.displacement,
                height_field: lights.is_height_field(),
                drawn: lights.are_drawn(),
            };
            let pass = self.pipelines.reference(&self.gpu, kind)?;
            return Ok(Light::Relief { pass, lights: Box::new(lights) });
        }
        let spheres: Vec<Sphere> = casters(surfaces).into_iter().map(PosedObject::bounds).collect();
        let size = map_size(settings.size);
        let shadows: Vec<ShadowView> = match Sphere::enclosing(&spheres).filter(|_| settings.shadows) {
            Some(sphere) => {
                let suns = suns_of(state, &self.environment).map(|sun| ShadowView::around(sun.direction, sphere, size));
                let points = state.point_lights.iter().take(MAX_POINT_LIGHTS);
                suns.chain(points.map(|point| ShadowView::from_point(point.position, sphere, size))).collect()
            }
            None => Vec::new(),
        };
        let lens = state.camera.lens(settings.size.1);
        for surface in surfaces.iter_mut().filter(|_| !shadows.is_empty()) {
            surface.cast(&shadows, lens)?;
        }
        let shade = match filter {
            FilterInto::GBuffer => Some(self.pipelines.shade(&self.gpu, kind)?),
            FilterInto::Radiance(_) => None,
        };
        let behind = self.pipelines.sky(&self.gpu, settings.msaa > 1)?;
        Ok(Light::Mapped { shadows, shade, behind })
    }

    /// Finds where edge samples are needed and makes what draws them into `targets`.
    fn prepare_edges(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        kind: ShadeKind,
        surfaces: &[Box<dyn PreparedSurface>],
        samples: u32,
        targets: EdgeTargets,
    ) -> Result<EdgeSamples> {
        let join = JoinKind { needs: settings.shading.needs(), shadow_maps: kind.lights.sun_maps() };
        let extents = surfaces.iter().map(|surface| surface.extent()).collect();
        Ok(EdgeSamples {
            samples,
            area: area_of(extents, &state.camera, settings.size),
            targets,
            shade: self.pipelines.shade(&self.gpu, ShadeKind { edges: Edges::Shaded, ..kind })?,
            join: self.pipelines.join(&self.gpu, join)?,
        })
    }
}

/// What throws shadows.
pub(super) fn casters(surfaces: &[Box<dyn PreparedSurface>]) -> Vec<&PosedObject> {
    surfaces.iter().flat_map(|surface| surface.casters()).collect()
}
