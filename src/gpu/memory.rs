//! How much memory the device's resources occupy, and how much it has.

use ash::vk;

use super::Gpu;

/// Device memory in use, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryUse {
    /// Held by buffers and images.
    pub allocated: u64,
    /// Reserved from the driver, including the free space in its blocks.
    pub reserved: u64,
    /// Number of buffers and images.
    pub allocations: usize,
}

impl Gpu {
    /// The memory that buffers and images hold now.
    #[must_use]
    pub fn memory_use(&self) -> MemoryUse {
        let report = self.allocator().generate_report();
        MemoryUse {
            allocated: report.total_allocated_bytes,
            reserved: report.total_capacity_bytes,
            allocations: report.allocations.len(),
        }
    }

    /// Bytes of the largest heap of the device's own memory.
    #[must_use]
    pub fn memory_size(&self) -> u64 {
        let (_, instance, physical) = self.raw_instance();
        // SAFETY: the instance and the physical device are alive.
        let properties = unsafe { instance.get_physical_device_memory_properties(physical) };
        let own = properties.memory_heaps_as_slice().iter();
        let own = own.filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL));
        own.map(|heap| heap.size).max().unwrap_or(u64::MAX)
    }
}
