//! trim, host side: the meshlets that trim curves cross. Twin of src/stages/trim.rs.

use super::frame::Stages;
use super::{Argument, Gpu, GpuError, abi};
use crate::stages::TrimCounts;

/// `trim::COUNTS` of trim.cu.
const TRIM_COUNTS: usize = 3;

impl<G: Gpu> Stages<'_, '_, G> {
    /// Draws the meshlets that trim curves cross: what no curve comes near to, then the fragments that have to be tested, then
    /// strokes, which only count where they are nearer.
    pub(super) fn trim(&mut self) -> Result<TrimCounts, GpuError> {
        let (near, spare, trims) = (self.near.pointer(), self.spare.pointer(), self.trims);
        let mut room = self.pixels() / 4 + 1;
        loop {
            let queue = self.session.allocate::<abi::Fragment>(room)?.pointer();
            let counts = self.session.zeroed::<u32>(TRIM_COUNTS)?;
            let places = counts.pointer();
            let room_there = room as u32;
            self.session.for_meshlets(
                &self.geometry,
                "trim_meshlets",
                &[&trims, &near, &room_there, &queue, &places],
            )?;
            let listed = self.session.download(&counts)?[0];
            if listed > room_there {
                room = listed as usize;
                continue;
            }
            let rest: [&dyn Argument; 6] = [&trims, &near, &spare, &queue, &listed, &places];
            self.session.for_each_in(&self.geometry, "trim_fragments", listed as usize, &rest)?;
            self.session.for_meshlets(&self.geometry, "trim_strokes", &[&trims, &near, &spare])?;
            let counts = self.session.download(&counts)?;
            let [tested, rejected, proposed] = [counts[0], counts[1], counts[2]].map(u64::from);
            return Ok(TrimCounts { tested, rejected, proposed, ..TrimCounts::default() });
        }
    }
}
