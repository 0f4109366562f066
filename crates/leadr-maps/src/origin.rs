//! Provenance metadata of a picture: the program, the command, and a fingerprint of all inputs.
//!
//! A PNG stores the metadata in `iTXt` chunks before the pixels. An EXR stores the metadata in layer attributes. Other
//! programs display the registered PNG names `Software` and `Comment` and the standard EXR names `software` and `comments`.

use std::io::Cursor;
use std::path::Path;

use exr::meta::MetaData;
use exr::meta::attribute::AttributeValue;
use exr::prelude::{LayerAttributes, Text};
use png::text_metadata::{EncodableTextChunk, ITXtChunk};

const FINGERPRINT: &str = "leadr-fingerprint";
/// The metadata names in a PNG, in the order of the fields of [`Origin`].
const PNG_NAMES: [&str; 3] = ["Software", "Comment", FINGERPRINT];
/// The size in bytes of the signature and the `IHDR` chunk.
const PNG_HEADER: usize = 8 + 25;

/// The provenance of a picture.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Origin {
    /// The program and its version.
    pub software: String,
    /// The command that reproduces the picture.
    pub command: String,
    /// A fingerprint of the inputs. Two pictures have the same fingerprint only if all their inputs are equal.
    pub fingerprint: String,
}

impl Origin {
    /// Inserts this metadata into `png`, which is a complete file without animation.
    pub fn in_png(&self, mut png: Vec<u8>) -> Vec<u8> {
        let mut chunks = Vec::new();
        for (name, text) in PNG_NAMES.into_iter().zip([&self.software, &self.command, &self.fingerprint]) {
            ITXtChunk::new(name, text).encode(&mut chunks).expect("a short plain name, written to memory");
        }
        let at = PNG_HEADER.min(png.len());
        png.splice(at..at, chunks);
        png
    }

    /// Reads the metadata of a PNG. Returns `None` if the metadata is incomplete.
    pub fn of_png(bytes: &[u8]) -> Option<Self> {
        let reader = png::Decoder::new(Cursor::new(bytes)).read_info().ok()?;
        let texts = &reader.info().utf8_text;
        let find = |name| texts.iter().find(|text| text.keyword == name)?.get_text().ok();
        let [software, command, fingerprint] = PNG_NAMES.map(find);
        Some(Self { software: software?, command: command?, fingerprint: fingerprint? })
    }

    /// Returns the EXR attributes for the metadata. Only one attribute is non-standard, because the writer would store
    /// several in random order.
    pub(super) fn exr_attributes(&self) -> LayerAttributes {
        let other = [(Text::from(FINGERPRINT), AttributeValue::Text(latin(&self.fingerprint)))].into_iter().collect();
        LayerAttributes {
            software_name: Some(latin(&self.software)),
            comments: Some(latin(&self.command)),
            other,
            ..LayerAttributes::default()
        }
    }

    /// Reads the metadata of a single-layer EXR. Returns `None` if the metadata is incomplete.
    pub fn of_exr(path: &Path) -> Option<Self> {
        let meta = MetaData::read_from_file(path, false).ok()?;
        let [header] = meta.headers.as_slice() else { return None };
        let own = &header.own_attributes;
        let Some(AttributeValue::Text(fingerprint)) = own.other.get(&Text::from(FINGERPRINT)) else { return None };
        let (software, command) = (own.software_name.as_ref()?, own.comments.as_ref()?);
        let [software, command, fingerprint] = [software, command, fingerprint].map(ToString::to_string);
        Some(Self { software, command, fingerprint })
    }
}

/// Converts a text for EXR, which supports only Latin-1.
fn latin(text: &str) -> Text {
    let escaped: String =
        text.chars().map(|c| if u32::from(c) < 256 { c.to_string() } else { c.escape_unicode().to_string() }).collect();
    Text::new_or_none(&escaped).unwrap_or_else(|| Text::from(""))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Rgb8Image;
    use crate::save::{encode_exr, encode_exr_of, encode_png_srgb8};
    use crate::{decode_color_srgb8, decode_picture};

    fn origin() -> Origin {
        let [software, command] = ["leadr 1 (abc)", "leadr capture --material 'ä wall'"].map(str::to_owned);
        Origin { software, command, fingerprint: "0123456789abcdef".to_owned() }
    }

    #[test]
    fn png_stores_origin_without_changing_pixels() {
        let image = Rgb8Image { width: 2, height: 1, texels: vec![[1, 2, 3], [4, 5, 6]] };
        let plain = encode_png_srgb8(&image).unwrap();
        assert_eq!(Origin::of_png(&plain), None);
        let png = origin().in_png(plain.clone());
        assert_eq!(Origin::of_png(&png), Some(origin()));
        assert_eq!(decode_color_srgb8(&png).unwrap(), image);
        for end in 0..png.len() - plain.len() {
            assert_eq!(Origin::of_png(&png[..end]), None, "cut after {end} bytes");
        }
        let mut damaged = png.clone();
        damaged[PNG_HEADER + 20] ^= 1;
        assert_eq!(Origin::of_png(&damaged), None);
    }

    #[test]
    fn exr_stores_origin_without_changing_pixels() {
        let folder = tempfile::tempdir().unwrap();
        let [plain, recorded] = ["plain.exr", "told.exr"].map(|name| folder.path().join(name));
        let channels: [(&str, &[f32]); 3] = [("R", &[0.5, 2.0]), ("G", &[1.0, 0.0]), ("B", &[0.25, 8.0])];
        let bytes = encode_exr_of(&origin(), 2, 1, &channels).unwrap();
        assert_eq!(bytes, encode_exr_of(&origin(), 2, 1, &channels).unwrap(), "bytes differ between two runs");
        std::fs::write(&recorded, &bytes).unwrap();
        let bare = encode_exr(2, 1, &channels).unwrap();
        std::fs::write(&plain, &bare).unwrap();
        assert_eq!((Origin::of_exr(&plain), Origin::of_exr(&recorded)), (None, Some(origin())));
        assert_eq!(decode_picture(&bytes).unwrap(), decode_picture(&bare).unwrap());
    }
}
