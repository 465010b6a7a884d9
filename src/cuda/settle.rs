//! Part of shade, host side: the nearest surface under pixels that are not settled. Twin of src/stages/settle.rs.

use super::count::Count;
use super::frame::{Pixels, Stages};
use super::{Argument, Gpu, GpuError, Pointer, abi};

/// Pixels along one side of a tile of settle_near.cu.
const TILE: u32 = 8;
/// Starts a candidate of settle.cu has at most.
const STARTS: usize = 4;
/// Triangles near the pixels of a list: all their starts have numbers of 32 bits.
const MOST_CANDIDATES: u64 = u32::MAX as u64 / STARTS as u64;

impl<G: Gpu> Stages<'_, '_, G> {
    /// Gives each pixel of a list to the nearest surface exactly under its centre, where that is nearer than it asks for.
    pub(super) fn settle(&mut self, pixels: Pixels, reaching: bool) -> Result<(), GpuError> {
        let (list, count) = (pixels.pointer(), pixels.count);
        if count.room() == 0 {
            // All frames have as many numbers.
            self.session.remember(0);
            return Ok(());
        }
        let slots = self.slots.pointer();
        let tiles = self.geometry.view.size.map(|side| side.div_ceil(TILE) as usize);
        let tiles = self.session.zeroed::<u32>(tiles[0] * tiles[1])?.pointer();
        self.session.for_all("settle_mark", count, &[&self.geometry.view, &list, &count, &slots, &tiles])?;
        let (nothing, none, no_cursors) = (Count::known(0), Pointer::<u64>::NULL, Pointer::<u32>::NULL);
        let rest: [&dyn Argument; 6] = [&slots, &tiles, &list, &nothing, &none, &no_cursors];
        self.session.for_meshlets(&self.geometry, "settle_find", &rest)?;
        let total = self.session.counters(1)?;
        self.session.for_all("settle_allocate", count, &[&list, &count, &total])?;
        let total = self.session.count(total, MOST_CANDIDATES)?.map_err(|needed| {
            let (what, limit) = ("candidates", MOST_CANDIDATES);
            GpuError::TooMany { what, needed, limit }
        })?;
        let candidates = self.session.allocate::<u64>(total.room())?.pointer();
        let cursors = self.session.zeroed::<u32>(count.room())?.pointer();
        let rest: [&dyn Argument; 6] = [&slots, &tiles, &list, &total, &candidates, &cursors];
        self.session.for_meshlets(&self.geometry, "settle_find", &rest)?;
        let all = total.room() * STARTS;
        let starts = self.session.allocate::<abi::Start>(all)?.pointer();
        let rest: [&dyn Argument; 5] = [&list, &count, &total, &candidates, &starts];
        self.session.for_each_in(&self.geometry, "settle_starts", count.room(), &rest)?;
        let reaching = u32::from(reaching);
        let rest: [&dyn Argument; 5] = [&list, &starts, &total, &reaching, &self.trims];
        self.session.for_each_in(&self.geometry, "settle_search", all, &rest)?;
        self.session.for_each("settle_winner", all, &[&list, &starts, &total])?;
        self.session.for_all("settle_apply", count, &[&list, &starts, &count, &self.near.pointer(), &slots])
    }
}
