//! shade, host side: the exact surface under every pixel. Twin of src/stages/shade.rs.

use super::frame::{Pixels, Stages};
use super::{Argument, Gpu, GpuError, Pointer, abi};

/// Pixels in doubt that a frame has room for before it has seen how many there are.
const DOUBTS: usize = 1 << 16;

impl<G: Gpu> Stages<'_, '_, G> {
    /// Shades everything; returns the lists of pixels that were filled, `best` is 0 for those that are not any more.
    pub(super) fn shade(&mut self, filled: Pixels, doubtful: bool) -> Result<Vec<Pixels>, GpuError> {
        let exact = self.is_exact();
        if exact {
            let list = filled.pointer();
            self.session.for_all("settle_ask", filled.count, &[&self.geometry.view, &list, &filled.count])?;
            self.group("settle filled", |stages| stages.settle(filled, true))?;
        } else if self.geometry.view.refine > 0 {
            let (near, list) = (self.near.pointer(), filled.pointer());
            let rest: [&dyn Argument; 3] = [&near, &list, &filled.count];
            self.session.for_each_in(&self.geometry, "shade_refuse", filled.room(), &rest)?;
        }
        let doubts = self.group("pixels", |stages| stages.shade_pixels(exact && doubtful))?;
        let mut lists = vec![filled];
        if exact {
            self.slots = self.session.zeroed(self.pixels())?;
            self.shade_filled(filled)?;
        }
        if let Some(doubts) = doubts {
            self.group("settle doubts", |stages| stages.settle(doubts, false))?;
            self.shade_filled(doubts)?;
            lists.push(doubts);
        }
        Ok(lists)
    }

    /// All pixels but the filled ones; those whose depth is in doubt are listed, where that is asked for.
    fn shade_pixels(&mut self, doubtful: bool) -> Result<Option<Pixels>, GpuError> {
        let run = |stages: &mut Self, room: u32, list: Pointer<abi::Filled>, counted: Pointer<u64>| {
            let (near, slots) = (stages.near.pointer(), stages.slots.pointer());
            let (parameters, color) = (stages.parameters.pointer(), stages.color.pointer());
            let rest: [&dyn Argument; 7] = [&near, &slots, &parameters, &color, &room, &list, &counted];
            stages.session.for_each_in(&stages.geometry, "shade_pixels", stages.pixels(), &rest)
        };
        if !doubtful {
            run(self, 0, Pointer::NULL, Pointer::NULL)?;
            return Ok(None);
        }
        let listed = self.list(DOUBTS, "pixels in doubt", |stages, list, counted| {
            run(stages, list.len() as u32, list.pointer(), counted)
        })?;
        Ok(Some(listed.0))
    }

    fn shade_filled(&mut self, pixels: Pixels) -> Result<(), GpuError> {
        let (near, list) = (self.near.pointer(), pixels.pointer());
        let (parameters, color) = (self.parameters.pointer(), self.color.pointer());
        let rest: [&dyn Argument; 5] = [&near, &list, &pixels.count, &parameters, &color];
        self.session.for_each_in(&self.geometry, "shade_filled", pixels.room(), &rest)
    }
}
