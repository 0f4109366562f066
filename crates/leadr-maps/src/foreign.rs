//! Common image formats that are not read here, by their first bytes, so that whoever has one is told what to do with it.

use super::MapFault;

/// Formats and how their files begin: bytes at a place.
const FORMATS: &[(&str, usize, &[u8])] = &[
    ("a TIFF", 0, b"II*\0"),
    ("a TIFF", 0, b"MM\0*"),
    ("a TIFF", 0, b"II+\0"),
    ("a TIFF", 0, b"MM\0+"),
    ("a WebP", 8, b"WEBP"),
    ("a Photoshop document", 0, b"8BPS"),
    ("a DDS", 0, b"DDS "),
    ("a JPEG XL", 0, b"\xff\x0a"),
    ("a JPEG XL", 4, b"JXL "),
    ("an AVIF", 4, b"ftypavif"),
];

/// The fault of bytes that begin as none of the accepted formats do. `expected` names those; `target` is the name of a file, as a
/// converter takes it, that a picture could be turned into.
pub(super) fn unrecognised(bytes: &[u8], expected: &'static str, target: &str) -> MapFault {
    let begins = |at: usize, with: &[u8]| bytes.get(at..at + with.len()) == Some(with);
    match FORMATS.iter().find(|(_, at, with)| begins(*at, with)) {
        Some((name, ..)) => MapFault::unsupported(
            format!("it is {name}, and {expected} is expected"),
            format!("convert it, for example with ImageMagick: magick FILE {target}"),
        ),
        None => MapFault::Unrecognised { expected },
    }
}
