//! trim, host side: the meshlets that trim curves cross. Twin of src/stages/trim.rs.

use super::frame::{Stages, Trimmed};
use super::{Argument, Gpu, GpuError, Pointer, abi};
use crate::stages::TrimCounts;

impl<G: Gpu> Stages<'_, '_, G> {
    /// Draws the meshlets that trim curves cross: what no curve comes near to, then the fragments that have to be tested, then
    /// strokes, which only count where they are nearer.
    pub(super) fn trim(&mut self) -> Result<Trimmed, GpuError> {
        let (near, spare, trims) = (self.near.pointer(), self.spare.pointer(), self.trims);
        let guess = self.pixels() / 4 + 1;
        let (queue, counted) = self.list(guess, "fragments to test", |stages, queue, counted| {
            let (room, queue) = (queue.len() as u32, queue.pointer());
            let bands = stages.bands()?;
            let rest: [&dyn Argument; 6] = [&trims, &near, &room, &queue, &counted, &bands];
            stages.session.for_meshlets(&stages.geometry, "trim_meshlets", &rest)?;
            stages.draw_bands("trim_bands", bands, &rest[..5])
        })?;
        let list: Pointer<abi::Fragment> = queue.pointer();
        let rest: [&dyn Argument; 6] = [&trims, &near, &spare, &list, &queue.count, &counted];
        self.session.for_each_in(&self.geometry, "trim_fragments", queue.room(), &rest)?;
        self.trim_listed(counted)?;
        self.session.for_meshlets(&self.geometry, "trim_strokes", &[&trims, &near, &spare])?;
        let known = TrimCounts { tested: self.hardware.listed.len() as u64, ..TrimCounts::default() };
        Ok(Trimmed { known, counted: Some(counted) })
    }
}
