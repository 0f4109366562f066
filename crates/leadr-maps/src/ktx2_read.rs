//! KTX2 reader for plain textures of one image. Only the largest mip level is read.
//!
//! `leadr bake` writes KTX2 files with slope moments, which [`crate::baked`] reads.

use std::io::Read;

use ktx2::{Header, KeyValueDataIterator, LevelIndex};

use super::material::{Raster, Samples};
use super::raster_read::Size;
use super::texels::{ColorBlock, Number, TexelFormat};
use super::{MapFault, limits};

const REMEDY: &str = "convert it with KTX-Software: ktx extract FILE.ktx2 FILE.png";
const TRANSCODE: &str = "convert it with KTX-Software: ktx extract --transcode rgba8 FILE.ktx2 FILE.png";

/// The first key of the metadata of a baked map.
const BAKED_KEY: &[u8] = b"leadr.kind\0";

/// Whether `leadr bake` wrote the file that starts with `start`. The keys come after the header.
pub(super) fn is_baked(start: &[u8]) -> bool {
    start.windows(BAKED_KEY.len()).any(|window| window == BAKED_KEY)
}

/// Returns the format of a KTX2 header in words.
pub(super) fn format_name(header: &Header) -> String {
    header.format.map_or("undefined".to_owned(), |format| format!("{format:?}"))
}

/// Returns the texel format for the number of a Vulkan format. Formats with sRGB have the same texels: the role of an image
/// determines its encoding. Integers count as codes.
fn format_of(vulkan: u32) -> Option<TexelFormat> {
    use Number::{Float, Half, Snorm8, Snorm16, Unorm8, Unorm16};
    let astc = |index: u32| {
        let sizes = [
            [4, 4],
            [5, 4],
            [5, 5],
            [6, 5],
            [6, 6],
            [8, 5],
            [8, 6],
            [8, 8],
            [10, 5],
            [10, 6],
            [10, 8],
            [10, 10],
            [12, 10],
            [12, 12],
        ];
        let [width, height] = sizes[index as usize];
        TexelFormat::Colors(ColorBlock::Astc { width, height })
    };
    let numbers = |channels, eac, signed| TexelFormat::Numbers { channels, eac, signed };
    Some(match vulkan {
        9 | 13 | 15 => TexelFormat::plain(1, Unorm8),
        10 => TexelFormat::plain(1, Snorm8),
        16 | 20 | 22 => TexelFormat::plain(2, Unorm8),
        17 => TexelFormat::plain(2, Snorm8),
        23 | 27 | 29 => TexelFormat::plain(3, Unorm8),
        24 => TexelFormat::plain(3, Snorm8),
        30 | 34 | 36 => TexelFormat::bgr(3, 3),
        37 | 41 | 43 | 51 | 55 | 57 => TexelFormat::plain(4, Unorm8),
        38 | 52 => TexelFormat::plain(4, Snorm8),
        44 | 48 | 50 => TexelFormat::bgr(4, 4),
        70 | 74 => TexelFormat::plain(1, Unorm16),
        71 => TexelFormat::plain(1, Snorm16),
        76 => TexelFormat::plain(1, Half),
        77 | 81 => TexelFormat::plain(2, Unorm16),
        78 => TexelFormat::plain(2, Snorm16),
        83 => TexelFormat::plain(2, Half),
        84 | 88 => TexelFormat::plain(3, Unorm16),
        85 => TexelFormat::plain(3, Snorm16),
        90 => TexelFormat::plain(3, Half),
        91 | 95 => TexelFormat::plain(4, Unorm16),
        92 => TexelFormat::plain(4, Snorm16),
        97 => TexelFormat::plain(4, Half),
        100 => TexelFormat::plain(1, Float),
        103 => TexelFormat::plain(2, Float),
        106 => TexelFormat::plain(3, Float),
        109 => TexelFormat::plain(4, Float),
        131 | 132 => TexelFormat::Colors(ColorBlock::Bc1 { alpha: false }),
        133 | 134 => TexelFormat::Colors(ColorBlock::Bc1 { alpha: true }),
        135 | 136 => TexelFormat::Colors(ColorBlock::Bc2),
        137 | 138 => TexelFormat::Colors(ColorBlock::Bc3),
        139 | 140 => numbers(1, false, vulkan == 140),
        141 | 142 => numbers(2, false, vulkan == 142),
        145 | 146 => TexelFormat::Colors(ColorBlock::Bc7),
        147 | 148 => TexelFormat::Colors(ColorBlock::Etc2),
        149 | 150 => TexelFormat::Colors(ColorBlock::Etc2Mask),
        151 | 152 => TexelFormat::Colors(ColorBlock::Etc2Alpha),
        153 | 154 => numbers(1, true, vulkan == 154),
        155 | 156 => numbers(2, true, vulkan == 156),
        157..=184 => astc((vulkan - 157) / 2),
        _ => return None,
    })
}

struct Opened {
    header: Header,
    format: TexelFormat,
    /// The scheme of supercompression: 0 is none, 2 Zstd, 3 zlib.
    scheme: u32,
}

fn open(bytes: &[u8]) -> Result<Opened, MapFault> {
    let start: &[u8; Header::LENGTH] =
        bytes.first_chunk().ok_or_else(|| MapFault::damaged("it ends within its header (truncated?)"))?;
    // The `ktx2` crate drops unknown values.
    let scheme = u32::from_le_bytes(start[44..48].try_into().expect("four bytes"));
    let header = Header::from_bytes(start).map_err(|fault| MapFault::damaged(format!("its header has {fault}")))?;
    if is_baked(&bytes[..bytes.len().min(1 << 16)]) {
        let remedy = "give it as --height-map, or give the pictures that it was baked from";
        return Err(MapFault::unsupported("it is a map of leadr bake, and a picture is expected", remedy));
    }
    if header.face_count > 1 || header.pixel_depth > 1 || header.layer_count > 1 {
        let what = "it is a cube map, a volume or an array, and one image is expected";
        return Err(MapFault::unsupported(what, REMEDY));
    }
    let Some(format) = header.format else {
        return Err(MapFault::unsupported("it holds Basis Universal texels (ETC1S or UASTC)", TRANSCODE));
    };
    let Some(format) = format_of(format.value()) else {
        let what = format!("its texels are {}, which is not supported", format_name(&header));
        return Err(MapFault::unsupported(what, REMEDY));
    };
    if ![0, 2, 3].contains(&scheme) {
        return Err(MapFault::unsupported("its supercompression is neither Zstandard nor zlib", TRANSCODE));
    }
    Ok(Opened { header, format, scheme })
}

/// Returns the size in the header.
pub(super) fn declared_size(bytes: &[u8]) -> Result<Size, MapFault> {
    let Opened { header, format, .. } = open(bytes)?;
    Ok(format.size(header.pixel_width, header.pixel_height.max(1)))
}

/// Decodes the largest mip level. The keys `KTXorientation` and `KTXswizzle` are applied.
pub(super) fn decode(bytes: &[u8]) -> Result<Raster, MapFault> {
    let Opened { header, format, scheme } = open(bytes)?;
    let (width, height) = (header.pixel_width, header.pixel_height.max(1));
    let size = format.size(width, height);
    limits::check_size(size.width, size.height, size.texel_bytes(), bytes.len())?;
    let part = |start: u64, length: u64, what: &str| {
        let range = usize::try_from(start).ok().zip(start.checked_add(length).and_then(|end| end.try_into().ok()));
        let found = range.and_then(|(start, end)| bytes.get(start..end));
        found.ok_or_else(|| MapFault::damaged(format!("its {what} lies beyond the end of the file (truncated?)")))
    };
    let entry = part(Header::LENGTH as u64, LevelIndex::LENGTH as u64, "list of levels")?;
    let entry = LevelIndex::from_bytes(entry.try_into().expect("as long as an entry"));
    let length = format.bytes(width, height);
    if entry.uncompressed_byte_length != length || scheme == 0 && entry.byte_length != length {
        return Err(MapFault::damaged(format!("its first level does not match {width} x {height} texels")));
    }
    let stored = part(entry.byte_offset, entry.byte_length, "first level")?;
    let keys = part(header.index.kvd_byte_offset.into(), header.index.kvd_byte_length.into(), "list of keys")?;
    let inflated;
    let texels = match scheme {
        0 => stored,
        _ => {
            inflated = inflate(stored, length as usize, scheme)?;
            &inflated
        }
    };
    let raster = format.decode(texels, width, height)?;
    let key = |name: &str| {
        let mut pairs = KeyValueDataIterator::new(keys);
        pairs.find(|(key, _)| *key == name).map(|(_, value)| value.strip_suffix(&[0]).unwrap_or(value))
    };
    let bottom_up = key("KTXorientation").is_some_and(|text| text.get(1) == Some(&b'u'));
    let swizzle = key("KTXswizzle").and_then(|text| <&[u8; 4]>::try_from(text).ok()).filter(|text| *text != b"rgba");
    if !bottom_up && swizzle.is_none() {
        return Ok(raster);
    }
    rearranged(&raster, bottom_up, swizzle.unwrap_or(b"rgba"))
}

fn inflate(stored: &[u8], length: usize, scheme: u32) -> Result<Vec<u8>, MapFault> {
    let mut texels = limits::zeroed::<u8>(length)?;
    let read = if scheme == 2 {
        // The window of a large level can be the whole level.
        let window = (length as u64).max(ruzstd::decoding::DEFAULT_MAX_WINDOW_SIZE);
        let decoder = ruzstd::decoding::StreamingDecoder::new_with_max_window_size(stored, window);
        decoder.ok().and_then(|mut decoder| decoder.read_exact(&mut texels).ok())
    } else {
        flate2::read::ZlibDecoder::new(stored).read_exact(&mut texels).ok()
    };
    read.map(|()| texels).ok_or_else(|| MapFault::damaged("its supercompressed level is invalid or ends early"))
}

/// Flips the rows, and selects the channels `r`, `g`, `b`, `a`, `0` or `1` for each channel.
fn rearranged(raster: &Raster, bottom_up: bool, swizzle: &[u8; 4]) -> Result<Raster, MapFault> {
    let [width, height] = raster.size();
    let channels = if swizzle == b"rgba" { raster.channels() } else { 4 };
    let position = |i: usize| {
        let (texel, channel) = (i / channels, i % channels);
        let [x, y] = [texel % width as usize, texel / width as usize].map(|k| k as u32);
        (x, if bottom_up { height - 1 - y } else { y }, channel)
    };
    let index = |i: usize| {
        let (x, y, channel) = position(i);
        // Grey and alpha are stored as red and green.
        let stored = match swizzle[channel] {
            b'r' => 0,
            b'g' => 1,
            b'b' => 2,
            b'a' => 3,
            other => return Err(other == b'1'),
        };
        let stored = if channels == raster.channels() && swizzle == b"rgba" { channel } else { stored };
        if stored >= raster.channels() {
            return Err(stored == 3);
        }
        Ok((y as usize * width as usize + x as usize) * raster.channels() + stored)
    };
    let count = width as usize * height as usize * channels;
    let samples = match raster.samples() {
        Samples::U8(all) => Samples::U8(
            (0..count).map(|i| index(i).map_or_else(|one| if one { u8::MAX } else { 0 }, |at| all[at])).collect(),
        ),
        Samples::U16(all) => Samples::U16(
            (0..count).map(|i| index(i).map_or_else(|one| if one { u16::MAX } else { 0 }, |at| all[at])).collect(),
        ),
        Samples::F32(all) => Samples::F32(
            (0..count).map(|i| index(i).map_or_else(|one| f32::from(u8::from(one)), |at| all[at])).collect(),
        ),
    };
    Raster::new(width, height, channels, samples)
}

#[cfg(test)]
mod tests {
    use std::io::Write;

    use super::*;
    use crate::texels::tests::{bc7, gradient};
    use crate::{decode_height_map, decode_raster};

    /// Returns a KTX2 of one level, with keys as pairs of a name and a text.
    fn ktx2(format: u32, size: [u32; 2], scheme: u32, stored: &[u8], length: u64, keys: &[(&str, &str)]) -> Vec<u8> {
        let mut pairs = Vec::new();
        for (key, text) in keys {
            let pair = [key.as_bytes(), b"\0", text.as_bytes(), b"\0"].concat();
            pairs.extend((pair.len() as u32).to_le_bytes());
            pairs.extend(&pair);
            pairs.resize(pairs.len().next_multiple_of(4), 0);
        }
        let mut file = ktx2::MAGIC.to_vec();
        for word in [format, 1, size[0], size[1], 0, 0, 1, 1, scheme, 0, 0, 104, pairs.len() as u32] {
            file.extend(word.to_le_bytes());
        }
        file.extend([0; 16]);
        for word in [104 + pairs.len() as u64, stored.len() as u64, length] {
            file.extend(word.to_le_bytes());
        }
        [file, pairs, stored.to_vec()].concat()
    }

    #[test]
    fn textures_are_plain_pictures() {
        let grey: Vec<u8> = (0..12).map(|i| 20 * i).collect();
        let heights = decode_height_map(&ktx2(9, [4, 3], 0, &grey, 12, &[])).unwrap();
        assert!((heights.texels[11] - 220.0 / 255.0).abs() < 1e-6);
        let texels = bc7();
        let mut zlib = flate2::write::ZlibEncoder::new(Vec::new(), flate2::Compression::default());
        zlib.write_all(&texels).unwrap();
        let zstd = ruzstd::encoding::compress_to_vec(&texels[..], ruzstd::encoding::CompressionLevel::Fastest);
        for (scheme, stored) in [(0, texels.clone()), (2, zstd), (3, zlib.finish().unwrap())] {
            let file = ktx2(146, [8, 8], scheme, &stored, 64, &[("KTXorientation", "rd")]);
            let raster = decode_raster(&file).unwrap();
            assert!((255.0 * raster.value(5, 2, 0) - gradient(5, 2)[0]).abs() < 4.0, "{scheme}");
            let header = crate::ImageHeader::read(&file[..130], file.len() as u64).unwrap();
            assert_eq!((header.width, header.channels, header.sample_bytes), (8, 4, 1));
            let error = decode_raster(&file[..file.len() - 9]).unwrap_err().to_string();
            assert!(error.contains("is damaged"), "{error}");
        }
        // One that claims 16 GiB.
        assert!(decode_raster(&ktx2(37, [1 << 16, 1 << 16], 2, &texels, 1 << 34, &[])).is_err());
    }

    #[test]
    fn orientation_and_swizzle_are_applied() {
        let texels = [1, 2, 3, 4, 5, 6, 7, 8];
        let read = |keys: &[(&str, &str)]| decode_raster(&ktx2(37, [1, 2], 0, &texels, 8, keys)).unwrap();
        let codes = |raster: Raster| match raster.samples() {
            Samples::U8(codes) => codes.clone(),
            other => panic!("{other:?}"),
        };
        assert_eq!(codes(read(&[])), texels);
        assert_eq!(codes(read(&[("KTXorientation", "ru")])), [5, 6, 7, 8, 1, 2, 3, 4]);
        assert_eq!(codes(read(&[("KTXswizzle", "bgr1")])), [3, 2, 1, 255, 7, 6, 5, 255]);
        let grey = ktx2(9, [2, 1], 0, &[9, 8], 2, &[("KTXswizzle", "rrr1")]);
        assert_eq!(codes(decode_raster(&grey).unwrap()), [9, 9, 9, 255, 8, 8, 8, 255]);
    }

    #[test]
    fn refusals_are_plain_words() {
        let error = |file: &[u8]| decode_raster(file).unwrap_err().to_string();
        let basis = error(&ktx2(0, [4, 4], 1, &[0; 16], 0, &[]));
        assert!(basis.contains("Basis Universal") && basis.contains("ktx extract --transcode rgba8"), "{basis}");
        let packed = error(&ktx2(122, [1, 1], 0, &[0; 4], 4, &[]));
        assert!(packed.contains("its texels are B10G11R11_UFLOAT_PACK32, which is not supported"), "{packed}");
        let baked = error(&ktx2(9, [1, 1], 0, &[0], 1, &[("leadr.kind", "leadr")]));
        assert!(baked.contains("it is a map of leadr bake"), "{baked}");
        let mut cube = ktx2(9, [1, 1], 0, &[0], 1, &[]);
        cube[36] = 6;
        assert!(error(&cube).contains("cube map"), "{}", error(&cube));
        let short = error(&ktx2(37, [2, 2], 0, &[0; 15], 15, &[]));
        assert!(short.contains("does not match 2 x 2"), "{short}");
    }
}
