//! Tests the layer over Vulkan: resources, pipelines, names and recording.

mod device;
mod names;
mod pipelines;
mod recording;
mod sets;
