//! Queries the memory that the device's resources use, and the memory that is free.

use ash::vk;

use super::{Gpu, GpuError, Result};

/// The device memory that is in use, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryUse {
    /// The bytes that buffers and images hold.
    pub allocated: u64,
    /// The bytes that were allocated from the driver, including the free space in memory blocks.
    pub reserved: u64,
    /// The number of buffers and images that have memory.
    pub allocations: usize,
}

/// The device memory that is available to new resources, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct MemoryRoom {
    /// The total memory of the device.
    pub size: u64,
    /// The free memory of the device.
    pub left: u64,
    /// The largest size of one buffer or image.
    pub piece: u64,
}

impl MemoryRoom {
    /// Checks that the device has room for `needs` bytes, of which `piece` bytes belong to one buffer or image.
    ///
    /// # Errors
    /// Returns [`GpuError::InOnePiece`] or [`GpuError::TooLarge`]. `what` names the content, and `remedy` names an alternative that
    /// needs less memory.
    pub fn check(&self, needs: u64, piece: u64, what: &str, remedy: &str) -> Result<()> {
        let Self { size, left, piece: most } = *self;
        let (what, remedy) = (what.to_owned(), remedy.to_owned());
        if needs > left {
            return Err(GpuError::TooLarge { what, needs, left, size, remedy });
        }
        if piece > most {
            return Err(GpuError::InOnePiece { what, needs: piece, most, remedy });
        }
        Ok(())
    }
}

/// Returns the number of bytes of system memory that programs can still use, or `None` if the system does not report it.
pub fn machine_memory() -> Option<u64> {
    entry(&std::fs::read_to_string("/proc/meminfo").ok()?, AVAILABLE)
}

/// The names of the available and the total memory in Linux's `/proc/meminfo`.
const AVAILABLE: &str = "MemAvailable:";
const TOTAL: &str = "MemTotal:";

/// Returns an entry of Linux's `/proc/meminfo`, in bytes.
fn entry(meminfo: &str, name: &str) -> Option<u64> {
    let line = meminfo.lines().find_map(|line| line.strip_prefix(name))?;
    line.trim().strip_suffix("kB")?.trim().parse::<u64>().ok()?.checked_mul(1024)
}

impl Gpu {
    /// Returns the memory currently held by buffers and images.
    pub fn memory_use(&self) -> MemoryUse {
        let report = self.allocator().generate_report();
        MemoryUse {
            allocated: report.total_allocated_bytes,
            reserved: report.total_capacity_bytes,
            allocations: report.allocations.len(),
        }
    }

    /// Returns the device-local memory available to buffers and images.
    pub fn memory_room(&self) -> MemoryRoom {
        let piece = self.largest_allocation();
        // Software drivers use system memory, which other programs share. The sizes that they report are arbitrary (2 GiB in
        // lavapipe).
        if self.is_software()
            && let Ok(meminfo) = std::fs::read_to_string("/proc/meminfo")
            && let (Some(size), Some(left)) = (entry(&meminfo, TOTAL), entry(&meminfo, AVAILABLE))
        {
            return MemoryRoom { size, left, piece };
        }
        let size = self.memory_size();
        MemoryRoom { size, left: size.saturating_sub(self.memory_use().allocated), piece }
    }

    /// Returns the size of the largest device-local memory heap in bytes.
    fn memory_size(&self) -> u64 {
        let (_, instance, physical) = self.raw_instance();
        // SAFETY: the instance and the physical device are alive.
        let properties = unsafe { instance.get_physical_device_memory_properties(physical) };
        let own = properties.memory_heaps_as_slice().iter();
        let own = own.filter(|heap| heap.flags.contains(vk::MemoryHeapFlags::DEVICE_LOCAL));
        own.map(|heap| heap.size).max().unwrap_or(u64::MAX)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn proc_status_is_parsed() {
        let text = "MemTotal:       24630000 kB\nMemFree:         9000000 kB\nMemAvailable:   20000000 kB\n";
        assert_eq!(entry(text, AVAILABLE), Some(20_000_000 * 1024));
        assert_eq!(entry(text, TOTAL), Some(24_630_000 * 1024));
        assert_eq!((entry("", AVAILABLE), entry("MemAvailable: a lot", AVAILABLE)), (None, None));
    }

    #[test]
    fn oversized_memory_is_refused_with_units() {
        let room = MemoryRoom { size: 4 << 30, left: 3 << 30, piece: 2 << 30 };
        assert!(room.check(3 << 30, 2 << 30, "a map", "less").is_ok());
        let message = room.check((3 << 30) + 1, 0, "a map", "smaller maps").unwrap_err().to_string();
        assert_eq!(
            message,
            "a map needs 3.00 GiB of device memory, but 3.00 GiB of 4.00 GiB are free: use smaller maps"
        );
        let message = room.check(3 << 30, 3 << 30, "a map", "smaller maps").unwrap_err().to_string();
        assert_eq!(
            message,
            "a map needs 3.00 GiB of device memory in one allocation, but the device allows 2.00 GiB: use smaller maps"
        );
    }
}
