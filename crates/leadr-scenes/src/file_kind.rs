//! Kinds of input files by their first bytes, so that a file given with the wrong flag is named together with the right one.

use std::fs::File;
use std::io::Read;
use std::path::Path;

use leadr_maps::baked::is_baked;
use leadr_maps::udim::Tiles;
use leadr_maps::{ImageFormat, MapError, MapFault};

/// Number of bytes that determine the kind of a file. The tables of a fit can come before its format.
const HEAD: u64 = 4 << 20;

/// The kind of an input file.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FileKind {
    /// A folder, such as a downloaded material.
    Folder,
    /// A picture such as PNG, JPEG, TIFF or KTX2.
    Picture,
    /// An OpenEXR picture or baked map.
    Exr,
    /// A Radiance HDR.
    Hdr,
    /// A baked map in a KTX2 file.
    Baked,
    /// A glTF model, binary or JSON.
    Model,
    /// A fit of `leadr fit`.
    Fit,
    /// A camera as JSON.
    Camera,
    /// The JSON result of a `leadr` command.
    Result,
}

/// Kinds of images with colours or numbers.
pub const IMAGE: &[FileKind] = &[FileKind::Picture, FileKind::Exr];

impl FileKind {
    /// Returns the kind of a file; `None` for unreadable files and for other formats.
    pub fn of(path: &Path) -> Option<Self> {
        if path.is_dir() {
            return Some(Self::Folder);
        }
        let mut head = Vec::new();
        // A pipe would lose these bytes.
        let file = path.is_file().then(|| File::open(path).ok()).flatten()?;
        file.take(HEAD).read_to_end(&mut head).ok()?;
        if head.starts_with(b"glTF") {
            return Some(Self::Model);
        }
        if let Some(format) = ImageFormat::of(&head) {
            return Some(match format {
                ImageFormat::Exr => Self::Exr,
                ImageFormat::Hdr => Self::Hdr,
                ImageFormat::Ktx2 if is_baked(path).unwrap_or(false) => Self::Baked,
                _ => Self::Picture,
            });
        }
        let text = String::from_utf8_lossy(&head);
        if !text.trim_start_matches('\u{feff}').trim_start().starts_with('{') {
            return None;
        }
        let text: String = text.chars().filter(|c| !c.is_whitespace()).collect();
        let has = |key: &str| text.contains(key);
        let is_model = path.extension().is_some_and(|ending| ending.eq_ignore_ascii_case("gltf"));
        [
            (has("\"format\":\"leadrfit\""), Self::Fit),
            (has("\"asset\":{") || is_model, Self::Model),
            (has("\"schema\":") && has("\"command\":"), Self::Result),
            (has("\"position\":[") && has("\"target\":["), Self::Camera),
        ]
        .into_iter()
        .find_map(|(matches, kind)| matches.then_some(kind))
    }

    /// Returns the kind with its article.
    fn name(self) -> &'static str {
        match self {
            Self::Folder => "a folder",
            Self::Picture => "a picture such as PNG or JPEG",
            Self::Exr => "an EXR picture",
            Self::Hdr => "a Radiance HDR picture",
            Self::Baked => "a KTX2 map of leadr bake",
            Self::Model => "a glTF model",
            Self::Fit => "a fit of leadr fit",
            Self::Camera => "a camera (JSON)",
            Self::Result => "the JSON result of a leadr command",
        }
    }

    /// Returns the flags that take such a file.
    fn flags(self) -> &'static str {
        match self {
            Self::Folder => "--material takes a folder of pictures",
            Self::Picture => "--height-map, --color-map, --normal-map and --roughness-map take a picture",
            Self::Exr => {
                "--height-map, --color-map and --normal-map take an EXR, and --environment takes one with light"
            }
            Self::Hdr => "--environment takes it",
            Self::Baked => "--height-map takes it",
            Self::Model => "--scene takes a model",
            Self::Fit => "--material takes a fit, and --measured MATERIAL=FIT.json applies it to a model",
            Self::Camera => "--camera takes it",
            Self::Result => "leadr bench --against and --measured take results of leadr bench",
        }
    }

    /// Checks that a file given with `flag` is of an accepted kind, or of a kind that only its reader knows.
    ///
    /// # Errors
    /// If the file is of another kind. The fault names the kind and the flags that take it.
    pub fn check(flag: &str, path: &Path, accepted: &[Self]) -> Result<(), MapError> {
        let tiles = Tiles::find(path)?;
        let first = tiles.as_ref().map_or(path, Tiles::first);
        let Some(kind) = Self::of(first).filter(|kind| !accepted.contains(kind)) else { return Ok(()) };
        let takes = accepted.iter().map(|kind| kind.name()).collect::<Vec<_>>().join(" or ");
        let what = if takes.is_empty() {
            format!("it is {}, which {flag} does not take", kind.name())
        } else {
            format!("it is {}, and {flag} takes {takes}", kind.name())
        };
        Err(MapFault::unsupported(what, kind.flags()).in_file(path))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn files_are_recognised_by_their_bytes() {
        let folder = tempfile::tempdir().unwrap();
        let kind = |name: &str, bytes: &[u8]| {
            let file = folder.path().join(name);
            std::fs::write(&file, bytes).unwrap();
            FileKind::of(&file)
        };
        assert_eq!(kind("a.json", b"\x89PNG\r\n"), Some(FileKind::Picture), "the name does not matter");
        assert_eq!(kind("a.bin", b"\xff\xd8\xff\xe0"), Some(FileKind::Picture));
        assert_eq!(kind("t", b"II*\0"), Some(FileKind::Picture));
        assert_eq!(kind("a", b"\x76\x2f\x31\x01\x02"), Some(FileKind::Exr));
        assert_eq!(kind("b", b"#?RADIANCE\n"), Some(FileKind::Hdr));
        assert_eq!(kind("b", b"#?AUTOPANO\n"), Some(FileKind::Hdr));
        assert_eq!(kind("c", b"\xabKTX 20\xbb"), Some(FileKind::Picture));
        assert_eq!(kind("c", b"\xabKTX 20\xbb...leadr.kind\0leadr"), Some(FileKind::Baked));
        assert_eq!(kind("d", b"glTF\x02"), Some(FileKind::Model));
        assert_eq!(kind("e", b"{ \"asset\" : { \"version\": \"2.0\" } }"), Some(FileKind::Model));
        assert_eq!(kind("f", b"{\"position\": [1, 2, 3], \"target\": [0, 0, 0]}"), Some(FileKind::Camera));
        assert_eq!(kind("g", b"{\"schema\": 1, \"command\": \"bench\"}"), Some(FileKind::Result));
        assert_eq!((kind("h", b"theta,r,g,b"), kind("i", b""), kind("j", b"{")), (None, None, None));
        assert_eq!(FileKind::of(folder.path()), Some(FileKind::Folder));
        assert_eq!(FileKind::of(&folder.path().join("none")), None);
    }
}
