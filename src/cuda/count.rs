//! How many entries lists have, without waiting for the device. Twin of kernels/count.cuh.
//!
//! A frame's first run asks for every number, and makes room for as many. The next ones make room for some more than that and
//! ask for nothing before their end: kernels count what there really is, do nothing where it is more than there is room for,
//! and the frame is drawn again, asking.

use super::gpu::pods;
use super::{Buffer, Pod, Pointer};

/// What kernels are told of a list's length.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub struct Count {
    counted: Pointer<u64>,
    room: u32,
    known: u32,
}

pods!(Count);

impl Count {
    /// Of a list with as many entries.
    pub fn known(length: u32) -> Self {
        Self { counted: Pointer::NULL, room: length, known: 1 }
    }

    /// Of a list with room for so many, whose entries are counted there.
    pub(super) fn new(counted: Pointer<u64>, room: u32) -> Self {
        Self { counted, room, known: 0 }
    }

    pub(super) fn counted(&self) -> Pointer<u64> {
        Pointer { ..self.counted }
    }

    pub(super) fn is_known(&self) -> bool {
        self.known != 0
    }

    pub(super) fn room(&self) -> usize {
        self.room as usize
    }
}

/// A list and its length; the buffer may be longer.
#[derive(Clone, Copy, Debug)]
pub(crate) struct List<T> {
    pub buffer: Buffer<T>,
    pub count: Count,
}

impl<T: Pod> List<T> {
    pub fn pointer(&self) -> Pointer<T> {
        self.buffer.pointer()
    }

    /// No list is longer.
    pub fn room(&self) -> usize {
        self.count.room()
    }
}

/// What a frame had to ask for, in that order.
#[derive(Clone, Debug, Default, PartialEq)]
pub(crate) struct Plan {
    numbers: Vec<u64>,
}

impl Plan {
    /// Room for either of two frames that asked for the same.
    pub fn or(mut self, other: &Self) -> Self {
        if self.numbers.len() == other.numbers.len() {
            self.numbers.iter_mut().zip(&other.numbers).for_each(|(a, b)| *a = (*a).max(*b));
        }
        self
    }
}

/// Where a frame's numbers come from.
#[derive(Clone, Debug)]
pub(super) enum Sizes {
    /// From the device, and what it said so far.
    Asked(Plan),
    /// From an earlier frame, and how many of them were used.
    Planned(Plan, usize),
}

impl Sizes {
    pub fn of(plan: Option<Plan>) -> Self {
        plan.map_or(Self::Asked(Plan::default()), |plan| Self::Planned(plan, 0))
    }

    /// The next planned number with some more, up to a limit; None: it is to be asked for, and [`Sizes::push`]ed.
    pub fn next(&mut self, limit: u64) -> Option<u64> {
        let Self::Planned(plan, used) = self else { return None };
        let number = plan.numbers.get(*used).copied().unwrap_or(0);
        *used += 1;
        Some(more(number).min(limit))
    }

    pub fn ask(&self) -> bool {
        matches!(self, Self::Asked(_))
    }

    pub fn push(&mut self, number: u64) {
        if let Self::Asked(plan) = self {
            plan.numbers.push(number);
        }
    }

    pub fn plan(&self) -> &Plan {
        match self {
            Self::Asked(plan) | Self::Planned(plan, _) => plan,
        }
    }
}

/// A quarter more, and at least a few.
fn more(number: u64) -> u64 {
    number + number / 4 + 64
}
