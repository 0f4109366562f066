//! Loads a [`Model`] from a path or from bytes.

use std::path::Path;

use super::fault::{ModelError, ModelFault};
use super::gltf;
use super::model::Model;
use leadr_maps::MapFault;
use leadr_maps::folders::OutsideLinks;
use leadr_maps::limits::{MAX_FILE_BYTES, format_bytes, read_file};

/// Options for loading a model.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct LoadOptions {
    /// Whether violations of glTF are errors. Otherwise they are repaired, or the part is left out, with a message in
    /// [`Model::remarks`]. A colour image that cannot be read becomes a magenta checkerboard, and a data image becomes the
    /// material's factor. Directions and heights are omitted.
    pub strict: bool,
    /// The name of the variant of materials (`KHR_materials_variants`); `None` for the materials that primitives name.
    pub variant: Option<String>,
    /// Treatment of links in the model's folder that lead out of it.
    pub links: OutsideLinks,
}

impl Model {
    /// Loads a glTF 2.0 model, `.glb` or `.gltf`, recognised by the first bytes. Buffers and images may be embedded, or be
    /// files in the model's folder or its subfolders. [`LoadOptions::links`] allows links out of the folder.
    ///
    /// # Errors
    /// Fails if the model cannot be read, violates glTF beyond repair, or exceeds [`super::limits`]. Also fails if nothing of its
    /// meshes can be read. [`Model::remarks`] lists repairs. In strict mode, fails instead of repairing, and if the model requires
    /// an extension outside [`super::EXTENSIONS_READ`].
    pub fn load(path: impl AsRef<Path>, options: LoadOptions) -> Result<Self, ModelError> {
        let path = path.as_ref();
        let folder = path.parent().unwrap_or(Path::new(""));
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let bytes = read_file(path).map_err(of_file);
        bytes
            .and_then(|bytes| gltf::decode(&bytes, &name, Some(folder), &options))
            .map_err(|fault| ModelError { file: path.to_path_buf(), fault })
    }

    /// Like [`Model::load`], but decodes the bytes of a file called `name`. Other files are read from `folder`, if given.
    ///
    /// # Errors
    /// Returns the errors of [`Model::load`].
    pub fn decode(bytes: &[u8], name: &str, folder: Option<&Path>, options: LoadOptions) -> Result<Self, ModelFault> {
        gltf::decode(bytes, name, folder, &options)
    }
}

pub(super) fn of_file(fault: MapFault) -> ModelFault {
    match fault {
        MapFault::Io { doing, source } => ModelFault::Io { doing, source },
        MapFault::NotAFile => ModelFault::NotAFile,
        MapFault::Unsupported { what, remedy } => ModelFault::Unsupported { what, remedy },
        _ => ModelFault::too_large(format!("it has more than {}", format_bytes(MAX_FILE_BYTES))),
    }
}
