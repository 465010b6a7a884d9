//! What memory and semaphores are passed from one API to another by: a file descriptor, on Windows an NT handle.

use super::Device;
use ash::{khr, vk};
use std::ffi::CStr;
#[cfg(unix)]
use std::os::fd::{AsRawFd, FromRawFd, IntoRawFd, OwnedFd as Native};
#[cfg(windows)]
use std::os::windows::io::{AsRawHandle, FromRawHandle, OwnedHandle as Native};

/// Owned: closed with this, unless an import has taken it over.
#[derive(Debug)]
pub struct Handle(pub Native);

#[cfg(unix)]
pub(super) const MEMORY: vk::ExternalMemoryHandleTypeFlags = vk::ExternalMemoryHandleTypeFlags::OPAQUE_FD;
#[cfg(windows)]
pub(super) const MEMORY: vk::ExternalMemoryHandleTypeFlags = vk::ExternalMemoryHandleTypeFlags::OPAQUE_WIN32;
#[cfg(unix)]
pub(super) const SEMAPHORE: vk::ExternalSemaphoreHandleTypeFlags = vk::ExternalSemaphoreHandleTypeFlags::OPAQUE_FD;
#[cfg(windows)]
pub(super) const SEMAPHORE: vk::ExternalSemaphoreHandleTypeFlags = vk::ExternalSemaphoreHandleTypeFlags::OPAQUE_WIN32;

#[cfg(unix)]
pub(super) const MEMORY_EXTENSION: &CStr = khr::external_memory_fd::NAME;
#[cfg(windows)]
pub(super) const MEMORY_EXTENSION: &CStr = khr::external_memory_win32::NAME;
#[cfg(unix)]
pub(super) const SEMAPHORE_EXTENSION: &CStr = khr::external_semaphore_fd::NAME;
#[cfg(windows)]
pub(super) const SEMAPHORE_EXTENSION: &CStr = khr::external_semaphore_win32::NAME;

#[cfg(unix)]
pub(super) type MemoryImport = vk::ImportMemoryFdInfoKHR<'static>;
#[cfg(windows)]
pub(super) type MemoryImport = vk::ImportMemoryWin32HandleInfoKHR<'static>;

#[cfg(unix)]
impl Handle {
    /// Of exportable memory of a device that shares memory.
    pub(super) fn of_memory(device: &Device, memory: vk::DeviceMemory) -> Result<Self, vk::Result> {
        let info = vk::MemoryGetFdInfoKHR::default().memory(memory).handle_type(MEMORY);
        let extension = khr::external_memory_fd::Device::new(&device.instance.raw, &device.raw);
        // SAFETY: the memory is the device's and exportable; the descriptor that comes back is ours alone.
        unsafe { extension.get_memory_fd(&info).map(|fd| Self(Native::from_raw_fd(fd))) }
    }

    /// Of an exportable semaphore of a device that shares semaphores.
    pub(super) fn of_semaphore(device: &Device, semaphore: vk::Semaphore) -> Result<Self, vk::Result> {
        let info = vk::SemaphoreGetFdInfoKHR::default().semaphore(semaphore).handle_type(SEMAPHORE);
        let extension = khr::external_semaphore_fd::Device::new(&device.instance.raw, &device.raw);
        // SAFETY: as above.
        unsafe { extension.get_semaphore_fd(&info).map(|fd| Self(Native::from_raw_fd(fd))) }
    }

    /// For `vkAllocateMemory`.
    pub(super) fn memory_import(&self) -> MemoryImport {
        vk::ImportMemoryFdInfoKHR::default().handle_type(MEMORY).fd(self.0.as_raw_fd())
    }

    /// Puts what the handle names in place of a semaphore's own.
    pub(super) fn into_semaphore(self, device: &Device, semaphore: vk::Semaphore) -> Result<(), vk::Result> {
        let info = vk::ImportSemaphoreFdInfoKHR::default().semaphore(semaphore).handle_type(SEMAPHORE);
        let extension = khr::external_semaphore_fd::Device::new(&device.instance.raw, &device.raw);
        // SAFETY: the semaphore is the device's and nobody uses it yet; the driver refuses descriptors of other things.
        unsafe { extension.import_semaphore_fd(&info.fd(self.0.as_raw_fd())) }?;
        self.taken();
        Ok(())
    }

    /// From here on the descriptor is the driver's.
    pub(crate) fn taken(self) {
        let _ = self.0.into_raw_fd();
    }

    /// As CUDA wants it.
    pub(crate) fn raw(&self) -> std::ffi::c_int {
        self.0.as_raw_fd()
    }
}

#[cfg(windows)]
impl Handle {
    /// Of exportable memory of a device that shares memory.
    pub(super) fn of_memory(device: &Device, memory: vk::DeviceMemory) -> Result<Self, vk::Result> {
        let info = vk::MemoryGetWin32HandleInfoKHR::default().memory(memory).handle_type(MEMORY);
        let extension = khr::external_memory_win32::Device::new(&device.instance.raw, &device.raw);
        // SAFETY: the memory is the device's and exportable; the handle that comes back is ours alone.
        unsafe { extension.get_memory_win32_handle(&info).map(|h| Self(Native::from_raw_handle(h as _))) }
    }

    /// Of an exportable semaphore of a device that shares semaphores.
    pub(super) fn of_semaphore(device: &Device, semaphore: vk::Semaphore) -> Result<Self, vk::Result> {
        let info = vk::SemaphoreGetWin32HandleInfoKHR::default().semaphore(semaphore).handle_type(SEMAPHORE);
        let extension = khr::external_semaphore_win32::Device::new(&device.instance.raw, &device.raw);
        // SAFETY: as above.
        unsafe { extension.get_semaphore_win32_handle(&info).map(|h| Self(Native::from_raw_handle(h as _))) }
    }

    /// For `vkAllocateMemory`.
    pub(super) fn memory_import(&self) -> MemoryImport {
        vk::ImportMemoryWin32HandleInfoKHR::default().handle_type(MEMORY).handle(self.0.as_raw_handle() as _)
    }

    /// Puts what the handle names in place of a semaphore's own.
    pub(super) fn into_semaphore(self, device: &Device, semaphore: vk::Semaphore) -> Result<(), vk::Result> {
        let info = vk::ImportSemaphoreWin32HandleInfoKHR::default().semaphore(semaphore).handle_type(SEMAPHORE);
        let extension = khr::external_semaphore_win32::Device::new(&device.instance.raw, &device.raw);
        // SAFETY: the semaphore is the device's and nobody uses it yet; the driver refuses handles of other things.
        unsafe { extension.import_semaphore_win32_handle(&info.handle(self.0.as_raw_handle() as _)) }
    }

    /// An import went well; handles of Windows stay ours and are closed.
    pub(crate) fn taken(self) {}

    /// As CUDA wants it.
    pub(crate) fn raw(&self) -> *mut std::ffi::c_void {
        self.0.as_raw_handle()
    }
}
