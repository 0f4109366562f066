//! TIFF reader. Only the first image of a file is read.

use std::io::Cursor;

use tiff::decoder::{Decoder, DecodingResult, Limits};
use tiff::tags::Tag;
use tiff::{ColorType, TiffError};

use super::fault::one_line;
use super::material::{Raster, Samples};
use super::raster_read::{Size, cmyk_to_rgb};
use super::{MapFault, limits};

const REMEDY: &str =
    "save it as 8, 16 or 32-bit grey or RGB TIFF with LZW or ZIP (Deflate) compression, or as a 16-bit PNG";

fn fault(error: TiffError) -> MapFault {
    match error {
        TiffError::UnsupportedError(what) => MapFault::unsupported(one_line(&what), REMEDY),
        TiffError::LimitsExceeded => MapFault::too_large("a strip or tag exceeds the memory limit"),
        other => MapFault::damaged(one_line(&other)),
    }
}

struct Opened<'a> {
    decoder: Decoder<Cursor<&'a [u8]>>,
    channels: usize,
    /// The bits of a sample.
    bits: u8,
}

fn open(bytes: &[u8]) -> Result<Opened<'_>, MapFault> {
    let mut most = Limits::default();
    most.decoding_buffer_size = limits::MAX_DECODED_BYTES as usize;
    most.intermediate_buffer_size = limits::MAX_DECODED_BYTES as usize;
    most.ifd_value_size = 64 << 20;
    let mut decoder = Decoder::new(Cursor::new(bytes)).map_err(fault)?.with_limits(most);
    let (channels, bits) = match decoder.colortype().map_err(fault)? {
        ColorType::Gray(bits) => (1, bits),
        ColorType::GrayA(bits) => (2, bits),
        ColorType::RGB(bits) | ColorType::YCbCr(bits) => (3, bits),
        ColorType::RGBA(bits) | ColorType::CMYK(bits) => (4, bits),
        ColorType::Multiband { bit_depth, num_samples } => (num_samples.into(), bit_depth),
        ColorType::Lab(_) => return Err(MapFault::unsupported("its colours are CIE L*a*b*", REMEDY)),
        _ => return Err(MapFault::unsupported("its colours are a palette or CMYK with alpha", REMEDY)),
    };
    Ok(Opened { decoder, channels, bits })
}

/// Returns the size in the header of a TIFF. The tags may lie at the end of the file, so `bytes` must be the whole file.
pub(super) fn declared_size(bytes: &[u8]) -> Result<Size, MapFault> {
    let Opened { mut decoder, channels, bits } = open(bytes)?;
    let (width, height) = decoder.dimensions().map_err(fault)?;
    // Integers of 32 bits become floats, so the decoded image and the result exist together.
    let sample_bytes = u64::from(bits.div_ceil(8)) * if bits > 16 { 2 } else { 1 };
    Ok(Size { width: width.into(), height: height.into(), channels, sample_bytes })
}

/// Decodes a TIFF of grey, RGB or CMYK colours, with or without alpha. Unsigned integers of 8 and 16 bits keep their
/// codes, unsigned integers of 32 bits become floats from 0 to 1, and signed integers and floats are as stored. Files with
/// further bands give the first band.
pub(super) fn decode(bytes: &[u8], remarks: &mut Vec<String>) -> Result<Raster, MapFault> {
    let size = declared_size(bytes)?;
    limits::check_size(size.width, size.height, size.texel_bytes(), bytes.len())?;
    let Opened { mut decoder, mut channels, bits } = open(bytes)?;
    let kind = decoder.colortype().map_err(fault)?;
    let mut read = DecodingResult::U8(Vec::new());
    let layout = decoder.read_image_to_buffer(&mut read).map_err(fault)?;
    let (width, height) = (size.width as usize, size.height as usize);
    let planes = layout.planes;
    let samples = match read {
        DecodingResult::U8(codes) if bits < 8 => Samples::U8(expand(&codes, bits, width * channels, height)?),
        DecodingResult::U8(codes) => Samples::U8(codes),
        DecodingResult::U16(codes) => Samples::U16(codes),
        DecodingResult::U32(codes) => floats(codes, |v| (f64::from(v) / f64::from(u32::MAX)) as f32),
        DecodingResult::I8(values) => floats(values, f32::from),
        DecodingResult::I16(values) => floats(values, f32::from),
        DecodingResult::I32(values) => floats(values, |v| v as f32),
        DecodingResult::F16(values) => floats(values, half::f16::to_f32),
        DecodingResult::F32(values) => Samples::F32(values),
        DecodingResult::F64(values) => floats(values, |v| v as f32),
        DecodingResult::U64(_) | DecodingResult::I64(_) => {
            return Err(MapFault::unsupported("its samples are 64-bit integers", REMEDY));
        }
    };
    let samples = match samples {
        Samples::U8(all) => Samples::U8(interleaved(all, planes, channels)),
        Samples::U16(all) => Samples::U16(interleaved(all, planes, channels)),
        Samples::F32(all) => Samples::F32(interleaved(all, planes, channels)),
    };
    let samples = match (kind, samples) {
        (ColorType::CMYK(_), Samples::U8(inks)) => {
            channels = 3;
            Samples::U8(inks.as_chunks().0.iter().flat_map(cmyk_to_rgb).collect())
        }
        (ColorType::CMYK(_), _) => return Err(MapFault::unsupported("its CMYK colours do not have 8 bits", REMEDY)),
        // Two bands are grey and alpha.
        (ColorType::Multiband { .. }, samples) if channels > 2 => {
            let bands = std::mem::replace(&mut channels, 1);
            remarks.push(format!("it has {bands} bands without a meaning; the first is read"));
            match samples {
                Samples::U8(all) => Samples::U8(all.into_iter().step_by(bands).collect()),
                Samples::U16(all) => Samples::U16(all.into_iter().step_by(bands).collect()),
                Samples::F32(all) => Samples::F32(all.into_iter().step_by(bands).collect()),
            }
        }
        (_, samples) => samples,
    };
    let orientation = decoder.find_tag_unsigned::<u16>(Tag::Orientation).ok().flatten().unwrap_or(1);
    remarks.extend(super::raster_read::turned(orientation));
    Raster::new(size.width as u32, size.height as u32, channels, samples)
}

fn floats<T>(values: Vec<T>, of: impl Fn(T) -> f32) -> Samples {
    Samples::F32(values.into_iter().map(of).collect())
}

/// Expands samples of 1, 2 or 4 bits, whose rows start on whole bytes, to 8 bits.
fn expand(packed: &[u8], bits: u8, row: usize, height: usize) -> Result<Vec<u8>, MapFault> {
    if ![1, 2, 4].contains(&bits) {
        return Err(MapFault::unsupported(format!("its samples have {bits} bits"), REMEDY));
    }
    let (bits, most) = (usize::from(bits), (1u16 << bits) - 1);
    let stride = (row * bits).div_ceil(8);
    if packed.len() < stride * height {
        return Err(MapFault::damaged("its rows end early"));
    }
    let sample = |y: usize, x: usize| {
        let at = x * bits;
        let code = u16::from(packed[y * stride + at / 8]) >> (8 - bits - at % 8) & most;
        (code * 255 / most) as u8
    };
    Ok((0..height).flat_map(|y| (0..row).map(move |x| sample(y, x))).collect())
}

/// Interleaves the channels of images that store each channel as a plane.
fn interleaved<T: Copy>(all: Vec<T>, planes: usize, channels: usize) -> Vec<T> {
    if planes != channels || planes < 2 {
        return all;
    }
    let plane = all.len() / planes;
    (0..plane).flat_map(|i| (0..planes).map(move |c| (i, c))).map(|(i, c)| all[c * plane + i]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tiff::encoder::{Compression, TiffEncoder, colortype};

    fn encode<C: colortype::ColorType>(compression: Compression, samples: &[C::Inner]) -> Vec<u8>
    where
        [C::Inner]: tiff::encoder::TiffValue,
    {
        let mut file = Cursor::new(Vec::new());
        let mut encoder = TiffEncoder::new(&mut file).unwrap().with_compression(compression);
        encoder.write_image::<C>(2, 2, samples).unwrap();
        file.into_inner()
    }

    #[test]
    fn missing_heights_are_filled() {
        for missing in [-9999.0, f32::MIN] {
            let file = encode::<colortype::Gray32Float>(Compression::Lzw, &[200.0, 201.0, 202.0, missing]);
            let map = crate::decode_height_map(&file).unwrap();
            assert!(map.texels[..3] == [200.0, 201.0, 202.0] && (200.0..=202.0).contains(&map.texels[3]), "{map:?}");
        }
    }

    #[test]
    fn every_sample_format_keeps_its_values() {
        use Compression::{Deflate, Lzw, Packbits, Uncompressed};
        use colortype::{Gray8, Gray16, Gray32, Gray32Float, GrayI16, RGB8, RGB16, RGBA8};
        let deflate = Deflate(Default::default());
        let cases: [(&str, Vec<u8>, usize, Samples); 8] = [
            ("8 bits", encode::<Gray8>(Uncompressed, &[0, 1, 128, 255]), 1, Samples::U8(vec![0, 1, 128, 255])),
            ("16 bits", encode::<Gray16>(Lzw, &[0, 1, 700, 65535]), 1, Samples::U16(vec![0, 1, 700, 65535])),
            (
                "32 bits",
                encode::<Gray32>(deflate, &[0, u32::MAX / 2, u32::MAX, 0]),
                1,
                Samples::F32(vec![0.0, 0.5, 1.0, 0.0]),
            ),
            ("signed", encode::<GrayI16>(Lzw, &[-7, 0, 2400, 1]), 1, Samples::F32(vec![-7.0, 0.0, 2400.0, 1.0])),
            (
                "floats",
                encode::<Gray32Float>(deflate, &[-0.5, 0.0, 1e4, 0.1]),
                1,
                Samples::F32(vec![-0.5, 0.0, 1e4, 0.1]),
            ),
            ("colours", encode::<RGB8>(Packbits, &[9; 12]), 3, Samples::U8(vec![9; 12])),
            ("fine colours", encode::<RGB16>(Lzw, &[900; 12]), 3, Samples::U16(vec![900; 12])),
            ("alpha", encode::<RGBA8>(Lzw, &[7; 16]), 4, Samples::U8(vec![7; 16])),
        ];
        for (name, bytes, channels, samples) in cases {
            let mut remarks = Vec::new();
            let raster = decode(&bytes, &mut remarks).unwrap_or_else(|error| panic!("{name}: {error}"));
            assert_eq!((raster.size(), raster.channels(), raster.samples()), ([2, 2], channels, &samples), "{name}");
            assert_eq!(remarks, Vec::<String>::new(), "{name}");
            let size = declared_size(&bytes).unwrap();
            assert!(size.texel_bytes() >= channels as u64, "{name}: {size:?}");
            assert!(decode(&bytes[..bytes.len() / 2], &mut remarks).is_err(), "{name}");
        }
    }

    #[test]
    fn rows_of_few_bits_are_expanded() {
        assert_eq!(expand(&[0b1010_0000, 0b0100_0000], 1, 3, 2).unwrap(), [255, 0, 255, 0, 255, 0]);
        assert_eq!(expand(&[0b1101_1000, 0x40], 2, 2, 2).unwrap(), [255, 85, 85, 0]);
        assert_eq!(expand(&[0xf0, 0x31], 4, 2, 2).unwrap(), [255, 0, 51, 17]);
        assert!(expand(&[0], 1, 8, 2).is_err() && expand(&[0; 9], 6, 2, 2).is_err());
        assert_eq!(interleaved(vec![1, 2, 11, 12, 21, 22], 3, 3), [1, 11, 21, 2, 12, 22]);
    }
}
