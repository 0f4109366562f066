//! Transfers image data between the CPU and the device, in chunks that fit a small heap.

use bytemuck::{AnyBitPattern, NoUninit};

use super::buffer::STAGING_BYTES;
use super::{Buffer, GpuError, Image, Memory, Result, Use};

impl Image {
    /// Fills one mip of one layer with tightly packed texels, top row first, and waits for the copy. Afterwards, the whole image is
    /// in [`Use::Sampled`], and mips that have not been written have undefined content.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if `data` does not have the mip's size or the mip does not exist. Returns
    /// [`GpuError::Allocation`] if memory for staging is short.
    pub fn write<T: NoUninit>(&self, mip: u32, layer: u32, data: &[T]) -> Result<()> {
        let bytes: &[u8] = bytemuck::cast_slice(data);
        let (row, rows_per_chunk) = self.chunks(mip, layer)?;
        let [width, height] = self.mip_extent(mip);
        let total = row * u64::from(height);
        if bytes.len() as u64 != total {
            let fault = format!("mip {mip} of {width}x{height} texels has {total} bytes, not {}", bytes.len());
            return Err(GpuError::usage(self.name(), fault));
        }
        let staging_bytes = row * u64::from(rows_per_chunk.min(height));
        let staging = Buffer::new(self.gpu(), "image staging", staging_bytes, Memory::Upload)?;
        for (i, chunk) in bytes.chunks((row * u64::from(rows_per_chunk)) as usize).enumerate() {
            let top = i as u32 * rows_per_chunk;
            let bottom = (top + rows_per_chunk).min(height);
            staging.write(0, chunk)?;
            self.gpu().submit(&format!("write {}", self.name()), |cmd| {
                cmd.transition(self, Use::CopyTarget);
                cmd.copy_buffer_to_image(&staging, 0, self, mip, layer, top..bottom);
                cmd.transition(self, Use::Sampled);
            })?;
        }
        Ok(())
    }

    /// Reads one mip of one layer as tightly packed texels, top row first, and waits for the copy. The whole image returns to its
    /// previous use, or to [`Use::CopySource`] if it was not used before.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if the mip does not exist or its size is not a multiple of the size of `T`. Returns
    /// [`GpuError::Allocation`] if memory for staging is short.
    pub fn read<T: AnyBitPattern + NoUninit>(&self, mip: u32, layer: u32) -> Result<Vec<T>> {
        let (row, rows_per_chunk) = self.chunks(mip, layer)?;
        let height = self.mip_extent(mip)[1];
        let total = (row * u64::from(height)) as usize;
        if size_of::<T>() == 0 || !total.is_multiple_of(size_of::<T>()) {
            let fault = format!("the {total} bytes of mip {mip} are not a multiple of {} bytes", size_of::<T>());
            return Err(GpuError::usage(self.name(), fault));
        }
        let mut values: Vec<T> = vec![T::zeroed(); total / size_of::<T>()];
        let bytes: &mut [u8] = bytemuck::cast_slice_mut(&mut values);
        let staging_bytes = row * u64::from(rows_per_chunk.min(height));
        let staging = Buffer::new(self.gpu(), "image readback", staging_bytes, Memory::Readback)?;
        for (i, chunk) in bytes.chunks_mut((row * u64::from(rows_per_chunk)) as usize).enumerate() {
            let top = i as u32 * rows_per_chunk;
            let bottom = (top + rows_per_chunk).min(height);
            let before = self.last_use();
            self.gpu().submit(&format!("read {}", self.name()), |cmd| {
                cmd.transition(self, Use::CopySource);
                cmd.copy_image_to_buffer(self, mip, layer, top..bottom, &staging, 0);
                if before != Use::Undefined {
                    cmd.transition(self, before);
                }
            })?;
            staging.with_mapped(|mapped| chunk.copy_from_slice(&mapped[..chunk.len()]))?;
        }
        Ok(values)
    }

    /// Returns the number of bytes per row of the mip, and the number of rows per chunk.
    fn chunks(&self, mip: u32, layer: u32) -> Result<(u64, u32)> {
        self.check_mip_layer(mip, layer)?;
        let row = self.texel_bytes()? * u64::from(self.mip_extent(mip)[0]);
        Ok((row, u32::try_from(STAGING_BYTES / row).unwrap_or(u32::MAX).max(1)))
    }
}
