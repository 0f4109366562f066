//! Textures. Each has an image, addressing modes, a coordinate set and a transform.

use std::collections::HashSet;
use std::f32::consts::TAU;
use std::sync::Arc;

use glam::{Affine2, Mat2, Vec2};

use super::extensions::{TEXTURE_TRANSFORM, TEXTURES, WEBP};
use super::images::{self, Image};
use super::json::{Item, Read};
use super::source::Source;
use crate::limits::COORDINATES;
use leadr_maps::material::{Encoding, Raster, Samples, Texture, TextureWrap};

#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Purpose {
    Color,
    Number,
    Direction,
}

pub(super) struct Textures<'a> {
    source: &'a Source<'a>,
    images: Vec<Image>,
    entries: Vec<Entry>,
}

struct Entry {
    extended: bool,
    image: Option<usize>,
    wrap: [TextureWrap; 2],
}

impl<'a> Textures<'a> {
    /// Reads all textures, and decodes the images of those in `used`.
    pub(super) fn read(source: &'a Source<'a>, used: &HashSet<usize>) -> Read<Self> {
        let samplers = source.root.items("samplers", "sampler")?;
        let wraps =
            samplers.iter().map(|sampler| Ok([wrap(source, sampler, "wrapS")?, wrap(source, sampler, "wrapT")?]));
        let wraps = wraps.collect::<Read<Vec<_>>>()?;
        let images = source.root.length("images")?;
        let entry = |item: &Item<'_>| {
            let sampler = item.index("sampler", "sampler", wraps.len())?;
            let of_extension = |name| -> Read<Option<usize>> {
                match item.extension(name)? {
                    Some(extension) => extension.index("source", "image", images),
                    None => Ok(None),
                }
            };
            // The other formats come after the plain image, which every program reads.
            let mut image = of_extension(WEBP)?.or(item.index("source", "image", images)?);
            for name in TEXTURES {
                image = image.or(of_extension(name)?);
            }
            Ok(Entry {
                extended: item.has("extensions"),
                image,
                wrap: sampler.map_or([TextureWrap::Repeat; 2], |sampler| wraps[sampler]),
            })
        };
        let items = source.root.items("textures", "texture")?;
        let entries = items.iter().map(entry).collect::<Read<Vec<_>>>()?;
        let used = entries.iter().enumerate().filter(|(number, _)| used.contains(number));
        let images = images::read(source, &used.filter_map(|(_, entry)| entry.image).collect())?;
        Ok(Self { source, images, entries })
    }

    /// Returns the texture of a material property, together with its info object. Returns `None` if the texture is missing.
    /// Also returns `None` for a texture of directions whose image is unreadable.
    pub(super) fn get(
        &self,
        material: &Item<'a>,
        key: &'static str,
        purpose: Purpose,
    ) -> Read<Option<(Texture, Item<'a>)>> {
        let log = self.source.log;
        let Some(info) = material.item(key)? else { return Ok(None) };
        let index = match info.required("index", |info, key| info.index(key, "texture", self.entries.len())) {
            Ok(index) => index,
            Err(fault) => {
                log.repair(fault, "the texture is ignored")?;
                return Ok(None);
            }
        };
        let entry = &self.entries[index];
        let image = entry.image.map(|image| &self.images[image]);
        let raster = image.and_then(|image| image.raster.clone());
        if image.is_none() && !entry.extended {
            log.remark(format!("{}: texture {index} has no image; it is ignored", info.location));
            return Ok(None);
        }
        if image.is_none_or(|image| image.raster.is_none() && !image.found) {
            let fault = info.fault(format!("texture {index} has no image in a supported format (PNG or JPEG)"));
            log.repair(fault, "a replacement is used")?;
        }
        let raster = match (raster, purpose) {
            (Some(raster), _) => raster,
            (None, Purpose::Color) => checks(),
            (None, Purpose::Number) => white(),
            (None, Purpose::Direction) => return Ok(None),
        };
        let (coordinates, transform) = coordinates(&info)?;
        let texture = Texture {
            raster,
            name: image.map_or_else(|| info.location.to_string(), |image| image.name.clone()),
            encoding: if purpose == Purpose::Color { Encoding::Srgb } else { Encoding::Linear },
            coordinates,
            transform,
            wrap: entry.wrap,
        };
        Ok(Some((texture, info)))
    }
}

fn coordinates(info: &Item<'_>) -> Read<(u32, Affine2)> {
    const MAX_SET: usize = 1 << 10;
    let set = info.index("texCoord", "texture coordinates", MAX_SET)?.unwrap_or(0);
    let Some(change) = info.extension(TEXTURE_TRANSFORM)? else { return Ok((set as u32, Affine2::IDENTITY)) };
    let set = change.index("texCoord", "texture coordinates", MAX_SET)?.unwrap_or(set);
    let offset = Vec2::from(change.vector("offset", COORDINATES)?.unwrap_or([0.0; 2]));
    let scale = Vec2::from(change.vector("scale", COORDINATES)?.unwrap_or([1.0; 2]));
    let angle = change.number("rotation", COORDINATES)?.unwrap_or(0.0) % TAU;
    // `t` points down, so a counter-clockwise rotation has a negated angle.
    let rotation = Mat2::from_angle(-angle);
    Ok((set as u32, Affine2::from_mat2_translation(rotation * Mat2::from_diagonal(scale), offset)))
}

fn wrap(source: &Source<'_>, sampler: &Item<'_>, key: &str) -> Read<TextureWrap> {
    Ok(match sampler.whole(key)? {
        None | Some(10497) => TextureWrap::Repeat,
        Some(33648) => TextureWrap::Mirror,
        Some(33071) => TextureWrap::Clamp,
        Some(other) => {
            let fault = sampler.fault(format!("`{key}` is {other}, but must be 10497, 33648 or 33071"));
            source.log.repair(fault, "the texture repeats")?;
            TextureWrap::Repeat
        }
    })
}

/// Returns the replacement for a missing colour image, a conspicuous checkerboard that is not too bright.
fn checks() -> Arc<Raster> {
    const SIDE: u32 = 8;
    let texel = |i: u32| if (i % SIDE + i / SIDE).is_multiple_of(2) { [200, 0, 200] } else { [40, 40, 40] };
    made(SIDE, (0..SIDE * SIDE).flat_map(texel).collect())
}

/// Returns the white replacement for a missing data image, so that only the material's factor applies.
fn white() -> Arc<Raster> {
    made(1, vec![255; 3])
}

fn made(side: u32, texels: Vec<u8>) -> Arc<Raster> {
    Arc::new(Raster::new(side, side, 3, Samples::U8(texels)).expect("three codes for each texel"))
}
