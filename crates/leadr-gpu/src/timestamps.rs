//! Measures time on the device between named marks.

use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;

use super::error::Doing;
use super::{Gpu, GpuError, Result};

/// Timestamp queries, one for each mark. Clones share the queries.
#[derive(Clone)]
pub struct Timestamps {
    pub(crate) inner: Arc<TimestampsInner>,
}

pub(crate) struct TimestampsInner {
    gpu: Arc<Gpu>,
    raw: vk::QueryPool,
    capacity: u32,
    /// A mask of the bits of a tick that are valid.
    mask: u64,
    /// The names of the marks that were submitted last.
    names: Mutex<Vec<String>>,
}

impl Drop for TimestampsInner {
    fn drop(&mut self) {
        // SAFETY: commands that write the queries hold an Arc of them until they are done.
        unsafe { self.gpu.raw().destroy_query_pool(self.raw, None) };
    }
}

impl TimestampsInner {
    /// Records a reset of all queries. After the reset, they may be written again.
    pub(crate) fn reset(&self, commands: vk::CommandBuffer) {
        // SAFETY: the command buffer is being recorded and keeps the queries alive.
        unsafe { self.gpu.raw().cmd_reset_query_pool(commands, self.raw, 0, self.capacity) };
    }

    /// Records the mark with this index.
    pub(crate) fn mark(&self, commands: vk::CommandBuffer, index: usize) -> Result<()> {
        if index >= self.capacity as usize {
            let fault = format!("there is room for only {} marks", self.capacity);
            return Err(GpuError::usage("timestamps", fault));
        }
        let stage = vk::PipelineStageFlags2::ALL_COMMANDS;
        // SAFETY: the command buffer is being recorded and keeps the queries alive, and `index` is one of them.
        unsafe { self.gpu.raw().cmd_write_timestamp2(commands, stage, self.raw, index as u32) };
        Ok(())
    }

    /// Sets the names of the marks after the commands with the marks were submitted.
    pub(crate) fn set_names(&self, names: Vec<String>) {
        *self.names.lock().unwrap_or_else(PoisonError::into_inner) = names;
    }
}

impl Timestamps {
    /// Creates queries for `capacity` marks per recording.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if the device has no timestamps.
    pub fn new(gpu: &Arc<Gpu>, capacity: u32) -> Result<Self> {
        if gpu.limits().timestamp_compute_and_graphics == vk::FALSE {
            return Err(GpuError::usage("timestamps", format!("{} has no timestamps", gpu.device_name())));
        }
        let info = vk::QueryPoolCreateInfo::default().query_type(vk::QueryType::TIMESTAMP).query_count(capacity.max(1));
        // SAFETY: the device is alive.
        let raw = unsafe { gpu.raw().create_query_pool(&info, None) }.doing("creating timestamps")?;
        gpu.name(raw, "timestamps");
        let (_, instance, physical) = gpu.raw_instance();
        // SAFETY: the instance and the physical device are alive.
        let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
        let bits = families.get(gpu.queue_family() as usize).map_or(64, |family| family.timestamp_valid_bits);
        // A 36-bit clock wraps around within minutes.
        let mask = 1u64.checked_shl(bits).map_or(u64::MAX, |beyond| beyond - 1);
        let (capacity, names) = (capacity.max(1), Mutex::default());
        Ok(Self { inner: Arc::new(TimestampsInner { gpu: gpu.clone(), raw, capacity, mask, names }) })
    }

    /// Returns the marks of the last submission that had marks, in order. Each mark is a name and the milliseconds since the first
    /// mark. Waits for the commands.
    pub fn marks(&self) -> Result<Vec<(String, f64)>> {
        let names = self.inner.names.lock().unwrap_or_else(PoisonError::into_inner).clone();
        if names.is_empty() {
            return Ok(Vec::new());
        }
        let mut ticks = vec![0u64; names.len()];
        let flags = vk::QueryResultFlags::TYPE_64 | vk::QueryResultFlags::WAIT;
        // SAFETY: `ticks` has room for all marks, and the pool contains a query for every mark.
        unsafe { self.inner.gpu.raw().get_query_pool_results(self.inner.raw, 0, &mut ticks, flags) }
            .doing("reading timestamps")?;
        let period = f64::from(self.inner.gpu.limits().timestamp_period);
        let since = |tick: u64| (tick.wrapping_sub(ticks[0]) & self.inner.mask) as f64 * period * 1e-6;
        Ok(names.into_iter().zip(ticks.iter().map(|tick| since(*tick))).collect())
    }

    /// Returns the time from each mark to the next in milliseconds, with the name of the second of the two marks. To time a pass,
    /// place a mark after it. The first mark only starts the clock.
    pub fn intervals(&self) -> Result<Vec<(String, f64)>> {
        let marks = self.marks()?;
        Ok(marks.windows(2).map(|pair| (pair[1].0.clone(), pair[1].1 - pair[0].1)).collect())
    }
}
