//! Buffers and semaphores that other APIs use too: CUDA, or another device of Vulkan.

use super::handle::{Handle, SEMAPHORE};
use super::memory::{Buffer, Use};
use super::recorder::{Copy, Recorder};
use super::{Device, Semaphores, VulkanError};
use ash::vk;
use std::sync::Arc;
use std::time::Duration;

const TIMELINES: &str = "timeline semaphores";

/// A buffer in exportable memory of its own, which lives as long as one of its clones.
#[derive(Clone)]
pub struct SharedBuffer {
    pub(super) buffer: Arc<Buffer>,
}

impl SharedBuffer {
    /// A buffer of at least so many bytes, which hold anything.
    pub fn new(device: &Arc<Device>, bytes: u64) -> Result<Self, VulkanError> {
        device.can_share(device.sharing.memory, "memory")?;
        Ok(Self { buffer: Buffer::new(device, bytes, Use::Shared)?.into() })
    }

    /// What another device has exported; `bytes` and `allocation` are those of the buffer there.
    pub fn import(device: &Arc<Device>, handle: Handle, bytes: u64, allocation: u64) -> Result<Self, VulkanError> {
        device.can_share(device.sharing.memory, "memory")?;
        Ok(Self { buffer: Buffer::import(device, handle, bytes, allocation)?.into() })
    }

    /// For one import of the memory, which lives until all who imported it have let it go.
    pub fn export(&self) -> Result<Handle, VulkanError> {
        self.buffer.export()
    }

    /// For shaders of its device.
    pub fn address(&self) -> u64 {
        self.buffer.address
    }

    /// Bytes it has room for.
    pub fn bytes(&self) -> u64 {
        self.buffer.bytes()
    }

    /// Bytes of the memory that is exported.
    pub fn allocation(&self) -> u64 {
        self.buffer.allocation()
    }

    /// All its bytes, where the host sees the device's memory. Whoever uses them keeps order with all others.
    pub fn mapped(&self) -> Option<*mut u8> {
        self.buffer.mapped()
    }

    pub fn device(&self) -> &Arc<Device> {
        self.buffer.device()
    }
}

impl std::fmt::Debug for SharedBuffer {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SharedBuffer").field("bytes", &self.bytes()).field("device", self.device()).finish()
    }
}

/// A semaphore that other APIs wait for and signal too.
pub struct SharedSemaphore {
    device: Arc<Device>,
    pub(super) raw: vk::Semaphore,
    kind: Semaphores,
    exportable: bool,
}

impl SharedSemaphore {
    /// Not signalled; a timeline's value is 0.
    pub fn new(device: &Arc<Device>, kind: Semaphores) -> Result<Self, VulkanError> {
        device.shares(kind)?;
        Self::make(device, kind, true)
    }

    /// A timeline that only this device and the host use.
    pub fn local(device: &Arc<Device>) -> Result<Self, VulkanError> {
        device.can_share(device.sharing.timeline, TIMELINES)?;
        Self::make(device, Semaphores::Timeline, false)
    }

    /// What another device has exported.
    pub fn import(device: &Arc<Device>, handle: Handle, kind: Semaphores) -> Result<Self, VulkanError> {
        device.shares(kind)?;
        let made = Self::make(device, kind, false)?;
        handle.into_semaphore(device, made.raw).map_err(|code| match code {
            vk::Result::ERROR_INVALID_EXTERNAL_HANDLE => VulkanError::WrongHandle { what: "a semaphore" },
            code => VulkanError::of("importing a semaphore")(code),
        })?;
        Ok(made)
    }

    fn make(device: &Arc<Device>, kind: Semaphores, exportable: bool) -> Result<Self, VulkanError> {
        let timeline = kind == Semaphores::Timeline;
        let type_ = if timeline { vk::SemaphoreType::TIMELINE } else { vk::SemaphoreType::BINARY };
        let mut type_ = vk::SemaphoreTypeCreateInfo::default().semaphore_type(type_);
        let mut export = vk::ExportSemaphoreCreateInfo::default().handle_types(SEMAPHORE);
        let mut info = vk::SemaphoreCreateInfo::default().push_next(&mut type_);
        if exportable {
            info = info.push_next(&mut export);
        }
        // SAFETY: the structures live until the call returns; the device can do what they ask for.
        let raw = unsafe { device.raw.create_semaphore(&info, None) };
        let raw = raw.map_err(VulkanError::of("vkCreateSemaphore"))?;
        Ok(Self { device: device.clone(), raw, kind, exportable })
    }

    /// For one import.
    pub fn export(&self) -> Result<Handle, VulkanError> {
        self.device.can_share(self.exportable, "a semaphore that is not made for it")?;
        Handle::of_semaphore(&self.device, self.raw).map_err(VulkanError::of("exporting a semaphore of Vulkan"))
    }

    pub fn kind(&self) -> Semaphores {
        self.kind
    }

    /// Raises a timeline to a value, from the host. Binary semaphores are signalled by devices alone.
    pub fn signal(&self, value: u64) -> Result<(), VulkanError> {
        self.device.can_share(self.kind == Semaphores::Timeline, TIMELINES)?;
        let info = vk::SemaphoreSignalInfo::default().semaphore(self.raw).value(value);
        // SAFETY: a timeline semaphore of this device.
        unsafe { self.device.raw.signal_semaphore(&info) }.map_err(VulkanError::of("vkSignalSemaphore"))
    }

    /// The host waits until a timeline has reached a value; false where it has not in time.
    pub fn wait(&self, value: u64, timeout: Duration) -> Result<bool, VulkanError> {
        self.device.can_share(self.kind == Semaphores::Timeline, TIMELINES)?;
        let (semaphores, values) = ([self.raw], [value]);
        let info = vk::SemaphoreWaitInfo::default().semaphores(&semaphores).values(&values);
        let timeout = u64::try_from(timeout.as_nanos()).unwrap_or(u64::MAX);
        // SAFETY: as above.
        match unsafe { self.device.raw.wait_semaphores(&info, timeout) } {
            Err(vk::Result::TIMEOUT) => Ok(false),
            other => other.map(|()| true).map_err(VulkanError::of("vkWaitSemaphores")),
        }
    }
}

impl Drop for SharedSemaphore {
    fn drop(&mut self) {
        // SAFETY: it is this one's own; `Recorder` waits for all that uses it.
        unsafe { self.device.raw.destroy_semaphore(self.raw, None) };
    }
}

impl std::fmt::Debug for SharedSemaphore {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_struct("SharedSemaphore").field("kind", &self.kind).field("device", &self.device).finish()
    }
}

/// What a list of commands waits for first, and what it signals at its end. Numbers are a timeline's values.
#[derive(Clone, Copy, Debug, Default)]
pub struct Order<'a> {
    pub wait: Option<(&'a SharedSemaphore, u64)>,
    pub signal: Option<(&'a SharedSemaphore, u64)>,
}

/// Fills, copies and reads shared buffers, each call to its end.
pub struct Transfers {
    recorder: Recorder,
}

impl std::fmt::Debug for Transfers {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Transfers").field(&self.recorder.device).finish()
    }
}

impl Transfers {
    pub fn new(device: &Arc<Device>) -> Result<Self, VulkanError> {
        Ok(Self { recorder: Recorder::new(device.clone())? })
    }

    /// All words of a buffer get one value.
    pub fn fill(&mut self, to: &SharedBuffer, word: u32, order: &Order) -> Result<(), VulkanError> {
        self.run(&[to], order, |recorder| {
            let (raw, commands) = (&recorder.device.raw, recorder.commands);
            // SAFETY: commands are being recorded; the buffer lives until they have run.
            unsafe { raw.cmd_fill_buffer(commands, to.buffer.raw, 0, vk::WHOLE_SIZE, word) };
        })
    }

    /// As many bytes as both have.
    pub fn copy(&mut self, from: &SharedBuffer, to: &SharedBuffer, order: &Order) -> Result<(), VulkanError> {
        let copies = [Copy::new(from.buffer.raw, to.buffer.raw, from.bytes().min(to.bytes()))];
        self.run(&[from, to], order, |recorder| recorder.copy(&copies))
    }

    /// All bytes of a buffer.
    pub fn read(&mut self, from: &SharedBuffer, order: &Order) -> Result<Vec<u8>, VulkanError> {
        let to = Buffer::new(from.device(), from.bytes(), Use::Download)?;
        let copies = [Copy::new(from.buffer.raw, to.raw, from.bytes())];
        self.run(&[from], order, |recorder| {
            recorder.copy(&copies);
            recorder.barrier(vk::PipelineStageFlags2::COPY, vk::PipelineStageFlags2::HOST);
        })?;
        Ok(to.read(from.bytes() as usize).to_vec())
    }

    fn run(
        &mut self,
        buffers: &[&SharedBuffer],
        order: &Order,
        record: impl FnOnce(&Recorder),
    ) -> Result<(), VulkanError> {
        let device = &self.recorder.device;
        assert!(buffers.iter().all(|b| Arc::ptr_eq(b.device(), device)), "buffers of another device");
        self.recorder.run_in_order("copying between shared buffers", order, |recorder| {
            recorder.acquire(buffers, vk::PipelineStageFlags2::ALL_TRANSFER);
            record(recorder);
            recorder.release(buffers, vk::PipelineStageFlags2::ALL_TRANSFER);
        })
    }
}

impl Device {
    fn shares(&self, kind: Semaphores) -> Result<(), VulkanError> {
        let what = if kind == Semaphores::Timeline { TIMELINES } else { "semaphores" };
        self.can_share(Semaphores::None < kind && kind <= self.sharing.semaphores, what)
    }

    fn can_share(&self, can: bool, what: &'static str) -> Result<(), VulkanError> {
        let device = || self.found.name.clone();
        if can { Ok(()) } else { Err(VulkanError::Unshared { what, device: device() }) }
    }
}
