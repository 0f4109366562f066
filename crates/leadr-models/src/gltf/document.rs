//! A whole glTF file, for programs that change its textures and keep everything else.

use std::collections::HashSet;
use std::path::Path;
use std::sync::Arc;

use leadr_maps::material::Raster;

use super::images::{self, Image};
use super::json::{Item, Location, Read};
use super::log::Log;
use super::source::{self, Source};
use super::uri::{self, Folder};
use super::{extensions, glb, meshopt, value};
use crate::LoadOptions;
use crate::fault::{ModelError, ModelFault};
use crate::load::of_file;
use leadr_maps::limits::{MAX_FILE_BYTES, read_file};

/// A glTF file with its JSON, its buffers and its decoded images.
#[derive(Clone, Debug)]
pub struct Document {
    /// The JSON, with all extensions and extras.
    pub json: serde_json::Value,
    /// The bytes of each buffer, or `None` for a buffer without data, which an extension fills.
    pub buffers: Vec<Option<Vec<u8>>>,
    /// The images, in the order of the file.
    pub images: Vec<DocumentImage>,
    /// What is repaired or cannot be read, one line each.
    pub remarks: Vec<String>,
}

/// An image of a [`Document`].
#[derive(Clone, Debug)]
pub struct DocumentImage {
    /// The name for messages.
    pub name: String,
    /// The texels, or `None` if the image cannot be decoded.
    pub raster: Option<Arc<Raster>>,
    /// The bytes of an image with a `uri`, if they can be read. Other images are in buffer views.
    pub file: Option<Vec<u8>>,
}

impl Document {
    /// Reads a `.glb` or `.gltf` file with its buffers and images. Meshes, skins and animations are not checked.
    ///
    /// # Errors
    /// Fails if the file, its JSON or one of its buffers cannot be read, or if a limit of [`crate::limits`] is exceeded.
    pub fn open(path: impl AsRef<Path>, options: &LoadOptions) -> Result<Self, ModelError> {
        let path = path.as_ref();
        let folder = path.parent().unwrap_or(Path::new(""));
        let bytes = read_file(path).map_err(of_file);
        bytes
            .and_then(|bytes| Self::decode(&bytes, Some(folder), options))
            .map_err(|fault| ModelError { file: path.to_path_buf(), fault })
    }

    /// Like [`Document::open`], for the bytes of a file. Other files are read from `folder`, if given.
    ///
    /// # Errors
    /// Returns the errors of [`Document::open`].
    pub fn decode(bytes: &[u8], folder: Option<&Path>, options: &LoadOptions) -> Result<Self, ModelFault> {
        let folder = folder.map(|path| Folder { path, links: options.links });
        let log = Log::new(options.strict);
        let container = glb::open(bytes, &log)?;
        let values = value::parse(container.json)?;
        let json = serde_json::from_slice(container.json)
            .map_err(|fault| ModelFault::damaged(format!("its JSON cannot be read ({fault})")))?;
        let root = Item::root(&values, &log);
        extensions::check_version(&root, &log)?;
        let buffers = source::buffers(&root, container.binary, folder, &log)?;
        let budget = source::budget(&buffers);
        let unpacked = meshopt::views(&root, &buffers, &budget, &log)?;
        let source = Source::open(root, &log, &buffers, &unpacked, budget, folder, None)?;
        let used: HashSet<usize> = (0..root.length("images")?).collect();
        let decoded = images::read(&source, &used)?;
        let uris = root.items("images", "image")?.into_iter().map(|item| item.string("uri"));
        let uris = uris.collect::<Read<Vec<_>>>()?;
        let images = decoded.into_iter().zip(uris).map(|(image, uri)| whole(image, uri, &source)).collect();
        let bytes = |(buffer, item): (&super::accessor::Buffer<'_>, &Item<'_>)| match &buffer.bytes {
            Ok(bytes) => Ok(Some(bytes.to_vec())),
            Err(_) if !item.has("uri") => Ok(None),
            Err(broken) => Err(broken.fault()),
        };
        let items = root.items("buffers", "buffer")?;
        let buffers = buffers.iter().zip(&items).map(bytes).collect::<Read<Vec<_>>>()?;
        drop(source);
        Ok(Self { json, buffers, images, remarks: log.into_remarks() })
    }
}

fn whole(image: Image, uri: Option<&str>, source: &Source<'_>) -> DocumentImage {
    // Decoding has reported what is wrong with the file.
    let fetch = |uri| uri::fetch(uri, source.folder, Location::ROOT, MAX_FILE_BYTES, &Log::default()).ok();
    DocumentImage { name: image.name, raster: image.raster, file: uri.and_then(fetch) }
}
