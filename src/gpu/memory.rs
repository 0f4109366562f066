//! How much memory the device's resources occupy.

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
}
