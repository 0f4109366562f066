//! Flags of commands that need a Vulkan device.

use std::fmt;
use std::sync::Arc;

use clap::Args;
use serde::Serialize;

use leadr_gpu::{Gpu, GpuError, GpuOptions};
use leadr_maps::shown::shown;

/// Device selection and validation.
#[derive(Clone, Debug, Default, Args, Serialize)]
pub struct DeviceArgs {
    /// Use this Vulkan device, by part of its name or by index
    #[arg(long, help_heading = "Device", value_name = "NAME|INDEX")]
    #[serde(skip)]
    pub device: Option<String>,
    /// Enable the Vulkan validation layers and treat any message as an error
    #[arg(long, help_heading = "Device", hide_short_help = true)]
    pub validation: bool,
}

impl DeviceArgs {
    /// Opens the device for rendering without a window.
    ///
    /// # Errors
    /// Fails if there is no matching device, or if the device lacks a required feature.
    pub fn open(&self) -> Result<Arc<Gpu>, GpuError> {
        leadr_render::open_gpu(&GpuOptions {
            device: self.device.clone(),
            validation: self.validation,
            ..Default::default()
        })
    }
}

/// The rendering device as a report describes it.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
pub struct DeviceInfo {
    /// The name of the device.
    pub device: String,
    /// The name and version of the driver.
    pub driver: String,
}

impl DeviceInfo {
    /// Returns the name and driver of a device.
    pub fn of(gpu: &Gpu) -> Self {
        Self { device: gpu.device_name().to_owned(), driver: gpu.driver_info().to_owned() }
    }
}

/// Name and driver, `DEVICE (DRIVER)`.
impl fmt::Display for DeviceInfo {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({})", shown(&self.device), shown(&self.driver))
    }
}
