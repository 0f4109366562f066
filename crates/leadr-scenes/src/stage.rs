//! A scene that is ready to render, with its objects and their poses at any time.

use std::f32::consts::PI;

use glam::{Vec2, Vec3};

use super::dressed;
use super::height_scale::SampledScale;
use super::placed_light::PlacedLight;
use super::plane::{even, plane};
use super::sphere::scaled_sphere;
use leadr_maps::cache::{MapCache, cached};
use leadr_maps::material::{Input, Material, Relief, RoughnessMeaning};
use leadr_maps::{HeightMap, LeadrMap, procedural};
use leadr_reflectance::color::luminance;
use leadr_render::camera::Camera;
use leadr_render::light::exposure::exposure;
use leadr_render::light::sky::Sky;
use leadr_render::scene::{FactorMap, FrameState, Object, PointLight, Pose, Scene, Sun};
use leadr_render::surfaces::classes::StoredClasses;
use leadr_render::surfaces::displacement::HeightField;
use leadr_render::surfaces::ocean::Ocean;
use leadr_render::surfaces::patch_mesh::PatchMesh;
use leadr_render::surfaces::tessellation::MAX_FACTOR;

/// The standard views of a scene.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Views {
    /// A camera that is close enough to show single bumps.
    pub near: Camera,
    /// A camera whose picture is filled by the scene.
    pub mid: Camera,
    /// A camera in whose picture the scene is small.
    pub far: Camera,
}

/// The distances of a receding camera. Each step multiplies the distance by the same factor.
#[derive(Clone, Copy, Debug, PartialEq, serde::Serialize)]
pub struct Sweep {
    /// The distance at the first step in metres, above 0.
    pub near: f32,
    /// The distance at the last step in metres, above 0.
    pub far: f32,
}

impl Sweep {
    /// Returns the distance in metres at `step` of `steps`. With a single step, the result is the first distance.
    pub fn distance(&self, step: u32, steps: u32) -> f32 {
        let share = f64::from(step) / f64::from(steps.max(2) - 1);
        (f64::from(self.near) * (f64::from(self.far) / f64::from(self.near)).powf(share)) as f32
    }

    /// Returns all distances, in order.
    pub fn distances(self, steps: u32) -> impl Iterator<Item = f32> {
        (0..steps).map(move |step| self.distance(step, steps))
    }
}

/// Returns the angle of a camera orbit in degrees at `step` of `steps` per turn. The step after a full turn equals the first step.
pub fn turntable_degrees(step: u32, steps: u32) -> f32 {
    (360.0 * f64::from(step) / f64::from(steps.max(1))) as f32
}

impl Views {
    /// Returns the distances from the near to the far view along the line of sight of `mid`, for [`Camera::at_distance`].
    pub fn sweep(&self) -> Sweep {
        let distance = |camera: &Camera| camera.position.distance(camera.target);
        Sweep { near: distance(&self.near), far: distance(&self.far) }
    }
}

/// The lights of a stage, in addition to its environment image.
#[derive(Clone, Debug)]
pub struct Lights {
    /// The analytic sky with its sun, unless the environment is an image.
    pub sky: Option<Sky>,
    /// A directional light that replaces the sun of the sky.
    pub sun: Option<Sun>,
    /// Point lights.
    pub points: Vec<PointLight>,
    /// Point lights whose power is relative to the white of the picture.
    pub placed: Vec<PlacedLight>,
    /// The exposure factor for stages without a sky, which is metered from an image, or 1.
    pub metered: f32,
}

impl Default for Lights {
    /// Returns no lights and an exposure of 1.
    fn default() -> Self {
        Self { sky: None, sun: None, points: Vec::new(), placed: Vec::new(), metered: 1.0 }
    }
}

impl Lights {
    /// Returns a sky with its sun.
    pub fn under(sky: &Sky) -> Self {
        Self { sky: Some(*sky), ..Self::default() }
    }
}

/// The lights of a model file. An irradiance of π makes a surface of albedo 1 as bright as an emission of 1.
#[derive(Clone, Debug, Default)]
pub struct OwnLights {
    /// The sun of the file, which replaces the sun of the sky.
    pub sun: Option<Sun>,
    /// The other directional lights.
    pub more_suns: Vec<Sun>,
    /// The point lights and spots.
    pub points: Vec<PointLight>,
}

/// The lowest elevation, in degrees, to which the sun of a model file moves the sun of the sky.
const LEAST_ELEVATION: f32 = 20.0;

/// A function of the time in seconds.
type Timed<T> = Box<dyn Fn(f64) -> T + Send>;

/// The objects of a scene and their motion.
pub struct Stage {
    /// The objects for the renderer.
    pub objects: Vec<Object>,
    /// The standard views, relative to the anchor.
    pub views: Views,
    /// The scene's own lights, in addition to the sky.
    pub points: Vec<PointLight>,
    /// The sea for the renderer, if there is one.
    pub ocean: Option<Ocean>,
    /// The linear albedo below the horizon of the sky.
    pub below_horizon: [f32; 3],
    motion: Timed<Vec<Pose>>,
    anchor: Timed<Vec3>,
    relief: Timed<f32>,
    own_lights: Timed<OwnLights>,
    /// The irradiance of the own lights at the subject, at most π.
    own_irradiance: f32,
    /// The camera of the model file, which does not follow the anchor.
    pub own_camera: Option<Timed<Camera>>,
}

impl Stage {
    /// Creates a stage whose objects move by `motion` (one pose per object) around the point of interest `anchor`. `motion` and `anchor`
    /// are functions of the time in seconds.
    pub fn moving(
        objects: Vec<Object>,
        views: Views,
        motion: impl Fn(f64) -> Vec<Pose> + Send + 'static,
        anchor: impl Fn(f64) -> Vec3 + Send + 'static,
    ) -> Self {
        Self {
            objects,
            views,
            points: Vec::new(),
            ocean: None,
            below_horizon: Sky::default().ground_albedo,
            motion: Box::new(motion),
            anchor: Box::new(anchor),
            relief: Box::new(|_| 1.0),
            own_lights: Box::new(|_| OwnLights::default()),
            own_irradiance: 0.0,
            own_camera: None,
        }
    }

    /// Creates a stage where nothing moves.
    pub fn still(objects: Vec<Object>, views: Views) -> Self {
        let count = objects.len();
        Self::moving(objects, views, move |_| vec![Pose::REST; count], |_| Vec3::ZERO)
    }

    /// Sets the standard views.
    #[must_use]
    pub fn with_views(self, views: Views) -> Self {
        Self { views, ..self }
    }

    /// Sets the linear albedo below the horizon, so that reflections of the ground beyond the scene match its floor.
    #[must_use]
    pub fn with_albedo_below(self, below_horizon: [f32; 3]) -> Self {
        Self { below_horizon, ..self }
    }

    /// Adds an object that does not move.
    #[must_use]
    pub fn with_still(mut self, object: Object) -> Self {
        self.objects.push(object);
        let motion = self.motion;
        let with_rest = move |time: f64| motion(time).into_iter().chain([Pose::REST]).collect();
        Self { motion: Box::new(with_rest), ..self }
    }

    /// Multiplies the displacement by `relief`, a function of the time in seconds.
    pub fn with_relief(self, relief: impl Fn(f64) -> f32 + Send + 'static) -> Self {
        Self { relief: Box::new(relief), ..self }
    }

    /// Adds a sea.
    #[must_use]
    pub fn with_ocean(self, ocean: Ocean) -> Self {
        Self { ocean: Some(ocean), ..self }
    }

    /// Adds point lights.
    #[must_use]
    pub fn with_points(self, points: Vec<PointLight>) -> Self {
        Self { points, ..self }
    }

    /// Adds the lights of a model file, as a function of the time in seconds. Together they have this `irradiance` at the subject, at most
    /// π. Under a sky, the sun of the file replaces the sun of the sky: all lights are then scaled to the brightness of the sky's sun.
    #[must_use]
    pub fn with_own_lights(self, irradiance: f32, lights: impl Fn(f64) -> OwnLights + Send + 'static) -> Self {
        Self { own_lights: Box::new(lights), own_irradiance: irradiance, ..self }
    }

    /// Leaves out the sun of the model file, so that the sun of the sky lights the scene.
    pub fn leave_out_own_sun(&mut self) {
        let own = std::mem::replace(&mut self.own_lights, Box::new(|_| OwnLights::default()));
        let of_sun = own(0.0).sun.map_or(0.0, |sun| sun.irradiance.max_element());
        self.own_irradiance = (self.own_irradiance - of_sun).max(0.0);
        self.own_lights = Box::new(move |time| OwnLights { sun: None, ..own(time) });
    }

    /// Returns the direction of the sky's sun that agrees with the sun of the model file, if there is one. The direction is at least 20°
    /// above the horizon, although the sun of a file may be level or below it.
    pub fn sun_of_sky(&self) -> Option<Vec3> {
        let toward = (self.own_lights)(0.0).sun?.direction;
        let level = toward.truncate().try_normalize().unwrap_or(Vec2::NEG_Y);
        let elevation = toward.z.clamp(-1.0, 1.0).asin().max(LEAST_ELEVATION.to_radians());
        Some((level * elevation.cos()).extend(elevation.sin()))
    }

    /// Adds the camera of the model file.
    #[must_use]
    pub fn with_own_camera(self, camera: impl Fn(f64) -> Camera + Send + 'static) -> Self {
        Self { own_camera: Some(Box::new(camera)), ..self }
    }

    /// Sets the Beckmann roughness of every displaced object to `alpha`, in `(0, 1]`. Smooth objects (eyes, teeth, the floor under the
    /// spheres) keep their roughness.
    pub fn set_roughness(&mut self, alpha: f32) {
        for object in self.objects.iter_mut().filter(|object| object.heights.is_some()) {
            let meshes = std::iter::once(&mut object.mesh).chain(&mut object.coarse_mesh);
            meshes.flat_map(|mesh| &mut mesh.colors).for_each(|color| color[3] = alpha);
            // Vertex colours are multiplied by the map.
            if let Some(map) = &mut object.material {
                map.colors.iter_mut().for_each(|texel| texel[3] = u8::MAX);
            }
        }
    }

    /// Moves the objects and the sea out of the stage, for a renderer that uses the user's cache.
    pub fn take_scene(&mut self) -> Scene {
        let objects = std::mem::take(&mut self.objects);
        Scene { objects, ocean: self.ocean.take(), cache: MapCache::of_user(), ..Scene::default() }
    }

    /// Returns the state at `time`, seen by `camera`. The coordinates of the camera are relative to the anchor.
    pub fn state(&self, time: f64, camera: &Camera, lights: &Lights) -> FrameState {
        let anchor = (self.anchor)(time);
        // Emission and lamps are relative to the white of the picture. The radiance of white depends on the initial exposure, so lamps are
        // visible in the evening.
        let white = lights.sky.as_ref().map_or(lights.metered, exposure).recip();
        let own = (self.own_lights)(time);
        let (unit, added_light) = match (own.sun, &lights.sky) {
            (Some(_), Some(sky)) => {
                let of_sky = luminance(Sun::of(sky).irradiance.as_dvec3()) as f32;
                (of_sky / self.own_irradiance.max(1e-20), 0.0)
            }
            _ => (white, self.own_irradiance / PI),
        };
        let lamps = own.points.into_iter().map(|lamp| PointLight { intensity: lamp.intensity * unit, ..lamp });
        let placed = lights.placed.iter().map(|light| light.lit(white));
        let points = self.points.iter().chain(&lights.points).copied().chain(lamps).chain(placed);
        let scaled = |sun: Sun| Sun { irradiance: sun.irradiance * unit, ..sun };
        let own_sun = own.sun.map(scaled);
        FrameState {
            time,
            camera: Camera { position: camera.position + anchor, target: camera.target + anchor, ..*camera },
            poses: (self.motion)(time),
            anchor,
            sky: lights.sky,
            sun: lights.sun.or(own_sun),
            point_lights: points.collect(),
            more_suns: own.more_suns.into_iter().map(scaled).collect(),
            height_scale: (self.relief)(time),
            emission_scale: white,
            metered: lights.metered,
            added_light,
        }
    }
}

/// The default height difference between map values 0 and 1, in metres.
pub const USUAL_RELIEF: f32 = 0.12;
/// The height factor for generated rock, which is steeper than most scans.
pub const GENERATED_HEIGHT: f32 = 0.6;

/// The slope moments and the height unit of a baked file.
#[derive(Clone, Debug)]
pub struct BakedRelief {
    /// The slope moments of all mip levels.
    pub moments: LeadrMap,
    /// The classes of facets, if the file has several.
    pub classes: Option<StoredClasses>,
    /// Whether heights are in widths of the map, and not in an unknown unit.
    pub in_widths: bool,
    /// Whether the file lacks finer levels, so that a texel of its finest level contains several slopes.
    pub is_reduced: bool,
}

/// The material and the relief of the `plane` and `sphere` scenes.
#[derive(Clone, Debug)]
pub struct ReliefOptions {
    /// One repeat of the heights, as an image with its first row on top; `None` uses a generated rock.
    pub map: Option<HeightMap>,
    /// The slope moments and the height unit of a baked file.
    pub baked: Option<BakedRelief>,
    /// The height difference between map values 0 and 1, in metres, before the frame's factor; `None` uses the baked file's scale or the
    /// default.
    pub height: Option<f32>,
    /// The width of one repeat of the map in metres; `None` uses the scene's default.
    pub repeat: Option<f32>,
    /// The Beckmann roughness `α` of the base material.
    pub roughness: f32,
    /// The number of texels along a tile of the sphere's atlas.
    pub tile: u32,
    /// Factors for the heights of the sphere, over the image of the map.
    pub scale: Option<FactorMap>,
}

impl Default for ReliefOptions {
    fn default() -> Self {
        Self { map: None, baked: None, height: None, repeat: None, roughness: 0.35, tile: 64, scale: None }
    }
}

/// Whether a height is from 0 to 1.
fn is_share(height: &f32) -> bool {
    (0.0..=1.0).contains(height)
}

/// Generates the default relief.
fn rock() -> HeightMap {
    let programs = [procedural::SOURCE, leadr_maps::noise::SOURCE];
    let [width, height] = [1024; 2];
    let make = || procedural::rock(width, height, 1).texels;
    HeightMap { width, height, texels: cached("rock", &programs, (width * height) as usize, is_share, make) }
}

impl ReliefOptions {
    /// Returns the number of metres per unit of the map's heights, if the map repeats every `repeat` metres.
    fn metres_per_unit(&self, repeat: f32) -> f32 {
        let usual = match &self.baked {
            Some(baked) if baked.in_widths => repeat,
            _ if self.map.is_none() => GENERATED_HEIGHT * USUAL_RELIEF,
            _ => USUAL_RELIEF,
        };
        self.height.unwrap_or(usual)
    }

    /// Takes the heights, which repeat, relative to their mean: the mean lies on the mesh, as with materials.
    fn field(&mut self) -> HeightField {
        let mut map = self.map.take().unwrap_or_else(rock);
        let middle = map.mean();
        map.texels.iter_mut().for_each(|height| *height -= middle);
        for texel in
            self.baked.iter_mut().flat_map(|baked| &mut baked.moments.levels).flat_map(|level| &mut level.texels)
        {
            texel.height -= middle;
        }
        for classes in self.baked.iter_mut().flat_map(|baked| &mut baked.classes) {
            classes.lower(middle);
        }
        HeightField::repeating(map)
    }

    /// Takes the relief as a material whose texels contain several slopes. `metres` is the length of a unit of the heights.
    fn take_material(&mut self, metres: f32) -> Material {
        let [red, green, blue, alpha] = self.color();
        let HeightField { map, .. } = self.field();
        Material {
            base_color: Input::constant([red, green, blue]),
            roughness: Input::constant(alpha),
            roughness_meaning: RoughnessMeaning::Alpha,
            relief: Some(Relief { map, scale: Some(metres), in_widths: false, middle: 0.0 }),
            slope_moments: self.baked.take().map(|mut baked| baked.moments.levels.swap_remove(0)),
            ..Material::new("relief")
        }
    }

    fn color(&self) -> [f32; 4] {
        [0.27, 0.23, 0.19, self.roughness]
    }
}

/// The default repeat of maps on the plane in metres.
pub const PLANE_REPEAT: f32 = 2.0;
/// The default repeat of maps on the sphere in metres.
pub const SPHERE_REPEAT: f32 = 1.2;

/// Builds a unit sphere with the relief, which repeats every 1.2 m by default. The moments are computed from the tiles of the sphere.
pub fn sphere_stage(mut relief: ReliefOptions) -> Stage {
    let repeat = relief.repeat.unwrap_or(SPHERE_REPEAT);
    let metres = relief.metres_per_unit(repeat);
    if relief.baked.as_ref().is_some_and(|baked| baked.is_reduced) {
        return dressed::scaled_sphere_stage(
            &relief.take_material(metres),
            Some(repeat),
            relief.tile,
            relief.scale.as_ref(),
        );
    }
    let scale = SampledScale::new(relief.scale.take().as_ref());
    let (mesh, heights) = scaled_sphere(&relief.field(), &scale, repeat, 16, relief.tile, relief.color());
    Stage::still(vec![Object::new("sphere", mesh).with_heights(heights, metres)], sphere_views())
}

/// Returns views of a unit sphere.
pub fn sphere_views() -> Views {
    let from =
        |distance: f32| Camera::looking_at(Vec3::new(0.66, -0.66, 0.35).normalize() * distance, Vec3::ZERO, 30.0);
    Views { near: from(2.2), mid: from(4.8), far: from(36.0) }
}

/// The size of the largest map for which the reference plane has a vertex per texel.
pub const LARGEST_PLANE_MAP: u32 = 4096;

/// Reverses the order of image rows. The top of an image lies toward `+y` of the plane, and so does the end of its texture coordinate `t`.
fn upright<T: Copy>(texels: &mut Vec<T>, width: u32) {
    *texels = texels.chunks_exact(width as usize).rev().flatten().copied().collect();
}

/// Builds an 8 m plane with the relief, which repeats every 2 m by default, upright seen from above with `+y` on top. Its patches allow a
/// vertex per texel, up to four times [`LARGEST_PLANE_MAP`] texels along the plane.
pub fn plane_stage(mut relief: ReliefOptions) -> Stage {
    let repeat = relief.repeat.unwrap_or(PLANE_REPEAT);
    let metres = relief.metres_per_unit(repeat);
    let mut heights = relief.field();
    upright(&mut heights.map.texels, heights.map.width);
    for level in relief.baked.iter_mut().flat_map(|baked| &mut baked.moments.levels) {
        upright(&mut level.texels, level.width);
        // Slopes along t change their sign with the direction of t.
        level
            .texels
            .iter_mut()
            .for_each(|texel| (texel.mean_slope[1], texel.cross) = (-texel.mean_slope[1], -texel.cross));
    }
    let (mesh, coarse) = plane_meshes(heights.map.width.max(heights.map.height), repeat, relief.color());
    let mut object = Object::new("plane", mesh).with_heights(heights, metres);
    object.coarse_mesh = coarse;
    if let Some(BakedRelief { moments, classes, .. }) = relief.baked.take() {
        object.moments = Some(moments);
        object.classes = classes.map(StoredClasses::with_reversed_rows);
    }
    Stage::still(vec![object], plane_views())
}

/// Half the side of the plane in metres.
const PLANE_HALF: f32 = 4.0;
/// The smallest number of patches along the plane that pictures need.
const PLANE_PATCHES: u32 = 32;

/// Builds plane meshes for a map of `texels` per side (or 0) that repeats every `repeat` metres: one mesh that allows a vertex per texel,
/// and a coarser mesh if pictures need less.
pub fn plane_meshes(texels: u32, repeat: f32, color: [f32; 4]) -> (PatchMesh, Option<PatchMesh>) {
    let mesh = |patches| plane(PLANE_HALF, patches, repeat, color, even);
    let most = 2.0 * PLANE_HALF / PLANE_REPEAT * LARGEST_PLANE_MAP.div_ceil(MAX_FACTOR as u32) as f32;
    let fine = 2.0 * PLANE_HALF / repeat * texels.div_ceil(MAX_FACTOR as u32) as f32;
    let patches = (fine.min(most).ceil() as u32).max(PLANE_PATCHES);
    (mesh(patches), (patches > PLANE_PATCHES).then(|| mesh(PLANE_PATCHES)))
}

/// Returns views of the 8 m plane.
pub fn plane_views() -> Views {
    let from = |distance: f32| Camera::looking_at(Vec3::new(0.6, -0.8, 0.55).normalize() * distance, Vec3::ZERO, 35.0);
    Views { near: from(2.0), mid: from(7.0), far: from(60.0) }
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_maps::moments::{Moments, Wrap};

    #[test]
    fn plane_reference_has_one_vertex_per_texel() {
        for (size, patches) in [(64, 32), (504, 32), (512, 36), (1024, 68), (4096, 264)] {
            let map = HeightMap::new(size, 1, (0..size).map(|i| (i % 7) as f32).collect()).unwrap();
            let stage = plane_stage(ReliefOptions { map: Some(map), ..ReliefOptions::default() });
            let object = &stage.objects[0];
            assert_eq!(object.mesh.patches.len(), patches * patches, "{size}");
            let [first, second, ..] = object.mesh.texcoords[0];
            let texels = (second - first).length() * size as f32;
            assert!(texels <= MAX_FACTOR + 1e-3, "{size}: {texels} texels along a patch");
        }
    }

    #[test]
    fn a_height_map_lies_as_in_a_material() {
        let map = HeightMap::new(4, 3, (0..12).map(|i| (i * i) as f32 / 144.0).collect()).unwrap();
        let baked = BakedRelief {
            moments: LeadrMap::new(&map, Wrap::Repeat),
            classes: None,
            in_widths: false,
            is_reduced: false,
        };
        let relief = Relief { map: map.clone(), scale: Some(1.0), in_widths: false, middle: map.mean() };
        let material = Material { relief: Some(relief), ..Material::new("squares") };
        let dressed = dressed::plane_stage(&material, None).objects.remove(0);
        let relief =
            ReliefOptions { map: Some(map), baked: Some(baked), height: Some(1.0), ..ReliefOptions::default() };
        let alone = plane_stage(relief).objects.remove(0);
        let metres = |object: &Object| -> Vec<f32> {
            let texels = &object.heights.as_ref().unwrap().map.texels;
            texels.iter().map(|height| height * object.height_scale).collect()
        };
        let heights = metres(&alone);
        for (found, wanted) in heights.iter().zip(metres(&dressed)) {
            assert!((found - wanted).abs() < 1e-3, "{heights:?}");
        }
        assert!(
            heights.iter().sum::<f32>().abs() < 1e-3 && heights[8] < heights[0],
            "the top row is the last: {heights:?}"
        );
        // The moments of the file are those of the heights as they lie.
        let wanted = LeadrMap::new(&alone.heights.as_ref().unwrap().map, Wrap::Repeat);
        for (level, found) in wanted.levels.iter().zip(&alone.moments.as_ref().unwrap().levels) {
            for (a, b) in level.texels.iter().zip(&found.texels) {
                let numbers = |m: &Moments| [m.mean_slope[0], m.mean_slope[1], m.second[1], m.cross, m.height];
                let off = numbers(a)
                    .iter()
                    .zip(numbers(b))
                    .map(|(a, b)| (a - b).abs() / a.abs().max(1.0))
                    .fold(0.0, f32::max);
                assert!(off < 1e-4, "{a:?} {b:?}");
            }
        }
    }

    #[test]
    fn heights_and_repeats_are_metres() {
        let stage = |relief: ReliefOptions| {
            let map = HeightMap::new(256, 1, (0..256).map(|i| (i % 7) as f32).collect()).ok();
            plane_stage(ReliefOptions { map, ..relief }).objects.remove(0)
        };
        let metres = stage(ReliefOptions { height: Some(0.05), repeat: Some(0.5), ..ReliefOptions::default() });
        assert_eq!((metres.height_scale, stage(ReliefOptions::default()).height_scale), (0.05, USUAL_RELIEF));
        // The plane has 16 repeats of half a metre, each with 5 patches.
        assert_eq!(metres.mesh.patches.len(), 80 * 80);
        let [first, second, ..] = metres.mesh.texcoords[0];
        assert!(((second - first).length() - 0.1 / 0.5).abs() < 1e-5);
        // The limit of patches for the largest map also applies to tiny repeats.
        let most = stage(ReliefOptions { repeat: Some(0.01), ..ReliefOptions::default() }).mesh.patches.len();
        assert_eq!(most, 264 * 264);
        assert_eq!(ReliefOptions::default().metres_per_unit(PLANE_REPEAT), GENERATED_HEIGHT * USUAL_RELIEF);
    }

    #[test]
    fn sweeps_are_geometric() {
        let sweep = Sweep { near: 2.0, far: 32.0 };
        let distances: Vec<f32> = sweep.distances(5).collect();
        for (distance, expected) in distances.iter().zip([2.0, 4.0, 8.0, 16.0, 32.0]) {
            assert!((distance / expected - 1.0).abs() < 1e-6, "{distances:?}");
        }
        assert_eq!(sweep.distances(1).collect::<Vec<_>>(), [2.0]);
        assert_eq!(Sweep { near: 3.0, far: 3.0 }.distance(4, 9), 3.0);
    }

    #[test]
    fn turntable_covers_one_revolution_without_repeat() {
        let degrees: Vec<f32> = (0..5).map(|step| turntable_degrees(step, 5)).collect();
        assert_eq!(degrees, [0.0, 72.0, 144.0, 216.0, 288.0]);
        assert_eq!(turntable_degrees(0, 1), 0.0);
    }

    #[test]
    fn cameras_follow_the_anchor() {
        let views = Views {
            near: Camera::looking_at(Vec3::X, Vec3::ZERO, 30.0),
            mid: Camera::looking_at(Vec3::X * 2.0, Vec3::ZERO, 30.0),
            far: Camera::looking_at(Vec3::X * 9.0, Vec3::ZERO, 30.0),
        };
        let stage = Stage::moving(Vec::new(), views, |_| Vec::new(), |time| Vec3::Y * time as f32);
        let state = stage.state(3.0, &views.mid, &Lights::under(&Sky::default()));
        assert_eq!(state.camera.position, Vec3::new(2.0, 3.0, 0.0));
        assert_eq!(state.camera.target, Vec3::Y * 3.0);
        assert!(state.sun().unwrap().irradiance.min_element() > 0.0);
    }
}
