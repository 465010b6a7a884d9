//! The frame after estimate: its buffers, and the order of its stages, one file each.

use super::evaluate::evaluate;
use super::session::{Geometry, Session};
use super::trims::TrimPointers;
use super::{Buffer, Gpu, GpuError, abi};
use crate::stages::TrimCounts;

/// What a device made of a frame.
pub(crate) struct Drawn {
    pub near: Vec<u64>,
    /// Patch parameters; meaningless where `near` is 0.
    pub parameters: Vec<[f32; 2]>,
    /// Linear RGB; meaningless where `near` is 0.
    pub color: Vec<[f32; 3]>,
    pub shown: Vec<abi::Shown>,
    /// Pixels that were filled, ascending.
    pub filled: Vec<u32>,
    /// Fragments that were tested and what became of them.
    pub trim: TrimCounts,
    pub buffer_bytes: u64,
}

/// Where stages end: their name, once they have.
pub(crate) type Ended<'a> = &'a mut dyn FnMut(&'static str);

/// What cull, estimate and the list of meshlets left on the device.
pub(crate) struct Input {
    pub geometry: Geometry,
    pub trims: TrimPointers,
    /// The scene has trims: meshlets may have to be tested, and pixels whose exact depth is not what was taken for it are in
    /// doubt.
    pub trimmed: bool,
    /// By textures.
    pub textured: bool,
}

/// Draws it; `ended` is told where stages end.
pub(crate) fn draw<G: Gpu>(session: &mut Session<'_, G>, input: &Input, ended: Ended) -> Result<Drawn, GpuError> {
    Stages::new(session, input)?.run(input, ended)
}

pub(super) struct Stages<'s, 'g, G: Gpu> {
    pub session: &'s mut Session<'g, G>,
    pub geometry: Geometry,
    pub trims: TrimPointers,
    pub near: Buffer<u64>,
    pub spare: Buffer<u64>,
    pub parameters: Buffer<[f32; 2]>,
    pub color: Buffer<[f32; 3]>,
    /// By pixel its place in the list of those that are asked about, from 1; 0: in none.
    pub slots: Buffer<u32>,
}

/// A list of pixels on the device.
#[derive(Clone, Copy)]
pub(super) struct Pixels {
    pub list: Buffer<abi::Filled>,
    /// How many of them there are.
    pub count: u32,
}

impl<'s, 'g, G: Gpu> Stages<'s, 'g, G> {
    fn new(session: &'s mut Session<'g, G>, input: &Input) -> Result<Self, GpuError> {
        let Input { geometry, trims, .. } = *input;
        let view = geometry.view;
        let pixels = view.size[0] as usize * view.size[1] as usize;
        Ok(Self {
            geometry,
            trims,
            near: session.zeroed(pixels)?,
            spare: session.zeroed(pixels)?,
            parameters: session.allocate(pixels)?,
            color: session.allocate(pixels)?,
            slots: session.zeroed(pixels)?,
            session,
        })
    }

    fn run(&mut self, input: &Input, ended: Ended) -> Result<Drawn, GpuError> {
        if let Some(vertices) = self.geometry.vertices {
            self.session.group("vertices", |session| evaluate(session, &self.geometry, &vertices))?;
        }
        self.end("evaluate", ended)?;
        self.rasterize()?;
        self.end("rasterize", ended)?;
        let trim = match (input.trimmed, input.textured) {
            (false, _) => TrimCounts::default(),
            (true, false) => self.trim()?,
            (true, true) => self.trim_by_textures()?,
        };
        self.end("trim", ended)?;
        let filled = self.fill()?;
        self.end("fill", ended)?;
        let filled = self.shade(filled, input.trimmed)?;
        self.end("shade", ended)?;
        self.group("download", |stages| {
            Ok(Drawn {
                near: stages.session.download(&stages.near)?,
                parameters: stages.session.download(&stages.parameters)?,
                color: stages.session.download(&stages.color)?,
                shown: stages.shown()?,
                filled,
                trim,
                buffer_bytes: stages.session.bytes(),
            })
        })
    }

    /// As [`Session::group`].
    pub(super) fn group<R>(&mut self, name: &'static str, work: impl FnOnce(&mut Self) -> R) -> R {
        self.session.open(name);
        let result = work(self);
        self.session.close();
        result
    }

    /// By pixel, for whoever asks the finished frame.
    fn shown(&mut self) -> Result<Vec<abi::Shown>, GpuError> {
        let shown = self.session.zeroed(self.pixels())?;
        let (near, parameters, out) = (self.near.pointer(), self.parameters.pointer(), shown.pointer());
        self.session.for_each_in(&self.geometry, "shown_pixels", self.pixels(), &[&near, &parameters, &out])?;
        self.session.download(&shown)
    }

    fn end(&mut self, stage: &'static str, ended: Ended) -> Result<(), GpuError> {
        self.session.finish()?;
        ended(stage);
        Ok(())
    }

    pub(super) fn pixels(&self) -> usize {
        self.near.len()
    }

    /// Counts what a kernel lists, and runs it again where there was no room for all of it.
    pub(super) fn list(
        &mut self,
        room: usize,
        run: impl Fn(&mut Self, &Buffer<abi::Filled>, &Buffer<u32>) -> Result<(), GpuError>,
    ) -> Result<Pixels, GpuError> {
        let mut room = room;
        loop {
            let (list, count) = (self.session.allocate(room)?, self.session.zeroed(1)?);
            run(self, &list, &count)?;
            let count = self.session.count(&count)?;
            if count as usize <= room {
                return Ok(Pixels { list, count });
            }
            room = count as usize;
        }
    }
}
