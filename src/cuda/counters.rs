//! Numbers that kernels count in a frame, and the room that lists get by them.

use super::count::{Count, List, Plan};
use super::session::Session;
use super::shared::Role;
use super::{Gpu, GpuError, Pod, Pointer, Shape};

/// Numbers of 32 bits name places in lists.
const MOST: u64 = u32::MAX as u64;
/// Counters of one buffer.
const COUNTERS: usize = 256;

impl<G: Gpu> Session<'_, G> {
    /// Numbers for kernels to count, zero.
    pub fn counters(&mut self, length: usize) -> Result<Pointer<u64>, GpuError> {
        let last = match self.counters.last() {
            Some(last) if self.used + length <= COUNTERS => *last,
            _ => {
                let new = self.zeroed(COUNTERS)?;
                self.counters.push(new);
                self.used = 0;
                new
            }
        };
        self.used += length;
        Ok(last.pointer().offset(self.used - length))
    }

    /// What was counted there; waits for it, unless the frame has ended.
    pub fn value(&mut self, counted: Pointer<u64>) -> Result<u64, GpuError> {
        for (k, buffer) in self.counters.clone().into_iter().enumerate() {
            let place = counted.bits.wrapping_sub(buffer.pointer.bits) as usize / size_of::<u64>();
            if place < buffer.len() {
                let of = |all: &[u64]| all.get(place).copied().unwrap_or(0);
                return match &self.found {
                    Some(found) => Ok(of(&found[k])),
                    None => Ok(of(&self.download(&buffer)?)),
                };
            }
        }
        Ok(0)
    }

    /// As many as kernels count there; where the frame asks for numbers, they must have been launched. Err: too many.
    pub fn count(&mut self, counted: Pointer<u64>, limit: u64) -> Result<Result<Count, u64>, GpuError> {
        let room = self.number(limit, |session| session.value(Pointer { ..counted }))?;
        if room > limit.min(MOST) {
            return Ok(Err(room));
        }
        Ok(Ok(self.counted(counted, room as u32)))
    }

    /// The same of what a frame can't have more of than places have numbers.
    pub fn count_of(&mut self, counted: Pointer<u64>, what: &'static str) -> Result<Count, GpuError> {
        self.count(counted, MOST)?.map_err(|needed| GpuError::TooMany { what, needed, limit: MOST })
    }

    /// Of a list with this room, whose entries are counted there: as many, where the frame has asked.
    pub fn counted(&mut self, counted: Pointer<u64>, room: u32) -> Count {
        if self.asks() {
            return Count::known(room);
        }
        let count = Count::new(counted, room);
        self.counts.push(count);
        count
    }

    /// How long a list is; waits for it, unless the frame has ended.
    pub fn length(&mut self, count: Count) -> Result<u64, GpuError> {
        if count.is_known() { Ok(count.room() as u64) } else { self.value(count.counted()) }
    }

    /// A number that room is made by: as an earlier frame had it and some more, or by asking.
    pub fn number(
        &mut self,
        limit: u64,
        ask: impl FnOnce(&mut Self) -> Result<u64, GpuError>,
    ) -> Result<u64, GpuError> {
        if let Some(number) = self.planned(limit) {
            return Ok(number);
        }
        let number = ask(self)?;
        self.remember(number);
        Ok(number)
    }

    /// As an earlier frame had it, and some more; None: the frame asks, and [`Session::remember`]s.
    pub fn planned(&mut self, limit: u64) -> Option<u64> {
        self.sizes.next(limit)
    }

    pub fn remember(&mut self, number: u64) {
        self.sizes.push(number);
    }

    /// The frame asks for its numbers: there is room for everything.
    pub fn asks(&self) -> bool {
        self.sizes.ask()
    }

    /// As many as a list has, if all of another one fits too.
    pub fn both(&mut self, list: Count, other: Count) -> Result<Count, GpuError> {
        if self.asks() {
            return Ok(list);
        }
        let out = self.counters(1)?;
        self.launch("count_both", Shape::row(1, 1), &[&list, &other, &out])?;
        Ok(self.counted(out, list.room() as u32))
    }

    /// Room for a list.
    pub fn list<T: Pod>(&mut self, count: Count) -> Result<List<T>, GpuError> {
        Ok(List { buffer: self.allocate(count.room())?, count })
    }

    /// Room for one that mesh shaders see too.
    pub fn list_as<T: Pod>(&mut self, role: Role, count: Count) -> Result<List<T>, GpuError> {
        Ok(List { buffer: self.allocate_as(role, count.room())?, count })
    }

    /// Whether there was room for everything; waits for the frame's end.
    pub fn fits(&mut self) -> Result<bool, GpuError> {
        let buffers = self.counters.clone();
        let found = buffers.iter().map(|buffer| self.download(buffer)).collect::<Result<_, _>>()?;
        self.found = Some(found);
        for count in self.counts.clone() {
            if self.value(count.counted())? > count.room() as u64 {
                return Ok(false);
            }
        }
        Ok(true)
    }

    /// What this frame had to ask for.
    pub fn plan(&self) -> Plan {
        self.sizes.plan().clone()
    }
}
