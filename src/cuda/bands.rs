//! Triangles of many pixels, handed on to many warps: kernels/bands.cuh.

use super::frame::Stages;
use super::gpu::pods;
use super::{Argument, Gpu, GpuError, Pointer, abi};

/// Pixels that one warp draws of a triangle: `bands::MOST_PIXELS`.
const MOST_PIXELS: usize = 1 << 14;
/// Bands that there is room for; warps draw what is beyond by themselves.
const ROOM: usize = 1 << 15;
/// Blocks that go through the list, one for so many pixels of the image.
const PIXELS_A_BLOCK: usize = 1 << 11;
const MOST_BLOCKS: usize = 1 << 10;

/// `bands::Bands`.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(super) struct Bands {
    list: Pointer<abi::Band>,
    counted: Pointer<u64>,
    room: u32,
    unused: u32,
}

pods!(Bands);

impl Bands {
    /// Nobody takes any.
    pub const NONE: Self = Self { list: Pointer::NULL, counted: Pointer::NULL, room: 0, unused: 0 };
}

impl<G: Gpu> Stages<'_, '_, G> {
    /// An empty list; none where the image is too small for it.
    pub(super) fn bands(&mut self) -> Result<Bands, GpuError> {
        if self.pixels() <= MOST_PIXELS {
            return Ok(Bands::NONE);
        }
        let list = self.session.allocate(ROOM)?.pointer();
        Ok(Bands { list, counted: self.session.counters(1)?, room: ROOM as u32, unused: 0 })
    }

    /// A warp for each of them, by a kernel that is given them last.
    pub(super) fn draw_bands(&mut self, kernel: &str, bands: Bands, rest: &[&dyn Argument]) -> Result<(), GpuError> {
        if bands.room == 0 {
            return Ok(());
        }
        let blocks = (self.pixels() / PIXELS_A_BLOCK).clamp(1, MOST_BLOCKS);
        let mut all = rest.to_vec();
        all.push(&bands);
        self.session.blocks(&self.geometry, kernel, blocks, &all)
    }
}
