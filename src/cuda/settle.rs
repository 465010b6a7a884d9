//! Part of shade, host side: the nearest surface under pixels that are not settled. Twin of src/stages/settle.rs.

use super::frame::{Pixels, Stages};
use super::{Gpu, GpuError, Pointer, abi};

/// Pixels along one side of a tile of settle_near.cu.
const TILE: u32 = 8;
/// Starts a candidate of settle.cu has at most.
const STARTS: usize = 4;
/// Triangles near the pixels of a list: all their starts have numbers of 32 bits.
const MOST_CANDIDATES: u64 = u32::MAX as u64 / STARTS as u64;

impl<G: Gpu> Stages<'_, '_, G> {
    /// Gives each pixel of a list to the nearest surface exactly under its centre, where that is nearer than it asks for.
    pub(super) fn settle(&mut self, pixels: Pixels, reaching: bool) -> Result<(), GpuError> {
        let (list, count) = (pixels.list.pointer(), pixels.count);
        let each = count as usize;
        if each == 0 {
            return Ok(());
        }
        let slots = self.slots.pointer();
        let tiles = self.geometry.view.size.map(|side| side.div_ceil(TILE) as usize);
        let tiles = self.session.zeroed::<u32>(tiles[0] * tiles[1])?.pointer();
        self.session.for_each("settle_mark", each, &[&self.geometry.view, &list, &count, &slots, &tiles])?;
        let (none, no_cursors) = (Pointer::<u64>::NULL, Pointer::<u32>::NULL);
        self.session.for_meshlets(&self.geometry, "settle_find", &[&slots, &tiles, &list, &none, &no_cursors])?;
        let total = self.session.zeroed::<u64>(1)?;
        self.session.for_each("settle_allocate", each, &[&list, &count, &total.pointer()])?;
        let total = self.session.download(&total)?[0];
        if total > MOST_CANDIDATES {
            return Err(GpuError::TooMany { what: "candidates", needed: total, limit: MOST_CANDIDATES });
        }
        let total = total as usize;
        let candidates = self.session.allocate::<u64>(total)?.pointer();
        let cursors = self.session.zeroed::<u32>(each)?.pointer();
        self.session.for_meshlets(&self.geometry, "settle_find", &[&slots, &tiles, &list, &candidates, &cursors])?;
        let starts = self.session.allocate::<abi::Start>(total * STARTS)?;
        let (all, starts) = (starts.len() as u32, starts.pointer());
        self.session.for_each_in(&self.geometry, "settle_starts", each, &[&list, &count, &candidates, &starts])?;
        let reaching = u32::from(reaching);
        self.session.for_each_in(
            &self.geometry,
            "settle_search",
            all as usize,
            &[&list, &starts, &all, &reaching, &self.trims],
        )?;
        self.session.for_each("settle_winner", all as usize, &[&list, &starts, &all])?;
        self.session.for_each("settle_apply", each, &[&list, &starts, &count, &self.near.pointer(), &slots])
    }
}
