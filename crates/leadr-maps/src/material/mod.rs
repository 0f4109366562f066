//! What a surface is made of: one type for everything that is drawn and for every file that names a material.
//!
//! Each property is a constant or a texture ([`Input`]); a texture has its own coordinates, transform, wrap and encoding. Nothing is
//! filtered here: that is done where a material meets its mesh and its relief.

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

/// A property: a constant, or a texture times a constant.
#[derive(Clone, Debug, PartialEq)]
pub struct Input<T> {
    /// The value, or the factor on the texture.
    pub factor: T,
    /// Where it changes over the surface.
    pub texture: Option<Texture>,
    /// Which channel of the texture a number is read from, 0 to 3; colours are read from the first three.
    pub channel: usize,
}

impl<T> Input<T> {
    /// The same everywhere.
    pub const fn constant(value: T) -> Self {
        Self { factor: value, texture: None, channel: 0 }
    }
}

impl Input<f32> {
    /// A channel of a texture.
    pub const fn texture(texture: Texture, channel: usize) -> Self {
        Self { factor: 1.0, texture: Some(texture), channel }
    }
}

impl Input<[f32; 3]> {
    /// The colours of a texture.
    pub const fn colors(texture: Texture) -> Self {
        Self { factor: [1.0; 3], texture: Some(texture), channel: 0 }
    }
}

/// The code, 0 to 255, of a roughness `α` in 0..1 where colour maps store it: of its root, so that smooth surfaces have codes enough.
pub fn alpha_code(alpha: f32) -> u8 {
    (alpha.clamp(0.0, 1.0).sqrt() * 255.0 + 0.5) as u8
}

/// The roughness `α` of a code.
pub fn alpha_of(code: u8) -> f32 {
    (f32::from(code) / 255.0).powi(2)
}

/// What the numbers of a roughness are.
#[derive(Clone, Copy, Debug, PartialEq, Default)]
pub enum RoughnessMeaning {
    /// Perceptual: `α` is its square, as in glTF and most texture libraries.
    #[default]
    Perceptual,
    /// `α` of the microfacet distribution itself: `√2` times the deviation of a Beckmann surface's slopes.
    Alpha,
    /// Gloss, or smoothness, on a scale.
    Gloss(Gloss),
}

impl RoughnessMeaning {
    /// `α` of a number in 0..1.
    pub fn alpha(self, value: f32) -> f32 {
        match self {
            Self::Perceptual => value * value,
            Self::Alpha => value,
            Self::Gloss(scale) => scale.alpha(f64::from(value)) as f32,
        }
    }
}

/// Roughness that differs along and across a direction, as in `KHR_materials_anisotropy`.
#[derive(Clone, Debug, PartialEq)]
pub struct Anisotropy {
    /// 0 (isotropic) to 1: along the direction `α` is mixed towards 1 by its square.
    pub strength: Input<f32>,
    /// Turns the direction from the tangent towards the bitangent, radians.
    pub rotation: f32,
    /// Directions in the tangent plane (red and green as -1..1), turned by `rotation`; the tangent without it.
    pub direction: Option<Texture>,
}

/// Fine slopes of a surface as directions of its normal in the tangent frame.
#[derive(Clone, Debug, PartialEq)]
pub struct NormalMap {
    /// Red and green as -1..1 are x and y; blue is z, and is found from the others where the image has two channels.
    pub texture: Texture,
    /// Which way green goes.
    pub green: GreenAxis,
    /// Factor on x and y.
    pub scale: f32,
}

/// Which way the green channel of a normal map goes, seen as an image.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Default)]
pub enum GreenAxis {
    /// Up (OpenGL, glTF).
    #[default]
    Up,
    /// Down (DirectX).
    Down,
}

/// Heights of a surface above its mesh.
#[derive(Clone, Debug, PartialEq)]
pub struct Relief {
    /// The heights, over the first texture coordinates.
    pub map: HeightMap,
    /// Metres for each unit of the map; `None` if the file does not say.
    pub scale: Option<f32>,
    /// Whether a unit is a width of the texture, where `scale` tells nothing else.
    pub in_widths: bool,
    /// The height of the map that lies on the mesh.
    pub middle: f32,
}

/// A material that lies over another and repeats more often.
#[derive(Clone, Debug, PartialEq)]
pub struct MaterialDetail {
    /// What it is made of. Its heights and normals only shade.
    pub material: Material,
    /// Which of its properties count besides its slopes: colours and roughness, if files tell them.
    pub colored: bool,
    /// Times that it repeats within one repeat of the other.
    pub repeat: f32,
    /// By which it is turned counter-clockwise, degrees.
    pub rotation: f32,
    /// Factor on its heights and slopes.
    pub height_scale: f32,
    /// Where it is, 0 to 1, over one repeat of the other: it covers what lies below. Without one it is everywhere and varies what lies
    /// below.
    pub mask: Option<Texture>,
}

/// Where a surface is.
#[derive(Clone, Debug, Default, PartialEq)]
pub enum Opacity {
    /// Everywhere.
    #[default]
    Opaque,
    /// Where the mask is not below the cutoff.
    Mask {
        /// What is compared: alpha of the base colour, as a rule.
        mask: Input<f32>,
        /// The least value that is there.
        cutoff: f32,
    },
    /// Everywhere to a degree. Drawn where the share is at least one half: nothing here is transparent.
    Blend {
        /// The degree.
        share: Input<f32>,
    },
}

/// What a surface is made of. Colours are linear Rec.709, 0 to 1 except for emission.
#[derive(Clone, Debug, PartialEq)]
pub struct Material {
    /// Its name in messages and on the command line.
    pub name: String,
    /// Albedo of what is no metal, and reflectance at normal incidence of what is.
    pub base_color: Input<[f32; 3]>,
    /// Share of metal, 0 to 1.
    pub metalness: Input<f32>,
    /// Roughness, 0 to 1, of the microfacets.
    pub roughness: Input<f32>,
    /// What its numbers are.
    pub roughness_meaning: RoughnessMeaning,
    /// The facets of a measured material, whose slopes roughness scales; they have reflectances of their own.
    pub fit: Option<Arc<FittedTable>>,
    /// Its direction, if it has one.
    pub anisotropy: Option<Anisotropy>,
    /// Reflectance at normal incidence of what is no metal; above 1 it counts as 1, once factor and texture are multiplied.
    pub f0: Input<[f32; 3]>,
    /// How far metal's reflectance dips below Schlick's form on its way to grazing incidence, 0 to 4
    /// ([`fresnel_dipped`](leadr_reflectance::facets::fresnel::fresnel_dipped)): 0 where nobody tells.
    pub conductor_dip: [f32; 3],
    /// Fine slopes.
    pub normal_map: Option<NormalMap>,
    /// Heights.
    pub relief: Option<Relief>,
    /// What lies over it and repeats more often.
    pub detail: Option<Box<MaterialDetail>>,
    /// Strength of what a dielectric reflects, 0 to 1: a factor on its Fresnel reflectance at every angle.
    pub specular: Input<f32>,
    /// Share of the surroundings that is seen, 0 to 1.
    pub occlusion: Input<f32>,
    /// How much of the occlusion counts, 0 to 1: at 0 all of the surroundings is seen.
    pub occlusion_strength: f32,
    /// In place of occlusion, where the surroundings are seen: red, green and blue as -1..1 are the mean open direction in the tangent frame
    /// with y up, as long as the cone about it is narrow; alpha is the share that is seen ([`Cone::of_vector`](leadr_reflectance::masking::occlusion::Cone::of_vector)).
    pub cones: Option<Texture>,
    /// Emitted radiance.
    pub emission: Input<[f32; 3]>,
    /// Where it is.
    pub opacity: Opacity,
    /// Whether its back is seen, too.
    pub double_sided: bool,
    /// Whether it is shown in its base colour, whatever the light.
    pub unlit: bool,
}

/// Reflectance at normal incidence of common dielectrics: an index of refraction of 1.5.
pub const DIELECTRIC_F0: f32 = 0.04;

impl Material {
    /// A grey, half rough dielectric.
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
            conductor_dip: [0.0; 3],
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

    /// How many sets of texture coordinates its textures follow: one more than the largest number of a set, 0 without textures.
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
