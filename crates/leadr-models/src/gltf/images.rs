//! Images of a model from files, data URIs or buffers. Each is decoded once, on all cores.

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::json::{Item, Read};
use super::source::Source;
use super::uri;
use crate::fault::{ModelFault, shown};
use crate::limits::Budget;
use leadr_maps::decode_raster;
use leadr_maps::material::{Raster, Samples};

#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Origin<'a> {
    Uri(&'a str),
    View(usize),
}

struct Entry<'a> {
    item: Item<'a>,
    origin: Option<Origin<'a>>,
    name: String,
}

pub(super) struct Image {
    pub(super) name: String,
    /// Decoded image; `None` if it is unreadable.
    pub(super) raster: Option<Arc<Raster>>,
}

/// Checks all images and decodes those that textures use.
pub(super) fn read<'a>(source: &Source<'a>) -> Read<Vec<Image>> {
    let items = source.root.items("images", "image")?;
    let entries = items.into_iter().map(|item| Entry::read(item, source)).collect::<Read<Vec<_>>>()?;
    let mut wanted: HashMap<Origin<'a>, usize> = HashMap::new();
    for texture in source.root.items("textures", "texture")? {
        if let Some(image) = texture.index("source", "image", entries.len())?
            && let Some(origin) = entries[image].origin
        {
            wanted.entry(origin).or_insert(image);
        }
    }
    // Other threads need these fields, since `Source` as a whole is not `Sync`.
    let (views, folder, budget) = (&source.views, source.folder, &source.image_budget);
    let decode = |(origin, image): (Origin<'a>, usize)| {
        let entry = &entries[image];
        let raster = match origin {
            Origin::Uri(uri) => {
                uri::fetch(uri, folder, entry.item.location, u64::MAX).and_then(|bytes| entry.decode(&bytes, budget))
            }
            Origin::View(view) => views[view].bytes().and_then(|bytes| entry.decode(bytes, budget)),
        };
        (origin, raster.map(Arc::new))
    };
    // For a single image, waking other threads costs more than decoding it.
    let mut results: HashMap<Origin<'a>, Read<Arc<Raster>>> = if wanted.len() > 1 {
        wanted.into_par_iter().map(decode).collect()
    } else {
        wanted.into_iter().map(decode).collect()
    };
    let failed = |origin: &Origin<'_>| results.get(origin).is_some_and(Result::is_err);
    let first_failed = entries.iter().filter_map(|entry| entry.origin).find(failed);
    if let Some(origin) = first_failed.filter(|_| !source.lenient) {
        return Err(results.remove(&origin).and_then(Result::err).expect("the key was found above"));
    }
    let image = |entry: Entry<'_>| {
        let raster = match entry.origin.and_then(|origin| results.get(&origin)) {
            Some(Ok(raster)) => Some(raster.clone()),
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

    fn decode(&self, bytes: &[u8], budget: &Budget) -> Read<Raster> {
        // Different names may refer to the same large file.
        budget.take::<u8>(bytes.len())?;
        let raster = decode_raster(bytes).map_err(|fault| {
            let (location, name) = (self.item.location.to_string(), &self.name);
            let location = if *name == location { location } else { format!("{location} ({name})") };
            ModelFault::Image { location, fault }
        })?;
        match raster.samples() {
            Samples::U8(samples) => budget.take::<u8>(samples.len()),
            Samples::U16(samples) => budget.take::<u16>(samples.len()),
            Samples::F32(samples) => budget.take::<f32>(samples.len()),
        }?;
        Ok(raster)
    }
}
