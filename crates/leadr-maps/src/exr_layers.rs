//! The layers of an EXR file, and the choice of the layer that a viewer shows.
//!
//! A channel `ViewLayer.Combined.R` is the channel `R` of the layer `ViewLayer.Combined`. A channel without a prefix belongs to
//! the unnamed layer, or to the layer that its part of a multi-part file names. Layers with deep data are left aside.

use std::collections::HashMap;

use exr::meta::MetaData;

use super::MapFault;
use super::shown::shown;

/// Layer names of finished pictures, the most usual first.
const FINISHED: [&str; 9] = ["combined", "beauty", "rgba", "rgb", "color", "colour", "c", "ci", "image"];
/// Names of the channel that stores heights, the most specific first.
const HEIGHTS: [&str; 6] = ["height", "displacement", "disp", "y", "z", "r"];
const REEXPORT: &str = "rename or re-export its channels";

/// A layer of a file.
struct Layer {
    part: usize,
    /// The name, or an empty text for the unnamed layer.
    name: String,
    /// The view of a stereo picture, such as `left`.
    view: Option<String>,
    /// The index of each channel in its part, and the channel name in lower case without the layer.
    channels: Vec<(usize, String)>,
}

/// The selected channels of a layer.
#[derive(Debug)]
pub(crate) struct Selected {
    pub part: usize,
    /// The name of the layer, or an empty text for the unnamed layer.
    pub layer: String,
    /// The view of a stereo picture, such as `left`.
    pub view: Option<String>,
    /// One or three channel indices: grey, or red, green and blue.
    pub colors: Vec<usize>,
    pub alpha: Option<usize>,
    /// A remark, if the file has several layers that could be meant.
    pub remark: Option<String>,
}

/// The purpose for which channels are selected.
#[derive(Clone, Copy)]
pub(crate) enum Wanted<'a> {
    /// Colours to look at, of the layer with this name if given.
    Colors(Option<&'a str>),
    /// Colours or numbers. A file with a single channel may name the channel in any way.
    Numbers,
    /// Heights.
    Heights,
}

impl Layer {
    fn channel(&self, names: &[&str]) -> Option<usize> {
        let named = |name: &&str| self.channels.iter().find(|(_, own)| own == *name);
        names.iter().find_map(named).map(|(index, _)| *index)
    }

    /// Returns the channels of red, green and blue, or of grey. The layer of a position has a `Y` too, which is no grey.
    fn colors(&self) -> Option<Vec<usize>> {
        let colors: Vec<usize> =
            [["r", "red"], ["g", "green"], ["b", "blue"]].iter().filter_map(|names| self.channel(names)).collect();
        let grey = || self.channel(&["y"]).filter(|_| self.channel(&["x"]).is_none());
        if colors.len() == 3 { Some(colors) } else { grey().map(|grey| vec![grey]) }
    }

    fn stores_chroma(&self) -> bool {
        ["y", "ry", "by"].iter().all(|name| self.channel(&[name]).is_some())
    }

    /// Returns the position in the order of choice. Layers of equal rank are chosen in the order of the file.
    fn rank(&self) -> (bool, usize, bool) {
        let mut words = self.name.split('.').filter(|word| !word.is_empty() && Some(*word) != self.view.as_deref());
        let last = words.next_back().map(str::to_ascii_lowercase);
        let known = last.map_or(0, |word| 1 + FINISHED.iter().position(|name| *name == word).unwrap_or(FINISHED.len()));
        (self.colors().is_none_or(|colors| colors.len() < 3), known, !self.name.is_empty())
    }

    fn is_finished(&self) -> bool {
        self.rank().1 <= FINISHED.len()
    }

    fn title(&self) -> String {
        if self.name.is_empty() { "the unnamed layer".to_owned() } else { format!("`{}`", shown(&self.name)) }
    }

    fn selected(&self, colors: Vec<usize>) -> Selected {
        let alpha = self.channel(&["a", "alpha"]).filter(|alpha| !colors.contains(alpha));
        Selected { part: self.part, layer: self.name.clone(), view: self.view.clone(), colors, alpha, remark: None }
    }
}

/// Selects the channels of a file.
///
/// Colours come from the layer of the given name. Without a name, they come from the unnamed layer, else from a layer that is
/// called as finished pictures are, else from the only layer with colour.
pub(crate) fn select(meta: &MetaData, wanted: Wanted<'_>) -> Result<Selected, MapFault> {
    let layers = layers(meta);
    let count: usize = layers.iter().map(|layer| layer.channels.len()).sum();
    match wanted {
        Wanted::Colors(Some(name)) => named(&layers, name),
        Wanted::Heights if count == 1 => Ok(layers[0].selected(vec![0])),
        Wanted::Numbers if count == 1 => Ok(layers[0].selected(vec![0])),
        Wanted::Heights => {
            heights(&layers)?.ok_or_else(|| no_channel(meta, "named height, displacement, disp, Y, Z or R"))
        }
        _ => colors(&layers)?.ok_or_else(|| no_channel(meta, "R, G, B or Y")),
    }
}

fn layers(meta: &MetaData) -> Vec<Layer> {
    let mut layers: Vec<Layer> = Vec::new();
    for (part, header) in meta.headers.iter().enumerate().filter(|(_, header)| !header.deep) {
        let own = &header.own_attributes;
        let part_name = own.layer_name.as_ref().filter(|_| meta.headers.len() > 1).map(ToString::to_string);
        // In a single part, the first view has no prefix, and the names of the other views are prefixes.
        let views: Vec<String> = own.multi_view_names.iter().flatten().map(ToString::to_string).collect();
        let mut known = HashMap::new();
        for (index, channel) in header.channels.list.iter().enumerate() {
            let full = channel.name.to_string();
            let (prefix, last) = full.rsplit_once('.').unwrap_or(("", &full));
            let name = if prefix.is_empty() { part_name.clone().unwrap_or_default() } else { prefix.to_owned() };
            let at = *known.entry(name).or_insert_with_key(|name| {
                let prefixed = views.iter().find(|view| name.split('.').any(|word| word == *view));
                let view = own.view_name.as_ref().map(ToString::to_string);
                let view = view.or_else(|| prefixed.or(views.first()).cloned());
                layers.push(Layer { part, name: name.clone(), view, channels: Vec::new() });
                layers.len() - 1
            });
            layers[at].channels.push((index, last.to_ascii_lowercase()));
        }
    }
    let mut counts: HashMap<String, usize> = HashMap::new();
    layers.iter().for_each(|layer| *counts.entry(layer.name.clone()).or_default() += 1);
    for layer in layers.iter_mut().filter(|layer| counts[&layer.name] > 1) {
        let part = meta.headers[layer.part].own_attributes.layer_name.as_ref().map(ToString::to_string);
        if let Some(part) = part.filter(|part| *part != layer.name) {
            layer.name = format!("{part}.{}", layer.name);
        }
    }
    layers
}

/// Selects the layer of this name. Case and the first words of a layer name may be left out if they are not needed.
fn named(layers: &[Layer], name: &str) -> Result<Selected, MapFault> {
    let wanted = name.to_ascii_lowercase();
    let suffix = format!(".{wanted}");
    let exact = layers.iter().find(|layer| layer.name == name);
    let found = exact.map(|layer| vec![layer]).unwrap_or_else(|| {
        let matches = |layer: &&Layer| {
            let own = layer.name.to_ascii_lowercase();
            own == wanted || own.ends_with(&suffix)
        };
        layers.iter().filter(matches).collect()
    });
    let [layer] = found[..] else {
        let what = if found.is_empty() { "it has no layer" } else { "it has several layers" };
        let what = format!("{what} `{}`; its layers are {}", shown(name), titles(layers.iter()));
        return Err(MapFault::unsupported(what, "give the name of one of its layers"));
    };
    refuse_chroma(layer)?;
    // A layer that is asked for by its name may store a depth or normals.
    let indices = || layer.channels.iter().filter(|(_, own)| own != "a").map(|(index, _)| *index).collect();
    let colors: Vec<usize> = layer.colors().unwrap_or_else(indices);
    if !matches!(colors.len(), 1 | 3) {
        let what = format!("its layer {} has {} channels", layer.title(), colors.len());
        return Err(MapFault::unsupported(what, "give a layer with one or three channels"));
    }
    Ok(layer.selected(colors))
}

fn colors(layers: &[Layer]) -> Result<Option<Selected>, MapFault> {
    let colored: Vec<&Layer> = layers.iter().filter(|layer| layer.colors().is_some()).collect();
    let Some(best) = colored.iter().min_by_key(|layer| layer.rank()) else { return Ok(None) };
    if colored.len() > 1 && !best.is_finished() {
        let what = format!("it has several layers with colour: {}", titles(colored.iter().copied()));
        let remedy =
            "choose one (leadr compare: --layer NAME; leadr capture: --environment-layer NAME), or save it alone";
        return Err(MapFault::unsupported(what, remedy));
    }
    refuse_chroma(best)?;
    let selected = best.selected(best.colors().expect("it has colour"));
    Ok(Some(Selected { remark: remark(&colored, best, "with colour"), ..selected }))
}

fn heights(layers: &[Layer]) -> Result<Option<Selected>, MapFault> {
    let having = |name: &&str| {
        let found: Vec<&Layer> = layers.iter().filter(|layer| layer.channel(&[*name]).is_some()).collect();
        let best = found.iter().copied().min_by_key(|layer| layer.rank())?;
        Some((best.channel(&[*name])?, best, found))
    };
    let Some((height, best, found)) = HEIGHTS.iter().find_map(having) else { return Ok(None) };
    refuse_chroma(best)?;
    // All three colours are selected, because they may form a normal map.
    let colors = best.colors().filter(|colors| colors.first() == Some(&height));
    let selected = best.selected(colors.unwrap_or(vec![height]));
    Ok(Some(Selected { remark: remark(&found, best, "with heights"), ..selected }))
}

fn remark(candidates: &[&Layer], chosen: &Layer, kind: &str) -> Option<String> {
    let others = candidates.iter().copied().filter(|layer| !std::ptr::eq(*layer, chosen));
    let (count, title) = (candidates.len(), chosen.title());
    (count > 1).then(|| format!("it has {count} layers {kind}; {title} is read, not {}", titles(others)))
}

fn refuse_chroma(layer: &Layer) -> Result<(), MapFault> {
    let what = "it stores luminance and chroma (channels Y, RY and BY)";
    if layer.stores_chroma() { Err(MapFault::unsupported(what, "save it as plain RGB")) } else { Ok(()) }
}

fn titles<'a>(layers: impl Iterator<Item = &'a Layer>) -> String {
    shown(&layers.take(50).map(Layer::title).collect::<Vec<_>>().join(", "))
}

fn no_channel(meta: &MetaData, wanted: &str) -> MapFault {
    let mut found: Vec<String> = Vec::new();
    for header in &meta.headers {
        if header.deep {
            found.push("deep data".to_owned());
        } else {
            found.extend(header.channels.list.iter().take(50).map(|channel| channel.name.to_string()));
        }
    }
    MapFault::unsupported(format!("it has no channel {wanted}, only: {}", shown(&found.join(", "))), REEXPORT)
}
