//! Materials. One type describes everything that is drawn, for all file formats.
//!
//! Each material property is a constant or a texture ([`Input`]). Textures have their own coordinates, transform, addressing
//! mode and encoding. Filtering happens later, when a material is combined with a mesh and relief.

mod baked;
mod folder;
mod names;
mod normals;
mod raster;

pub use folder::{MaterialFolder, MaterialPicture};
pub use names::{Role, role_of};
pub use normals::{Agreement, STEEPEST, agreement, green_axis};
pub use raster::{Encoding, Raster, Samples, Texture, TextureWrap};

use std::sync::Arc;

use super::{HeightMap, MomentLevel};
pub use leadr_reflectance::facets::gloss::Gloss;
use leadr_reflectance::materials::fitted_table::FittedTable;

/// A material property, which is a constant or a texture times a constant factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Input<T> {
    /// The constant value, or the factor that multiplies the texture.
    pub factor: T,
    /// The texture, if any.
    pub texture: Option<Texture>,
    /// The texture channel of a scalar property, from 0 to 3. Colours always use the first three channels.
    pub channel: usize,
}

impl<T> Input<T> {
    /// Creates a constant property.
    pub const fn constant(value: T) -> Self {
        Self { factor: value, texture: None, channel: 0 }
    }
}

impl Input<f32> {
    /// Creates a scalar property from a channel of a texture.
    pub const fn texture(texture: Texture, channel: usize) -> Self {
        Self { factor: 1.0, texture: Some(texture), channel }
    }
}

impl Input<[f32; 3]> {
    /// Creates a colour property from a texture.
    pub const fn colors(texture: Texture) -> Self {
        Self { factor: [1.0; 3], texture: Some(texture), channel: 0 }
    }
}

/// Returns the code, from 0 to 255, by which colour maps store a roughness `α` in 0..1. The code stores the square root of
/// `α`, which gives precision on smooth surfaces.
pub fn alpha_code(alpha: f32) -> u8 {
    (alpha.clamp(0.0, 1.0).sqrt() * 255.0 + 0.5) as u8
}

/// Returns the roughness `α` of a code. Inverse of [`alpha_code`].
pub fn alpha_of(code: u8) -> f32 {
    (f32::from(code) / 255.0).powi(2)
}

/// What the values of a roughness texture mean.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum RoughnessMeaning {
    /// Perceptual roughness, whose square is `α`, as in glTF and most texture libraries.
    #[default]
    Perceptual,
    /// The roughness `α` of the microfacet distribution, which is `√2` times the standard deviation of a Beckmann surface's
    /// slopes.
    Alpha,
    /// Gloss or smoothness on a given scale.
    Gloss(Gloss),
}

impl RoughnessMeaning {
    /// Converts a value in 0..1 to the roughness `α`.
    pub fn alpha(self, value: f32) -> f32 {
        match self {
            Self::Perceptual => value * value,
            Self::Alpha => value,
            Self::Gloss(scale) => scale.alpha(f64::from(value)) as f32,
        }
    }
}

/// Anisotropic roughness, as in `KHR_materials_anisotropy`.
#[derive(Clone, Debug, PartialEq)]
pub struct Anisotropy {
    /// The strength, from 0 (isotropic) to 1. Along the direction, `α` is interpolated towards 1 by the squared strength.
    pub strength: Input<f32>,
    /// The rotation of the direction in radians, from the tangent towards the bitangent.
    pub rotation: f32,
    /// The directions in the tangent plane before the rotation by `rotation`. Red and green as -1..1 are the components.
    /// `None` means the tangent direction.
    pub direction: Option<Texture>,
}

/// A clear coat, as in `KHR_materials_clearcoat`: a thin dielectric layer over the material, whose index of refraction is 1.5.
#[derive(Clone, Debug, PartialEq)]
pub struct ClearCoat {
    /// The covered fraction of the surface, from 0 to 1.
    pub weight: Input<f32>,
    /// The roughness, from 0 to 1.
    pub roughness: Input<f32>,
    /// What the roughness values mean.
    pub roughness_meaning: RoughnessMeaning,
    /// Whether the coat has the relief of the material. If not, the coat has the relief of its normal map, or is smooth.
    pub follows_relief: bool,
    /// The coat's own normal map, if any.
    pub normal_map: Option<NormalMap>,
}

/// Light that passes through a dielectric, as in `KHR_materials_transmission` and `KHR_materials_volume`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Transmission {
    /// The fraction of the light below the specular term that passes, from 0 to 1. The base colour colours it.
    pub weight: f32,
    /// The refractive index, at least 1.
    pub ior: f32,
    /// The thickness of the body, in the unit of the mesh, or 0 for a thin wall, which does not bend light.
    pub thickness: f32,
    /// The colour of white light after it passes `attenuation_distance` of the body, from 0 to 1.
    pub attenuation_color: [f32; 3],
    /// The distance of `attenuation_color`, in the unit of the world. Infinity means no attenuation.
    pub attenuation_distance: f32,
}

impl ClearCoat {
    /// Returns the textures of the coat.
    pub fn textures(&self) -> impl Iterator<Item = &Texture> {
        let numbers = [&self.weight, &self.roughness].into_iter().filter_map(|input| input.texture.as_ref());
        numbers.chain(self.normal_map.as_ref().map(|map| &map.texture))
    }

    /// Returns the textures of the coat, to change their layout.
    pub fn textures_mut(&mut self) -> impl Iterator<Item = &mut Texture> {
        let numbers = [&mut self.weight, &mut self.roughness].into_iter().filter_map(|input| input.texture.as_mut());
        numbers.chain(self.normal_map.as_mut().map(|map| &mut map.texture))
    }
}

/// A normal map in the tangent frame.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalMap {
    /// The normals as a texture. Red and green as -1..1 are x and y. Blue is z, which is computed from x and y for
    /// two-channel images.
    pub texture: Texture,
    /// The direction of the green channel.
    pub green: GreenAxis,
    /// The factor that multiplies x and y.
    pub scale: f32,
}

/// The direction of a normal map's green channel in the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum GreenAxis {
    /// Green points up (OpenGL, glTF).
    #[default]
    Up,
    /// Green points down (DirectX).
    Down,
}

/// The heights of a surface above its mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    /// The height map, which uses the first set of texture coordinates.
    pub map: HeightMap,
    /// The number of metres per unit of the map, or `None` if unknown.
    pub scale: Option<f32>,
    /// Whether the unit of the map is the texture width. The field is used only if `scale` is unknown.
    pub in_widths: bool,
    /// The height of the map that lies at the mesh surface.
    pub middle: f32,
}

/// A detail material that repeats more often than its base material.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialDetail {
    /// The detail material.
    pub material: Material,
    /// Whether the detail affects colour and roughness as well as slopes. True if the detail's files contain colour or
    /// roughness.
    pub colored: bool,
    /// The number of repeats within one repeat of the base material.
    pub repeat: f32,
    /// The counter-clockwise rotation in degrees.
    pub rotation: f32,
    /// The factor that multiplies the heights and slopes of the detail.
    pub height_scale: f32,
    /// Whether the heights displace the surface. Otherwise the detail affects only shading.
    pub displaces: bool,
    /// The coverage from 0 to 1, over one repeat of the base material. If the mask is `None`, the detail modulates the base
    /// everywhere instead of covering it.
    pub mask: Option<Texture>,
}

/// The opacity of a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Opacity {
    /// The surface is fully opaque.
    #[default]
    Opaque,
    /// The surface is visible where the mask is at least the cutoff.
    Mask {
        /// The mask value, usually the alpha of the base colour.
        mask: Input<f32>,
        /// The smallest mask value that is visible.
        cutoff: f32,
    },
    /// The surface is partially opaque. Transparency is not supported, so the surface is drawn where the opacity is at least
    /// one half.
    Blend {
        /// The opacity, from 0 to 1.
        share: Input<f32>,
    },
}

/// A surface material. Colours are linear Rec.709 and lie between 0 and 1, except for emission.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// The name in messages and on the command line.
    pub name: String,
    /// The albedo of a dielectric, or the reflectance of a metal at normal incidence.
    pub base_color: Input<[f32; 3]>,
    /// The metalness, from 0 to 1.
    pub metalness: Input<f32>,
    /// The microfacet roughness, from 0 to 1.
    pub roughness: Input<f32>,
    /// What the roughness values mean.
    pub roughness_meaning: RoughnessMeaning,
    /// The facet distribution of a measured material, with its own reflectance. The roughness scales the slopes of the
    /// facets.
    pub fit: Option<Arc<FittedTable>>,
    /// The anisotropy, if any.
    pub anisotropy: Option<Anisotropy>,
    /// The reflectance of dielectrics at normal incidence. The product of factor and texture is clamped to 1.
    pub f0: Input<[f32; 3]>,
    /// The F82 tint of metals, from 0 to 4. The tint reduces the reflectance below Schlick's curve towards grazing incidence
    /// ([`fresnel_edge_tint`](leadr_reflectance::facets::fresnel::fresnel_edge_tint)). The value is 0 if the material gives
    /// none.
    pub edge_tint: [f32; 3],
    /// The clear coat, if any.
    pub coat: Option<ClearCoat>,
    /// The transmission, if light passes through the material.
    pub transmission: Option<Transmission>,
    /// The normal map, if any.
    pub normal_map: Option<NormalMap>,
    /// The heights, if any.
    pub relief: Option<Relief>,
    /// The UDIM tiles across and up that the relief covers, which is [1, 1] for a single image. Models only.
    pub relief_tiles: [u32; 2],
    /// The slope moments of every texel of the heights, in their unit, if a texel contains several slopes: the moments of a baked file
    /// without its finest levels. A normal map replaces the moments. Without heights, the unit is the texture width.
    pub slope_moments: Option<MomentLevel>,
    /// The detail material, if any.
    pub detail: Option<Box<MaterialDetail>>,
    /// The factor from 0 to 1 that multiplies the Fresnel reflectance of dielectrics at every angle.
    pub specular: Input<f32>,
    /// The ambient occlusion, which is the visible fraction of the hemisphere, from 0 to 1.
    pub occlusion: Input<f32>,
    /// The strength of the occlusion, from 0 to 1, where 0 means no occlusion.
    pub occlusion_strength: f32,
    /// The visibility cones, which replace the occlusion. Red, green and blue as -1..1 are the mean open direction in the
    /// tangent frame with y up. The vector is longer for a narrower cone. Alpha is the visible fraction
    /// ([`Cone::of_vector`](leadr_reflectance::masking::occlusion::Cone::of_vector)).
    pub cones: Option<Texture>,
    /// The emitted radiance.
    pub emission: Input<[f32; 3]>,
    /// The opacity.
    pub opacity: Opacity,
    /// Whether back faces are visible.
    pub double_sided: bool,
    /// Whether the surface shows only its base colour, independent of light.
    pub unlit: bool,
}

/// The reflectance at normal incidence of common dielectrics (index of refraction 1.5).
pub const DIELECTRIC_F0: f32 = 0.04;

/// Returns the reflectance at normal incidence of a dielectric of this refractive index.
pub fn f0_of_ior(ior: f32) -> f32 {
    ((ior - 1.0) / (ior + 1.0)).powi(2)
}

impl Material {
    /// Creates a grey dielectric of medium roughness.
    pub fn new(name: impl Into<String>) -> Self {
        Self {
            name: name.into(),
            base_color: Input::constant([0.5; 3]),
            metalness: Input::constant(0.0),
            roughness: Input::constant(0.5),
            roughness_meaning: RoughnessMeaning::Perceptual,
            fit: None,
            anisotropy: None,
            f0: Input::constant([DIELECTRIC_F0; 3]),
            edge_tint: [0.0; 3],
            coat: None,
            transmission: None,
            normal_map: None,
            relief: None,
            relief_tiles: [1; 2],
            slope_moments: None,
            detail: None,
            specular: Input::constant(1.0),
            occlusion: Input::constant(1.0),
            occlusion_strength: 1.0,
            cones: None,
            emission: Input::constant([0.0; 3]),
            opacity: Opacity::Opaque,
            double_sided: false,
            unlit: false,
        }
    }

    /// Returns the number of texture coordinate sets in use, which is one more than the largest index. Without textures, the
    /// number is 0.
    pub fn coordinate_sets(&self) -> u32 {
        let colors = [&self.base_color, &self.f0, &self.emission].map(|input| input.texture.as_ref());
        let numbers =
            [&self.metalness, &self.roughness, &self.specular, &self.occlusion].map(|input| input.texture.as_ref());
        let opacity = match &self.opacity {
            Opacity::Opaque => None,
            Opacity::Mask { mask, .. } => mask.texture.as_ref(),
            Opacity::Blend { share } => share.texture.as_ref(),
        };
        let direction = self.anisotropy.as_ref().and_then(|a| a.direction.as_ref().or(a.strength.texture.as_ref()));
        let normal = self.normal_map.as_ref().map(|map| &map.texture);
        let others = [opacity, direction, normal, self.cones.as_ref()];
        let textures = colors.into_iter().chain(numbers).chain(others).flatten();
        let coat = self.coat.iter().flat_map(ClearCoat::textures);
        let sets = textures.chain(coat).map(|texture| texture.coordinates + 1);
        sets.max().unwrap_or(0).max(u32::from(self.relief.is_some()))
    }
}
