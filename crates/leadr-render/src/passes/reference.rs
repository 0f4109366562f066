//! The reference with relief shadows, whose supersampled, displaced geometry casts shadows on itself.
//!
//! In every sample, the visible facets are lit by the sun, up to four lamps, the lights of the panorama, and a few directions of
//! the remaining environment. Of more lamps, each sample draws four. All lamps are drawn equally often. Some of these directions are drawn at random for the whole image
//! ([`environment_lights`](super::environment_lights)). The others are drawn for each pixel, from its specular lobe and from its
//! hemisphere. The mean over the samples is the environment with its true visibility.
//!
//! Visibility is computed with one of two methods. If all casters are displaced in one direction, they form a height field, and
//! rays from each pixel are traced through the depth map of this field. Otherwise, the casters are drawn into one depth map for
//! each light of the sample ([`relief_shadow`](super::relief_shadow)). In this case, all draws together estimate the unoccluded
//! environment, and the draws with maps estimate the occluded part.
//!
//! Blocked directions are black, because light is reflected only once. With one map per light, base materials smoother than
//! [`MIRROR_ALPHA`](crate::constants::MIRROR_ALPHA) reflect the environment as if the relief hid only the rays of the viewer.
//! Lights with maps would almost never fall into their narrow lobes.

use std::sync::Arc;

use glam::{Vec2, Vec3};

use super::environment_lights::{EnvironmentLights, light_point};
use super::geometry::CasterKinds;
use super::lamps::{Lamp, lamps_of};
use super::relief_shadow::{Caster, ReliefMaps, ReliefShadowPass, map_size, relief_view};
use super::shade::air_of;
use super::shadow::ShadowView;
use super::targets::{RADIANCE_FORMAT, SampleTargets};
use crate::constants::{
    ENVIRONMENT_DRAWS, LIGHT_DRAWN, LIGHT_OF_ENVIRONMENT, LIGHT_OF_SCENE, MAX_LAMP_MAPS, MAX_RELIEF_LIGHTS,
};
use crate::light::environment::Environment;
use crate::light::panorama::EnvironmentLight;
use crate::scene::FrameState;
use crate::settings::{FresnelForm, RenderSettings, Terms};
use crate::surfaces::material::Bases;
use crate::surfaces::patch_mesh::PosedVertices;
use crate::surfaces::posed::PosedObject;
use crate::surfaces::sphere::Sphere;
use crate::view::View;
use leadr_gpu::{
    AddressMode, Buffer, Commands, Descriptor, Filter, Gpu, GraphicsDesc, GraphicsPipeline, Memory, ResourceSet,
    Result, Sampler, SharedStruct, SpecValue, shared_struct,
};

const MAX_LIGHTS: usize = MAX_RELIEF_LIGHTS as usize;
/// The largest number of lamps in a sample.
const LAMPS: usize = MAX_LAMP_MAPS as usize;

shared_struct! {
    /// A light as the shader reads it (`Light` in `passes/shade/visibility.glsl`).
    #[derive(Default)]
    pub struct ReliefLightGpu for "Light" {
        /// The matrix from world space to texture coordinates and depth in the map.
        pub texture_from_world: [[f32; 4]; 4],
        /// The inverse of `texture_from_world`.
        pub world_from_texture: [[f32; 4]; 4],
        /// The direction towards the light or, if w is 1, the position of a point light.
        pub position: [f32; 4],
        /// The irradiance or intensity in rgb. One of the `LIGHT_` constants is in w.
        pub power: [f32; 4],
        /// The spot cone, as [`Lamp::falloff`].
        pub falloff: [f32; 4],
        /// The reciprocal of the squared range, or 0 without a range.
        pub range: [f32; 4],
        /// The layer of the map, the world size of a texel, the density of the draw per solid angle, and 1 if the light has a map.
        pub map: [f32; 4],
    }
}

shared_struct! {
    /// The block with the lights of a sample (`Lighting`).
    #[derive(Default)]
    pub struct ReliefLightingGpu for "Lighting" {
        /// The matrix from world space to the map of a height field.
        pub field_from_world: [[f32; 4]; 4],
        /// The rays through the image. The near distance is in the last w.
        pub rays: [[f32; 4]; 3],
        /// The position of the camera, and the radiance of an emission value of 1.
        pub camera_position: [f32; 4],
        /// The width and height of the image, and the face size of the environment.
        pub viewport: [f32; 4],
        /// Extinction of the air per metre, or 0 without an analytic sky.
        pub air: [f32; 4],
        /// World size of a map texel, depth of the highest point, and map size in texels, for a height field.
        pub field: [f32; 4],
        /// The number of lights, the number of drawn lights, the face size of the texels from which lights are drawn, and the index
        /// of the sample.
        pub counts: [i32; 4],
        /// The random seed of the draws.
        pub seed: [u32; 4],
        /// The lights.
        pub lights: [ReliefLightGpu; MAX_LIGHTS],
    }
}

/// The key that selects the pipelines of the reference.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub struct ReferenceKind {
    /// The enabled light terms.
    pub terms: Terms,
    /// Whether the base roughness applies in the frame of the facets, instead of the frame of the macrosurface.
    pub facet_frame: bool,
    /// The Fresnel term.
    pub fresnel: FresnelForm,
    /// The base materials of the surfaces.
    pub bases: Bases,
    /// The kinds of surfaces that cast shadows.
    pub casters: CasterKinds,
    /// Whether heights move the surface.
    pub displaced: bool,
    /// Whether the casters form a height field.
    pub height_field: bool,
    /// Whether lights are drawn from the environment.
    pub drawn: bool,
}

/// The pipelines of the reference, for shading and for its shadow maps.
#[derive(Clone)]
pub struct ReferencePass {
    pipeline: GraphicsPipeline,
    shadows: ReliefShadowPass,
    nearest: Sampler,
    trilinear: Sampler,
}

impl ReferencePass {
    /// Creates the pass for one kind.
    pub fn new(gpu: &Arc<Gpu>, kind: ReferenceKind) -> Result<Self> {
        let desc = GraphicsDesc {
            vertex: "passes/fullscreen.vert",
            fragment: Some("passes/shade/reference.frag"),
            colors: &[RADIANCE_FORMAT],
            spec: &[
                &[
                    ("TERMS", SpecValue::I32(kind.terms.bits())),
                    ("FACET_FRAME", SpecValue::Bool(kind.facet_frame)),
                    ("FRESNEL", SpecValue::I32(kind.fresnel as i32)),
                    ("DISPLACED", SpecValue::Bool(kind.displaced)),
                    ("HEIGHT_FIELD", SpecValue::Bool(kind.height_field)),
                    ("DRAWN", SpecValue::Bool(kind.drawn)),
                ][..],
                &kind.bases.spec(),
            ]
            .concat(),
            structs: &[ReliefLightGpu::LAYOUT, ReliefLightingGpu::LAYOUT],
            ..Default::default()
        };
        Ok(Self {
            pipeline: GraphicsPipeline::new(gpu, "reference", &desc)?,
            shadows: ReliefShadowPass::new(gpu, kind.casters)?,
            nearest: Sampler::new(gpu, Filter::Nearest, AddressMode::ClampToEdge)?,
            trilinear: Sampler::new(gpu, Filter::Trilinear, AddressMode::ClampToEdge)?,
        })
    }

    /// Draws the shadow maps for the sample that was last selected in `lights`.
    pub fn record_maps(&self, cmd: &mut Commands, lights: &ReliefLights, casters: &[&PosedObject]) {
        self.shadows.record(cmd, &lights.maps, casters);
    }

    /// Shades every pixel of the sample's G-buffer into its active radiance target. `scene` contains the measured materials.
    pub fn draw(
        &self,
        cmd: &mut Commands,
        sample: &SampleTargets,
        lights: &ReliefLights,
        environment: &Environment,
        scene: &ResourceSet,
    ) {
        let SampleTargets { visible, gbuffer, .. } = sample;
        cmd.bind(
            &self.pipeline,
            &[
                ("gbuffer_slopes", Descriptor::Sampled(gbuffer.slopes.whole(), &self.nearest)),
                ("gbuffer_material", Descriptor::Sampled(gbuffer.material.whole(), &self.nearest)),
                ("gbuffer_surface", Descriptor::Sampled(gbuffer.surface.whole(), &self.nearest)),
                ("gbuffer_reflection", Descriptor::Sampled(gbuffer.reflection.whole(), &self.nearest)),
                ("gbuffer_emission", Descriptor::Sampled(gbuffer.emission.whole(), &self.nearest)),
                ("visible_depth", Descriptor::Sampled(visible.depth.whole(), &self.nearest)),
                ("lighting", Descriptor::Uniform(&lights.block)),
                ("background_cube", Descriptor::Sampled(environment.background(), &self.trilinear)),
                ("depth_maps", Descriptor::Sampled(lights.maps.array(), &self.nearest)),
                ("EnvironmentTexels", Descriptor::Storage(&lights.texels)),
            ],
        );
        cmd.bind_set(scene);
        cmd.draw(0..3, 0..1);
    }
}

/// The lights of a frame, with the maps in which the relief occludes them.
pub struct ReliefLights {
    block: Buffer,
    /// The environment radiance and the density of the draws, for each texel.
    texels: Buffer,
    maps: ReliefMaps,
    environment: Option<EnvironmentLights>,
    panorama: Vec<EnvironmentLight>,
    lamps: Vec<Lamp>,
    face_size: u32,
    /// The bounding sphere of the casters, if any.
    bounds: Option<Sphere>,
    /// The casters as a height field, if they form one.
    field: Option<HeightFieldAxis>,
    /// The number of texels along one side of a map.
    size: u32,
}

/// The displacement direction that all casters share, and their highest extent along it.
#[derive(Clone, Copy, Debug, PartialEq)]
struct HeightFieldAxis {
    axis: Vec3,
    top: f32,
}

impl HeightFieldAxis {
    /// Returns the axis, or `None` if there are no casters or several displacement directions.
    fn of(casters: &[&PosedObject]) -> Option<Self> {
        let axis = casters.first()?.vertices.displaced_along().first()?.normalize_or_zero();
        let mut top = f32::NEG_INFINITY;
        for posed in casters {
            let PosedVertices { positions, .. } = &posed.vertices;
            if posed.vertices.displaced_along().iter().any(|n| n.dot(axis) < 1.0 - 1e-5) {
                return None;
            }
            let highest = positions.iter().map(|p| p.dot(axis)).fold(f32::NEG_INFINITY, f32::max);
            top = top.max(highest + posed.highest_bump());
        }
        Some(Self { axis, top })
    }
}

impl ReliefLights {
    /// Creates the lights of a frame for its casters. The device must be idle, and the environment must already contain the frame's
    /// sky.
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
        let field = HeightFieldAxis::of(casters);
        let panorama: Vec<EnvironmentLight> = environment.lights().to_vec();
        let seen = seen_normals(state.camera.position, casters);
        let receiving = |d: Vec3| {
            let cosines = seen.iter().map(|n| f64::from(n.dot(d).max(0.0))).sum::<f64>();
            LEAST_RECEIVED + cosines / seen.len().max(1) as f64
        };
        let (face_size, environment) = (environment.face_size(), EnvironmentLights::read(environment, receiving)?);
        let lamps = lamps_of(state, None);
        let draws = if environment.is_some() { ENVIRONMENT_DRAWS as usize } else { 0 };
        let lights = usize::from(state.sun().is_some()) + panorama.len() + draws + lamps.len().min(LAMPS);
        let maps = match (bounds, field) {
            (None, _) => 0,
            (Some(_), Some(_)) => 1,
            (Some(_), None) => lights.min(MAX_LIGHTS),
        };
        let table = environment.as_ref().map_or(vec![[0.0; 4]], EnvironmentLights::table);
        let texels = Buffer::new(gpu, "reference environment", size_of_val(&table[..]) as u64, Memory::Upload)?;
        texels.write(0, &table)?;
        Ok(Self {
            block: Buffer::new(gpu, "reference lighting", size_of::<ReliefLightingGpu>() as u64, Memory::Upload)?,
            texels,
            maps: ReliefMaps::new(gpu, casters, size, maps)?,
            environment,
            panorama,
            lamps,
            face_size,
            bounds,
            field,
            size,
        })
    }

    /// Whether the casters form a height field.
    pub const fn is_height_field(&self) -> bool {
        self.field.is_some()
    }

    /// Whether lights are drawn from the environment.
    pub const fn are_drawn(&self) -> bool {
        self.environment.is_some()
    }

    /// Selects the lights of sample `index` in `view`, and sets the views of their maps. `casters` must be the casters passed to
    /// `new`. The device must be idle.
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
        let lights = self.lights_of_sample(state, settings, index);
        let drawn = lights.iter().filter(|light| light.kind == LIGHT_DRAWN).count();
        let mut block = ReliefLightingGpu {
            rays: [x.extend(0.0), y.extend(0.0), z.extend(view.camera.near)].map(|v| v.to_array()),
            camera_position: view.camera.position.extend(state.emission_scale).to_array(),
            viewport: [width as f32, height as f32, self.face_size as f32, 0.0],
            counts: [
                lights.len() as i32,
                drawn as i32,
                self.environment.as_ref().map_or(1, EnvironmentLights::size) as i32,
                index as i32,
            ],
            air: air_of(state).extend(0.0).to_array(),
            seed: [(settings.seed ^ settings.seed >> 32) as u32, 0, 0, 0],
            ..Default::default()
        };
        // The offset of the maps is independent of the sample's position in the pixel.
        let [u, v] = light_point(index, !settings.seed);
        let shift = Vec2::new(u as f32, v as f32) - 0.5;
        let mut views: Vec<ShadowView> = Vec::new();
        if let (Some(bounds), Some(HeightFieldAxis { axis, top })) = (self.bounds, self.field) {
            let view = relief_view(Caster::Directional(axis), bounds, self.size, shift);
            let highest =
                view.texture_from_world.transform_point3(bounds.centre + axis * (top - bounds.centre.dot(axis)));
            block.field_from_world = view.texture_from_world.to_cols_array_2d();
            block.field = [view.texel, highest.z, self.size as f32, 0.0];
            views.push(view);
        }
        for (light, slot) in lights.iter().zip(&mut block.lights) {
            let (position, point) = match light.caster {
                Caster::Directional(direction) => (direction, 0.0),
                Caster::Point(position) => (position, 1.0),
            };
            slot.position = position.extend(point).to_array();
            slot.power = light.power.extend(light.kind as f32).to_array();
            slot.falloff = light.falloff;
            slot.range = [light.inverse_square_range, 0.0, 0.0, 0.0];
            slot.map = [0.0, 0.0, light.density, 0.0];
            if let (Some(bounds), None) = (self.bounds, self.field) {
                let view = relief_view(light.caster, bounds, self.size, shift);
                slot.texture_from_world = view.texture_from_world.to_cols_array_2d();
                slot.world_from_texture = view.texture_from_world.inverse().to_cols_array_2d();
                slot.map = [views.len() as f32, view.texel, light.density, 1.0];
                views.push(view);
            }
        }
        self.maps.point(casters, &views, view.lens(), &settings.tessellation)?;
        self.block.write(0, &[block])
    }

    fn lights_of_sample(&self, state: &FrameState, settings: &RenderSettings, index: u32) -> Vec<SampleLight> {
        let light = |caster, power, kind| SampleLight {
            caster,
            power,
            kind,
            density: 0.0,
            falloff: [0.0, 0.0, 0.0, 1.0],
            inverse_square_range: 0.0,
        };
        let mut lights = Vec::new();
        if let Some(sun) = state.sun() {
            let direction = sun.direction.normalize_or(Vec3::Z);
            lights.push(light(Caster::Directional(direction), sun.irradiance, LIGHT_OF_SCENE));
        }
        // In each sample, a panorama light has a different direction from its disk.
        for (number, taken) in self.panorama.iter().enumerate() {
            let [u, v] = light_point(index, settings.seed ^ (number as u64 + 1) << 32);
            let direction = taken.direction_within([u as f32, v as f32]);
            lights.push(light(Caster::Directional(direction), taken.irradiance, LIGHT_OF_ENVIRONMENT));
        }
        if let Some(environment) = &self.environment {
            let draws = ENVIRONMENT_DRAWS as u32;
            for draw in 0..draws {
                let drawn = environment.draw(light_point(index * draws + draw, settings.seed));
                let caster = Caster::Directional(drawn.direction);
                lights.push(SampleLight { density: drawn.density, ..light(caster, drawn.irradiance, LIGHT_DRAWN) });
            }
        }
        let drawn = drawn_lamps(self.lamps.len(), index, settings.seed);
        let scale = self.lamps.len() as f32 / drawn.len().max(1) as f32;
        lights.extend(drawn.into_iter().map(|number| {
            let Lamp { caster, power, falloff, inverse_square_range, .. } = self.lamps[number];
            SampleLight { falloff, inverse_square_range, ..light(caster, scale * power, LIGHT_OF_SCENE) }
        }));
        lights.truncate(MAX_LIGHTS);
        lights
    }
}

/// Returns the numbers of the lamps of sample `index`: all of them or, of more than [`LAMPS`], the next in an endless sequence of
/// permutations. A sequence without permutations would light a part of each pixel by the same lamps in all samples.
fn drawn_lamps(count: usize, index: u32, seed: u64) -> Vec<usize> {
    if count <= LAMPS {
        return (0..count).collect();
    }
    let nth = |i: usize| {
        let (cycle, at) = ((i / count) as u64, i % count);
        let mut order: Vec<usize> = (0..count).collect();
        order.sort_by_cached_key(|&lamp| hashed(seed ^ hashed(cycle << 32 | lamp as u64)));
        order[at]
    };
    (0..LAMPS).map(|i| nth(index as usize * LAMPS + i)).collect()
}

/// Returns 64 random bits of a number (SplitMix64: Steele, Lea and Flood 2014).
const fn hashed(number: u64) -> u64 {
    let z = number.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let z = (z ^ z >> 30).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    let z = (z ^ z >> 27).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ z >> 31
}

struct SampleLight {
    caster: Caster,
    power: Vec3,
    /// The type of the light, as one of the `LIGHT_` constants.
    kind: i32,
    /// The density of a drawn light per solid angle.
    density: f32,
    falloff: [f32; 4],
    inverse_square_range: f32,
}

/// The smallest weight of a direction from which lights are drawn. Bumps may face a direction that lights no visible smooth
/// surface.
const LEAST_RECEIVED: f64 = 0.15;
/// The maximum number of normals that [`seen_normals`] returns.
const SEEN_NORMALS: usize = 64;

/// Returns some of the vertex normals that face the viewer.
fn seen_normals(eye: Vec3, casters: &[&PosedObject]) -> Vec<Vec3> {
    let vertices = casters.iter().flat_map(|posed| posed.vertices.positions.iter().zip(&posed.vertices.normals));
    let seen: Vec<Vec3> = vertices.filter(|&(&p, n)| n.dot(eye - p) > 0.0).map(|(_, &n)| n).collect();
    let stride = seen.len().div_ceil(SEEN_NORMALS).max(1);
    seen.into_iter().step_by(stride).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::light::panorama::EnvironmentLight;

    #[test]
    fn all_lamps_are_drawn_equally_often() {
        assert_eq!(drawn_lamps(3, 7, 1), [0, 1, 2]);
        for count in [5, 8, 13] {
            let mut drawn = vec![0; count];
            for index in 0..count as u32 {
                drawn_lamps(count, index, 9).into_iter().for_each(|lamp| drawn[lamp] += 1);
            }
            assert_eq!(drawn, vec![LAMPS; count]);
        }
        assert_ne!(drawn_lamps(16, 0, 1), drawn_lamps(16, 4, 1));
    }

    #[test]
    fn panorama_light_directions_have_its_spread() {
        let light = EnvironmentLight {
            direction: Vec3::new(0.3, -0.4, 0.8).normalize(),
            irradiance: Vec3::ONE,
            variance: 4e-4,
        };
        let (mut sum, mut square, n) = (Vec3::ZERO, 0.0, 1024);
        for index in 0..n {
            let [u, v] = light_point(index, 5);
            let d = light.direction_within([u as f32, v as f32]);
            assert!((d.length() - 1.0).abs() < 1e-5);
            sum += d / n as f32;
            square += f64::from(d.reject_from(light.direction).length_squared()) / f64::from(n);
        }
        assert!(sum.normalize().angle_between(light.direction) < 2e-4, "{sum}");
        // The mean squared distance is the sum of the variances along two axes.
        assert!((square / 8e-4 - 1.0).abs() < 0.01, "{square}");
    }
}
