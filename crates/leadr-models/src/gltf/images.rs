//! Images of a model from files, data URIs or buffers. Each image is decoded once, and images are decoded in parallel.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use rayon::prelude::*;

use super::json::{Item, Location, Read};
use super::log::Log;
use super::source::Source;
use super::uri::{self, Contents};
use crate::fault::{Broken, ModelFault, shown};
use leadr_maps::material::Raster;
use leadr_maps::{ImageHeader, MapFault, decode_raster_with_remarks};

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Origin<'a> {
    Uri(&'a str),
    View(usize),
}

/// A decoded image, and remarks about it.
type Decoded = (Arc<Raster>, Vec<String>);

struct Entry<'a> {
    location: Location,
    origin: Option<Origin<'a>>,
    name: String,
}

pub(super) struct Image {
    pub(super) name: String,
    /// The texels, if the image is used and can be decoded.
    pub(super) raster: Option<Arc<Raster>>,
    /// Whether the image has data, whose faults have been reported.
    pub(super) found: bool,
}

/// Reads the list of images and decodes those in `used`.
pub(super) fn read<'a>(source: &Source<'a>, used: &HashSet<usize>) -> Read<Vec<Image>> {
    let items = source.root.items("images", "image")?;
    let entries = items.into_iter().map(|item| Entry::read(item, source)).collect::<Read<Vec<_>>>()?;
    let used = entries.iter().enumerate().filter(|(number, _)| used.contains(number));
    let mut wanted: HashSet<Origin<'_>> = used.filter_map(|(_, entry)| entry.origin).collect();
    // All memory is reserved before any image is decoded, so it does not depend on the number of threads.
    let mut reserved = Vec::new();
    for entry in &entries {
        if let Some(origin) = entry.origin.filter(|origin| wanted.remove(origin)) {
            entry.reserve(source)?;
            reserved.push((origin, entry));
        }
    }
    let decode = |(origin, entry): (Origin<'a>, &Entry<'a>)| {
        let raster = match origin {
            Origin::Uri(uri) => uri::fetch(uri, source.folder, entry.location, u64::MAX, source.log)
                .and_then(|bytes| entry.decode(&bytes)),
            Origin::View(view) => view_bytes(source, view).and_then(|bytes| entry.decode(bytes)),
        };
        (origin, raster.map(|(raster, remarks)| (Arc::new(raster), remarks)))
    };
    // For a single image, waking other threads costs more than decoding it.
    let results: Vec<(Origin<'_>, Read<Decoded>)> = if reserved.len() > 1 {
        reserved.into_par_iter().map(decode).collect()
    } else {
        reserved.into_iter().map(decode).collect()
    };
    let mut rasters = HashMap::new();
    for (origin, raster) in results {
        match raster {
            Ok(raster) => drop(rasters.insert(origin, raster)),
            Err(fault) => source.log.repair(fault, "a replacement is used")?,
        }
    }
    for entry in &entries {
        // Several images can have one origin, whose remarks are given once.
        if let Some((_, remarks)) = entry.origin.and_then(|origin| rasters.get_mut(&origin)) {
            remarks.drain(..).for_each(|text| source.log.remark(format!("{}: {text}", entry.label())));
        }
    }
    let image = |entry: &Entry<'_>| {
        let raster = entry.origin.and_then(|origin| rasters.get(&origin)).map(|(raster, _)| raster.clone());
        Image { name: entry.name.clone(), raster, found: entry.origin.is_some() }
    };
    Ok(entries.iter().map(image).collect())
}

fn view_bytes<'a>(source: &Source<'a>, view: usize) -> Read<&'a [u8]> {
    source.views[view].as_ref().map_err(Broken::fault)?.bytes()
}

impl<'a> Entry<'a> {
    fn read(item: Item<'a>, source: &Source<'_>) -> Read<Self> {
        let uri = item.string("uri")?;
        let view = item.index("bufferView", "buffer view", source.views.len())?;
        if uri.is_some() && view.is_some() {
            source.log.repair(item.fault("has both a `uri` and a `bufferView`"), "the `bufferView` is used")?;
        }
        let origin = view.map(Origin::View).or(uri.map(Origin::Uri));
        let file = uri.filter(|uri| !uri.starts_with("data:")).map(shown);
        let name = Some(item.name()?).filter(|name| !name.is_empty()).map(|name| shown(&name));
        let name = name.or(file).unwrap_or_else(|| item.location.to_string());
        Ok(Self { location: item.location, origin, name })
    }

    /// Reserves the memory of the encoded and the decoded image. Decoding reports damaged headers.
    fn reserve(&self, source: &Source<'_>) -> Read<()> {
        let Some((header, length)) = self.header(source) else { return Ok(()) };
        source.image_budget.take(length + header.decoded_bytes()).map_err(|fault| self.fault(fault))
    }

    /// Returns the header and the encoded length, if they are readable.
    fn header(&self, source: &Source<'_>) -> Option<(ImageHeader, u64)> {
        let in_memory = |bytes: &[u8]| Some((ImageHeader::read(bytes, bytes.len() as u64).ok()?, bytes.len() as u64));
        match self.origin? {
            Origin::View(view) => in_memory(source.views[view].as_ref().ok()?.bytes().ok()?),
            // Decoding reports what is wrong with the name.
            Origin::Uri(uri) => match uri::find(uri, source.folder, self.location, &Log::default()).ok()? {
                Contents::Data(bytes) => in_memory(&bytes),
                Contents::File(file) => ImageHeader::of_file(&file).ok(),
            },
        }
    }

    fn decode(&self, bytes: &[u8]) -> Read<(Raster, Vec<String>)> {
        let decoded = decode_raster_with_remarks(bytes).map_err(|fault| match fault {
            MapFault::Unsupported { what, .. } if bytes.starts_with(b"\xabKTX 20") => {
                MapFault::unsupported(what, "decompress it, for example: gltf-transform ktxdecompress IN.glb OUT.glb")
            }
            other => other,
        });
        decoded.map_err(|fault| self.fault(fault))
    }

    fn fault(&self, fault: MapFault) -> ModelFault {
        ModelFault::Image { location: self.label(), fault }
    }

    /// Returns the position of the image in the file, with its name.
    fn label(&self) -> String {
        let (location, name) = (self.location.to_string(), &self.name);
        if *name == location { location } else { format!("{location} ({name})") }
    }
}
