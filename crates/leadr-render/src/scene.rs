//! The input of the renderer: objects, which are uploaded once, and the state of each frame.

use std::sync::Arc;

use super::camera::Camera;
use super::constants::CHARTS;
use super::light::exposure;
use super::light::sky::Sky;
use super::surfaces::classes::StoredClasses;
use super::surfaces::displacement::HeightField;
use super::surfaces::moments::MomentFormat;
use super::surfaces::ocean::Ocean;
use super::surfaces::patch_mesh::{PatchMesh, PosedVertices};
use super::surfaces::skinning;
use crate::named_enum;
use glam::{Affine2, Affine3A, Mat4, Vec2, Vec3};
use leadr_maps::LeadrMap;
use leadr_maps::cache::MapCache;
use leadr_maps::material::TextureWrap;
use leadr_reflectance::materials::fitted_table::FittedTable;

/// A property of a surface, stored over texture coordinates.
#[derive(Clone, Debug)]
pub struct PropertyMap<T> {
    /// The number of texels per row.
    pub width: u32,
    /// The number of rows.
    pub height: u32,
    /// The texels, row by row.
    pub texels: Vec<T>,
    /// The horizontal and vertical wrap modes. An atlas ignores them.
    pub wrap: [TextureWrap; 2],
}

/// The texture coordinates of a triangle's corners, for each type of image in the `CHART_` constants.
pub type TriangleCharts = [[Vec2; 3]; CHARTS as usize];

impl Cutout {
    /// Returns the opacity map, which both variants have.
    pub const fn map(&self) -> &PropertyMap<f32> {
        match self {
            Self::Mask(map) | Self::Share(map) => map,
        }
    }
}

/// The material of a surface over its texture coordinates.
#[derive(Clone, Debug, Default)]
pub struct MaterialMap {
    /// The number of texels per row.
    pub width: u32,
    /// The number of rows.
    pub height: u32,
    /// The sRGB-encoded albedo in rgb. The alpha channel is the [code](leadr_maps::material::alpha_code) of the Beckmann roughness
    /// `α`.
    pub colors: Vec<[u8; 4]>,
    /// The sRGB-encoded reflectance at normal incidence, at the resolution of `colors`, which replaces the object's own value.
    pub f0: Option<Vec<[u8; 4]>>,
    /// The facets of a measured material, whose slopes are scaled where the roughness of a texel differs from [the
    /// material's](FittedTable::alpha).
    pub fit: Option<Arc<FittedTable>>,
    /// The wrap modes of the colours and of the reflectance.
    pub wrap: [TextureWrap; 2],
    /// The linear emitted radiance. Each frame multiplies it by [`FrameState::emission_scale`].
    pub emission: Option<PropertyMap<[f32; 3]>>,
    /// The ambient accessibility at a large scale, from 0 (hidden) to 1 (open), which multiplies the accessibility of the vertices.
    pub occlusion: Option<PropertyMap<f32>>,
    /// Cones of ambient visibility, which are used instead of `occlusion` alone. The mean open direction is in xyz, in the frame of
    /// `s`, `-t` and the normal, and it is longer for narrower cones. The accessibility is in w
    /// ([`Cone::of_vector`](leadr_reflectance::masking::occlusion::Cone::of_vector)). Where `s` and `t` are not orthogonal, the frame
    /// is the [orthonormal](crate::surfaces::atlas::frames::orthonormal) one nearest to them. A surface with cones gets no horizon from
    /// its heights.
    pub cones: Option<PropertyMap<[f32; 4]>>,
    /// The alpha mask or the partial coverage.
    pub opacity: Option<Cutout>,
    /// The clear coat over the texture coordinates of the colours, which replaces the weight and the roughness of the object's
    /// [coat](Object::coat). Tile atlases do not support it.
    pub coat: Option<PropertyMap<CoatTexel>>,
}

/// A texel of a clear coat.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct CoatTexel {
    /// The covered fraction of the surface, from 0 to 1.
    pub weight: f32,
    /// The Beckmann roughness.
    pub alpha: f32,
    /// The slopes of the coat along `s` and `t`, as rise over run. Only a [smooth](CoatRelief::Smooth) coat uses them.
    pub slope: [f32; 2],
}

/// The cutout of a surface, as a mask or as coverage.
#[derive(Clone, Debug)]
pub enum Cutout {
    /// An alpha mask, which is interpolated between texels. Values below one half are cut out.
    Mask(PropertyMap<f32>),
    /// Partial coverage, as the fraction of the samples that hit the surface, from 0 to 1.
    Share(PropertyMap<f32>),
}

impl MaterialMap {
    /// Creates a material from albedo and roughness.
    pub fn new(width: u32, height: u32, colors: Vec<[u8; 4]>) -> Self {
        Self { width, height, colors, ..Self::default() }
    }
}

/// The coordinates that a [`Detail`] uses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DetailMapping {
    /// The detail uses the texture coordinates of the mesh. Tile atlases do not support it, because their coordinates end at each
    /// patch.
    Texcoords,
    /// The detail uses triplanar mapping. The positions at rest are projected along the three axes, and the projections are blended
    /// by the normal. The value is the number of metres per unit of the coordinates.
    Triplanar(f32),
}

/// How the colours and the roughness of a [`Detail`] are combined with those of the surface.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum DetailColors {
    /// The detail's colours, divided by their mean, multiply the surface's colours. The detail's roughness replaces the surface's
    /// roughness. With the gloss technique, both roughnesses combine: the lengths of their mean normals multiply.
    Vary,
    /// The detail's colours and roughness replace those of the surface. The value replaces the surface's reflectance at normal
    /// incidence.
    Cover(f32),
}

/// A factor from 0 to 1 at each point of a surface. The map repeats.
#[derive(Clone, Debug)]
pub struct FactorMap {
    /// The number of texels per row.
    pub width: u32,
    /// The number of rows.
    pub height: u32,
    /// The factors, from 0 to 1.
    pub texels: Vec<f32>,
    /// The transform from the surface's coordinates to the map's coordinates.
    pub transform: Affine2,
}

/// A tiling relief that is finer than the surface's own. The slopes of the detail are added.
#[derive(Clone, Debug)]
pub struct Detail {
    /// The repeating heights, in metres.
    pub heights: HeightField,
    /// The slopes in metres per unit of the detail's coordinates, one per texel of `heights`, which replace the slopes computed
    /// from `heights`.
    pub slopes: Option<Vec<[f32; 2]>>,
    /// The detail's material, over the detail's own coordinates. `None` keeps the surface's colours.
    pub material: Option<(MaterialMap, DetailColors)>,
    /// The coordinates to which the detail is attached.
    pub mapping: DetailMapping,
    /// The transform from the coordinates of `mapping` to the detail's own coordinates, which repeat with period 1.
    pub transform: Affine2,
    /// The factors for the slopes and the coverage of the detail. `None` applies all of it everywhere.
    pub mask: Option<FactorMap>,
    /// Whether the heights are added to those of the surface, which must have relief over texture coordinates. The frame's height
    /// scale then applies to the detail too. Otherwise the slopes are added for shading, without displacement.
    pub displaces: bool,
}

/// How repeating maps cover a surface.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Hash)]
pub enum Tiling {
    /// The maps simply repeat.
    #[default]
    Repeats,
    /// The maps are tiled by example, which blends pieces of the maps and preserves their mean and covariance
    /// ([`leadr_reflectance::slopes::tiling`]). Adjacent pieces are never neighbours in the map. The mesh must consist of quads
    /// without seams, its texture coordinates must agree where patches meet, and the maps on these coordinates must repeat. Other
    /// meshes use [`Repeats`](Self::Repeats).
    ByExample,
    /// The maps simply repeat, but use the shaders of [`ByExample`](Self::ByExample), for the same meshes. A scene that contains
    /// this mode and `ByExample` needs fewer pipelines.
    OneVariant,
    /// Like [`ByExample`](Self::ByExample), but the tiling is fixed in the world when the mesh moves within its own surface. The
    /// tiling is fixed exactly on planes, and in steps of whole repeats on other meshes.
    ByExampleInWorld,
    /// Like `ByExampleInWorld`, but with the drifts and paths of open ground. Only planes support it.
    Ground,
}

named_enum! {
    /// The relief of a clear coat.
    #[derive(Default)]
    pub enum CoatRelief {
        /// The coat follows the relief of the surface.
        #[default]
        Base = "base", "The relief of the surface below";
        /// The coat fills the relief and has the normals of the mesh.
        Smooth = "smooth", "No relief: the coat fills the bumps";
    }
}

/// A clear coat: a thin dielectric layer of index 1.5 over the surface ([`leadr_reflectance::visible::clear_coat`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ClearCoat {
    /// The covered fraction of the surface, from 0 to 1.
    pub weight: f32,
    /// The Beckmann roughness.
    pub alpha: f32,
    /// The relief of the coat.
    pub relief: CoatRelief,
}

/// What light that enters a surface passes through ([`leadr_reflectance::visible::transmission`]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Medium {
    /// The fraction of the light below the specular term that passes, from 0 to 1. The rest scatters in the diffuse base. The albedo
    /// colours both.
    pub weight: f32,
    /// The refractive index, at least 1.
    pub ior: f32,
    /// The thickness of the body in metres, or 0 for a thin wall, which does not bend light.
    pub thickness: f32,
    /// The extinction per metre inside the body.
    pub extinction: [f32; 3],
}

/// A displaced or smooth surface.
#[derive(Clone, Debug)]
pub struct Object {
    /// The object's name in messages and debugging tools.
    pub name: String,
    /// The patches of the surface.
    pub mesh: PatchMesh,
    /// The same surface in fewer patches, with the same joints and texture coordinates. A smooth surface uses the coarse mesh where
    /// the patches of `mesh` are smaller than pixels. A displaced surface uses it wherever its patches can be divided finely
    /// enough. Atlases, triplanar details, and materials with their own charts belong to the patches of one mesh, so they do not
    /// allow a coarse mesh.
    pub coarse_mesh: Option<PatchMesh>,
    /// The heights along the patch normals, or `None` for a smooth surface.
    pub heights: Option<HeightField>,
    /// The slopes over texture coordinates in the unit of the heights, one per texel of `heights`, for example from a normal map
    /// that is finer than the heights. The surface is still displaced by the heights. On triangles, the slopes are rise over run,
    /// because their texture coordinates have any scale.
    pub slopes: Option<Vec<[f32; 2]>>,
    /// Precomputed slope moments of all levels, as in a baked file, which replace the moments computed from `heights` or `slopes`.
    /// The moments contain the same heights as `heights`, which wrap like a single map.
    pub moments: Option<LeadrMap>,
    /// Additional slope variance `(ss, tt, st)` in squared slope units, one per texel of `slopes`, for an anisotropic base.
    pub slope_spread: Option<Vec<[f32; 3]>>,
    /// How repeating maps cover the surface.
    pub tiling: Tiling,
    /// A finer relief that repeats over the surface.
    pub detail: Option<Detail>,
    /// The displacement in metres per unit of `heights` (`η`). Each frame multiplies it by its own factor.
    pub height_scale: f32,
    /// Factors for the height scale, over the texture coordinates of the mesh. `None` does not scale. The values of the vertices
    /// ([`PatchMesh::height_scales`]) multiply it. Atlases take values at vertices only.
    pub height_scale_map: Option<FactorMap>,
    /// The material, or `None` to use the vertex colours.
    pub material: Option<MaterialMap>,
    /// The texture coordinates of each triangle in the material's images, if they differ from those of the mesh. The mesh's
    /// coordinates then apply to the slopes only. Only triangle meshes support this.
    pub charts: Option<Vec<TriangleCharts>>,
    /// The reflectance at normal incidence. If there is an `f0` map, this value applies to the diffuse base only. Below 0.02, the
    /// reflection fades at all angles, and 0 disables it.
    pub specular_f0: f32,
    /// The edge tint of a conductor, which is how far the reflectance falls below Schlick's form between normal and grazing
    /// incidence ([`fresnel_edge_tint`](leadr_reflectance::facets::fresnel::fresnel_edge_tint)). The tint ranges from 0 to 4, in
    /// steps of 4/31. Use it only for surfaces of a single metal, because the reflectance of a dielectric would become negative.
    pub edge_tint: [f32; 3],
    /// The clear coat, or `None` without one. Techniques that do not integrate over slopes draw the surface without its coat.
    pub coat: Option<ClearCoat>,
    /// The medium behind the surface, or `None` if no light passes. Only the environment, suns and lamps are seen through it. Techniques
    /// that do not integrate over slopes draw an opaque surface.
    pub medium: Option<Medium>,
    /// The horizontal and vertical wrap modes of the slopes. `None` uses the border rule of the heights.
    pub slope_wrap: Option<[TextureWrap; 2]>,
    /// Whether the vertex colours multiply the emission.
    pub tints_emission: bool,
    /// Whether only the front side is drawn, on which triangles run counter-clockwise. Both sides of a surface cast shadows.
    pub front_only: bool,
    /// Whether colours that follow the relief separate classes of facets
    /// ([`ShadingOptions::relief_color`](crate::settings::ShadingOptions::relief_color)).
    pub follows_relief: bool,
    /// The classes of facets of the relief, from a baked file. Without them, the renderer finds them in the maps. It also finds them if
    /// the height scale is negative, or if the material separates classes.
    pub classes: Option<StoredClasses>,
    /// Whether one Gaussian of slopes describes the relief well enough, so that it is not divided into classes. Classes of colours that
    /// [follow the relief](Self::follows_relief) are found nevertheless.
    pub single_class: bool,
    /// Whether the object casts a shadow.
    pub casts_shadow: bool,
    /// The number of times that the object is drawn, each time with its own pose. Instances share the mesh and the maps on the
    /// device.
    pub instances: u32,
}

impl Object {
    /// Creates a smooth surface with vertex colours and the reflectance of common dielectrics, which casts a shadow.
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
            height_scale_map: None,
            material: None,
            charts: None,
            specular_f0: 0.04,
            edge_tint: [0.0; 3],
            coat: None,
            medium: None,
            slope_wrap: None,
            tints_emission: false,
            front_only: false,
            follows_relief: false,
            classes: None,
            single_class: false,
            casts_shadow: true,
            instances: 1,
        }
    }

    /// Sets how many times the object is drawn, each time with its own pose.
    #[must_use]
    pub fn with_instances(self, instances: u32) -> Self {
        Self { instances, ..self }
    }

    /// Separates classes of facets by colours that follow the relief.
    #[must_use]
    pub fn with_relief_color(self) -> Self {
        Self { follows_relief: true, ..self }
    }

    /// Describes the relief by one Gaussian of slopes.
    #[must_use]
    pub fn with_single_class(self) -> Self {
        Self { single_class: true, ..self }
    }

    /// Adds a [coarser mesh](Self::coarse_mesh), which is drawn wherever it is fine enough.
    #[must_use]
    pub fn with_coarse_mesh(self, mesh: PatchMesh) -> Self {
        Self { coarse_mesh: Some(mesh), ..self }
    }

    /// Displaces the surface along the patch normals, by `scale` times the heights.
    #[must_use]
    pub fn with_heights(self, heights: HeightField, scale: f32) -> Self {
        Self { heights: Some(heights), height_scale: scale, ..self }
    }

    /// Multiplies the height scale by a map. Call it after [`with_heights`](Self::with_heights).
    #[must_use]
    pub fn with_height_scale_map(self, map: FactorMap) -> Self {
        Self { height_scale_map: Some(map), ..self }
    }

    /// Shades with these slopes instead of the slopes of the heights. Call it after [`with_heights`](Self::with_heights).
    #[must_use]
    pub fn with_slopes(self, slopes: Vec<[f32; 2]>) -> Self {
        Self { slopes: Some(slopes), ..self }
    }

    /// Shades with precomputed moments of the heights. Call it after [`with_heights`](Self::with_heights).
    #[must_use]
    pub fn with_moments(self, moments: LeadrMap) -> Self {
        Self { moments: Some(moments), ..self }
    }

    /// Adds variance to the slopes of the surface. Call it after [`with_slopes`](Self::with_slopes).
    #[must_use]
    pub fn with_slope_spread(self, spread: Vec<[f32; 3]>) -> Self {
        Self { slope_spread: Some(spread), ..self }
    }

    /// Sets how repeating maps cover the surface.
    #[must_use]
    pub fn with_tiling(self, tiling: Tiling) -> Self {
        Self { tiling, ..self }
    }

    /// Adds a finer relief that repeats over the surface.
    #[must_use]
    pub fn with_detail(self, detail: Detail) -> Self {
        Self { detail: Some(detail), ..self }
    }

    /// Adds a material, whose albedo and roughness are multiplied by those of the vertices.
    #[must_use]
    pub fn with_material(self, map: MaterialMap) -> Self {
        Self { material: Some(map), ..self }
    }

    /// Adds separate texture coordinates for the material's images.
    #[must_use]
    pub fn with_charts(self, charts: Vec<TriangleCharts>) -> Self {
        Self { charts: Some(charts), ..self }
    }

    /// Sets the reflectance at normal incidence.
    #[must_use]
    pub fn with_specular_f0(self, specular_f0: f32) -> Self {
        Self { specular_f0, ..self }
    }

    /// Sets the edge tint of a conductor.
    #[must_use]
    pub fn with_edge_tint(self, edge_tint: [f32; 3]) -> Self {
        Self { edge_tint, ..self }
    }

    /// Sets the clear coat.
    #[must_use]
    pub fn with_coat(self, coat: Option<ClearCoat>) -> Self {
        Self { coat, ..self }
    }

    /// Sets the medium behind the surface.
    #[must_use]
    pub fn with_medium(self, medium: Option<Medium>) -> Self {
        Self { medium, ..self }
    }

    /// Stops the object from casting shadows on other surfaces.
    #[must_use]
    pub fn without_shadow(self) -> Self {
        Self { casts_shadow: false, ..self }
    }
}

/// The contents of a scene. Only poses and waves change between frames.
#[derive(Clone, Debug, Default)]
pub struct Scene {
    /// The meshes of the scene.
    pub objects: Vec<Object>,
    /// The sea, if there is one.
    pub ocean: Option<Ocean>,
    /// A cache for map data that is slow to compute. `None` disables caching.
    pub cache: Option<MapCache>,
    /// The format in which the slopes of meshes are stored.
    pub map_precision: MomentFormat,
}

impl From<Vec<Object>> for Scene {
    /// Creates a scene with objects and without a sea.
    fn from(objects: Vec<Object>) -> Self {
        Self { objects, ..Self::default() }
    }
}

impl From<Ocean> for Scene {
    /// Creates a scene of the open sea, without objects.
    fn from(ocean: Ocean) -> Self {
        Self { ocean: Some(ocean), ..Self::default() }
    }
}

/// The pose of an object in one frame.
#[derive(Clone, Debug, PartialEq)]
pub enum Pose {
    /// The pose is a rigid transform from rest to world space.
    Rigid(Affine3A),
    /// The pose is given by linear blend skinning, with one matrix per joint from rest to world space.
    Skinned(Vec<Mat4>),
    /// The pose is given by the world positions and the unit normals of all vertices.
    Vertices(PosedVertices),
}

/// A directional light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Sun {
    /// The unit direction toward the sun.
    pub direction: Vec3,
    /// The irradiance on a plane that faces the sun, as linear rgb.
    pub irradiance: Vec3,
}

impl Sun {
    /// Returns the sun of a sky, attenuated by the atmosphere. After sunset it returns the moon.
    pub fn of(sky: &Sky) -> Self {
        let direction = sky.sun_direction.normalize_or(Vec3::Z);
        let irradiance = Vec3::from_array(sky.sun_irradiance());
        if irradiance == Vec3::ZERO {
            return Self { direction: -direction, irradiance: Vec3::from_array(sky.moon_irradiance()) };
        }
        Self { direction, irradiance }
    }
}

/// A point light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PointLight {
    /// The position in world space, in metres.
    pub position: Vec3,
    /// The radiant intensity in linear rgb, which equals the irradiance at a distance of 1 m.
    pub intensity: Vec3,
    /// The cone of a spot light, or `None` for a light that shines in all directions.
    pub cone: Option<Cone>,
    /// The distance in metres at which the light fades to zero, as in `KHR_lights_punctual`. `None` means that there is no limit.
    pub range: Option<f32>,
    /// The radius in metres, which only sets the width of the penumbrae. Shading treats the light as a point.
    pub radius: f32,
}

/// The cone of a spot light.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Cone {
    /// The axis of the cone, as a unit vector.
    pub axis: Vec3,
    /// The angle from the axis, in radians, up to which the light has its full intensity, less than `outer_angle`.
    pub inner_angle: f32,
    /// The angle from the axis, in radians, at which the light ends, at most π/2.
    pub outer_angle: f32,
}

impl PointLight {
    /// Creates a point light that shines in all directions and has no range.
    pub const fn new(position: Vec3, intensity: Vec3) -> Self {
        Self { position, intensity, cone: None, range: None, radius: 0.0 }
    }

    /// Sets the radius, in metres.
    #[must_use]
    pub const fn with_radius(self, radius: f32) -> Self {
        Self { radius, ..self }
    }

    /// Returns the coefficients of the cone's falloff. If `d` is a unit direction away from the light, the factor is `clamp(d · xyz
    /// + w, 0, 1)²`.
    pub(super) fn falloff(&self) -> [f32; 4] {
        let Some(Cone { axis, inner_angle, outer_angle }) = self.cone else { return [0.0, 0.0, 0.0, 1.0] };
        let (inner, outer) = (inner_angle.cos(), outer_angle.cos());
        let scale = (inner - outer).max(1e-3).recip();
        (axis * scale).extend(-outer * scale).to_array()
    }

    /// Returns the reciprocal of the squared range, or 0 without a range.
    pub(super) fn inverse_square_range(&self) -> f32 {
        self.range.map_or(0.0, |range| (range * range).max(1e-20).recip())
    }
}

/// The maximum number of lamps in a frame: point lights, spots, and directional lights beside the sun.
pub const MAX_LAMPS: usize = super::constants::MAX_LAMPS as usize;

/// The state of one frame.
#[derive(Clone, Debug, PartialEq)]
pub struct FrameState {
    /// The time of the waves in seconds.
    pub time: f64,
    /// The camera.
    pub camera: Camera,
    /// One pose for each instance of each object, in scene order. Instances without a pose are not drawn.
    pub poses: Vec<Pose>,
    /// A position in world space that moves with the subject of the view.
    pub anchor: Vec3,
    /// The sky, if the environment is a sky. The sky determines the cube map, the sun and the exposure.
    pub sky: Option<Sky>,
    /// A directional light that replaces the sun of the sky.
    pub sun: Option<Sun>,
    /// The point lights. The four brightest lamps at the objects have shadow maps. With the directional lights of `more_suns`, there are
    /// at most [`MAX_LAMPS`].
    pub point_lights: Vec<PointLight>,
    /// Directional lights in addition to the sun.
    pub more_suns: Vec<Sun>,
    /// A factor for the height scale of every object.
    pub height_scale: f32,
    /// The radiance of an emission value of 1.
    pub emission_scale: f32,
    /// The metered exposure factor, for a frame without a sky.
    pub metered: f32,
    /// The irradiance that lamps add at the subject, relative to that of the environment. The exposure compensates it.
    pub added_light: f32,
}

impl FrameState {
    /// Creates the view of `camera` at time 0. The heights are not scaled, and only the renderer's environment lights the scene.
    pub fn new(camera: Camera, poses: Vec<Pose>) -> Self {
        Self {
            time: 0.0,
            camera,
            poses,
            anchor: Vec3::ZERO,
            sky: None,
            sun: None,
            point_lights: Vec::new(),
            more_suns: Vec::new(),
            height_scale: 1.0,
            emission_scale: 1.0,
            metered: 1.0,
            added_light: 0.0,
        }
    }

    /// Sets the sky, whose sun then lights the frame.
    #[must_use]
    pub fn under(self, sky: &Sky) -> Self {
        Self { sky: Some(*sky), sun: None, ..self }
    }

    /// Returns the frame's own directional light or, if there is none, the sun of the sky.
    pub fn sun(&self) -> Option<Sun> {
        self.sun.or_else(|| self.sky.as_ref().map(Sun::of))
    }

    /// Returns the exposure factor for displaying the image. The factor comes from the sun of the sky, or is the metered value
    /// without a sky. Lamps that add light decrease it.
    pub fn exposure(&self) -> f32 {
        self.sky.as_ref().map_or(self.metered, exposure::exposure) / (1.0 + self.added_light)
    }
}

impl Pose {
    /// The rest pose.
    pub const REST: Self = Self::Rigid(Affine3A::IDENTITY);

    /// Poses a mesh. Joints that the pose does not have are ignored.
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
