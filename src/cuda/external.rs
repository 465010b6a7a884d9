//! Memory and semaphores of Vulkan on a CUDA device: imported from handles, unmapped and destroyed with these.

use super::CudaError;
use crate::vulkan::{Handle, Semaphores};
use cudarc::driver::{CudaStream, DriverError, result, sys};
use std::sync::Arc;

/// Memory that Vulkan has allocated for one buffer, mapped as a whole.
#[derive(Debug)]
pub(super) struct ExternalMemory {
    raw: sys::CUexternalMemory,
    /// Null until it is mapped.
    pointer: sys::CUdeviceptr,
    bytes: usize,
    stream: Arc<CudaStream>,
}

// SAFETY: the driver's objects belong to a context, not to a thread; `drop` chooses the context.
unsafe impl Send for ExternalMemory {}
// SAFETY: `&self` only reads numbers.
unsafe impl Sync for ExternalMemory {}

impl ExternalMemory {
    /// `bytes`: of the buffer; `allocation`: of its memory. Used by this stream alone.
    pub fn import(stream: &Arc<CudaStream>, handle: Handle, bytes: u64, allocation: u64) -> Result<Self, CudaError> {
        let (type_, described) = memory_handle(&handle);
        let flags = sys::CUDA_EXTERNAL_MEMORY_DEDICATED;
        let description = sys::CUDA_EXTERNAL_MEMORY_HANDLE_DESC {
            type_,
            handle: described,
            size: allocation,
            flags,
            reserved: [0; 16],
        };
        let stream = stream.clone();
        let mut made = Self { raw: std::ptr::null_mut(), pointer: 0, bytes: bytes as usize, stream };
        choose(&made.stream)?;
        // SAFETY: the description is of dedicated memory of this size, and the handle is open; there is a driver: a stream is.
        let imported = unsafe { sys::cuImportExternalMemory(&raw mut made.raw, &raw const description) }.result();
        imported.map_err(CudaError::of_driver("importing memory of Vulkan"))?;
        handle.taken();
        // SAFETY: the buffer begins where the memory does and is not larger.
        let mapped = unsafe { result::external_memory::get_mapped_buffer(made.raw, 0, bytes) };
        made.pointer = mapped.map_err(CudaError::of_driver("mapping memory of Vulkan"))?;
        Ok(made)
    }

    pub fn pointer(&self) -> sys::CUdeviceptr {
        self.pointer
    }

    pub fn bytes(&self) -> usize {
        self.bytes
    }
}

impl Drop for ExternalMemory {
    fn drop(&mut self) {
        // What runs still uses it to its end.
        let _ = self.stream.synchronize();
        // SAFETY: both are this one's own, or null; the mapping goes first, and nothing runs that uses it.
        unsafe {
            if self.pointer != 0 {
                let _ = result::free_sync(self.pointer);
            }
            if !self.raw.is_null() {
                let _ = result::external_memory::destroy_external_memory(self.raw);
            }
        }
    }
}

/// A semaphore of Vulkan that a stream waits for and signals.
#[derive(Debug)]
pub(super) struct ExternalSemaphore {
    raw: sys::CUexternalSemaphore,
    stream: Arc<CudaStream>,
}

// SAFETY: as for memory.
unsafe impl Send for ExternalSemaphore {}
// SAFETY: `&self` hands the semaphore to the driver, which allows that from any thread.
unsafe impl Sync for ExternalSemaphore {}

impl ExternalSemaphore {
    pub fn import(stream: &Arc<CudaStream>, handle: Handle, kind: Semaphores) -> Result<Self, CudaError> {
        let (type_, described) = semaphore_handle(&handle, kind);
        let description =
            sys::CUDA_EXTERNAL_SEMAPHORE_HANDLE_DESC { type_, handle: described, flags: 0, reserved: [0; 16] };
        let mut made = Self { raw: std::ptr::null_mut(), stream: stream.clone() };
        choose(stream)?;
        // SAFETY: the description names an open handle of this kind of semaphore; there is a driver: a stream is.
        let imported = unsafe { sys::cuImportExternalSemaphore(&raw mut made.raw, &raw const description) }.result();
        imported.map_err(CudaError::of_driver("importing a semaphore of Vulkan"))?;
        handle.taken();
        Ok(made)
    }

    /// After all that the stream was given before. Binary semaphores have no value.
    pub fn signal(&self, value: u64) -> Result<(), CudaError> {
        // SAFETY: numbers and unions of numbers: zeros are a value of it.
        let mut how: sys::CUDA_EXTERNAL_SEMAPHORE_SIGNAL_PARAMS = unsafe { std::mem::zeroed() };
        how.params.fence.value = value;
        choose(&self.stream)?;
        // SAFETY: one semaphore of this context and how to signal it; both are read before the call returns.
        let called = unsafe {
            sys::cuSignalExternalSemaphoresAsync(&raw const self.raw, &raw const how, 1, self.stream.cu_stream())
        };
        called.result().map_err(CudaError::of_driver("signalling a semaphore of Vulkan"))
    }

    /// Before all that the stream is given from here on.
    pub fn wait(&self, value: u64) -> Result<(), CudaError> {
        // SAFETY: as in `signal`.
        let mut how: sys::CUDA_EXTERNAL_SEMAPHORE_WAIT_PARAMS = unsafe { std::mem::zeroed() };
        how.params.fence.value = value;
        choose(&self.stream)?;
        // SAFETY: as in `signal`.
        let called = unsafe {
            sys::cuWaitExternalSemaphoresAsync(&raw const self.raw, &raw const how, 1, self.stream.cu_stream())
        };
        called.result().map_err(CudaError::of_driver("waiting for a semaphore of Vulkan"))
    }
}

impl Drop for ExternalSemaphore {
    fn drop(&mut self) {
        // The driver wants no wait or signal to be pending.
        let _ = self.stream.synchronize();
        if !self.raw.is_null() {
            // SAFETY: it is this one's own, and destroyed once.
            let _ = unsafe { sys::cuDestroyExternalSemaphore(self.raw) }.result();
        }
    }
}

/// The calls that follow are for this stream's device.
fn choose(stream: &CudaStream) -> Result<(), CudaError> {
    let chosen: Result<(), DriverError> = stream.context().bind_to_thread();
    chosen.map_err(CudaError::of_driver("choosing the GPU"))
}

#[cfg(unix)]
fn memory_handle(
    handle: &Handle,
) -> (sys::CUexternalMemoryHandleType, sys::CUDA_EXTERNAL_MEMORY_HANDLE_DESC_st__bindgen_ty_1) {
    let described = sys::CUDA_EXTERNAL_MEMORY_HANDLE_DESC_st__bindgen_ty_1 { fd: handle.raw() };
    (sys::CUexternalMemoryHandleType::CU_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_FD, described)
}

#[cfg(windows)]
fn memory_handle(
    handle: &Handle,
) -> (sys::CUexternalMemoryHandleType, sys::CUDA_EXTERNAL_MEMORY_HANDLE_DESC_st__bindgen_ty_1) {
    let name = std::ptr::null();
    let win32 = sys::CUDA_EXTERNAL_MEMORY_HANDLE_DESC_st__bindgen_ty_1__bindgen_ty_1 { handle: handle.raw(), name };
    let described = sys::CUDA_EXTERNAL_MEMORY_HANDLE_DESC_st__bindgen_ty_1 { win32 };
    (sys::CUexternalMemoryHandleType::CU_EXTERNAL_MEMORY_HANDLE_TYPE_OPAQUE_WIN32, described)
}

#[cfg(unix)]
fn semaphore_handle(
    handle: &Handle,
    kind: Semaphores,
) -> (sys::CUexternalSemaphoreHandleType, sys::CUDA_EXTERNAL_SEMAPHORE_HANDLE_DESC_st__bindgen_ty_1) {
    use sys::CUexternalSemaphoreHandleType as Type;
    let described = sys::CUDA_EXTERNAL_SEMAPHORE_HANDLE_DESC_st__bindgen_ty_1 { fd: handle.raw() };
    match kind {
        Semaphores::Timeline => (Type::CU_EXTERNAL_SEMAPHORE_HANDLE_TYPE_TIMELINE_SEMAPHORE_FD, described),
        _ => (Type::CU_EXTERNAL_SEMAPHORE_HANDLE_TYPE_OPAQUE_FD, described),
    }
}

#[cfg(windows)]
fn semaphore_handle(
    handle: &Handle,
    kind: Semaphores,
) -> (sys::CUexternalSemaphoreHandleType, sys::CUDA_EXTERNAL_SEMAPHORE_HANDLE_DESC_st__bindgen_ty_1) {
    use sys::CUexternalSemaphoreHandleType as Type;
    let name = std::ptr::null();
    let win32 = sys::CUDA_EXTERNAL_SEMAPHORE_HANDLE_DESC_st__bindgen_ty_1__bindgen_ty_1 { handle: handle.raw(), name };
    let described = sys::CUDA_EXTERNAL_SEMAPHORE_HANDLE_DESC_st__bindgen_ty_1 { win32 };
    match kind {
        Semaphores::Timeline => (Type::CU_EXTERNAL_SEMAPHORE_HANDLE_TYPE_TIMELINE_SEMAPHORE_WIN32, described),
        _ => (Type::CU_EXTERNAL_SEMAPHORE_HANDLE_TYPE_OPAQUE_WIN32, described),
    }
}
