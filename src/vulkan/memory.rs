//! Buffers with addresses: what shaders read and write is named by push constants alone.

use super::handle::{Handle, MEMORY};
use super::{Device, VulkanError};
use crate::cuda::Pod;
use ash::vk;
use ash::vk::MemoryPropertyFlags as Flags;
use std::sync::Arc;

/// Who uses a buffer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Use {
    /// Written by the host, read by shaders or copied from.
    Upload,
    /// Shaders alone.
    Shaders,
    /// Copied to by the device, read by the host.
    Download,
    /// Shaders and other APIs; `Sharing` has seen that it can be.
    Shared,
}

impl Use {
    pub fn usage(self) -> vk::BufferUsageFlags {
        let shaders = vk::BufferUsageFlags::STORAGE_BUFFER | vk::BufferUsageFlags::SHADER_DEVICE_ADDRESS;
        match self {
            Self::Upload => shaders | vk::BufferUsageFlags::TRANSFER_SRC,
            Self::Shaders | Self::Shared => {
                shaders | vk::BufferUsageFlags::TRANSFER_SRC | vk::BufferUsageFlags::TRANSFER_DST
            }
            Self::Download => vk::BufferUsageFlags::TRANSFER_DST,
        }
    }
}

/// A buffer with memory of its own.
pub(super) struct Buffer {
    device: Arc<Device>,
    pub raw: vk::Buffer,
    memory: vk::DeviceMemory,
    /// Bytes of that.
    allocation: u64,
    /// For shaders.
    pub address: u64,
    /// Of the buffer, where the host sees it.
    mapped: Option<*mut u8>,
    bytes: u64,
}

// SAFETY: the pointer is the buffer's own mapping, written through `&mut self` alone. Of shared memory others know it: they
// keep order, as `SharedBuffer::mapped` says.
unsafe impl Send for Buffer {}
// SAFETY: as above; `&self` only reads it.
unsafe impl Sync for Buffer {}

impl Buffer {
    pub fn new(device: &Arc<Device>, bytes: u64, used: Use) -> Result<Self, VulkanError> {
        let mut made = Self::unbound(device, bytes, used)?;
        made.allocate(used, None)?;
        Ok(made)
    }

    /// A buffer in memory that was exported; `allocation`: the bytes of all of that.
    pub fn import(device: &Arc<Device>, handle: Handle, bytes: u64, allocation: u64) -> Result<Self, VulkanError> {
        let mut made = Self::unbound(device, bytes, Use::Shared)?;
        made.allocate(Use::Shared, Some((handle, allocation)))?;
        Ok(made)
    }

    fn unbound(device: &Arc<Device>, bytes: u64, used: Use) -> Result<Self, VulkanError> {
        if bytes > device.largest_buffer {
            return Err(VulkanError::OutOfMemory { what: "a buffer larger than the device allows", bytes });
        }
        let mut external = vk::ExternalMemoryBufferCreateInfo::default().handle_types(MEMORY);
        let mut info = vk::BufferCreateInfo::default().size(bytes.max(16)).usage(used.usage());
        if used == Use::Shared {
            info = info.push_next(&mut external);
        }
        // SAFETY: `info` is valid and the device is alive.
        let raw = unsafe { device.raw.create_buffer(&info, None) }.map_err(VulkanError::of("vkCreateBuffer"))?;
        let memory = vk::DeviceMemory::null();
        let bytes = bytes.max(16);
        Ok(Self { device: device.clone(), raw, memory, allocation: 0, address: 0, mapped: None, bytes })
    }

    /// `import`: what was exported, and its bytes.
    fn allocate(&mut self, used: Use, import: Option<(Handle, u64)>) -> Result<(), VulkanError> {
        let raw = &self.device.raw;
        // SAFETY: the buffer is the device's.
        let needs = unsafe { raw.get_buffer_memory_requirements(self.raw) };
        let mut flags = vk::MemoryAllocateFlagsInfo::default().flags(vk::MemoryAllocateFlags::DEVICE_ADDRESS);
        let mut dedicated = vk::MemoryDedicatedAllocateInfo::default().buffer(self.raw);
        let mut export = vk::ExportMemoryAllocateInfo::default().handle_types(MEMORY);
        let mut imported = import.as_ref().map(|(handle, _)| handle.memory_import());
        let bytes = import.as_ref().map_or(needs.size, |(_, bytes)| *bytes);
        if bytes < needs.size {
            return Err(VulkanError::WrongHandle { what: "memory that is smaller than its buffer" });
        }
        let mut info = vk::MemoryAllocateInfo::default().allocation_size(bytes);
        if used != Use::Download {
            info = info.push_next(&mut flags);
        }
        if used == Use::Shared {
            info = info.push_next(&mut dedicated);
            info = match &mut imported {
                Some(imported) => info.push_next(imported),
                None => info.push_next(&mut export),
            };
        }
        let [best, enough] = memory_types(&self.device, needs.memory_type_bits, used);
        let failed = |code| match code {
            vk::Result::ERROR_OUT_OF_DEVICE_MEMORY | vk::Result::ERROR_OUT_OF_HOST_MEMORY => {
                VulkanError::OutOfMemory { what: "vkAllocateMemory", bytes }
            }
            vk::Result::ERROR_INVALID_EXTERNAL_HANDLE => VulkanError::WrongHandle { what: "memory" },
            code => VulkanError::of("vkAllocateMemory")(code),
        };
        let kinds = self.device.memory.memory_types_as_slice();
        // SAFETY: `info` names a memory type of this device. The memory is bound to the buffer it was made for, mapped as a
        // whole, once, where the host sees it, and freed after the buffer.
        unsafe {
            // Where the best memory is full, other memory will do.
            let made = raw.allocate_memory(&info.memory_type_index(best), None).or_else(|code| match enough == best {
                true => Err(code),
                false => raw.allocate_memory(&info.memory_type_index(enough), None),
            });
            // Mesa 25.0 closes the handle of memory that it refuses, against the specification. To close it once more may
            // close somebody else's; where a driver leaves it open, one that was refused stays open.
            if let Some((handle, _)) = import {
                handle.taken();
            }
            self.memory = made.map_err(failed)?;
            raw.bind_buffer_memory(self.raw, self.memory, 0).map_err(VulkanError::of("vkBindBufferMemory"))?;
            if used != Use::Download {
                let info = vk::BufferDeviceAddressInfo::default().buffer(self.raw);
                self.address = raw.get_buffer_device_address(&info);
            }
            self.allocation = bytes;
            let seen = kinds.get(best as usize).is_some_and(|kind| kind.property_flags.contains(HOST));
            if matches!(used, Use::Upload | Use::Download) || used == Use::Shared && seen {
                let all = vk::MemoryMapFlags::empty();
                let mapped = raw.map_memory(self.memory, 0, vk::WHOLE_SIZE, all);
                self.mapped = Some(mapped.map_err(VulkanError::of("vkMapMemory"))?.cast());
            }
        }
        Ok(())
    }

    /// Bytes it has room for.
    pub fn bytes(&self) -> u64 {
        self.bytes
    }

    pub fn device(&self) -> &Arc<Device> {
        &self.device
    }

    /// Bytes of its memory.
    pub fn allocation(&self) -> u64 {
        self.allocation
    }

    /// All of it, where the host sees it.
    pub fn mapped(&self) -> Option<*mut u8> {
        self.mapped
    }

    /// What other APIs import the memory by; of [`Use::Shared`].
    pub fn export(&self) -> Result<Handle, VulkanError> {
        Handle::of_memory(&self.device, self.memory).map_err(VulkanError::of("exporting memory of Vulkan"))
    }

    /// Writes values from the beginning on.
    pub fn write<T: Pod>(&mut self, values: impl ExactSizeIterator<Item = T>) {
        let Some(mapped) = self.mapped else { return };
        assert!((values.len() * size_of::<T>()) as u64 <= self.bytes);
        let mut at = mapped.cast::<T>();
        let mut room = values.len();
        for value in values {
            assert!(room > 0, "an iterator of exact size");
            room -= 1;
            // SAFETY: `room` says that the place is within the mapping, which Vulkan aligns to 64 bytes at least.
            unsafe {
                at.write(value);
                at = at.add(1);
            }
        }
    }

    /// The first values.
    pub fn read<T: Pod>(&self, count: usize) -> &[T] {
        assert!((count * size_of::<T>()) as u64 <= self.bytes);
        // SAFETY: the host's own memory is coherent, as large as that, aligned to 64 bytes, and any bytes are a value.
        self.mapped.map_or(&[], |mapped| unsafe { std::slice::from_raw_parts(mapped.cast(), count) })
    }
}

impl Drop for Buffer {
    fn drop(&mut self) {
        // SAFETY: the device is done with both: `Rasterizer` waits for all that it has asked for.
        unsafe {
            self.device.raw.destroy_buffer(self.raw, None);
            self.device.raw.free_memory(self.memory, None);
        }
    }
}

/// Memory that the host sees, coherently.
const HOST: Flags = Flags::from_raw(Flags::HOST_VISIBLE.as_raw() | Flags::HOST_COHERENT.as_raw());

/// The best type of memory among those allowed, and one that will do. Vulkan promises one that the host sees, coherently.
fn memory_types(device: &Device, allowed: u32, used: Use) -> [u32; 2] {
    let memory = &device.memory;
    let (best, enough) = match used {
        Use::Upload => (HOST | Flags::DEVICE_LOCAL, HOST),
        Use::Shaders => (Flags::DEVICE_LOCAL, Flags::empty()),
        Use::Download => (HOST | Flags::HOST_CACHED, HOST),
        // No second choice: who imports it must choose the same. The CPU is its own host.
        Use::Shared if device.found.kind == "cpu" => (HOST, HOST),
        Use::Shared => (Flags::DEVICE_LOCAL, Flags::DEVICE_LOCAL),
    };
    let first = |wish: Flags, least: u64| {
        memory.memory_types_as_slice().iter().enumerate().position(|(k, t)| {
            let heap = memory.memory_heaps[t.heap_index as usize].size;
            allowed >> k & 1 == 1 && t.property_flags.contains(wish) && heap >= least
        })
    };
    // A small window of device memory that the host sees is left to others.
    let enough = first(enough, 0).unwrap_or(0);
    [first(best, 1 << 30).unwrap_or(enough), enough].map(|k| k as u32)
}
