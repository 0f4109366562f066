//! Collects the validation layer's messages, so that tests can require that there are none.

use std::ffi::{CStr, c_void};
use std::sync::Mutex;

use ash::vk;

/// The name of the layer that checks the use of Vulkan.
pub(crate) const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// The settings for core and synchronization checks, in the form that older layers expect. GPU-assisted checks are excluded,
/// because they report false errors for push descriptors.
pub(crate) const ENABLED: [vk::ValidationFeatureEnableEXT; 1] =
    [vk::ValidationFeatureEnableEXT::SYNCHRONIZATION_VALIDATION];

/// Returns the settings for layers with `VK_EXT_layer_settings`. In these layers, synchronization checks of shader accesses are off
/// by default.
pub(crate) fn settings() -> [vk::LayerSettingEXT<'static>; 2] {
    static ON: vk::Bool32 = vk::TRUE;
    [c"validate_sync", c"syncval_shader_accesses_heuristic"].map(|name| vk::LayerSettingEXT {
        value_count: 1,
        p_values: std::ptr::from_ref(&ON).cast(),
        ..vk::LayerSettingEXT::default().layer_name(LAYER).setting_name(name).ty(vk::LayerSettingTypeEXT::BOOL32)
    })
}

/// The messages that the messenger collects. The owner boxes the messages, because Vulkan keeps their address.
pub(crate) type Messages = Mutex<Vec<String>>;

/// Describes a messenger that sends the validation layer's warnings and errors to `messages`, which must outlive it.
pub(crate) fn messenger_info(messages: &Messages) -> vk::DebugUtilsMessengerCreateInfoEXT<'static> {
    vk::DebugUtilsMessengerCreateInfoEXT::default()
        .message_severity(vk::DebugUtilsMessageSeverityFlagsEXT::WARNING | vk::DebugUtilsMessageSeverityFlagsEXT::ERROR)
        .message_type(vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION)
        .pfn_user_callback(Some(collect))
        .user_data(std::ptr::from_ref(messages).cast_mut().cast())
}

/// # Safety
/// Only Vulkan may call this function, with valid data or null, and with the `Messages` of [`messenger_info`].
unsafe extern "system" fn collect(
    severity: vk::DebugUtilsMessageSeverityFlagsEXT,
    _kind: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user: *mut c_void,
) -> vk::Bool32 {
    if data.is_null() || user.is_null() {
        return vk::FALSE;
    }
    // SAFETY: Vulkan passes valid callback data, and `user` is the `Messages` that outlives the messenger.
    let (text, messages) = unsafe {
        let data = &*data;
        let text = data.message_as_c_str().map(CStr::to_string_lossy).unwrap_or_default();
        (text.into_owned(), &*user.cast::<Messages>())
    };
    if severity.contains(vk::DebugUtilsMessageSeverityFlagsEXT::ERROR) {
        tracing::error!(target: "vulkan", "{text}");
    } else {
        tracing::warn!(target: "vulkan", "{text}");
    }
    if let Ok(mut messages) = messages.lock() {
        messages.push(text);
    }
    vk::FALSE
}
