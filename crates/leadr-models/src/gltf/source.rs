//! The opened model file: its lists, buffers and accessors, and messages for the user.

use std::borrow::Cow;
use std::cell::{Cell, RefCell};

use super::accessor::{Accessor, Buffer, BufferView};
use super::json::{Item, Read};
use super::uri::Folder;
use super::{extensions, uri};
use crate::fault::ModelFault;
use crate::limits::{Budget, MAX_BUFFER_BYTES};
use leadr_maps::limits::{ImageBudget, format_bytes};

/// The maximum number of stored remarks. Further remarks are only counted.
const MAX_REMARKS: usize = 64;

/// Reads all buffers, embedded or from other files.
pub(super) fn buffers<'a>(
    root: &Item<'_>,
    binary: Option<&'a [u8]>,
    folder: Option<Folder<'_>>,
) -> Read<Vec<Buffer<'a>>> {
    let mut all = Vec::new();
    let mut sum = 0u64;
    for (i, item) in root.items("buffers", "buffer")?.into_iter().enumerate() {
        let length = item.required("byteLength", item.whole("byteLength")?)?;
        if length == 0 {
            return Err(item.fault("`byteLength` must be 1 or more"));
        }
        sum = sum.saturating_add(length);
        if sum > MAX_BUFFER_BYTES {
            let [sum, most] = [sum, MAX_BUFFER_BYTES].map(format_bytes);
            let what = format!("its buffers have {sum} or more; the limit is {most}");
            return Err(ModelFault::too_large(what));
        }
        let bytes = match (item.string("uri")?, binary) {
            (Some(uri), _) => Some(Cow::Owned(uri::fetch(uri, folder, item.location, length)?)),
            (None, Some(binary)) if i == 0 => Some(Cow::Borrowed(binary)),
            // An extension provides the buffer's bytes. The model is refused only if the data are used.
            (None, _) => None,
        };
        if let Some(bytes) = bytes.as_ref().filter(|bytes| (bytes.len() as u64) < length) {
            return Err(item.fault(format!("`byteLength` is {length}, but there are {} bytes", bytes.len())));
        }
        all.push(Buffer { length, bytes });
    }
    Ok(all)
}

/// The state that all readers share.
pub(super) struct Source<'a> {
    pub(super) root: Item<'a>,
    /// Folder of external files; `None` for a model in memory.
    pub(super) folder: Option<Folder<'a>>,
    /// Whether unreadable images are replaced.
    pub(super) lenient: bool,
    pub(super) views: Vec<BufferView<'a>>,
    /// All accessors, whose ranges have been checked against their views.
    pub(super) accessors: Vec<Accessor<'a>>,
    /// Whether the model declares `KHR_mesh_quantization`.
    pub(super) quantized: bool,
    /// The number of bytes that may still be unpacked.
    pub(super) budget: Budget,
    /// Remaining bytes of images.
    pub(super) image_budget: ImageBudget,
    remarks: RefCell<Vec<String>>,
    more_remarks: Cell<usize>,
}

impl<'a> Source<'a> {
    /// Reads the shared lists, and checks the version and the extensions.
    pub(super) fn open(
        root: Item<'a>,
        buffers: &'a [Buffer<'_>],
        folder: Option<Folder<'a>>,
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
            image_budget: ImageBudget::default(),
            remarks: RefCell::default(),
            more_remarks: Cell::new(0),
        };
        let unread = extensions::check(&root)?;
        source.quantized = root.strings("extensionsUsed")?.contains(&extensions::QUANTIZATION);
        if !unread.is_empty() {
            source.remark(format!("uses unsupported extensions: {}", unread.join(", ")));
        }
        Ok(source)
    }

    /// Adds a message about a repair or ignored content.
    pub(super) fn remark(&self, text: impl Into<String>) {
        let mut remarks = self.remarks.borrow_mut();
        if remarks.len() < MAX_REMARKS {
            remarks.push(text.into());
        } else {
            self.more_remarks.set(self.more_remarks.get() + 1);
        }
    }

    pub(super) fn into_remarks(self) -> Vec<String> {
        let mut remarks = self.remarks.into_inner();
        if self.more_remarks.get() > 0 {
            remarks.push(format!("{} further remarks are omitted", self.more_remarks.get()));
        }
        remarks
    }

    pub(super) fn accessor(&self, item: &Item<'_>, key: &str) -> Read<Option<&Accessor<'a>>> {
        let index = item.index(key, "accessor", self.accessors.len())?;
        Ok(index.map(|i| &self.accessors[i]))
    }
}
