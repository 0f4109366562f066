//! The passes of a sample in their order.

use glam::Vec2;

use super::targets::{SampleTargets, Targets};
use super::{EdgePasses, PassTime, PixelPasses, Renderer, add_times};
use crate::gpu::{Commands, Image, Result};
use crate::render::passes::edges::{EdgeRays, area_of};
use crate::render::passes::shade::{LightSet, ShadeInputs};
use crate::render::sampling::edge_jitter;
use crate::render::scene::FrameState;
use crate::render::settings::RenderSettings;
use crate::render::surfaces::patch_mesh::PosedVertices;

/// One drawing of the geometry.
#[derive(Clone, Copy)]
pub(super) struct SubFrame {
    /// The sample among those of the frame.
    pub index: u32,
    /// Samples in the mean before it.
    drawn: u32,
    /// Which grid of its edge samples this is, and of how many; none for what the pixel's surface is shaded by.
    edges: Option<(u32, u32)>,
    /// Pixels of this drawing along one of the picture.
    pub grid: u32,
    /// Pixels of the picture that edge samples are drawn in ([`area_of`]).
    area: [i32; 4],
}

impl SubFrame {
    /// Whether these are edge samples.
    pub fn edges(&self) -> bool {
        self.edges.is_some()
    }

    /// Pixels across and down, and the offset inside each.
    pub fn image(&self, settings: &RenderSettings) -> ((u32, u32), Vec2) {
        let offset = settings.sample_offset(self.index);
        let (width, height) = settings.size;
        let offset = self.edges.map_or(offset, |(index, count)| edge_jitter(offset, index, count));
        ((self.grid * width, self.grid * height), offset)
    }

    /// Edge samples of each pixel before these, and their rays beside those of the pixels' own samples.
    fn edge_rays(&self, state: &FrameState, settings: &RenderSettings) -> EdgeRays {
        let (size, offset) = self.image(settings);
        let pixel = state.camera.rays(settings.size, settings.sample_offset(self.index));
        let before = self.edges.map_or(0, |(k, _)| k * self.grid * self.grid);
        EdgeRays::new(
            pixel,
            state.camera.rays(size, offset),
            state.camera.near,
            (before, settings.edges().unwrap_or(1)),
            self.area,
        )
    }

    /// Where edge samples are filtered and shaded.
    fn scissor(&self) -> Option<[u32; 4]> {
        let [left, top, right, bottom] = self.area.map(i32::unsigned_abs);
        self.edges.map(|_| [left, top, right - left, bottom - top].map(|v| v * self.grid))
    }
}

impl Renderer {
    /// Draws sample `index` of a prepared frame, all its edge samples included, into the mean that holds the `drawn` samples
    /// before it (at 0 it is begun). Waits for the device, and returns the time of each pass on it.
    ///
    /// # Errors
    /// As [`render`](Self::render).
    pub fn draw_sample(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        posed: &[PosedVertices],
        index: u32,
        drawn: u32,
    ) -> Result<Vec<PassTime>> {
        let mut times = Vec::new();
        let gpu = self.gpu.clone();
        let grid = self.targets.as_ref().and_then(|targets| targets.edges.as_ref()).map_or(1, |edges| edges.grid);
        let pixel = SubFrame { index, drawn, edges: None, grid: 1, area: [0; 4] };
        let count = settings.edges().map_or(0, |samples| samples / (grid * grid));
        let area = if self.ocean.is_some() {
            [0, 0, settings.size.0 as i32, settings.size.1 as i32]
        } else {
            let height_scale = settings.geometry_scale(state.height_scale);
            let spheres: Vec<_> =
                self.drawn.iter().zip(posed).map(|(d, posed)| d.object.bounds(posed, height_scale)).collect();
            area_of(&spheres, &state.camera, settings.size)
        };
        let edges = (0..count).map(|k| SubFrame { edges: Some((k, count)), grid, area, ..pixel });
        let mut submit = |renderer: &mut Self, record: &dyn Fn(&mut Self, &mut Commands)| -> Result<()> {
            let timestamps = renderer.timestamps.clone();
            gpu.submit("frame", |cmd| {
                cmd.reset_timestamps(&timestamps);
                cmd.timestamp(&timestamps, "begin");
                record(renderer, cmd);
            })?;
            let intervals = timestamps.intervals()?.into_iter();
            add_times(&mut times, intervals.map(|(pass, milliseconds)| PassTime { pass, milliseconds }).collect());
            Ok(())
        };
        for sub in std::iter::once(pixel).chain(edges) {
            self.prepare_camera(state, settings, posed, &sub)?;
            submit(self, &|renderer, cmd| {
                renderer.record_lights(cmd, state, settings, &sub);
                renderer.record_surfaces(cmd, state, settings, &sub);
                if sub.edges.is_some() {
                    renderer.record_edges(cmd, state, settings, &sub);
                } else if count == 0 {
                    renderer.record_shading(cmd, state, settings, &sub);
                }
            })?;
        }
        if count > 0 {
            // Only now is known what the pixels' own surfaces are.
            self.prepare_lighting(state, settings, &pixel)?;
            submit(self, &|renderer, cmd| renderer.record_shading(cmd, state, settings, &pixel))?;
        }
        Ok(times)
    }

    /// The targets and the passes of a prepared frame.
    fn pixel_passes(&self, state: &FrameState, settings: &RenderSettings) -> (&Targets, &PixelPasses) {
        let lights = LightSet::new(state, self.shadow_view.is_some());
        let passes = self.pipelines.get(&(settings.shading.plain(), lights)).expect("prepared");
        (self.targets.as_ref().expect("prepared"), passes)
    }

    /// Records what comes before any view: waves, sky, irradiance and shadows of the frame, or the shadows of one sample of
    /// the reference.
    fn record_lights(&mut self, cmd: &mut Commands, state: &FrameState, settings: &RenderSettings, sub: &SubFrame) {
        let (timestamps, repeats) = (&self.timestamps, self.repeats);
        let height_scale = settings.geometry_scale(state.height_scale);
        let relief = self.reference.as_ref().filter(|_| settings.shadows_of_relief());
        let first = sub.drawn == 0 && sub.edges.is_none();
        if let Some(ocean) = self.ocean.as_ref().filter(|_| first) {
            ocean.record_waves(cmd, state.time, repeats, timestamps);
        }
        if let Some(relief) = relief {
            let casters: Vec<_> = self.drawn.iter().filter(|d| d.sun.is_some()).map(|d| &d.object).collect();
            cmd.label("shadow", |cmd| relief.record_maps(cmd, &casters, height_scale));
            cmd.timestamp(timestamps, "shadow");
        } else if first {
            if let Some(sky) = &state.sky {
                let moved = cmd.label("sky", |cmd| self.environment.begin_sky(cmd, sky));
                cmd.timestamp(timestamps, "sky");
                if moved {
                    cmd.label("cube mips", |cmd| self.environment.make_mips(cmd));
                }
                cmd.timestamp(timestamps, "cube mips");
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
    }

    /// Records what a prepared sub-frame sees, filtered: LEADR's Figure 3 down to the shading.
    fn record_surfaces(&self, cmd: &mut Commands, state: &FrameState, settings: &RenderSettings, sub: &SubFrame) {
        let (timestamps, repeats) = (&self.timestamps, self.repeats);
        let (targets, passes) = self.pixel_passes(state, settings);
        let target = match &targets.edges {
            Some(edges) if sub.edges.is_some() => &edges.samples,
            _ => &targets.pixel,
        };
        let height_scale = settings.geometry_scale(state.height_scale);
        let objects: Vec<_> = self.drawn.iter().map(|d| (&d.object, &d.camera)).collect();
        cmd.label_times("geometry", repeats, |cmd| {
            self.geometry.record(cmd, &target.visible, &objects, height_scale, settings.mark_inside)
        });
        cmd.timestamp(timestamps, "geometry");
        if let Some(ocean) = &self.ocean {
            cmd.label_times("sea geometry", repeats, |cmd| ocean.record_geometry(cmd, &target.visible));
            cmd.timestamp(timestamps, "sea geometry");
        }
        if sub.edges.is_some() {
            let rays = sub.edge_rays(state, settings);
            cmd.label_times("edges", repeats, |cmd| {
                let pixel = (&targets.pixel.visible, &targets.pixel.gbuffer);
                self.edges.record(cmd, pixel, &target.visible, &rays);
            });
            cmd.timestamp(timestamps, "edges");
        }
        let grid = if sub.edges() { sub.grid } else { 0 };
        let (size, offset) = sub.image(settings);
        cmd.label_times("filter", repeats, |cmd| {
            self.tiles.record(cmd, &target.visible);
            let objects = objects.iter().filter(|(_, view)| !view.draws.is_empty()).map(|(object, _)| *object);
            passes.filter.record(
                cmd,
                &target.visible,
                &target.gbuffer,
                objects,
                state.height_scale,
                (state.camera.rays(size, offset), state.camera.near),
                grid,
                sub.scissor(),
            );
        });
        cmd.timestamp(timestamps, "filter");
        if let Some(ocean) = &self.ocean {
            cmd.label_times("sea filter", repeats, |cmd| ocean.record_filter(cmd, &target.visible, &target.gbuffer));
            cmd.timestamp(timestamps, "sea filter");
        }
    }

    /// Records the shading of edge samples that see other surfaces than their pixels, and joins them all.
    fn record_edges(&self, cmd: &mut Commands, state: &FrameState, settings: &RenderSettings, sub: &SubFrame) {
        let (targets, passes) = self.pixel_passes(state, settings);
        let (Some(edges), Some(EdgePasses { shade, join, .. })) = (&targets.edges, &passes.edges) else { return };
        let SampleTargets { visible, gbuffer, radiance } = &edges.samples;
        let inputs = self.shade_inputs(&edges.samples, None);
        cmd.label_times("shade", self.repeats, |cmd| shade.record(cmd, inputs, radiance, sub.scissor()));
        cmd.timestamp(&self.timestamps, "shade");
        let rays = sub.edge_rays(state, settings);
        cmd.label_times("edges", self.repeats, |cmd| {
            let lights = (&self.lighting, &self.shadow.map);
            join.record(cmd, (visible, gbuffer, radiance), &targets.pixel.gbuffer, &edges.joined, lights, &rays);
        });
        cmd.timestamp(&self.timestamps, "edges");
    }

    /// Records the shading of the pixels, and takes the sample into the mean.
    fn record_shading(&self, cmd: &mut Commands, state: &FrameState, settings: &RenderSettings, sub: &SubFrame) {
        let (targets, passes) = self.pixel_passes(state, settings);
        let SampleTargets { visible, gbuffer, radiance } = &targets.pixel;
        let relief = self.reference.as_ref().filter(|_| settings.shadows_of_relief());
        cmd.label_times("shade", self.repeats, |cmd| match relief {
            Some(pass) => pass.record(cmd, visible, gbuffer, &self.environment, radiance),
            None => {
                let edges = targets.edges.as_ref().zip(passes.edges.as_ref());
                let shade = edges.map_or(&passes.shade, |(_, passes)| &passes.shade_joined);
                let shares = edges.map(|(targets, _)| &targets.joined.shares);
                shade.record(cmd, self.shade_inputs(&targets.pixel, shares), radiance, None);
            }
        });
        cmd.timestamp(&self.timestamps, "shade");
        let edges = targets.edges.as_ref().zip(settings.edges()).map(|(edges, samples)| (&edges.joined, samples));
        cmd.label_times("accumulate", self.repeats, |cmd| {
            self.accumulate.record(cmd, radiance, edges, &targets.mean, sub.drawn);
        });
        cmd.timestamp(&self.timestamps, "accumulate");
    }

    fn shade_inputs<'a>(&'a self, target: &'a SampleTargets, shares: Option<&'a Image>) -> ShadeInputs<'a> {
        ShadeInputs {
            visible: &target.visible,
            gbuffer: &target.gbuffer,
            lighting: &self.lighting,
            cube: self.environment.cube(),
            radiance_sh: self.irradiance.coefficients(),
            shadow_map: &self.shadow.map,
            shares: shares.unwrap_or(&target.visible.depth),
        }
    }
}
