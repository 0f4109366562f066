//! The opened model file: its lists, buffers and accessors, and messages for the user.

use std::borrow::Cow;

use super::accessor::{Accessor, Buffer, BufferView, Unpacked};
use super::json::{Item, Read};
use super::log::Log;
use super::uri::Folder;
use super::{extensions, uri};
use crate::fault::{Broken, ModelFault};
use crate::limits::{Budget, MAX_BUFFER_BYTES};
use leadr_maps::limits::{ImageBudget, format_bytes};

/// The number of bytes that are read after the declared end of a buffer, because some exporters forget its padding.
const SLACK: u64 = 64;

/// Reads all buffers, embedded or from other files. A buffer that cannot be read is a fault of the parts that use it.
pub(super) fn buffers<'a>(
    root: &Item<'_>,
    binary: Option<&'a [u8]>,
    folder: Option<Folder<'_>>,
    log: &Log,
) -> Read<Vec<Buffer<'a>>> {
    let mut all = Vec::new();
    let mut sum = 0u64;
    for (i, item) in root.items("buffers", "buffer")?.into_iter().enumerate() {
        let declared = item.required("byteLength", Item::whole).and_then(|length| match length {
            0 => Err(item.fault("`byteLength` must be 1 or more")),
            length => Ok(length),
        });
        let uri = item.string("uri")?;
        let most = match (&declared, uri) {
            (Ok(length), _) => *length,
            (Err(_), Some(uri)) => uri.len() as u64,
            (Err(_), None) => 0,
        };
        sum = sum.saturating_add(most);
        if sum > MAX_BUFFER_BYTES {
            let [sum, most] = [sum, MAX_BUFFER_BYTES].map(format_bytes);
            let what = format!("its buffers have {sum} or more; the limit is {most}");
            return Err(ModelFault::too_large(what));
        }
        let bytes = match (uri, binary) {
            (Some(uri), _) => uri::fetch(uri, folder, item.location, most.saturating_add(SLACK), log).map(Cow::Owned),
            (None, Some(binary)) if i == 0 => Ok(Cow::Borrowed(binary)),
            // An extension provides the buffer's bytes.
            (None, _) => Err(item.fault("is needed, but has no readable data")),
        };
        let bytes = match bytes {
            // Nothing reports data of an extension, and other missing data are reported by the parts that use them.
            Err(fault) if uri.is_some() && log.strict => return Err(fault),
            bytes => bytes.map_err(Broken::new),
        };
        let there = bytes.as_ref().map_or(most, |bytes| bytes.len() as u64);
        let length = match declared {
            Ok(length) if length <= there => length,
            Ok(length) => {
                let what = format!("`byteLength` is {length}, but there are {there} bytes");
                log.repair(item.fault(what), "it is read as far as it is there")?;
                there
            }
            Err(fault) => {
                log.repair(fault, "all of its data are read")?;
                there
            }
        };
        all.push(Buffer { length, bytes });
    }
    Ok(all)
}

/// Returns the budget for data that are unpacked from buffers.
pub(super) fn budget(buffers: &[Buffer<'_>]) -> Budget {
    Budget::for_buffers(buffers.iter().filter(|buffer| buffer.bytes.is_ok()).map(|buffer| buffer.length).sum())
}

/// Leaves the fault of a part to those that use it.
fn lazily<T>(read: Read<T>, log: &Log) -> Read<Result<T, Broken>> {
    match read {
        Err(fault) if log.strict || matches!(fault, ModelFault::TooLarge { .. }) => Err(fault),
        read => Ok(read.map_err(Broken::new)),
    }
}

/// The state that all readers share.
pub(super) struct Source<'a> {
    pub(super) root: Item<'a>,
    pub(super) log: &'a Log,
    /// The selected variant of materials.
    pub(super) variant: Option<usize>,
    /// Folder of external files; `None` for a model in memory.
    pub(super) folder: Option<Folder<'a>>,
    pub(super) views: Vec<Result<BufferView<'a>, Broken>>,
    /// All accessors, whose ranges have been checked against their views.
    accessors: Vec<Result<Accessor<'a>, Broken>>,
    /// Whether the model declares `KHR_mesh_quantization`.
    pub(super) quantized: bool,
    /// The required extensions that are not supported.
    pub(super) unread: Vec<String>,
    /// The number of bytes that may still be unpacked.
    pub(super) budget: Budget,
    /// Remaining bytes of images.
    pub(super) image_budget: ImageBudget,
}

impl<'a> Source<'a> {
    /// Reads the shared lists, and checks the extensions.
    pub(super) fn open(
        root: Item<'a>,
        log: &'a Log,
        buffers: &'a [Buffer<'_>],
        unpacked: &'a [Unpacked],
        budget: Budget,
        folder: Option<Folder<'a>>,
        variant: Option<&str>,
    ) -> Read<Self> {
        let unread = extensions::unread(&root, log)?;
        let quantized = root.strings("extensionsUsed")?.contains(&extensions::QUANTIZATION);
        let view = |(item, unpacked): (&Item<'_>, &'a Unpacked)| match unpacked {
            None => lazily(BufferView::read(item, buffers, log), log),
            Some(bytes) => lazily(BufferView::unpacked(item, bytes), log),
        };
        let items = root.items("bufferViews", "buffer view")?;
        let views = items.iter().zip(unpacked).map(view).collect::<Read<Vec<_>>>()?;
        let accessor = |item: &Item<'_>| lazily(Accessor::read(item, &views, &budget, log), log);
        let accessors = root.items("accessors", "accessor")?.iter().map(accessor).collect::<Read<_>>()?;
        let variant = variant.map(|name| extensions::variant(&root, name)).transpose()?;
        let image_budget = ImageBudget::default();
        Ok(Self { root, log, variant, folder, views, accessors, quantized, unread, budget, image_budget })
    }

    /// Returns the accessor that a property refers to. Fails if there is no such accessor, or if it cannot be read.
    pub(super) fn accessor(&self, item: &Item<'_>, key: &str) -> Read<Option<&Accessor<'a>>> {
        match item.exact_index(key, "accessor", self.accessors.len())? {
            None => Ok(None),
            Some(index) => self.accessors[index].as_ref().map(Some).map_err(Broken::fault),
        }
    }
}
