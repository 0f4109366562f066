//! How much an untrusted model may ask for. Every claim in it is believed only within these; images keep to the limits of
//! [`leadr_maps::limits`] as well.

use std::ops::RangeInclusive;
use std::sync::atomic::{AtomicU64, Ordering};

use super::fault::ModelFault;

/// Most bytes of all buffers together, files and data URIs alike.
pub const MAX_BUFFER_BYTES: u64 = 1 << 30;
/// Most JSON objects in a model. A node, an accessor, a channel of an animation are one to three each.
pub const MAX_OBJECTS: usize = 1 << 20;
/// Most values in all arrays and objects of the JSON.
pub const MAX_VALUES: usize = 1 << 23;
/// Most joints of a skin: what the 16-bit indices of vertices can name.
pub const MAX_JOINTS: usize = 1 << 16;
/// Most morph targets of a mesh.
pub const MAX_TARGETS: usize = 1 << 12;
/// Most bytes of vertices, triangles and animation that a model may unpack to.
pub const MAX_UNPACKED_BYTES: u64 = 4 << 30;
/// Unpacked bytes that a file of any length may claim: accessors without data are zeros, and parts may share data.
const FREE_UNPACKED_BYTES: u64 = 128 << 20;
/// Further unpacked bytes that are believed per byte of the buffers.
const MAX_EXPANSION: u64 = 64;
/// Most bytes of all images together, read and decoded.
pub const MAX_IMAGE_BYTES: u64 = 4 << 30;
/// Largest coordinate, offset or scale accepted: squares and products of three stay finite in 32 bits.
pub const MAX_COORDINATE: f32 = 1e12;
/// Coordinates, offsets and scales that are accepted.
pub(super) const COORDINATES: RangeInclusive<f32> = -MAX_COORDINATE..=MAX_COORDINATE;

/// Bytes that a model may still unpack, on whatever thread.
pub(super) struct Budget {
    left: AtomicU64,
    /// What is said of a model that unpacks more.
    fault: String,
}

impl Budget {
    /// For a model whose buffers hold this many bytes.
    pub(super) fn for_buffers(bytes: u64) -> Self {
        let whole = bytes.saturating_mul(MAX_EXPANSION).saturating_add(FREE_UNPACKED_BYTES).min(MAX_UNPACKED_BYTES);
        let fault = format!("its parts unpack to more than the {whole} bytes that its length lets one expect");
        Self { left: AtomicU64::new(whole), fault }
    }

    /// For the images of a model, read and decoded.
    pub(super) fn for_images() -> Self {
        let fault = format!("its images have more than {MAX_IMAGE_BYTES} bytes");
        Self { left: AtomicU64::new(MAX_IMAGE_BYTES), fault }
    }

    /// Takes the bytes of `count` elements before they are allocated.
    pub(super) fn take<T>(&self, count: usize) -> Result<(), ModelFault> {
        let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
        let rest = |left: u64| left.checked_sub(bytes);
        let taken = self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, rest);
        taken.map(drop).map_err(|_| ModelFault::too_large(&self.fault))
    }
}
