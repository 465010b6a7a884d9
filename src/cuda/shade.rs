//! shade, host side: the exact surface under every pixel. Twin of src/stages/shade.rs.

use super::frame::{Pixels, Stages};
use super::{Gpu, GpuError, abi};

/// Pixels in doubt that a frame has room for before it has seen how many there are.
const DOUBTS: usize = 1 << 16;

impl<G: Gpu> Stages<'_, '_, G> {
    /// Shades everything; returns the pixels that stay filled, ascending.
    pub(super) fn shade(&mut self, filled: Pixels, doubtful: bool) -> Result<Vec<u32>, GpuError> {
        let refine = self.geometry.view.refine;
        let exact = self.is_exact();
        if exact {
            self.session.for_each(
                "settle_ask",
                filled.count as usize,
                &[&self.geometry.view, &filled.list.pointer(), &filled.count],
            )?;
            self.group("settle filled", |stages| stages.settle(filled, true))?;
        } else if refine > 0 {
            let (near, list) = (self.near.pointer(), filled.list.pointer());
            self.session.for_each_in(
                &self.geometry,
                "shade_refuse",
                filled.count as usize,
                &[&near, &list, &filled.count],
            )?;
        }
        let room = if exact && doubtful { DOUBTS } else { 0 };
        let doubts = self.group("pixels", |stages| stages.shade_pixels(room))?;
        let mut lists = vec![filled];
        if exact {
            self.slots = self.session.zeroed(self.pixels())?;
            self.group("settle doubts", |stages| stages.settle(doubts, false))?;
            self.shade_filled(filled)?;
            self.shade_filled(doubts)?;
            lists.push(doubts);
        }
        let mut all = Vec::new();
        for pixels in lists {
            let list = self.session.download(&pixels.list)?;
            let stays = |f: &&abi::Filled| refine == 0 || f.best != 0;
            all.extend(list[..pixels.count as usize].iter().filter(stays).map(|f| f.pixel));
        }
        all.sort_unstable();
        Ok(all)
    }

    fn shade_pixels(&mut self, room: usize) -> Result<Pixels, GpuError> {
        self.list(room, |stages, list, count| {
            let (near, slots) = (stages.near.pointer(), stages.slots.pointer());
            let (parameters, color) = (stages.parameters.pointer(), stages.color.pointer());
            let (room, list, count) = (list.len() as u32, list.pointer(), count.pointer());
            stages.session.for_each_in(
                &stages.geometry,
                "shade_pixels",
                stages.pixels(),
                &[&near, &slots, &parameters, &color, &room, &list, &count],
            )
        })
    }

    fn shade_filled(&mut self, pixels: Pixels) -> Result<(), GpuError> {
        let (near, list) = (self.near.pointer(), pixels.list.pointer());
        let (parameters, color) = (self.parameters.pointer(), self.color.pointer());
        self.session.for_each_in(
            &self.geometry,
            "shade_filled",
            pixels.count as usize,
            &[&near, &list, &pixels.count, &parameters, &color],
        )
    }
}
