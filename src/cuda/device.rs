//! Which CUDA devices there are. No context is made: listing takes no memory on them.

use super::{CudaError, OLDEST_DEVICE, fatbin, toolkit};
use crate::vulkan::uuid_text;
use cudarc::driver::{result, sys};
use serde::Serialize;
use std::fs;

/// A CUDA device, as its driver describes it.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Device {
    /// Its number for CUDA, from 0.
    pub ordinal: usize,
    pub name: String,
    /// Major, minor.
    pub compute_capability: [i32; 2],
    /// Bytes.
    pub memory: usize,
    pub multiprocessors: i32,
    /// As nvidia-smi writes it.
    pub uuid: String,
    pub driver: Driver,
}

/// The driver of all devices.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Driver {
    /// The newest CUDA release it knows: major, minor.
    pub cuda: [i32; 2],
    /// Its own version, where the kernel module tells it.
    pub version: Option<String>,
}

/// All CUDA devices; at least one.
pub fn devices() -> Result<Vec<Device>, CudaError> {
    let driver = driver()?;
    let count = result::device::get_count().map_err(CudaError::of_driver("counting CUDA devices"))?;
    if count == 0 {
        return Err(CudaError::NoDevice);
    }
    (0..count).map(|ordinal| device(ordinal, &driver)).collect()
}

/// The driver, ready for calls; every call of it comes after this one.
pub fn driver() -> Result<Driver, CudaError> {
    // SAFETY: opens and closes libcuda; loading NVIDIA's driver has no preconditions.
    if !unsafe { sys::is_culib_present() } {
        return Err(CudaError::NoDriver);
    }
    match result::init() {
        Err(error) if error.0 == sys::CUresult::CUDA_ERROR_NO_DEVICE => return Err(CudaError::NoDevice),
        other => other.map_err(CudaError::of_driver("starting the NVIDIA driver"))?,
    }
    let mut cuda = 0;
    // SAFETY: the library is there, and the pointer is to a live integer.
    let told = unsafe { sys::cuDriverGetVersion(&raw mut cuda) };
    told.result().map_err(CudaError::of_driver("asking for the driver's version"))?;
    let text = fs::read_to_string("/proc/driver/nvidia/version").unwrap_or_default();
    Ok(Driver { cuda: [cuda / 1000, cuda % 1000 / 10], version: module_version(&text) })
}

fn device(ordinal: i32, driver: &Driver) -> Result<Device, CudaError> {
    use sys::CUdevice_attribute::{
        CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR, CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR,
        CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT,
    };
    let failed = CudaError::of_driver("asking for a CUDA device's properties");
    let handle = result::device::get(ordinal).map_err(&failed)?;
    let attribute = |which| {
        // SAFETY: the handle comes from `device::get`.
        unsafe { result::device::get_attribute(handle, which) }.map_err(&failed)
    };
    Ok(Device {
        ordinal: ordinal as usize,
        name: result::device::get_name(handle).map_err(&failed)?,
        compute_capability: [
            attribute(CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MAJOR)?,
            attribute(CU_DEVICE_ATTRIBUTE_COMPUTE_CAPABILITY_MINOR)?,
        ],
        // SAFETY: the handle comes from `device::get`.
        memory: unsafe { result::device::total_mem(handle) }.map_err(&failed)?,
        multiprocessors: attribute(CU_DEVICE_ATTRIBUTE_MULTIPROCESSOR_COUNT)?,
        uuid: uuid(result::device::get_uuid(handle).map_err(&failed)?.bytes.map(|b| b as u8)),
        driver: driver.clone(),
    })
}

impl Device {
    /// As Vulkan writes it: NVIDIA promises the same bytes in the same order.
    pub fn vulkan_uuid(&self) -> &str {
        self.uuid.trim_start_matches("GPU-")
    }

    /// Whether the embedded kernels run on it.
    pub fn check(&self) -> Result<(), CudaError> {
        if self.compute_capability < OLDEST_DEVICE {
            return Err(CudaError::TooOld { name: self.name.clone(), found: self.compute_capability });
        }
        match (fatbin(), toolkit()) {
            // Machine code runs on every driver of its toolkit's major release.
            (Ok(_), Some(toolkit)) if self.driver.cuda[0] < toolkit.major() => {
                Err(CudaError::OldDriver { driver: self.driver.cuda, nvcc: toolkit.version.into() })
            }
            _ => Ok(()),
        }
    }
}

/// GPU-8-4-4-4-12, hexadecimal.
fn uuid(bytes: [u8; 16]) -> String {
    format!("GPU-{}", uuid_text(bytes))
}

/// The driver's version in `/proc/driver/nvidia/version`: the first line's first word of digits and dots.
fn module_version(text: &str) -> Option<String> {
    let number = |word: &&str| word.contains('.') && word.chars().all(|c| c.is_ascii_digit() || c == '.');
    text.lines().next()?.split_whitespace().find(number).map(String::from)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn card(compute_capability: [i32; 2], cuda: [i32; 2]) -> Device {
        let driver = Driver { cuda, version: None };
        let uuid = uuid([0; 16]);
        Device { ordinal: 0, name: "card".into(), compute_capability, memory: 0, multiprocessors: 1, uuid, driver }
    }

    #[test]
    fn old_devices_and_drivers_are_refused_by_name() {
        assert_eq!(card([8, 0], [99, 0]).check(), Ok(()));
        assert_eq!(card([12, 1], [99, 0]).check(), Ok(()));
        let old = card([7, 5], [99, 0]).check().unwrap_err().to_string();
        assert_eq!(old, "card has compute capability 7.5; 8.0 or newer is needed");
        let refused = card([9, 0], [11, 4]).check();
        assert_eq!(refused.is_err(), fatbin().is_ok(), "{refused:?}");
    }

    #[test]
    fn texts_are_as_nvidia_writes_them() {
        let bytes = std::array::from_fn(|k| 16 * k as u8 + 1);
        assert_eq!(uuid(bytes), "GPU-01112131-4151-6171-8191-a1b1c1d1e1f1");
        let card = Device { uuid: uuid(bytes), ..card([9, 0], [99, 0]) };
        assert_eq!(card.vulkan_uuid(), "01112131-4151-6171-8191-a1b1c1d1e1f1");
        let open =
            "NVRM version: NVIDIA UNIX Open Kernel Module for x86_64  580.65.06  Release Build  (a@b)\nGCC 12.2.0";
        assert_eq!(module_version(open).as_deref(), Some("580.65.06"));
        assert_eq!(
            module_version("NVRM version: NVIDIA UNIX x86_64 Kernel Module  550.90  Mon").as_deref(),
            Some("550.90")
        );
        assert_eq!(module_version(""), None);
    }
}
