//! Materials: one type for everything that is drawn, and for all file formats.
//!
//! Each material property is a constant or a texture ([`Input`]). Textures have their own coordinates, transform, addressing
//! mode and encoding. Filtering happens later, when a material is combined with a mesh and relief.

mod baked;
mod folder;
mod normals;
mod raster;

pub use folder::{MaterialFolder, Role, role_of};
pub use normals::{Agreement, STEEPEST, agreement, green_axis};
pub use raster::{Encoding, Raster, Samples, Texture, TextureWrap};

use std::sync::Arc;

use super::HeightMap;
use leadr_reflectance::facets::gloss::Gloss;
use leadr_reflectance::materials::fitted_table::FittedTable;

/// A material property: a constant, or a texture times a constant factor.
#[derive(Clone, Debug, PartialEq)]
pub struct Input<T> {
    /// The constant value, or the factor on the texture.
    pub factor: T,
    /// Optional texture.
    pub texture: Option<Texture>,
    /// Channel of a scalar property, 0 to 3. Colours use the first three channels.
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

/// Returns the code, 0 to 255, of a roughness `α` in 0..1 in colour maps. The code stores the square root of `α`, for precision
/// on smooth surfaces.
pub fn alpha_code(alpha: f32) -> u8 {
    (alpha.clamp(0.0, 1.0).sqrt() * 255.0 + 0.5) as u8
}

/// Returns the roughness `α` of a code; inverse of [`alpha_code`].
pub fn alpha_of(code: u8) -> f32 {
    (f32::from(code) / 255.0).powi(2)
}

/// Meaning of roughness values.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum RoughnessMeaning {
    /// Perceptual roughness, whose square is `α`, as in glTF and most texture libraries.
    #[default]
    Perceptual,
    /// Roughness `α` of the microfacet distribution: `√2` times the standard deviation of a Beckmann surface's slopes.
    Alpha,
    /// Gloss or smoothness on a given scale.
    Gloss(Gloss),
}

impl RoughnessMeaning {
    /// Returns the roughness `α` of a value in 0..1.
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
    /// Strength, 0 (isotropic) to 1. Along the direction, `α` is interpolated towards 1 by the squared strength.
    pub strength: Input<f32>,
    /// Rotation of the direction from the tangent towards the bitangent, in radians.
    pub rotation: f32,
    /// Directions in the tangent plane (red and green as -1..1), rotated by `rotation`. `None` uses the tangent.
    pub direction: Option<Texture>,
}

/// Normal map in the tangent frame.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalMap {
    /// Normals as a texture. Red and green as -1..1 are x and y. Blue is z, which two-channel images derive.
    pub texture: Texture,
    /// Direction of the green channel.
    pub green: GreenAxis,
    /// Factor on x and y.
    pub scale: f32,
}

/// Direction of a normal map's green channel in the image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum GreenAxis {
    /// Green points up (OpenGL, glTF).
    #[default]
    Up,
    /// Green points down (DirectX).
    Down,
}

/// Heights of a surface above its mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    /// The heights, over the first texture coordinates.
    pub map: HeightMap,
    /// Metres per unit of the map. `None` if unknown.
    pub scale: Option<f32>,
    /// Whether the unit is the texture width, if `scale` is unknown.
    pub in_widths: bool,
    /// Map height at the mesh surface.
    pub middle: f32,
}

/// A detail material that repeats more often than its base material.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialDetail {
    /// The detail material. Its heights and normals affect only shading.
    pub material: Material,
    /// Whether the detail affects colour and roughness as well as slopes. True if its files define them.
    pub colored: bool,
    /// Number of repeats within one repeat of the base material.
    pub repeat: f32,
    /// Counter-clockwise rotation in degrees.
    pub rotation: f32,
    /// Factor on the heights and slopes of the detail.
    pub height_scale: f32,
    /// Coverage, 0 to 1, over one repeat of the base material. `None` modulates the base everywhere instead of covering it.
    pub mask: Option<Texture>,
}

/// Opacity of a surface.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Opacity {
    /// Fully opaque.
    #[default]
    Opaque,
    /// Visible where the mask is at least the cutoff.
    Mask {
        /// Mask value, usually the base colour's alpha.
        mask: Input<f32>,
        /// Smallest mask value that is visible.
        cutoff: f32,
    },
    /// Partial opacity. The surface is drawn where the opacity is at least one half, since transparency is not supported.
    Blend {
        /// Opacity, 0 to 1.
        share: Input<f32>,
    },
}

/// A surface material. Colours are linear Rec.709, from 0 to 1 except for emission.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Name in messages and on the command line.
    pub name: String,
    /// Albedo of dielectrics; reflectance at normal incidence of metals.
    pub base_color: Input<[f32; 3]>,
    /// Metalness, 0 to 1.
    pub metalness: Input<f32>,
    /// Microfacet roughness, 0 to 1.
    pub roughness: Input<f32>,
    /// Meaning of the roughness values.
    pub roughness_meaning: RoughnessMeaning,
    /// Facet distribution of a measured material, with its own reflectance. Roughness scales the slopes of the facets.
    pub fit: Option<Arc<FittedTable>>,
    /// Anisotropy, if any.
    pub anisotropy: Option<Anisotropy>,
    /// Reflectance at normal incidence of dielectrics. The product of factor and texture is clamped to 1.
    pub f0: Input<[f32; 3]>,
    /// F82 tint of metals, 0 to 4: the reduction of reflectance below Schlick's curve towards grazing incidence
    /// ([`fresnel_edge_tint`](leadr_reflectance::facets::fresnel::fresnel_edge_tint)). 0 if not given.
    pub edge_tint: [f32; 3],
    /// Normal map.
    pub normal_map: Option<NormalMap>,
    /// Heights.
    pub relief: Option<Relief>,
    /// Detail material.
    pub detail: Option<Box<MaterialDetail>>,
    /// Factor on the Fresnel reflectance of dielectrics at every angle, 0 to 1.
    pub specular: Input<f32>,
    /// Ambient occlusion: the visible fraction of the hemisphere, 0 to 1.
    pub occlusion: Input<f32>,
    /// Strength of the occlusion, 0 to 1; 0 disables it.
    pub occlusion_strength: f32,
    /// Visibility cones, which replace the occlusion. Red, green and blue as -1..1 are the mean open direction in the tangent
    /// frame with y up, longer for a narrower cone. Alpha is the visible fraction
    /// ([`Cone::of_vector`](leadr_reflectance::masking::occlusion::Cone::of_vector)).
    pub cones: Option<Texture>,
    /// Emitted radiance.
    pub emission: Input<[f32; 3]>,
    /// Opacity.
    pub opacity: Opacity,
    /// Whether back faces are visible.
    pub double_sided: bool,
    /// Whether only the base colour is shown, independent of light.
    pub unlit: bool,
}

/// Reflectance at normal incidence of common dielectrics (index of refraction 1.5).
pub const DIELECTRIC_F0: f32 = 0.04;

impl Material {
    /// A grey dielectric of medium roughness.
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
            normal_map: None,
            relief: None,
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

    /// Returns the number of texture coordinate sets in use: one more than the largest index, or 0 without textures.
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
        let sets = colors.into_iter().chain(numbers).chain(others).flatten().map(|texture| texture.coordinates + 1);
        sets.max().unwrap_or(0).max(u32::from(self.relief.is_some()))
    }
}
