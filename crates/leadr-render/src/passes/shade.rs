//! The inputs of fragment stages that shade. Also the passes that shade the G-buffer and draw the sky behind surfaces.

use std::sync::Arc;

use super::lamps::{Lamp, LampGpu};
use super::object_depth::{ANY_OBJECT_TEST, OBJECT_TEST};
use super::shadow::ShadowView;
use super::targets::{JoinedEdges, RADIANCE_FORMAT, SampleTargets, VisibleSurface};
use crate::constants::{
    EDGES_ARE_ABSENT, EDGES_ARE_JOINED, EDGES_ARE_SHADED, MAX_LAMP_MAPS, MAX_SHADOW_MAPS, MAX_SUNS,
};
use crate::light::environment::Environment;
use crate::light::panorama::{EnvironmentLight, MAX_ENVIRONMENT_LIGHTS};
use crate::light::sky::Sky;
use crate::light::sky_visibility::SkyVisibilityGpu;
use crate::scene::FrameState;
use crate::settings::Shading;
use crate::surfaces::material::Bases;
use crate::view::View;
use glam::{Mat4, Vec3};
use leadr_gpu::{
    AddressMode, Commands, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, ResourceSet, Result, Sampler,
    SharedStruct, SpecValue, StructLayout, Topology, shared_struct,
};

const SUNS: usize = MAX_SUNS as usize;
const LAMP_MAPS: usize = MAX_LAMP_MAPS as usize;
const SHADOW_MAPS: usize = MAX_SHADOW_MAPS as usize;

/// The angular radius of the frame's own sun in radians: 0.2665°, the value at the mean distance of the Earth.
pub const SUN_RADIUS: f32 = 4.651e-3;

shared_struct! {
    /// The push constants of a draw that shades the G-buffer.
    pub struct ObjectsByClassGpu for "ObjectsByClass" {
        /// A bit for each object that its own filter pass shades, as in [`Tiles::records`](super::targets::Tiles::records).
        pub by_class: [u32; 2],
    }
}

shared_struct! {
    /// The block with the lights of a frame (`Lighting` in `passes/shade/shade.frag`).
    pub struct LightingGpu for "Lighting" {
        /// The rays through the image, as in [`Camera::rays`](crate::camera::Camera::rays). The near distance is in the last w.
        pub rays: [[f32; 4]; 3],
        /// The matrices from world space to shadow texture space, for the frame's own sun, the suns of the panorama, and the lamps.
        pub shadow_from_world: [[[f32; 4]; 4]; SHADOW_MAPS],
        /// The position of the camera, and the radiance of an emission value of 1.
        pub camera_position: [f32; 4],
        /// The directions toward the suns, and the angular variance of their light.
        pub sun_direction: [[f32; 4]; SUNS],
        /// The irradiance of each sun on a plane that faces it, and the tangent of the sun's angular radius.
        pub sun_irradiance: [[f32; 4]; SUNS],
        /// The shadows of the lamps with maps, as [`Lamp::penumbra`].
        pub lamp_shadow: [[f32; 4]; LAMP_MAPS],
        /// The width and height of the image, and the number of samples along one side of a pixel.
        pub viewport: [f32; 4],
        /// The face size of the cube, 0, the world size of a shadow texel, and the tangent of the lowest elevation at which the
        /// background is looked up in the cube.
        pub environment: [f32; 4],
        /// Extinction of the air per metre, or 0 without an analytic sky.
        pub air: [f32; 4],
        /// Index and random seed of the sample, and the number of lamps.
        pub draws: [u32; 4],
    }
}

/// Returns the extinction of the air per metre under the frame's sky, or 0 without a sky.
pub(super) fn air_of(state: &FrameState) -> Vec3 {
    state.sky.as_ref().map_or(Vec3::ZERO, Sky::extinction)
}

impl LightingGpu {
    /// Returns the block for an image of the scene under an environment with these lamps. `shadows` are the views of the lights with
    /// shadow maps, in order.
    pub fn new(
        state: &FrameState,
        view: &View,
        environment: &Environment,
        lamps: &[Lamp],
        shadows: &[ShadowView],
    ) -> Self {
        let four = |v: Vec3, w: f32| v.extend(w).to_array();
        let mut sun_direction = [[0.0, 0.0, 1.0, 0.0]; SUNS];
        let mut sun_irradiance = [[0.0; 4]; SUNS];
        let suns = suns_of(state, environment).count();
        for (i, light) in suns_of(state, environment).enumerate().take(SUNS) {
            sun_direction[i] = four(light.direction, light.variance);
            sun_irradiance[i] = four(
                light.irradiance,
                if i == 0 && state.sun().is_some() { SUN_RADIUS.tan() } else { light.radius().tan() },
            );
        }
        let mut shadow_from_world = [Mat4::IDENTITY.to_cols_array_2d(); SHADOW_MAPS];
        for (matrix, view) in shadow_from_world.iter_mut().zip(shadows) {
            *matrix = view.texture_from_world.to_cols_array_2d();
        }
        let ([x, y, z], size) = (view.rays(), view.size());
        let mut block = Self {
            rays: [four(x, 0.0), four(y, 0.0), four(z, view.camera.near)],
            shadow_from_world,
            camera_position: four(view.camera.position, state.emission_scale),
            sun_direction,
            sun_irradiance,
            lamp_shadow: [[0.0; 4]; LAMP_MAPS],
            viewport: [size.0 as f32, size.1 as f32, view.grid() as f32, 0.0],
            // The maps of all suns cover the same sphere, and precede the maps of lamps.
            environment: [environment.face_size() as f32, 0.0, shadows.first().map_or(0.0, |s| s.texel), -1e9],
            air: four(air_of(state), 0.0),
            draws: [0, 0, lamps.len() as u32, 0],
        };
        for ((shadow, lamp), view) in block.lamp_shadow.iter_mut().zip(lamps).zip(shadows.iter().skip(suns)) {
            *shadow = lamp.penumbra(view);
        }
        block
    }

    /// Sets the index and the seed for the random draws of the reference.
    #[must_use]
    pub fn with_draws(mut self, sample: u32, seed: u64) -> Self {
        [self.draws[0], self.draws[1]] = [sample, (seed ^ seed >> 32) as u32];
        self
    }

    /// Extends the lowest texels of the sky down to the horizon of a sea, which sinks below eye level as the viewer rises.
    #[must_use]
    pub fn with_sea_horizon(mut self) -> Self {
        // This is the elevation of the lowest texel centres above eye level.
        self.environment[3] = 1.0 / self.environment[0];
        self
    }
}

/// The numbers of lights in a frame. Each combination has its own pipelines, so absent lights cost nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LightSet {
    /// Whether the frame has its own sun.
    pub sun: bool,
    /// The number of lights extracted from the panorama.
    pub panorama: u32,
    /// The number of lamps that can have shadow maps.
    pub lamps: u32,
    /// Whether there are more lamps. Their number does not change the pipelines.
    pub more_lamps: bool,
    /// Whether the lights have shadow maps.
    pub shadows: bool,
}

impl LightSet {
    /// Counts the lights of a frame under an environment. `shadows` is whether they have shadow maps.
    pub fn new(state: &FrameState, environment: &Environment, shadows: bool) -> Self {
        let lamps = state.point_lights.len() + state.more_suns.len();
        let panorama = (environment.lights().len() as u32).min(MAX_ENVIRONMENT_LIGHTS);
        Self {
            sun: state.sun().is_some(),
            panorama,
            lamps: lamps.min(LAMP_MAPS) as u32,
            more_lamps: lamps > LAMP_MAPS,
            shadows,
        }
    }

    /// Counts the directional lights with shadow maps.
    pub fn sun_maps(&self) -> u32 {
        if self.shadows { u32::from(self.sun) + self.panorama } else { 0 }
    }

    /// Counts the lights with shadow maps.
    pub fn shadow_maps(&self) -> u32 {
        if self.shadows { self.sun_maps() + self.lamps } else { 0 }
    }
}

/// Returns the directional lights of a frame in the order of the shaders. The frame's own sun comes first, with zero size, then the
/// panorama's lights.
pub fn suns_of<'a>(
    state: &FrameState,
    environment: &'a Environment,
) -> impl Iterator<Item = EnvironmentLight> + use<'a> {
    let own = state.sun().map(|sun| EnvironmentLight {
        direction: sun.direction.normalize_or(Vec3::Z),
        irradiance: sun.irradiance,
        variance: 0.0,
    });
    own.into_iter().chain(environment.lights().iter().copied().take(MAX_ENVIRONMENT_LIGHTS as usize))
}

/// How the shading pass treats edge samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Edges {
    /// There are no edge samples.
    None = EDGES_ARE_ABSENT as isize,
    /// The pass shades edge samples, except those that [`EdgePass`](super::edges::EdgePass) has marked.
    Shaded = EDGES_ARE_SHADED as isize,
    /// The pass shades pixels whose edge samples were joined before.
    Joined = EDGES_ARE_JOINED as isize,
}

/// The key that selects the pipeline of the shading pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ShadeKind {
    /// How surfaces are shaded. The value is [plain](Shading::plain), because other settings do not affect the pipelines.
    pub shading: Shading,
    /// The lights of the frame.
    pub lights: LightSet,
    /// How the pass treats edge samples.
    pub edges: Edges,
    /// The base materials of the surfaces.
    pub bases: Bases,
    /// Whether the pass outputs the fractions of light that arrive at a pixel, instead of its radiance.
    pub light_visibility: bool,
}

impl ShadeKind {
    /// Returns the specialisation constants of `passes/shade/settings.glsl`.
    pub fn spec(&self) -> Vec<(&'static str, SpecValue)> {
        let Self { shading, lights, edges, bases, light_visibility } = self;
        let lit = [
            ("OWN_SUNS", SpecValue::I32(i32::from(lights.sun))),
            ("PANORAMA_SUNS", SpecValue::I32(lights.panorama as i32)),
            ("MAPPED_SHADOWS", SpecValue::Bool(lights.shadows)),
            ("LAMPS", SpecValue::I32(lights.lamps as i32)),
            ("MORE_LAMPS", SpecValue::Bool(lights.more_lamps)),
            ("EDGES", SpecValue::I32(*edges as i32)),
            ("TELLS_LIGHT", SpecValue::Bool(*light_visibility)),
        ];
        [shading.spec(), lit.to_vec(), bases.spec().to_vec()].concat()
    }
}

/// The structs of the [scene's set](crate::sets::SCENE).
pub const SCENE_STRUCTS: [StructLayout; 3] = [LightingGpu::LAYOUT, LampGpu::LAYOUT, SkyVisibilityGpu::LAYOUT];

fn nearest(gpu: &Arc<Gpu>) -> Result<Sampler> {
    Sampler::new(gpu, Filter::Nearest, AddressMode::ClampToEdge)
}

/// The pipeline that shades the pixels of the G-buffer.
#[derive(Clone)]
pub struct ShadePass {
    pipeline: GraphicsPipeline,
    nearest: Sampler,
}

impl ShadePass {
    /// Creates the pass for one kind.
    pub fn new(gpu: &Arc<Gpu>, kind: ShadeKind) -> Result<Self> {
        // Objects with several classes are shaded by their filter passes.
        let kind = ShadeKind { bases: Bases { classes: 1, ..kind.bases }, ..kind };
        let desc = GraphicsDesc {
            vertex: "passes/shade/shade.vert",
            fragment: Some("passes/shade/shade.frag"),
            colors: &[RADIANCE_FORMAT],
            depth: (kind.edges != Edges::Shaded).then_some(ANY_OBJECT_TEST),
            topology: Topology::Points,
            spec: &kind.spec(),
            structs: &[&SCENE_STRUCTS[..], &[ObjectsByClassGpu::LAYOUT]].concat(),
            ..Default::default()
        };
        Ok(Self { pipeline: GraphicsPipeline::new(gpu, "shade", &desc)?, nearest: nearest(gpu)? })
    }

    /// Shades the surface pixels of a filtered sample into its active radiance target. For edge samples, shades the unmarked ones.
    /// `joined` has the sums of each pixel's edge samples, if any. Tiles that contain only objects of `by_class` are left out.
    pub fn draw(
        &self,
        cmd: &mut Commands,
        sample: &SampleTargets,
        scene: &ResourceSet,
        joined: Option<&JoinedEdges>,
        by_class: [u32; 2],
    ) {
        let SampleTargets { visible, gbuffer, .. } = sample;
        let nearest = &self.nearest;
        // A pipeline without joined edge samples still needs a float image as a placeholder.
        let shares = joined.map_or(&visible.depth, |joined| &joined.shares);
        let more_suns = joined.map_or(&visible.depth, |joined| &joined.more_suns);
        let filtered = [
            ("visible_surface", Descriptor::Sampled(visible.surface.whole(), nearest)),
            ("visible_depth", Descriptor::Sampled(visible.depth.whole(), nearest)),
            ("gbuffer_slopes", Descriptor::Sampled(gbuffer.slopes.whole(), nearest)),
            ("gbuffer_material", Descriptor::Sampled(gbuffer.material.whole(), nearest)),
            ("gbuffer_surface", Descriptor::Sampled(gbuffer.surface.whole(), nearest)),
            ("gbuffer_horizon", Descriptor::Sampled(gbuffer.horizon.whole(), nearest)),
            ("gbuffer_reflection", Descriptor::Sampled(gbuffer.reflection.whole(), nearest)),
            ("gbuffer_emission", Descriptor::Sampled(gbuffer.emission.whole(), nearest)),
            ("shares", Descriptor::Sampled(shares.whole(), nearest)),
            ("more_suns", Descriptor::Sampled(more_suns.whole(), nearest)),
            ("TileRecords", Descriptor::Storage(&visible.tiles.records)),
        ];
        cmd.bind(&self.pipeline, &filtered);
        cmd.bind_set(scene);
        cmd.push_constants(&ObjectsByClassGpu { by_class });
        visible.tiles.draw(cmd);
    }
}

/// The pipeline that draws the sky behind surfaces, which needs few of the inputs of shading.
#[derive(Clone)]
pub struct SkyBehindPass {
    pipeline: GraphicsPipeline,
    nearest: Sampler,
}

impl SkyBehindPass {
    /// Creates the pass. `multisampled` is whether the image has slots for multisampled pixels.
    pub fn new(gpu: &Arc<Gpu>, multisampled: bool) -> Result<Self> {
        let desc = GraphicsDesc {
            vertex: "passes/shade/sky.vert",
            fragment: Some("passes/shade/sky.frag"),
            colors: &[RADIANCE_FORMAT],
            depth: Some(OBJECT_TEST),
            spec: &[("MULTISAMPLED", SpecValue::Bool(multisampled))],
            structs: &SCENE_STRUCTS,
            ..Default::default()
        };
        Ok(Self { pipeline: GraphicsPipeline::new(gpu, "shade sky", &desc)?, nearest: nearest(gpu)? })
    }

    /// Draws the sky pixels into the active radiance target of a sample. Record it after the object depth pass.
    pub fn draw(&self, cmd: &mut Commands, visible: &VisibleSurface, scene: &ResourceSet) {
        cmd.bind(&self.pipeline, &[("visible_surface", Descriptor::Sampled(visible.surface.whole(), &self.nearest))]);
        cmd.bind_set(scene);
        cmd.draw(0..3, 0..1);
    }
}
