//! Images of a model: files, data URIs or parts of buffers, decoded on all cores, each once.

use std::collections::HashMap;
use std::sync::Arc;

use rayon::prelude::*;

use super::json::{Item, Read};
use super::source::Source;
use super::uri;
use crate::fault::{ModelFault, shown};
use crate::limits::ImageBudget;
use leadr_maps::decode_raster;
use leadr_maps::material::{Raster, Samples};

/// Where an image's bytes are.
#[derive(Clone, Copy, PartialEq, Eq, Hash)]
enum Origin<'a> {
    Uri(&'a str),
    View(usize),
}

/// An image as the file describes it.
struct Entry<'a> {
    item: Item<'a>,
    origin: Option<Origin<'a>>,
    name: String,
}

/// The images that textures show.
pub(super) struct Images {
    rasters: Vec<Option<Arc<Raster>>>,
    names: Vec<String>,
}

impl Images {
    /// Checks all images and decodes those that textures show.
    pub(super) fn read<'a>(source: &Source<'a>) -> Read<Self> {
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
        // What other threads need of the source, which they cannot share as a whole.
        let (views, folder, budget) = (&source.views, source.folder, &source.image_budget);
        let decode = |(origin, image): (Origin<'a>, usize)| {
            let entry = &entries[image];
            let raster = match origin {
                Origin::Uri(uri) => {
                    uri::fetch(uri, folder, entry.item.place, u64::MAX).and_then(|bytes| entry.decode(&bytes, budget))
                }
                Origin::View(view) => views[view].bytes().and_then(|bytes| entry.decode(bytes, budget)),
            };
            (origin, raster.map(Arc::new))
        };
        // Waking other threads takes longer than many a model.
        let mut results: HashMap<Origin<'a>, Read<Arc<Raster>>> = if wanted.len() > 1 {
            wanted.into_par_iter().map(decode).collect()
        } else {
            wanted.into_iter().map(decode).collect()
        };
        let mut images = Self { rasters: Vec::new(), names: entries.iter().map(|e| e.name.clone()).collect() };
        for entry in &entries {
            let Some(origin) = entry.origin else {
                images.rasters.push(None);
                continue;
            };
            if !source.lenient && matches!(results.get(&origin), Some(Err(_))) {
                return Err(results.remove(&origin).and_then(Result::err).expect("just seen"));
            }
            if let Some(Err(fault)) = results.get(&origin) {
                source.remark(format!("{fault}; a replacement is shown"));
            }
            images.rasters.push(results.get(&origin).and_then(|result| result.as_ref().ok()).cloned());
        }
        Ok(images)
    }

    /// How many there are.
    pub(super) fn len(&self) -> usize {
        self.rasters.len()
    }

    /// The texels of an image, or nothing if they could not be had.
    pub(super) fn raster(&self, image: usize) -> Option<Arc<Raster>> {
        self.rasters[image].clone()
    }

    /// What an image is called.
    pub(super) fn name(&self, image: usize) -> &str {
        &self.names[image]
    }
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
        let name = name.or(file).unwrap_or_else(|| item.place.to_string());
        Ok(Self { item, origin, name })
    }

    fn decode(&self, bytes: &[u8], budget: &ImageBudget) -> Read<Raster> {
        // Names that differ may lead to the same large file.
        budget.take(bytes.len())?;
        let raster = decode_raster(bytes).map_err(|fault| {
            let (place, name) = (self.item.place.to_string(), &self.name);
            let place = if *name == place { place } else { format!("{place} ({name})") };
            ModelFault::Image { place, fault }
        })?;
        budget.take(match raster.samples() {
            Samples::U8(samples) => samples.len(),
            Samples::U16(samples) => 2 * samples.len(),
            Samples::F32(samples) => 4 * samples.len(),
        })?;
        Ok(raster)
    }
}
