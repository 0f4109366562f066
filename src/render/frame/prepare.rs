//! What is made and written before a sample is drawn: targets, pipelines, poses, views.

use std::collections::hash_map::Entry;

use glam::Vec3;

use super::record::SubFrame;
use super::targets::Targets;
use super::{EdgePasses, PixelPasses, Renderer, SHADOW_SIZE};
use crate::gpu::{GpuError, Result};
use crate::render::passes::edges::{JoinPass, MAX_GRID, edge_grid, edge_tessellation};
use crate::render::passes::filter::FilterPass;
use crate::render::passes::reference::ReferencePass;
use crate::render::passes::shade::{Edges, LightSet, LightingGpu, ShadePass};
use crate::render::passes::shadow::ShadowView;
use crate::render::scene::FrameState;
use crate::render::settings::{Quadrature, RenderSettings, Terms};
use crate::render::surfaces::patch_mesh::PosedVertices;
use crate::render::surfaces::tessellation::TessellationSettings;

impl Renderer {
    /// Makes targets and pipelines for these settings, poses the scene, and prepares the sun's view. The device must be
    /// idle.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub fn prepare(&mut self, state: &FrameState, settings: &RenderSettings) -> Result<Vec<PosedVertices>> {
        settings.check().map_err(|fault| GpuError::Usage { name: "settings".to_owned(), fault })?;
        // The sea's geometry stage knows no grid.
        let finest = if self.ocean.is_some() { 1 } else { MAX_GRID };
        let grid = settings.edges().map(|samples| edge_grid(samples, settings.size, finest));
        if self.targets.as_ref().is_none_or(|targets| !targets.suit(settings.size, grid)) {
            self.targets = None;
            self.targets = Some(Targets::new(&self.gpu, settings.size, grid)?);
        }
        if let Some(limit) = self.gpu.loop_iterations_per_invocation() {
            // One walk over the grid for the visible normals, one for the environment, one per light.
            let walks = 2 + u32::from(state.sun.is_some()) + state.point_lights.len() as u32;
            if let Some(Quadrature::Grid(grid)) = settings.shading.integral().map(|integral| integral.quadrature)
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
            self.prepare_reference(state, settings.shading.terms())?;
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
                    buffers.update(&drawn.object, posed, height_scale, clip, eye, lens, &casters, 1)?;
                }
            }
        }
        Ok(posed)
    }

    /// Points the camera's buffers at a sub-frame of a prepared frame. The device must be idle.
    pub(super) fn prepare_camera(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        posed: &[PosedVertices],
        sub: &SubFrame,
    ) -> Result<()> {
        let (size, offset) = sub.image(settings);
        let camera = &state.camera;
        let clip_from_world = camera.clip_from_world(size, offset);
        self.near = camera.near;
        let lens = camera.lens(settings.size.1);
        let tessellation =
            TessellationSettings { max_vertices_per_draw: self.vertices_per_draw(), ..settings.tessellation };
        let scale = settings.geometry_scale(state.height_scale);
        for (drawn, posed) in self.drawn.iter_mut().zip(posed) {
            // Outlines are of bumps, which the geometry of whole pixels leaves out where they are small.
            let tessellation = match sub.edges() {
                true => edge_tessellation(tessellation, drawn.object.bounds(posed, scale), &lens),
                false => tessellation,
            };
            drawn.camera.update(
                &drawn.object,
                posed,
                scale,
                clip_from_world,
                camera.position,
                lens,
                &tessellation,
                sub.grid,
            )?;
        }
        if let Some(ocean) = &mut self.ocean {
            let needs = settings.shading.needs();
            ocean.update(&self.gpu, needs, state.time, clip_from_world, camera.position, lens, &tessellation)?;
        }
        if settings.shadows_of_relief() {
            let cube_size = self.environment.face_size();
            let bounds = self.casters_sphere(posed, settings.geometry_scale(state.height_scale));
            let most = self.vertices_per_draw();
            let casters: Vec<_> = self.drawn.iter().zip(posed).filter(|(d, _)| d.sun.is_some()).collect();
            let casters: Vec<_> = casters.into_iter().map(|(d, posed)| (&d.object, posed)).collect();
            let reference = self.reference.as_mut().expect("prepared");
            return reference.prepare(state, settings, &casters, bounds, cube_size, sub.index, most);
        }
        self.prepare_lighting(state, settings, sub)
    }

    /// Writes the light and the rays of a sub-frame. The device must be idle.
    pub(super) fn prepare_lighting(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        sub: &SubFrame,
    ) -> Result<()> {
        let (size, offset) = sub.image(settings);
        let cube_size = self.environment.face_size();
        let block = LightingGpu::new(state, size, sub.grid, offset, cube_size, self.shadow_view.as_ref());
        self.lighting.write(0, &[if self.ocean.is_some() { block.with_sea_horizon() } else { block }])
    }

    /// Makes the pipelines of these settings and of the lights there are.
    fn prepare_pipelines(&mut self, state: &FrameState, settings: &RenderSettings) -> Result<()> {
        let (shading, lights) = (settings.shading.plain(), LightSet::new(state, self.shadow_view.is_some()));
        let passes = match self.pipelines.entry((shading, lights)) {
            Entry::Occupied(entry) => entry.into_mut(),
            Entry::Vacant(entry) => entry.insert(PixelPasses {
                filter: FilterPass::new(&self.gpu, shading.needs())?,
                shade: ShadePass::new(&self.gpu, shading, lights, Edges::None)?,
                edges: None,
            }),
        };
        if settings.edges().is_some() && passes.edges.is_none() {
            passes.edges = Some(EdgePasses {
                shade: ShadePass::new(&self.gpu, shading, lights, Edges::Shaded)?,
                join: JoinPass::new(&self.gpu, shading.needs(), lights)?,
                shade_joined: ShadePass::new(&self.gpu, shading, lights, Edges::Joined)?,
            });
        }
        Ok(())
    }

    /// Makes what the shadows of the reference need: its pass, and an environment that can be drawn from.
    fn prepare_reference(&mut self, state: &FrameState, terms: Terms) -> Result<()> {
        if let Some(sky) = &state.sky {
            self.show_sky(sky)?;
        }
        let kept = self.reference.take().filter(|pass| pass.terms() == terms);
        let pass = self.reference.insert(kept.map_or_else(|| ReferencePass::new(&self.gpu, terms), Ok)?);
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
