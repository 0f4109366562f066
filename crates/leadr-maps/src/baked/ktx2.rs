//! Reads the header, the levels and the keys of baked maps in KTX2 files.

use std::io::{Read, Seek, SeekFrom};

use half::f16;
use ktx2::{Format, Header, KeyValueDataIterator, LevelIndex};

use super::keys::{Keys, names};
use super::map::{BakedLevel, BakedMap, REMEDY};
use crate::bake::blocks::BlockPlan;
use crate::bake::ktx2_write::{FLOATS_16, FLOATS_32};
use crate::bake::{Precision, packed};
use crate::ktx2_read::format_name;
use crate::{MapFault, bc5, limits};

/// The maximum number of four-channel layers.
const MOST_LAYERS: u32 = 12;
/// The maximum number of block layers, which have two channels each.
const MOST_LAYERS_OF_BLOCKS: u32 = 64;
/// The maximum total size of the keys in bytes.
const MOST_KEYS: u32 = 1 << 16;

/// Reads `length` bytes at offset `start`, after checking the range against the file length.
fn part(
    file: &mut (impl Read + Seek),
    file_length: u64,
    start: u64,
    length: u64,
    what: &str,
) -> Result<Vec<u8>, MapFault> {
    if start.checked_add(length).is_none_or(|end| end > file_length) {
        return Err(MapFault::damaged(format!("its {what} lies beyond the end of the file (truncated?)")));
    }
    let length = usize::try_from(length).map_err(|_| MapFault::damaged(format!("its {what} is too long")))?;
    let mut bytes = limits::zeroed::<u8>(length)?;
    let read = file.seek(SeekFrom::Start(start)).and_then(|_| file.read_exact(&mut bytes));
    read.map_err(MapFault::io("cannot be read"))?;
    Ok(bytes)
}

pub(super) fn read(mut file: impl Read + Seek, length: u64) -> Result<BakedMap, MapFault> {
    let start = part(&mut file, length, 0, (Header::LENGTH as u64).min(length), "header")?;
    if !start.starts_with(&ktx2::MAGIC) {
        return Err(MapFault::Unrecognised { expected: "a KTX2 file of leadr bake" });
    }
    let header: [u8; Header::LENGTH] =
        start.try_into().map_err(|_| MapFault::damaged("it ends within its header (truncated?)"))?;
    // The scheme is read from the raw bytes, because the `ktx2` crate drops unknown values.
    let scheme = u32::from_le_bytes(header[44..48].try_into().expect("four bytes"));
    let header = Header::from_bytes(&header).map_err(|e| MapFault::damaged(format!("its header has {e}")))?;
    let of = |formats: [(usize, Format); 3]| formats.into_iter().find(|(_, format)| Some(*format) == header.format);
    // The file format determines the precision and the number of channels per layer.
    let (precision, channels) = match (of(FLOATS_32), of(FLOATS_16), header.format) {
        (Some((channels, _)), ..) => (Precision::F32, channels),
        (_, Some((channels, _)), _) => (Precision::F16, channels),
        (.., Some(Format::BC5_SNORM_BLOCK)) => (Precision::Bc, 2),
        _ => {
            let name = format_name(&header);
            let what =
                format!("its texels are {name}; supported are 1, 2 or 4 floats of 32 or 16 bits, and signed BC5");
            return Err(MapFault::unsupported(what, REMEDY));
        }
    };
    if scheme != 0 || header.face_count != 1 || header.pixel_depth != 0 {
        return Err(MapFault::unsupported("it is compressed, a cube or a volume", REMEDY));
    }
    let (width, height, layers) = (header.pixel_width, header.pixel_height, header.layer_count.max(1));
    let in_blocks = precision == Precision::Bc;
    // The number of bytes per unit, which is a texel or a block, and the number of units per side.
    let unit = if in_blocks { 2 * bc5::BYTES } else { channels * precision.bytes() } as u64;
    let units = |side: u32| u64::from(if in_blocks { side.div_ceil(bc5::SIDE as u32) } else { side });
    let most_layers = if in_blocks { MOST_LAYERS_OF_BLOCKS } else { MOST_LAYERS };
    let too_large = u64::from(width.max(height)) > limits::MAX_SIDE;
    if height == 0 || too_large || u64::from(width) * u64::from(height) > limits::MAX_TEXELS || layers > most_layers {
        return Err(MapFault::too_large(format!("{width} x {height} texels in {layers} layers")));
    }
    let count = width.max(height).ilog2() + 1;
    if header.level_count != count || header.type_size as usize != precision.bytes() {
        return Err(MapFault::damaged(format!("it has {} of {count} levels", header.level_count)));
    }
    let index =
        part(&mut file, length, Header::LENGTH as u64, u64::from(count) * LevelIndex::LENGTH as u64, "list of levels")?;
    let (keys_at, keys_length) = (header.index.kvd_byte_offset, header.index.kvd_byte_length);
    if keys_length > MOST_KEYS {
        return Err(MapFault::damaged(format!("it declares {keys_length} bytes of keys")));
    }
    let keys = part(&mut file, length, keys_at.into(), keys_length.into(), "list of keys")?;
    let pairs: Vec<(&str, &[u8])> = KeyValueDataIterator::new(&keys).collect();
    let value = |key: &str| {
        let found = pairs.iter().find(|(name, _)| *name == key).and_then(|(_, v)| v.strip_suffix(&[0]));
        found.and_then(|text| std::str::from_utf8(text).ok())
    };
    if value("KTXorientation") != Some("rd") {
        return Err(MapFault::damaged("its key KTXorientation is invalid"));
    }
    let mut keys = Keys::new(value, channels * layers as usize, precision)?;
    let slots = packed(&keys.map.channels);

    let mut levels = Vec::new();
    for (i, entry) in index.chunks_exact(LevelIndex::LENGTH).enumerate() {
        let entry = LevelIndex::from_bytes(entry.try_into().expect("as long as an entry"));
        let [w, h] = [width, height].map(|side| (side >> i).max(1));
        let layer = units(w) * units(h) * unit;
        if entry.byte_length != layer * u64::from(layers) || entry.uncompressed_byte_length != entry.byte_length {
            return Err(MapFault::damaged(format!(
                "level {i} has {} bytes, which does not match {w} x {h}",
                entry.byte_length
            )));
        }
        let bytes = part(&mut file, length, entry.byte_offset, entry.byte_length, "level")?;
        let parts: Vec<&[u8]> = bytes.chunks_exact(layer as usize).collect();
        let layers = match &keys.blocks {
            Some(blocks) => of_blocks(blocks, &parts, [w, h], &slots)?,
            None => {
                let plane = |(layer, bytes)| plane(&keys, bytes, precision, channels, layer, w);
                parts.into_iter().enumerate().map(plane).collect::<Result<_, _>>()?
            }
        };
        levels.push(BakedLevel { width: w, height: h, layers });
    }
    if in_blocks {
        keys.map.channels = names(&keys.map.channels, &slots);
    }
    Ok(keys.map(levels))
}

/// Decodes a level of blocks into layers of four channels. `parts` holds the bytes of each block layer.
fn of_blocks(
    blocks: &BlockPlan,
    parts: &[&[u8]],
    [width, height]: [u32; 2],
    slots: &[Option<usize>],
) -> Result<Vec<Vec<[f32; 4]>>, MapFault> {
    let [width, height] = [width, height].map(|side| side as usize);
    let texels = || limits::zeroed::<[f32; 4]>(width * height);
    let mut layers = slots.chunks_exact(4).map(|_| texels()).collect::<Result<Vec<_>, _>>()?;
    let across = width.div_ceil(bc5::SIDE);
    let parts: Vec<&[[u8; bc5::BYTES]]> = parts.iter().map(|part| part.as_chunks().0).collect();
    let mut block = Vec::new();
    let mut fault = None;
    for index in 0..across * height.div_ceil(bc5::SIDE) {
        let (left, top) = (bc5::SIDE * (index % across), bc5::SIDE * (index / across));
        block.clear();
        block.extend(parts.iter().flat_map(|part| &part[2 * index..2 * index + 2]));
        blocks.decode_block(&block, |x, y, texel| {
            let (x, y) = (left + x, top + y);
            if x >= width || y >= height {
                return;
            }
            if !texel.iter().all(|v| v.is_finite()) {
                fault = Some(format!("its texel at x = {x}, y = {y} of {width} x {height} is not finite"));
            }
            for (layer, slots) in layers.iter_mut().zip(slots.chunks_exact(4)) {
                layer[y * width + x] = [0, 1, 2, 3].map(|c| slots[c].map_or(0.0, |channel| texel[channel]));
            }
        });
    }
    fault.map_or(Ok(layers), |fault| Err(MapFault::damaged(fault)))
}

fn plane(
    keys: &Keys,
    bytes: &[u8],
    precision: Precision,
    channels: usize,
    layer: usize,
    width: u32,
) -> Result<Vec<[f32; 4]>, MapFault> {
    let factors = &keys.factors[channels * layer..channels * (layer + 1)];
    let unit = channels * precision.bytes();
    let mut texels = limits::zeroed::<[f32; 4]>(bytes.len() / unit)?;
    for (i, (texel, bytes)) in texels.iter_mut().zip(bytes.chunks_exact(unit)).enumerate() {
        for (c, (value, bytes)) in texel.iter_mut().zip(bytes.chunks_exact(precision.bytes())).enumerate() {
            *value = match precision {
                Precision::F32 => f32::from_le_bytes(bytes.try_into().expect("four bytes")),
                Precision::F16 => f16::from_le_bytes(bytes.try_into().expect("two bytes")).to_f32(),
                Precision::Bc => unreachable!("blocks are not floats"),
            };
            if factors[c] != 1.0 {
                *value = (f64::from(*value) / factors[c]) as f32;
            }
            if !value.is_finite() {
                let remedy = "every value must be finite; bake the map again";
                return Err(MapFault::bad_texel(i, width, ["R", "G", "B", "A"][c], *value, remedy));
            }
        }
    }
    Ok(texels)
}
