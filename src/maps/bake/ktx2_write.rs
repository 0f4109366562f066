//! KTX2 (Khronos KTX file format 2.0): header, level index, description of the numbers, keys; then the levels, the smallest first, whose
//! places are known before any of them is.
//!
//! Layers of an array texture hold four channels each: those of the kind first, then `alpha2` and `alpha4`, and colour in a layer of its
//! own. Channels named `-` are zero.

use std::fs::File;
use std::io::{Seek, SeekFrom, Write};

use half::f16;
use ktx2::{Format, Header, Index, LevelIndex};

use super::pyramid::level_sizes;
use super::{Kind, Plan, Precision, Report, Target};
use crate::maps::{MapFault, Wrap};

/// A file that is being written.
pub struct Ktx2File<'a> {
    file: &'a mut File,
    plan: &'a Plan,
    layers: Vec<[Option<usize>; 4]>,
    sizes: Vec<[u32; 2]>,
    offsets: Vec<u64>,
    keys_at: u64,
}

/// Channels of the plan in each layer.
fn layers(plan: &Plan) -> Vec<[Option<usize>; 4]> {
    let colors = plan.channels.iter().position(|name| *name == "red").unwrap_or(plan.channels.len());
    let pack = |channels: std::ops::Range<usize>| -> Vec<[Option<usize>; 4]> {
        let starts = channels.clone().step_by(4);
        starts.map(|start| std::array::from_fn(|i| Some(start + i).filter(|c| *c < channels.end))).collect()
    };
    [pack(0..colors), pack(colors..plan.channels.len())].concat()
}

/// The basic descriptor block: four floats of one size, linear.
fn descriptor(precision: Precision) -> Vec<u8> {
    let bytes = precision.bytes() as u8;
    // Total size; vendor and type 0; version 2, size of the block; RGBSDA, BT.709, linear, straight alpha; texels of 1 x 1; bytes.
    let mut block =
        [92u32.to_le_bytes(), [0; 4], [2, 0, 88, 0], [1, 1, 1, 0], [0; 4], [4 * bytes, 0, 0, 0], [0; 4]].concat();
    for (i, channel) in [0u8, 1, 2, 15].into_iter().enumerate() {
        let bits = 8 * u16::from(bytes);
        block.extend((bits * i as u16).to_le_bytes());
        // Signed floats.
        block.extend([bits as u8 - 1, channel | 0xc0]);
        block.extend([0; 4]);
        block.extend((-1.0f32).to_le_bytes());
        block.extend(1.0f32.to_le_bytes());
    }
    block
}

/// The keys, of the same length whatever `report` says.
fn keys(plan: &Plan, layers: &[[Option<usize>; 4]], report: Option<&Report>) -> Vec<u8> {
    let join = |values: Vec<String>| values.join(" ");
    let slots = || layers.iter().flatten().copied();
    let per_slot =
        |of: &dyn Fn(usize) -> String, none: &str| join(slots().map(|c| c.map_or(none.into(), of)).collect());
    let number = |v: f64| format!("{v:>+13.6e}");
    let levels = level_sizes(plan.size).len();
    let errors = (0..levels).map(|i| format!("{:>10.3e}", report.map_or(0.0, |r| r.errors[i].channels))).collect();
    let range = |c: usize| report.map_or([0.0; 2], |r| r.channel_ranges[c]).map(number).join(" ");
    let frame = match plan.kind {
        Kind::Leadr => "slopes per unit of texture coordinate, s right, t down",
        _ => "rise over run in the tangent frame, y up, square texels",
    };
    let wrap = if plan.wrap == Wrap::Repeat { "repeat" } else { "clamp" };
    let keys = [
        ("KTXorientation", "rd".to_owned()),
        ("KTXwriter", concat!("leadr-vk ", env!("CARGO_PKG_VERSION")).to_owned()),
        ("leadr.channels", per_slot(&|c| plan.channels[c].to_owned(), "-")),
        ("leadr.error", join(errors)),
        ("leadr.factors", per_slot(&|c| format!("{:e}", plan.factors[c]), "1e0")),
        ("leadr.height_scale", number(plan.height_scale)),
        ("leadr.kind", plan.kind.name().to_owned()),
        ("leadr.ranges", per_slot(&range, &[0.0, 0.0].map(number).join(" "))),
        ("leadr.units", frame.to_owned()),
        ("leadr.wrap", wrap.to_owned()),
    ];
    let mut bytes = Vec::new();
    for (key, value) in keys {
        let pair = [key.as_bytes(), &[0], value.as_bytes(), &[0]].concat();
        bytes.extend((pair.len() as u32).to_le_bytes());
        bytes.extend(pair);
        bytes.resize(bytes.len().next_multiple_of(4), 0);
    }
    bytes
}

fn refused(source: std::io::Error) -> MapFault {
    MapFault::Io { doing: "cannot be written", source }
}

impl<'a> Ktx2File<'a> {
    /// Writes everything but the levels, and makes room for those.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn new(file: &'a mut File, plan: &'a Plan) -> Result<Self, MapFault> {
        let layers = layers(plan);
        let sizes = level_sizes(plan.size);
        let (descriptor, keys) = (descriptor(plan.precision), keys(plan, &layers, None));
        let descriptor_at = (Header::LENGTH + sizes.len() * LevelIndex::LENGTH) as u64;
        let keys_at = descriptor_at + descriptor.len() as u64;
        let texel = 4 * plan.precision.bytes() as u64;
        let bytes = |[w, h]: [u32; 2]| layers.len() as u64 * u64::from(w) * u64::from(h) * texel;
        let mut offsets = vec![0; sizes.len()];
        let mut end = keys_at + keys.len() as u64;
        for (offset, &size) in offsets.iter_mut().zip(&sizes).rev() {
            *offset = end.next_multiple_of(texel);
            end = *offset + bytes(size);
        }
        let header = Header {
            format: Some(match plan.precision {
                Precision::F32 => Format::R32G32B32A32_SFLOAT,
                Precision::F16 => Format::R16G16B16A16_SFLOAT,
            }),
            type_size: plan.precision.bytes() as u32,
            pixel_width: plan.size[0],
            pixel_height: plan.size[1],
            pixel_depth: 0,
            // Zero says that it is no array.
            layer_count: if layers.len() > 1 { layers.len() as u32 } else { 0 },
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
        file.write_all(&head).and_then(|()| file.set_len(end)).map_err(refused)?;
        Ok(Self { file, plan, layers, sizes, offsets, keys_at })
    }

    /// Writes what is only known after baking.
    ///
    /// # Errors
    /// If the file cannot be written.
    pub fn finish(self, report: &Report) -> Result<(), MapFault> {
        let keys = keys(self.plan, &self.layers, Some(report));
        self.file.seek(SeekFrom::Start(self.keys_at)).and_then(|_| self.file.write_all(&keys)).map_err(refused)
    }
}

impl Target for Ktx2File<'_> {
    fn rows(&mut self, level: usize, first: u32, rows: &[Vec<f32>]) -> Result<(), MapFault> {
        let [width, height] = self.sizes[level].map(u64::from);
        let texel = 4 * self.plan.precision.bytes() as u64;
        let channels = self.plan.channels.len();
        for (i, layer) in self.layers.iter().enumerate() {
            let place = self.offsets[level] + (i as u64 * height + u64::from(first)) * width * texel;
            let mut bytes = Vec::with_capacity(rows.len() * (width * texel) as usize);
            for texel in rows.iter().flat_map(|row| row.chunks_exact(channels)) {
                let values = layer.map(|channel| channel.map_or(0.0, |channel| texel[channel]));
                match self.plan.precision {
                    Precision::F32 => values.iter().for_each(|v| bytes.extend(v.to_le_bytes())),
                    Precision::F16 => values.iter().for_each(|&v| bytes.extend(f16::from_f32(v).to_le_bytes())),
                }
            }
            self.file.seek(SeekFrom::Start(place)).and_then(|_| self.file.write_all(&bytes)).map_err(refused)?;
        }
        Ok(())
    }
}
