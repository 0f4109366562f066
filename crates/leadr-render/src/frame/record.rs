//! Records the passes of a sample in order.

use std::time::Instant;

use super::edge_samples::{EdgeImage, EdgeSamples};
use super::prepared::{FramePath, FramePlan, MappedLight, Multisample, PreparedFrame};
use super::renderer::{LastSample, Renderer};
use super::timing::{CpuTime, PassTime, Passes, add_times, since};
use crate::passes::accumulate::Parts;
use crate::passes::lamps;
use crate::passes::shade::LightingGpu;
use crate::passes::targets::{Begin, GeometryTargets, SampleTargets};
use crate::view::View;
use leadr_gpu::{Commands, GpuError, Result, Timestamps};

impl PreparedFrame<'_> {
    /// Draws sample `index` of `settings.samples` with all its edge samples, and adds it to the running mean. Waits for the device,
    /// and returns the device time of each pass.
    pub fn draw_sample(&mut self, index: u32) -> Result<Vec<PassTime>> {
        self.draw_sample_repeating(index, 1, &mut CpuTime::default())
    }

    /// Draws a sample. The order of the passes follows the paper's overview (LEADR Figure 3): the light, the tessellated and
    /// displaced geometry with the surface at each pixel, the slope statistics per pixel, and the shading. The edge samples run
    /// through the same passes before the pixels are shaded, and add to the statistics of their pixels. The CPU time is added to
    /// `cpu`.
    pub(super) fn draw_sample_repeating(
        &mut self,
        index: u32,
        repeats: u32,
        cpu: &mut CpuTime,
    ) -> Result<Vec<PassTime>> {
        let timer = self.renderer.timer.repeating(repeats);
        let pixels = self.plan.pixels(index);
        let edges = self.plan.path.edges().cloned();

        // The device may still be drawing frames from other submissions.
        self.renderer.gpu.wait_idle()?;
        let start = Instant::now();
        self.set_view(&pixels, index)?;
        cpu.prepare += since(start);
        let drawn = timer.submit(cpu, |passes| self.record_pixels(passes, &pixels));
        let mut times = drawn.inspect_err(|_| self.renderer.environment.invalidate_sky())?;
        if let Some(edges) = edges {
            for image in edges.images(&pixels) {
                let start = Instant::now();
                self.set_view(&image.view, index)?;
                cpu.prepare += since(start);
                add_times(&mut times, timer.submit(cpu, |passes| self.record_edges(passes, &edges, &image))?);
            }
            // The pixels' slope statistics now include the edge samples.
            if self.plan.surfaces.meshes.shades_classes() {
                self.set_view(&pixels, index)?;
            } else {
                self.write_lighting(&pixels, index)?;
            }
            add_times(&mut times, timer.submit(cpu, |passes| self.record_shading(passes, &pixels))?);
        }
        self.finish_sample(index);
        Ok(times)
    }

    /// Records the passes of sample `index` and writes a named timestamp after each. `timestamps` must have room for a first mark
    /// and `MAX_PASSES` more. The frame's buffers are written immediately, so the device must have finished its earlier samples.
    /// The device may still be drawing other frames.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] for a frame that cannot [overlap](Self::overlaps) with others. Also returns an error if memory
    /// is short.
    #[doc(hidden)]
    pub fn record_sample(&mut self, index: u32, cmd: &mut Commands, timestamps: &Timestamps) -> Result<()> {
        if !self.overlaps() {
            let fault = "a sample takes several submissions: call `draw_sample` instead".to_owned();
            return Err(GpuError::Usage { name: "frame".to_owned(), fault });
        }
        let pixels = self.plan.pixels(index);
        self.set_view(&pixels, index)?;
        Passes::record(cmd, timestamps, 1, |passes| self.record_pixels(passes, &pixels));
        self.finish_sample(index);
        Ok(())
    }

    /// Records all passes of a sample or, with edge samples, only the passes that come before them.
    fn record_pixels(&mut self, passes: &mut Passes<'_>, pixels: &View) {
        self.record_light(passes);
        self.record_pixel_geometry(passes, pixels);
        let target = &self.plan.targets.pixels;
        match &self.plan.path {
            FramePath::Fused { lit, multisample } => {
                self.record_filter_and_shade(passes, target, pixels, lit, multisample.as_ref());
            }
            FramePath::Deferred { .. } | FramePath::Reference { .. } => {
                self.record_filter(passes, target, pixels, None);
            }
        }
        if self.plan.path.edges().is_none() {
            self.record_shading(passes, pixels);
        }
    }

    fn finish_sample(&mut self, index: u32) {
        self.plan.drawn += 1;
        let FramePlan { state, settings, .. } = &self.plan;
        let (state, settings) = (state.clone(), *settings);
        self.renderer.last = Some(LastSample { state, settings, index, in_gbuffer: self.plan.path.fills_gbuffer() });
    }

    /// Selects the geometry that a view shows, and writes the light for the view. The device must not be drawing this frame.
    pub(super) fn set_view(&mut self, view: &View, index: u32) -> Result<()> {
        self.plan.surfaces.set_view(view)?;
        self.write_lighting(view, index)?;
        let FramePlan { state, settings, surfaces, path, .. } = &mut self.plan;
        match path {
            FramePath::Reference { lights, .. } => {
                lights.point(state, settings, view, &surfaces.meshes.casters(), index)
            }
            FramePath::Fused { .. } | FramePath::Deferred { .. } => Ok(()),
        }
    }

    /// Writes the lighting and the rays of a view. The device must not be drawing this frame.
    fn write_lighting(&self, view: &View, index: u32) -> Result<()> {
        let FramePlan { state, settings, path, surfaces, lighting, lamps, .. } = &self.plan;
        let block = LightingGpu::new(state, view, &self.renderer.environment, &lamps.list, path.shadows())
            .with_draws(index, settings.seed);
        lamps::write(&lamps.buffer, &lamps.list)?;
        // The horizon of a sea lies below eye level, so the sky continues below it.
        lighting.write(0, &[if surfaces.sea.is_some() { block.with_sea_horizon() } else { block }])
    }

    /// Records the light that all views share. Waves, sky, irradiance and shadow maps are recorded once per frame, and relief
    /// shadows once per sample.
    fn record_light(&mut self, passes: &mut Passes<'_>) {
        let FramePlan { state, surfaces, path, shadow_maps, drawn, .. } = &self.plan;
        let Renderer { environment, irradiance, common, .. } = &mut *self.renderer;
        let first = *drawn == 0;
        if first {
            surfaces.record_motion(passes);
        }
        match path {
            FramePath::Reference { pass, lights } => {
                let casters = surfaces.meshes.casters();
                passes.run("shadow", |cmd| pass.record_maps(cmd, lights, &casters));
            }
            FramePath::Fused { lit, .. } | FramePath::Deferred { lit, .. } if first => {
                if let Some(sky) = &state.sky {
                    let mut moved = false;
                    passes.run_once("sky", |cmd| moved = environment.begin_sky(cmd, sky));
                    passes.run_once("cube mips", |cmd| {
                        if moved {
                            environment.make_mips(cmd);
                        }
                    });
                }
                passes.run("irradiance", |cmd| irradiance.record(cmd, environment));
                let casters = |light| surfaces.meshes.casters_under(light).into_iter();
                passes.run("shadow", |cmd| common.shadow.record(cmd, shadow_maps, (0..lit.shadows.len()).map(casters)));
            }
            FramePath::Fused { .. } | FramePath::Deferred { .. } => {}
        }
    }

    /// Records the geometry of the pixels, single-sampled or multisampled.
    pub(super) fn record_pixel_geometry(&self, passes: &mut Passes<'_>, view: &View) {
        let visible = &self.plan.targets.pixels.visible;
        match self.plan.path.multisample() {
            Some(Multisample { pass, targets }) => {
                self.record_geometry(passes, &targets.geometry, view);
                passes.run("multisampling", |cmd| pass.record(cmd, targets, visible, view));
            }
            None => self.record_geometry(passes, &visible.geometry(), view),
        }
    }

    /// Records the geometry. The surfaces are tessellated, displaced and rasterised, so that each sample holds its visible surface.
    fn record_geometry(&self, passes: &mut Passes<'_>, target: &GeometryTargets, view: &View) {
        let mut begin = Begin::Clear;
        for surface in self.plan.surfaces.drawn() {
            let draw = |cmd: &mut Commands| surface.draw_geometry(cmd, target, view);
            passes.run(surface.names().geometry, |cmd| target.draw(cmd, begin, draw));
            begin = Begin::Continue;
        }
    }

    /// Records the filter passes, which compute the statistics of the surfaces' maps under each pixel.
    pub(super) fn record_filter(
        &self,
        passes: &mut Passes<'_>,
        target: &SampleTargets,
        view: &View,
        scissor: Option<[u32; 4]>,
    ) {
        let SampleTargets { visible, gbuffer, .. } = target;
        let mut begin = Begin::Clear;
        passes.run("filter", |cmd| self.renderer.common.tiles.record(cmd, visible));
        for surface in self.plan.surfaces.drawn() {
            let draw = |cmd: &mut Commands| surface.draw_filter(cmd, visible, view, None);
            passes.run(surface.names().filter, |cmd| gbuffer.draw(cmd, begin, scissor, draw));
            begin = Begin::Continue;
        }
    }

    /// Records filter passes that also shade, and the sky in empty pixels.
    fn record_filter_and_shade(
        &self,
        passes: &mut Passes<'_>,
        target: &SampleTargets,
        view: &View,
        lit: &MappedLight,
        multisample: Option<&Multisample>,
    ) {
        let (visible, scene) = (&target.visible, &self.plan.scene);
        for (i, surface) in self.plan.surfaces.drawn().enumerate() {
            passes.run(surface.names().filter_and_shade, |cmd| {
                if i == 0 {
                    let multisampled = multisample.map(|multisample| &multisample.targets);
                    self.renderer.common.objects.record(cmd, visible, multisampled);
                }
                let begin = if i == 0 { Begin::Clear } else { Begin::Continue };
                target.draw_radiance_of_objects(cmd, begin, |cmd| {
                    if i == 0 {
                        lit.behind.draw(cmd, visible, scene);
                    }
                    surface.draw_filter(cmd, visible, view, Some(scene));
                });
            });
        }
    }

    /// Records an image of edge samples. Samples on the pixel's own surface add to the slope statistics of the pixel. All other
    /// samples are shaded.
    fn record_edges(&self, passes: &mut Passes<'_>, edges: &EdgeSamples, image: &EdgeImage) {
        let (renderer, targets) = (&*self.renderer, &edges.targets);
        let (pixels, samples, scissor) = (&self.plan.targets.pixels, &targets.samples, Some(image.scissor));
        self.record_geometry(passes, &samples.visible.geometry(), &image.view);
        passes.run("edges", |cmd| renderer.common.edges.record(cmd, pixels, &samples.visible, &image.rays));
        self.record_filter(passes, samples, &image.view, scissor);
        let (scene, meshes) = (&self.plan.scene, &self.plan.surfaces.meshes);
        passes.run("shade", |cmd| {
            let by_class = meshes.objects_by_class();
            samples.draw_radiance(cmd, scissor, |cmd| edges.shade.draw(cmd, samples, scene, None, by_class));
            if meshes.shades_classes() {
                renderer.common.objects.record(cmd, &samples.visible, None);
                samples.draw_radiance_of_objects(cmd, Begin::Continue, |cmd| {
                    meshes.draw_by_class(cmd, &samples.visible, &image.view, scene);
                });
            }
        });
        let joined = &targets.joined;
        passes.run("edges", |cmd| edges.join.record(cmd, samples, &pixels.gbuffer, joined, scene, &image.rays));
    }

    /// Records the shading of the pixels, and adds them to the mean.
    fn record_shading(&self, passes: &mut Passes<'_>, view: &View) {
        let FramePlan { targets, path, accumulate, drawn, scene, surfaces, .. } = &self.plan;
        let Renderer { environment, common, .. } = &*self.renderer;
        let edges = path.edges();
        let pixels = &targets.pixels;
        match path {
            FramePath::Fused { .. } => {}
            FramePath::Reference { pass, lights } => passes.run("shade", |cmd| {
                pixels.draw_radiance(cmd, None, |cmd| pass.draw(cmd, pixels, lights, environment, scene));
            }),
            FramePath::Deferred { lit, shade, .. } => passes.run("shade", |cmd| {
                common.objects.record(cmd, &pixels.visible, None);
                pixels.draw_radiance_of_objects(cmd, Begin::Clear, |cmd| {
                    lit.behind.draw(cmd, &pixels.visible, scene);
                    let joined = edges.map(|edges| &edges.targets.joined);
                    shade.draw(cmd, pixels, scene, joined, surfaces.meshes.objects_by_class());
                    surfaces.meshes.draw_by_class(cmd, &pixels.visible, view, scene);
                });
            }),
        }
        let parts = match (edges, path.multisample()) {
            (Some(edges), _) => Parts::Edges { joined: &edges.targets.joined, samples: edges.samples },
            (None, Some(multisample)) => Parts::Multisampled(&multisample.targets),
            (None, None) => Parts::One,
        };
        passes.run("accumulate", |cmd| accumulate.record(cmd, pixels, parts, &targets.mean, *drawn));
    }
}

impl FramePlan {
    /// Returns the view that draws the pixels' own samples for sample `index`.
    pub(super) fn pixels(&self, index: u32) -> View {
        View {
            camera: self.state.camera,
            picture: self.settings.size,
            samples: self.settings.pixel_samples(),
            offset: self.settings.sample_offset(index),
            lod_bias: self.settings.shading.options().lod_bias.0,
        }
    }
}
