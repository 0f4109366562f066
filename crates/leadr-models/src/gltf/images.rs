//! Images of a model from files, data URIs or buffers. Each image is decoded once, and images are decoded in parallel.

use std::collections::{HashMap, HashSet};
use std::sync::Arc;

use rayon::prelude::*;

use super::json::{Item, Read};
use super::source::Source;
use super::uri::{self, Contents};
use crate::fault::{ModelFault, shown};
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
    item: Item<'a>,
    origin: Option<Origin<'a>>,
    name: String,
}

pub(super) struct Image {
    pub(super) name: String,
    pub(super) raster: Option<Arc<Raster>>,
}

/// Checks all images and decodes those that textures use.
pub(super) fn read<'a>(source: &Source<'a>) -> Read<Vec<Image>> {
    let items = source.root.items("images", "image")?;
    let entries = items.into_iter().map(|item| Entry::read(item, source)).collect::<Read<Vec<_>>>()?;
    let mut wanted = HashSet::new();
    for texture in source.root.items("textures", "texture")? {
        wanted.extend(texture.index("source", "image", entries.len())?.and_then(|image| entries[image].origin));
    }
    // All memory is reserved before any image is decoded, so it does not depend on the number of threads.
    let mut reserved = Vec::new();
    for entry in &entries {
        if let Some(origin) = entry.origin.filter(|origin| wanted.remove(origin)) {
            let room = entry.reserve(source);
            reserved.push((origin, entry, if source.lenient { room } else { Ok(room?) }));
        }
    }
    // Other threads need these fields, since `Source` as a whole is not `Sync`.
    let (views, folder) = (&source.views, source.folder);
    let decode = |(origin, entry, room): (Origin<'a>, &Entry<'a>, Read<()>)| {
        let raster = room.and_then(|()| match origin {
            Origin::Uri(uri) => {
                uri::fetch(uri, folder, entry.item.location, u64::MAX).and_then(|bytes| entry.decode(&bytes))
            }
            Origin::View(view) => views[view].bytes().and_then(|bytes| entry.decode(bytes)),
        });
        (origin, raster.map(|(raster, remarks)| (Arc::new(raster), remarks)))
    };
    // For a single image, waking other threads costs more than decoding it.
    let mut results: HashMap<Origin<'a>, Read<Decoded>> = if reserved.len() > 1 {
        reserved.into_par_iter().map(decode).collect()
    } else {
        reserved.into_iter().map(decode).collect()
    };
    let failed = |origin: &Origin<'_>| results.get(origin).is_some_and(Result::is_err);
    let first_failed = entries.iter().filter_map(|entry| entry.origin).find(failed);
    if let Some(origin) = first_failed.filter(|_| !source.lenient) {
        return Err(results.remove(&origin).and_then(Result::err).expect("the key was found above"));
    }
    for entry in &entries {
        // Several images can have one origin, whose remarks are given once.
        if let Some(Ok((_, remarks))) = entry.origin.and_then(|origin| results.get_mut(&origin)) {
            remarks.drain(..).for_each(|text| source.remark(format!("{}: {text}", entry.label())));
        }
    }
    let image = |entry: Entry<'_>| {
        let raster = match entry.origin.and_then(|origin| results.get(&origin)) {
            Some(Ok((raster, _))) => Some(raster.clone()),
            Some(Err(fault)) => {
                source.remark(format!("{fault}; a replacement is used"));
                None
            }
            None => None,
        };
        Image { name: entry.name, raster }
    };
    Ok(entries.into_iter().map(image).collect())
}

impl<'a> Entry<'a> {
    fn read(item: Item<'a>, source: &Source<'_>) -> Read<Self> {
        let uri = item.string("uri")?;
        let view = item.index("bufferView", "buffer view", source.views.len())?;
        let origin = match (uri, view) {
            (Some(_), Some(_)) => return Err(item.fault("has both a `uri` and a `bufferView`")),
            (Some(uri), None) => Some(Origin::Uri(uri)),
            (None, Some(view)) => Some(Origin::View(view)),
            (None, None) => None,
        };
        let file = uri.filter(|uri| !uri.starts_with("data:")).map(shown);
        let name = Some(item.name()?).filter(|name| !name.is_empty()).map(|name| shown(&name));
        let name = name.or(file).unwrap_or_else(|| item.location.to_string());
        Ok(Self { item, origin, name })
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
            Origin::View(view) => in_memory(source.views[view].bytes().ok()?),
            Origin::Uri(uri) => match uri::find(uri, source.folder, self.item.location).ok()? {
                Contents::Data(bytes) => in_memory(&bytes),
                Contents::File(file) => ImageHeader::of_file(&file).ok(),
            },
        }
    }

    fn decode(&self, bytes: &[u8]) -> Read<(Raster, Vec<String>)> {
        decode_raster_with_remarks(bytes).map_err(|fault| self.fault(fault))
    }

    fn fault(&self, fault: MapFault) -> ModelFault {
        ModelFault::Image { location: self.label(), fault }
    }

    /// Returns the position of the image in the file, with its name.
    fn label(&self) -> String {
        let (location, name) = (self.item.location.to_string(), &self.name);
        if *name == location { location } else { format!("{location} ({name})") }
    }
}
