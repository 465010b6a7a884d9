//! Memory that a frame's device and Vulkan's both see: what mesh shaders read and write of a frame. Vulkan allocates it, the
//! device adopts it, and both keep it from frame to frame.

use super::{Buffer, Gpu, GpuError, Pod};
use crate::vulkan::{Device, Order, Semaphores, SharedBuffer, SharedSemaphore};
use std::sync::Arc;

/// What a buffer is for.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Role {
    Patches,
    Leaves,
    Meshlets,
    Vertices,
    /// Workgroups of mesh shaders.
    Jobs,
    Near,
    Spare,
}

const ROLES: usize = Role::Spare as usize + 1;

#[derive(Debug)]
struct Place {
    memory: SharedBuffer,
    /// The same for the frame's device.
    buffer: Buffer<u8>,
    /// As many as were asked for.
    bytes: u64,
}

/// What two devices share.
#[derive(Debug)]
pub(crate) struct Shared {
    device: Arc<Device>,
    places: [Option<Place>; ROLES],
    /// What the frame's device signals, with a timeline's last value; None: the host waits for it.
    semaphore: Option<(Arc<SharedSemaphore>, u64)>,
}

impl Shared {
    /// Whether memory can be shared is found out by sharing some. None: it is copied.
    pub fn new<G: Gpu>(gpu: &mut G, device: &Arc<Device>) -> Option<Self> {
        let memory = SharedBuffer::new(device, 1).ok()?;
        let buffer = gpu.adopt(&memory).ok()?;
        gpu.free(buffer).ok()?;
        let mut made = |kind| {
            let semaphore = Arc::new(SharedSemaphore::new(device, kind).ok()?);
            gpu.signal(&semaphore, 1).and_then(|()| gpu.wait(&semaphore, 1)).and_then(|()| gpu.finish()).ok()?;
            Some((semaphore, 1))
        };
        let semaphore = made(Semaphores::Timeline).or_else(|| made(Semaphores::Binary));
        Some(Self { device: device.clone(), places: Default::default(), semaphore })
    }

    /// What it is shared with.
    pub fn device(&self) -> &Arc<Device> {
        &self.device
    }

    /// Room for `length` elements, which hold anything: the last frame's where it will do, since devices take long to share
    /// more.
    pub fn room<G: Gpu, T: Pod>(&mut self, gpu: &mut G, role: Role, length: usize) -> Result<Buffer<T>, GpuError> {
        let bytes = (length * size_of::<T>()).max(1) as u64;
        let place = &mut self.places[role as usize];
        let had = place.is_some();
        if let Some(old) = place.take_if(|place| place.bytes < bytes) {
            gpu.free(old.buffer)?;
        }
        let place = match place {
            Some(place) => place,
            none => {
                let mut made = |bytes: u64| -> Result<Place, GpuError> {
                    let memory = SharedBuffer::new(&self.device, bytes)?;
                    Ok(Place { buffer: gpu.adopt(&memory)?, memory, bytes })
                };
                // What is to spare may be too much.
                let more = if had { bytes + bytes / 4 } else { bytes };
                none.insert(made(more).or_else(|error| if more > bytes { made(bytes) } else { Err(error) })?)
            }
        };
        Ok(Buffer { length, ..place.buffer.of() })
    }

    /// Vulkan's side of a buffer that the frame has asked for.
    pub fn memory(&self, role: Role) -> Option<&SharedBuffer> {
        self.places[role as usize].as_ref().map(|place| &place.memory)
    }

    pub fn bytes(&self) -> u64 {
        self.places.iter().flatten().map(|place| place.buffer.len() as u64).sum()
    }

    /// After all that was launched, it is Vulkan's turn: signals that, or waits for it.
    pub fn hand_over<G: Gpu>(&mut self, gpu: &mut G) -> Result<(), GpuError> {
        let Some((semaphore, value)) = &mut self.semaphore else { return gpu.finish() };
        *value += 1;
        gpu.signal(semaphore, *value)
    }

    /// What Vulkan waits for then.
    pub fn order(&self) -> Order<'_> {
        Order { wait: self.semaphore.as_ref().map(|(semaphore, value)| (&**semaphore, *value)), signal: None }
    }

    /// Gives all of it back.
    pub fn free<G: Gpu>(self, gpu: &mut G) -> Result<(), GpuError> {
        self.places.into_iter().flatten().try_for_each(|place| gpu.free(place.buffer))
    }
}
