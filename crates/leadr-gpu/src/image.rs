//! 2D images and their views. An image can have mips, array layers or cube faces, and its current use is tracked.

use std::sync::{Arc, Mutex, PoisonError};

use ash::vk;
use gpu_allocator::MemoryLocation;
use gpu_allocator::vulkan::Allocation;

use super::buffer::allocate;
use super::error::Doing;
use super::{Gpu, GpuError, Result, Use};

/// The description of an image. Every image can be sampled, and can be the source and the target of copies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct ImageDesc {
    /// The texel format.
    pub format: vk::Format,
    /// The width of mip 0 in texels.
    pub width: u32,
    /// The height of mip 0 in texels.
    pub height: u32,
    /// The number of mip levels, at least 1.
    pub mips: u32,
    /// The number of array layers, which is 6 for a cube.
    pub layers: u32,
    /// Whether the six layers are the faces +x, -x, +y, -y, +z, -z of a cube.
    pub cube: bool,
    /// The number of samples per texel, either 1 or a value in [`Gpu::image_samples`].
    pub samples: u32,
    /// The further uses of the image: storage image, colour attachment or depth attachment.
    pub usage: vk::ImageUsageFlags,
}

impl ImageDesc {
    /// Describes an image with a single 2D layer and one mip.
    pub fn new(format: vk::Format, width: u32, height: u32) -> Self {
        let usage =
            vk::ImageUsageFlags::SAMPLED | vk::ImageUsageFlags::TRANSFER_SRC | vk::ImageUsageFlags::TRANSFER_DST;
        Self { format, width, height, mips: 1, layers: 1, cube: false, samples: 1, usage }
    }

    /// Sets the number of mips.
    pub fn mips(self, mips: u32) -> Self {
        Self { mips, ..self }
    }

    /// Gives the image all mips, down to one texel.
    pub fn full_mips(self) -> Self {
        Self { mips: u32::BITS - self.width.max(self.height).leading_zeros(), ..self }
    }

    /// Sets the number of array layers. The view of the image is then an array view, even with one layer.
    pub fn layers(self, layers: u32) -> Self {
        Self { layers, ..self }
    }

    /// Turns the image into a cube with square faces.
    pub fn cube(self) -> Self {
        Self { layers: 6, cube: true, ..self }
    }

    /// Sets the number of samples per texel, for attachments and `sampler2DMS`.
    pub fn samples(self, samples: u32) -> Self {
        Self { samples, ..self }
    }

    /// Allows use as a storage image.
    pub fn storage(self) -> Self {
        Self { usage: self.usage | vk::ImageUsageFlags::STORAGE, ..self }
    }

    /// Allows use as a colour attachment.
    pub fn color_target(self) -> Self {
        Self { usage: self.usage | vk::ImageUsageFlags::COLOR_ATTACHMENT, ..self }
    }

    /// Allows use as a depth attachment.
    pub fn depth_target(self) -> Self {
        Self { usage: self.usage | vk::ImageUsageFlags::DEPTH_STENCIL_ATTACHMENT, ..self }
    }
}

/// An image. Clones share the same image.
#[derive(Clone)]
pub struct Image {
    pub(crate) inner: Arc<ImageInner>,
    whole: ImageView,
}

pub(crate) struct ImageInner {
    pub(crate) gpu: Arc<Gpu>,
    pub(crate) raw: vk::Image,
    /// The memory of the image, or `None` for images with another owner, such as a swapchain.
    allocation: Option<Allocation>,
    owned: bool,
    name: String,
    desc: ImageDesc,
    /// The use of all mips and layers after the commands submitted so far.
    last_use: Mutex<Use>,
}

impl ImageInner {
    pub(crate) fn set_last_use(&self, last: Use) {
        *self.last_use.lock().unwrap_or_else(PoisonError::into_inner) = last;
    }
}

impl Drop for ImageInner {
    fn drop(&mut self) {
        if self.owned {
            // SAFETY: commands that use the image hold an Arc of it until they are done.
            unsafe { self.gpu.raw().destroy_image(self.raw, None) };
        }
        if let Some(allocation) = self.allocation.take() {
            let _ = self.gpu.allocator().free(allocation);
        }
    }
}

/// A view of some mips and layers of an image. A view keeps its image alive, and clones share the same view.
#[derive(Clone)]
pub struct ImageView {
    pub(crate) inner: Arc<ViewInner>,
}

pub(crate) struct ViewInner {
    pub(crate) image: Arc<ImageInner>,
    pub(crate) raw: vk::ImageView,
    width: u32,
    height: u32,
}

impl Drop for ViewInner {
    fn drop(&mut self) {
        // SAFETY: commands that use the view hold an Arc of it until they are done.
        unsafe { self.image.gpu.raw().destroy_image_view(self.raw, None) };
    }
}

impl ImageView {
    /// Returns the raw handle.
    pub fn raw(&self) -> vk::ImageView {
        self.inner.raw
    }

    /// Returns the width and height of the view's first mip, in texels.
    pub fn extent(&self) -> [u32; 2] {
        [self.inner.width, self.inner.height]
    }

    /// Returns the format of the image.
    pub fn format(&self) -> vk::Format {
        self.inner.image.desc.format
    }
}

impl Image {
    /// Creates an image in [`Use::Undefined`], with undefined content.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if the description is impossible on this device, or [`GpuError::Allocation`] if memory is short.
    pub fn new(gpu: &Arc<Gpu>, name: &str, desc: ImageDesc) -> Result<Self> {
        check(gpu, name, &desc)?;
        let flags = if desc.cube { vk::ImageCreateFlags::CUBE_COMPATIBLE } else { vk::ImageCreateFlags::empty() };
        let info = vk::ImageCreateInfo::default()
            .flags(flags)
            .image_type(vk::ImageType::TYPE_2D)
            .format(desc.format)
            .extent(vk::Extent3D { width: desc.width, height: desc.height, depth: 1 })
            .mip_levels(desc.mips)
            .array_layers(desc.layers)
            .samples(vk::SampleCountFlags::from_raw(desc.samples))
            .tiling(vk::ImageTiling::OPTIMAL)
            .usage(desc.usage);
        // SAFETY: the device is alive and the description was checked; `inner` destroys the image on failure.
        let raw = unsafe { gpu.raw().create_image(&info, None) }.doing(format!("creating image {name}"))?;
        gpu.name(raw, name);
        let mut inner = ImageInner {
            gpu: gpu.clone(),
            raw,
            allocation: None,
            owned: true,
            name: name.to_owned(),
            desc,
            last_use: Mutex::new(Use::Undefined),
        };
        // SAFETY: the image was made above, on this device.
        let requirements = unsafe { gpu.raw().get_image_memory_requirements(raw) };
        let allocation = allocate(gpu, name, requirements, MemoryLocation::GpuOnly, false)?;
        // SAFETY: the memory was made for this image and is not bound yet.
        let bound = unsafe { gpu.raw().bind_image_memory(raw, allocation.memory(), allocation.offset()) };
        inner.allocation = Some(allocation);
        bound.doing(format!("binding memory of image {name}"))?;
        Self::with_view(inner)
    }

    /// Wraps an image with another owner, such as a swapchain.
    ///
    /// # Safety
    /// `raw` must be an image of this device that matches `desc`. The image must stay alive until this object, its views and the
    /// commands that use them are gone.
    pub(crate) unsafe fn borrowed(gpu: &Arc<Gpu>, name: &str, raw: vk::Image, desc: ImageDesc) -> Result<Self> {
        gpu.name(raw, name);
        Self::with_view(ImageInner {
            gpu: gpu.clone(),
            raw,
            allocation: None,
            owned: false,
            name: name.to_owned(),
            desc,
            last_use: Mutex::new(Use::Undefined),
        })
    }

    fn with_view(inner: ImageInner) -> Result<Self> {
        let inner = Arc::new(inner);
        let desc = inner.desc;
        let kind = match (desc.cube, desc.layers) {
            (true, _) => vk::ImageViewType::CUBE,
            (false, 1) => vk::ImageViewType::TYPE_2D,
            (false, _) => vk::ImageViewType::TYPE_2D_ARRAY,
        };
        let whole = view(&inner, kind, 0..desc.mips, 0..desc.layers)?;
        Ok(Self { inner, whole })
    }

    /// Returns the view of all mips and layers as a 2D image, a 2D array or a cube.
    pub fn whole(&self) -> &ImageView {
        &self.whole
    }

    /// Creates a 2D view of one mip of one layer, for attachments and `image2D`.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if the mip or layer does not exist.
    pub fn mip_layer(&self, mip: u32, layer: u32) -> Result<ImageView> {
        self.check_mip_layer(mip, layer)?;
        view(&self.inner, vk::ImageViewType::TYPE_2D, mip..mip + 1, layer..layer + 1)
    }

    /// Creates a 2D array view of one mip of all layers or cube faces, for `image2DArray`.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if the mip does not exist.
    pub fn mip_array(&self, mip: u32) -> Result<ImageView> {
        self.check_mip_layer(mip, 0)?;
        view(&self.inner, vk::ImageViewType::TYPE_2D_ARRAY, mip..mip + 1, 0..self.inner.desc.layers)
    }

    /// Creates a view of one mip of a cube, for `samplerCube`.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if the mip does not exist, or if the image is not a cube.
    pub fn mip_cube(&self, mip: u32) -> Result<ImageView> {
        self.check_mip_layer(mip, 0)?;
        if !self.inner.desc.cube {
            return Err(GpuError::usage(self.name(), "it is not a cube, so it has no cube view of a mip".to_owned()));
        }
        view(&self.inner, vk::ImageViewType::CUBE, mip..mip + 1, 0..self.inner.desc.layers)
    }

    /// Creates a 2D array view of all mips and layers, so that `sampler2DArray` can also read a single layer or a cube.
    pub fn array(&self) -> Result<ImageView> {
        view(&self.inner, vk::ImageViewType::TYPE_2D_ARRAY, 0..self.inner.desc.mips, 0..self.inner.desc.layers)
    }

    /// Returns the description of the image.
    pub fn desc(&self) -> &ImageDesc {
        &self.inner.desc
    }

    /// Returns the width and height of a mip in texels.
    pub fn mip_extent(&self, mip: u32) -> [u32; 2] {
        let size = |texels: u32| texels.checked_shr(mip).unwrap_or(0).max(1);
        [size(self.inner.desc.width), size(self.inner.desc.height)]
    }

    /// Returns the size of a texel in bytes.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] for formats that the renderer does not transfer.
    pub fn texel_bytes(&self) -> Result<u64> {
        texel_bytes(self.inner.desc.format).ok_or_else(|| {
            GpuError::usage(self.name(), format!("copies of format {:?} are not supported", self.inner.desc.format))
        })
    }

    /// Returns the debug name.
    pub fn name(&self) -> &str {
        &self.inner.name
    }

    /// Returns the raw handle.
    pub fn raw(&self) -> vk::Image {
        self.inner.raw
    }

    /// Returns the use of the whole image after the commands submitted so far. Barriers for single mips do not change this use.
    pub(crate) fn last_use(&self) -> Use {
        *self.inner.last_use.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn gpu(&self) -> &Arc<Gpu> {
        &self.inner.gpu
    }

    pub(crate) fn aspect(&self) -> vk::ImageAspectFlags {
        aspect(self.inner.desc.format)
    }

    pub(crate) fn check_mip_layer(&self, mip: u32, layer: u32) -> Result<()> {
        let desc = &self.inner.desc;
        if mip < desc.mips && layer < desc.layers {
            return Ok(());
        }
        Err(GpuError::usage(
            self.name(),
            format!("mip {mip} of layer {layer} is not among its {} mips and {} layers", desc.mips, desc.layers),
        ))
    }
}

fn check(gpu: &Gpu, name: &str, desc: &ImageDesc) -> Result<()> {
    let ImageDesc { format, width, height, mips, layers, cube, samples, usage } = *desc;
    let most = gpu.limits().max_image_dimension2_d;
    if width == 0 || height == 0 || width > most || height > most {
        return Err(GpuError::usage(name, format!("{width}x{height} texels are not between 1x1 and {most}x{most}")));
    }
    if mips == 0 || mips > desc.full_mips().mips {
        return Err(GpuError::usage(name, format!("{width}x{height} texels cannot have {mips} mips")));
    }
    if layers == 0 || layers > gpu.limits().max_image_array_layers {
        return Err(GpuError::usage(name, format!("{layers} array layers are not supported")));
    }
    if cube && (width != height || layers != 6) {
        return Err(GpuError::usage(name, format!("a cube has 6 square faces, not {layers} of {width}x{height}")));
    }
    let possible = gpu.image_samples(format, usage);
    if possible == 0 {
        return Err(GpuError::usage(name, format!("{} has no {format:?} images for {usage:?}", gpu.device_name())));
    }
    if possible & samples == 0 || !samples.is_power_of_two() {
        let fault = format!("{} has no {format:?} images with {samples} samples for {usage:?}", gpu.device_name());
        return Err(GpuError::usage(name, fault));
    }
    Ok(())
}

fn view(
    image: &Arc<ImageInner>,
    kind: vk::ImageViewType,
    mips: std::ops::Range<u32>,
    layers: std::ops::Range<u32>,
) -> Result<ImageView> {
    let range = vk::ImageSubresourceRange::default()
        .aspect_mask(aspect(image.desc.format))
        .base_mip_level(mips.start)
        .level_count(mips.end - mips.start)
        .base_array_layer(layers.start)
        .layer_count(layers.end - layers.start);
    let info = vk::ImageViewCreateInfo::default()
        .image(image.raw)
        .view_type(kind)
        .format(image.desc.format)
        .subresource_range(range);
    // SAFETY: callers checked the range against the image, and the view keeps the image alive.
    let raw = unsafe { image.gpu.raw().create_image_view(&info, None) }
        .doing(format!("creating a view of image {}", image.name))?;
    image.gpu.name(raw, &format!("{} mips {mips:?} layers {layers:?}", image.name));
    let size = |texels: u32| (texels >> mips.start).max(1);
    let (width, height) = (size(image.desc.width), size(image.desc.height));
    Ok(ImageView { inner: Arc::new(ViewInner { image: image.clone(), raw, width, height }) })
}

/// Returns the image aspect of a format. No depth format of the renderer has a stencil.
fn aspect(format: vk::Format) -> vk::ImageAspectFlags {
    match format {
        vk::Format::D32_SFLOAT | vk::Format::D16_UNORM | vk::Format::X8_D24_UNORM_PACK32 => vk::ImageAspectFlags::DEPTH,
        _ => vk::ImageAspectFlags::COLOR,
    }
}

fn texel_bytes(format: vk::Format) -> Option<u64> {
    use vk::Format as F;
    Some(match format {
        F::R8_UNORM | F::R8_SNORM | F::R8_UINT => 1,
        F::R8G8_UNORM | F::R8G8_SNORM | F::R16_UNORM | F::R16_SNORM | F::R16_SFLOAT | F::R16_UINT | F::D16_UNORM => 2,
        F::R8G8B8A8_UNORM
        | F::R8G8B8A8_SNORM
        | F::R8G8B8A8_SRGB
        | F::B8G8R8A8_UNORM
        | F::B8G8R8A8_SRGB
        | F::A2B10G10R10_UNORM_PACK32
        | F::B10G11R11_UFLOAT_PACK32
        | F::R16G16_UNORM
        | F::R16G16_SNORM
        | F::R16G16_SFLOAT
        | F::R32_UINT
        | F::R32_SINT
        | F::R32_SFLOAT
        | F::D32_SFLOAT => 4,
        F::R16G16B16A16_UNORM | F::R16G16B16A16_SNORM | F::R16G16B16A16_SFLOAT | F::R32G32_SFLOAT | F::R32G32_UINT => 8,
        F::R32G32B32A32_SFLOAT | F::R32G32B32A32_UINT => 16,
        _ => return None,
    })
}
