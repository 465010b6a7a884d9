//! Memory of the emulated device.
#![allow(unsafe_code)]

use super::LaunchError;
use crate::cuda::{Buffer, Pod, Pointer};
use crate::vulkan::SharedBuffer;

/// As coarse as CUDA aligns its allocations.
#[derive(Clone, Copy)]
#[repr(C, align(256))]
struct Line([u8; 256]);

enum Place {
    Own(Vec<Line>),
    /// Memory of Vulkan, mapped as long as this lives.
    Adopted(SharedBuffer),
}

struct Allocation {
    place: Place,
    bytes: usize,
}

impl Allocation {
    fn first(&self) -> *const u8 {
        match &self.place {
            Place::Own(lines) => lines.as_ptr().cast(),
            Place::Adopted(memory) => memory.mapped().map_or(std::ptr::null(), <*mut u8>::cast_const),
        }
    }

    fn first_mut(&mut self) -> *mut u8 {
        match &mut self.place {
            Place::Own(lines) => lines.as_mut_ptr().cast(),
            Place::Adopted(memory) => memory.mapped().unwrap_or(std::ptr::null_mut()),
        }
    }
}

/// Where an allocation lies; `hp::Range` in kernels/host/runtime.h.
#[cfg(host_kernels)]
#[derive(Clone, Copy)]
#[repr(C)]
pub(super) struct Range {
    first: usize,
    bytes: u64,
}

const ADDRESS_BITS: u32 = 48;
const MOST_ALLOCATIONS: usize = 1 << 16;

/// All allocations; number 0 is none, as kernels do not check its pointers.
#[derive(Default)]
pub(super) struct Memory {
    allocations: Vec<Option<Allocation>>,
}

impl Memory {
    /// Numbers are not used again, so that a pointer into what was freed stays one.
    pub(super) fn allocate<T: Pod>(&mut self, length: usize, fill: u8) -> Buffer<T> {
        let bytes = length * size_of::<T>();
        let lines = vec![Line([fill; 256]); bytes.div_ceil(256).max(1)];
        self.add(Allocation { place: Place::Own(lines), bytes }, length)
    }

    /// Memory of Vulkan as an allocation.
    pub(super) fn adopt(&mut self, memory: &SharedBuffer) -> Result<Buffer<u8>, LaunchError> {
        if memory.mapped().is_none() {
            return Err(LaunchError::Unmapped { device: memory.device().found.name.clone() });
        }
        let bytes = memory.bytes() as usize;
        Ok(self.add(Allocation { place: Place::Adopted(memory.clone()), bytes }, bytes))
    }

    fn add<T>(&mut self, mut allocation: Allocation, length: usize) -> Buffer<T> {
        if self.allocations.is_empty() {
            self.allocations.push(None);
        }
        let number = self.allocations.len();
        assert!(number < MOST_ALLOCATIONS, "a device of more than {MOST_ALLOCATIONS} allocations");
        let address = allocation.first_mut().expose_provenance() as u64;
        assert!(address >> ADDRESS_BITS == 0, "an address of more than {ADDRESS_BITS} bits");
        self.allocations.push(Some(allocation));
        let bits = (number as u64) << ADDRESS_BITS | address;
        Buffer { pointer: Pointer::new(bits), number, length }
    }

    pub(super) fn free<T>(&mut self, buffer: &Buffer<T>) -> Result<(), LaunchError> {
        self.find(buffer)?;
        self.allocations[buffer.number] = None;
        Ok(())
    }

    pub(super) fn read<T: Pod>(&self, buffer: &Buffer<T>) -> Result<Vec<T>, LaunchError> {
        let first = self.find(buffer)?.first().cast::<T>();
        // SAFETY: `find` saw that the allocation has `length` elements; they are aligned (256 bytes; Vulkan maps
        // memory to 64) and any bytes are a T.
        Ok(unsafe { std::slice::from_raw_parts(first, buffer.length) }.to_vec())
    }

    pub(super) fn write<T: Pod>(&mut self, buffer: &Buffer<T>, data: &[T]) -> Result<(), LaunchError> {
        if data.len() != buffer.length {
            return Err(LaunchError::Length { length: buffer.length, given: data.len() });
        }
        self.find(buffer)?;
        let allocation = self.allocations[buffer.number].as_mut().expect("found");
        let first = allocation.first_mut().cast::<T>();
        // SAFETY: as in `read`; the allocation is borrowed exclusively.
        unsafe { std::slice::from_raw_parts_mut(first, buffer.length) }.copy_from_slice(data);
        Ok(())
    }

    /// Sets every byte to 0.
    pub(super) fn clear<T>(&mut self, buffer: &Buffer<T>) -> Result<(), LaunchError> {
        self.find(buffer)?;
        if let Some(allocation) = &mut self.allocations[buffer.number] {
            // SAFETY: it has as many bytes, and is borrowed exclusively.
            unsafe { allocation.first_mut().write_bytes(0, allocation.bytes) };
        }
        Ok(())
    }

    /// The allocation, if it is this memory's and has this size; what is shared may be larger.
    fn find<T>(&self, buffer: &Buffer<T>) -> Result<&Allocation, LaunchError> {
        let bytes = buffer.length * size_of::<T>();
        let found = self.allocations.get(buffer.number).and_then(Option::as_ref);
        let same = |a: &&Allocation| {
            let fits = a.bytes == bytes || a.bytes > bytes && matches!(a.place, Place::Adopted(_));
            fits && a.first().addr() as u64 == buffer.pointer.bits & ((1 << ADDRESS_BITS) - 1)
        };
        found.filter(same).ok_or(LaunchError::NoSuchBuffer { bytes })
    }

    /// Every allocation there is: its number, the address that kernels get, its bytes.
    pub(super) fn contents(&self) -> impl Iterator<Item = (usize, u64, &[u8])> {
        let all = self.allocations.iter().enumerate().filter_map(|(number, a)| Some((number, a.as_ref()?)));
        all.map(|(number, a)| {
            let first = a.first();
            // SAFETY: there are that many bytes, all of them initialised, borrowed with the memory.
            let bytes = unsafe { std::slice::from_raw_parts(first, a.bytes) };
            (number, (number as u64) << ADDRESS_BITS | first.addr() as u64, bytes)
        })
    }

    /// Where everything lies, for a launch; freed allocations have no bytes.
    #[cfg(host_kernels)]
    pub(super) fn ranges(&mut self) -> Vec<Range> {
        let range = |a: &mut Option<Allocation>| match a {
            Some(a) => Range { first: a.first_mut().expose_provenance(), bytes: a.bytes as u64 },
            None => Range { first: 0, bytes: 0 },
        };
        self.allocations.iter_mut().map(range).collect()
    }
}
