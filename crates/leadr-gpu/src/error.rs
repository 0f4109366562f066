//! What can go wrong in the Vulkan layer, each error as one sentence with its remedy.

use ash::vk;

/// The result of whatever uses the device. Short memory, a failed Vulkan call or pipeline and a lost device can happen in each of
/// these functions; their documentation names only other errors.
pub type Result<T> = std::result::Result<T, GpuError>;

/// A failure in the Vulkan layer. Its text is one sentence that names the fault and the remedy.
#[derive(Debug, thiserror::Error)]
pub enum GpuError {
    /// The Vulkan loader library could not be opened.
    #[error("no Vulkan loader found ({0}): install libvulkan1 and a driver such as mesa-vulkan-drivers")]
    NoLoader(String),
    /// The loader works but offers no device.
    #[error(
        "no Vulkan driver found: install mesa-vulkan-drivers (software) or your graphics card's driver, \
         and check that VK_DRIVER_FILES, if set, names an existing file"
    )]
    NoDriver,
    /// There are devices, but none of them can run the renderer.
    #[error("no Vulkan device can run the renderer: {0}; update the driver or install mesa-vulkan-drivers")]
    NoSuitableDevice(String),
    /// `--device` matched nothing.
    #[error("no Vulkan device matches {wanted:?}: choose an index or part of a name from {available}")]
    UnknownDevice {
        /// What was asked for.
        wanted: String,
        /// The available devices, `0: name, 1: name`.
        available: String,
    },
    /// The chosen device lacks something required.
    #[error("{device} cannot run the renderer: it lacks {missing}; choose another device or update its driver")]
    MissingFeatures {
        /// Name of the device.
        device: String,
        /// What is missing, separated by commas.
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
        "no shader named {name:?} in this build: entry points are files below shaders-glsl/passes and shaders-glsl/probes"
    )]
    NoShader {
        /// The name looked for.
        name: String,
    },
    /// A SPIR-V module could not be understood or does not fit its pipeline.
    #[error("shader {name}: {fault}")]
    Shader {
        /// Entry point or struct.
        name: String,
        /// What is wrong with it.
        fault: String,
    },
    /// Memory for a resource could not be allocated.
    #[error(
        "the device has no {} left for {name} ({source}): take smaller maps or a smaller picture, or close what else uses it",
        binary(*bytes)
    )]
    Allocation {
        /// The resource's debug name.
        name: String,
        /// Bytes asked for.
        bytes: u64,
        /// The allocator's reason.
        source: gpu_allocator::AllocationError,
    },
    /// What is to be drawn does not fit into the device's memory.
    #[error(
        "{what} needs {} of device memory, and {} of {} are left: take {remedy}",
        binary(*needs), binary(*left), binary(*size)
    )]
    TooLarge {
        /// What needs it.
        what: String,
        /// Bytes that it needs.
        needs: u64,
        /// Bytes that are not in use.
        left: u64,
        /// Bytes of the device's memory.
        size: u64,
        /// What would need less.
        remedy: String,
    },
    /// What is to be drawn needs more memory in one piece than the device gives.
    #[error(
        "{what} needs {} of device memory in one piece, and the device gives {}: take {remedy}",
        binary(*needs), binary(*most)
    )]
    InOnePiece {
        /// What needs it.
        what: String,
        /// Bytes that it needs.
        needs: u64,
        /// The most bytes that one buffer or image can have.
        most: u64,
        /// What would need less.
        remedy: String,
    },
    /// The allocator itself could not be created.
    #[error("cannot create the GPU memory allocator: {0}")]
    Allocator(gpu_allocator::AllocationError),
    /// A resource was used in a way that contradicts its description (a wrong size, a missing binding, a mip that does not
    /// exist).
    #[error("{name}: {fault}")]
    Usage {
        /// The resource's debug name.
        name: String,
        /// What is wrong.
        fault: String,
    },
    /// A Vulkan call failed.
    #[error("{what} failed: {}", reason(*result))]
    Vulkan {
        /// What was being done.
        what: String,
        /// Vulkan's result code.
        result: vk::Result,
    },
}

/// Why Vulkan fails a call, and what to do about it.
fn reason(result: vk::Result) -> String {
    use vk::Result as R;
    match result {
        R::ERROR_DEVICE_LOST => {
            "the device was lost: start again, and if that happens again, take a smaller picture, update the driver or choose another device".to_owned()
        }
        R::ERROR_OUT_OF_HOST_MEMORY => {
            "the machine has no memory left: take smaller maps or a smaller picture, or close what else uses it".to_owned()
        }
        R::ERROR_OUT_OF_DEVICE_MEMORY => {
            "the device has no memory left: take smaller maps or a smaller picture, or close what else uses it".to_owned()
        }
        R::ERROR_SURFACE_LOST_KHR => "the window is gone from its display: start again".to_owned(),
        // Vulkan's name of it, since only the driver's makers know more.
        other => format!("the driver answers {other:?}: update it, or choose another device"),
    }
}

impl GpuError {
    /// Whether the device is gone, and with it all that it was doing.
    pub(crate) fn is_lost_device(&self) -> bool {
        matches!(self, Self::Vulkan { result: vk::Result::ERROR_DEVICE_LOST, .. })
    }

    /// A [`GpuError::Usage`] from its two parts.
    pub fn usage(name: impl Into<String>, fault: impl Into<String>) -> Self {
        Self::Usage { name: name.into(), fault: fault.into() }
    }
}

/// Adds the operation that failed to a Vulkan result.
pub(crate) trait Doing<T> {
    /// Names the operation in the error.
    fn doing(self, what: impl Into<String>) -> Result<T>;
}

impl<T> Doing<T> for std::result::Result<T, vk::Result> {
    fn doing(self, what: impl Into<String>) -> Result<T> {
        self.map_err(|result| GpuError::Vulkan { what: what.into(), result })
    }
}

/// Bytes as a person reads them.
pub fn binary(bytes: u64) -> String {
    let mebibytes = bytes as f64 / f64::from(1 << 20);
    if mebibytes < 1000.0 { format!("{mebibytes:.1} MiB") } else { format!("{:.2} GiB", mebibytes / 1024.0) }
}
