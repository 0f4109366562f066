//! Flags of every command that needs a Vulkan device.

use std::sync::Arc;

use clap::Args;
use serde::Serialize;

use leadr_gpu::{Gpu, GpuError, GpuOptions};

/// Which device, and how closely it is watched.
#[derive(Clone, Debug, Default, Args, Serialize)]
pub struct DeviceArgs {
    /// Use this Vulkan device, by part of its name or by index
    #[arg(long, help_heading = "Device", value_name = "NAME|INDEX")]
    #[serde(skip)]
    pub device: Option<String>,
    /// Turn the Vulkan validation layers on; any message is an error
    #[arg(long, help_heading = "Device", hide_short_help = true)]
    pub validation: bool,
}

impl DeviceArgs {
    /// Opens the device, for pictures without a window.
    ///
    /// # Errors
    /// If there is no such device, or it lacks something.
    pub fn open(&self) -> Result<Arc<Gpu>, GpuError> {
        leadr_render::open_gpu(&GpuOptions {
            device: self.device.clone(),
            validation: self.validation,
            ..Default::default()
        })
    }
}

/// The device that renders, for reports.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DeviceInfo {
    /// As the driver names it.
    pub device: String,
    /// Driver and version.
    pub driver: String,
}

impl DeviceInfo {
    /// What this device says of itself.
    pub fn of(gpu: &Gpu) -> Self {
        Self { device: gpu.device_name().to_owned(), driver: gpu.driver_info().to_owned() }
    }
}
