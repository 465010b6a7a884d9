//! A device for tests: the emulated one, which records what it is asked for and can be told to fail, or to find other numbers
//! than there are.

use super::{Argument, Buffer, Gpu, GpuError, Pod, Shape};
use crate::emulated::{Device, LaunchError};
use crate::vulkan::{SharedBuffer, SharedSemaphore};
use std::sync::Arc;
use std::time::Instant;

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Event {
    Open(&'static str),
    Launch(String),
    /// Bytes that were uploaded or downloaded.
    Transfer(usize),
    Close,
    Record,
    Run,
    /// What can't be done while launches are recorded.
    Broken(&'static str),
}

#[derive(Debug, Default)]
pub(crate) struct Recorded {
    pub device: Device,
    pub events: Vec<Event>,
    /// Launches that go well; all others fail.
    pub launches: Option<usize>,
    /// What the first launch of a kernel leaves, in place of what it found.
    pub finds: Option<Find>,
    pub buffers: Vec<Buffer<u8>>,
    pub recording: bool,
}

/// A number in a kernel's memory.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Find {
    pub kernel: &'static str,
    /// The argument that has its address, counted from the last one, and which byte of it.
    pub argument: usize,
    pub byte: usize,
    pub number: u64,
}

impl Recorded {
    pub fn kernels(&self) -> impl Iterator<Item = &str> {
        self.events.iter().filter_map(|event| match event {
            Event::Launch(kernel) => Some(kernel.as_str()),
            _ => None,
        })
    }

    fn own<T: Pod>(&mut self, buffer: Buffer<T>) -> Buffer<T> {
        self.buffers.push(buffer.bytes());
        buffer
    }

    /// Puts a number where an argument points.
    fn put(&mut self, find: &Find, arguments: &[&dyn Argument]) -> Result<(), GpuError> {
        let argument = arguments[arguments.len() - 1 - find.argument].bytes();
        let address = argument[find.byte..find.byte + 8].try_into().map(u64::from_le_bytes).expect("eight bytes");
        let begins = |b: &&Buffer<u8>| (b.pointer.bits..b.pointer.bits + b.length as u64).contains(&address);
        let buffer = *self.buffers.iter().find(begins).expect("memory of this device");
        let mut bytes = self.device.download(&buffer)?;
        let place = (address - buffer.pointer.bits) as usize;
        bytes[place..place + 8].copy_from_slice(&find.number.to_le_bytes());
        Ok(self.device.write(&buffer, &bytes)?)
    }
}

impl Recorded {
    fn waits(&mut self, what: &'static str) {
        if self.recording {
            self.events.push(Event::Broken(what));
        }
    }
}

impl Gpu for Recorded {
    type Mark = Instant;

    fn allocate<T: Pod>(&mut self, length: usize) -> Result<Buffer<T>, GpuError> {
        self.waits("allocate");
        Gpu::allocate(&mut self.device, length).map(|b| self.own(b))
    }

    fn zeroed<T: Pod>(&mut self, length: usize) -> Result<Buffer<T>, GpuError> {
        self.waits("zeroed");
        Gpu::zeroed(&mut self.device, length).map(|b| self.own(b))
    }

    fn upload<T: Pod>(&mut self, data: &[T]) -> Result<Buffer<T>, GpuError> {
        self.waits("upload");
        self.events.push(Event::Transfer(size_of_val(data)));
        Gpu::upload(&mut self.device, data).map(|b| self.own(b))
    }

    fn download<T: Pod>(&mut self, buffer: &Buffer<T>) -> Result<Vec<T>, GpuError> {
        self.waits("download");
        self.events.push(Event::Transfer(buffer.len() * size_of::<T>()));
        Gpu::download(&mut self.device, buffer)
    }

    fn clear<T: Pod>(&mut self, buffer: &Buffer<T>) -> Result<(), GpuError> {
        Gpu::clear(&mut self.device, buffer)
    }

    fn free<T: Pod>(&mut self, buffer: Buffer<T>) -> Result<(), GpuError> {
        Gpu::free(&mut self.device, buffer)
    }

    fn adopt(&mut self, memory: &SharedBuffer) -> Result<Buffer<u8>, GpuError> {
        self.waits("adopt");
        self.device.adopt(memory).map(|b| self.own(b))
    }

    fn signal(&mut self, semaphore: &Arc<SharedSemaphore>, value: u64) -> Result<(), GpuError> {
        self.waits("signal");
        self.device.signal(semaphore, value)
    }

    fn wait(&mut self, semaphore: &Arc<SharedSemaphore>, value: u64) -> Result<(), GpuError> {
        self.waits("wait");
        self.device.wait(semaphore, value)
    }

    fn launch(&mut self, kernel: &str, shape: Shape, arguments: &[&dyn Argument]) -> Result<(), GpuError> {
        if self.launches.is_some_and(|most| self.kernels().count() >= most) {
            return Err(LaunchError::NotBuilt("a test wants it so").into());
        }
        self.events.push(Event::Launch(kernel.to_owned()));
        Gpu::launch(&mut self.device, kernel, shape, arguments)?;
        match self.finds.take_if(|find| find.kernel == kernel) {
            Some(find) => self.put(&find, arguments),
            None => Ok(()),
        }
    }

    fn record(&mut self) -> Result<(), GpuError> {
        self.recording = true;
        self.events.push(Event::Record);
        Ok(())
    }

    fn run(&mut self) -> Result<(), GpuError> {
        if std::mem::take(&mut self.recording) {
            self.events.push(Event::Run);
        }
        Ok(())
    }

    fn abandon(&mut self) {
        self.recording = false;
    }

    fn finish(&mut self) -> Result<(), GpuError> {
        self.waits("finish");
        self.device.finish()
    }

    fn mark(&mut self) -> Result<Instant, GpuError> {
        self.device.mark()
    }

    fn between(&mut self, from: &Instant, to: &Instant) -> Result<f64, GpuError> {
        self.device.between(from, to)
    }

    fn open(&mut self, name: &'static str) {
        self.events.push(Event::Open(name));
    }

    fn close(&mut self) {
        self.events.push(Event::Close);
    }
}
