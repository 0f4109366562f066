//! Prepares a frame before its first sample: poses, targets, light views and pipelines.

use super::drawing::{Purpose, drawing, shade_kind};
use super::edge_samples::EdgeSamples;
use super::prepared::{FrameLamps, FramePath, FramePlan, MappedLight, Multisample, PreparedFrame};
use super::renderer::Renderer;
use super::scene_set::FrameLight;
use super::surfaces::{PreparedSurfaces, SurfaceDrawing};
use super::targets::{EdgeTargets, TargetShape, Targets};
use crate::constants::MAX_LAMP_MAPS;
use crate::passes::accumulate::{AccumulatePass, PartsKind};
use crate::passes::edges::{JoinKind, JoinPass, MAX_GRID, edge_grid};
use crate::passes::filter::FilterInto;
use crate::passes::lamps::{self, Lamp, lamps_of};
use crate::passes::msaa::MsaaPass;
use crate::passes::reference::{ReferenceKind, ReferencePass, ReliefLights};
use crate::passes::shade::{Edges, LightingGpu, ShadeKind, ShadePass, SkyBehindPass, suns_of};
use crate::passes::shadow::{ShadowView, map_size};
use crate::passes::targets::MultisampleTargets;
use crate::scene::FrameState;
use crate::settings::{Quadrature, RenderSettings};
use crate::surfaces::material::Bases;
use crate::surfaces::posed::PosedObject;
use crate::surfaces::sphere::Sphere;
use crate::surfaces::tessellation::TessellationSettings;
use leadr_gpu::{Buffer, GpuError, Memory, Result};
use leadr_reflectance::masking::classes::MOST_CLASSES;

impl Renderer {
    /// Poses the scene and makes everything that is needed to draw a frame. The device may still be drawing the last frame, and
    /// this call may already overwrite images of that frame.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] for invalid or unsupported settings. Also returns an error if memory is short, the device is
    /// lost, or a pipeline fails.
    pub fn prepare(&mut self, state: &FrameState, settings: &RenderSettings) -> Result<PreparedFrame<'_>> {
        self.prepare_for(state, settings, Purpose::Picture)
    }

    /// Like [`prepare`](Self::prepare), but for any purpose.
    pub(super) fn prepare_for(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        purpose: Purpose,
    ) -> Result<PreparedFrame<'_>> {
        settings.check().map_err(|fault| GpuError::Usage { name: "settings".to_owned(), fault })?;
        let count = lamps::check(state).map_err(|fault| GpuError::Usage { name: "lights".to_owned(), fault })?;
        self.check_loops(state, settings, count)?;
        if settings.shading.has_classes() {
            self.surfaces.meshes.find_classes()?;
        }
        self.prepared += 1;
        let max_vertices_per_draw = self.gpu.tessellated_vertices_per_draw().unwrap_or(u32::MAX);
        let tessellation = TessellationSettings { max_vertices_per_draw, ..settings.tessellation };
        let settings = RenderSettings { tessellation, ..*settings };
        let light_visibility = purpose == Purpose::Light;
        let kind = ShadeKind {
            light_visibility,
            ..shade_kind(state, &settings, &self.environment, self.surfaces.meshes.demands(state, &settings))
        };
        let (settings, drawing) = drawing(settings, kind, purpose);
        let filter = drawing.filter;
        // The G-buffer holds one class of facets.
        let kind = match filter {
            FilterInto::Radiance(kind) => kind,
            FilterInto::GBuffer => ShadeKind { bases: Bases { classes: 1, ..kind.bases }, ..kind },
        };
        let mut surfaces = self.surfaces.prepare(state, &settings, drawing)?;
        let targets = self.targets_for(&surfaces, &settings, drawing)?;
        let spheres: Vec<Sphere> = surfaces.meshes.casters().into_iter().map(PosedObject::bounds).collect();
        let casters = Sphere::enclosing(&spheres);
        let block = || Buffer::new(&self.gpu, "lamps", lamps::BUFFER_SIZE, Memory::Upload);
        let lamps = FrameLamps { list: lamps_of(state, casters), buffer: self.lamps.take(block)? };
        let light = (&lamps.list[..], casters);
        let path = self.prepare_path(state, &settings, light, (kind, filter), &mut surfaces, &targets)?;
        let parts = match (path.edges(), path.multisample()) {
            (Some(_), _) => PartsKind::Edges,
            (None, Some(_)) => PartsKind::Multisampled(settings.msaa),
            (None, None) => PartsKind::One,
        };
        let accumulate = self.pipelines.accumulate.get(parts, || AccumulatePass::new(&self.gpu, parts))?;
        let block = || Buffer::new(&self.gpu, "lighting", size_of::<LightingGpu>() as u64, Memory::Upload);
        let lighting = self.lighting.take(block)?;
        let shadow_maps = self.common.shadow.maps(&self.gpu, map_size(settings.size), path.shadows().len() as u32)?;
        let shades_sky = path.lit().is_some() && kind.shading.options().sky_occlusion;
        let sky = if shades_sky { self.sky.around(&self.gpu, &surfaces.meshes.casters())? } else { None };
        let frame_light = FrameLight {
            lighting: &lighting,
            lamps: &lamps.buffer,
            shadow_maps: shadow_maps.array(),
            sky: sky.as_ref(),
        };
        let scene = self.tables.set(&self.gpu, &self.environment, &self.irradiance, &frame_light)?;
        let (state, number) = (state.clone(), self.prepared);
        let plan = FramePlan {
            state,
            settings,
            surfaces,
            targets,
            path,
            shadow_maps,
            lighting,
            lamps,
            scene,
            accumulate,
            drawn: 0,
            number,
        };
        Ok(PreparedFrame { renderer: self, plan })
    }

    /// Checks that the device can run enough loop iterations for a slope grid.
    fn check_loops(&self, state: &FrameState, settings: &RenderSettings, lamps: usize) -> Result<()> {
        let Some(limit) = self.gpu.loop_iterations_per_invocation() else { return Ok(()) };
        // The grid is traversed once for the visible normals, once for the environment, and once per light.
        let suns = suns_of(state, &self.environment).count();
        // Every class of facets has its own loop over the lamps without shadow maps.
        let mapped = lamps.min(MAX_LAMP_MAPS as usize);
        let walks = 2 + (suns + mapped + MOST_CLASSES * (lamps - mapped)) as u32;
        match settings.shading.quadrature() {
            Some(Quadrature::Grid(grid)) if grid * grid * walks >= limit => {
                let fault = format!(
                    "{walks} loops over {grid} x {grid} slopes exceed this driver's {limit} iterations: use a smaller grid or fewer lights"
                );
                Err(GpuError::Usage { name: "slope grid".to_owned(), fault })
            }
            _ => Ok(()),
        }
    }

    /// Returns the last frame's targets if they fit, or new targets.
    fn targets_for(
        &mut self,
        surfaces: &PreparedSurfaces,
        settings: &RenderSettings,
        drawing: SurfaceDrawing,
    ) -> Result<Targets> {
        // The geometry stages of the sea do not support a grid.
        let finest = if surfaces.sea.is_some() { 1 } else { MAX_GRID };
        let grid = settings.edges().map(|samples| edge_grid(samples, settings.size, finest));
        let shape = TargetShape {
            size: settings.size,
            grid,
            msaa: settings.msaa,
            gbuffer: drawing.filter == FilterInto::GBuffer,
            sun_maps: drawing.sun_maps,
        };
        if let Some(kept) = &self.targets
            && kept.fits(shape)
        {
            return Ok(kept.clone());
        }
        // Unsuitable targets are dropped first, because memory may not hold both old and new ones.
        self.gpu.wait_idle()?;
        let mean = self.targets.take().map(|targets| targets.mean);
        self.last = None;
        Ok(self.targets.insert(Targets::new(&self.gpu, shape, mean)?).clone())
    }

    /// Chooses the passes of a frame. Also sets up the shadow views of the casters or, for the reference, its lights.
    fn prepare_path(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        (lamps, casters): (&[Lamp], Option<Sphere>),
        (kind, filter): (ShadeKind, FilterInto),
        surfaces: &mut PreparedSurfaces,
        targets: &Targets,
    ) -> Result<FramePath> {
        if settings.shadows_of_relief() {
            return self.prepare_reference(state, settings, kind.bases, surfaces);
        }
        let lit = self.prepare_light(state, settings, lamps, casters, surfaces)?;
        let (gpu, numbering) = (&self.gpu, self.numbering);
        match filter {
            FilterInto::Radiance(_) => {
                let of = |targets: MultisampleTargets| {
                    let count = targets.count;
                    let pass = self.pipelines.multisample.get(count, || MsaaPass::new(gpu, count, numbering))?;
                    Ok(Multisample { pass, targets })
                };
                Ok(FramePath::Fused { lit, multisample: targets.multisample.clone().map(of).transpose()? })
            }
            FilterInto::GBuffer => {
                let shade = self.pipelines.shade.get(kind, || ShadePass::new(gpu, kind))?;
                let edges = match (settings.edges(), targets.edges.clone()) {
                    (Some(samples), Some(targets)) => {
                        Some(Box::new(self.prepare_edges(state, settings, kind, surfaces, samples, targets)?))
                    }
                    _ => None,
                };
                Ok(FramePath::Deferred { lit, shade, edges })
            }
        }
    }

    fn prepare_reference(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        bases: Bases,
        surfaces: &PreparedSurfaces,
    ) -> Result<FramePath> {
        if let Some(sky) = &state.sky {
            self.show_sky(sky)?;
        }
        let lights = ReliefLights::new(&self.gpu, state, &self.environment, &surfaces.meshes.casters())?;
        let kind = ReferenceKind {
            terms: settings.shading.terms(),
            facet_frame: settings.shading.facet_frame(),
            fresnel: settings.shading.options().fresnel,
            bases,
            casters: self.casters,
            displaced: settings.displacement,
            height_field: lights.is_height_field(),
            drawn: lights.are_drawn(),
        };
        let pass = self.pipelines.reference.get(kind, || ReferencePass::new(&self.gpu, kind))?;
        Ok(FramePath::Reference { pass, lights: Box::new(lights) })
    }

    /// Sets up the shadow views of the casters.
    fn prepare_light(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        lamps: &[Lamp],
        casters: Option<Sphere>,
        surfaces: &mut PreparedSurfaces,
    ) -> Result<MappedLight> {
        let size = map_size(settings.size);
        let shadows: Vec<ShadowView> = match casters.filter(|_| settings.shadows) {
            Some(sphere) => {
                let suns = suns_of(state, &self.environment).map(|sun| ShadowView::around(sun.direction, sphere, size));
                let mapped = lamps.iter().take(MAX_LAMP_MAPS as usize);
                suns.chain(mapped.map(|lamp| lamp.shadow_view(sphere, size))).collect()
            }
            None => Vec::new(),
        };
        let lens = state.camera.lens(settings.size.1);
        if !shadows.is_empty() {
            surfaces.meshes.cast(&shadows, lens)?;
        }
        let multisampled = settings.msaa > 1;
        let behind = self.pipelines.sky.get(multisampled, || SkyBehindPass::new(&self.gpu, multisampled))?;
        Ok(MappedLight { shadows, behind })
    }

    /// Finds the area that needs edge samples, and makes the passes of the edge samples for `targets`.
    fn prepare_edges(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        kind: ShadeKind,
        surfaces: &PreparedSurfaces,
        samples: u32,
        targets: EdgeTargets,
    ) -> Result<EdgeSamples> {
        let join = JoinKind { needs: settings.shading.needs(), shadow_maps: kind.lights.sun_maps() };
        let shaded = ShadeKind { edges: Edges::Shaded, ..kind };
        Ok(EdgeSamples {
            samples,
            area: surfaces.area(&state.camera, settings.size),
            targets,
            shade: self.pipelines.shade.get(shaded, || ShadePass::new(&self.gpu, shaded))?,
            join: self.pipelines.join.get(join, || JoinPass::new(&self.gpu, join))?,
        })
    }
}
