//! Selects the physical device and checks the requirements of the renderer.

use std::ffi::CStr;

use ash::vk;

use super::error::Doing;
use super::{GpuError, Result};

/// A physical device and the properties that matter for the choice of a device.
pub(crate) struct Candidate {
    pub(crate) physical: vk::PhysicalDevice,
    pub(crate) name: String,
    pub(crate) kind: vk::PhysicalDeviceType,
    /// The requirements of the renderer that the device does not meet. The list is empty for a usable device.
    pub(crate) missing: Vec<String>,
    /// The index of a queue family that can draw, compute and copy.
    pub(crate) queue_family: u32,
    /// Whether the device can draw triangles as wireframes.
    pub(crate) wires: bool,
    /// Whether the device lacks parts of Vulkan, as MoltenVK does, and has an extension that lists them.
    pub(crate) is_portable: bool,
}

/// Returns the device that `wanted` names by its index or by a part of its name, ignoring case. Without `wanted`, returns the best
/// usable device.
pub(crate) fn choose(instance: &ash::Instance, wanted: Option<&str>, extensions: &[&CStr]) -> Result<Candidate> {
    // SAFETY: the instance is alive.
    let physicals = unsafe { instance.enumerate_physical_devices() }.doing("listing the Vulkan devices")?;
    let mut candidates: Vec<_> =
        physicals.into_iter().map(|physical| inspect(instance, physical, extensions)).collect();
    if candidates.is_empty() {
        return Err(GpuError::NoDriver);
    }
    if let Some(wanted) = wanted {
        let index = match wanted.trim().parse::<usize>() {
            Ok(index) => Some(index).filter(|index| *index < candidates.len()),
            Err(_) => {
                let needle = wanted.to_lowercase();
                candidates.iter().position(|c| !needle.is_empty() && c.name.to_lowercase().contains(&needle))
            }
        };
        let Some(index) = index else {
            return Err(GpuError::UnknownDevice { wanted: wanted.to_owned(), available: list(&candidates) });
        };
        let chosen = candidates.swap_remove(index);
        if !chosen.missing.is_empty() {
            return Err(GpuError::MissingFeatures { device: chosen.name, missing: chosen.missing.join(", ") });
        }
        return Ok(chosen);
    }
    let best =
        (0..candidates.len()).filter(|i| candidates[*i].missing.is_empty()).min_by_key(|i| rank(candidates[*i].kind));
    best.map(|index| candidates.swap_remove(index)).ok_or_else(|| {
        let lacks = |c: &Candidate| format!("{} lacks {}", c.name, c.missing.join(", "));
        GpuError::NoSuitableDevice(candidates.iter().map(lacks).collect::<Vec<_>>().join("; "))
    })
}

fn rank(kind: vk::PhysicalDeviceType) -> u32 {
    match kind {
        vk::PhysicalDeviceType::DISCRETE_GPU => 0,
        vk::PhysicalDeviceType::INTEGRATED_GPU => 1,
        vk::PhysicalDeviceType::VIRTUAL_GPU => 2,
        vk::PhysicalDeviceType::CPU => 3,
        _ => 4,
    }
}

fn list(candidates: &[Candidate]) -> String {
    let names: Vec<String> = candidates.iter().enumerate().map(|(i, c)| format!("{i}: {}", c.name)).collect();
    names.join(", ")
}

fn inspect(instance: &ash::Instance, physical: vk::PhysicalDevice, extensions: &[&CStr]) -> Candidate {
    // SAFETY: `physical` comes from this live instance.
    let properties = unsafe { instance.get_physical_device_properties(physical) };
    let name = properties.device_name_as_c_str().map(CStr::to_string_lossy).unwrap_or_default().into_owned();
    let mut missing = Vec::new();
    // SAFETY: `physical` comes from this live instance.
    let families = unsafe { instance.get_physical_device_queue_family_properties(physical) };
    let needed = vk::QueueFlags::GRAPHICS | vk::QueueFlags::COMPUTE;
    let queue_family = families.iter().position(|f| f.queue_flags.contains(needed));
    if queue_family.is_none() {
        missing.push("a queue for graphics and compute".to_owned());
    }
    if properties.api_version < vk::API_VERSION_1_3 {
        let v = properties.api_version;
        missing.push(format!("Vulkan 1.3 (it has {}.{})", vk::api_version_major(v), vk::api_version_minor(v)));
    } else {
        missing.extend(missing_features(instance, physical));
    }
    // SAFETY: `physical` comes from this live instance.
    let available = unsafe { instance.enumerate_device_extension_properties(physical) }.unwrap_or_default();
    let has = |name: &CStr| available.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
    for extension in extensions {
        if !has(extension) {
            missing.push(extension.to_string_lossy().into_owned());
        }
    }
    let is_portable = has(ash::khr::portability_subset::NAME);
    let kind = properties.device_type;
    // SAFETY: `physical` comes from this live instance.
    let wires = unsafe { instance.get_physical_device_features(physical) }.fill_mode_non_solid == vk::TRUE;
    Candidate { physical, name, kind, missing, queue_family: queue_family.unwrap_or(0) as u32, wires, is_portable }
}

fn missing_features(instance: &ash::Instance, physical: vk::PhysicalDevice) -> Vec<String> {
    let mut v13 = vk::PhysicalDeviceVulkan13Features::default();
    let mut all = vk::PhysicalDeviceFeatures2::default().push_next(&mut v13);
    // SAFETY: the device supports Vulkan 1.3 and therefore the whole chain.
    unsafe { instance.get_physical_device_features2(physical, &mut all) };
    let v10 = all.features;
    [
        (v10.tessellation_shader, "tessellationShader"),
        (v10.independent_blend, "independentBlend"),
        (v10.large_points, "largePoints"),
        (v10.shader_storage_image_extended_formats, "shaderStorageImageExtendedFormats"),
        (v13.dynamic_rendering, "dynamicRendering"),
        (v13.synchronization2, "synchronization2"),
        (v13.maintenance4, "maintenance4"),
        (v13.shader_demote_to_helper_invocation, "shaderDemoteToHelperInvocation"),
        (v13.shader_terminate_invocation, "shaderTerminateInvocation"),
    ]
    .into_iter()
    .filter(|(has, _)| *has == vk::FALSE)
    .map(|(_, name)| name.to_owned())
    .collect()
}

/// Returns the Vulkan 1.0 features to enable. All of them are required, except for `wires`. Features of Vulkan 1.3 are added when
/// the device is created.
pub(crate) fn features(wires: bool) -> vk::PhysicalDeviceFeatures {
    vk::PhysicalDeviceFeatures::default()
        .fill_mode_non_solid(wires)
        .tessellation_shader(true)
        .large_points(true)
        .independent_blend(true)
        .shader_storage_image_extended_formats(true)
}
