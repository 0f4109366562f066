//! The model file opened: its lists, buffers and accessors, and what reading it has to remark.

use std::borrow::Cow;
use std::cell::{Cell, RefCell};
use std::path::Path;

use super::accessor::{Accessor, Buffer, BufferView};
use super::json::{Item, Read};
use super::{extensions, uri};
use crate::fault::ModelFault;
use crate::limits::{Budget, MAX_BUFFER_BYTES};
use leadr_maps::limits::in_words;

/// Most remarks that are kept; the rest is counted.
const MAX_REMARKS: usize = 64;

/// Reads all buffers, from the file itself and from beside it.
pub(super) fn buffers<'a>(root: &Item<'_>, binary: Option<&'a [u8]>, folder: Option<&Path>) -> Read<Vec<Buffer<'a>>> {
    let mut all = Vec::new();
    let mut sum = 0u64;
    for (i, item) in root.items("buffers", "buffer")?.into_iter().enumerate() {
        let length = item.required("byteLength", item.whole("byteLength")?)?;
        if length == 0 {
            return Err(item.fault("`byteLength` must be 1 or more"));
        }
        sum = sum.saturating_add(length);
        if sum > MAX_BUFFER_BYTES {
            let [sum, most] = [sum, MAX_BUFFER_BYTES].map(in_words);
            let what = format!("its buffers have {sum} or more, the limit is {most}");
            return Err(ModelFault::too_large(what));
        }
        let bytes = match (item.string("uri")?, binary) {
            (Some(uri), _) => Some(Cow::Owned(uri::fetch(uri, folder, item.place, length)?)),
            (None, Some(binary)) if i == 0 => Some(Cow::Borrowed(binary)),
            // Left to an extension: an error only if the data are used.
            (None, _) => None,
        };
        if let Some(bytes) = bytes.as_ref().filter(|bytes| (bytes.len() as u64) < length) {
            return Err(item.fault(format!("`byteLength` is {length}, but there are {} bytes", bytes.len())));
        }
        all.push(Buffer { length, bytes });
    }
    Ok(all)
}

/// What the readers of all parts share.
pub(super) struct Source<'a> {
    /// The whole model.
    pub(super) root: Item<'a>,
    /// Where files beside the model are; nowhere if it came from memory.
    pub(super) folder: Option<&'a Path>,
    /// Whether images that cannot be had are replaced.
    pub(super) lenient: bool,
    /// All buffer views.
    pub(super) views: Vec<BufferView<'a>>,
    /// All accessors, within their views.
    pub(super) accessors: Vec<Accessor<'a>>,
    /// Whether vertices may be stored in small integers.
    pub(super) quantized: bool,
    /// What may still be unpacked.
    pub(super) budget: Budget,
    /// What images may still unpack.
    pub(super) image_budget: Budget,
    remarks: RefCell<Vec<String>>,
    more_remarks: Cell<usize>,
}

impl<'a> Source<'a> {
    /// Opens the lists that other parts refer to, and checks version and extensions.
    pub(super) fn open(
        root: Item<'a>,
        buffers: &'a [Buffer<'_>],
        folder: Option<&'a Path>,
        lenient: bool,
    ) -> Read<Self> {
        let there = buffers.iter().filter(|buffer| buffer.bytes.is_some()).map(|buffer| buffer.length).sum();
        let view = |item: &Item<'_>| BufferView::read(item, buffers);
        let views = root.items("bufferViews", "buffer view")?.iter().map(view).collect::<Read<Vec<_>>>()?;
        let budget = Budget::for_buffers(there);
        let accessors = root.items("accessors", "accessor")?;
        let accessors = accessors.iter().map(|item| Accessor::read(item, &views, &budget)).collect::<Read<_>>()?;
        let mut source = Self {
            root,
            folder,
            lenient,
            views,
            accessors,
            quantized: false,
            budget,
            image_budget: Budget::for_images(),
            remarks: RefCell::default(),
            more_remarks: Cell::new(0),
        };
        let unread = extensions::check(&root)?;
        source.quantized = root.strings("extensionsUsed")?.contains(&extensions::QUANTIZATION);
        if !unread.is_empty() {
            source.remark(format!("uses extensions that are not read: {}", unread.join(", ")));
        }
        Ok(source)
    }

    /// Notes what was read otherwise than the file says.
    pub(super) fn remark(&self, text: impl Into<String>) {
        let mut remarks = self.remarks.borrow_mut();
        if remarks.len() < MAX_REMARKS {
            remarks.push(text.into());
        } else {
            self.more_remarks.set(self.more_remarks.get() + 1);
        }
    }

    /// All remarks.
    pub(super) fn into_remarks(self) -> Vec<String> {
        let mut remarks = self.remarks.into_inner();
        if self.more_remarks.get() > 0 {
            remarks.push(format!("{} further remarks are left out", self.more_remarks.get()));
        }
        remarks
    }

    /// The accessor that a property names, if it is there.
    pub(super) fn accessor(&self, item: &Item<'_>, key: &str) -> Read<Option<&Accessor<'a>>> {
        let index = item.index(key, "accessor", self.accessors.len())?;
        Ok(index.map(|i| &self.accessors[i]))
    }
}
