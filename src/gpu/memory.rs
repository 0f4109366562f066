//! How much memory the device's resources take.

use super::Gpu;

/// Device memory in use, bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryUse {
    /// Held by buffers and images.
    pub allocated: u64,
    /// Taken from the driver, what is free in its blocks included.
    pub reserved: u64,
    /// Number of buffers and images.
    pub allocations: usize,
}

impl Gpu {
    /// What buffers and images hold now.
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
