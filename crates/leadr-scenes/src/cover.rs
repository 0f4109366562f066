//! Applies a material to a mesh. The textures are evaluated per texel into the maps that the renderer filters.
//!
//! Colours and roughness keep the resolution of the finest texture. The slopes of a normal map are added to the slopes of the heights, or
//! to a flat relief if there are no heights. If the unit of the heights is unknown, their scale is fitted to the normals.

use std::sync::Arc;

use glam::{Affine2, DVec3, Vec2};
use rayon::prelude::*;

use super::cutout::filled;
use super::sphere::color_code;
use leadr_maps::derive::{USUAL_HEIGHT, usual_scale, usual_scale_of_slope};
use leadr_maps::material::{
    Encoding, Input, Material, NormalMap, Opacity, Relief, RoughnessMeaning, Texture, TextureWrap, agreement,
};
use leadr_maps::moments::{MomentLevel, Moments, Wrap};
use leadr_maps::srgb::{linear_of_srgb8, srgb8_from_linear};
use leadr_reflectance::materials::fitted_table::FittedTable;
use leadr_reflectance::visible::transmission::extinction;
use leadr_render::scene::{ClearCoat, CoatRelief, CoatTexel, Cutout, MaterialMap, Medium, PropertyMap};

/// An image for bilinear lookups.
struct Plate<const N: usize> {
    width: u32,
    height: u32,
    texels: Vec<[f32; N]>,
    transform: Affine2,
    wrap: [TextureWrap; 2],
}

/// Interpolates linearly from `a` at 0 to `b` at 1.
fn lerp<const N: usize>(a: [f32; N], b: [f32; N], t: f32) -> [f32; N] {
    std::array::from_fn(|i| a[i] + t * (b[i] - a[i]))
}

impl<const N: usize> Plate<N> {
    fn new(texture: &Texture, texel: impl Fn(u32, u32) -> [f32; N] + Sync) -> Self {
        let (width, height) = (texture.raster.width(), texture.raster.height());
        let texels =
            (0..height).into_par_iter().flat_map_iter(|y| (0..width).map(move |x| (x, y))).map(|(x, y)| texel(x, y));
        let (transform, wrap) = (texture.transform, texture.wrap);
        Self { width, height, texels: texels.collect(), transform, wrap }
    }

    fn at(&self, texcoord: Vec2) -> [f32; N] {
        let t = self.transform.transform_point2(texcoord);
        let (x, y) = (on_centre(t.x * self.width as f32 - 0.5), on_centre(t.y * self.height as f32 - 0.5));
        let (left, top) = (x.floor(), y.floor());
        let texel = |dx: i64, dy: i64| {
            let x = self.wrap[0].texel(left as i64 + dx, self.width);
            let y = self.wrap[1].texel(top as i64 + dy, self.height);
            self.texels[y as usize * self.width as usize + x as usize]
        };
        let row = |dy: i64| lerp(texel(0, dy), texel(1, dy), x - left);
        lerp(row(0), row(1), y - top)
    }
}

/// Moves a texel position to the texel centre if they differ only by rounding error.
fn on_centre(position: f32) -> f32 {
    let centre = position.round();
    if (position - centre).abs() < 1e-3 { centre } else { position }
}

/// A property of the material, sampled by texture coordinate.
struct Property<const N: usize> {
    factor: [f32; N],
    plate: Option<Plate<N>>,
}

impl<const N: usize> Property<N> {
    fn at(&self, texcoord: Vec2) -> [f32; N] {
        let Some(plate) = &self.plate else { return self.factor };
        let texel = plate.at(texcoord);
        std::array::from_fn(|i| self.factor[i] * texel[i])
    }
}

fn number(input: &Input<f32>) -> Property<1> {
    let plate = |texture: &Texture| Plate::new(texture, |x, y| [texture.raster.value(x, y, input.channel)]);
    Property { factor: [input.factor], plate: input.texture.as_ref().map(plate) }
}

fn color(input: &Input<[f32; 3]>) -> Property<3> {
    let plate = |texture: &Texture| {
        // A table is used, because a million powers would be slow.
        let table = linear_of_srgb8();
        let raster = &texture.raster;
        let of_codes = matches!(raster.samples(), leadr_maps::material::Samples::U8(_));
        Plate::new(texture, |x, y| {
            if of_codes && texture.encoding == Encoding::Srgb {
                [0, 1, 2].map(|channel| table[(raster.value(x, y, channel) * 255.0 + 0.5) as usize])
            } else {
                raster.color(x, y, texture.encoding)
            }
        })
    };
    Property { factor: input.factor, plate: input.texture.as_ref().map(plate) }
}

/// Returns the resolution, in texels, of a texture over its chart's unit square.
fn texels_of(texture: &Texture) -> (u32, u32) {
    let size = Vec2::new(texture.raster.width() as f32, texture.raster.height() as f32);
    let texels = |axis: Vec2| ((axis * size).length().round() as u32).clamp(1, MOST_TEXELS);
    (texels(texture.transform.matrix2.x_axis), texels(texture.transform.matrix2.y_axis))
}

/// The largest side of a resampled image, in texels. Smaller images keep their size.
const MOST_TEXELS: u32 = 8192;

/// Returns the slopes `dh/ds, dh/dt` (`t` down) of a normal map, as rise over run.
fn slopes(map: &NormalMap) -> Plate<2> {
    Plate::new(&map.texture, |x, y| map.slope(x, y).map(|v| v as f32))
}

/// Returns the slope moments `E[x], E[y], E[x²], E[y²], E[xy]`. Moments are linear, so they may be interpolated.
fn slope_moments(level: &MomentLevel) -> Plate<5> {
    let texel = |&Moments { mean_slope: [x, y], second: [xx, yy], cross, .. }: &Moments| [x, y, xx, yy, cross];
    let texels = level.texels.iter().map(texel).collect();
    let (transform, wrap) = (Affine2::IDENTITY, [TextureWrap::Repeat; 2]);
    Plate { width: level.width, height: level.height, texels, transform, wrap }
}

/// Returns the default scale of heights without scale, in texture repeats per unit of height.
fn default_scale(material: &Material, relief: &Relief) -> f32 {
    let Some(level) = &material.slope_moments else { return usual_scale(&relief.map) };
    let sum: f64 = level.texels.iter().map(|texel| f64::from(texel.second[0] + texel.second[1])).sum();
    usual_scale_of_slope((sum / level.texels.len() as f64).sqrt() as f32)
}

/// Returns occlusion cones: directions with y up, whose coordinates are from -1 to 1, and the visible fraction.
fn cones(texture: &Texture) -> Plate<4> {
    let raster = &texture.raster;
    Plate::new(texture, |x, y| {
        let value = |channel| raster.value(x, y, channel);
        let signed = |channel| 2.0 * value(channel) - 1.0;
        [signed(0), signed(1), signed(2), value(3)]
    })
}

/// Returns the scale that agrees with the normals, in texture repeats per unit of height, or `None` if heights and normals are not
/// correlated.
fn agreed_scale(material: &Material) -> Option<f32> {
    let relief = material.relief.as_ref()?;
    if relief.in_widths {
        return Some(1.0);
    }
    let normals = material.normal_map.as_ref()?;
    let found = agreement(&relief.map, normals, Wrap::Repeat).filter(|found| found.scale_texels > 0.0)?;
    Some((found.scale_texels / f64::from(relief.map.width)) as f32)
}

/// The anisotropy, sampled by texture coordinate.
struct SampledAnisotropy {
    strength: Property<1>,
    /// The counter-clockwise rotation from the tangent, in radians.
    rotation: f32,
    direction: Option<Plate<2>>,
}

/// The anisotropy at one point.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct AnisotropySample {
    /// The unit direction from the tangent towards the bitangent, which points up in images.
    pub along: Vec2,
    /// The slope variance along this direction, in excess of the variance due to the base's `α`: `(α_t² − α²)/2`.
    pub variance: f32,
}

/// A clear coat with textures, sampled by texture coordinate.
struct SampledCoat {
    weight: Property<1>,
    roughness: Property<1>,
    meaning: RoughnessMeaning,
    slopes: Option<Plate<2>>,
    size: (u32, u32),
}

impl SampledCoat {
    /// Returns the coat of a material, if it has textures.
    fn of(material: &Material) -> Option<Self> {
        let coat = material.coat.as_ref().filter(|coat| coat.weight.factor > 0.0)?;
        let size = coat.textures().map(texels_of).reduce(|a, b| (a.0.max(b.0), a.1.max(b.1)))?;
        Some(Self {
            weight: number(&coat.weight),
            roughness: number(&coat.roughness),
            meaning: coat.roughness_meaning,
            slopes: coat.normal_map.as_ref().map(slopes),
            size,
        })
    }

    fn texel(&self, texcoord: Vec2) -> CoatTexel {
        let ([weight], [roughness]) = (self.weight.at(texcoord), self.roughness.at(texcoord));
        CoatTexel {
            weight: weight.clamp(0.0, 1.0),
            alpha: self.meaning.alpha(roughness.clamp(0.0, 1.0)),
            slope: self.slopes.as_ref().map_or([0.0; 2], |plate| plate.at(texcoord)),
        }
    }
}

/// A material that can be sampled at its first set of texture coordinates.
pub struct SampledMaterial {
    base_color: Property<3>,
    metalness: Property<1>,
    roughness: Property<1>,
    meaning: RoughnessMeaning,
    /// The facet distribution of a measured material.
    fit: Option<Arc<FittedTable>>,
    f0: Property<3>,
    specular: Property<1>,
    emission: Property<3>,
    occlusion: Property<1>,
    occlusion_strength: f32,
    cones: Option<Plate<4>>,
    opacity: Option<(Property<1>, Option<f32>)>,
    slopes: Option<Plate<2>>,
    /// The slope moments of heights whose texels contain several slopes, in the unit of the heights.
    slope_moments: Option<Plate<5>>,
    anisotropy: Option<SampledAnisotropy>,
    coat: Option<SampledCoat>,
    heights: Option<Plate<1>>,
    /// The map height at which the surface coincides with the mesh.
    pub middle: f32,
    scale: Option<f32>,
    /// The number of texture repeats per unit of height for files without a scale, fitted to the normals or from the default.
    agreed: f32,
    /// The resolution of the finest texture, in texels across and down.
    pub size: (u32, u32),
    /// The resolutions of the emission, the accessibility (or the cones), and the opacity.
    sizes: [(u32, u32); 3],
}

/// The material properties of one texel.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Texel {
    /// The linear albedo.
    pub albedo: [f32; 3],
    /// The roughness `α`.
    pub alpha: f32,
    /// The reflectance at normal incidence.
    pub f0: [f32; 3],
    /// The mean F0 of the dielectric layer.
    pub diffuse_f0: f32,
}

impl Texel {
    /// Adds another texel multiplied by `weight`. The weights need not sum to one.
    #[must_use]
    pub fn plus(self, weight: f32, other: Self) -> Self {
        let sum = |a: [f32; 3], b: [f32; 3]| std::array::from_fn(|i| a[i] + weight * b[i]);
        // Roughness is added as a variance.
        let square = self.alpha * self.alpha + weight * other.alpha * other.alpha;
        Self {
            albedo: sum(self.albedo, other.albedo),
            alpha: square.sqrt(),
            f0: sum(self.f0, other.f0),
            diffuse_f0: self.diffuse_f0 + weight * other.diffuse_f0,
        }
    }
}

/// Returns the centre of a texel in the image's unit square, with `t` down.
fn texel_centre(index: usize, (width, height): (u32, u32)) -> Vec2 {
    let [x, y] = [index % width as usize, index / width as usize].map(|k| k as f32 + 0.5);
    Vec2::new(x / width as f32, y / height as f32)
}

/// Evaluates `at` at each texel centre of an image, in the order of rows.
pub fn per_texel<T: Send>(size: (u32, u32), at: impl Fn(Vec2) -> T + Sync) -> Vec<T> {
    (0..size.0 as usize * size.1 as usize).into_par_iter().map(|index| at(texel_centre(index, size))).collect()
}

/// Returns the clear coat of a material, if the coat covers a part of the surface.
pub fn coat_of(material: &Material) -> Option<ClearCoat> {
    let coat = material.coat.as_ref().filter(|coat| coat.weight.factor > 0.0 && !material.unlit)?;
    Some(ClearCoat {
        weight: coat.weight.factor,
        alpha: coat.roughness_meaning.alpha(coat.roughness.factor),
        relief: if coat.follows_relief { CoatRelief::Base } else { CoatRelief::Smooth },
    })
}

/// Returns the medium behind a material, if light passes. `scale` is the number of metres per unit of the mesh.
pub fn medium_of(material: &Material, scale: f32) -> Option<Medium> {
    let passed = material.transmission.filter(|passed| passed.weight > 0.0 && !material.unlit)?;
    let color = DVec3::from(passed.attenuation_color.map(f64::from));
    let distance = f64::from(passed.attenuation_distance * scale);
    Some(Medium {
        weight: passed.weight,
        ior: passed.ior,
        thickness: passed.thickness * scale,
        extinction: extinction(color, distance).as_vec3().to_array(),
    })
}

/// Returns a material that reflects no light.
fn black(name: &str) -> Material {
    Material {
        base_color: Input::constant([0.0; 3]),
        f0: Input::constant([0.0; 3]),
        specular: Input::constant(0.0),
        roughness: Input::constant(1.0),
        ..Material::new(name)
    }
}

/// Returns the resolution of a material's finest texture, in texels across and down.
pub fn finest(material: &Material) -> (u32, u32) {
    let textures = [&material.base_color, &material.f0].into_iter().filter_map(|input| input.texture.as_ref());
    let numbers = [&material.metalness, &material.roughness, &material.specular];
    let numbers = numbers.into_iter().filter_map(|input| input.texture.as_ref());
    let anisotropy = material.anisotropy.as_ref().and_then(|a| a.direction.as_ref().or(a.strength.texture.as_ref()));
    let normal = material.normal_map.as_ref().map(|map| &map.texture).into_iter().chain(anisotropy);
    let heights = material.relief.as_ref().map(|relief| (relief.map.width, relief.map.height));
    let moments = material.slope_moments.as_ref().map(|level| (level.width, level.height));
    let sizes = textures.chain(numbers).chain(normal).map(texels_of).chain(heights).chain(moments);
    sizes.fold((1, 1), |a, b| (a.0.max(b.0), a.1.max(b.1)))
}

impl SampledMaterial {
    /// Prepares a material for sampling.
    pub fn new(material: &Material) -> Self {
        let heights = |relief: &Relief| Plate {
            width: relief.map.width,
            height: relief.map.height,
            texels: relief.map.texels.iter().map(|&h| [h]).collect(),
            transform: Affine2::IDENTITY,
            wrap: [TextureWrap::Repeat; 2],
        };
        let glowing = if material.unlit { &material.base_color } else { &material.emission };
        let opacity = match &material.opacity {
            Opacity::Opaque => None,
            Opacity::Mask { mask, cutoff } => Some((mask, Some(*cutoff))),
            Opacity::Blend { share } => Some((share, None)),
        };
        let image = |texture: Option<&Texture>| texture.map_or((1, 1), texels_of);
        let sizes = [
            image(glowing.texture.as_ref()),
            image(material.cones.as_ref().or(material.occlusion.texture.as_ref())),
            image(opacity.as_ref().and_then(|(input, _)| input.texture.as_ref())),
        ];
        if material.unlit {
            return Self {
                emission: color(glowing),
                opacity: opacity.map(|(input, cutoff)| (number(input), cutoff)),
                sizes,
                ..Self::new(&Material { unlit: false, opacity: Opacity::Opaque, ..black(&material.name) })
            };
        }
        Self {
            emission: color(glowing),
            occlusion: number(&material.occlusion),
            occlusion_strength: material.occlusion_strength,
            cones: material.cones.as_ref().map(cones),
            opacity: opacity.map(|(input, cutoff)| (number(input), cutoff)),
            sizes,
            base_color: color(&material.base_color),
            metalness: number(&material.metalness),
            roughness: number(&material.roughness),
            meaning: material.roughness_meaning,
            fit: material.fit.clone(),
            f0: color(&material.f0),
            specular: number(&material.specular),
            slopes: material.normal_map.as_ref().map(slopes),
            slope_moments: material.slope_moments.as_ref().filter(|_| material.normal_map.is_none()).map(slope_moments),
            anisotropy: material.anisotropy.as_ref().filter(|a| a.strength.factor > 0.0).map(|anisotropy| {
                SampledAnisotropy {
                    strength: number(&anisotropy.strength),
                    rotation: anisotropy.rotation,
                    direction: anisotropy.direction.as_ref().map(|texture| {
                        let signed = |x, y, channel| 2.0 * texture.raster.value(x, y, channel) - 1.0;
                        Plate::new(texture, |x, y| [signed(x, y, 0), signed(x, y, 1)])
                    }),
                }
            }),
            coat: SampledCoat::of(material),
            heights: material.relief.as_ref().map(heights),
            middle: material.relief.as_ref().map_or(0.0, |relief| relief.middle),
            scale: material.relief.as_ref().and_then(|relief| relief.scale),
            agreed: agreed_scale(material)
                .or_else(|| material.relief.as_ref().map(|relief| default_scale(material, relief)))
                .unwrap_or(USUAL_HEIGHT),
            size: finest(material),
        }
    }

    /// Returns the map of the clear coat over the chart of the colours, whose wrap modes are `wrap`. Without textures, it is `None`.
    pub fn coat_map(&self, wrap: [TextureWrap; 2]) -> Option<PropertyMap<CoatTexel>> {
        let coat = self.coat.as_ref()?;
        let (width, height) = coat.size;
        Some(PropertyMap { width, height, texels: per_texel(coat.size, |at| coat.texel(at)), wrap })
    }

    /// Whether the material emits light.
    pub fn emits(&self) -> bool {
        self.emission.factor != [0.0; 3]
    }

    /// Returns the emitted radiance at a texture coordinate, with `t` down.
    pub fn emission(&self, texcoord: Vec2) -> [f32; 3] {
        self.emission.at(texcoord)
    }

    /// Whether the material has ambient occlusion without direction. Cones replace it.
    pub fn is_occluded(&self) -> bool {
        self.cones.is_none()
            && self.occlusion_strength != 0.0
            && (self.occlusion.plate.is_some() || self.occlusion.factor != [1.0])
    }

    /// Whether the material has occlusion cones.
    pub fn has_cones(&self) -> bool {
        self.cones.is_some()
    }

    /// Returns the occlusion cone at a texture coordinate: the direction along `s`, `-t` and the normal, and the accessibility.
    pub fn cone(&self, texcoord: Vec2) -> Option<[f32; 4]> {
        self.cones.as_ref().map(|cones| cones.at(texcoord))
    }

    /// Returns the accessibility (1 − occlusion) at a texture coordinate.
    pub fn accessibility(&self, texcoord: Vec2) -> f32 {
        let [seen] = self.occlusion.at(texcoord);
        1.0 + self.occlusion_strength * (seen.clamp(0.0, 1.0) - 1.0)
    }

    /// Whether the material has an alpha mask or transparency.
    pub fn has_cutouts(&self) -> bool {
        self.opacity.is_some()
    }

    /// Returns the opacity at a texture coordinate. An alpha mask is remapped so that its cutoff is at one half.
    pub fn opacity(&self, texcoord: Vec2) -> f32 {
        let Some((property, cutoff)) = &self.opacity else { return 1.0 };
        let [value] = property.at(texcoord).map(|v| v.clamp(0.0, 1.0));
        match cutoff {
            None => value,
            // A cutoff of 0 passes every value, and a cutoff above 1 passes none.
            Some(cutoff) if *cutoff <= 0.0 => 1.0,
            // With an equal slope on both sides, the edge of the mask remains in place under interpolation.
            Some(cutoff) => 0.5 + 0.5 * (value - cutoff) / cutoff.max(1.0 - cutoff),
        }
    }

    /// Returns the cutout for a map of [`opacity`](Self::opacity) values.
    pub fn cutout(&self, map: PropertyMap<f32>) -> Option<Cutout> {
        let (_, cutoff) = self.opacity.as_ref()?;
        Some(if cutoff.is_some() { Cutout::Mask(map) } else { Cutout::Share(map) })
    }

    /// Adds emission, ambient occlusion and cutouts to a material map. Each of them has its own chart and wrap mode. `to_texcoord` maps the
    /// coordinates of a chart to those of the material.
    pub fn with_light(
        &self,
        map: MaterialMap,
        wraps: [[TextureWrap; 2]; 3],
        to_texcoord: impl Fn(Vec2) -> Vec2 + Sync,
    ) -> MaterialMap {
        fn property<T: Send>(
            (width, height): (u32, u32),
            wrap: [TextureWrap; 2],
            at: impl Fn(Vec2) -> T + Sync,
        ) -> PropertyMap<T> {
            PropertyMap { width, height, texels: per_texel((width, height), at), wrap }
        }
        let [emission, occlusion, opacity] = self.sizes;
        let cutout = || property(opacity, wraps[2], |at| self.opacity(to_texcoord(at)));
        MaterialMap {
            emission: self.emits().then(|| property(emission, wraps[0], |at| self.emission(to_texcoord(at)))),
            occlusion: self
                .is_occluded()
                .then(|| property(occlusion, wraps[1], |at| self.accessibility(to_texcoord(at)))),
            cones: self.cones.as_ref().map(|cones| property(occlusion, wraps[1], |at| cones.at(to_texcoord(at)))),
            opacity: self.has_cutouts().then(cutout).and_then(|map| self.cutout(map)),
            ..map
        }
    }

    /// Whether the material has heights.
    pub fn has_heights(&self) -> bool {
        self.heights.is_some()
    }

    /// Whether the material has slopes besides its heights.
    pub fn has_slopes(&self) -> bool {
        self.slopes.is_some() || self.slope_moments.is_some()
    }

    /// Whether the slopes vary within a texel.
    pub fn has_slope_spread(&self) -> bool {
        self.slope_moments.is_some()
    }

    /// Returns the colour, roughness and reflectance at a texture coordinate, with `t` down.
    pub fn texel(&self, texcoord: Vec2) -> Texel {
        let ([metal], [roughness]) = (self.metalness.at(texcoord), self.roughness.at(texcoord));
        let (base, metal, [specular]) =
            (self.base_color.at(texcoord), metal.clamp(0.0, 1.0), self.specular.at(texcoord));
        // If F0 is below that of real dielectrics, reflection is weaker at all angles.
        let f0 = self.f0.at(texcoord).map(|c| c.min(1.0) * specular);
        Texel {
            albedo: base.map(|c| (c * (1.0 - metal)).clamp(0.0, 1.0)),
            alpha: self.meaning.alpha(roughness.clamp(0.0, 1.0)),
            f0: lerp(f0, base, metal).map(|c| c.clamp(0.0, 1.0)),
            diffuse_f0: (f0.iter().sum::<f32>() / 3.0).clamp(0.0, 1.0),
        }
    }

    /// Evaluates [`texel`](Self::texel) for an image of the material's [`size`](Self::size). `to_texcoord` maps image to texture
    /// coordinates. With `fills`, the mean of the nearest opaque texels replaces each texel in a cutout.
    pub fn texels(&self, fills: bool, to_texcoord: impl Fn(Vec2) -> Vec2 + Sync) -> Vec<Texel> {
        let texels = per_texel(self.size, |at| self.texel(to_texcoord(at)));
        if !fills || !self.has_cutouts() {
            return texels;
        }
        // The smallest opacity at which the colour of a texel counts.
        let least = if matches!(self.opacity, Some((_, None))) { 1.0 / 255.0 } else { 0.5 };
        filled(&texels, self.size.into(), |index| self.opacity(to_texcoord(texel_centre(index, self.size))) >= least)
    }

    /// Returns the height at a texture coordinate, in the unit of the map. Without a map, it is the middle height.
    pub fn height(&self, texcoord: Vec2) -> f32 {
        self.heights.as_ref().map_or(self.middle, |plate| plate.at(texcoord)[0])
    }

    /// Returns the slope of the normal map at a texture coordinate, as rise over run by `s` and `t` (down). Without a normal map, the slope
    /// is 0.
    pub fn slope(&self, texcoord: Vec2) -> Vec2 {
        self.slopes.as_ref().map_or(Vec2::ZERO, |plate| Vec2::from(plate.at(texcoord)))
    }

    /// Whether the base is anisotropic.
    pub fn is_anisotropic(&self) -> bool {
        self.anisotropy.is_some()
    }

    /// Returns the anisotropy at a texture coordinate: `α_t = mix(α, 1, strength²)`, as in `KHR_materials_anisotropy`.
    pub fn anisotropy_at(&self, texcoord: Vec2) -> AnisotropySample {
        let Some(SampledAnisotropy { strength, rotation, direction }) = &self.anisotropy else {
            return AnisotropySample::default();
        };
        let stored = direction.as_ref().map_or(Vec2::X, |plate| Vec2::from(plate.at(texcoord)));
        let along = Vec2::from_angle(*rotation).rotate(stored.normalize_or(Vec2::X));
        let alpha = self.texel(texcoord).alpha;
        let [strength] = strength.at(texcoord);
        let more = alpha + (1.0 - alpha) * strength.clamp(0.0, 1.0).powi(2);
        AnisotropySample { along, variance: 0.5 * (more * more - alpha * alpha) }
    }

    /// Returns the variances `ss, tt` and the covariance `st` of the slopes in a texel, for heights that are multiplied by `scale` and a
    /// repeat of 1.
    pub fn slope_spread(&self, texcoord: Vec2, scale: f32) -> [f32; 3] {
        let Some([x, y, xx, yy, cross]) = self.slope_moments.as_ref().map(|plate| plate.at(texcoord)) else {
            return [0.0; 3];
        };
        let moments = Moments { mean_slope: [x, y], second: [xx, yy], cross, height: 0.0 };
        let square = f64::from(self.moment_scale(scale)).powi(2);
        moments.slope_covariance().map(|variance| (square * variance) as f32)
    }

    /// Returns the factor on the slope moments. Without heights, they are rise over run.
    fn moment_scale(&self, scale: f32) -> f32 {
        if self.has_heights() { scale } else { 1.0 }
    }

    /// Returns the relief slope at a texture coordinate. The slope comes from the normal map, from the slope moments, or from central
    /// differences of heights that are multiplied by `scale`, for a repeat of 1.
    pub fn relief_slope(&self, texcoord: Vec2, scale: f32) -> Vec2 {
        if let Some([x, y, ..]) = self.slope_moments.as_ref().map(|plate| plate.at(texcoord)) {
            return self.moment_scale(scale) * Vec2::new(x, y);
        }
        let Some(heights) = self.heights.as_ref().filter(|_| self.slopes.is_none()) else {
            return self.slope(texcoord);
        };
        let step = Vec2::new(1.0 / heights.width as f32, 1.0 / heights.height as f32);
        let across = |d: Vec2| (heights.at(texcoord + d)[0] - heights.at(texcoord - d)[0]) * scale / (2.0 * d.length());
        Vec2::new(across(step * Vec2::X), across(step * Vec2::Y))
    }

    /// Returns the number of texture repeats per unit of height, for repeats of `repeat` metres. This scale comes from the file's scale,
    /// the fit to the normals, or the default ([`USUAL_HEIGHT`], limited by [`leadr_maps::derive::USUAL_SLOPE`]).
    pub fn unit(&self, repeat: f32) -> f32 {
        self.scale.map_or(self.agreed, |metres| metres / repeat)
    }

    /// Builds a map of albedo, roughness and reflectance from the results of [`texel`](Self::texel).
    pub fn map(&self, (width, height): (u32, u32), texels: &[Texel]) -> MaterialMap {
        let opaque = |c: [f32; 3]| {
            let [r, g, b] = c.map(srgb8_from_linear);
            [r, g, b, u8::MAX]
        };
        let colors: Vec<[u8; 4]> = texels.par_iter().map(|t| color_code(t.albedo, t.alpha)).collect();
        let f0: Vec<[u8; 4]> = texels.par_iter().map(|t| opaque(t.f0)).collect();
        // The dielectric reflectance is stored with the object.
        let own = opaque([texels[0].diffuse_f0; 3]);
        let f0 = f0.iter().any(|texel| *texel != own).then_some(f0);
        MaterialMap { f0, fit: self.fit.clone(), ..MaterialMap::new(width, height, colors) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use leadr_maps::HeightMap;
    use leadr_maps::derive::USUAL_SLOPE;

    #[test]
    fn a_usual_relief_is_not_steep() {
        let waves = |times: f32| {
            let height = |x: u32| 0.5 + 0.5 * (std::f32::consts::TAU * times * x as f32 / 256.0).sin();
            let mut material = Material::new("waves");
            let map = HeightMap { width: 256, height: 1, texels: (0..256).map(height).collect() };
            material.relief = Some(Relief { map, scale: None, in_widths: false, middle: 0.5 });
            material
        };
        // The default height limits the relief of maps with few waves. The default slope limits the relief of maps with many waves.
        assert_eq!(SampledMaterial::new(&waves(1.0)).unit(2.0), USUAL_HEIGHT);
        let many = SampledMaterial::new(&waves(20.0));
        let slope = many.unit(2.0) * 20.0 * std::f32::consts::PI * 0.5f32.sqrt();
        assert!((slope / USUAL_SLOPE - 1.0).abs() < 0.03, "{slope}");
        // If the file has a scale, it is used unchanged.
        let mut stored = waves(20.0);
        stored.relief.as_mut().unwrap().scale = Some(0.3);
        assert_eq!(SampledMaterial::new(&stored).unit(2.0), 0.15);
    }
}
