//! Writes the textures of a material with filtered mip levels: base colour, normals, emission, and one texture with roughness, occlusion
//! and metalness in the channels that the engine reads.

use std::borrow::Cow;

use leadr_maps::material::{Encoding, GreenAxis, Input, Material, NormalMap, Opacity, Raster, Samples};
use leadr_maps::mips::{Alpha, MipLevel, Mips, NormalMips, RoughnessSource, color_mips, roughness_mips};

use crate::blocks::{BLOCK_SIDE, whole_blocks};
use crate::engine::{Engine, Packing};
use crate::model::{FilterError, FilteredTexture};

/// The textures of a material.
#[derive(Clone, Debug)]
pub struct FilteredMaterial {
    /// The textures, with the bytes of their files. Their names are ends of file names, such as `_Normal.ktx2`.
    pub files: Vec<(FilteredTexture, Vec<u8>)>,
    /// What is missing or left out, one line each.
    pub remarks: Vec<String>,
}

/// Filters the textures of a material. `progress` receives the number of finished textures and the number of all.
///
/// # Errors
/// Fails if the material has no texture, or if all of them are smaller than a block.
pub fn filter_material(
    material: &Material,
    engine: Engine,
    progress: &mut dyn FnMut(usize, usize),
) -> Result<FilteredMaterial, FilterError> {
    let mut remarks = Vec::new();
    let normals = material
        .normal_map
        .as_ref()
        .map(|map| in_blocks(&in_engine(map, engine.green()), Encoding::Linear, engine).into_owned());
    // The scale is a factor of the engine's material. In the textures it is part of the normals only where the spread is found.
    let scale = material.normal_map.as_ref().map_or(1.0, |map| map.scale);
    let normals = normals.map(|raster| NormalMips::new(&raster, scale));
    let mut parts: Vec<Part<'_>> = Vec::new();
    if let Some(texture) = &material.base_color.texture {
        parts.push(Part { name: "BaseColor", role: "colour", of: Source::BaseColor(&texture.raster) });
    }
    if normals.is_some() {
        parts.push(Part { name: "Normal", role: "normals", of: Source::Normals });
    }
    let packing = engine.packing();
    let scalars = [&material.occlusion, &material.roughness, &material.metalness];
    if normals.is_some() || scalars.iter().any(|input| input.texture.is_some()) {
        parts.push(Part { name: packing.name, role: "roughness", of: Source::Packed });
    }
    if let Some(texture) = &material.emission.texture {
        parts.push(Part { name: "Emissive", role: "colour", of: Source::Emission(&texture.raster) });
    }
    if normals.is_none() && !parts.is_empty() {
        remarks.push("the material has no normal map, so its roughness contains no spread of normals".to_owned());
    }
    let count = parts.len();
    let mut files: Vec<(FilteredTexture, Vec<u8>)> = Vec::new();
    for (i, part) in parts.into_iter().enumerate() {
        progress(i, count);
        let mips = match part.of {
            Source::BaseColor(raster) => {
                let (raster, alpha) = with_opacity(raster, &material.opacity);
                color_mips(&in_blocks(&raster, Encoding::Srgb, engine), alpha)
            }
            Source::Emission(raster) => color_mips(&in_blocks(raster, Encoding::Srgb, engine), Alpha::Ignored),
            Source::Normals => normals.as_ref().expect("a part for normals").mips(),
            Source::Packed => packed(material, normals.as_ref(), packing, engine),
        };
        let size = mips.levels[0].size;
        if engine.has_blocks() && size.iter().any(|side| *side < BLOCK_SIDE) {
            remarks.push(format!(
                "{} has {} x {} texels, fewer than a block, and is left out",
                part.name, size[0], size[1]
            ));
            continue;
        }
        if !size.iter().all(|side| side.is_power_of_two()) && engine == Engine::Unreal {
            remarks.push(format!(
                "{} has {} x {} texels; Unreal keeps mip levels only of powers of two",
                part.name, size[0], size[1]
            ));
        }
        let roughness = matches!(part.of, Source::Packed).then(|| {
            let mean = |level: &MipLevel| {
                let codes: f32 = level.texels.iter().map(|texel| f32::from(texel[packing.roughness])).sum();
                let mean = codes / (255.0 * level.texels.len() as f32);
                if packing.smoothness { 1.0 - mean } else { mean }
            };
            [mean(&mips.levels[0]), mean(&mips.levels[mips.levels.len() - 1])]
        });
        let bytes = engine.file(&mips);
        let name = format!("_{}.{}", part.name, engine.suffix());
        files.push((FilteredTexture { name, role: part.role, size, bytes: bytes.len() as u64, roughness }, bytes));
    }
    progress(count, count);
    if files.is_empty() {
        return Err(FilterError::NoTexture);
    }
    Ok(FilteredMaterial { files, remarks })
}

struct Part<'a> {
    name: &'static str,
    role: &'static str,
    of: Source<'a>,
}

enum Source<'a> {
    BaseColor(&'a Raster),
    Emission(&'a Raster),
    Normals,
    Packed,
}

/// Returns the codes of normals with three channels whose green points in a direction.
fn in_engine(map: &NormalMap, green: GreenAxis) -> Cow<'_, Raster> {
    let raster = &*map.texture.raster;
    let has_vectors = raster.channels() >= 3 && map.texture.encoding != Encoding::Slopes;
    if has_vectors && map.green == green {
        return Cow::Borrowed(raster);
    }
    let [width, height] = raster.size();
    let sign = if green == GreenAxis::Up { 1.0 } else { -1.0 };
    let texel = |x, y| {
        if has_vectors {
            return [raster.value(x, y, 0), 1.0 - raster.value(x, y, 1), raster.value(x, y, 2)];
        }
        // Slopes along t, which points down, and without the scale of the map.
        let [s, t] = map.slope(x, y).map(|slope| slope as f32 / map.scale.max(1e-6));
        let length = (1.0 + s * s + t * t).sqrt();
        [-s, sign * t, 1.0].map(|v| 0.5 + 0.5 * v / length)
    };
    let samples = (0..height).flat_map(|y| (0..width).flat_map(move |x| texel(x, y))).map(code16).collect();
    Cow::Owned(Raster::new(width, height, 3, Samples::U16(samples)).expect("three values a texel"))
}

/// Returns the colours with the mask of the material as their alpha, and what the alpha means.
fn with_opacity<'a>(colors: &'a Raster, opacity: &Opacity) -> (Cow<'a, Raster>, Alpha) {
    let (mask, alpha) = match opacity {
        Opacity::Opaque => return (Cow::Borrowed(colors), Alpha::Ignored),
        Opacity::Mask { mask, cutoff } => (mask, Alpha::Masked { cutoff: *cutoff }),
        Opacity::Blend { share } => (share, Alpha::Blended),
    };
    let [width, height] = colors.size();
    let mask = Scalar::new(mask, colors.size());
    let texel = |x, y| [colors.value(x, y, 0), colors.value(x, y, 1), colors.value(x, y, 2), mask.at(x, y)];
    let samples = (0..height).flat_map(|y| (0..width).flat_map(move |x| texel(x, y))).map(code16).collect();
    (Cow::Owned(Raster::new(width, height, 4, Samples::U16(samples)).expect("four values a texel")), alpha)
}

/// Returns the texture with roughness, occlusion and metalness.
fn packed(material: &Material, normals: Option<&NormalMips>, packing: Packing, engine: Engine) -> Mips {
    let scalars = [&material.roughness, &material.occlusion, &material.metalness];
    let sizes = scalars.iter().filter_map(|input| input.texture.as_ref()).map(|texture| texture.raster.size());
    // The roughness decides, then the normals, whose spread it gets.
    let size = material.roughness.texture.as_ref().map(|texture| texture.raster.size());
    let size = size.or(normals.map(NormalMips::size)).or(sizes.max()).unwrap_or([1, 1]);
    let [roughness, occlusion, metalness] = scalars.map(|input| Scalar::new(input, size));
    let [width, height] = size;
    let texel = |x, y| {
        let mut texel = [0.0, 0.0, 0.0, if packing.roughness == 3 { 0.0 } else { 1.0 }];
        texel[packing.roughness] = material.roughness_meaning.alpha(roughness.at(x, y).clamp(0.0, 1.0)).sqrt();
        let strength = material.occlusion_strength;
        texel[packing.occlusion] = 1.0 - strength + strength * occlusion.at(x, y);
        texel[packing.metalness] = metalness.at(x, y);
        texel
    };
    let samples = (0..height).flat_map(|y| (0..width).flat_map(|x| texel(x, y)).collect::<Vec<_>>());
    let raster =
        Raster::new(width, height, 4, Samples::U16(samples.map(code16).collect())).expect("four values a texel");
    let raster = in_blocks(&raster, Encoding::Linear, engine);
    let source = RoughnessSource { raster: Some(&raster), channel: packing.roughness, factor: 1.0 };
    let mut mips = roughness_mips(source, normals);
    if packing.smoothness {
        for texel in mips.levels.iter_mut().flat_map(|level| &mut level.texels) {
            texel[packing.roughness] = u8::MAX - texel[packing.roughness];
        }
    }
    mips
}

/// A property over texels of a size.
struct Scalar<'a> {
    factor: f32,
    raster: Option<Cow<'a, Raster>>,
    channel: usize,
}

impl<'a> Scalar<'a> {
    fn new(input: &'a Input<f32>, size: [u32; 2]) -> Self {
        let raster = input.texture.as_ref().map(|texture| &*texture.raster);
        let raster = raster.map(|raster| match raster.size() == size {
            true => Cow::Borrowed(raster),
            false => Cow::Owned(raster.resampled(size, Encoding::Linear)),
        });
        Self { factor: input.factor, raster, channel: input.channel }
    }

    fn at(&self, x: u32, y: u32) -> f32 {
        self.factor * self.raster.as_ref().map_or(1.0, |raster| raster.value(x, y, self.channel))
    }
}

/// Returns an image as the files of the engine hold it.
fn in_blocks(raster: &Raster, encoding: Encoding, engine: Engine) -> Cow<'_, Raster> {
    if engine.has_blocks() { whole_blocks(raster, encoding) } else { Cow::Borrowed(raster) }
}

fn code16(value: f32) -> u16 {
    (value.clamp(0.0, 1.0) * 65535.0).round() as u16
}
