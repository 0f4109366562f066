//! Copies buffers and images, and fills buffers.

use std::ops::Range;

use ash::vk;

use super::{Buffer, Commands, GpuError, Image, Result, Use};

impl Commands {
    /// Copies bytes between buffers.
    pub fn copy_buffer(&mut self, source: &Buffer, source_offset: u64, target: &Buffer, target_offset: u64, size: u64) {
        let fits = |offset: u64, buffer: &Buffer| offset.checked_add(size).is_some_and(|end| end <= buffer.size());
        if !fits(source_offset, source) || !fits(target_offset, target) {
            let fault = format!("{size} bytes do not fit {} or {}", source.name(), target.name());
            return self.fail(GpuError::usage("copy", fault));
        }
        if size == 0 {
            return;
        }
        self.keep(&source.inner);
        self.keep(&target.inner);
        let region = vk::BufferCopy { src_offset: source_offset, dst_offset: target_offset, size };
        // SAFETY: the command buffer is being recorded and keeps both buffers alive; the region lies within them.
        unsafe { self.gpu().raw().cmd_copy_buffer(self.raw(), source.raw(), target.raw(), &[region]) };
    }

    /// Fills a whole buffer with a 32-bit pattern. The last bytes stay unchanged if the size is not a multiple of 4 bytes.
    pub fn fill_buffer(&mut self, buffer: &Buffer, pattern: u32) {
        self.keep(&buffer.inner);
        let size = buffer.size() / 4 * 4;
        // SAFETY: the command buffer is being recorded and keeps the buffer alive; `size` is the buffer's size in whole words.
        unsafe { self.gpu().raw().cmd_fill_buffer(self.raw(), buffer.raw(), 0, size, pattern) };
    }

    /// Copies tightly packed rows from a buffer to the rows `rows` of one mip of one layer. The image must be in
    /// [`Use::CopyTarget`].
    pub fn copy_buffer_to_image(
        &mut self,
        source: &Buffer,
        offset: u64,
        target: &Image,
        mip: u32,
        layer: u32,
        rows: Range<u32>,
    ) {
        let region = match self.region(source, offset, target, mip, layer, rows) {
            Ok(region) => region,
            Err(error) => return self.fail(error),
        };
        let (device, layout) = (self.gpu().raw(), Use::CopyTarget.layout());
        // SAFETY: the command buffer is being recorded; `region` keeps the buffer and the image alive and lies within both.
        unsafe { device.cmd_copy_buffer_to_image(self.raw(), source.raw(), target.raw(), layout, &[region]) };
    }

    /// Copies the rows `rows` of one mip of one layer, tightly packed, into a buffer. The image must be in [`Use::CopySource`].
    pub fn copy_image_to_buffer(
        &mut self,
        source: &Image,
        mip: u32,
        layer: u32,
        rows: Range<u32>,
        target: &Buffer,
        offset: u64,
    ) {
        let region = match self.region(target, offset, source, mip, layer, rows) {
            Ok(region) => region,
            Err(error) => return self.fail(error),
        };
        let (device, layout) = (self.gpu().raw(), Use::CopySource.layout());
        // SAFETY: the command buffer is being recorded; `region` keeps the buffer and the image alive and lies within both.
        unsafe { device.cmd_copy_image_to_buffer(self.raw(), source.raw(), layout, target.raw(), &[region]) };
    }

    fn region(
        &mut self,
        buffer: &Buffer,
        offset: u64,
        image: &Image,
        mip: u32,
        layer: u32,
        rows: Range<u32>,
    ) -> Result<vk::BufferImageCopy> {
        image.check_mip_layer(mip, layer)?;
        let [width, height] = image.mip_extent(mip);
        let bytes = image.texel_bytes()? * u64::from(width) * rows.len() as u64;
        if rows.is_empty() || rows.end > height || offset.checked_add(bytes).is_none_or(|end| end > buffer.size()) {
            let fault = format!("rows {rows:?} of mip {mip} do not fit the image or buffer {}", buffer.name());
            return Err(GpuError::usage(image.name(), fault));
        }
        self.keep(&buffer.inner);
        self.keep(&image.inner);
        let subresource = vk::ImageSubresourceLayers::default()
            .aspect_mask(image.aspect())
            .mip_level(mip)
            .base_array_layer(layer)
            .layer_count(1);
        Ok(vk::BufferImageCopy::default()
            .buffer_offset(offset)
            .image_subresource(subresource)
            .image_offset(vk::Offset3D { x: 0, y: rows.start.cast_signed(), z: 0 })
            .image_extent(vk::Extent3D { width, height: rows.len() as u32, depth: 1 }))
    }
}
