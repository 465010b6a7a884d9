//! What a device can share with other APIs, and with other devices of Vulkan.

use super::handle::{MEMORY, MEMORY_EXTENSION, SEMAPHORE, SEMAPHORE_EXTENSION};
use super::memory::Use;
use super::{Device, Instance};
use ash::vk;
use std::ffi::CStr;

/// Semaphores that can be exported and imported. Who shares timelines shares binary ones too.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord)]
pub enum Semaphores {
    #[default]
    None,
    Binary,
    Timeline,
}

/// What can be shared; by default nothing.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Sharing {
    pub memory: bool,
    pub semaphores: Semaphores,
    /// It has timeline semaphores, shared or not.
    pub timeline: bool,
}

impl Sharing {
    /// Asks a device.
    pub fn of(instance: &Instance, device: vk::PhysicalDevice) -> Self {
        // SAFETY: the device is the instance's.
        let (properties, extensions) = unsafe {
            let properties = instance.raw.get_physical_device_properties(device);
            (properties, instance.raw.enumerate_device_extension_properties(device).unwrap_or_default())
        };
        let has = |name: &CStr| extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
        if properties.api_version < vk::API_VERSION_1_2 {
            return Self::default();
        }
        let mut v12 = vk::PhysicalDeviceVulkan12Features::default();
        let mut features = vk::PhysicalDeviceFeatures2::default().push_next(&mut v12);
        // SAFETY: a device of 1.2, which knows the structure; it is alive.
        unsafe { instance.raw.get_physical_device_features2(device, &mut features) };
        let timeline = v12.timeline_semaphore == vk::TRUE;
        let shares = |kind| has(SEMAPHORE_EXTENSION) && semaphores(instance, device, kind);
        let semaphores = match shares(vk::SemaphoreType::BINARY) {
            false => Semaphores::None,
            true if timeline && shares(vk::SemaphoreType::TIMELINE) => Semaphores::Timeline,
            true => Semaphores::Binary,
        };
        Self { memory: has(MEMORY_EXTENSION) && memory(instance, device), semaphores, timeline }
    }

    /// The extensions that it takes.
    pub fn extensions(self) -> impl Iterator<Item = &'static CStr> {
        let memory = self.memory.then_some(MEMORY_EXTENSION);
        memory.into_iter().chain((self.semaphores > Semaphores::None).then_some(SEMAPHORE_EXTENSION))
    }

    /// What it lacks, and what comes of that.
    pub fn absent(self) -> impl Iterator<Item = &'static str> {
        let memory = (!self.memory).then_some("no memory that CUDA can import: memory is copied to and from CUDA");
        let none = self.semaphores == Semaphores::None;
        let semaphores = none.then_some("no semaphores that CUDA can import: the host waits between CUDA and Vulkan");
        memory.into_iter().chain(semaphores)
    }
}

/// Whether buffers as we share them can be exported and imported.
fn memory(instance: &Instance, device: vk::PhysicalDevice) -> bool {
    let info = vk::PhysicalDeviceExternalBufferInfo::default().usage(Use::Shared.usage()).handle_type(MEMORY);
    let mut found = vk::ExternalBufferProperties::default();
    // SAFETY: a device of 1.2; both structures are alive.
    unsafe { instance.raw.get_physical_device_external_buffer_properties(device, &info, &mut found) };
    let both = vk::ExternalMemoryFeatureFlags::EXPORTABLE | vk::ExternalMemoryFeatureFlags::IMPORTABLE;
    found.external_memory_properties.external_memory_features.contains(both)
}

fn semaphores(instance: &Instance, device: vk::PhysicalDevice, kind: vk::SemaphoreType) -> bool {
    let mut kind = vk::SemaphoreTypeCreateInfo::default().semaphore_type(kind);
    let info = vk::PhysicalDeviceExternalSemaphoreInfo::default().handle_type(SEMAPHORE).push_next(&mut kind);
    let mut found = vk::ExternalSemaphoreProperties::default();
    // SAFETY: as above.
    unsafe { instance.raw.get_physical_device_external_semaphore_properties(device, &info, &mut found) };
    let both = vk::ExternalSemaphoreFeatureFlags::EXPORTABLE | vk::ExternalSemaphoreFeatureFlags::IMPORTABLE;
    found.external_semaphore_features.contains(both)
}

impl Device {
    /// Whether buffers can be shared with other APIs.
    pub fn shares_memory(&self) -> bool {
        self.sharing.memory
    }

    /// The best semaphores that can be shared with other APIs.
    pub fn shares_semaphores(&self) -> Semaphores {
        self.sharing.semaphores
    }
}
