//! The uses of resources. A use combines a pipeline stage, an access and an image layout.

use ash::vk;

/// A use of an image or of memory. A barrier changes one use to another.
///
/// The image layout has no meaning for buffers and other memory.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Use {
    /// The resource is not used yet, or its content may be discarded. A barrier from this use waits for all earlier work.
    Undefined,
    /// The source of a copy.
    CopySource,
    /// The target of a copy or fill.
    CopyTarget,
    /// A sampled texture in any shader. Every `Descriptor::Sampled` has this layout.
    Sampled,
    /// A storage buffer or storage image that a compute shader reads.
    ComputeRead,
    /// A storage buffer or storage image that a compute shader writes.
    ComputeWrite,
    /// A storage buffer or storage image that a compute shader both reads and writes.
    ComputeReadWrite,
    /// A storage buffer, storage image or uniform buffer that any graphics stage reads.
    GraphicsRead,
    /// A colour attachment that is loaded and stored.
    ColorTarget,
    /// A depth attachment that is tested and written.
    DepthTarget,
    /// A buffer that the CPU reads after the submission.
    HostRead,
    /// An image that a swapchain displays.
    Present,
}

impl Use {
    pub(crate) fn stages(self) -> vk::PipelineStageFlags2 {
        use vk::PipelineStageFlags2 as S;
        match self {
            Self::Undefined => S::ALL_COMMANDS,
            Self::CopySource | Self::CopyTarget => S::ALL_TRANSFER,
            Self::Sampled => S::PRE_RASTERIZATION_SHADERS | S::FRAGMENT_SHADER | S::COMPUTE_SHADER,
            Self::ComputeRead | Self::ComputeWrite | Self::ComputeReadWrite => S::COMPUTE_SHADER,
            Self::GraphicsRead => S::PRE_RASTERIZATION_SHADERS | S::FRAGMENT_SHADER,
            Self::ColorTarget => S::COLOR_ATTACHMENT_OUTPUT,
            Self::DepthTarget => S::EARLY_FRAGMENT_TESTS | S::LATE_FRAGMENT_TESTS,
            Self::HostRead => S::HOST,
            // Presentation is ordered by the semaphore that it waits for.
            Self::Present => S::COLOR_ATTACHMENT_OUTPUT,
        }
    }

    /// Returns the memory accesses of these stages.
    pub(crate) fn access(self) -> vk::AccessFlags2 {
        use vk::AccessFlags2 as A;
        match self {
            // All earlier writes must be finished.
            Self::Undefined => A::MEMORY_WRITE,
            Self::Present => A::NONE,
            Self::CopySource => A::TRANSFER_READ,
            Self::CopyTarget => A::TRANSFER_WRITE,
            Self::Sampled => A::SHADER_SAMPLED_READ,
            Self::ComputeRead => A::SHADER_STORAGE_READ | A::UNIFORM_READ,
            Self::ComputeWrite => A::SHADER_STORAGE_WRITE,
            Self::ComputeReadWrite => A::SHADER_STORAGE_READ | A::SHADER_STORAGE_WRITE,
            Self::GraphicsRead => A::SHADER_STORAGE_READ | A::UNIFORM_READ,
            Self::ColorTarget => A::COLOR_ATTACHMENT_READ | A::COLOR_ATTACHMENT_WRITE,
            Self::DepthTarget => A::DEPTH_STENCIL_ATTACHMENT_READ | A::DEPTH_STENCIL_ATTACHMENT_WRITE,
            Self::HostRead => A::HOST_READ,
        }
    }

    pub(crate) fn layout(self) -> vk::ImageLayout {
        use vk::ImageLayout as L;
        match self {
            Self::Undefined => L::UNDEFINED,
            Self::CopySource => L::TRANSFER_SRC_OPTIMAL,
            Self::CopyTarget => L::TRANSFER_DST_OPTIMAL,
            Self::Sampled => L::SHADER_READ_ONLY_OPTIMAL,
            Self::ColorTarget => L::COLOR_ATTACHMENT_OPTIMAL,
            Self::DepthTarget => L::DEPTH_ATTACHMENT_OPTIMAL,
            Self::Present => L::PRESENT_SRC_KHR,
            Self::ComputeRead | Self::ComputeWrite | Self::ComputeReadWrite | Self::GraphicsRead | Self::HostRead => {
                L::GENERAL
            }
        }
    }
}
