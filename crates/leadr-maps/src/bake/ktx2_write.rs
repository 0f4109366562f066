//! KTX2 writer (Khronos KTX file format 2.0). The file contains the header, the level index, the data format descriptor, the
//! keys, and the levels from the smallest to the largest. All offsets are computed in advance.
//!
//! Block-compressed layers hold two channels ([`super::blocks`]). Uncompressed maps of one or two channels form a one- or
//! two-channel texture. Maps with more channels form an array texture with four channels per layer. The kind's own channels
//! come first, and `alpha2` and `alpha4` follow. Colour starts a new layer. In 16-bit files the last channel is the residual
//! of the height. Channels named `-` are unused and zero.

use std::fs::File;
use std::io::{Seek, SeekFrom, Write};

use half::f16;
use ktx2::{Format, Header, Index, LevelIndex};

use super::blocks::BlockPlan;
use super::keys::{keys, packed};
use super::{Plan, Precision, Report, Target};
use crate::{MapFault, bc5};

/// The 32-bit float formats, each with its channel count.
pub(crate) const FLOATS_32: [(usize, Format); 3] =
    [(1, Format::R32_SFLOAT), (2, Format::R32G32_SFLOAT), (4, Format::R32G32B32A32_SFLOAT)];
pub(crate) const FLOATS_16: [(usize, Format); 3] =
    [(1, Format::R16_SFLOAT), (2, Format::R16G16_SFLOAT), (4, Format::R16G16B16A16_SFLOAT)];

/// A KTX2 file that is being written.
pub struct Ktx2File<'a> {
    file: &'a mut File,
    plan: &'a Plan,
    layers: Vec<Vec<Option<usize>>>,
    sizes: Vec<[u32; 2]>,
    offsets: Vec<u64>,
    keys_at: u64,
}

/// Returns the plan's channels in each layer. All layers have the same number of channels.
fn layers(plan: &Plan) -> Vec<Vec<Option<usize>>> {
    let count = plan.channels.len();
    if count <= 2 {
        return vec![(0..count).map(Some).collect()];
    }
    packed(&plan.channels).chunks(4).map(<[_]>::to_vec).collect()
}

/// Returns the basic data format descriptor block for two BC5 channels, or for `channels` linear floats of one size.
fn descriptor(precision: Precision, channels: usize) -> Vec<u8> {
    let in_blocks = precision == Precision::Bc;
    let channels = if in_blocks { 2 } else { channels };
    let bits = if in_blocks { 64 } else { 8 * precision.bytes() as u16 };
    let (size, bytes) = (24 + 16 * channels as u8, (channels as u16 * bits / 8) as u8);
    // The colour model is BC5 or RGBSDA. The texel block dimension is stored minus one.
    let (model, last) = if in_blocks { (132, 3) } else { (1, 0) };
    // The block consists of: total size; vendor and type 0; version 2 and block size; colour model, BT.709, linear, straight
    // alpha; texel block dimensions; bytes per plane.
    let mut block = [
        u32::from(size + 4).to_le_bytes(),
        [0; 4],
        [2, 0, size, 0],
        [model, 1, 1, 0],
        [last, last, 0, 0],
        [bytes, 0, 0, 0],
        [0; 4],
    ]
    .concat();
    // Each sample is a signed normalised value or a signed float.
    let (sign, [low, high]) = if in_blocks {
        (0x40, [i32::MIN, i32::MAX].map(i32::to_le_bytes))
    } else {
        (0xc0, [-1.0, 1.0].map(f32::to_le_bytes))
    };
    for (i, channel) in [0u8, 1, 2, 15].into_iter().take(channels).enumerate() {
        block.extend((bits * i as u16).to_le_bytes());
        block.extend([bits as u8 - 1, channel | sign]);
        block.extend([[0; 4], low, high].as_flattened());
    }
    block
}

fn float_format(precision: Precision, channels: usize) -> Format {
    let of_counts = if precision == Precision::F32 { FLOATS_32 } else { FLOATS_16 };
    of_counts.into_iter().find(|(count, _)| *count == channels).expect("1, 2 or 4 channels").1
}

/// Returns the encoded keys. The length of the keys does not depend on `report`.
fn encoded_keys(plan: &Plan, layers: &[Vec<Option<usize>>], report: Option<&Report>) -> Vec<u8> {
    let slots: Vec<Option<usize>> = layers.iter().flatten().copied().collect();
    let mut keys = keys(plan, &slots, report);
    keys.push(("KTXorientation", "rd".to_owned()));
    keys.push(("KTXwriter", concat!("leadr-vk ", env!("CARGO_PKG_VERSION")).to_owned()));
    keys.sort_by_key(|(key, _)| *key);
    let mut bytes = Vec::new();
    for (key, value) in keys {
        let pair = [key.as_bytes(), &[0], value.as_bytes(), &[0]].concat();
        bytes.extend((pair.len() as u32).to_le_bytes());
        bytes.extend(pair);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    bytes
}

fn write_at(file: &mut File, offset: u64, bytes: &[u8]) -> Result<(), MapFault> {
    file.seek(SeekFrom::Start(offset)).and_then(|_| file.write_all(bytes)).map_err(MapFault::io("cannot be written"))
}

impl<'a> Ktx2File<'a> {
    /// Writes everything except the levels and reserves space for the levels.
    ///
    /// # Errors
    /// Fails if the file cannot be written.
    pub fn new(file: &'a mut File, plan: &'a Plan) -> Result<Self, MapFault> {
        let layers = layers(plan);
        let sizes = plan.level_sizes();
        let channels = layers[0].len();
        let (descriptor, keys) = (descriptor(plan.precision, channels), encoded_keys(plan, &layers, None));
        let descriptor_at = (Header::LENGTH + sizes.len() * LevelIndex::LENGTH) as u64;
        let keys_at = descriptor_at + descriptor.len() as u64;
        // The number of bytes in a texel or block of one layer.
        let unit = if plan.precision == Precision::Bc { 16 } else { (channels * plan.precision.bytes()) as u64 };
        let count = plan.blocks.as_ref().map_or(layers.len(), BlockPlan::layers);
        let bytes = |size: [u32; 2]| count as u64 * units(plan, size).iter().product::<u64>() * unit;
        let mut offsets = vec![0; sizes.len()];
        let mut end = keys_at + keys.len() as u64;
        for (offset, &size) in offsets.iter_mut().zip(&sizes).rev() {
            // The format requires levels to be aligned to texels and to four bytes.
            *offset = end.next_multiple_of(unit.max(4));
            end = *offset + bytes(size);
        }
        let header = Header {
            format: Some(match plan.precision {
                Precision::Bc => Format::BC5_SNORM_BLOCK,
                floats => float_format(floats, channels),
            }),
            type_size: plan.precision.bytes() as u32,
            pixel_width: sizes[0][0],
            pixel_height: sizes[0][1],
            pixel_depth: 0,
            // In KTX2, a layer count of zero means that the texture is not an array.
            layer_count: if count > 1 { count as u32 } else { 0 },
            face_count: 1,
            level_count: sizes.len() as u32,
            supercompression_scheme: None,
            index: Index {
                dfd_byte_offset: descriptor_at as u32,
                dfd_byte_length: descriptor.len() as u32,
                kvd_byte_offset: keys_at as u32,
                kvd_byte_length: keys.len() as u32,
                sgd_byte_offset: 0,
                sgd_byte_length: 0,
            },
        };
        let mut head = header.as_bytes().to_vec();
        for (&byte_offset, &size) in offsets.iter().zip(&sizes) {
            let byte_length = bytes(size);
            head.extend(LevelIndex { byte_offset, byte_length, uncompressed_byte_length: byte_length }.as_bytes());
        }
        head.extend(descriptor);
        head.extend(keys);
        file.write_all(&head).and_then(|()| file.set_len(end)).map_err(MapFault::io("cannot be written"))?;
        Ok(Self { file, plan, layers, sizes, offsets, keys_at })
    }

    /// Writes the keys whose values are known only after the bake.
    ///
    /// # Errors
    /// Fails if the file cannot be written.
    pub fn finish(self, report: &Report) -> Result<(), MapFault> {
        write_at(self.file, self.keys_at, &encoded_keys(self.plan, &self.layers, Some(report)))
    }
}

fn units(plan: &Plan, size: [u32; 2]) -> [u64; 2] {
    let side = if plan.precision == Precision::Bc { bc5::SIDE as u32 } else { 1 };
    size.map(|texels| u64::from(texels.div_ceil(side)))
}

impl Target for Ktx2File<'_> {
    fn blocks(&mut self, level: usize, row: u32, layers: &[Vec<u8>]) -> Result<(), MapFault> {
        let [_, rows] = units(self.plan, self.sizes[level]);
        for (i, bytes) in layers.iter().enumerate() {
            let offset = self.offsets[level] + (i as u64 * rows + u64::from(row)) * bytes.len() as u64;
            write_at(self.file, offset, bytes)?;
        }
        Ok(())
    }

    fn rows(&mut self, level: usize, first: u32, rows: &[Vec<f32>]) -> Result<(), MapFault> {
        let [width, height] = self.sizes[level].map(u64::from);
        let texel = (self.layers[0].len() * self.plan.precision.bytes()) as u64;
        let channels = self.plan.channels.len();
        for (i, layer) in self.layers.iter().enumerate() {
            let offset = self.offsets[level] + (i as u64 * height + u64::from(first)) * width * texel;
            let mut bytes = Vec::with_capacity(rows.len() * (width * texel) as usize);
            for texel in rows.iter().flat_map(|row| row.chunks_exact(channels)) {
                let values = layer.iter().map(|channel| channel.map_or(0.0, |channel| texel[channel]));
                match self.plan.precision {
                    Precision::F32 => values.for_each(|v| bytes.extend(v.to_le_bytes())),
                    Precision::F16 => values.for_each(|v| bytes.extend(f16::from_f32(v).to_le_bytes())),
                    Precision::Bc => unreachable!("rows are encoded as blocks"),
                }
            }
            write_at(self.file, offset, &bytes)?;
        }
        Ok(())
    }
}
