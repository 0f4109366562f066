//! Errors of the Vulkan layer. Each error message is one sentence with a remedy.

use ash::vk;

/// The result of functions that use the device. All such functions can fail because of a memory shortage, a failed Vulkan call, a
/// failed pipeline or a lost device. The documentation of a function lists only its other errors.
pub type Result<T> = std::result::Result<T, GpuError>;

/// A failure in the Vulkan layer. The text is one sentence with the fault and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// The Vulkan loader library could not be opened.
    #[error("no Vulkan loader found ({0}): install libvulkan1 and a driver such as mesa-vulkan-drivers")]
    NoLoader(String),
    /// The loader works but finds no device.
    #[error(
        "no Vulkan driver found: install mesa-vulkan-drivers (software) or your graphics card's driver, \
         and check that VK_DRIVER_FILES, if set, names an existing file"
    )]
    NoDriver,
    /// None of the available devices can run the renderer.
    #[error("no Vulkan device can run the renderer: {0}; update the driver or install mesa-vulkan-drivers")]
    NoSuitableDevice(String),
    /// The value of `--device` matches no device.
    #[error("no Vulkan device matches {wanted:?}: choose an index or part of a name from {available}")]
    UnknownDevice {
        /// The requested device.
        wanted: String,
        /// The available devices, in the form `0: name, 1: name`.
        available: String,
    },
    /// The chosen device does not meet a requirement.
    #[error("{device} cannot run the renderer: it lacks {missing}; choose another device or update its driver")]
    MissingFeatures {
        /// The name of the device.
        device: String,
        /// The missing features, separated by commas.
        missing: String,
    },
    /// Validation was requested, but its layer is not installed.
    #[error(
        "validation was requested but VK_LAYER_KHRONOS_validation is not installed: install vulkan-validationlayers"
    )]
    NoValidationLayer,
    /// A requested instance extension does not exist.
    #[error("the Vulkan loader has no extension {0}: update libvulkan1 and the driver")]
    NoInstanceExtension(String),
    /// No entry point of this name was compiled into the build.
    #[error(
        "this build has no shader named {name:?}: entry points are files below shaders-glsl/passes and shaders-glsl/probes"
    )]
    NoShader {
        /// The requested name.
        name: String,
    },
    /// A SPIR-V module is unsupported or does not fit its pipeline.
    #[error("shader {name}: {fault}")]
    Shader {
        /// The name of the entry point or struct.
        name: String,
        /// The description of the fault.
        fault: String,
    },
    /// Memory for a resource could not be allocated.
    #[error(
        "the device has no {} left for {name} ({source}): use smaller maps or a smaller image, or close other programs that use it",
        binary(*bytes)
    )]
    Allocation {
        /// The resource's debug name.
        name: String,
        /// The number of bytes requested.
        bytes: u64,
        /// The allocator's reason.
        source: gpu_allocator::AllocationError,
    },
    /// The content to draw does not fit into the device's memory.
    #[error(
        "{what} needs {} of device memory, but {} of {} are free: use {remedy}",
        binary(*needs), binary(*left), binary(*size)
    )]
    TooLarge {
        /// The content that needs the memory.
        what: String,
        /// The number of bytes needed.
        needs: u64,
        /// The number of free bytes.
        left: u64,
        /// The size of the device's memory in bytes.
        size: u64,
        /// An alternative that needs less memory.
        remedy: String,
    },
    /// The content to draw needs a larger single allocation than the device allows.
    #[error(
        "{what} needs {} of device memory in one allocation, but the device allows {}: use {remedy}",
        binary(*needs), binary(*most)
    )]
    InOnePiece {
        /// The content that needs the memory.
        what: String,
        /// The number of bytes needed.
        needs: u64,
        /// The largest size of one buffer or image in bytes.
        most: u64,
        /// An alternative that needs less memory.
        remedy: String,
    },
    /// The memory allocator could not be created.
    #[error("cannot create the GPU memory allocator: {0}")]
    Allocator(gpu_allocator::AllocationError),
    /// A resource was used in a way that contradicts its description, such as a wrong size, a missing binding, or a mip that does
    /// not exist.
    #[error("{name}: {fault}")]
    Usage {
        /// The resource's debug name.
        name: String,
        /// The description of the misuse.
        fault: String,
    },
    /// A Vulkan call failed.
    #[error("{what} failed: {}", reason(*result))]
    Vulkan {
        /// The operation that failed.
        what: String,
        /// Vulkan's result code.
        result: vk::Result,
    },
}

fn reason(result: vk::Result) -> String {
    use vk::Result as R;
    match result {
        R::ERROR_DEVICE_LOST => {
            "the device was lost: restart; if it fails again, use a smaller image, update the driver or choose another device".to_owned()
        }
        R::ERROR_OUT_OF_HOST_MEMORY => {
            "the system is out of memory: use smaller maps or a smaller image, or close other programs".to_owned()
        }
        R::ERROR_OUT_OF_DEVICE_MEMORY => {
            "the device is out of memory: use smaller maps or a smaller image, or close other programs that use it".to_owned()
        }
        R::ERROR_SURFACE_LOST_KHR => "the window's surface was lost: restart the program".to_owned(),
        // The message contains Vulkan's name for the result, because only the driver's documentation explains the cause.
        other => format!("the driver returned {other:?}: update it, or choose another device"),
    }
}

impl GpuError {
    /// Whether the error reports a lost device. A lost device has lost all its work.
    pub(crate) fn is_lost_device(&self) -> bool {
        matches!(self, Self::Vulkan { result: vk::Result::ERROR_DEVICE_LOST, .. })
    }

    /// Creates a [`GpuError::Usage`] from a resource's name and a fault.
    pub fn usage(name: impl Into<String>, fault: impl Into<String>) -> Self {
        Self::Usage { name: name.into(), fault: fault.into() }
    }
}

/// Adds the name of the failed operation to a Vulkan result.
pub(crate) trait Doing<T> {
    /// Adds the name of the operation to the error.
    fn doing(self, what: impl Into<String>) -> Result<T>;
}

impl<T> Doing<T> for std::result::Result<T, vk::Result> {
    fn doing(self, what: impl Into<String>) -> Result<T> {
        self.map_err(|result| GpuError::Vulkan { what: what.into(), result })
    }
}

/// Formats a number of bytes in readable units.
pub fn binary(bytes: u64) -> String {
    let mebibytes = bytes as f64 / f64::from(1 << 20);
    if mebibytes < 1000.0 { format!("{mebibytes:.1} MiB") } else { format!("{:.2} GiB", mebibytes / 1024.0) }
}
