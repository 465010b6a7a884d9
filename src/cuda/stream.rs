//! A GPU as the frame uses it: one stream on one device, and its memory.

use super::external::{ExternalMemory, ExternalSemaphore};
use super::gpu::bytes_of;
use super::graph::Graph;
use super::ranges::Ranges;
use super::{Argument, Buffer, CudaError, Device, Gpu, GpuError, Kernels, OLDEST_DEVICE, Pod, Pointer, Shape, devices};
use crate::vulkan::{Semaphores, SharedBuffer, SharedSemaphore};
use cudarc::driver::{CudaEvent, CudaFunction, CudaSlice, CudaStream, DevicePtr, result, sys};
use foldhash::{HashMap, HashMapExt};
use std::ffi::c_void;
use std::sync::{Arc, Weak};

/// Memory of a stream.
#[derive(Debug)]
enum Memory {
    Own(CudaSlice<u8>),
    /// Vulkan's.
    External(ExternalMemory),
}

impl Memory {
    fn bytes(&self) -> usize {
        match self {
            Self::Own(slice) => slice.len(),
            Self::External(memory) => memory.bytes(),
        }
    }
}

/// Launches follow each other on one stream.
#[derive(Debug)]
pub struct Stream {
    name: String,
    compute_capability: [i32; 2],
    vulkan_uuid: String,
    kernels: Kernels,
    stream: Arc<CudaStream>,
    /// By [`Buffer`]'s number.
    memory: Vec<Option<Memory>>,
    unused: Vec<usize>,
    /// Imported once each.
    semaphores: Vec<(Weak<SharedSemaphore>, ExternalSemaphore)>,
    functions: HashMap<String, CudaFunction>,
    graph: Graph,
    ranges: Ranges,
}

impl Stream {
    /// On the device with this number.
    pub fn new(ordinal: usize) -> Result<Self, CudaError> {
        let kernels = Kernels::load(ordinal)?;
        let stream = kernels.context().new_stream().map_err(CudaError::of_driver("making a CUDA stream"))?;
        keep_memory(ordinal);
        let device = devices()?.into_iter().find(|d| d.ordinal == ordinal);
        let driver = |d: &Device| d.driver.version.clone().unwrap_or_else(|| "unknown".into());
        Ok(Self {
            name: device.as_ref().map_or_else(String::new, |d| format!("{}, driver {}", d.name, driver(d))),
            vulkan_uuid: device.as_ref().map_or_else(String::new, |d| d.vulkan_uuid().into()),
            compute_capability: device.map_or(OLDEST_DEVICE, |d| d.compute_capability),
            kernels,
            stream,
            memory: Vec::new(),
            unused: Vec::new(),
            semaphores: Vec::new(),
            functions: HashMap::new(),
            graph: Graph::default(),
            ranges: Ranges::new(),
        })
    }

    pub fn compute_capability(&self) -> [i32; 2] {
        self.compute_capability
    }

    /// The best semaphores that can be shared with Vulkan.
    pub fn semaphores(&self) -> Semaphores {
        let timelines = sys::CUdevice_attribute::CU_DEVICE_ATTRIBUTE_TIMELINE_SEMAPHORE_INTEROP_SUPPORTED;
        match self.stream.context().attribute(timelines) {
            Ok(yes) if yes != 0 => Semaphores::Timeline,
            _ => Semaphores::Binary,
        }
    }

    /// The device and its driver, as rows of measurements name them.
    pub fn name(&self) -> &str {
        &self.name
    }

    fn keep<T>(&mut self, slice: CudaSlice<u8>, length: usize) -> Buffer<T> {
        let bits = slice.device_ptr(&self.stream).0;
        self.put(Memory::Own(slice), bits, length)
    }

    fn put<T>(&mut self, memory: Memory, bits: u64, length: usize) -> Buffer<T> {
        let number = self.unused.pop().unwrap_or(self.memory.len());
        if number == self.memory.len() {
            self.memory.push(None);
        }
        self.memory[number] = Some(memory);
        Buffer { pointer: Pointer::new(bits), number, length }
    }

    fn memory<T>(&self, buffer: &Buffer<T>) -> Result<&Memory, CudaError> {
        let bytes = buffer.length * size_of::<T>();
        let found = self.memory.get(buffer.number).and_then(Option::as_ref);
        found.filter(|memory| memory.bytes() >= bytes).ok_or(CudaError::NoSuchBuffer { bytes })
    }

    fn semaphore(&mut self, of: &Arc<SharedSemaphore>) -> Result<&ExternalSemaphore, GpuError> {
        self.semaphores.retain(|(known, _)| known.strong_count() > 0);
        let known = self.semaphores.iter().position(|(known, _)| std::ptr::eq(known.as_ptr(), Arc::as_ptr(of)));
        let place = match known {
            Some(place) => place,
            None => {
                let imported = ExternalSemaphore::import(&self.stream, of.export()?, of.kind())?;
                self.semaphores.push((Arc::downgrade(of), imported));
                self.semaphores.len() - 1
            }
        };
        Ok(&self.semaphores[place].1)
    }

    fn function(&mut self, kernel: &str) -> Result<CudaFunction, CudaError> {
        if let Some(function) = self.functions.get(kernel) {
            return Ok(function.clone());
        }
        let function = self.kernels.get(kernel)?;
        self.functions.insert(kernel.into(), function.clone());
        Ok(function)
    }
}

/// What frames give back stays with the program: to ask the driver for it again takes longer than to draw.
/// A device without pools of memory draws the same.
fn keep_memory(ordinal: usize) {
    let Ok(device) = result::device::get(ordinal as i32) else { return };
    let mut all = u64::MAX;
    let threshold = sys::CUmemPool_attribute::CU_MEMPOOL_ATTR_RELEASE_THRESHOLD;
    // SAFETY: the device is the driver's own, and its default pool lives as long; the attribute is a u64.
    let _ = unsafe {
        result::device::get_default_mem_pool(device)
            .and_then(|pool| result::mem_pool::set_attribute(pool, threshold, (&raw mut all).cast::<c_void>()))
    };
}

/// The driver makes no allocations of nothing.
fn room<T>(length: usize) -> usize {
    (length * size_of::<T>()).max(1)
}

impl Gpu for Stream {
    type Mark = Arc<CudaEvent>;

    fn vulkan_uuid(&self) -> Option<&str> {
        Some(&self.vulkan_uuid)
    }

    fn allocate<T: Pod>(&mut self, length: usize) -> Result<Buffer<T>, GpuError> {
        // SAFETY: the bytes hold anything, as callers are told; kernels write them before anyone reads them.
        let slice = unsafe { self.stream.alloc::<u8>(room::<T>(length)) };
        let slice = slice.map_err(CudaError::of_driver("allocating memory of the GPU"))?;
        Ok(self.keep(slice, length))
    }

    fn zeroed<T: Pod>(&mut self, length: usize) -> Result<Buffer<T>, GpuError> {
        let slice = self.stream.alloc_zeros::<u8>(room::<T>(length));
        let slice = slice.map_err(CudaError::of_driver("allocating memory of the GPU"))?;
        Ok(self.keep(slice, length))
    }

    fn upload<T: Pod>(&mut self, data: &[T]) -> Result<Buffer<T>, GpuError> {
        if data.is_empty() {
            return self.allocate(0);
        }
        let slice = self.stream.clone_htod(bytes_of(data));
        let slice = slice.map_err(CudaError::of_driver("copying data to the GPU"))?;
        Ok(self.keep(slice, data.len()))
    }

    fn download<T: Pod>(&mut self, buffer: &Buffer<T>) -> Result<Vec<T>, GpuError> {
        // SAFETY: any bytes are a T, zeros too.
        let mut data: Vec<T> = vec![unsafe { std::mem::zeroed() }; buffer.length];
        let bytes = size_of_val(&data[..]);
        if bytes > 0 {
            // SAFETY: the bytes of the vector, borrowed exclusively; any bytes are a T.
            let target = unsafe { std::slice::from_raw_parts_mut(data.as_mut_ptr().cast::<u8>(), bytes) };
            let copied = match self.memory(buffer)? {
                Memory::Own(slice) => self.stream.memcpy_dtoh(&slice.slice(..bytes), target),
                // SAFETY: `memory` has seen that there are as many bytes; the copy ends before `data` does, in `finish`.
                Memory::External(memory) => unsafe {
                    result::memcpy_dtoh_async(target, memory.pointer(), self.stream.cu_stream())
                },
            };
            copied.map_err(CudaError::of_driver("copying data from the GPU"))?;
        }
        self.finish()?;
        Ok(data)
    }

    fn clear<T: Pod>(&mut self, buffer: &Buffer<T>) -> Result<(), GpuError> {
        let bytes = self.memory(buffer)?.bytes();
        let failed = CudaError::of_driver("clearing memory of the GPU");
        // SAFETY: the allocation has as many bytes, and is used by this stream alone.
        let cleared = unsafe { result::memset_d8_async(buffer.pointer.bits, 0, bytes, self.stream.cu_stream()) };
        Ok(cleared.map_err(failed)?)
    }

    fn free<T: Pod>(&mut self, buffer: Buffer<T>) -> Result<(), GpuError> {
        self.memory(&buffer)?;
        // Given back in the order of the stream, or once nothing runs: what runs still has it.
        self.memory[buffer.number] = None;
        self.unused.push(buffer.number);
        Ok(())
    }

    fn adopt(&mut self, memory: &SharedBuffer) -> Result<Buffer<u8>, GpuError> {
        let imported = ExternalMemory::import(&self.stream, memory.export()?, memory.bytes(), memory.allocation())?;
        let (bits, length) = (imported.pointer(), imported.bytes());
        Ok(self.put(Memory::External(imported), bits, length))
    }

    fn signal(&mut self, semaphore: &Arc<SharedSemaphore>, value: u64) -> Result<(), GpuError> {
        Ok(self.semaphore(semaphore)?.signal(value)?)
    }

    fn wait(&mut self, semaphore: &Arc<SharedSemaphore>, value: u64) -> Result<(), GpuError> {
        Ok(self.semaphore(semaphore)?.wait(value)?)
    }

    fn launch(&mut self, kernel: &str, shape: Shape, arguments: &[&dyn Argument]) -> Result<(), GpuError> {
        let function = self.function(kernel)?;
        let context = self.kernels.context();
        context.bind_to_thread().map_err(CudaError::of_driver("choosing the GPU"))?;
        let mut parameters: Vec<*mut c_void> =
            arguments.iter().map(|a| a.bytes().as_ptr().cast_mut().cast::<c_void>()).collect();
        let ([gx, gy, gz], [bx, by, bz]) = (shape.grid, shape.block);
        // SAFETY: the parameters are the kernel's own, in order (on the CPU each is checked by number and size); the driver
        // reads them before this call ends.
        let launched = unsafe {
            result::launch_kernel(
                function.cu_function(),
                (gx, gy, gz),
                (bx, by, bz),
                shape.dynamic_bytes,
                self.stream.cu_stream(),
                &mut parameters,
            )
        };
        launched.map_err(CudaError::of_kernel(kernel))?;
        Ok(())
    }

    fn finish(&mut self) -> Result<(), GpuError> {
        Ok(self.stream.synchronize().map_err(CudaError::of_driver("waiting for the GPU"))?)
    }

    fn record(&mut self) -> Result<(), GpuError> {
        Ok(self.graph.begin(&self.stream)?)
    }

    fn run(&mut self) -> Result<(), GpuError> {
        Ok(self.graph.run(&self.stream)?)
    }

    fn abandon(&mut self) {
        self.graph.abandon(&self.stream);
    }

    fn mark(&mut self) -> Result<Arc<CudaEvent>, GpuError> {
        if self.graph.is_recording() {
            return Ok(self.graph.mark(&self.stream)?);
        }
        // Events that cudarc makes by default tell no time.
        let event = self.stream.record_event(Some(sys::CUevent_flags::CU_EVENT_DEFAULT));
        Ok(Arc::new(event.map_err(CudaError::of_driver("recording a CUDA event"))?))
    }

    fn between(&mut self, from: &Arc<CudaEvent>, to: &Arc<CudaEvent>) -> Result<f64, GpuError> {
        let ms = from.elapsed_ms(to).map_err(CudaError::of_driver("timing by CUDA events"))?;
        Ok(ms.into())
    }

    fn open(&mut self, name: &'static str) {
        self.ranges.open(name);
    }

    fn close(&mut self) {
        self.ranges.close();
    }
}
