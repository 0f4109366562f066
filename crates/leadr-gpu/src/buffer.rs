//! Buffers in device-local memory, or in mapped memory for upload or readback.

use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;
use bytemuck::{AnyBitPattern, NoUninit};
use gpu_allocator::vulkan::{Allocation, AllocationCreateDesc, AllocationScheme};
use gpu_allocator::{AllocationError, MemoryLocation};

use super::error::Doing;
use super::{DriverCall, Gpu, GpuError, Result};

/// The largest number of bytes that are staged at once. The limit lets large transfers fit into a small heap.
pub(crate) const STAGING_BYTES: u64 = 32 << 20;

/// The kind of memory of a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Memory {
    /// Memory that is fast for the GPU and not mapped. The CPU accesses it through a staging buffer, and waits for the copy.
    Device,
    /// Mapped memory that the CPU writes, for example every frame.
    Upload,
    /// Mapped memory that the CPU reads.
    Readback,
}

/// A buffer for storage blocks, uniform blocks and copies. Clones share the same buffer.
#[derive(Clone)]
pub struct Buffer {
    pub(crate) inner: Arc<BufferInner>,
}

pub(crate) struct BufferInner {
    gpu: Arc<Gpu>,
    pub(crate) raw: vk::Buffer,
    // This is `None` only while the buffer is being dropped. The lock serialises accesses by the CPU.
    allocation: Mutex<Option<Allocation>>,
    name: String,
    size: u64,
    memory: Memory,
}

impl Drop for BufferInner {
    fn drop(&mut self) {
        let allocation = self.allocation.get_mut().unwrap_or_else(PoisonError::into_inner).take();
        // SAFETY: commands that use the buffer hold an Arc of it until they are done.
        unsafe { self.gpu.raw().destroy_buffer(self.raw, None) };
        if let Some(allocation) = allocation {
            let _ = self.gpu.allocator().free(allocation);
        }
    }
}

impl Buffer {
    /// Creates a buffer of `size` bytes with undefined content. The allocation has at least 4 bytes.
    pub fn new(gpu: &Arc<Gpu>, name: &str, size: u64, memory: Memory) -> Result<Self> {
        let size = size.max(4);
        let usage = vk::BufferUsageFlags::STORAGE_BUFFER
            | vk::BufferUsageFlags::UNIFORM_BUFFER
            | vk::BufferUsageFlags::TRANSFER_SRC
            | vk::BufferUsageFlags::TRANSFER_DST;
        let info = vk::BufferCreateInfo::default().size(size).usage(usage);
        // SAFETY: the device is alive; `inner` below destroys the buffer if it gets no memory.
        let raw = unsafe { gpu.raw().create_buffer(&info, None) }.doing(format!("creating buffer {name}"))?;
        gpu.name(raw, name);
        // SAFETY: the buffer was made above, on this device.
        let requirements = unsafe { gpu.raw().get_buffer_memory_requirements(raw) };
        let location = match memory {
            Memory::Device => MemoryLocation::GpuOnly,
            Memory::Upload => MemoryLocation::CpuToGpu,
            Memory::Readback => MemoryLocation::GpuToCpu,
        };
        let allocation = allocate(gpu, name, requirements, location, true);
        let mut inner =
            BufferInner { gpu: gpu.clone(), raw, allocation: Mutex::new(None), name: name.to_owned(), size, memory };
        let allocation = allocation?;
        // SAFETY: the memory was made for this buffer and is not bound yet.
        let bound = unsafe { gpu.raw().bind_buffer_memory(raw, allocation.memory(), allocation.offset()) };
        *inner.allocation.get_mut().unwrap_or_else(PoisonError::into_inner) = Some(allocation);
        bound.doing(format!("binding memory of buffer {name}"))?;
        Ok(Self { inner: Arc::new(inner) })
    }

    /// Creates a device-local buffer with a copy of `data`, and waits for the upload.
    pub fn from_slice<T: NoUninit>(gpu: &Arc<Gpu>, name: &str, data: &[T]) -> Result<Self> {
        let buffer = Self::new(gpu, name, size_of_val(data) as u64, Memory::Device)?;
        buffer.write(0, data)?;
        Ok(buffer)
    }

    /// Returns the size in bytes.
    pub fn size(&self) -> u64 {
        self.inner.size
    }

    /// Returns the debug name.
    pub fn name(&self) -> &str {
        &self.inner.name
    }

    /// Returns the raw handle.
    pub fn raw(&self) -> vk::Buffer {
        self.inner.raw
    }

    /// Writes `data` starting at byte `offset`. Mapped buffers are written at once, so the caller must make sure that the GPU is
    /// not reading them. Device-local buffers are written through a staging buffer, and the call waits for the copy.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if the data exceeds the buffer.
    pub fn write<T: NoUninit>(&self, offset: u64, data: &[T]) -> Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        self.check(offset, bytes.len() as u64)?;
        if bytes.is_empty() {
            return Ok(());
        }
        if self.inner.memory != Memory::Device {
            return self.with_mapped(|mapped| mapped[offset as usize..][..bytes.len()].copy_from_slice(bytes));
        }
        let gpu = &self.inner.gpu;
        let staging = Self::new(gpu, "staging", STAGING_BYTES.min(bytes.len() as u64), Memory::Upload)?;
        for (i, chunk) in bytes.chunks(STAGING_BYTES as usize).enumerate() {
            staging.write(0, chunk)?;
            let at = offset + i as u64 * STAGING_BYTES;
            gpu.submit(&format!("write {}", self.inner.name), |cmd| {
                cmd.copy_buffer(&staging, 0, self, at, chunk.len() as u64);
            })?;
        }
        Ok(())
    }

    /// Reads `count` values starting at byte `offset`. Device-local buffers are read through a staging buffer, and the call waits
    /// for the copy.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if the range exceeds the buffer.
    pub fn read<T: AnyBitPattern + NoUninit>(&self, offset: u64, count: usize) -> Result<Vec<T>> {
        let length = (count as u64).saturating_mul(size_of::<T>() as u64);
        self.check(offset, length)?;
        let mut values: Vec<T> = vec![T::zeroed(); count];
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut values);
        if bytes.is_empty() {
            return Ok(values);
        }
        if self.inner.memory != Memory::Device {
            self.with_mapped(|mapped| bytes.copy_from_slice(&mapped[offset as usize..][..bytes.len()]))?;
            return Ok(values);
        }
        let gpu = &self.inner.gpu;
        let staging = Self::new(gpu, "readback", STAGING_BYTES.min(length), Memory::Readback)?;
        for (i, chunk) in bytes.chunks_mut(STAGING_BYTES as usize).enumerate() {
            let at = offset + i as u64 * STAGING_BYTES;
            gpu.submit(&format!("read {}", self.inner.name), |cmd| {
                cmd.copy_buffer(self, at, &staging, 0, chunk.len() as u64);
            })?;
            staging.with_mapped(|mapped| chunk.copy_from_slice(&mapped[..chunk.len()]))?;
        }
        Ok(values)
    }

    /// Reads the whole buffer as values of `T`. A remainder smaller than one value is ignored.
    pub fn read_all<T: AnyBitPattern + NoUninit>(&self) -> Result<Vec<T>> {
        self.read(0, self.inner.size as usize / size_of::<T>().max(1))
    }

    /// Runs `f` on the mapped memory.
    pub(crate) fn with_mapped<R>(&self, f: impl FnOnce(&mut [u8]) -> R) -> Result<R> {
        let mut allocation = self.inner.allocation.lock().unwrap_or_else(PoisonError::into_inner);
        let mapped = allocation.as_mut().and_then(Allocation::mapped_slice_mut);
        let mapped = mapped.ok_or_else(|| GpuError::usage(&self.inner.name, "its memory is not mapped"))?;
        Ok(f(mapped))
    }

    fn check(&self, offset: u64, length: u64) -> Result<()> {
        if offset.checked_add(length).is_some_and(|end| end <= self.inner.size) {
            return Ok(());
        }
        Err(GpuError::usage(
            &self.inner.name,
            format!("{length} bytes at {offset} are more than the buffer's {}", self.inner.size),
        ))
    }
}

/// Allocations of at least this size are first compared with the free memory, because drivers report a shortage late or never.
const LARGE: u64 = 64 << 20;

/// Allocates memory for a resource. Errors contain the resource's name.
pub(crate) fn allocate(
    gpu: &Gpu,
    name: &str,
    requirements: vk::MemoryRequirements,
    location: MemoryLocation,
    linear: bool,
) -> Result<Allocation> {
    if location == MemoryLocation::GpuOnly && requirements.size >= LARGE {
        let bytes = requirements.size;
        gpu.memory_room().check(bytes, bytes, name, "smaller maps or a smaller image")?;
    }
    let description = AllocationCreateDesc {
        name,
        requirements,
        location,
        linear,
        allocation_scheme: AllocationScheme::GpuAllocatorManaged,
    };
    let refused = gpu.faults().check(DriverCall::Allocation).map_err(|_| AllocationError::OutOfMemory);
    refused.and_then(|()| gpu.allocator().allocate(&description)).map_err(|source| GpuError::Allocation {
        name: name.to_owned(),
        bytes: requirements.size,
        source,
    })
}
