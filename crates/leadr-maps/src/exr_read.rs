//! OpenEXR reader. The `exr` crate parses the header and decompresses blocks. This module checks which blocks are safe to
//! decompress.
//!
//! Offsets, block lengths and the image size are checked against the file length first. Blocks are decoded one at a time, and a
//! panic in the crate becomes an error. Subsampled channels and High-Throughput JPEG 2000 are refused. Only the largest mip
//! level is read, except for baked maps.

use std::collections::HashSet;
use std::io::Cursor;

use exr::block::UncompressedBlock;
use exr::block::chunk::{Chunk, CompressedBlock, CompressedScanLineBlock, CompressedTileBlock, TileCoordinates};
use exr::compression::Compression;
use exr::math::{RoundingMode, Vec2};
use exr::meta::attribute::LevelMode;
use exr::meta::header::Header;
use exr::meta::{BlockDescription, MetaData};
use exr::prelude::SampleType;

use super::fault::one_line;
use super::guard::guarded;
use super::{MapFault, limits};

/// The selected channels of one part of the file. Each has `width * height` values, with row 0 on top.
pub(crate) struct Planes {
    pub width: u32,
    pub height: u32,
    pub planes: Vec<Vec<f32>>,
}

pub(crate) fn is_exr(bytes: &[u8]) -> bool {
    bytes.starts_with(&[0x76, 0x2f, 0x31, 0x01])
}

/// Returns the header of the first part, which must be flat.
pub(crate) fn header(bytes: &[u8]) -> Result<Header, MapFault> {
    guarded("EXR", || {
        let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(fault)?;
        meta.headers.into_iter().next().ok_or_else(|| MapFault::damaged("it has no part"))
    })
}

/// Returns the width, the height and the bytes per texel of the data window and of the display window of each part.
pub(crate) fn declared_sizes(bytes: &[u8]) -> Result<Vec<(u64, u64, u64)>, MapFault> {
    guarded("EXR", || {
        let meta = MetaData::read_from_buffered(Cursor::new(bytes), false).map_err(fault)?;
        let size = |header: &Header| {
            let texel_bytes = header.channels.bytes_per_pixel.max(4 * header.channels.list.len());
            [header.layer_size, header.shared_attributes.display_window.size]
                .map(|size| (size.width() as u64, size.height() as u64, texel_bytes as u64))
        };
        Ok(meta.headers.iter().flat_map(size).collect())
    })
}

/// Decodes the selected channels of the first part at all mip levels. Level sizes are halved and rounded down to 1 x 1.
pub(crate) fn decode_levels(bytes: &[u8], picked: &[usize]) -> Result<Vec<Planes>, MapFault> {
    guarded("EXR", || {
        let file = Opened::new(bytes)?;
        let header = &file.meta.headers[0];
        let BlockDescription::Tiles(tiles) = header.blocks else {
            return Err(MapFault::damaged("it has no mip levels"));
        };
        if (tiles.level_mode, tiles.rounding_mode) != (LevelMode::MipMap, RoundingMode::Down) {
            return Err(MapFault::damaged("its mip sizes are not rounded down"));
        }
        if header.deep || is_subsampled(header) {
            return Err(MapFault::damaged("its channels are deep or subsampled"));
        }
        let longest = header.layer_size.width().max(header.layer_size.height());
        let count = usize::BITS - longest.leading_zeros();
        (0..count).map(|level| file.level(0, picked, level)).collect()
    })
}

fn is_subsampled(header: &Header) -> bool {
    header.channels.list.iter().any(|c| c.sampling != Vec2(1, 1))
}

/// An EXR file with a parsed header. The block offset tables are known to lie inside the file.
pub(crate) struct Opened<'a> {
    bytes: &'a [u8],
    pub meta: MetaData,
    /// The byte offset of the block offset tables.
    tables: usize,
}

impl<'a> Opened<'a> {
    pub fn new(bytes: &'a [u8]) -> Result<Self, MapFault> {
        let mut cursor = Cursor::new(bytes);
        let meta = MetaData::read_from_buffered(&mut cursor, false).map_err(fault)?;
        let tables = cursor.position() as usize;
        let chunks = meta.headers.iter().try_fold(0usize, |sum, h| sum.checked_add(h.chunk_count));
        if chunks.and_then(|n| n.checked_mul(8)).is_none_or(|n| n > bytes.len() - tables) {
            return Err(MapFault::damaged("the file is shorter than its block offset table"));
        }
        Ok(Self { bytes, meta, tables })
    }

    /// Decodes channels of a flat part over the display window. Texels outside the data window are `outside`.
    pub fn framed(&self, part: usize, picked: &[usize], outside: f32) -> Result<Planes, MapFault> {
        let header = &self.meta.headers[part];
        if is_subsampled(header) {
            let what = "its channels are subsampled";
            return Err(MapFault::unsupported(what, "save it with one sample per pixel in every channel"));
        }
        let (data, display) = (header.data_window(), header.shared_attributes.display_window);
        let stored = self.level(part, picked, 0)?;
        if data == display {
            return Ok(stored);
        }
        let [width, height] = [display.size.width(), display.size.height()];
        limits::check_size(width as u64, height as u64, 4 * picked.len() as u64, self.bytes.len())?;
        // The column or row of the display window at which the data window starts.
        let [left, top] = [0, 1].map(|axis| {
            let of = |position: Vec2<i32>| i64::from(if axis == 0 { position.x() } else { position.y() });
            of(data.position) - of(display.position)
        });
        let columns = left.max(0)..(left + i64::from(stored.width)).min(width as i64);
        let rows = top.max(0)..(top + i64::from(stored.height)).min(height as i64);
        let mut planes = Vec::with_capacity(picked.len());
        for plane in &stored.planes {
            let mut framed = limits::zeroed::<f32>(width * height)?;
            framed.fill(outside);
            for y in rows.clone().filter(|_| !columns.is_empty()) {
                let from = ((y - top) * i64::from(stored.width) + columns.start - left) as usize;
                let to = y as usize * width + columns.start as usize;
                let count = (columns.end - columns.start) as usize;
                framed[to..to + count].copy_from_slice(&plane[from..from + count]);
            }
            planes.push(framed);
        }
        Ok(Planes { width: width as u32, height: height as u32, planes })
    }

    fn level(&self, part: usize, picked: &[usize], level: u32) -> Result<Planes, MapFault> {
        let header = &self.meta.headers[part];
        let (width, height) = (header.layer_size.width() as u64, header.layer_size.height() as u64);
        let texel_bytes = (header.channels.bytes_per_pixel as u64).max(4 * picked.len() as u64);
        limits::check_size(width, height, texel_bytes, self.bytes.len())?;
        // The size check comes first, so that zero and huge sizes get specific errors.
        header.validate(self.meta.headers.len() > 1, &mut false, false).map_err(fault)?;

        let before: usize = self.meta.headers[..part].iter().map(|h| h.chunk_count).sum();
        let (offsets, _) = self.bytes[self.tables + 8 * before..][..8 * header.chunk_count].as_chunks();
        let [width, height] = [width, height].map(|side| (side >> level).max(1));
        let texel_count = (width * height) as usize;
        let mut into = Planes { width: width as u32, height: height as u32, planes: Vec::new() };
        let mut seen = HashSet::new();
        let mut covered = 0;
        for offset in offsets {
            let Some(block) = self.block(u64::from_le_bytes(*offset), part, level)? else { continue };
            if !seen.insert(block.index.pixel_position) {
                return Err(MapFault::damaged("two of its blocks overlap"));
            }
            covered += block.index.pixel_size.area();
            // Memory is allocated only after the first block has been decoded.
            while into.planes.len() < picked.len() {
                into.planes.push(limits::zeroed::<f32>(texel_count)?);
            }
            copy_lines(&block, header, picked, &mut into)?;
        }
        if covered != texel_count {
            return Err(MapFault::damaged(format!("its blocks cover only {covered} of {texel_count} texels")));
        }
        Ok(into)
    }

    /// Decompresses the block at `offset`. Returns `None` if the block belongs to another mip level.
    fn block(&self, offset: u64, part: usize, level: u32) -> Result<Option<UncompressedBlock>, MapFault> {
        if offset == 0 {
            return Err(MapFault::damaged("a block was never written (incomplete render?)"));
        }
        let rest = usize::try_from(offset).ok().and_then(|at| self.bytes.get(at..));
        let rest = &mut rest.ok_or_else(outside)?;
        if self.meta.requirements.is_multilayer() && read_i32(rest)? != part as i32 {
            return Err(MapFault::damaged("a block does not belong to the part of its offset table"));
        }
        let header = &self.meta.headers[part];
        let negative = |_| MapFault::damaged("a tile has a negative index");
        let tiled = matches!(header.blocks, BlockDescription::Tiles(_));
        let (mut coordinates, mut y_coordinate) = ([0usize; 4], 0);
        if tiled {
            for value in &mut coordinates {
                *value = usize::try_from(read_i32(rest)?).map_err(negative)?;
            }
        } else {
            y_coordinate = read_i32(rest)?;
        }
        let length = read_i32(rest)?;
        let length = usize::try_from(length).map_err(|_| MapFault::damaged("a block has a negative length"))?;
        let data = rest.get(..length).ok_or_else(outside)?;
        if coordinates[2..] != [level as usize; 2] {
            return Ok(None);
        }
        check_dwa_claims(data, header)?;
        let compressed_pixels_le = data.to_vec();
        let compressed_block = if tiled {
            let [x, y, level_x, level_y] = coordinates;
            let coordinates = TileCoordinates { tile_index: Vec2(x, y), level_index: Vec2(level_x, level_y) };
            CompressedBlock::Tile(CompressedTileBlock { coordinates, compressed_pixels_le })
        } else {
            CompressedBlock::ScanLine(CompressedScanLineBlock { y_coordinate, compressed_pixels_le })
        };
        let chunk = Chunk { layer_index: part, compressed_block };
        UncompressedBlock::decompress_chunk(chunk, &self.meta, false).map(Some).map_err(fault)
    }
}

fn outside() -> MapFault {
    MapFault::damaged("a block lies outside the file (truncated?)")
}

fn read_i32(rest: &mut &[u8]) -> Result<i32, MapFault> {
    let (value, after) = rest.split_first_chunk().ok_or_else(outside)?;
    *rest = after;
    Ok(i32::from_le_bytes(*value))
}

/// Checks the section sizes in the header of a DWA block. The crate allocates the declared sizes before decompression, and
/// would abort if memory is short.
fn check_dwa_claims(data: &[u8], header: &Header) -> Result<(), MapFault> {
    if !matches!(header.compression, Compression::DWAA(_) | Compression::DWAB(_)) {
        return Ok(());
    }
    // The block starts with eleven numbers: the version, the byte sizes, the counts of 2-byte values, and the coder.
    let (counters, _) = data.as_chunks::<8>();
    let claims = counters.iter().take(10).skip(1).map(|bytes| u64::from_le_bytes(*bytes));
    // Blocks of 8 x 8 values overlap the edges, and a 1-byte value can become a 2-byte coefficient.
    let (block, whole) = (header.max_block_pixel_size(), header.layer_size);
    let texels = (block.0.min(whole.0) as u64 + 8).saturating_mul(block.1.min(whole.1) as u64 + 8);
    let most = texels.saturating_mul(4 * header.channels.bytes_per_pixel as u64);
    match claims.max() {
        Some(claim) if claim > most => Err(MapFault::damaged(format!(
            "a block declares {claim} bytes for one of its sections, but at most {most} are possible"
        ))),
        _ => Ok(()),
    }
}

fn copy_lines(block: &UncompressedBlock, header: &Header, picked: &[usize], into: &mut Planes) -> Result<(), MapFault> {
    for line in block.lines(&header.channels) {
        let Some(slot) = picked.iter().position(|&p| p == line.location.channel) else { continue };
        let Vec2(x, y) = line.location.position;
        let start = y * into.width as usize + x;
        let row = into.planes[slot].get_mut(start..start + line.location.sample_count);
        let row = row.ok_or_else(|| MapFault::damaged("a block lies outside the image"))?;
        match header.channels.list[line.location.channel].sample_type {
            SampleType::F16 => fill(row, line.read_samples::<exr::prelude::f16>(), |v| v.to_f32())?,
            SampleType::F32 => fill(row, line.read_samples::<f32>(), |v| v)?,
            SampleType::U32 => fill(row, line.read_samples::<u32>(), |v| v as f32)?,
        }
    }
    Ok(())
}

fn fill<T>(
    row: &mut [f32],
    samples: impl Iterator<Item = exr::error::Result<T>>,
    convert: impl Fn(T) -> f32,
) -> Result<(), MapFault> {
    for (texel, sample) in row.iter_mut().zip(samples) {
        *texel = convert(sample.map_err(fault)?);
    }
    Ok(())
}

fn fault(error: exr::error::Error) -> MapFault {
    match error {
        exr::error::Error::NotSupported(reason) => {
            MapFault::unsupported(one_line(&reason), "save it as a flat EXR with ZIP compression")
        }
        exr::error::Error::Invalid(reason) => MapFault::damaged(one_line(&reason)),
        other => MapFault::damaged(one_line(&other)),
    }
}
