//! The passes of a sample in their order.

use glam::Vec2;

use super::{PassTime, PixelPasses, Renderer, add_times};
use crate::gpu::{Commands, Result, Timestamps};
use crate::render::accumulate::edge_jitter;
use crate::render::edges::EdgeRays;
use crate::render::patch_mesh::PosedVertices;
use crate::render::scene::FrameState;
use crate::render::settings::RenderSettings;
use crate::render::shade::{LightSet, ShadeInputs};

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
}

impl SubFrame {
    /// Pixels across and down, and the offset inside each.
    pub fn image(&self, settings: &RenderSettings) -> ((u32, u32), Vec2) {
        let offset = settings.sample_offset(self.index);
        let (width, height) = settings.size;
        let offset = self.edges.map_or(offset, |(index, count)| edge_jitter(offset, index, count));
        ((self.grid * width, self.grid * height), offset)
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
        let (gpu, timestamps) = (self.gpu.clone(), self.timestamps.clone());
        let grid = self.targets.as_ref().map_or(1, |targets| targets.grid);
        let shaded = SubFrame { index, drawn, edges: None, grid: 1 };
        let count = settings.edges().map_or(0, |samples| samples / (grid * grid));
        let edges = (0..count).map(|k| SubFrame { edges: Some((k, count)), grid, ..shaded });
        for sub in std::iter::once(shaded).chain(edges) {
            self.prepare_camera(state, settings, posed, &sub)?;
            gpu.submit("frame", |cmd| {
                cmd.reset_timestamps(&timestamps);
                self.record(cmd, state, settings, &sub, &timestamps);
            })?;
            let intervals = timestamps.intervals()?.into_iter();
            add_times(&mut times, intervals.map(|(pass, milliseconds)| PassTime { pass, milliseconds }).collect());
        }
        Ok(times)
    }

    /// Records a prepared sub-frame: LEADR's Figure 3 from top to bottom.
    fn record(
        &mut self,
        cmd: &mut Commands,
        state: &FrameState,
        settings: &RenderSettings,
        sub: &SubFrame,
        timestamps: &Timestamps,
    ) {
        let lights = LightSet::new(state, self.shadow_view.is_some());
        let (Some(targets), Some(PixelPasses { filter, shade, shade_edges })) =
            (&self.targets, self.pipelines.get(&(settings.shading, lights)))
        else {
            return;
        };
        let (target, shade) = match (sub.edges, &targets.edges, shade_edges) {
            (Some(_), Some(edges), Some(shade_edges)) => (edges, shade_edges),
            _ => (&targets.pixel, shade),
        };
        let repeats = self.repeats;
        let height_scale = settings.geometry_scale(state.height_scale);
        let relief = self.reference.as_ref().filter(|_| settings.shadows_of_relief());
        cmd.timestamp(timestamps, "begin");
        if let Some(ocean) = self.ocean.as_ref().filter(|_| sub.drawn == 0 && sub.edges.is_none()) {
            ocean.record_waves(cmd, state.time, repeats, timestamps);
        }
        if let Some(relief) = relief {
            let casters: Vec<_> = self.drawn.iter().filter(|d| d.sun.is_some()).map(|d| &d.object).collect();
            cmd.label("shadow", |cmd| relief.record_maps(cmd, &casters, height_scale));
            cmd.timestamp(timestamps, "shadow");
        } else if sub.drawn == 0 && sub.edges.is_none() {
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
            let (size, offset) = sub.image(settings);
            let pixel = state.camera.rays(settings.size, settings.sample_offset(sub.index));
            let rays = EdgeRays::new(pixel, state.camera.rays(size, offset), state.camera.near);
            cmd.label_times("edges", repeats, |cmd| {
                self.edges.record(cmd, &targets.pixel.visible, &target.visible, &rays);
            });
            cmd.timestamp(timestamps, "edges");
        }
        cmd.label_times("filter", repeats, |cmd| {
            let objects = objects.iter().filter(|(_, view)| !view.draws.is_empty()).map(|(object, _)| *object);
            filter.record(cmd, &target.visible, &target.gbuffer, objects, state.height_scale)
        });
        cmd.timestamp(timestamps, "filter");
        if let Some(ocean) = &self.ocean {
            cmd.label_times("sea filter", repeats, |cmd| ocean.record_filter(cmd, &target.visible, &target.gbuffer));
            cmd.timestamp(timestamps, "sea filter");
        }
        let inputs = ShadeInputs {
            visible: &target.visible,
            gbuffer: &target.gbuffer,
            lighting: &self.lighting,
            cube: self.environment.cube(),
            radiance_sh: self.irradiance.coefficients(),
            shadow_map: &self.shadow.map,
        };
        cmd.label_times("shade", repeats, |cmd| match relief {
            Some(pass) => pass.record(cmd, &target.visible, &target.gbuffer, &self.environment, &target.radiance),
            None => shade.record(cmd, inputs, &target.radiance),
        });
        cmd.timestamp(timestamps, "shade");
        // With edge samples, they are all there is in the mean.
        let (number, count) = sub.edges.unwrap_or((0, 1));
        let before = sub.drawn * count + number;
        if sub.edges.is_some() || targets.edges.is_none() {
            cmd.label_times("accumulate", repeats, |cmd| {
                self.accumulate.record(cmd, &target.radiance, &targets.pixel.radiance, &targets.mean, before);
            });
            cmd.timestamp(timestamps, "accumulate");
        }
    }
}
