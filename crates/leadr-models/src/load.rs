//! Loading: from a path or from bytes to a [`Model`].

use std::path::Path;

use super::fault::{ModelError, ModelFault};
use super::gltf;
use super::model::Model;
use leadr_maps::MapFault;
use leadr_maps::limits::{MAX_FILE_BYTES, in_words, read_file};

/// How to load a model.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct LoadOptions {
    /// Replace images that are missing or damaged (colours by a magenta check, numbers by their factor, directions and heights by
    /// none) and say so in [`Model::remarks`], instead of refusing the model.
    pub lenient: bool,
}

impl Model {
    /// Loads a glTF 2.0 model, `.glb` or `.gltf`; the first bytes decide which. Buffers and images may lie in the model itself or
    /// as files in its folder and below, never elsewhere.
    ///
    /// # Errors
    /// If the model or a file of its cannot be read, breaks a rule of glTF beyond repair, requires an extension that is not among
    /// [`super::EXTENSIONS_READ`], or goes over [`super::limits`]. Repairs stand in [`Model::remarks`].
    pub fn load(path: impl AsRef<Path>, options: LoadOptions) -> Result<Self, ModelError> {
        let path = path.as_ref();
        let folder = path.parent().unwrap_or(Path::new(""));
        let name = path.file_stem().unwrap_or_default().to_string_lossy();
        let bytes = read_file(path).map_err(of_file);
        bytes
            .and_then(|bytes| gltf::decode(&bytes, &name, Some(folder), options.lenient))
            .map_err(|fault| ModelError { file: path.to_path_buf(), fault })
    }

    /// Like [`Model::load`], from the bytes of a file called `name`. Other files are looked for in `folder`, if one is given.
    ///
    /// # Errors
    /// As [`Model::load`].
    pub fn decode(bytes: &[u8], name: &str, folder: Option<&Path>, options: LoadOptions) -> Result<Self, ModelFault> {
        gltf::decode(bytes, name, folder, options.lenient)
    }
}

/// The same fault, told of a model instead of an image.
fn of_file(fault: MapFault) -> ModelFault {
    match fault {
        MapFault::Io { doing, source } => ModelFault::Io { doing, source },
        MapFault::NotAFile => ModelFault::NotAFile,
        _ => ModelFault::too_large(format!("it has more than {}", in_words(MAX_FILE_BYTES))),
    }
}
