//! fill, host side: the pixels that the spare buffer takes. Twin of src/stages/fill.rs.

use super::frame::{Pixels, Stages};
use super::{Gpu, GpuError, abi};

impl<G: Gpu> Stages<'_, '_, G> {
    pub(super) fn fill(&mut self) -> Result<Pixels, GpuError> {
        let pixels = self.pixels();
        let (filled, _) = self.list(pixels / 16 + 1, "pixels to fill", |stages, list, counted| {
            let (near, spare) = (stages.near.pointer(), stages.spare.pointer());
            let (room, list) = (list.len() as u32, list.pointer());
            stages.session.for_each_in(&stages.geometry, "fill_list", pixels, &[&near, &spare, &room, &list, &counted])
        })?;
        // Shading gives each of them its word, or back what it had.
        if self.is_exact() {
            return Ok(filled);
        }
        let (near, spare, list) = (self.near.pointer(), self.spare.pointer(), filled.pointer());
        self.session.for_all("fill_take", filled.count, &[&near, &spare, &list, &filled.count])?;
        Ok(filled)
    }

    /// The exact surface decides what fill proposes.
    pub(super) fn is_exact(&self) -> bool {
        let abi::View { refine, fill, .. } = self.geometry.view;
        refine > 0 && fill == abi::FillRule::FILL_STROKE
    }
}
