//! A device for tests: the emulated one, which records what it is asked for and can be told to fail, or to find other counts
//! than there are.

use super::{Argument, Buffer, Gpu, GpuError, Pod, Shape};
use crate::emulated::{Device, LaunchError};
use std::time::Instant;

#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Event {
    Open(&'static str),
    Launch(String),
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
    /// After a launch of this kernel the first number that is downloaded is this one.
    pub finds: Option<(&'static str, u64)>,
    pub recording: bool,
}

impl Recorded {
    pub fn kernels(&self) -> impl Iterator<Item = &str> {
        self.events.iter().filter_map(|event| match event {
            Event::Launch(kernel) => Some(kernel.as_str()),
            _ => None,
        })
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
        Gpu::allocate(&mut self.device, length)
    }

    fn zeroed<T: Pod>(&mut self, length: usize) -> Result<Buffer<T>, GpuError> {
        self.waits("zeroed");
        Gpu::zeroed(&mut self.device, length)
    }

    fn upload<T: Pod>(&mut self, data: &[T]) -> Result<Buffer<T>, GpuError> {
        self.waits("upload");
        Gpu::upload(&mut self.device, data)
    }

    fn download<T: Pod>(&mut self, buffer: &Buffer<T>) -> Result<Vec<T>, GpuError> {
        self.waits("download");
        if let Some((kernel, number)) = self.finds
            && self.kernels().any(|launched| launched == kernel)
        {
            self.finds = None;
            let mut bytes = Gpu::download(&mut self.device, &buffer.bytes())?;
            let length = bytes.len().min(8);
            bytes[..length].copy_from_slice(&number.to_le_bytes()[..length]);
            self.device.write(&buffer.bytes(), &bytes)?;
        }
        Gpu::download(&mut self.device, buffer)
    }

    fn clear<T: Pod>(&mut self, buffer: &Buffer<T>) -> Result<(), GpuError> {
        Gpu::clear(&mut self.device, buffer)
    }

    fn free<T: Pod>(&mut self, buffer: Buffer<T>) -> Result<(), GpuError> {
        Gpu::free(&mut self.device, buffer)
    }

    fn launch(&mut self, kernel: &str, shape: Shape, arguments: &[&dyn Argument]) -> Result<(), GpuError> {
        if self.launches.is_some_and(|most| self.kernels().count() >= most) {
            return Err(LaunchError::NotBuilt("a test wants it so").into());
        }
        self.events.push(Event::Launch(kernel.to_owned()));
        Gpu::launch(&mut self.device, kernel, shape, arguments)
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
