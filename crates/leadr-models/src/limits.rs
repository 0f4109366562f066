//! Limits on the resources that an untrusted model can claim. Images obey the limits of [`leadr_maps::limits`].

use std::ops::RangeInclusive;
use std::sync::atomic::{AtomicU64, Ordering};

use super::fault::ModelFault;

/// The maximum size in bytes of all buffers together, including files and data URIs.
pub const MAX_BUFFER_BYTES: u64 = 1 << 30;
/// The maximum number of JSON objects in a model. A node, accessor or animation channel takes one to three objects.
pub const MAX_OBJECTS: usize = 1 << 20;
/// The maximum number of values in all JSON arrays and objects.
pub const MAX_VALUES: usize = 1 << 23;
/// The maximum number of joints of a skin, which is the range of 16-bit vertex indices.
pub const MAX_JOINTS: usize = 1 << 16;
/// The maximum number of morph targets of a mesh.
pub const MAX_TARGETS: usize = 1 << 12;
/// The maximum size in bytes of unpacked vertices, triangles and animations.
pub const MAX_UNPACKED_BYTES: u64 = 4 << 30;
/// The number of unpacked bytes that any file may request. Accessors without data are zeros, and parts may share data.
const FREE_UNPACKED_BYTES: u64 = 128 << 20;
/// The number of further unpacked bytes that are allowed per byte of the buffers.
const MAX_EXPANSION: u64 = 64;
/// Largest accepted coordinate, offset or scale. Squares and products of three stay finite in 32 bits.
pub const MAX_COORDINATE: f32 = 1e12;
/// Largest accepted factor on the height of relief.
pub const MAX_HEIGHT_SCALE: f32 = 1e3;
pub(super) const COORDINATES: RangeInclusive<f32> = -MAX_COORDINATE..=MAX_COORDINATE;

/// The number of bytes that a model may still unpack, shared by all threads.
pub(super) struct Budget {
    left: AtomicU64,
    fault: String,
}

impl Budget {
    pub(super) fn for_buffers(bytes: u64) -> Self {
        let whole = bytes.saturating_mul(MAX_EXPANSION).saturating_add(FREE_UNPACKED_BYTES).min(MAX_UNPACKED_BYTES);
        let fault = format!("its parts unpack to more than {whole} bytes, the limit for its length");
        Self { left: AtomicU64::new(whole), fault }
    }

    /// Reserves the bytes of `count` elements before their allocation.
    pub(super) fn take<T>(&self, count: usize) -> Result<(), ModelFault> {
        let bytes = (count as u64).saturating_mul(size_of::<T>() as u64);
        let rest = |left: u64| left.checked_sub(bytes);
        let taken = self.left.fetch_update(Ordering::Relaxed, Ordering::Relaxed, rest);
        taken.map(drop).map_err(|_| ModelFault::too_large(&self.fault))
    }
}
