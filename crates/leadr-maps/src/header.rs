//! The size of an image from the start of its file, to reserve memory before the image is decoded.

use std::path::Path;

use super::image_format::{ImageFormat, unrecognised};
use super::limits::{MAX_FILE_BYTES, check_size, first_bytes, open};
use super::raster_read::{self, EXPECTED, Size};
use super::{MapFault, exr_read, hdr};

/// Bytes at the start of a file that usually contain the header of an image.
const START: u64 = 1 << 16;

/// The declared size of an image, within [`limits`](crate::limits).
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageHeader {
    /// Width in texels.
    pub width: u32,
    /// Height in texels.
    pub height: u32,
    /// Number of channels.
    pub channels: usize,
    /// Maximum bytes of a decoded sample.
    pub sample_bytes: u64,
}

impl ImageHeader {
    /// Reads the header of an image in any [`ImageFormat`] from the first bytes of a file of `file_bytes` bytes.
    ///
    /// # Errors
    /// Fails if the format is unsupported, the header is damaged or continues after `start`, or the size exceeds
    /// [`limits`](crate::limits).
    pub fn read(start: &[u8], file_bytes: u64) -> Result<Self, MapFault> {
        let floats = |(width, height, texel_bytes): (u64, u64, u64)| Size {
            width,
            height,
            channels: texel_bytes as usize / 4,
            sample_bytes: 4,
        };
        let sizes = match ImageFormat::of(start) {
            Some(ImageFormat::Hdr) => vec![floats(hdr::declared_size(start)?)],
            Some(ImageFormat::Exr) => exr_read::declared_sizes(start)?.into_iter().map(floats).collect(),
            Some(format) => vec![raster_read::declared_size(format, start)?],
            None => return Err(unrecognised(start, EXPECTED, "FILE.png")),
        };
        let file_bytes = usize::try_from(file_bytes).unwrap_or(usize::MAX);
        let check = |size: &Size| check_size(size.width, size.height, size.texel_bytes(), file_bytes);
        // A part that is too large cannot be the one that is decoded.
        let fitting = sizes.iter().filter(|size| check(size).is_ok());
        let largest = fitting.max_by_key(|size| size.width * size.height * size.texel_bytes());
        let Some(&Size { width, height, channels, sample_bytes }) = largest else {
            return Err(sizes
                .first()
                .and_then(|size| check(size).err())
                .unwrap_or_else(|| MapFault::damaged("it has no part")));
        };
        Ok(Self { width: width as u32, height: height as u32, channels, sample_bytes })
    }

    /// Reads the header of an image file. Returns the header with the length of the file in bytes.
    ///
    /// # Errors
    /// Returns the errors of [`Self::read`], and those of the operating system.
    pub fn of_file(path: &Path) -> Result<(Self, u64), MapFault> {
        let (file, length) = open(path)?;
        let start = first_bytes(&file, START)?;
        let header = Self::read(&start, length).or_else(|fault| {
            if length <= START {
                return Err(fault);
            }
            // Some files have a colour profile or a thumbnail before their size.
            Self::read(&first_bytes(&open(path)?.0, MAX_FILE_BYTES)?, length)
        })?;
        Ok((header, length))
    }

    /// Returns the number of texels.
    pub fn texels(self) -> u64 {
        u64::from(self.width) * u64::from(self.height)
    }

    /// Returns the maximum bytes of the decoded image.
    pub fn decoded_bytes(self) -> u64 {
        self.texels() * self.channels as u64 * self.sample_bytes
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::HeightMap;
    use crate::save::{encode_exr, encode_png_grey16};

    #[test]
    fn headers_give_the_size_of_the_decoded_image() {
        let map = HeightMap::new(6, 4, vec![0.5; 24]).unwrap();
        let png = encode_png_grey16(&map, 0.0, 1.0).unwrap();
        let plane = vec![0.5; 24];
        let exr = encode_exr(6, 4, &[("R", &plane), ("G", &plane), ("B", &plane)]).unwrap();
        let mut jpeg = Vec::new();
        image::codecs::jpeg::JpegEncoder::new(&mut jpeg)
            .encode(&[9; 72], 6, 4, image::ExtendedColorType::Rgb8)
            .unwrap();
        let hdr = b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 6\n".to_vec();
        for (bytes, channels, sample_bytes) in [(png, 1, 2), (jpeg, 3, 1), (exr, 3, 4), (hdr, 3, 4)] {
            let header = ImageHeader::read(&bytes, bytes.len() as u64).unwrap();
            assert_eq!(header, ImageHeader { width: 6, height: 4, channels, sample_bytes });
            assert_eq!(header.decoded_bytes(), 24 * channels as u64 * sample_bytes);
            assert!(ImageHeader::read(&bytes[..6], 6).is_err());
        }
    }

    #[test]
    fn headers_after_a_long_profile_are_found() {
        let folder = tempfile::tempdir().unwrap();
        let file = folder.path().join("a.jpg");
        let mut jpeg = Vec::new();
        image::codecs::jpeg::JpegEncoder::new(&mut jpeg).encode(&[9; 4], 2, 2, image::ExtendedColorType::L8).unwrap();
        let comment = [&[0xff, 0xfe, 0xff, 0xff][..], &[b'a'; 0xfffd]].concat();
        let long = [&jpeg[..2], &comment[..], &comment[..], &jpeg[2..]].concat();
        std::fs::write(&file, &long).unwrap();
        let (header, length) = ImageHeader::of_file(&file).unwrap();
        assert_eq!((header.texels(), length), (4, long.len() as u64));
    }
}
