//! The layer over Vulkan: resources, pipelines, names, recording.

mod device;
mod names;
mod recording;
mod sets;
