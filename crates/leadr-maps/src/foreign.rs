//! Detects unsupported image formats by their first bytes. The error message gives a command that converts the file.

use super::MapFault;

/// The names of the formats with their signatures. A signature is a byte string at an offset.
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

/// Returns the fault for a file whose format is not accepted. `expected` lists the accepted formats, and `target` is the
/// output argument of the conversion command.
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
