//! Materials. The reader supports core metallic-roughness, and extensions for dielectrics, emission, anisotropy, clear coats and
//! transmission.

use std::collections::HashSet;
use std::sync::Arc;

use super::extensions::{
    ANISOTROPY, CLEAR_COAT, EMISSIVE_STRENGTH, IOR, SPECULAR, SPECULAR_GLOSSINESS, TRANSMISSION, UNLIT, VOLUME,
};
use super::json::{Item, Read};
use super::log::Log;
use super::meshes;
use super::source::Source;
use super::textures::{Purpose, Textures};
use super::uri;
use crate::fault::{ModelFault, shown};
use crate::limits::{COORDINATES, MAX_COORDINATE};
use leadr_maps::material::{
    Anisotropy, ClearCoat, Gloss, GreenAxis, Input, Material, NormalMap, Opacity, Raster, Relief, RoughnessMeaning,
    Samples, Texture, Transmission, f0_of_ior,
};
use leadr_maps::srgb::srgb8_from_linear;
use leadr_maps::{HeightMap, ImageHeader, decode_heights};

/// The key of the displacement map in a material's `extras`.
const DISPLACEMENT: &str = "leadr_displacement";

/// Reads the materials that primitives use. The others have only their names.
pub(super) fn read(source: &Source<'_>) -> Read<Vec<Material>> {
    let items = source.root.items("materials", "material")?;
    let mut used = vec![source.log.strict; items.len()];
    // The reader of meshes reports what is wrong with them.
    let quiet = Log::default();
    for mesh in source.root.items("meshes", "mesh")? {
        for primitive in mesh.quietly(&quiet).items("primitives", "primitive").unwrap_or_default() {
            if let Ok(Some(material)) = meshes::material(source, &primitive, items.len()) {
                used[material] = true;
            }
        }
    }
    let mut textures = HashSet::new();
    for (item, _) in items.iter().zip(&used).filter(|(_, used)| **used) {
        textures.extend(item.whole_numbers_below("index"));
    }
    if source.log.strict {
        textures.extend(0..source.root.length("textures")?);
    }
    let textures = Textures::read(source, &textures)?;
    let read = |(number, (item, used)): (usize, (&Item<'_>, bool))| -> Read<Material> {
        let mut material = default();
        let name = item.name()?;
        material.name = if name.is_empty() { format!("material {number}") } else { name };
        if used {
            Reader { source, textures: &textures, item }.read(&mut material)?;
        }
        Ok(material)
    };
    items.iter().zip(used).enumerate().map(read).collect()
}

/// Returns the material of primitives that have none.
pub(super) fn default() -> Material {
    Material {
        base_color: Input::constant([1.0; 3]),
        metalness: Input::constant(1.0),
        roughness: Input::constant(1.0),
        ..Material::new("default")
    }
}

struct Reader<'a> {
    source: &'a Source<'a>,
    textures: &'a Textures<'a>,
    item: &'a Item<'a>,
}

impl<'a> Reader<'a> {
    fn read(&self, material: &mut Material) -> Read<()> {
        let item = self.item;
        let opacity = match item.extension(SPECULAR_GLOSSINESS)? {
            Some(extension) => self.specular_glossiness(&extension, material)?,
            None => self.base(material)?,
        };
        material.opacity = self.opacity(opacity)?;
        material.double_sided = item.flag("doubleSided", false)?;
        material.unlit = item.extension(UNLIT)?.is_some();
        material.normal_map = self.normal_map()?;
        if let Some((texture, info)) = self.textures.get(item, "occlusionTexture", Purpose::Number)? {
            material.occlusion = Input::texture(texture, 0);
            material.occlusion_strength = info.number("strength", 0.0..=1.0)?.unwrap_or(1.0);
        }
        material.emission = self.emission()?;
        self.dielectric(material)?;
        material.anisotropy = self.anisotropy()?;
        material.transmission = self.transmission()?;
        material.coat = self.clear_coat(material.normal_map.as_ref())?;
        material.relief = self.relief()?;
        Ok(())
    }

    /// Reads base colour, metalness and roughness into `material`. Returns the opacity.
    fn base(&self, material: &mut Material) -> Read<Input<f32>> {
        let mut alpha = Input::constant(1.0);
        let Some(item) = self.item.item("pbrMetallicRoughness")? else { return Ok(alpha) };
        let [r, g, b, a] = item.vector("baseColorFactor", 0.0..=1.0)?.unwrap_or([1.0; 4]);
        (material.base_color.factor, alpha.factor) = ([r, g, b], a);
        if let Some((texture, _)) = self.textures.get(&item, "baseColorTexture", Purpose::Color)? {
            alpha.texture = Some(texture.clone());
            alpha.channel = 3;
            material.base_color.texture = Some(texture);
        }
        material.metalness.factor = item.number("metallicFactor", 0.0..=1.0)?.unwrap_or(1.0);
        material.roughness.factor = item.number("roughnessFactor", 0.0..=1.0)?.unwrap_or(1.0);
        material.roughness_meaning = RoughnessMeaning::Perceptual;
        if let Some((texture, _)) = self.textures.get(&item, "metallicRoughnessTexture", Purpose::Number)? {
            (material.roughness.channel, material.metalness.channel) = (1, 2);
            material.roughness.texture = Some(texture.clone());
            material.metalness.texture = Some(texture);
        }
        Ok(alpha)
    }

    /// Reads diffuse colour, specular colour and gloss into `material`. Returns the opacity.
    ///
    /// The specular colour is the reflectance at normal incidence, and takes its strongest channel from the diffuse colour.
    fn specular_glossiness(&self, extension: &Item<'a>, material: &mut Material) -> Read<Input<f32>> {
        let mut alpha = Input::constant(1.0);
        let [r, g, b, a] = extension.vector("diffuseFactor", 0.0..=1.0)?.unwrap_or([1.0; 4]);
        (material.base_color.factor, alpha.factor) = ([r, g, b], a);
        let specular: [f32; 3] = extension.vector("specularFactor", 0.0..=1.0)?.unwrap_or([1.0; 3]);
        material.metalness = Input::constant(0.0);
        material.f0.factor = specular;
        material.roughness.factor = extension.number("glossinessFactor", 0.0..=1.0)?.unwrap_or(1.0);
        material.roughness_meaning = RoughnessMeaning::Gloss(Gloss::Perceptual);
        let diffuse = self.textures.get(extension, "diffuseTexture", Purpose::Color)?.map(|(texture, _)| texture);
        alpha.texture = diffuse.clone();
        alpha.channel = 3;
        material.base_color.texture = diffuse;
        match self.textures.get(extension, "specularGlossinessTexture", Purpose::Color)? {
            Some((texture, _)) => {
                let raster = dimmed(material.base_color.texture.as_ref(), &texture, specular, self.source)?;
                let under = material.base_color.texture.as_ref().unwrap_or(&texture);
                material.base_color.texture = Some(Texture { raster: Arc::new(raster), ..under.clone() });
                material.roughness.channel = 3;
                material.roughness.texture = Some(texture.clone());
                material.f0.texture = Some(texture);
            }
            None => {
                let rest = 1.0 - specular.into_iter().fold(0.0, f32::max);
                material.base_color.factor = [r, g, b].map(|color| color * rest);
            }
        }
        Ok(alpha)
    }

    fn opacity(&self, alpha: Input<f32>) -> Read<Opacity> {
        let cutoff = self.item.number("alphaCutoff", 0.0..=MAX_COORDINATE)?.unwrap_or(0.5);
        Ok(match self.item.string("alphaMode")? {
            None | Some("OPAQUE") => Opacity::Opaque,
            Some("MASK") => Opacity::Mask { mask: alpha, cutoff },
            Some("BLEND") => Opacity::Blend { share: alpha },
            Some(other) => {
                let (location, other) = (self.item.location, shown(other));
                let fault = location.fault(format!("alpha mode {other} is unknown"));
                self.source.log.repair(fault, "it is drawn as opaque")?;
                Opacity::Opaque
            }
        })
    }

    fn normal_map(&self) -> Read<Option<NormalMap>> {
        let found = self.textures.get(self.item, "normalTexture", Purpose::Direction)?;
        let Some((texture, info)) = found else { return Ok(None) };
        let scale = info.number("scale", COORDINATES)?.unwrap_or(1.0);
        Ok(Some(NormalMap { texture, green: GreenAxis::Up, scale }))
    }

    fn emission(&self) -> Read<Input<[f32; 3]>> {
        let mut factor = self.item.vector::<3>("emissiveFactor", 0.0..=MAX_COORDINATE)?.unwrap_or([0.0; 3]);
        if let Some(most) = factor.into_iter().find(|&factor| factor > 1.0) {
            let fault = self.item.fault(format!("`emissiveFactor` is {most}, but must be at most 1"));
            // A value just above 1 is a rounding error, and older exporters wrote the strength into the factor.
            self.source.log.repair(fault, "it is read as the strength of the emission")?;
            factor = factor.map(|factor| if factor < 1.0 + 1e-3 { factor.min(1.0) } else { factor });
        }
        let strength = match self.item.extension(EMISSIVE_STRENGTH)? {
            Some(extension) => extension.number("emissiveStrength", 0.0..=MAX_COORDINATE)?.unwrap_or(1.0),
            None => 1.0,
        };
        let texture = self.textures.get(self.item, "emissiveTexture", Purpose::Color)?.map(|(texture, _)| texture);
        Ok(Input { factor: factor.map(|f: f32| f * strength), texture, channel: 0 })
    }

    /// Reads the reflectance of dielectrics: the index of refraction, and the specular colour and strength.
    fn dielectric(&self, material: &mut Material) -> Read<()> {
        if let Some(ior) = self.ior()? {
            material.f0.factor = [f0_of_ior(ior); 3];
        }
        let Some(extension) = self.item.extension(SPECULAR)? else { return Ok(()) };
        let color: [f32; 3] = extension.vector("specularColorFactor", 0.0..=MAX_COORDINATE)?.unwrap_or([1.0; 3]);
        let f0 = material.f0.factor;
        material.f0.factor = std::array::from_fn(|c| f0[c] * color[c]);
        material.f0.texture =
            self.textures.get(&extension, "specularColorTexture", Purpose::Color)?.map(|(texture, _)| texture);
        material.specular.factor = extension.number("specularFactor", 0.0..=1.0)?.unwrap_or(1.0);
        if let Some((texture, _)) = self.textures.get(&extension, "specularTexture", Purpose::Number)? {
            material.specular.texture = Some(texture);
            material.specular.channel = 3;
        }
        Ok(())
    }

    /// Reads the refractive index. A value of 0 means that everything is reflected, which also follows from the formula.
    fn ior(&self) -> Read<Option<f32>> {
        let Some(extension) = self.item.extension(IOR)? else { return Ok(None) };
        let ior = extension.number("ior", 0.0..=MAX_COORDINATE)?.unwrap_or(1.5);
        if ior > 0.0 && ior < 1.0 {
            let fault = extension.fault(format!("`ior` is {ior}, but must be 0, or at least 1"));
            self.source.log.repair(fault, "it is read as 1.5")?;
            return Ok(Some(1.5));
        }
        Ok(Some(ior))
    }

    /// Reads the light that passes through the material. Textures count with their mean.
    fn transmission(&self) -> Read<Option<Transmission>> {
        let Some(extension) = self.item.extension(TRANSMISSION)? else { return Ok(None) };
        let mean = |item: &Item<'a>, name, channel| {
            let found = self.textures.get(item, name, Purpose::Number)?;
            Ok(found.map_or(1.0, |(texture, _)| mean_of(&texture.raster, channel)))
        };
        let factor = extension.number("transmissionFactor", 0.0..=1.0)?.unwrap_or(0.0);
        let mut passed = Transmission {
            weight: factor * mean(&extension, "transmissionTexture", 0)?,
            ior: self.ior()?.unwrap_or(1.5).max(1.0),
            thickness: 0.0,
            attenuation_color: [1.0; 3],
            attenuation_distance: f32::INFINITY,
        };
        if let Some(volume) = self.item.extension(VOLUME)? {
            let thickness = volume.number("thicknessFactor", 0.0..=MAX_COORDINATE)?.unwrap_or(0.0);
            passed.thickness = thickness * mean(&volume, "thicknessTexture", 1)?;
            passed.attenuation_color = volume.vector("attenuationColor", 0.0..=1.0)?.unwrap_or([1.0; 3]);
            let distance = volume.number("attenuationDistance", 0.0..=MAX_COORDINATE)?;
            passed.attenuation_distance = distance.filter(|distance| *distance > 0.0).unwrap_or(f32::INFINITY);
        }
        Ok(Some(passed))
    }

    fn anisotropy(&self) -> Read<Option<Anisotropy>> {
        let Some(extension) = self.item.extension(ANISOTROPY)? else { return Ok(None) };
        let mut strength = Input::constant(extension.number("anisotropyStrength", 0.0..=1.0)?.unwrap_or(0.0));
        let rotation = extension.number("anisotropyRotation", COORDINATES)?.unwrap_or(0.0);
        let texture = self.textures.get(&extension, "anisotropyTexture", Purpose::Direction)?;
        let direction = texture.map(|(texture, _)| texture);
        if let Some(texture) = &direction {
            strength.texture = Some(texture.clone());
            strength.channel = 2;
        }
        Ok(Some(Anisotropy { strength, rotation, direction }))
    }

    /// Reads a clear coat. Without a normal texture of its own, the coat is smooth. With the `normals` of the material, it follows the relief.
    fn clear_coat(&self, normals: Option<&NormalMap>) -> Read<Option<ClearCoat>> {
        let Some(extension) = self.item.extension(CLEAR_COAT)? else { return Ok(None) };
        let number = |factor, texture, channel| {
            let mut input = Input::constant(extension.number(factor, 0.0..=1.0)?.unwrap_or(0.0));
            if let Some((texture, _)) = self.textures.get(&extension, texture, Purpose::Number)? {
                (input.texture, input.channel) = (Some(texture), channel);
            }
            Ok(input)
        };
        let found = self.textures.get(&extension, "clearcoatNormalTexture", Purpose::Direction)?;
        let normal_map = match found {
            Some((texture, info)) => {
                let scale = info.number("scale", COORDINATES)?.unwrap_or(1.0);
                Some(NormalMap { texture, green: GreenAxis::Up, scale })
            }
            None => None,
        };
        let follows_relief = normal_map.is_some() && normal_map.as_ref() == normals;
        Ok(Some(ClearCoat {
            weight: number("clearcoatFactor", "clearcoatTexture", 0)?,
            roughness: number("clearcoatRoughnessFactor", "clearcoatRoughnessTexture", 1)?,
            roughness_meaning: RoughnessMeaning::Perceptual,
            follows_relief,
            normal_map: normal_map.filter(|_| !follows_relief),
        }))
    }

    /// Reads the displacement map from `extras`: `"leadr_displacement": {"uri": "bark.png", "scale": 0.02, "middle": 0.5}`.
    fn relief(&self) -> Read<Option<Relief>> {
        // Other programs also use `extras`, which need not be an object.
        let Some(extras) = self.item.object_or_nothing("extras") else { return Ok(None) };
        let Some(item) = extras.item(DISPLACEMENT)? else { return Ok(None) };
        let map = item.required("uri", Item::string).and_then(|uri| self.heights(&item, uri));
        match map {
            Ok(map) => Ok(Some(Relief {
                map,
                scale: item.number("scale", 0.0..=MAX_COORDINATE)?,
                in_widths: false,
                middle: item.number("middle", COORDINATES)?.unwrap_or(0.5),
            })),
            Err(fault) => self.source.log.repair(fault, "the surface is not displaced").map(|()| None),
        }
    }

    fn heights(&self, item: &Item<'_>, uri: &str) -> Read<HeightMap> {
        let bytes = uri::fetch(uri, self.source.folder, item.location, u64::MAX, self.source.log)?;
        let fault = |fault| ModelFault::Image { location: format!("{} ({})", item.location, shown(uri)), fault };
        let length = bytes.len() as u64;
        // Decoding reports damaged headers.
        if let Ok(header) = ImageHeader::read(&bytes, length) {
            let heights = header.texels() * size_of::<f32>() as u64;
            self.source.image_budget.take(length + header.decoded_bytes() + heights).map_err(fault)?;
        }
        let mut remarks = Vec::new();
        let map = decode_heights(&bytes, &mut remarks).map_err(fault);
        let place = format!("{} ({})", item.location, shown(uri));
        remarks.iter().for_each(|text| self.source.log.remark(format!("{place}: {text}")));
        map
    }
}

/// Returns the mean of a channel of an image.
fn mean_of(raster: &Raster, channel: usize) -> f32 {
    let texels = (0..raster.height()).flat_map(|y| (0..raster.width()).map(move |x| (x, y)));
    let sum: f64 = texels.map(|(x, y)| f64::from(raster.value(x, y, channel))).sum();
    (sum / (f64::from(raster.width()) * f64::from(raster.height()))) as f32
}

/// Returns the diffuse colours under a specular texture, which reflects its strongest channel.
fn dimmed(diffuse: Option<&Texture>, specular: &Texture, factor: [f32; 3], source: &Source<'_>) -> Read<Raster> {
    let size = &diffuse.unwrap_or(specular).raster;
    let (width, height) = (size.width(), size.height());
    let fault = |fault| ModelFault::Image { location: specular.name.clone(), fault };
    source.image_budget.take(3 * u64::from(width) * u64::from(height)).map_err(fault)?;
    let of = &specular.raster;
    let mut texels = Vec::with_capacity(3 * width as usize * height as usize);
    for (y, x) in (0..height).flat_map(|y| (0..width).map(move |x| (y, x))) {
        let at = |i: u32, count: u32, others: u32| (u64::from(i) * u64::from(others) / u64::from(count)) as u32;
        let reflected = of.color(at(x, width, of.width()), at(y, height, of.height()), specular.encoding);
        let strongest = reflected.into_iter().zip(factor).map(|(color, factor)| color * factor).fold(0.0, f32::max);
        let color = diffuse.map_or([1.0; 3], |diffuse| diffuse.raster.color(x, y, diffuse.encoding));
        texels.extend(color.map(|color| srgb8_from_linear(color * (1.0 - strongest))));
    }
    Raster::new(width, height, 3, Samples::U8(texels)).map_err(fault)
}
