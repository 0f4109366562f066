//! Formats of image files by their first bytes.

use super::{MapFault, exr_read, hdr};

/// The format of an image file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum ImageFormat {
    /// PNG. Only the letters of its signature count, so that a file whose signature was damaged in transfer is reported as
    /// damaged instead of unknown.
    Png,
    /// JPEG.
    Jpeg,
    /// TIFF, including BigTIFF.
    Tiff,
    /// WebP.
    WebP,
    /// Windows bitmap.
    Bmp,
    /// Netpbm: PBM, PGM, PPM and PAM.
    Pnm,
    /// Truevision TGA.
    Tga,
    /// DirectDraw surface.
    Dds,
    /// KTX2, which includes baked maps.
    Ktx2,
    /// OpenEXR.
    Exr,
    /// Radiance HDR.
    Hdr,
}

/// Signatures of the formats, each as a byte string at an offset.
const SIGNATURES: &[(ImageFormat, usize, &[u8])] = &[
    (ImageFormat::Png, 1, b"PNG"),
    (ImageFormat::Jpeg, 0, b"\xff\xd8"),
    (ImageFormat::Tiff, 0, b"II*\0"),
    (ImageFormat::Tiff, 0, b"MM\0*"),
    (ImageFormat::Tiff, 0, b"II+\0"),
    (ImageFormat::Tiff, 0, b"MM\0+"),
    (ImageFormat::Dds, 0, b"DDS "),
    (ImageFormat::Ktx2, 0, b"\xabKTX 20"),
];

/// Formats that are not supported, with their signatures.
const FOREIGN: &[(&str, usize, &[u8])] = &[
    ("a Photoshop document", 0, b"8BPS"),
    ("a JPEG XL", 0, b"\xff\x0a"),
    ("a JPEG XL", 4, b"JXL "),
    ("an AVIF", 4, b"ftypavif"),
    ("a HEIC", 4, b"ftyphei"),
    ("a JPEG 2000", 4, b"jP  "),
    ("a GIF", 0, b"GIF8"),
    ("a KTX of version 1", 0, b"\xabKTX 11"),
    ("a Basis file", 0, b"sB\x13\0"),
    ("a PFM", 0, b"PF\n"),
    ("a PFM", 0, b"Pf\n"),
];

fn begins(bytes: &[u8], at: usize, with: &[u8]) -> bool {
    bytes.get(at..at + with.len()) == Some(with)
}

impl ImageFormat {
    /// Returns the format of a file that starts with `bytes`, or `None` for other formats. TGA files have no signature and
    /// are recognised by a consistent header of 18 bytes.
    pub fn of(bytes: &[u8]) -> Option<Self> {
        let signed = SIGNATURES.iter().find(|(_, at, with)| begins(bytes, *at, with)).map(|(format, ..)| *format);
        signed.or_else(|| {
            if exr_read::is_exr(bytes) {
                Some(Self::Exr)
            } else if hdr::is_hdr(bytes) {
                Some(Self::Hdr)
            } else if bytes.starts_with(b"RIFF") && begins(bytes, 8, b"WEBP") {
                Some(Self::WebP)
            } else if is_bmp(bytes) {
                Some(Self::Bmp)
            } else if is_pnm(bytes) {
                Some(Self::Pnm)
            } else {
                is_tga(bytes).then_some(Self::Tga)
            }
        })
    }

    /// Returns the name of the format with its article.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Png => "a PNG",
            Self::Jpeg => "a JPEG",
            Self::Tiff => "a TIFF",
            Self::WebP => "a WebP",
            Self::Bmp => "a BMP",
            Self::Pnm => "a PNM",
            Self::Tga => "a TGA",
            Self::Dds => "a DDS",
            Self::Ktx2 => "a KTX2",
            Self::Exr => "an EXR",
            Self::Hdr => "a Radiance HDR",
        }
    }

    /// Returns the name of the format.
    pub(super) fn short_name(self) -> &'static str {
        self.name().split_once(' ').map_or(self.name(), |(_, name)| name)
    }

    /// Whether [`decode_raster`](crate::decode_raster) reads the format.
    pub const fn is_raster(self) -> bool {
        !matches!(self, Self::Exr | Self::Hdr)
    }
}

fn is_bmp(bytes: &[u8]) -> bool {
    bytes.starts_with(b"BM") && matches!(bytes.get(14..18), Some([12 | 40 | 52 | 56 | 64 | 108 | 124, 0, 0, 0]))
}

fn is_pnm(bytes: &[u8]) -> bool {
    matches!(bytes, [b'P', b'1'..=b'7', b' ' | b'\t' | b'\n' | b'\r', ..])
}

fn is_tga(bytes: &[u8]) -> bool {
    let Some(&[_, map, kind, _, _, _, _, entry, _, _, _, _, w0, w1, h0, h1, depth, flags]) = bytes.first_chunk::<18>()
    else {
        return false;
    };
    let depths: &[u8] = match (map, kind) {
        (1, 1 | 9) => &[8],
        (0, 2 | 10) => &[15, 16, 24, 32],
        (0, 3 | 11) => &[8, 16],
        _ => return false,
    };
    let mapped = if map == 1 { matches!(entry, 15 | 16 | 24 | 32) } else { entry == 0 };
    mapped && depths.contains(&depth) && flags & 0xc0 == 0 && [w0, w1] != [0; 2] && [h0, h1] != [0; 2]
}

/// Returns the fault for a file whose format is not accepted. `expected` lists the accepted formats, and `target` is the
/// output argument of the conversion command.
pub(super) fn unrecognised(bytes: &[u8], expected: &'static str, target: &str) -> MapFault {
    let foreign = FOREIGN.iter().find(|(_, at, with)| begins(bytes, *at, with)).map(|(name, ..)| (*name).to_owned());
    match foreign.or_else(|| ImageFormat::of(bytes).map(|format| format.name().to_owned())) {
        Some(name) => MapFault::unsupported(
            format!("it is {name}, and {expected} is expected"),
            format!("convert it, for example with ImageMagick: magick FILE {target}"),
        ),
        None => MapFault::Unrecognised { expected },
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn formats_are_recognised_by_their_bytes() {
        let tga = [0, 0, 2, 0, 0, 0, 0, 0, 0, 0, 0, 0, 4, 0, 2, 0, 24, 0x20];
        let bmp = [&b"BM"[..], &[0; 12], &[40, 0, 0, 0]].concat();
        for (bytes, format) in [
            (&b"\x89PNG\r\n"[..], Some(ImageFormat::Png)),
            (b"\xff\xd8\xff\xe0", Some(ImageFormat::Jpeg)),
            (b"MM\0*", Some(ImageFormat::Tiff)),
            (b"RIFF\0\0\0\0WEBPVP8 ", Some(ImageFormat::WebP)),
            (b"\x76\x2f\x31\x01\x02\0\0\0WEBP", Some(ImageFormat::Exr)),
            (&bmp, Some(ImageFormat::Bmp)),
            (b"P5\n2 2 255\n", Some(ImageFormat::Pnm)),
            (&tga, Some(ImageFormat::Tga)),
            (b"DDS |", Some(ImageFormat::Dds)),
            (b"\xabKTX 20\xbb", Some(ImageFormat::Ktx2)),
            (b"\x76\x2f\x31\x01", Some(ImageFormat::Exr)),
            (b"#?RADIANCE\n", Some(ImageFormat::Hdr)),
            (b"8BPS", None),
            (b"{ \"asset\": 1, \"and more\": 2 }", None),
            (b"theta,phi,r,g,b\n0,0,0,0,0\n", None),
            (&[0; 64], None),
            (b"", None),
        ] {
            assert_eq!(ImageFormat::of(bytes), format, "{}", String::from_utf8_lossy(bytes));
        }
        let error = unrecognised(b"8BPS", "a PNG", "FILE.png").to_string();
        assert!(error.contains("it is a Photoshop document, and a PNG is expected; convert it"), "{error}");
    }
}
