//! rasterize, host side: triangles and strokes into the two buffers. Twin of src/stages/rasterize.rs.

use super::frame::Stages;
use super::session::THREADS;
use super::{Argument, Gpu, GpuError};

/// Counts of rasterize.cu: by class, degree and box, twice, and one more.
const COUNTS: usize = 2 * 4 * 4 * 3 + 1;
/// Blocks of kernels that go through a list of unknown length: several times as many as any device runs at once.
const MOST_BLOCKS: usize = 1 << 13;

impl<G: Gpu> Stages<'_, '_, G> {
    /// Triangles, then strokes where these leave room: in the fused frame by classes of meshlets, those of few lanes first,
    /// since they hand what is too large for them on to the widest.
    pub(super) fn rasterize(&mut self) -> Result<(), GpuError> {
        let (near, spare) = (self.near.pointer(), self.spare.pointer());
        let bands = self.bands()?;
        if self.staged {
            self.session.for_meshlets(&self.geometry, "rasterize_triangles", &[&near, &bands])?;
            self.draw_bands("rasterize_bands", bands, &[&near])?;
            return self.session.for_meshlets(&self.geometry, "rasterize_strokes", &[&near, &spare]);
        }
        let (count, all) = (self.geometry.meshlets.room(), self.geometry.meshlets.count);
        if count == 0 {
            return Ok(());
        }
        let mut list = || self.session.allocate::<u32>(count).map(|list| list.pointer());
        let (corners, strips, narrow, wide) = (list()?, list()?, list()?, list()?);
        let counts = self.session.zeroed::<u32>(COUNTS)?.pointer();
        let (patches, meshlets) = (self.geometry.patches.pointer(), self.geometry.meshlets.pointer());
        let lists: [&dyn Argument; 8] = [&patches, &meshlets, &all, &counts, &corners, &strips, &narrow, &wide];
        self.session.for_each("rasterize_classes", count, &lists[..4])?;
        self.session.for_each("rasterize_sort", count, &lists)?;
        for part in ["rasterize", "stroke"] {
            // A thread draws the triangles of a row of quads, eight lanes its strokes.
            let row = if part == "rasterize" { 1 } else { 8 };
            let classes = [("corners", 1, corners), ("strips", row, strips), ("narrow", 8, narrow), ("wide", 32, wide)];
            for (class, lanes, numbers) in classes {
                // The host does not know how many there are: blocks go on until the list ends.
                let blocks = (count * lanes).div_ceil(THREADS as usize).min(MOST_BLOCKS);
                let rest: [&dyn Argument; 6] = [&numbers, &wide, &counts, &near, &spare, &bands];
                self.session.blocks(&self.geometry, &format!("{part}_{class}"), blocks, &rest)?;
            }
            if part == "rasterize" {
                self.draw_bands("rasterize_bands", bands, &[&near])?;
            }
        }
        Ok(())
    }
}
