//! Shading pass: one invocation per pixel of the G-buffer. Tiles of the screen that show only sky use a cheaper shader.

use std::sync::Arc;

use super::shadow::ShadowView;
use super::targets::{JoinedEdges, RADIANCE_FORMAT, SampleTargets};
use crate::gpu::{
    AddressMode, Buffer, ColorTarget, Commands, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, Image,
    ImageView, Load, Result, Sampler, SharedStruct, SpecValue, Topology, Use, shared_struct,
};
use crate::render::constants::{EDGES_ARE_ABSENT, EDGES_ARE_JOINED, EDGES_ARE_SHADED};
use crate::render::scene::{FrameState, MAX_POINT_LIGHTS};
use crate::render::settings::Shading;
use crate::render::view::View;
use glam::{Mat4, Vec3};

shared_struct! {
    /// The light block (`Lighting` in `passes/shade/shade.frag`).
    pub struct LightingGpu for "Lighting" {
        /// Rays through the image, see [`Camera::rays`](crate::render::camera::Camera::rays); w of the last: the near
        /// plane.
        pub rays: [[f32; 4]; 3],
        /// World to shadow texture space.
        pub shadow_from_world: [[f32; 4]; 4],
        /// Position of the viewer.
        pub camera_position: [f32; 4],
        /// Direction toward the sun.
        pub sun_direction: [f32; 4],
        /// The sun's irradiance on a plane facing it.
        pub sun_irradiance: [f32; 4],
        /// Positions of the point lights.
        pub point_position: [[f32; 4]; MAX_POINT_LIGHTS],
        /// Their intensities.
        pub point_intensity: [[f32; 4]; MAX_POINT_LIGHTS],
        /// Width and height of the image, and its samples along a side of a pixel.
        pub viewport: [f32; 4],
        /// Face size of the cube, its scale, world size of a shadow texel, tangent of the lowest elevation at which the
        /// cube is looked up for the background.
        pub environment: [f32; 4],
    }
}

impl LightingGpu {
    /// The block for an image of the scene under an environment of `cube_size` texels along a face.
    #[must_use]
    pub fn new(state: &FrameState, view: &View, cube_size: u32, shadow: Option<&ShadowView>) -> Self {
        let four = |v: Vec3, w: f32| v.extend(w).to_array();
        let (sun_direction, sun_irradiance) = state.sun.map_or(([0.0, 0.0, 1.0, 0.0], [0.0; 4]), |sun| {
            (four(sun.direction.normalize_or(Vec3::Z), 0.0), four(sun.irradiance, 0.0))
        });
        let ([x, y, z], size) = (view.rays(), view.size());
        let mut block = Self {
            rays: [four(x, 0.0), four(y, 0.0), four(z, view.camera.near)],
            shadow_from_world: shadow.map_or(Mat4::IDENTITY, |s| s.texture_from_world).to_cols_array_2d(),
            camera_position: four(view.camera.position, 1.0),
            sun_direction,
            sun_irradiance,
            point_position: [[0.0; 4]; MAX_POINT_LIGHTS],
            point_intensity: [[0.0; 4]; MAX_POINT_LIGHTS],
            viewport: [size.0 as f32, size.1 as f32, view.grid() as f32, 0.0],
            environment: [cube_size as f32, 1.0, shadow.map_or(0.0, |s| s.texel), -1e9],
        };
        for (i, light) in state.point_lights.iter().take(MAX_POINT_LIGHTS).enumerate() {
            block.point_position[i] = four(light.position, 1.0);
            block.point_intensity[i] = four(light.intensity, 0.0);
        }
        block
    }

    /// Continues the sky's lowest texels below eye level, down to the horizon of a sea, which sinks as the viewer rises.
    #[must_use]
    pub fn with_sea_horizon(mut self) -> Self {
        // Elevation of the middle of the lowest texels above eye level.
        self.environment[3] = 1.0 / self.environment[0];
        self
    }
}

/// The lights of a frame. Pipelines are made for each set, so that absent lights cost nothing.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct LightSet {
    /// A sun.
    pub sun: bool,
    /// Its shadow map.
    pub shadows: bool,
    /// Point lights.
    pub points: u32,
}

impl LightSet {
    /// The lights of a frame, with the sun's shadow map or without.
    #[must_use]
    pub fn new(state: &FrameState, shadows: bool) -> Self {
        let points = state.point_lights.len().min(MAX_POINT_LIGHTS) as u32;
        Self { sun: state.sun.is_some(), shadows, points }
    }
}

/// How the shading pass treats edge samples.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Edges {
    /// The frame has no edge samples.
    None = EDGES_ARE_ABSENT as isize,
    /// It shades edge samples, except those that [`EdgePass`](super::edges::EdgePass) marked.
    Shaded = EDGES_ARE_SHADED as isize,
    /// It shades pixels whose edge samples were joined.
    Joined = EDGES_ARE_JOINED as isize,
}

/// The inputs of the shading pass.
#[derive(Clone, Copy)]
pub struct ShadeInputs<'a> {
    /// The [`LightingGpu`] block.
    pub lighting: &'a Buffer,
    /// The environment cube, with mips.
    pub cube: &'a ImageView,
    /// Its nine SH coefficients of radiance, `vec4` each.
    pub radiance_sh: &'a Buffer,
    /// The shadow map.
    pub shadow_map: &'a Image,
    /// The joined sums of each pixel's edge samples, if there are any.
    pub joined: Option<&'a JoinedEdges>,
}

/// The options that decide the pipelines of the shading pass.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ShadeKind {
    /// How surfaces are shaded; [plain](Shading::plain), since no other setting affects the pipelines.
    pub shading: Shading,
    /// The lights of the frame.
    pub lights: LightSet,
    /// With or without edge samples.
    pub edges: Edges,
}

/// The pipelines of the shading pass.
#[derive(Clone)]
pub struct ShadePass {
    surfaces: GraphicsPipeline,
    /// For tiles without surfaces, which need little of the shading; `None` for edge samples, few of which are shaded.
    sky: Option<GraphicsPipeline>,
    nearest: Sampler,
    trilinear: Sampler,
}

impl ShadePass {
    /// The pass of one kind.
    ///
    /// # Errors
    /// A failed pipeline.
    pub fn new(gpu: &Arc<Gpu>, kind: ShadeKind) -> Result<Self> {
        let ShadeKind { shading, lights, edges } = kind;
        let lit = [
            ("FIRST_LIGHT", SpecValue::I32(i32::from(!lights.sun))),
            ("SUN_SHADOWS", SpecValue::Bool(lights.shadows)),
            ("POINT_LIGHTS", SpecValue::I32(lights.points as i32)),
            ("EDGES", SpecValue::I32(edges as i32)),
        ];
        let spec = [&shading.spec()[..], &lit].concat();
        let pipeline = |name: &str, fragment, spec: &[_]| {
            let desc = GraphicsDesc {
                vertex: "passes/shade/shade.vert",
                fragment: Some(fragment),
                colors: &[RADIANCE_FORMAT],
                topology: Topology::Points,
                spec,
                structs: &[LightingGpu::LAYOUT],
                ..Default::default()
            };
            GraphicsPipeline::new(gpu, name, &desc)
        };
        let sky = || pipeline("shade sky", "passes/shade/sky.frag", &[("SKY", SpecValue::Bool(true))]);
        Ok(Self {
            surfaces: pipeline("shade", "passes/shade/shade.frag", &spec)?,
            sky: (edges != Edges::Shaded).then(sky).transpose()?,
            nearest: Sampler::new(gpu, "nearest", Filter::Nearest, AddressMode::ClampToEdge)?,
            trilinear: Sampler::new(gpu, "environment", Filter::Trilinear, AddressMode::ClampToEdge)?,
        })
    }

    /// Shades every pixel of a filtered sample, or those within a scissor.
    pub fn record(
        &self,
        cmd: &mut Commands,
        sample: &SampleTargets,
        inputs: ShadeInputs<'_>,
        scissor: Option<[u32; 4]>,
    ) {
        let SampleTargets { visible, gbuffer, radiance } = sample;
        cmd.image_barrier(radiance, Use::Undefined, Use::ColorTarget);
        cmd.begin_rendering(&[ColorTarget { view: radiance.whole(), load: Load::Discard }], None);
        if let Some(area) = scissor {
            cmd.scissor(area);
        }
        // Pipelines without joined edge samples still need some float image bound in their place.
        let shares = inputs.joined.map_or(&visible.depth, |joined| &joined.shares);
        let everywhere = [
            ("visible_surface", Descriptor::Sampled(visible.surface.whole(), &self.nearest)),
            ("TileRecords", Descriptor::Storage(&visible.tiles.records)),
            ("lighting", Descriptor::Uniform(inputs.lighting)),
            ("environment_cube", Descriptor::Sampled(inputs.cube, &self.trilinear)),
        ];
        let on_surfaces = [
            ("gbuffer_slopes", Descriptor::Sampled(gbuffer.slopes.whole(), &self.nearest)),
            ("gbuffer_material", Descriptor::Sampled(gbuffer.material.whole(), &self.nearest)),
            ("gbuffer_surface", Descriptor::Sampled(gbuffer.surface.whole(), &self.nearest)),
            ("gbuffer_depth", Descriptor::Sampled(visible.depth.whole(), &self.nearest)),
            ("shares", Descriptor::Sampled(shares.whole(), &self.nearest)),
            ("Irradiance", Descriptor::Storage(inputs.radiance_sh)),
            ("shadow_map", Descriptor::Sampled(inputs.shadow_map.whole(), &self.nearest)),
        ];
        cmd.bind(&self.surfaces, &[&everywhere[..], &on_surfaces].concat());
        visible.tiles.draw(cmd);
        if let Some(sky) = &self.sky {
            cmd.bind(sky, &everywhere);
            visible.tiles.draw(cmd);
        }
        cmd.end_rendering();
    }
}
