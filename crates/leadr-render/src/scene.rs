//! The data that a scene hands to the renderer: objects, made once, and the state of each frame.

use std::sync::Arc;

use super::camera::Camera;
use super::constants::CHARTS;
use super::light::exposure;
use super::light::sky::Sky;
use super::surfaces::displacement::HeightField;
use super::surfaces::moments::MomentFormat;
use super::surfaces::ocean::Ocean;
use super::surfaces::patch_mesh::{PatchMesh, PosedVertices};
use super::surfaces::skinning;
use glam::{Affine2, Affine3A, Mat4, Vec2, Vec3};
use leadr_maps::LeadrMap;
use leadr_maps::cache::MapCache;
use leadr_maps::material::TextureWrap;
use leadr_reflectance::materials::fitted_table::FittedTable;

/// A property of a surface over texture coordinates.
#[derive(Clone, Debug)]
pub struct PropertyMap<T> {
    /// Texels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Row by row.
    pub texels: Vec<T>,
    /// What lies beyond the edges, across and down; in an atlas that is the atlas's business.
    pub wrap: [TextureWrap; 2],
}

/// Texture coordinates of the corners of a triangle for each kind of image: see the `CHART_` constants.
pub type TriangleCharts = [[Vec2; 3]; CHARTS as usize];

impl Holes {
    /// What is compared, or the share.
    pub const fn map(&self) -> &PropertyMap<f32> {
        match self {
            Self::Mask(map) | Self::Share(map) => map,
        }
    }
}

/// The material of a surface over its texture coordinates.
#[derive(Clone, Debug, Default)]
pub struct MaterialMap {
    /// Texels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// sRGB-encoded albedo in rgb; in a the [code](leadr_maps::material::alpha_code) of the Beckmann roughness `α`.
    pub colors: Vec<[u8; 4]>,
    /// sRGB-encoded reflectance at normal incidence in rgb, in as many texels, instead of the object's own.
    pub f0: Option<Vec<[u8; 4]>>,
    /// The `α` from which texels count as rough and are filtered in a class of their own, with mirrors of its own
    /// ([`mixed_roughness`](leadr_reflectance::facets::mixed_roughness)), which takes time.
    pub two_lobes: Option<f32>,
    /// The facets of a measured material, whose slopes are scaled where the roughness differs from
    /// [its own](FittedTable::alpha).
    pub fit: Option<Arc<FittedTable>>,
    /// What lies beyond the edges of colours and reflectance.
    pub wrap: [TextureWrap; 2],
    /// Emitted radiance, linear; each frame multiplies it by [`FrameState::emission_scale`].
    pub emission: Option<PropertyMap<[f32; 3]>>,
    /// Share of the surroundings that a place sees past what is large, 0 to 1: multiplies the accessibility of the vertices.
    pub occlusion: Option<PropertyMap<f32>>,
    /// Instead of the share alone, the cone in which a place sees its surroundings: its mean open direction in the frame of `s`, the other
    /// way of `t`, and the normal, as long as the cone is narrow; and the share
    /// ([`Cone::of_vector`](leadr_reflectance::masking::occlusion::Cone::of_vector)). Not for atlases of tiles. Such a surface has no horizon of its heights.
    pub cones: Option<PropertyMap<[f32; 4]>>,
    /// Where the surface has holes.
    pub opacity: Option<Holes>,
}

/// Where a surface has holes.
#[derive(Clone, Debug)]
pub enum Holes {
    /// Where this is below one half; between texels it is interpolated.
    Mask(PropertyMap<f32>),
    /// Everywhere to a degree: this share of the samples of a place sees the surface.
    Share(PropertyMap<f32>),
}

impl MaterialMap {
    /// Albedo and roughness, one lobe under every pixel.
    pub fn new(width: u32, height: u32, colors: Vec<[u8; 4]>) -> Self {
        Self { width, height, colors, ..Self::default() }
    }
}

/// What coordinates a [`Detail`] follows.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DetailMapping {
    /// The texture coordinates of the mesh. Not for atlases of tiles, whose coordinates end with a patch.
    Texcoords,
    /// Places of the mesh at rest, seen along the three axes and blended by the normal; one unit of the coordinates covers so many metres.
    Triplanar(f32),
}

/// What the colours and the roughness of a [`Detail`] do.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DetailColors {
    /// Its colours over their mean multiply those of the surface; its roughness replaces the surface's.
    Vary,
    /// They replace those of the surface, and so does this reflectance at normal incidence.
    Cover(f32),
}

/// How much there is of a [`Detail`].
#[derive(Clone, Debug)]
pub struct DetailMask {
    /// Texels per row.
    pub width: u32,
    /// Rows.
    pub height: u32,
    /// Factors of its slopes and of its cover, 0 to 1.
    pub texels: Vec<f32>,
    /// From the surface's coordinates to the mask's own.
    pub transform: Affine2,
}

/// A tiling relief over a surface, finer than its own: their slopes add up. It shades; it does not displace.
#[derive(Clone, Debug)]
pub struct Detail {
    /// Its heights in metres; they repeat.
    pub heights: HeightField,
    /// Its slopes in metres per unit of its own coordinates, one for each texel of `heights`, instead of those of the heights.
    pub slopes: Option<Vec<[f32; 2]>>,
    /// What it is made of, over its own coordinates; without it the surface keeps its colours.
    pub material: Option<(MaterialMap, DetailColors)>,
    /// What coordinates it follows.
    pub mapping: DetailMapping,
    /// From those to its own, in which it repeats after 1.
    pub transform: Affine2,
    /// Where it is; everywhere without one.
    pub mask: Option<DetailMask>,
}

/// How maps that repeat cover a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tiling {
    /// Side by side.
    #[default]
    Repeats,
    /// By example: pieces of them, no two of which are neighbours in the map, are blended so that mean and covariance stay
    /// ([`leadr_reflectance::slopes::tiling`]). Of meshes of quads without seams, on which patches have the same texture coordinates where they
    /// meet, and whose maps lie on these coordinates and repeat; others take it for [`Repeats`](Self::Repeats).
    ByExample,
    /// Side by side as well, by the shaders of [`ByExample`](Self::ByExample), of the same meshes: a scene that has both makes fewer pipelines.
    OneLook,
    /// The same as [`ByExample`](Self::ByExample), staying where it is in the world however the mesh moves along itself: on planes wherever that is, on others by whole repeats.
    ByExampleInWorld,
    /// The same in the world, under the drifts and paths of open ground, which planes alone have.
    Ground,
}

/// One displaced (or smooth) surface.
#[derive(Clone, Debug)]
pub struct Object {
    /// Name for messages and debugging.
    pub name: String,
    /// Its patches.
    pub mesh: PatchMesh,
    /// The same surface in fewer patches, with the same joints and the same texture coordinates. A smooth one is drawn where the patches of
    /// `mesh` are smaller than pixels; a displaced one wherever its own can be divided finely enough. Not for atlases, details that are
    /// seen along the axes, and materials with charts of their own, which are made for the patches of one mesh.
    pub coarse_mesh: Option<PatchMesh>,
    /// Heights along the patch normals; `None` for a smooth surface.
    pub heights: Option<HeightField>,
    /// Slopes of the heights by texture coordinate, in the heights' unit, one for each texel of `heights`: finer ones than those of the
    /// heights themselves, as a normal map tells them. The heights still displace. Those of triangles are rise over run, since their
    /// texture coordinates are of any size.
    pub slopes: Option<Vec<[f32; 2]>>,
    /// Moments of the slopes on all levels, as a baked file has them, instead of those that follow from `heights` or `slopes`. Their
    /// heights are those of `heights`, which repeat or go on as a single map does.
    pub moments: Option<LeadrMap>,
    /// Further variance of the slopes about them, `(ss, tt, st)` in squares of their unit, one for each of `slopes`: a base that is rougher along one direction.
    pub slope_spread: Option<Vec<[f32; 3]>>,
    /// How its maps cover it.
    pub tiling: Tiling,
    /// A finer relief that repeats.
    pub detail: Option<Detail>,
    /// Metres of displacement per unit of `heights` (`η`); each frame multiplies it by its own factor.
    pub height_scale: f32,
    /// Its material; without it the colours of the vertices are used.
    pub material: Option<MaterialMap>,
    /// Texture coordinates of each triangle in the images of the material, where they are not those of the mesh, which then lead
    /// the slopes alone. For meshes of triangles.
    pub charts: Option<Vec<TriangleCharts>>,
    /// Reflectance at normal incidence; of what has albedo, where the material tells more. Below 0.02 reflection fades at all angles,
    /// and at 0 nothing is reflected.
    pub specular_f0: f32,
    /// How far its reflectance dips below Schlick's form on its way to grazing incidence, 0 to 4
    /// ([`fresnel_dipped`](leadr_reflectance::facets::fresnel::fresnel_dipped)), in steps of 4/31. For surfaces that are one metal all
    /// over: a dielectric would reflect less than nothing.
    pub conductor_dip: [f32; 3],
    /// What lies beyond the edges of its slopes, across and down, where the border of its heights does not say so.
    pub slope_wrap: Option<[TextureWrap; 2]>,
    /// Whether what it emits is multiplied with the colours of the vertices.
    pub tints_emission: bool,
    /// Whether only its front is seen: the side from which its triangles run counter-clockwise. Shadows fall from both.
    pub front_only: bool,
    /// Whether to keep how its colours follow its relief, if they do: weighted means beside its material, for
    /// [`ShadingOptions::relief_color`](crate::settings::ShadingOptions::relief_color).
    pub follows_relief: bool,
    /// Whether it casts a shadow.
    pub casts_shadow: bool,
    /// Number of times it is drawn, each with a pose of its own. The copies share mesh and maps on the device.
    pub instances: u32,
}

impl Object {
    /// A smooth surface in the colours of its vertices that reflects like common dielectrics and casts a shadow.
    pub fn new(name: impl Into<String>, mesh: PatchMesh) -> Self {
        Self {
            name: name.into(),
            mesh,
            coarse_mesh: None,
            heights: None,
            slopes: None,
            moments: None,
            slope_spread: None,
            tiling: Tiling::Repeats,
            detail: None,
            height_scale: 1.0,
            material: None,
            charts: None,
            specular_f0: 0.04,
            conductor_dip: [0.0; 3],
            slope_wrap: None,
            tints_emission: false,
            front_only: false,
            follows_relief: false,
            casts_shadow: true,
            instances: 1,
        }
    }

    /// The same, drawn in so many poses.
    #[must_use]
    pub fn with_instances(self, instances: u32) -> Self {
        Self { instances, ..self }
    }

    /// The same, whose colours may be those of what is seen and lit
    /// ([`ShadingOptions::relief_color`](crate::settings::ShadingOptions::relief_color)).
    #[must_use]
    pub fn with_relief_color(self) -> Self {
        Self { follows_relief: true, ..self }
    }

    /// The same, drawn as `mesh` where that suffices ([`coarse_mesh`](Self::coarse_mesh)).
    #[must_use]
    pub fn with_coarse_mesh(self, mesh: PatchMesh) -> Self {
        Self { coarse_mesh: Some(mesh), ..self }
    }

    /// The same, displaced along the patch normals by `scale` times the heights.
    #[must_use]
    pub fn with_heights(self, heights: HeightField, scale: f32) -> Self {
        Self { heights: Some(heights), height_scale: scale, ..self }
    }

    /// The same, shaded by these slopes of its heights. Called after [`with_heights`](Self::with_heights).
    #[must_use]
    pub fn with_slopes(self, slopes: Vec<[f32; 2]>) -> Self {
        Self { slopes: Some(slopes), ..self }
    }

    /// The same, shaded by ready moments of its heights. Called after [`with_heights`](Self::with_heights).
    #[must_use]
    pub fn with_moments(self, moments: LeadrMap) -> Self {
        Self { moments: Some(moments), ..self }
    }

    /// The same with further variance about those slopes. Called after [`with_slopes`](Self::with_slopes).
    #[must_use]
    pub fn with_slope_spread(self, spread: Vec<[f32; 3]>) -> Self {
        Self { slope_spread: Some(spread), ..self }
    }

    /// The same, whose maps cover it otherwise than side by side.
    #[must_use]
    pub fn with_tiling(self, tiling: Tiling) -> Self {
        Self { tiling, ..self }
    }

    /// The same with a finer relief that repeats.
    #[must_use]
    pub fn with_detail(self, detail: Detail) -> Self {
        Self { detail: Some(detail), ..self }
    }

    /// The same, made of a material whose albedo and roughness are multiplied with those of the vertices.
    #[must_use]
    pub fn with_material(self, map: MaterialMap) -> Self {
        Self { material: Some(map), ..self }
    }

    /// The same with texture coordinates of their own for the images of its material.
    #[must_use]
    pub fn with_charts(self, charts: Vec<TriangleCharts>) -> Self {
        Self { charts: Some(charts), ..self }
    }

    /// The same with another reflectance at normal incidence.
    #[must_use]
    pub fn with_specular_f0(self, specular_f0: f32) -> Self {
        Self { specular_f0, ..self }
    }

    /// The same with the dip of a conductor.
    #[must_use]
    pub fn with_conductor_dip(self, conductor_dip: [f32; 3]) -> Self {
        Self { conductor_dip, ..self }
    }

    /// The same without casting a shadow on other surfaces.
    #[must_use]
    pub fn without_shadow(self) -> Self {
        Self { casts_shadow: false, ..self }
    }
}

/// The contents of a scene: surfaces that do not change from frame to frame except for their poses and waves.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// Meshes.
    pub objects: Vec<Object>,
    /// The sea, if there is one.
    pub ocean: Option<Ocean>,
    /// Where what takes long to find in the maps of the meshes is kept for the next time; `None`: nowhere.
    pub cache: Option<MapCache>,
    /// How the slopes of the meshes are kept.
    pub map_precision: MomentFormat,
}

impl From<Vec<Object>> for Scene {
    /// Objects without a sea.
    fn from(objects: Vec<Object>) -> Self {
        Self { objects, ..Self::default() }
    }
}

impl From<Ocean> for Scene {
    /// The open sea without objects.
    fn from(ocean: Ocean) -> Self {
        Self { ocean: Some(ocean), ..Self::default() }
    }
}

/// Where an object is in one frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Pose {
    /// Rigid: world from rest.
    Rigid(Affine3A),
    /// Linear blend skinning: world from rest, one matrix per joint.
    Skinned(Vec<Mat4>),
    /// Every vertex in the world, with unit normals.
    Vertices(PosedVertices),
}

/// A directional light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// Unit direction toward the sun.
    pub direction: Vec3,
    /// Irradiance on a plane facing it, linear rgb.
    pub irradiance: Vec3,
}

impl Sun {
    /// The sun of a sky, attenuated by its air.
    pub fn of(sky: &Sky) -> Self {
        let direction = sky.sun_direction.normalize_or(Vec3::Z);
        Self { direction, irradiance: Vec3::from_array(sky.sun_irradiance()) }
    }
}

/// A point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// World position.
    pub position: Vec3,
    /// Radiant intensity, linear rgb: the irradiance at distance 1.
    pub intensity: Vec3,
    /// Where it shines; `None` in all directions.
    pub cone: Option<Cone>,
    /// Metres at which it has faded to nothing, as `KHR_lights_punctual` has it; `None` if it never does.
    pub range: Option<f32>,
    /// Metres from its middle to its rim, which make the penumbrae of its shadows wide; 0 for a point. It shines as a point does.
    pub radius: f32,
}

/// Where a spot shines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// Its middle, unit.
    pub axis: Vec3,
    /// Angle from the axis up to which it has its full intensity, radians, below the outer one.
    pub inner_angle: f32,
    /// Angle from the axis at which it ends, radians, at most π/2.
    pub outer_angle: f32,
}

impl PointLight {
    /// A point that shines in all directions, however far.
    pub const fn new(position: Vec3, intensity: Vec3) -> Self {
        Self { position, intensity, cone: None, range: None, radius: 0.0 }
    }

    /// The same with a radius, metres.
    #[must_use]
    pub const fn with_radius(self, radius: f32) -> Self {
        Self { radius, ..self }
    }

    /// What its intensity is multiplied with toward a direction away from it: the square of `d · xyz + w`, kept in 0 to 1.
    pub(super) fn falloff(&self) -> [f32; 4] {
        let Some(Cone { axis, inner_angle, outer_angle }) = self.cone else { return [0.0, 0.0, 0.0, 1.0] };
        let (inner, outer) = (inner_angle.cos(), outer_angle.cos());
        let scale = (inner - outer).max(1e-3).recip();
        (axis * scale).extend(-outer * scale).to_array()
    }

    /// One over the square of its range; 0 without one.
    pub(super) fn inverse_square_range(&self) -> f32 {
        self.range.map_or(0.0, |range| (range * range).max(1e-20).recip())
    }
}

/// Largest number of point lights in a frame.
pub const MAX_POINT_LIGHTS: usize = super::constants::MAX_POINT_LIGHTS as usize;

/// The state of one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameState {
    /// Time of the waves, seconds.
    pub time: f64,
    /// The viewer.
    pub camera: Camera,
    /// One pose per instance of each object of the scene, in their order. Instances without a pose are not drawn.
    pub poses: Vec<Pose>,
    /// The place that moves along with what is looked at.
    pub anchor: Vec3,
    /// The sky, when it is the environment; the cube map follows it.
    pub sky: Option<Sky>,
    /// Directional light, if any.
    pub sun: Option<Sun>,
    /// Point lights, at most [`MAX_POINT_LIGHTS`].
    pub point_lights: Vec<PointLight>,
    /// Multiplies the height scale of every object.
    pub height_scale: f32,
    /// Radiance of an emission of 1.
    pub emission_scale: f32,
    /// Exposure factor for viewing the picture where no sky decides it.
    pub metered: f32,
}

impl FrameState {
    /// The view of `camera` on objects in their `poses` at time 0, with unscaled heights, lit by the renderer's environment
    /// alone.
    pub fn new(camera: Camera, poses: Vec<Pose>) -> Self {
        Self {
            time: 0.0,
            camera,
            poses,
            anchor: Vec3::ZERO,
            sky: None,
            sun: None,
            point_lights: Vec::new(),
            height_scale: 1.0,
            emission_scale: 1.0,
            metered: 1.0,
        }
    }

    /// The same frame under a sky and its sun.
    #[must_use]
    pub fn under(self, sky: &Sky) -> Self {
        Self { sky: Some(*sky), sun: Some(Sun::of(sky)), ..self }
    }

    /// Exposure factor for viewing the picture: chosen by the sky's sun, and under any other light what was metered.
    pub fn exposure(&self) -> f32 {
        self.sky.as_ref().map_or(self.metered, exposure::exposure)
    }
}

impl Pose {
    /// The pose in which the mesh was made.
    pub const REST: Self = Self::Rigid(Affine3A::IDENTITY);

    /// Poses a mesh. Joints beyond the pose's own are ignored.
    pub fn apply(&self, mesh: &PatchMesh) -> PosedVertices {
        match self {
            Self::Rigid(world) => {
                let normal_matrix = world.matrix3.inverse().transpose();
                PosedVertices::new(
                    mesh.positions.iter().map(|&p| world.transform_point3(p)).collect(),
                    mesh.normals.iter().map(|&n| (normal_matrix * n).normalize_or(Vec3::Z)).collect(),
                )
            }
            Self::Skinned(joints) => skinning::skin(mesh, joints),
            Self::Vertices(vertices) => vertices.clone(),
        }
    }
}
