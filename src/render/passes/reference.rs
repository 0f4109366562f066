//! The reference with relief shadows: supersampled displacement that blocks its own lights.
//!
//! Every sample draws maps of the lights' visibility ([`relief_shadow`](super::relief_shadow)) from geometry with a vertex
//! per texel, and lights the facets it sees with them: by the sun, the point lights, and one light drawn from the
//! environment ([`environment_lights`](super::environment_lights)), whose mean over the samples is the environment with
//! true visibility.
//!
//! Blocked directions are black: light is reflected only once. In base materials smoother than
//! [`MIRROR_ALPHA`](crate::render::constants::MIRROR_ALPHA), the environment is reflected as if the relief hid only the
//! viewer's rays: lights drawn at random would almost never fall into such a narrow lobe, and a depth map knows no other
//! directions.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::environment_lights::{EnvironmentLights, light_point};
use super::relief_shadow::{Caster, ReliefMaps, ReliefShadowPass, map_size, relief_view};
use super::shadow::ShadowView;
use super::targets::{RADIANCE_FORMAT, SampleTargets};
use crate::gpu::{
    AddressMode, Buffer, ColorTarget, Commands, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, Load, Memory,
    Result, Sampler, SharedStruct, SpecValue, Use, shared_struct,
};
use crate::render::constants::MAX_RELIEF_LIGHTS;
use crate::render::light::environment::Environment;
use crate::render::scene::{FrameState, MAX_POINT_LIGHTS};
use crate::render::settings::{RenderSettings, Terms};
use crate::render::surfaces::object_view::PosedObject;
use crate::render::surfaces::sphere::Sphere;
use crate::render::view::View;

const MAX_LIGHTS: usize = MAX_RELIEF_LIGHTS as usize;

shared_struct! {
    /// A light as the shader reads it (`Light` in `passes/shade/reference.frag`).
    #[derive(Default)]
    pub struct ReliefLightGpu for "Light" {
        /// World to texture coordinates and depth in the map.
        pub texture_from_world: [[f32; 4]; 4],
        /// Its inverse.
        pub world_from_texture: [[f32; 4]; 4],
        /// Direction towards it, or its position; w 1 for a point light.
        pub place: [f32; 4],
        /// Irradiance or intensity; w 1 for a light drawn from the environment.
        pub power: [f32; 4],
        /// Layer, world size of a texel, unused, 1 if it has a map.
        pub map: [f32; 4],
    }
}

shared_struct! {
    /// The light block (`Lighting`).
    #[derive(Default)]
    pub struct ReliefLightingGpu for "Lighting" {
        /// Rays through the image; the last w is the near plane.
        pub rays: [[f32; 4]; 3],
        /// Position of the viewer.
        pub camera_position: [f32; 4],
        /// Width and height of the image, face size of the environment, 1 if heights move the surface.
        pub viewport: [f32; 4],
        /// Number of lights.
        pub counts: [i32; 4],
        /// The lights.
        pub lights: [ReliefLightGpu; MAX_LIGHTS],
    }
}

/// The pipelines of the reference: its shading, and the shadow maps that it reads.
#[derive(Clone)]
pub struct ReferencePass {
    pipeline: GraphicsPipeline,
    shadows: ReliefShadowPass,
    nearest: Sampler,
    trilinear: Sampler,
}

impl ReferencePass {
    /// The pass for some terms of the light, with the base rough in the frame of the facets or in that of the macrosurface.
    ///
    /// # Errors
    /// Memory that is short, or a failed pipeline.
    pub fn new(gpu: &Arc<Gpu>, terms: Terms, facet_frame: bool) -> Result<Self> {
        let desc = GraphicsDesc {
            vertex: "passes/fullscreen.vert",
            fragment: Some("passes/shade/reference.frag"),
            colors: &[RADIANCE_FORMAT],
            spec: &[("TERMS", SpecValue::I32(terms.bits())), ("FACET_FRAME", SpecValue::Bool(facet_frame))],
            structs: &[ReliefLightGpu::LAYOUT, ReliefLightingGpu::LAYOUT],
            ..Default::default()
        };
        Ok(Self {
            pipeline: GraphicsPipeline::new(gpu, "reference", &desc)?,
            shadows: ReliefShadowPass::new(gpu)?,
            nearest: Sampler::new(gpu, "nearest", Filter::Nearest, AddressMode::ClampToEdge)?,
            trilinear: Sampler::new(gpu, "environment", Filter::Trilinear, AddressMode::ClampToEdge)?,
        })
    }

    /// Draws the shadow maps of the sample for which `lights` were last pointed.
    pub fn record_maps(&self, cmd: &mut Commands, lights: &ReliefLights, casters: &[&PosedObject]) {
        self.shadows.record(cmd, &lights.maps, casters);
    }

    /// Shades every pixel of the sample's G-buffer.
    pub fn record(&self, cmd: &mut Commands, sample: &SampleTargets, lights: &ReliefLights, environment: &Environment) {
        let SampleTargets { visible, gbuffer, radiance } = sample;
        cmd.image_barrier(radiance, Use::Undefined, Use::ColorTarget);
        cmd.begin_rendering(&[ColorTarget { view: radiance.whole(), load: Load::Discard }], None);
        cmd.bind(
            &self.pipeline,
            &[
                ("gbuffer_slopes", Descriptor::Sampled(gbuffer.slopes.whole(), &self.nearest)),
                ("gbuffer_material", Descriptor::Sampled(gbuffer.material.whole(), &self.nearest)),
                ("gbuffer_surface", Descriptor::Sampled(gbuffer.surface.whole(), &self.nearest)),
                ("gbuffer_depth", Descriptor::Sampled(visible.depth.whole(), &self.nearest)),
                ("lighting", Descriptor::Uniform(&lights.block)),
                ("environment_cube", Descriptor::Sampled(environment.cube(), &self.trilinear)),
                ("depth_maps", Descriptor::Sampled(lights.maps.array(), &self.nearest)),
            ],
        );
        cmd.draw(0..3, 0..1);
        cmd.end_rendering();
    }
}

/// The lights of a frame, with maps of the parts that the relief hides from them.
pub struct ReliefLights {
    block: Buffer,
    maps: ReliefMaps,
    environment: Option<EnvironmentLights>,
    face_size: u32,
    /// Bounding sphere of the casters, if there are any.
    bounds: Option<Sphere>,
    /// Size of a map in texels along a side.
    size: u32,
}

impl ReliefLights {
    /// The lights of a frame on its casters. The device must be idle, and the environment must show the frame's sky.
    ///
    /// # Errors
    /// A lost device, or memory that is short.
    pub fn new(
        gpu: &Arc<Gpu>,
        state: &FrameState,
        environment: &Environment,
        casters: &[&PosedObject],
    ) -> Result<Self> {
        let bounds = Sphere::enclosing(&casters.iter().map(|posed| posed.bounds()).collect::<Vec<_>>());
        let size = bounds.map_or(1, |bounds| {
            let texel = casters.iter().map(|posed| posed.texel_length()).fold(f32::INFINITY, f32::min);
            map_size(bounds.radius, texel)
        });
        let (face_size, environment) = (environment.face_size(), EnvironmentLights::read(environment)?);
        let points = state.point_lights.len().min(MAX_POINT_LIGHTS);
        let lights = usize::from(state.sun.is_some()) + usize::from(environment.is_some()) + points;
        Ok(Self {
            block: Buffer::new(gpu, "reference lighting", size_of::<ReliefLightingGpu>() as u64, Memory::Upload)?,
            maps: ReliefMaps::new(gpu, casters, size, if bounds.is_some() { lights } else { 0 })?,
            environment,
            face_size,
            bounds,
            size,
        })
    }

    /// Chooses the lights of sample `index`, seen in `view`, and points their maps at the `casters` for which the lights
    /// were made. The device must be idle.
    ///
    /// # Errors
    /// A failed write.
    pub fn point(
        &mut self,
        state: &FrameState,
        settings: &RenderSettings,
        view: &View,
        casters: &[&PosedObject],
        index: u32,
    ) -> Result<()> {
        let [x, y, z] = view.rays();
        let (width, height) = view.size();
        let mut block = ReliefLightingGpu {
            rays: [x.extend(0.0), y.extend(0.0), z.extend(view.camera.near)].map(|v| v.to_array()),
            camera_position: view.camera.position.extend(1.0).to_array(),
            viewport: [width as f32, height as f32, self.face_size as f32, f32::from(u8::from(settings.displacement))],
            ..Default::default()
        };
        let lights = self.lights_of_sample(state, settings, index);
        // Maps are moved independently of the sample's position in the pixel.
        let [u, v] = light_point(index, !settings.seed);
        let shift = Vec2::new(u as f32, v as f32) - 0.5;
        let mut views: Vec<ShadowView> = Vec::new();
        for (light, slot) in lights.iter().zip(&mut block.lights) {
            let (place, point) = match light.caster {
                Caster::Directional(direction) => (direction, 0.0),
                Caster::Point(position) => (position, 1.0),
            };
            slot.place = place.extend(point).to_array();
            slot.power = light.power.extend(f32::from(u8::from(light.drawn))).to_array();
            if let Some(bounds) = self.bounds {
                let view = relief_view(light.caster, bounds, self.size, shift);
                slot.texture_from_world = view.texture_from_world.to_cols_array_2d();
                slot.world_from_texture = view.texture_from_world.inverse().to_cols_array_2d();
                slot.map = [views.len() as f32, view.texel, 0.0, 1.0];
                views.push(view);
            }
        }
        block.counts[0] = lights.len() as i32;
        self.maps.point(casters, &views, view.lens(), &settings.tessellation)?;
        self.block.write(0, &[block])
    }

    fn lights_of_sample(&self, state: &FrameState, settings: &RenderSettings, index: u32) -> Vec<SampleLight> {
        let mut lights = Vec::new();
        if let Some(sun) = state.sun {
            let direction = sun.direction.normalize_or(Vec3::Z);
            lights.push(SampleLight { caster: Caster::Directional(direction), power: sun.irradiance, drawn: false });
        }
        if let Some(environment) = &self.environment {
            let light = environment.draw(light_point(index, settings.seed));
            let caster = Caster::Directional(light.direction);
            lights.push(SampleLight { caster, power: light.irradiance, drawn: true });
        }
        let points = state.point_lights.iter().take(MAX_POINT_LIGHTS);
        lights.extend(points.map(|l| SampleLight {
            caster: Caster::Point(l.position),
            power: l.intensity,
            drawn: false,
        }));
        lights
    }
}

struct SampleLight {
    caster: Caster,
    power: Vec3,
    drawn: bool,
}
