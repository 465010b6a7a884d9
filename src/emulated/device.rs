use super::memory::{Buffer, Memory, Pod, bytes_of};
use super::schedule::Schedule;
use super::{LaunchError, ffi};
use std::thread;

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
        bytes_of(self)
    }
}

/// Memory and launches, as of a GPU. Devices share nothing: tests with one each can run side by side.
pub struct Device {
    pub schedule: Schedule,
    /// How many threads of the CPU share the blocks of a launch.
    pub threads: usize,
    memory: Memory,
}

impl Default for Device {
    fn default() -> Self {
        let threads = thread::available_parallelism().map_or(1, Into::into);
        Self { schedule: Schedule::default(), threads, memory: Memory::default() }
    }
}

impl Device {
    /// A device with these orders.
    pub fn new(schedule: Schedule, threads: usize) -> Self {
        Self { schedule, threads, ..Self::default() }
    }

    /// Room for `length` elements. It holds no data yet: every byte is 0xff, a NaN or -1.
    pub fn allocate<T: Pod>(&mut self, length: usize) -> Buffer<T> {
        self.memory.allocate(length, 0xff)
    }

    pub fn zeroed<T: Pod>(&mut self, length: usize) -> Buffer<T> {
        self.memory.allocate(length, 0)
    }

    pub fn upload<T: Pod>(&mut self, data: &[T]) -> Buffer<T> {
        let buffer = self.allocate(data.len());
        self.memory.write(&buffer, data).expect("a buffer of just this size");
        buffer
    }

    /// Replaces all elements of a buffer.
    pub fn write<T: Pod>(&mut self, buffer: &Buffer<T>, data: &[T]) -> Result<(), LaunchError> {
        self.memory.write(buffer, data)
    }

    pub fn download<T: Pod>(&self, buffer: &Buffer<T>) -> Result<Vec<T>, LaunchError> {
        self.memory.read(buffer)
    }

    /// Kernels that still use it are stopped with a diagnosis.
    pub fn free<T>(&mut self, buffer: &Buffer<T>) -> Result<(), LaunchError> {
        self.memory.free(buffer)
    }

    /// Runs a kernel to its end. Arguments must be the kernel's parameters, in order; a buffer is passed as its
    /// [`Buffer::pointer`].
    ///
    /// A kernel that uses plain C++ pointers beyond their memory is beyond this check; the sanitizers find it
    /// (`scripts/sanitize_kernels.sh`).
    pub fn launch(&mut self, kernel: &str, shape: Shape, arguments: &[&dyn Argument]) -> Result<(), LaunchError> {
        let bytes: Vec<&[u8]> = arguments.iter().map(|a| a.bytes()).collect();
        ffi::launch(kernel, &shape, &self.schedule, self.threads, &bytes, &mut self.memory)
    }
}
