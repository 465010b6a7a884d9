//! The loader, an instance, and what validation layers say.

use super::VulkanError;
use ash::{ext, vk};
use std::ffi::{CStr, c_void};
use std::sync::{Arc, Mutex, PoisonError};

const LAYER: &CStr = c"VK_LAYER_KHRONOS_validation";

/// Whether the validation layers look on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Validation {
    #[default]
    Off,
    On,
}

/// A Vulkan instance; devices keep it alive.
pub struct Instance {
    // The library: it must outlive all that was loaded from it.
    _entry: ash::Entry,
    pub(super) raw: ash::Instance,
    messenger: Option<(ext::debug_utils::Instance, vk::DebugUtilsMessengerEXT)>,
    messages: Arc<Messages>,
}

/// Errors and warnings of the validation layers.
type Messages = Mutex<Vec<String>>;

impl Instance {
    pub fn new(validation: Validation) -> Result<Arc<Self>, VulkanError> {
        // SAFETY: the library is the system's Vulkan loader, whose initialisers may run; it is kept as long as the instance.
        let entry = unsafe { ash::Entry::load() };
        let entry = entry.map_err(|e| VulkanError::NoLoader { reason: e.to_string() })?;
        let application =
            vk::ApplicationInfo::default().application_name(c"halfpixel").api_version(vk::API_VERSION_1_3);
        let (mut layers, mut extensions) = (Vec::new(), Vec::new());
        if validation == Validation::On {
            // SAFETY: no pointer is passed.
            let known = unsafe { entry.enumerate_instance_layer_properties() }.unwrap_or_default();
            if !known.iter().any(|l| l.layer_name_as_c_str() == Ok(LAYER)) {
                return Err(VulkanError::NoValidation);
            }
            layers.push(LAYER.as_ptr());
            extensions.push(ext::debug_utils::NAME.as_ptr());
        }
        let info = vk::InstanceCreateInfo::default()
            .application_info(&application)
            .enabled_layer_names(&layers)
            .enabled_extension_names(&extensions);
        // SAFETY: all that `info` points to lives until the call returns.
        let raw = unsafe { entry.create_instance(&info, None) };
        let raw = raw.map_err(|code| VulkanError::NoDriver { code })?;
        let mut instance = Self { _entry: entry, raw, messenger: None, messages: Arc::default() };
        if validation == Validation::On {
            instance.listen()?;
        }
        Ok(Arc::new(instance))
    }

    /// What validation layers have said so far, oldest first.
    pub fn messages(&self) -> Vec<String> {
        self.messages.lock().unwrap_or_else(PoisonError::into_inner).clone()
    }

    fn listen(&mut self) -> Result<(), VulkanError> {
        let debug = ext::debug_utils::Instance::new(&self._entry, &self.raw);
        let info = vk::DebugUtilsMessengerCreateInfoEXT::default()
            .message_severity(
                vk::DebugUtilsMessageSeverityFlagsEXT::ERROR | vk::DebugUtilsMessageSeverityFlagsEXT::WARNING,
            )
            .message_type(
                vk::DebugUtilsMessageTypeFlagsEXT::GENERAL
                    | vk::DebugUtilsMessageTypeFlagsEXT::VALIDATION
                    | vk::DebugUtilsMessageTypeFlagsEXT::PERFORMANCE,
            )
            .pfn_user_callback(Some(heard))
            .user_data(Arc::as_ptr(&self.messages) as *mut c_void);
        // SAFETY: what user data points to is shared, and stays until the messenger is destroyed in `drop`.
        let messenger = unsafe { debug.create_debug_utils_messenger(&info, None) };
        self.messenger = Some((debug, messenger.map_err(VulkanError::of("vkCreateDebugUtilsMessengerEXT"))?));
        Ok(())
    }
}

impl Drop for Instance {
    fn drop(&mut self) {
        if let Some((debug, messenger)) = self.messenger.take() {
            // SAFETY: it is this instance's, and destroyed once.
            unsafe { debug.destroy_debug_utils_messenger(messenger, None) };
        }
        // SAFETY: devices hold an `Arc` of this: none is left.
        unsafe { self.raw.destroy_instance(None) };
    }
}

/// Keeps a message.
///
/// # Safety
/// For `Instance::listen` alone: `user_data` points to its `Messages`.
unsafe extern "system" fn heard(
    _: vk::DebugUtilsMessageSeverityFlagsEXT,
    _: vk::DebugUtilsMessageTypeFlagsEXT,
    data: *const vk::DebugUtilsMessengerCallbackDataEXT<'_>,
    user_data: *mut c_void,
) -> vk::Bool32 {
    // SAFETY: Vulkan passes a valid structure with a terminated string, and what `listen` gave it.
    let (messages, text) =
        unsafe { (&*user_data.cast::<Messages>(), (*data).message_as_c_str().map(CStr::to_string_lossy)) };
    let text = text.unwrap_or_default().into_owned();
    messages.lock().unwrap_or_else(PoisonError::into_inner).push(text);
    vk::FALSE
}
