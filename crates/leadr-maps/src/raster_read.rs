//! Decodes files of 8-bit and 16-bit codes, and TIFF, to a [`Raster`]. The size is checked before decompression. Palettes, and
//! greys of 1, 2 or 4 bits, are expanded to 8 bits. Interlacing is supported. Only the first frame of an animation is read.
//! Colour profiles and gamma are ignored, as in glTF.

use std::io::Cursor;

use image::codecs::bmp::BmpDecoder;
use image::codecs::jpeg::JpegDecoder;
use image::codecs::png::PngDecoder;
use image::codecs::pnm::PnmDecoder;
use image::codecs::tga::TgaDecoder;
use image::codecs::webp::WebPDecoder;
use image::{ImageDecoder, ImageError, ImageResult, Limits};

use super::fault::one_line;
use super::guard::guarded;
use super::image_format::{ImageFormat, unrecognised};
use super::material::{Raster, Samples};
use super::{MapFault, dds_read, ktx2_read, limits, tiff_read};

const NO_END: &str = "its end marker is missing, but all its rows are complete";
const REMEDY: &str = "save it as an 8 or 16-bit grey or RGB PNG";
/// The formats of [`decode_raster`] and EXR, for error messages.
pub(super) const EXPECTED: &str = "a PNG, JPEG, TIFF, WebP, TGA, BMP, PNM, KTX2, DDS or EXR image";

/// The size in the header of an image.
#[derive(Clone, Copy, Debug)]
pub(super) struct Size {
    pub width: u64,
    pub height: u64,
    pub channels: usize,
    /// Maximum bytes per sample while the image is decoded.
    pub sample_bytes: u64,
}

impl Size {
    pub fn texel_bytes(self) -> u64 {
        self.channels as u64 * self.sample_bytes
    }
}

/// Decodes a PNG, JPEG, TIFF, WebP, TGA, BMP, PNM, KTX2 or DDS image. The first bytes determine the format. KTX2 and DDS
/// textures must hold one image, of which the largest mip level is read; signed codes become codes from 0 to 1. The orientation in EXIF data
/// is not applied: texture coordinates belong to the stored rows, as in glTF.
///
/// # Errors
/// Fails if the format is unsupported, or if the file is damaged or exceeds [`limits`].
pub fn decode_raster(bytes: &[u8]) -> Result<Raster, MapFault> {
    decode_raster_with_remarks(bytes).map(|(raster, _)| raster)
}

/// Like [`decode_raster`], but also returns a sentence for each property of the file that was repaired or left aside.
///
/// # Errors
/// Returns the errors of [`decode_raster`].
pub fn decode_raster_with_remarks(bytes: &[u8]) -> Result<(Raster, Vec<String>), MapFault> {
    let mut remarks = Vec::new();
    let raster = match ImageFormat::of(bytes) {
        Some(ImageFormat::Jpeg) => guarded("JPEG", || decode_jpeg(bytes, &mut remarks)),
        Some(ImageFormat::Png) => guarded("PNG", || decode_png(bytes, &mut remarks)),
        Some(ImageFormat::Tiff) => guarded("TIFF", || tiff_read::decode(bytes, &mut remarks)),
        Some(ImageFormat::Ktx2) => guarded("KTX2", || ktx2_read::decode(bytes)),
        Some(ImageFormat::Dds) => guarded("DDS", || dds_read::decode(bytes)),
        Some(format @ (ImageFormat::WebP | ImageFormat::Bmp | ImageFormat::Pnm | ImageFormat::Tga)) => {
            guarded(format.short_name(), || unpack(opened(format, bytes)?, bytes.len(), format, &mut remarks))
        }
        _ => Err(unrecognised(bytes, EXPECTED, "FILE.png")),
    }?;
    Ok((raster, remarks))
}

/// Returns the size in the header of a raster file.
pub(super) fn declared_size(format: ImageFormat, bytes: &[u8]) -> Result<Size, MapFault> {
    guarded(format.short_name(), || match format {
        ImageFormat::Tiff => tiff_read::declared_size(bytes),
        ImageFormat::Ktx2 => ktx2_read::declared_size(bytes),
        ImageFormat::Dds => dds_read::declared_size(bytes),
        _ => Ok(size_of(&*opened(format, bytes)?)),
    })
}

/// Reads the header of a PNG.
pub(super) fn png_decoder(bytes: &[u8]) -> Result<PngDecoder<Cursor<&[u8]>>, MapFault> {
    let mut most = Limits::no_limits();
    most.max_image_width = Some(limits::MAX_SIDE as u32);
    most.max_image_height = Some(limits::MAX_SIDE as u32);
    most.max_alloc = Some(limits::MAX_DECODED_BYTES);
    PngDecoder::with_limits(Cursor::new(bytes), most).map_err(|error| fault(error, ImageFormat::Png))
}

fn size_of(decoder: &dyn ImageDecoder) -> Size {
    let ((width, height), color) = (decoder.dimensions(), decoder.color_type());
    let channels = usize::from(color.channel_count());
    let sample_bytes = u64::from(color.bytes_per_pixel()) / channels as u64;
    Size { width: width.into(), height: height.into(), channels, sample_bytes }
}

/// Reads the header of a file that the `image` crate decodes.
fn opened<'a>(format: ImageFormat, bytes: &'a [u8]) -> Result<Box<dyn ImageDecoder + 'a>, MapFault> {
    if format == ImageFormat::Png {
        return Ok(Box::new(png_decoder(bytes)?));
    }
    let file = Cursor::new(bytes);
    let open = || -> ImageResult<Box<dyn ImageDecoder + 'a>> {
        Ok(match format {
            ImageFormat::Jpeg => Box::new(JpegDecoder::new(file)?),
            ImageFormat::WebP => Box::new(WebPDecoder::new(file)?),
            ImageFormat::Bmp => Box::new(BmpDecoder::new(file)?),
            ImageFormat::Pnm => Box::new(PnmDecoder::new(file)?),
            _ => Box::new(TgaDecoder::new(file)?),
        })
    };
    open().map_err(|error| fault(error, format))
}

fn decode_png(bytes: &[u8], remarks: &mut Vec<String>) -> Result<Raster, MapFault> {
    const END: &[u8; 12] = b"\0\0\0\0IEND\xae\x42\x60\x82";
    let decode = |bytes: &[u8], remarks: &mut Vec<String>| {
        unpack(opened(ImageFormat::Png, bytes)?, bytes.len(), ImageFormat::Png, remarks)
    };
    let read = decode(bytes, remarks);
    if read.is_ok() || bytes.windows(END.len()).any(|window| window == END) {
        return read;
    }
    // Missing rows stay an error.
    let ended = decode(&[bytes, END].concat(), &mut Vec::new());
    ended.inspect(|_| remarks.push(NO_END.to_owned())).or(read)
}

fn decode_jpeg(bytes: &[u8], remarks: &mut Vec<String>) -> Result<Raster, MapFault> {
    let decode = |bytes: &[u8], remarks: &mut Vec<String>| {
        unpack(opened(ImageFormat::Jpeg, bytes)?, bytes.len(), ImageFormat::Jpeg, remarks)
    };
    if has_end(bytes) {
        return decode(bytes, remarks);
    }
    // The decoder fills missing rows. If the rows are complete, further data before the end marker do not change them.
    let data = bytes.strip_suffix(&[0xff]).unwrap_or(bytes);
    let ended = |more: &[u8]| [data, more, &[0xff, 0xd9]].concat();
    let read = decode(&ended(&[]), remarks)?;
    let complete = [[0x35u8, 0xa6], [0xc9, 0x13]]
        .iter()
        .all(|more| decode(&ended(&more.repeat(512)), &mut Vec::new()).is_ok_and(|other| other == read));
    if !complete {
        return Err(MapFault::damaged("its JPEG data end early"));
    }
    remarks.push(NO_END.to_owned());
    Ok(read)
}

fn unpack(
    mut decoder: Box<dyn ImageDecoder + '_>,
    file_bytes: usize,
    format: ImageFormat,
    remarks: &mut Vec<String>,
) -> Result<Raster, MapFault> {
    let size = size_of(&*decoder);
    limits::check_size(size.width, size.height, size.texel_bytes(), file_bytes)?;
    remarks.extend(decoder.orientation().ok().and_then(|orientation| turned(orientation.to_exif().into())));
    let count = (size.width * size.height) as usize * size.channels;
    let samples = match size.sample_bytes {
        1 => {
            let mut samples = limits::zeroed::<u8>(count)?;
            decoder.read_image(&mut samples).map_err(|error| fault(error, format))?;
            Samples::U8(samples)
        }
        2 => {
            let mut samples = limits::zeroed::<u16>(count)?;
            decoder.read_image(bytemuck::cast_slice_mut(&mut samples)).map_err(|error| fault(error, format))?;
            Samples::U16(samples)
        }
        _ => return Err(MapFault::unsupported("its samples have more than 16 bits", REMEDY)),
    };
    Raster::new(size.width as u32, size.height as u32, size.channels, samples)
}

/// Returns the remark about an EXIF orientation other than 1.
pub(super) fn turned(orientation: u16) -> Option<String> {
    (2..=8)
        .contains(&orientation)
        .then(|| format!("its orientation tag ({orientation}) is not applied; rotate the stored image to apply it"))
}

/// Converts inks, which are 0 without ink, to colours.
pub(super) fn cmyk_to_rgb([c, m, y, k]: &[u8; 4]) -> [u8; 3] {
    [c, m, y].map(|ink| {
        let light = u32::from(255 - ink) * u32::from(255 - k);
        ((light + 127) / 255) as u8
    })
}

/// Converts a decoder error to a `MapFault`.
fn fault(error: ImageError, format: ImageFormat) -> MapFault {
    match error {
        ImageError::Unsupported(reason) => MapFault::unsupported(one_line(&reason), REMEDY),
        ImageError::Limits(reason) => MapFault::too_large(one_line(&reason)),
        ImageError::IoError(_) => MapFault::damaged(format!("its {} data end early", format.short_name())),
        other => MapFault::damaged(one_line(&other)),
    }
}

/// Whether a JPEG has its end marker after the first scan. Segments before the scan may contain other JPEGs, such as thumbnails.
fn has_end(bytes: &[u8]) -> bool {
    let mut at = 2;
    while let Some(&[0xff, marker]) = bytes.get(at..at + 2) {
        match marker {
            // After a start of scan, the only markers in the data are restarts.
            0xda => return bytes[at..].windows(2).any(|pair| pair == [0xff, 0xd9]),
            0xff => at += 1,
            0x01 | 0xd0..=0xd8 => at += 2,
            _ => {
                let Some(length) = bytes.get(at + 2..at + 4) else { return false };
                at += 2 + usize::from(u16::from_be_bytes([length[0], length[1]]));
            }
        }
    }
    false
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::load::{decode_color, decode_height_map};
    use crate::srgb::linear_from_srgb;
    use image::{DynamicImage, ImageFormat as Kind};

    fn encode(image: &DynamicImage, kind: Kind) -> Vec<u8> {
        let mut file = Cursor::new(Vec::new());
        image.write_to(&mut file, kind).unwrap();
        file.into_inner()
    }

    #[test]
    fn lossless_formats_keep_their_codes() {
        let color = image::RgbImage::from_fn(5, 3, |x, y| image::Rgb([x as u8 * 50, y as u8 * 100, 7]));
        let grey = image::GrayImage::from_fn(5, 3, |x, y| image::Luma([x as u8 * 50 + y as u8]));
        for kind in [Kind::Png, Kind::WebP, Kind::Tga, Kind::Bmp, Kind::Pnm] {
            let bytes = encode(&color.clone().into(), kind);
            let (raster, remarks) = decode_raster_with_remarks(&bytes).unwrap();
            let texel = |x, y| [0, 1, 2].map(|c| (raster.value(x, y, c) * 255.0).round() as u8);
            assert_eq!(
                (raster.size(), texel(4, 0), texel(1, 2), remarks.len()),
                ([5, 3], [200, 0, 7], [50, 200, 7], 0)
            );
            let [red, ..] = decode_color(&bytes).unwrap().texels[4];
            assert!((red - linear_from_srgb(200.0 / 255.0)).abs() < 1e-6, "{kind:?}");
            let header = crate::ImageHeader::read(&bytes, bytes.len() as u64).unwrap();
            assert_eq!((header.width, header.height), (5, 3), "{kind:?}");
            assert!(decode_raster(&bytes[..bytes.len() / 2]).is_err(), "{kind:?}");
            if kind != Kind::WebP {
                let heights = decode_height_map(&encode(&grey.clone().into(), kind)).unwrap();
                assert!((heights.texels[14] - 202.0 / 255.0).abs() < 1e-6, "{kind:?}");
            }
        }
    }

    #[test]
    fn only_images_with_all_rows_may_lack_their_end() {
        let image = image::RgbImage::from_fn(64, 64, |x, y| image::Rgb([x as u8 * 4, y as u8 * 4, (x * y) as u8]));
        let image = DynamicImage::from(image);
        let png = encode(&image, Kind::Png);
        let (read, remarks) = decode_raster_with_remarks(&png[..png.len() - 12]).unwrap();
        assert_eq!((read, remarks.len()), (decode_raster(&png).unwrap(), 1));
        assert!(decode_raster(&png[..png.len() - 40]).is_err());
        let whole = encode(&image, Kind::Jpeg);
        let (read, none) = decode_raster_with_remarks(&whole).unwrap();
        let (same, remarks) = decode_raster_with_remarks(&whole[..whole.len() - 2]).unwrap();
        assert_eq!((&read, none.len(), remarks.len()), (&same, 0, 1));
        for length in [whole.len() - 12, whole.len() * 3 / 4, whole.len() / 2] {
            let error = decode_raster(&whole[..length]).unwrap_err().to_string();
            assert!(error.contains("its JPEG data end early"), "{length}: {error}");
        }
    }

    #[test]
    fn an_orientation_tag_is_not_applied_but_named() {
        let image = image::GrayImage::from_fn(16, 8, |x, _| image::Luma([x as u8 * 16]));
        let jpeg = encode(&image.into(), Kind::Jpeg);
        let tiff = [&b"Exif\0\0II*\0\x08\0\0\0\x01\0\x12\x01\x03\0\x01\0\0\0\x06\0\0\0\0\0\0\0"[..]].concat();
        let length = (tiff.len() as u16 + 2).to_be_bytes();
        let turned = [&jpeg[..2], &[0xff, 0xe1], &length, &tiff, &jpeg[2..]].concat();
        let (raster, remarks) = decode_raster_with_remarks(&turned).unwrap();
        assert_eq!((raster.size(), remarks.len()), ([16, 8], 1));
        assert!(remarks[0].contains("orientation tag (6) is not applied"), "{remarks:?}");
    }
}
