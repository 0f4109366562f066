//! Owns the instance, the device, the queue and the allocator, and destroys them in the right order.

use std::ffi::{CStr, CString};
use std::mem::ManuallyDrop;
use std::sync::{Arc, Mutex, MutexGuard, PoisonError, Weak};

use ash::vk;
use gpu_allocator::vulkan::{Allocator, AllocatorCreateDesc};
use gpu_allocator::{AllocationSizes, AllocatorDebugSettings};

use super::error::Doing;
use super::faults::Faults;
use super::pipeline_handles::KnownPipelines;
use super::reload::Remake;
use super::sampler::Samplers;
use super::sets::{SetLayout, SetLayouts};
use super::shaders::{Shader, Shaders};
use super::{DriverCall, GpuError, Result, select, validation};

/// Options for opening the device.
#[derive(Clone, Debug, Default)]
pub struct GpuOptions {
    /// An index into the list of devices, or a part of a device's name, ignoring case. `None` prefers a discrete GPU.
    pub device: Option<String>,
    /// Whether to enable the validation layer with core and synchronization checks; see [`Gpu::validation_messages`].
    pub validation: bool,
    /// The instance extensions that a window needs, `VK_KHR_surface` and the platform's own. If there are any, `VK_KHR_swapchain`
    /// is enabled too.
    pub window_extensions: Vec<&'static CStr>,
    /// The tables of the available shaders, each sorted by name.
    pub shaders: Vec<&'static [Shader]>,
    /// The layouts of the longer-lived descriptor sets.
    pub sets: Vec<&'static SetLayout>,
}

/// An open Vulkan device. Every resource holds a reference to it, so it is destroyed last.
pub struct Gpu {
    // `Drop` destroys the members in this order: allocator, pipelines, set layouts, pipeline cache, device, messenger, instance.
    allocator: ManuallyDrop<Arc<Mutex<Allocator>>>,
    pipeline_cache: vk::PipelineCache,
    queue: Mutex<vk::Queue>,
    queue_family: u32,
    pub(super) push_descriptor: ash::khr::push_descriptor::Device,
    pub(super) debug: Option<ash::ext::debug_utils::Device>,
    labels: Mutex<()>,
    /// The recipes from which the existing pipelines can be re-created.
    pub(super) recipes: Mutex<Vec<Weak<dyn Remake>>>,
    pipelines: KnownPipelines,
    shaders: Shaders,
    set_layouts: SetLayouts,
    samplers: Samplers,
    faults: Faults,
    device: ash::Device,
    messenger: Option<(ash::ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    messages: Box<validation::Messages>,
    physical: vk::PhysicalDevice,
    instance: ash::Instance,
    entry: ash::Entry,
    facts: Facts,
}

/// Device properties that are queried more than once.
struct Facts {
    name: String,
    driver: String,
    driver_id: vk::DriverId,
    limits: vk::PhysicalDeviceLimits,
    kind: vk::PhysicalDeviceType,
    largest_allocation: u64,
    push_descriptors: u32,
    wires: bool,
}

/// The objects created so far, which are destroyed in order if a later step fails.
struct Unfinished {
    instance: Option<ash::Instance>,
    messenger: Option<(ash::ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    device: Option<ash::Device>,
}

impl Drop for Unfinished {
    fn drop(&mut self) {
        // SAFETY: each object is destroyed once, children before parents; nothing was submitted yet.
        unsafe {
            if let Some(device) = self.device.take() {
                device.destroy_device(None);
            }
            if let Some((functions, messenger)) = self.messenger.take() {
                functions.destroy_debug_utils_messenger(messenger, None);
            }
            if let Some(instance) = self.instance.take() {
                instance.destroy_instance(None);
            }
        }
    }
}

impl Gpu {
    /// Opens a device.
    ///
    /// # Errors
    /// Returns [`GpuError::NoLoader`], [`GpuError::NoDriver`], [`GpuError::NoSuitableDevice`], [`GpuError::UnknownDevice`],
    /// [`GpuError::MissingFeatures`], [`GpuError::NoValidationLayer`], [`GpuError::NoInstanceExtension`], or an error for a failed
    /// Vulkan call.
    pub fn new(options: &GpuOptions) -> Result<Arc<Self>> {
        // SAFETY: loading a library runs its initialisers, and the initialisers of the system's Vulkan loader are safe to run.
        let entry = unsafe { ash::Entry::load() }.map_err(|e| GpuError::NoLoader(e.to_string()))?;
        let messages: Box<validation::Messages> = Box::default();
        let mut unfinished = Unfinished { instance: None, messenger: None, device: None };

        let (instance, has_debug_utils) = create_instance(&entry, options, &messages)?;
        unfinished.instance = Some(instance.clone());
        if options.validation {
            let functions = ash::ext::debug_utils::Instance::new(&entry, &instance);
            // SAFETY: `messages` is boxed and moves into the Gpu, which destroys the messenger before the messages.
            let messenger =
                unsafe { functions.create_debug_utils_messenger(&validation::messenger_info(&messages), None) }
                    .doing("creating the validation messenger")?;
            unfinished.messenger = Some((functions, messenger));
        }

        let mut extensions = vec![ash::khr::push_descriptor::NAME];
        if !options.window_extensions.is_empty() {
            extensions.push(ash::khr::swapchain::NAME);
        }
        let chosen = select::choose(&instance, options.device.as_deref(), &extensions)?;
        let device = create_device(&instance, &chosen, &extensions)?;
        unfinished.device = Some(device.clone());

        // SAFETY: the queue family and the queue index were requested when the device was created.
        let queue = unsafe { device.get_device_queue(chosen.queue_family, 0) };
        let allocator = Allocator::new(&AllocatorCreateDesc {
            instance: instance.clone(),
            device: device.clone(),
            physical_device: chosen.physical,
            debug_settings: AllocatorDebugSettings::default(),
            buffer_device_address: false,
            // The memory blocks are small because lavapipe's heap of 2 GiB is shared by several tests. Larger resources get
            // dedicated memory.
            allocation_sizes: AllocationSizes::new(32 << 20, 16 << 20),
        })
        .map_err(GpuError::Allocator)?;
        // SAFETY: the device is alive.
        let pipeline_cache = unsafe { device.create_pipeline_cache(&vk::PipelineCacheCreateInfo::default(), None) }
            .doing("creating the pipeline cache")?;

        let debug = has_debug_utils.then(|| ash::ext::debug_utils::Device::new(&instance, &device));
        let facts = facts(&instance, &chosen);
        tracing::info!("{} ({})", facts.name, facts.driver);
        unfinished.instance = None;
        unfinished.device = None;
        Ok(Arc::new(Self {
            allocator: ManuallyDrop::new(Arc::new(Mutex::new(allocator))),
            pipeline_cache,
            queue: Mutex::new(queue),
            queue_family: chosen.queue_family,
            push_descriptor: ash::khr::push_descriptor::Device::new(&instance, &device),
            debug,
            labels: Mutex::new(()),
            recipes: Mutex::default(),
            pipelines: KnownPipelines::default(),
            shaders: Shaders::new(options.shaders.clone()),
            set_layouts: SetLayouts::new(options.sets.clone()),
            samplers: Samplers::default(),
            faults: Faults::wanted(),
            device,
            messenger: unfinished.messenger.take(),
            messages,
            physical: chosen.physical,
            instance,
            entry,
            facts,
        }))
    }

    /// Waits until the device has finished all its work.
    pub fn wait_idle(&self) -> Result<()> {
        let _queue = self.queue();
        // SAFETY: the queue is locked, because device_wait_idle requires exclusive access to all queues.
        let done = unsafe { self.device.device_wait_idle() };
        done.and_then(|()| self.faults.check(DriverCall::Wait)).doing("waiting for the device")
    }

    /// Returns the device's name, such as "llvmpipe (LLVM 15.0.6, 256 bits)".
    pub fn device_name(&self) -> &str {
        &self.facts.name
    }

    /// Returns the driver's name and version, such as "llvmpipe Mesa 22.3.6 (LLVM 15.0.6)".
    pub fn driver_info(&self) -> &str {
        &self.facts.driver
    }

    /// Whether the driver is Mesa's lavapipe.
    pub fn is_lavapipe(&self) -> bool {
        self.facts.driver_id == vk::DriverId::MESA_LLVMPIPE
    }

    /// Whether the device can draw triangles as wireframes.
    pub(crate) fn draws_wires(&self) -> bool {
        self.facts.wires
    }

    /// Returns the largest number of tessellated vertices per draw, if the driver has such a limit. Beyond 65,536 vertices,
    /// lavapipe silently draws wrong geometry. A patch with tessellation level l has at most (ceil_even(l) + 1)² vertices.
    #[doc(hidden)]
    pub fn tessellated_vertices_per_draw(&self) -> Option<u32> {
        self.is_lavapipe().then_some(65_535)
    }

    /// Returns the largest total number of loop iterations per shader invocation, if the driver has such a limit. Beyond 65,535
    /// iterations, lavapipe silently ends loops early.
    #[doc(hidden)]
    pub fn loop_iterations_per_invocation(&self) -> Option<u32> {
        self.is_lavapipe().then_some(65_535)
    }

    /// Whether the driver renders on the CPU, in system memory.
    pub fn is_software(&self) -> bool {
        self.facts.kind == vk::PhysicalDeviceType::CPU
    }

    /// Returns the size of the device's largest single allocation in bytes.
    pub(super) fn largest_allocation(&self) -> u64 {
        self.facts.largest_allocation
    }

    /// Returns the device's Vulkan limits.
    #[doc(hidden)]
    pub fn limits(&self) -> &vk::PhysicalDeviceLimits {
        &self.facts.limits
    }

    /// Returns a bit mask of the supported numbers of samples per texel, which are powers of two, for images of this format and
    /// usage with optimal tiling. The mask is 0 if there are none.
    #[doc(hidden)]
    pub fn image_samples(&self, format: vk::Format, usage: vk::ImageUsageFlags) -> u32 {
        // SAFETY: the instance and physical device are alive.
        let properties = unsafe {
            self.instance.get_physical_device_image_format_properties(
                self.physical,
                format,
                vk::ImageType::TYPE_2D,
                vk::ImageTiling::OPTIMAL,
                usage,
                vk::ImageCreateFlags::empty(),
            )
        };
        properties.map_or(0, |properties| properties.sample_counts.as_raw())
    }

    /// Returns the warnings and errors that the validation layer has reported so far. The list is always empty without
    /// [`GpuOptions::validation`].
    pub fn validation_messages(&self) -> Vec<String> {
        self.messages.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    /// Removes and returns the validation messages, for tests that provoke them.
    pub fn take_validation_messages(&self) -> Vec<String> {
        std::mem::take(&mut self.messages.lock().unwrap_or_else(PoisonError::into_inner))
    }

    /// Returns the raw device, for calls that this module does not wrap.
    #[doc(hidden)]
    pub fn raw(&self) -> &ash::Device {
        &self.device
    }

    /// Returns the raw loader, instance and physical device, for the window.
    #[doc(hidden)]
    pub fn raw_instance(&self) -> (&ash::Entry, &ash::Instance, vk::PhysicalDevice) {
        (&self.entry, &self.instance, self.physical)
    }

    /// Returns the queue family index of the device's only queue.
    #[doc(hidden)]
    pub fn queue_family(&self) -> u32 {
        self.queue_family
    }

    /// Locks the device's only queue, because Vulkan requires serialised access to it.
    #[doc(hidden)]
    pub fn queue(&self) -> MutexGuard<'_, vk::Queue> {
        self.queue.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Returns the allocator, for code that creates its own buffers and images. The allocator must be dropped before the device.
    pub fn shared_allocator(&self) -> Arc<Mutex<Allocator>> {
        Arc::clone(&self.allocator)
    }

    /// Returns the names of all entry points in the device's tables.
    pub fn shader_names(&self) -> impl Iterator<Item = &'static str> {
        self.shaders.names()
    }

    pub(super) fn shaders(&self) -> &Shaders {
        &self.shaders
    }

    pub(super) fn samplers(&self) -> &Samplers {
        &self.samplers
    }

    pub(super) fn set_layouts(&self) -> &SetLayouts {
        &self.set_layouts
    }

    pub(super) fn faults(&self) -> &Faults {
        &self.faults
    }

    /// Returns the number of driver calls of this kind so far.
    #[doc(hidden)]
    pub fn calls(&self, call: DriverCall) -> u32 {
        self.faults.made(call)
    }

    /// Makes a driver call of this kind fail, after `calls` further ones.
    #[doc(hidden)]
    pub fn fail_after(&self, calls: u32, call: DriverCall) {
        self.faults.fail(call, self.faults.made(call) + calls + 1);
    }

    pub(crate) fn allocator(&self) -> MutexGuard<'_, Allocator> {
        self.allocator.lock().unwrap_or_else(PoisonError::into_inner)
    }

    pub(crate) fn known_pipelines(&self) -> &KnownPipelines {
        &self.pipelines
    }

    pub(crate) fn pipeline_cache(&self) -> vk::PipelineCache {
        self.pipeline_cache
    }

    /// Returns the largest number of push descriptors that a pipeline may have.
    pub(crate) fn most_resources(&self) -> usize {
        self.facts.push_descriptors as usize
    }

    /// Returns a lock that must be held while the labels of any command buffer change. Labels change where they begin and end, and
    /// when a command buffer is created, reset or destroyed. The validation layer of Debian 12 keeps the labels of all command
    /// buffers in one table, and modifies the table without a lock. Without this lock, threads that record different buffers would
    /// crash in the layer.
    pub(crate) fn lock_labels(&self) -> MutexGuard<'_, ()> {
        self.labels.lock().unwrap_or_else(PoisonError::into_inner)
    }

    /// Names an object for captures and validation messages.
    pub(crate) fn name<T: vk::Handle>(&self, object: T, name: &str) {
        if let (Some(debug), Ok(name)) = (&self.debug, CString::new(name)) {
            let info = vk::DebugUtilsObjectNameInfoEXT::default().object_handle(object).object_name(&name);
            // SAFETY: the object belongs to this device. A failure to set the name does no harm.
            let _ = unsafe { debug.set_debug_utils_object_name(&info) };
        }
    }
}

impl Drop for Gpu {
    fn drop(&mut self) {
        // SAFETY: no resource is left, because every resource holds an Arc of self. The allocator comes first because it frees
        // device memory. The messenger outlives the device to receive its last messages, and the instance comes last.
        unsafe {
            let _ = self.device.device_wait_idle();
            ManuallyDrop::drop(&mut self.allocator);
            self.pipelines.clear();
            self.set_layouts.destroy(&self.device);
            self.device.destroy_pipeline_cache(self.pipeline_cache, None);
            self.device.destroy_device(None);
            if let Some((functions, messenger)) = self.messenger.take() {
                functions.destroy_debug_utils_messenger(messenger, None);
            }
            self.instance.destroy_instance(None);
        }
    }
}

impl std::fmt::Debug for Gpu {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("Gpu")
            .field("name", &self.facts.name)
            .field("driver", &self.facts.driver)
            .finish_non_exhaustive()
    }
}

fn create_instance(
    entry: &ash::Entry,
    options: &GpuOptions,
    messages: &validation::Messages,
) -> Result<(ash::Instance, bool)> {
    // SAFETY: the loader is alive during this function.
    let available = unsafe { entry.enumerate_instance_extension_properties(None) }
        .map_err(|e| GpuError::NoLoader(format!("listing its extensions failed: {e}")))?;
    let has = |name: &CStr| available.iter().any(|e| e.extension_name_as_c_str() == Ok(name));

    let mut extensions = Vec::new();
    for extension in &options.window_extensions {
        if !has(extension) {
            return Err(GpuError::NoInstanceExtension(extension.to_string_lossy().into_owned()));
        }
        extensions.push(extension.as_ptr());
    }
    let has_debug_utils = has(ash::ext::debug_utils::NAME) || options.validation;
    if has_debug_utils {
        extensions.push(ash::ext::debug_utils::NAME.as_ptr());
    }

    let application = vk::ApplicationInfo::default()
        .application_name(c"leadr")
        .engine_name(c"leadr-vk")
        .api_version(vk::API_VERSION_1_3);
    let layers = [validation::LAYER.as_ptr()];
    let mut features = vk::ValidationFeaturesEXT::default().enabled_validation_features(&validation::ENABLED);
    let settings = validation::settings();
    let mut settings = vk::LayerSettingsCreateInfoEXT::default().settings(&settings);
    let mut messenger = validation::messenger_info(messages);
    let mut info = vk::InstanceCreateInfo::default().application_info(&application);
    // Without this extension, the loader hides drivers such as MoltenVK.
    if has(ash::khr::portability_enumeration::NAME) {
        extensions.push(ash::khr::portability_enumeration::NAME.as_ptr());
        info = info.flags(vk::InstanceCreateFlags::ENUMERATE_PORTABILITY_KHR);
    }
    if options.validation {
        // SAFETY: the loader is alive.
        let known = unsafe { entry.enumerate_instance_layer_properties() }.unwrap_or_default();
        if !known.iter().any(|l| l.layer_name_as_c_str() == Ok(validation::LAYER)) {
            return Err(GpuError::NoValidationLayer);
        }
        info = info.enabled_layer_names(&layers).push_next(&mut messenger);
        // SAFETY: the loader is alive.
        let of_layer = unsafe { entry.enumerate_instance_extension_properties(Some(validation::LAYER)) };
        let takes_settings =
            |e: &vk::ExtensionProperties| e.extension_name_as_c_str() == Ok(ash::ext::layer_settings::NAME);
        if of_layer.unwrap_or_default().iter().any(takes_settings) {
            extensions.push(ash::ext::layer_settings::NAME.as_ptr());
            info = info.push_next(&mut settings);
        } else {
            extensions.push(ash::ext::validation_features::NAME.as_ptr());
            info = info.push_next(&mut features);
        }
    }
    let info = info.enabled_extension_names(&extensions);
    // SAFETY: all pointers in `info` outlive the call.
    match unsafe { entry.create_instance(&info, None) } {
        Ok(instance) => Ok((instance, has_debug_utils)),
        Err(vk::Result::ERROR_INCOMPATIBLE_DRIVER) => Err(GpuError::NoDriver),
        Err(result) => Err(GpuError::Vulkan { what: "creating the Vulkan instance".to_owned(), result }),
    }
}

fn create_device(instance: &ash::Instance, chosen: &select::Candidate, extensions: &[&CStr]) -> Result<ash::Device> {
    let mut names: Vec<_> = extensions.iter().map(|name| name.as_ptr()).collect();
    let queues =
        [vk::DeviceQueueCreateInfo::default().queue_family_index(chosen.queue_family).queue_priorities(&[1.0])];
    let features = select::features(chosen.wires);
    let mut v13 = vk::PhysicalDeviceVulkan13Features::default()
        .dynamic_rendering(true)
        .synchronization2(true)
        .maintenance4(true)
        .shader_demote_to_helper_invocation(true)
        .shader_terminate_invocation(true);
    let mut subset = vk::PhysicalDevicePortabilitySubsetFeaturesKHR::default();
    if chosen.is_portable {
        // Vulkan requires this extension to be enabled where it exists, with each optional part that is used.
        names.push(ash::khr::portability_subset::NAME.as_ptr());
        let mut all = vk::PhysicalDeviceFeatures2::default().push_next(&mut subset);
        // SAFETY: the device has the extension of the chained structure.
        unsafe { instance.get_physical_device_features2(chosen.physical, &mut all) };
        subset.p_next = std::ptr::null_mut();
    }
    let info = vk::DeviceCreateInfo::default()
        .queue_create_infos(&queues)
        .enabled_extension_names(&names)
        .enabled_features(&features)
        .push_next(&mut v13);
    let info = if chosen.is_portable { info.push_next(&mut subset) } else { info };
    // SAFETY: the features and extensions were found on this device; all pointers outlive the call.
    unsafe { instance.create_device(chosen.physical, &info, None) }.doing(format!("opening {}", chosen.name))
}

fn facts(instance: &ash::Instance, chosen: &select::Candidate) -> Facts {
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut v11 = vk::PhysicalDeviceVulkan11Properties::default();
    let mut push = vk::PhysicalDevicePushDescriptorPropertiesKHR::default();
    let mut all =
        vk::PhysicalDeviceProperties2::default().push_next(&mut driver).push_next(&mut v11).push_next(&mut push);
    // SAFETY: the device supports Vulkan 1.3 and therefore the chain.
    unsafe { instance.get_physical_device_properties2(chosen.physical, &mut all) };
    let limits = all.properties.limits;
    let text = |s: std::result::Result<&CStr, _>| s.map(|s| s.to_string_lossy().into_owned()).unwrap_or_default();
    let name = text(driver.driver_name_as_c_str().map_err(drop));
    let info = text(driver.driver_info_as_c_str().map_err(drop));
    Facts {
        name: chosen.name.clone(),
        driver: format!("{name} {info}"),
        driver_id: driver.driver_id,
        limits,
        kind: chosen.kind,
        largest_allocation: v11.max_memory_allocation_size,
        push_descriptors: push.max_push_descriptors,
        wires: chosen.wires,
    }
}
