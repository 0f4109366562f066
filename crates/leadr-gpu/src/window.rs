//! The swapchain of a window. Its functions take raw handles, so they work with any window library.
//!
//! There are [`FRAMES_IN_FLIGHT`] frames, so the CPU prepares one frame while the device draws the other.

use std::any::Any;
use std::ffi::CStr;
use std::sync::Arc;

use ash::vk;
use raw_window_handle::{HasDisplayHandle, HasWindowHandle};

use super::error::Doing;
use super::{CommandRecorder, Gpu, GpuError, Image, ImageDesc, Result};

/// Returns the instance extensions for windows on a display, for [`GpuOptions::window_extensions`](super::GpuOptions).
///
/// # Errors
/// Returns [`GpuError::Usage`] for displays that Vulkan cannot present to.
pub fn window_extensions(display: &impl HasDisplayHandle) -> Result<Vec<&'static CStr>> {
    let handle = display.display_handle().map_err(|e| GpuError::usage("display", e.to_string()))?;
    let pointers = ash_window::enumerate_required_extensions(handle.as_raw())
        .map_err(|_| GpuError::usage("display", "Vulkan does not support this kind of display"))?;
    // SAFETY: ash-window returns its own static, terminated names.
    Ok(pointers.iter().map(|&name| unsafe { CStr::from_ptr(name) }).collect())
}

/// The maximum number of frames in flight.
pub const FRAMES_IN_FLIGHT: usize = 2;

/// The surface of a window, which keeps the window open.
struct Surface {
    functions: ash::khr::surface::Instance,
    raw: vk::SurfaceKHR,
    // The window is dropped last, because the surface refers to it.
    _window: Arc<dyn Any>,
    gpu: Arc<Gpu>,
}

impl Drop for Surface {
    fn drop(&mut self) {
        // SAFETY: the swapchain, the only child of the surface, is destroyed.
        unsafe { self.functions.destroy_surface(self.raw, None) };
    }
}

/// The images of a window, which are recreated when the window's size changes.
pub struct Swapchain {
    functions: ash::khr::swapchain::Device,
    raw: vk::SwapchainKHR,
    images: Vec<Image>,
    /// One semaphore per image. The semaphore of an image is free again when the image is acquired again.
    presentable: Vec<vk::Semaphore>,
    /// One semaphore per frame in flight.
    acquired: [vk::Semaphore; FRAMES_IN_FLIGHT],
    presented: usize,
    /// Whether an image was acquired but not presented yet. The semaphore of the next frame is then signalled.
    handed_out: bool,
    format: vk::SurfaceFormatKHR,
    wanted: [u32; 2],
    stale: bool,
    surface: Surface,
}

/// An image to draw into and then pass to [`Swapchain::present`].
pub struct SwapchainFrame {
    /// The image, with undefined content. The commands must leave it in [`Use::Present`](super::Use::Present).
    pub image: Image,
    index: u32,
}

impl Swapchain {
    /// Creates a swapchain for a window. The device must have been opened with the display's [`window_extensions`].
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] if the device cannot present to this window.
    pub fn new<W: HasDisplayHandle + HasWindowHandle + 'static>(gpu: &Arc<Gpu>, window: Arc<W>) -> Result<Self> {
        let (entry, instance, physical) = gpu.raw_instance();
        let unusable = |e: raw_window_handle::HandleError| GpuError::usage("window", e.to_string());
        let display = window.display_handle().map_err(unusable)?.as_raw();
        let handle = window.window_handle().map_err(unusable)?.as_raw();
        // SAFETY: both handles belong to `window`, which the surface keeps open.
        let raw = unsafe { ash_window::create_surface(entry, instance, display, handle, None) }
            .doing("creating the window's surface")?;
        let functions = ash::khr::surface::Instance::new(entry, instance);
        let surface = Surface { functions, raw, _window: window, gpu: gpu.clone() };
        // SAFETY: the surface and the device are alive.
        let supported =
            unsafe { surface.functions.get_physical_device_surface_support(physical, gpu.queue_family(), raw) }
                .doing("querying whether the device can present")?;
        if !supported {
            let fault = format!("{} cannot present to this display: choose another device", gpu.device_name());
            return Err(GpuError::usage("window", fault));
        }
        // SAFETY: the surface and the device are alive.
        let formats = unsafe { surface.functions.get_physical_device_surface_formats(physical, raw) }
            .doing("listing the surface's formats")?;
        let format =
            choose_format(&formats).ok_or_else(|| GpuError::usage("window", "its surface has no 8-bit sRGB format"))?;
        let mut swapchain = Self {
            functions: ash::khr::swapchain::Device::new(instance, gpu.raw()),
            raw: vk::SwapchainKHR::null(),
            images: Vec::new(),
            presentable: Vec::new(),
            acquired: [vk::Semaphore::null(); FRAMES_IN_FLIGHT],
            presented: 0,
            handed_out: false,
            format,
            wanted: [0, 0],
            stale: true,
            surface,
        };
        for i in 0..FRAMES_IN_FLIGHT {
            swapchain.acquired[i] = swapchain.semaphore(&format!("acquired {i}"))?;
        }
        Ok(swapchain)
    }

    /// Returns the format of the images, which is `B8G8R8A8` or `R8G8B8A8` and is displayed as sRGB. `UNORM` formats store the
    /// drawn codes unchanged, and `SRGB` formats encode the drawn values.
    pub fn format(&self) -> vk::Format {
        self.format.format
    }

    /// Waits for the next image of a window of `size` pixels. Returns `None` if the window has no area or changed during the call.
    /// Try again at the next event.
    ///
    /// The commands of all earlier frames except the last [`FRAMES_IN_FLIGHT`]` - 1` must be done.
    ///
    /// # Errors
    /// Returns [`GpuError::Usage`] after a frame that was not presented. A lost device or surface and a memory shortage are also
    /// errors.
    pub fn acquire(&mut self, size: [u32; 2]) -> Result<Option<SwapchainFrame>> {
        if self.handed_out {
            return Err(GpuError::usage("window", "the last acquired image was not presented: open the window again"));
        }
        // A window may be resized faster than swapchains can be created. The caller then waits for its next event.
        for _ in 0..3 {
            if (self.stale || self.wanted != size) && !self.recreate(size)? {
                return Ok(None);
            }
            let timeout = 1_000_000_000;
            let acquired = self.acquired();
            // SAFETY: the semaphore is unsignalled, because its last frame was presented and the commands that waited for it are
            // done.
            let result = unsafe { self.functions.acquire_next_image(self.raw, timeout, acquired, vk::Fence::null()) };
            match result {
                Ok((index, suboptimal)) => {
                    // The acquired image must be drawn and presented before the swapchain is recreated.
                    self.stale = suboptimal;
                    self.handed_out = true;
                    return Ok(Some(SwapchainFrame { image: self.images[index as usize].clone(), index }));
                }
                Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => self.stale = true,
                // A compositor provides no images for a hidden window.
                Err(vk::Result::TIMEOUT | vk::Result::NOT_READY) => return Ok(None),
                Err(result) => return Err(result).doing("acquiring an image of the window"),
            }
        }
        Ok(None)
    }

    /// Submits the commands of `recorder` for this frame, and presents the image after the commands are done. The call does not
    /// wait.
    ///
    /// # Errors
    /// Returns an error for a lost device or surface.
    pub fn present(&mut self, recorder: &mut CommandRecorder, frame: SwapchainFrame) -> Result<()> {
        let presentable = self.presentable[frame.index as usize];
        recorder.submit(
            &[(self.acquired(), vk::PipelineStageFlags2::COLOR_ATTACHMENT_OUTPUT)],
            &[(presentable, vk::PipelineStageFlags2::ALL_COMMANDS)],
        )?;
        self.presented += 1;
        self.handed_out = false;
        let (semaphores, swapchains, indices) = ([presentable], [self.raw], [frame.index]);
        let info =
            vk::PresentInfoKHR::default().wait_semaphores(&semaphores).swapchains(&swapchains).image_indices(&indices);
        let queue = self.surface.gpu.queue();
        // SAFETY: the image was acquired, and the semaphore's signal was submitted.
        match unsafe { self.functions.queue_present(*queue, &info) } {
            Ok(suboptimal) => self.stale |= suboptimal,
            Err(vk::Result::ERROR_OUT_OF_DATE_KHR) => self.stale = true,
            Err(result) => return Err(result).doing("presenting an image"),
        }
        Ok(())
    }

    /// Recreates the images. Returns false if the window has no area.
    fn recreate(&mut self, size: [u32; 2]) -> Result<bool> {
        let gpu = self.surface.gpu.clone();
        let (_, _, physical) = gpu.raw_instance();
        let surface = &self.surface;
        // SAFETY: the surface and the device are alive.
        let capabilities = unsafe { surface.functions.get_physical_device_surface_capabilities(physical, surface.raw) }
            .doing("querying the surface's size")?;
        let Some([width, height]) = extent(&capabilities, size) else { return Ok(false) };
        let usage = vk::ImageUsageFlags::COLOR_ATTACHMENT;
        let most = if capabilities.max_image_count == 0 { u32::MAX } else { capabilities.max_image_count };
        let alpha = [vk::CompositeAlphaFlagsKHR::OPAQUE, vk::CompositeAlphaFlagsKHR::INHERIT];
        let alpha = alpha.into_iter().find(|&a| capabilities.supported_composite_alpha.contains(a));
        // FIFO is always available, never tears, and lets the GPU idle between refreshes.
        let info = vk::SwapchainCreateInfoKHR::default()
            .surface(surface.raw)
            .min_image_count((capabilities.min_image_count + 1).min(most))
            .image_format(self.format.format)
            .image_color_space(self.format.color_space)
            .image_extent(vk::Extent2D { width, height })
            .image_array_layers(1)
            .image_usage(usage)
            .pre_transform(capabilities.current_transform)
            .composite_alpha(alpha.unwrap_or(vk::CompositeAlphaFlagsKHR::OPAQUE))
            .present_mode(vk::PresentModeKHR::FIFO)
            .clipped(true)
            .old_swapchain(self.raw);
        // SAFETY: the surface is alive and supports the requested properties; the old swapchain belongs to it or is null.
        let new = unsafe { self.functions.create_swapchain(&info, None) }.doing("creating the swapchain")?;
        // The old swapchain is retired even if a later step fails. Only an idle queue guarantees that presentation no longer uses
        // the swapchain's semaphores.
        if let Err(error) = gpu.wait_idle() {
            // SAFETY: the new swapchain was made above, and nothing has used it. The old one stays for `drop`.
            unsafe { self.functions.destroy_swapchain(new, None) };
            return Err(error);
        }
        self.retire();
        self.raw = new;
        // SAFETY: the swapchain was made above.
        let raw_images = unsafe { self.functions.get_swapchain_images(new) }.doing("listing the swapchain's images")?;
        let desc = ImageDesc { usage, ..ImageDesc::new(self.format.format, width, height) };
        for (i, raw) in raw_images.into_iter().enumerate() {
            // SAFETY: the image belongs to the new swapchain. `retire` releases the images, with the device idle, before it
            // destroys the swapchain, and frames that were handed out refer to images that are no longer displayed.
            self.images.push(unsafe { Image::borrowed(&gpu, &format!("window image {i}"), raw, desc) }?);
            let semaphore = self.semaphore(&format!("presentable {i}"))?;
            self.presentable.push(semaphore);
        }
        self.wanted = size;
        self.stale = false;
        Ok(true)
    }

    fn acquired(&self) -> vk::Semaphore {
        self.acquired[self.presented % FRAMES_IN_FLIGHT]
    }

    fn semaphore(&self, name: &str) -> Result<vk::Semaphore> {
        let gpu = &self.surface.gpu;
        // SAFETY: the device is alive; `retire` or dropping the swapchain destroys the semaphore.
        let semaphore = unsafe { gpu.raw().create_semaphore(&vk::SemaphoreCreateInfo::default(), None) }
            .doing("creating a semaphore")?;
        gpu.name(semaphore, name);
        Ok(semaphore)
    }

    /// Releases the images. The device must be idle.
    fn retire(&mut self) {
        self.images.clear();
        // SAFETY: the device is idle; null handles are ignored.
        unsafe {
            for semaphore in self.presentable.drain(..) {
                self.surface.gpu.raw().destroy_semaphore(semaphore, None);
            }
            self.functions.destroy_swapchain(self.raw, None);
        }
        self.raw = vk::SwapchainKHR::null();
    }
}

impl Drop for Swapchain {
    fn drop(&mut self) {
        let _ = self.surface.gpu.wait_idle();
        self.retire();
        for acquired in self.acquired {
            // SAFETY: the device is idle, and the surface outlives its swapchain.
            unsafe { self.surface.gpu.raw().destroy_semaphore(acquired, None) };
        }
    }
}

/// Chooses an 8-bit sRGB format, preferably one that the shader encodes. The window then shows exactly the codes of a PNG.
fn choose_format(formats: &[vk::SurfaceFormatKHR]) -> Option<vk::SurfaceFormatKHR> {
    use vk::Format as F;
    let wanted = [F::B8G8R8A8_UNORM, F::R8G8B8A8_UNORM, F::B8G8R8A8_SRGB, F::R8G8B8A8_SRGB];
    wanted.into_iter().find_map(|format| {
        let fits = |f: &&vk::SurfaceFormatKHR| f.format == format && f.color_space == vk::ColorSpaceKHR::SRGB_NONLINEAR;
        formats.iter().find(fits).copied()
    })
}

/// Returns the size of the images, which is the surface's size, or the window's size if the surface adapts to the images.
fn extent(capabilities: &vk::SurfaceCapabilitiesKHR, size: [u32; 2]) -> Option<[u32; 2]> {
    let vk::Extent2D { width, height } = capabilities.current_extent;
    let (least, most) = (capabilities.min_image_extent, capabilities.max_image_extent);
    let follows = width == u32::MAX && height == u32::MAX;
    if size.contains(&0) || (!follows && (width == 0 || height == 0)) || most.width == 0 || most.height == 0 {
        return None;
    }
    let [width, height] = if follows { size } else { [width, height] };
    Some([
        width.clamp(least.width.min(most.width), most.width),
        height.clamp(least.height.min(most.height), most.height),
    ])
}

#[cfg(test)]
mod tests {
    use super::*;

    fn capabilities(current: [u32; 2]) -> vk::SurfaceCapabilitiesKHR {
        let extent = |[width, height]: [u32; 2]| vk::Extent2D { width, height };
        vk::SurfaceCapabilitiesKHR::default()
            .current_extent(extent(current))
            .min_image_extent(extent([1, 1]))
            .max_image_extent(extent([4096, 2048]))
    }

    #[test]
    fn a_window_without_area_has_no_images() {
        assert_eq!(extent(&capabilities([640, 360]), [0, 0]), None);
        assert_eq!(extent(&capabilities([640, 360]), [640, 0]), None);
        assert_eq!(extent(&capabilities([0, 0]), [640, 360]), None);
    }

    #[test]
    fn the_surface_decides_the_size_unless_it_follows() {
        assert_eq!(extent(&capabilities([640, 360]), [800, 600]), Some([640, 360]));
        assert_eq!(extent(&capabilities([u32::MAX; 2]), [800, 600]), Some([800, 600]));
        assert_eq!(extent(&capabilities([u32::MAX; 2]), [9000, 9000]), Some([4096, 2048]));
    }

    #[test]
    fn format_stores_codes_unchanged_if_possible() {
        let format = |format, color_space| vk::SurfaceFormatKHR { format, color_space };
        let srgb = vk::ColorSpaceKHR::SRGB_NONLINEAR;
        let other = vk::ColorSpaceKHR::HDR10_ST2084_EXT;
        let (encoded, plain) = (vk::Format::B8G8R8A8_SRGB, vk::Format::B8G8R8A8_UNORM);
        let both = [format(plain, other), format(encoded, srgb), format(plain, srgb)];
        assert_eq!(choose_format(&both), Some(both[2]));
        assert_eq!(choose_format(&both[..2]), Some(both[1]));
        assert_eq!(choose_format(&both[..1]), None);
    }
}
