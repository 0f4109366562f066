//! The files of a document: one buffer, and images in it or beside it.

use std::collections::{BTreeMap, HashMap};

use leadr_models::Document;
use serde_json::{Value, json};

use super::{FilterError, invalid, list};

/// Data start at multiples of this number of bytes, which suits every accessor.
const ALIGNMENT: usize = 8;
const MESHOPT: [&str; 2] = ["EXT_meshopt_compression", "KHR_meshopt_compression"];

/// A document with one buffer. Images of files are apart from it.
#[derive(Clone, Debug)]
pub(super) struct Parts {
    json: Value,
    buffer: Vec<u8>,
    images: BTreeMap<usize, Vec<u8>>,
}

impl Parts {
    /// Takes a document. `replaced` has the new bytes of images by number. The bytes of images that were replaced are left out.
    pub(super) fn new(document: Document, replaced: HashMap<usize, Vec<u8>>) -> Result<Self, FilterError> {
        let Document { mut json, mut buffers, images, .. } = document;
        remove_image_views(&mut json, &mut buffers);
        let buffer = join(&mut json, buffers)?;
        // Images of the file's folder, and those that were embedded as text.
        let files = images.into_iter().enumerate().filter_map(|(i, image)| Some((i, image.file?)));
        let mut images: BTreeMap<usize, Vec<u8>> = files.collect();
        images.extend(replaced);
        Ok(Self { json, buffer, images })
    }

    fn image(&mut self, number: usize) -> Result<&mut serde_json::Map<String, Value>, FilterError> {
        self.json["images"][number].as_object_mut().ok_or_else(|| invalid(format!("image {number}")))
    }

    /// Returns the bytes of a `.glb` with all images.
    pub(super) fn glb(mut self) -> Result<Vec<u8>, FilterError> {
        for (number, file) in std::mem::take(&mut self.images) {
            self.buffer.resize(self.buffer.len().next_multiple_of(ALIGNMENT), 0);
            let view = json!({ "buffer": 0, "byteOffset": self.buffer.len(), "byteLength": file.len() });
            self.buffer.extend(&file);
            let views = list(&mut self.json, "bufferViews")?;
            views.push(view);
            let view = views.len() - 1;
            let image = self.image(number)?;
            image.remove("uri");
            image.insert("bufferView".to_owned(), json!(view));
            image.insert("mimeType".to_owned(), json!(kind(&file).0));
        }
        self.buffer.resize(self.buffer.len().next_multiple_of(4), 0);
        self.json["buffers"][0] = json!({ "byteLength": self.buffer.len() });
        let mut text = self.json.to_string().into_bytes();
        text.resize(text.len().next_multiple_of(4), b' ');
        let whole = 12 + 8 + text.len() + 8 + self.buffer.len();
        let size = u32::try_from(whole).map_err(|_| FilterError::TooLarge { bytes: whole as u64 })?;
        let mut file = Vec::with_capacity(whole);
        file.extend(b"glTF");
        file.extend([2, size, text.len() as u32].into_iter().flat_map(u32::to_le_bytes));
        file.extend(b"JSON");
        file.extend(text);
        file.extend((self.buffer.len() as u32).to_le_bytes());
        file.extend(b"BIN\0");
        file.extend(self.buffer);
        Ok(file)
    }

    /// Returns the names and the bytes of a `.gltf`, of its buffer and of its images. All names begin with `name`.
    pub(super) fn files(mut self, name: &str) -> Result<Vec<(String, Vec<u8>)>, FilterError> {
        let mut files = Vec::new();
        for (number, bytes) in std::mem::take(&mut self.images) {
            let (mime, suffix) = kind(&bytes);
            let file = format!("{name}_image{number}.{suffix}");
            let image = self.image(number)?;
            image.insert("uri".to_owned(), json!(encoded(&file)));
            // Only images in buffer views must have a type.
            if mime == "image/ktx2" {
                image.insert("mimeType".to_owned(), json!(mime));
            } else {
                image.remove("mimeType");
            }
            files.push((file, bytes));
        }
        let file = format!("{name}.bin");
        self.json["buffers"][0] = json!({ "byteLength": self.buffer.len(), "uri": encoded(&file) });
        if !self.buffer.is_empty() {
            files.push((file, self.buffer));
        } else if let Some(buffers) =
            self.json.as_object_mut().filter(|json| json["buffers"].as_array().map(Vec::len) == Some(1))
        {
            buffers.remove("buffers");
        }
        files
            .push((format!("{name}.gltf"), serde_json::to_vec_pretty(&self.json).expect("JSON without foreign types")));
        Ok(files)
    }
}

/// Returns the media type and the suffix of an image.
fn kind(file: &[u8]) -> (&'static str, &'static str) {
    match file {
        [0x89, b'P', b'N', b'G', ..] => ("image/png", "png"),
        [0xff, 0xd8, ..] => ("image/jpeg", "jpg"),
        [b'R', b'I', b'F', b'F', ..] => ("image/webp", "webp"),
        [0xab, b'K', b'T', b'X', ..] => ("image/ktx2", "ktx2"),
        _ => ("application/octet-stream", "bin"),
    }
}

/// Returns a file name as a URI.
fn encoded(name: &str) -> String {
    let letter = |byte: u8| match byte {
        b'0'..=b'9' | b'a'..=b'z' | b'A'..=b'Z' | b'-' | b'_' | b'.' => char::from(byte).to_string(),
        byte => format!("%{byte:02X}"),
    };
    name.bytes().map(letter).collect()
}

/// The largest end of a range. Sums of a few ranges do not overflow.
const MOST_BYTES: u64 = 1 << 48;

/// A range of a buffer in an object of the JSON: the number of the buffer, the first byte, and the number of bytes.
fn range(object: &Value) -> Option<(usize, usize, usize)> {
    let number = |key: &str| object[key].as_u64();
    let (at, length) = (number("byteOffset").unwrap_or(0), number("byteLength")?);
    at.checked_add(length).filter(|end| *end <= MOST_BYTES)?;
    Some((number("buffer")? as usize, at as usize, length as usize))
}

/// Calls `f` with every object that refers to a range of a buffer.
fn for_each_range(json: &mut Value, f: &mut dyn FnMut(&mut Value)) {
    for view in json["bufferViews"].as_array_mut().into_iter().flatten() {
        for name in MESHOPT {
            if view["extensions"][name].is_object() {
                f(&mut view["extensions"][name]);
            }
        }
        f(view);
    }
}

/// Removes the bytes of views that no image uses any more, and moves the others together. The views stay, with their last bytes.
fn remove_image_views(json: &mut Value, buffers: &mut [Option<Vec<u8>>]) {
    let mut unused = unused_views(json);
    if unused.is_empty() {
        return;
    }
    let mut kept: Vec<(usize, usize, usize)> = Vec::new();
    let views = json["bufferViews"].as_array().cloned().unwrap_or_default();
    for (i, view) in views.iter().enumerate() {
        if !unused.contains(&i) {
            kept.extend(range(view));
        }
        kept.extend(MESHOPT.iter().filter_map(|name| range(&view["extensions"][name])));
    }
    // Views that share bytes with others stay.
    unused.retain(|&i| {
        range(&views[i]).is_some_and(|(buffer, at, length)| {
            kept.iter().all(|&(other, start, size)| buffer != other || start + size <= at || at + length <= start)
        })
    });
    for (number, buffer) in buffers.iter_mut().enumerate() {
        let Some(bytes) = buffer else { continue };
        // Whole steps of the alignment are cut out, so all other data keep theirs.
        let cut = |i: &usize| {
            let (of, at, length) = range(&views[*i])?;
            let (start, end) = (at.next_multiple_of(ALIGNMENT), (at + length).min(bytes.len()) / ALIGNMENT * ALIGNMENT);
            (of == number && start < end).then_some((start, end))
        };
        let mut cuts: Vec<(usize, usize)> = unused.iter().filter_map(cut).collect();
        cuts.sort_unstable();
        cuts.dedup();
        if cuts.windows(2).any(|pair| pair[0].1 > pair[1].0) {
            continue;
        }
        let moved = |at: usize| at - cuts.iter().map(|&(start, end)| end.min(at).saturating_sub(start)).sum::<usize>();
        for_each_range(json, &mut |object| {
            if let Some((of, at, length)) = range(object)
                && of == number
            {
                object["byteOffset"] = json!(moved(at));
                object["byteLength"] = json!((moved(at + length) - moved(at)).max(1));
            }
        });
        for &(start, end) in cuts.iter().rev() {
            bytes.drain(start..end);
        }
    }
}

/// Returns the views that nothing refers to.
fn unused_views(json: &Value) -> Vec<usize> {
    fn collect(value: &Value, used: &mut Vec<u64>) {
        match value {
            Value::Object(object) => {
                used.extend(object.get("bufferView").and_then(Value::as_u64));
                object.values().for_each(|value| collect(value, used));
            }
            Value::Array(values) => values.iter().for_each(|value| collect(value, used)),
            _ => {}
        }
    }
    let mut used = Vec::new();
    collect(json, &mut used);
    let count = json["bufferViews"].as_array().map_or(0, Vec::len);
    (0..count).filter(|&i| !used.contains(&(i as u64))).collect()
}

/// Joins all buffers with data into the first. Buffers without data follow it.
fn join(json: &mut Value, buffers: Vec<Option<Vec<u8>>>) -> Result<Vec<u8>, FilterError> {
    let mut binary = Vec::new();
    let mut places = Vec::new();
    let old = std::mem::take(list(json, "buffers")?);
    let mut new = vec![json!({})];
    for (bytes, entry) in buffers.into_iter().zip(old) {
        match bytes {
            Some(bytes) => {
                binary.resize(binary.len().next_multiple_of(ALIGNMENT), 0);
                places.push((0, binary.len()));
                binary.extend(bytes);
            }
            None => {
                places.push((new.len(), 0));
                new.push(entry);
            }
        }
    }
    *list(json, "buffers")? = new;
    for_each_range(json, &mut |object| {
        if let Some((buffer, at, _)) = range(object)
            && let Some(&(number, offset)) = places.get(buffer)
        {
            object["buffer"] = json!(number);
            object["byteOffset"] = json!(offset + at);
        }
    });
    Ok(binary)
}
