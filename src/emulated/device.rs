use super::memory::Memory;
use super::schedule::Schedule;
use super::{LaunchError, Recording, ffi};
use crate::cuda::{Argument, Buffer, Gpu, GpuError, Pod, Shape, bytes_of};
use crate::vulkan::{SharedBuffer, SharedSemaphore, VulkanError};
use std::fmt;
use std::sync::Arc;
use std::thread;
use std::time::{Duration, Instant};

/// Vulkan has this long to signal a semaphore: as long as a list of its commands may take.
const PATIENCE: Duration = Duration::from_secs(120);

/// Memory and launches, as of a GPU. Devices share nothing: tests with one each can run side by side.
pub struct Device {
    pub schedule: Schedule,
    /// How many threads of the CPU share the blocks of a launch.
    pub threads: usize,
    memory: Memory,
    recording: Option<Recording>,
}

impl fmt::Debug for Device {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.debug_struct("Device").field("schedule", &self.schedule).field("threads", &self.threads).finish()
    }
}

impl Default for Device {
    fn default() -> Self {
        let threads = thread::available_parallelism().map_or(1, Into::into);
        Self { schedule: Schedule::default(), threads, memory: Memory::default(), recording: None }
    }
}

impl Device {
    /// A device with these orders.
    pub fn new(schedule: Schedule, threads: usize) -> Self {
        Self { schedule, threads, ..Self::default() }
    }

    /// From here on everything is recorded that it is asked for.
    pub fn record(&mut self) -> Recording {
        let recording = Recording::default();
        for (number, bits, contents) in self.memory.contents() {
            recording.allocated(bits, contents.len(), 0);
            recording.written(number, contents);
        }
        self.recording = Some(recording.clone());
        recording
    }

    /// How many there are.
    #[cfg(test)]
    pub(crate) fn allocations(&self) -> usize {
        self.memory.contents().count()
    }

    fn make<T: Pod>(&mut self, length: usize, fill: u8) -> Buffer<T> {
        let buffer = self.memory.allocate(length, fill);
        if let Some(recording) = &self.recording {
            recording.allocated(buffer.pointer().bits, length * size_of::<T>(), fill);
        }
        buffer
    }

    /// Room for `length` elements. It holds no data yet: every byte is 0xff, a NaN or -1.
    pub fn allocate<T: Pod>(&mut self, length: usize) -> Buffer<T> {
        self.make(length, 0xff)
    }

    pub fn zeroed<T: Pod>(&mut self, length: usize) -> Buffer<T> {
        self.make(length, 0)
    }

    pub fn upload<T: Pod>(&mut self, data: &[T]) -> Buffer<T> {
        let buffer = self.allocate(data.len());
        self.write(&buffer, data).expect("a buffer of just this size");
        buffer
    }

    /// Replaces all elements of a buffer.
    pub fn write<T: Pod>(&mut self, buffer: &Buffer<T>, data: &[T]) -> Result<(), LaunchError> {
        self.memory.write(buffer, data)?;
        if let Some(recording) = &self.recording {
            recording.written(buffer.number, bytes_of(data));
        }
        Ok(())
    }

    pub fn download<T: Pod>(&self, buffer: &Buffer<T>) -> Result<Vec<T>, LaunchError> {
        self.memory.read(buffer)
    }

    /// Kernels that still use it are stopped with a diagnosis.
    pub fn free<T>(&mut self, buffer: &Buffer<T>) -> Result<(), LaunchError> {
        self.memory.free(buffer)?;
        if let Some(recording) = &self.recording {
            recording.freed(buffer.number);
        }
        Ok(())
    }

    /// Runs a kernel to its end. Arguments must be the kernel's parameters, in order; a buffer is passed as its
    /// [`Buffer::pointer`].
    ///
    /// A kernel that uses plain C++ pointers beyond their memory is beyond this check; the sanitizers find it
    /// (`scripts/sanitize_kernels.sh`).
    pub fn launch(&mut self, kernel: &str, shape: Shape, arguments: &[&dyn Argument]) -> Result<(), LaunchError> {
        let bytes: Vec<&[u8]> = arguments.iter().map(|a| a.bytes()).collect();
        ffi::launch(kernel, &shape, &self.schedule, self.threads, &bytes, &mut self.memory)?;
        if let Some(recording) = &self.recording {
            let after = self.memory.contents().map(|(number, _, contents)| (number, contents));
            recording.launched(kernel, &shape, &self.schedule, &bytes, after);
        }
        Ok(())
    }
}

impl Gpu for Device {
    /// Launches run to their end at once.
    type Mark = Instant;

    fn allocate<T: Pod>(&mut self, length: usize) -> Result<Buffer<T>, GpuError> {
        Ok(Device::allocate(self, length))
    }

    fn zeroed<T: Pod>(&mut self, length: usize) -> Result<Buffer<T>, GpuError> {
        Ok(Device::zeroed(self, length))
    }

    fn upload<T: Pod>(&mut self, data: &[T]) -> Result<Buffer<T>, GpuError> {
        Ok(Device::upload(self, data))
    }

    fn download<T: Pod>(&mut self, buffer: &Buffer<T>) -> Result<Vec<T>, GpuError> {
        Ok(Device::download(self, buffer)?)
    }

    fn clear<T: Pod>(&mut self, buffer: &Buffer<T>) -> Result<(), GpuError> {
        Ok(self.memory.clear(buffer)?)
    }

    fn free<T: Pod>(&mut self, buffer: Buffer<T>) -> Result<(), GpuError> {
        Ok(Device::free(self, &buffer)?)
    }

    /// The same bytes, where the host sees them. A [`Recording`] has what they are now, not what Vulkan writes later.
    fn adopt(&mut self, memory: &SharedBuffer) -> Result<Buffer<u8>, GpuError> {
        let buffer = self.memory.adopt(memory)?;
        if let Some(recording) = &self.recording {
            recording.allocated(buffer.pointer().bits, buffer.len(), 0);
            recording.written(buffer.number, &self.memory.read(&buffer)?);
        }
        Ok(buffer)
    }

    /// Launches have ended: the host signals.
    fn signal(&mut self, semaphore: &Arc<SharedSemaphore>, value: u64) -> Result<(), GpuError> {
        Ok(semaphore.signal(value)?)
    }

    fn wait(&mut self, semaphore: &Arc<SharedSemaphore>, value: u64) -> Result<(), GpuError> {
        if semaphore.wait(value, PATIENCE)? {
            return Ok(());
        }
        Err(VulkanError::NotSignalled { value }.into())
    }

    fn launch(&mut self, kernel: &str, shape: Shape, arguments: &[&dyn Argument]) -> Result<(), GpuError> {
        Ok(Device::launch(self, kernel, shape, arguments)?)
    }

    fn finish(&mut self) -> Result<(), GpuError> {
        Ok(())
    }

    fn mark(&mut self) -> Result<Instant, GpuError> {
        Ok(Instant::now())
    }

    fn between(&mut self, from: &Instant, to: &Instant) -> Result<f64, GpuError> {
        Ok((*to - *from).as_secs_f64() * 1e3)
    }
}
