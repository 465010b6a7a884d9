//! What a device must have, and what is missing where it can't be used.

use super::sharing::Sharing;
use super::{Instance, Validation, VulkanError};
use ash::{ext, vk};
use serde::Serialize;
use std::ffi::CStr;
use std::fmt;
use std::sync::{Arc, Mutex, PoisonError};

/// A Vulkan device that is there.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Found {
    pub name: String,
    /// The driver's own words.
    pub driver: String,
    /// As CUDA's, without `GPU-`: a device of both has the same.
    pub uuid: String,
    /// "discrete", "integrated", "virtual", "cpu" or "other".
    pub kind: &'static str,
    /// What meshlets need and it lacks; empty: it can be used.
    pub missing: Vec<String>,
    /// What it lacks that only makes frames slower.
    pub absent: Vec<String>,
}

/// A device that draws meshlets, with a queue.
pub struct Device {
    pub(super) raw: ash::Device,
    pub(super) mesh: ext::mesh_shader::Device,
    /// Vulkan wants one user at a time.
    pub(super) queue: Mutex<vk::Queue>,
    pub(super) family: u32,
    pub(super) memory: vk::PhysicalDeviceMemoryProperties,
    /// Bytes of a buffer.
    pub(super) largest_buffer: u64,
    /// Half the side of the viewport in pixels, a power of two.
    pub(super) half_viewport: u32,
    /// Pixels a side of what can be drawn.
    pub(super) largest: u32,
    /// The most quads along a side of what is tessellated, or the features that this lacks.
    pub(super) tessellation: Result<u32, Vec<&'static str>>,
    /// Where the queue has any.
    pub(super) timestamps: Option<Timestamps>,
    pub(super) sharing: Sharing,
    pub found: Found,
    pub(super) instance: Arc<Instance>,
}

/// What a queue's clock says.
#[derive(Clone, Copy, Debug)]
pub(super) struct Timestamps {
    /// Nanoseconds a tick.
    pub period: f32,
    /// That count; those above are 0.
    pub bits: u32,
}

/// What is asked of a device beyond 1.3.
const EXTENSIONS: [&CStr; 1] = [ext::mesh_shader::NAME];
/// Sides of the viewport beyond which nothing is asked for.
const LARGEST_VIEWPORT: u32 = 1 << 14;

/// All Vulkan devices of this machine.
pub fn devices() -> Result<Vec<Found>, VulkanError> {
    let instance = Instance::new(Validation::Off)?;
    Ok(physical(&instance)?.into_iter().map(|device| look(&instance, device, Sharing::of(&instance, device))).collect())
}

fn physical(instance: &Instance) -> Result<Vec<vk::PhysicalDevice>, VulkanError> {
    // SAFETY: the instance is alive.
    let found = unsafe { instance.raw.enumerate_physical_devices() };
    match found {
        Err(vk::Result::ERROR_INITIALIZATION_FAILED) => Err(VulkanError::NoDevice),
        other => other.map_err(VulkanError::of("vkEnumeratePhysicalDevices")),
    }
}

/// The features that are used, as one chain.
#[derive(Default)]
struct Features {
    core: vk::PhysicalDeviceFeatures,
    v11: vk::PhysicalDeviceVulkan11Features<'static>,
    v12: vk::PhysicalDeviceVulkan12Features<'static>,
    v13: vk::PhysicalDeviceVulkan13Features<'static>,
    mesh: vk::PhysicalDeviceMeshShaderFeaturesEXT<'static>,
}

impl Features {
    fn of(instance: &Instance, device: vk::PhysicalDevice) -> Self {
        let mut all = Self::default();
        let mut features = vk::PhysicalDeviceFeatures2::default()
            .push_next(&mut all.v11)
            .push_next(&mut all.v12)
            .push_next(&mut all.v13)
            .push_next(&mut all.mesh);
        // SAFETY: every structure of the chain is alive and is one that a device of 1.3 with the extension knows.
        unsafe { instance.raw.get_physical_device_features2(device, &mut features) };
        all.core = features.features;
        all
    }

    /// Exactly what is used.
    fn wanted() -> Self {
        let core = vk::PhysicalDeviceFeatures::default()
            .fragment_stores_and_atomics(true)
            .shader_int64(true)
            .shader_float64(true)
            .shader_int16(true);
        let v11 = vk::PhysicalDeviceVulkan11Features::default().storage_buffer16_bit_access(true);
        let v12 = vk::PhysicalDeviceVulkan12Features::default()
            .buffer_device_address(true)
            .scalar_block_layout(true)
            .shader_int8(true)
            .storage_buffer8_bit_access(true)
            .shader_buffer_int64_atomics(true);
        let v13 = vk::PhysicalDeviceVulkan13Features::default()
            .dynamic_rendering(true)
            .synchronization2(true)
            .maintenance4(true);
        let mesh = vk::PhysicalDeviceMeshShaderFeaturesEXT::default().mesh_shader(true);
        Self { core, v11, v12, v13, mesh }
    }

    /// What tessellation asks for besides; a device that lacks it still draws meshlets.
    fn tessellation(core: &vk::PhysicalDeviceFeatures) -> [(&'static str, vk::Bool32); 2] {
        [
            ("tessellationShader", core.tessellation_shader),
            ("vertexPipelineStoresAndAtomics", core.vertex_pipeline_stores_and_atomics),
        ]
    }

    /// By name, in one order.
    fn named(&self) -> [(&'static str, vk::Bool32); 13] {
        [
            ("fragmentStoresAndAtomics", self.core.fragment_stores_and_atomics),
            ("shaderInt64", self.core.shader_int64),
            ("shaderFloat64", self.core.shader_float64),
            ("shaderInt16", self.core.shader_int16),
            ("storageBuffer16BitAccess", self.v11.storage_buffer16_bit_access),
            ("bufferDeviceAddress", self.v12.buffer_device_address),
            ("scalarBlockLayout", self.v12.scalar_block_layout),
            ("shaderInt8", self.v12.shader_int8),
            ("storageBuffer8BitAccess", self.v12.storage_buffer8_bit_access),
            ("shaderBufferInt64Atomics", self.v12.shader_buffer_int64_atomics),
            ("dynamicRendering", self.v13.dynamic_rendering),
            ("maintenance4", self.v13.maintenance4),
            ("meshShader", self.mesh.mesh_shader),
        ]
    }
}

fn look(instance: &Instance, device: vk::PhysicalDevice, sharing: Sharing) -> Found {
    let mut id = vk::PhysicalDeviceIDProperties::default();
    let mut driver = vk::PhysicalDeviceDriverProperties::default();
    let mut floats = vk::PhysicalDeviceFloatControlsProperties::default();
    let mut properties = vk::PhysicalDeviceProperties2::default();
    properties = properties.push_next(&mut id).push_next(&mut driver).push_next(&mut floats);
    // SAFETY: the chain is alive; a loader of 1.3 accepts it.
    unsafe { instance.raw.get_physical_device_properties2(device, &mut properties) };
    let core = properties.properties;
    let text = |bytes: Result<&CStr, std::ffi::FromBytesUntilNulError>| {
        bytes.map(|t| t.to_string_lossy().into_owned()).unwrap_or_default()
    };
    let kind = match core.device_type {
        vk::PhysicalDeviceType::DISCRETE_GPU => "discrete",
        vk::PhysicalDeviceType::INTEGRATED_GPU => "integrated",
        vk::PhysicalDeviceType::VIRTUAL_GPU => "virtual",
        vk::PhysicalDeviceType::CPU => "cpu",
        _ => "other",
    };
    // SAFETY: the device is the instance's.
    let extensions = unsafe { instance.raw.enumerate_device_extension_properties(device) }.unwrap_or_default();
    let has = |name: &CStr| extensions.iter().any(|e| e.extension_name_as_c_str() == Ok(name));
    let mut missing: Vec<String> = Vec::new();
    if core.api_version < vk::API_VERSION_1_3 {
        let (major, minor) = (vk::api_version_major(core.api_version), vk::api_version_minor(core.api_version));
        missing.push(format!("Vulkan 1.3 (it has {major}.{minor})"));
    }
    missing.extend(EXTENSIONS.iter().filter(|name| !has(name)).map(|name| name.to_string_lossy().into_owned()));
    if missing.is_empty() {
        let there = Features::of(instance, device).named();
        missing.extend(there.into_iter().filter(|(_, value)| *value == vk::FALSE).map(|(name, _)| name.to_owned()));
        if core.limits.sub_pixel_precision_bits < 8 {
            missing.push(format!("8 bits of sub-pixels (it has {})", core.limits.sub_pixel_precision_bits));
        }
        if floats.shader_rounding_mode_rte_float32 == vk::FALSE {
            missing.push("shaderRoundingModeRTEFloat32".into());
        }
        if family(instance, device).is_none() {
            missing.push("a graphics queue".into());
        }
    }
    let mut absent: Vec<String> = sharing.absent().map(String::from).collect();
    let lacking = tessellation_lacks(instance, device).into_iter();
    absent.extend(lacking.map(|name| format!("no {name}: no bench tessellation")));
    Found {
        name: text(core.device_name_as_c_str()),
        driver: format!("{} {}", text(driver.driver_name_as_c_str()), text(driver.driver_info_as_c_str())),
        uuid: uuid_text(id.device_uuid),
        kind,
        missing,
        absent,
    }
}

/// 8-4-4-4-12, hexadecimal: of one device the same for Vulkan and for CUDA.
pub(crate) fn uuid_text(u: [u8; 16]) -> String {
    let hex = |bytes: &[u8]| bytes.iter().map(|b| format!("{b:02x}")).collect::<String>();
    [&u[..4], &u[4..6], &u[6..8], &u[8..10], &u[10..]].map(hex).join("-")
}

/// The features that tessellation needs and the device has not.
fn tessellation_lacks(instance: &Instance, device: vk::PhysicalDevice) -> Vec<&'static str> {
    // SAFETY: the device is the instance's.
    let core = unsafe { instance.raw.get_physical_device_features(device) };
    let lacking = Features::tessellation(&core).into_iter().filter(|(_, value)| *value == vk::FALSE);
    lacking.map(|(name, _)| name).collect()
}

/// A family of queues that draw.
fn family(instance: &Instance, device: vk::PhysicalDevice) -> Option<u32> {
    // SAFETY: the device is the instance's.
    let families = unsafe { instance.raw.get_physical_device_queue_family_properties(device) };
    families.iter().position(|f| f.queue_flags.contains(vk::QueueFlags::GRAPHICS)).map(|k| k as u32)
}

/// The first that can draw meshlets; hardware before what runs on the CPU. `uuid`: that one alone.
fn best<T>(mut all: Vec<(Found, T)>, uuid: Option<&str>) -> Result<(Found, T), VulkanError> {
    all.retain(|(found, _)| uuid.is_none_or(|uuid| found.uuid == uuid));
    let rank = |kind: &str| ["discrete", "integrated", "virtual", "other"].iter().position(|k| *k == kind);
    all.sort_by_key(|(found, _)| (!found.missing.is_empty(), rank(found.kind).unwrap_or(usize::MAX)));
    let Some((found, of)) = all.into_iter().next() else { return Err(VulkanError::NoDevice) };
    if found.missing.is_empty() {
        return Ok((found, of));
    }
    Err(VulkanError::Unfit { device: found.name, missing: found.missing })
}

impl Device {
    /// The first device that can draw meshlets; hardware before what runs on the CPU. `uuid`: that one alone.
    pub fn new(validation: Validation, uuid: Option<&str>) -> Result<Arc<Self>, VulkanError> {
        Self::choose(validation, uuid, Sharing::of)
    }

    /// The same, but nothing of it can be shared with other APIs.
    pub fn unshared(validation: Validation, uuid: Option<&str>) -> Result<Arc<Self>, VulkanError> {
        Self::choose(validation, uuid, |_, _| Sharing::default())
    }

    fn choose(
        validation: Validation,
        uuid: Option<&str>,
        sharing: impl Fn(&Instance, vk::PhysicalDevice) -> Sharing,
    ) -> Result<Arc<Self>, VulkanError> {
        let instance = Instance::new(validation)?;
        let seen = |device| {
            let sharing = sharing(&instance, device);
            (look(&instance, device, sharing), (device, sharing))
        };
        let all = physical(&instance)?.into_iter().map(seen).collect();
        let (found, (physical, sharing)) = best(all, uuid)?;
        Self::open(instance, physical, found, sharing)
    }

    fn open(
        instance: Arc<Instance>,
        physical: vk::PhysicalDevice,
        found: Found,
        sharing: Sharing,
    ) -> Result<Arc<Self>, VulkanError> {
        let family = family(&instance, physical).ok_or(VulkanError::NoDevice)?;
        let queues = [vk::DeviceQueueCreateInfo::default().queue_family_index(family).queue_priorities(&[1.0])];
        let names: Vec<_> = EXTENSIONS.into_iter().chain(sharing.extensions()).map(CStr::as_ptr).collect();
        let lacking = tessellation_lacks(&instance, physical);
        let tessellates = lacking.is_empty();
        let Features { mut core, mut v11, mut v12, mut v13, mut mesh } = Features::wanted();
        core = core.tessellation_shader(tessellates).vertex_pipeline_stores_and_atomics(tessellates);
        v12 = v12.timeline_semaphore(sharing.timeline);
        let info = vk::DeviceCreateInfo::default()
            .queue_create_infos(&queues)
            .enabled_extension_names(&names)
            .enabled_features(&core)
            .push_next(&mut v11)
            .push_next(&mut v12)
            .push_next(&mut v13)
            .push_next(&mut mesh);
        // SAFETY: all that `info` points to lives until the call returns; `look` has seen that all of it is there.
        let raw = unsafe { instance.raw.create_device(physical, &info, None) };
        let raw = raw.map_err(VulkanError::of("vkCreateDevice"))?;
        // SAFETY: one queue of this family was asked for; the device is the instance's.
        let (queue, memory, limits) = unsafe {
            let queue = raw.get_device_queue(family, 0);
            let memory = instance.raw.get_physical_device_memory_properties(physical);
            (queue, memory, instance.raw.get_physical_device_properties(physical).limits)
        };
        let mut buffers = vk::PhysicalDeviceMaintenance4Properties::default();
        let mut properties = vk::PhysicalDeviceProperties2::default().push_next(&mut buffers);
        // SAFETY: the chain is alive; a device of 1.3 accepts it.
        unsafe { instance.raw.get_physical_device_properties2(physical, &mut properties) };
        let mesh = ext::mesh_shader::Device::new(&instance.raw, &raw);
        let [width, height] = limits.max_viewport_dimensions;
        let viewport = 1 << width.min(height).min(LARGEST_VIEWPORT).ilog2();
        let largest = limits.max_framebuffer_width.min(limits.max_framebuffer_height).min(viewport);
        // SAFETY: the device is the instance's.
        let families = unsafe { instance.raw.get_physical_device_queue_family_properties(physical) };
        let bits = families.get(family as usize).map_or(0, |f| f.timestamp_valid_bits);
        let timestamps = (bits > 0).then_some(Timestamps { period: limits.timestamp_period, bits });
        Ok(Arc::new(Self {
            raw,
            mesh,
            queue: Mutex::new(queue),
            family,
            memory,
            largest_buffer: buffers.max_buffer_size,
            half_viewport: viewport / 2,
            largest,
            tessellation: if tessellates { Ok(limits.max_tessellation_generation_level) } else { Err(lacking) },
            timestamps,
            sharing,
            found,
            instance,
        }))
    }

    /// What validation layers have said so far.
    pub fn messages(&self) -> Vec<String> {
        self.instance.messages()
    }
}

impl Device {
    /// Waits for all that the queue was given; a lost device has nothing left to wait for.
    pub(super) fn wait_idle(&self) {
        let _queue = self.queue.lock().unwrap_or_else(PoisonError::into_inner);
        // SAFETY: the device is alive, and nobody else uses its queue meanwhile.
        let _ = unsafe { self.raw.device_wait_idle() };
    }
}

impl Drop for Device {
    fn drop(&mut self) {
        self.wait_idle();
        // SAFETY: what was made of the device holds an `Arc` of this: nothing is left.
        unsafe { self.raw.destroy_device(None) };
    }
}

impl fmt::Debug for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_tuple("Device").field(&self.found.name).finish()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn found(name: &str, kind: &'static str, missing: &[&str]) -> (Found, u32) {
        let missing = missing.iter().map(|&m| m.into()).collect();
        let (driver, absent) = (String::new(), Vec::new());
        (Found { name: name.into(), driver, uuid: format!("uuid of {name}"), kind, missing, absent }, 0)
    }

    #[test]
    fn hardware_that_draws_meshlets_comes_first() {
        let all = || {
            vec![
                found("lavapipe", "cpu", &[]),
                found("old", "discrete", &["meshShader"]),
                found("new", "discrete", &[]),
            ]
        };
        assert_eq!(best(all(), None).expect("two will do").0.name, "new");
        assert_eq!(best(all(), Some("uuid of lavapipe")).expect("it will do").0.name, "lavapipe");
        assert_eq!(best(all(), Some("another")).expect_err("there is none"), VulkanError::NoDevice);
        assert_eq!(best(Vec::<(Found, u32)>::new(), None).expect_err("there is none"), VulkanError::NoDevice);
    }

    #[test]
    fn a_driver_without_mesh_shaders_is_one_clear_line() {
        let old = vec![found("old", "discrete", &["VK_EXT_mesh_shader", "shaderInt64"])];
        let error = best(old, None).expect_err("it lacks something").to_string();
        assert_eq!(error, "old can't be used for this, it lacks VK_EXT_mesh_shader, shaderInt64");
    }
}
