//! What a frame needs of a device: memory and launches. A GPU has them, and so has the CPU in its place (`emulated`).
#![allow(unsafe_code)]

use super::{CudaError, abi};
use crate::emulated::LaunchError;
use crate::vulkan::{SharedBuffer, SharedSemaphore, VulkanError};
use std::marker::PhantomData;
use std::sync::Arc;
use thiserror::Error;

/// Plain data that kernels read and write.
///
/// # Safety
/// Any bytes must be a valid value, there must be no padding, and the layout must be that of the kernels' type.
pub unsafe trait Pod: Copy + Send + Sync + 'static {}

/// Says of types that they are plain data: numbers of C's size, what bindgen made of what the kernels include, and structures of
/// pointers that a kernel has too. None has padding.
macro_rules! pods {
    ($($plain:ty)*) => { $(
        // SAFETY: as above; any bytes are a value of it.
        #[allow(unsafe_code)]
        unsafe impl $crate::cuda::Pod for $plain {}
    )* };
}
pub(crate) use pods;
pods!(u8 i8 u16 i16 u32 i32 u64 i64 f32 f64);
pods!(abi::View abi::Patch abi::Leaf abi::Meshlet abi::Point abi::Vertex abi::Filled abi::Start abi::Fragment abi::Shown abi::Band);
pods!(abi::SurfacePoint abi::SurfaceFrame);
// SAFETY: an array is its elements, without padding between them.
unsafe impl<T: Pod, const N: usize> Pod for [T; N] {}
// SAFETY: it is a u64; kernels check what it points at where anything can.
unsafe impl<T: Pod> Pod for Pointer<T> {}

/// A kernel's `Buffer<T>`: an address, or null. On the CPU it names its allocation too.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(transparent)]
pub struct Pointer<T> {
    pub(crate) bits: u64,
    pub(crate) element: PhantomData<fn() -> T>,
}

impl<T> Pointer<T> {
    pub const NULL: Self = Self { bits: 0, element: PhantomData };

    pub(crate) fn new(bits: u64) -> Self {
        Self { bits, element: PhantomData }
    }

    /// So many elements further on.
    pub(crate) fn offset(self, elements: usize) -> Self {
        Self::new(self.bits + (elements * size_of::<T>()) as u64)
    }
}

/// An allocation of a device, freed with the device or by [`Gpu::free`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Buffer<T> {
    pub(crate) pointer: Pointer<T>,
    pub(crate) number: usize,
    pub(crate) length: usize,
}

impl<T> Buffer<T> {
    /// Number of elements.
    pub fn len(&self) -> usize {
        self.length
    }

    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// The same allocation as elements of another type, as many as it has room for.
    pub(crate) fn of<U>(&self) -> Buffer<U> {
        let length = self.length * size_of::<T>() / size_of::<U>();
        Buffer { pointer: Pointer::new(self.pointer.bits), number: self.number, length }
    }

    /// The same allocation as bytes.
    pub(crate) fn bytes(&self) -> Buffer<u8> {
        Buffer { pointer: Pointer::new(self.pointer.bits), number: self.number, length: self.length * size_of::<T>() }
    }

    /// What a kernel gets.
    pub fn pointer(&self) -> Pointer<T> {
        Pointer { ..self.pointer }
    }
}

/// Blocks and threads of a launch.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Shape {
    pub grid: [u32; 3],
    pub block: [u32; 3],
    /// Of shared memory, besides what kernels declare.
    pub dynamic_bytes: u32,
}

impl Shape {
    /// A row of blocks, without dynamic shared memory.
    pub fn row(blocks: u32, threads: u32) -> Self {
        Self { grid: [blocks, 1, 1], block: [threads, 1, 1], dynamic_bytes: 0 }
    }

    /// As many blocks of `threads` as it takes for `count` threads.
    pub fn of(count: usize, threads: u32) -> Self {
        Self::row((count as u64).div_ceil(u64::from(threads)) as u32, threads)
    }

    pub fn with_dynamic(self, dynamic_bytes: u32) -> Self {
        Self { dynamic_bytes, ..self }
    }
}

/// What a kernel can be given: a number, a structure, the buffer's address for a buffer.
pub trait Argument {
    fn bytes(&self) -> &[u8];
}

impl<T: Pod> Argument for T {
    fn bytes(&self) -> &[u8] {
        bytes_of(std::slice::from_ref(self))
    }
}

/// The bytes of some values.
pub(crate) fn bytes_of<T: Pod>(values: &[T]) -> &[u8] {
    // SAFETY: a Pod has no padding, so all its bytes are initialised; they live as long as the values.
    unsafe { std::slice::from_raw_parts(values.as_ptr().cast::<u8>(), size_of_val(values)) }
}

/// Why a device did not do what it was asked.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum GpuError {
    #[error(transparent)]
    Emulated(#[from] LaunchError),
    #[error(transparent)]
    Cuda(#[from] CudaError),
    #[error("--raster: {0}")]
    Vulkan(#[from] VulkanError),
    #[error("a frame that asked for all its numbers had no room for something")]
    Unsettled,
    #[error("this view needs {needed} {what}; a frame holds {limit}")]
    TooMany { what: &'static str, needed: u64, limit: u64 },
}

/// Memory and launches of one device. Launches follow each other; reading waits for them.
pub trait Gpu {
    /// A point in the order of launches.
    type Mark: std::fmt::Debug;

    /// Room for `length` elements, which hold anything.
    fn allocate<T: Pod>(&mut self, length: usize) -> Result<Buffer<T>, GpuError>;

    /// The same with every byte 0.
    fn zeroed<T: Pod>(&mut self, length: usize) -> Result<Buffer<T>, GpuError>;

    /// A new buffer with this data.
    fn upload<T: Pod>(&mut self, data: &[T]) -> Result<Buffer<T>, GpuError>;

    /// All elements.
    fn download<T: Pod>(&mut self, buffer: &Buffer<T>) -> Result<Vec<T>, GpuError>;

    /// Sets every byte to 0.
    fn clear<T: Pod>(&mut self, buffer: &Buffer<T>) -> Result<(), GpuError>;

    /// Gives memory back; what runs still uses it to its end.
    fn free<T: Pod>(&mut self, buffer: Buffer<T>) -> Result<(), GpuError>;

    /// What Vulkan knows this device by, if it does.
    fn vulkan_uuid(&self) -> Option<&str> {
        None
    }

    /// Memory of Vulkan as a buffer of this device. [`Gpu::free`] gives this device's part of it back; Vulkan keeps its own.
    /// Who writes when is for callers to order, by [`Gpu::signal`] and [`Gpu::wait`] or by waiting for the end of everything.
    fn adopt(&mut self, memory: &SharedBuffer) -> Result<Buffer<u8>, GpuError>;

    /// Signals a semaphore after all that was launched; a timeline gets this value, a binary semaphore has none. Like
    /// [`Gpu::wait`] and [`Gpu::adopt`], not while launches are recorded.
    fn signal(&mut self, semaphore: &Arc<SharedSemaphore>, value: u64) -> Result<(), GpuError>;

    /// What is launched from here on waits until a semaphore is signalled, a timeline until it has reached this value.
    fn wait(&mut self, semaphore: &Arc<SharedSemaphore>, value: u64) -> Result<(), GpuError>;

    /// Runs a kernel. Arguments must be the kernel's parameters, in order; a buffer is passed as its [`Buffer::pointer`].
    fn launch(&mut self, kernel: &str, shape: Shape, arguments: &[&dyn Argument]) -> Result<(), GpuError>;

    /// From here on what is launched, cleared and marked may be recorded, to be run by [`Gpu::run`]. Nothing may be allocated,
    /// uploaded or downloaded before that.
    fn record(&mut self) -> Result<(), GpuError> {
        Ok(())
    }

    /// Runs what was recorded.
    fn run(&mut self) -> Result<(), GpuError> {
        Ok(())
    }

    /// Forgets it.
    fn abandon(&mut self) {}

    /// What was launched has ended.
    fn finish(&mut self) -> Result<(), GpuError>;

    /// The point after everything that has been launched.
    fn mark(&mut self) -> Result<Self::Mark, GpuError>;

    /// Milliseconds from one point to a later one, by the device's own clock; waits for it.
    fn between(&mut self, from: &Self::Mark, to: &Self::Mark) -> Result<f64, GpuError>;

    /// What is launched until the matching [`Gpu::close`] belongs together, for profilers that show it under this name.
    fn open(&mut self, _name: &'static str) {}

    /// Ends the range that was opened last and is still open.
    fn close(&mut self) {}
}
