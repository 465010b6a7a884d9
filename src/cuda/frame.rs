//! The staged frame: every stage after estimate, one kernel after the other (ETER's own shape).

use super::evaluate::evaluate;
use super::session::{Geometry, Session, THREADS};
use super::trims::TrimPointers;
use super::{Argument, Buffer, Gpu, GpuError, Pointer, abi};
use crate::stages::{FrameShape, TrimCounts};

/// Pixels in doubt that a frame has room for before it has seen how many there are.
const DOUBTS: usize = 1 << 16;
/// Pixels along one side of a tile of settle_near.cu.
const TILE: u32 = 8;
/// Starts a candidate of settle.cu has at most.
const STARTS: usize = 4;
/// `trim::COUNTS` of trim.cu.
const TRIM_COUNTS: usize = 3;
/// Classes of meshlets of rasterize.cu.
const CLASSES: usize = 3;
/// Blocks of kernels that go through a list of unknown length: several times as many as any device runs at once.
const MOST_BLOCKS: usize = 1 << 13;
const NO_SLOT: u32 = u32::MAX;

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
    pub view: abi::View,
    pub patches: Buffer<abi::Patch>,
    pub leaves: Buffer<abi::Leaf>,
    pub nets: Buffer<abi::Point>,
    pub basis: Buffer<f32>,
    pub meshlets: Buffer<abi::Meshlet>,
    /// Vertices of all meshlets.
    pub vertices: u64,
    pub shape: FrameShape,
    pub trims: TrimPointers,
    /// The scene has trims: meshlets may have to be tested, and pixels whose exact depth is not what was taken for it are in
    /// doubt.
    pub trimmed: bool,
}

/// Draws it; `ended` is told where stages end.
pub(crate) fn draw<G: Gpu>(session: &mut Session<'_, G>, input: &Input, ended: Ended) -> Result<Drawn, GpuError> {
    Stages::new(session, input)?.run(input, ended)
}

struct Stages<'s, 'g, G: Gpu> {
    session: &'s mut Session<'g, G>,
    geometry: Geometry,
    trims: TrimPointers,
    near: Buffer<u64>,
    spare: Buffer<u64>,
    parameters: Buffer<[f32; 2]>,
    color: Buffer<[f32; 3]>,
    /// By pixel its number in the list of those that are asked about; `NO_SLOT`: in none.
    slots: Buffer<u32>,
}

/// A list of pixels on the device.
#[derive(Clone, Copy)]
struct Pixels {
    list: Buffer<abi::Filled>,
    /// How many of them there are.
    count: u32,
}

impl<'s, 'g, G: Gpu> Stages<'s, 'g, G> {
    fn new(session: &'s mut Session<'g, G>, input: &Input) -> Result<Self, GpuError> {
        let Input { view, patches, leaves, nets, basis, meshlets, trims, .. } = *input;
        let pixels = view.size[0] as usize * view.size[1] as usize;
        let vertices = match input.shape {
            FrameShape::Fused => None,
            FrameShape::Staged => Some(session.allocate(input.vertices as usize)?),
        };
        Ok(Self {
            geometry: Geometry { view, patches, leaves, nets, basis, meshlets, vertices },
            trims,
            near: session.zeroed(pixels)?,
            spare: session.zeroed(pixels)?,
            parameters: session.allocate(pixels)?,
            color: session.allocate(pixels)?,
            slots: session.upload(&vec![NO_SLOT; pixels])?,
            session,
        })
    }

    fn run(&mut self, input: &Input, ended: Ended) -> Result<Drawn, GpuError> {
        if let Some(vertices) = self.geometry.vertices {
            evaluate(self.session, &self.geometry, &vertices, None)?;
        }
        self.end("evaluate", ended)?;
        self.rasterize()?;
        self.end("rasterize", ended)?;
        let trim = if input.trimmed { self.trim()? } else { TrimCounts::default() };
        self.end("trim", ended)?;
        let filled = self.fill()?;
        self.end("fill", ended)?;
        let filled = self.shade(filled, input.trimmed)?;
        self.end("shade", ended)?;
        Ok(Drawn {
            near: self.session.download(&self.near)?,
            parameters: self.session.download(&self.parameters)?,
            color: self.session.download(&self.color)?,
            shown: self.shown()?,
            filled,
            trim,
            buffer_bytes: self.session.bytes(),
        })
    }

    /// Triangles, then strokes where these leave room: in the fused frame by classes of meshlets, those of few lanes first,
    /// since they hand what is too large for them on to the widest.
    fn rasterize(&mut self) -> Result<(), GpuError> {
        let (near, spare) = (self.near.pointer(), self.spare.pointer());
        if self.geometry.vertices.is_some() {
            self.session.for_meshlets(&self.geometry, "rasterize_triangles", &[&near])?;
            return self.session.for_meshlets(&self.geometry, "rasterize_strokes", &[&near, &spare]);
        }
        let count = self.geometry.meshlets.len();
        if count == 0 {
            return Ok(());
        }
        let mut list = || self.session.allocate::<u32>(count).map(|list| list.pointer());
        let (corners, narrow, wide) = (list()?, list()?, list()?);
        let counts = self.session.zeroed::<u32>(CLASSES)?.pointer();
        let meshlets = self.geometry.meshlets.pointer();
        let lists: [&dyn Argument; 6] = [&meshlets, &(count as u32), &corners, &narrow, &wide, &counts];
        self.session.for_each("rasterize_classes", count, &lists)?;
        for part in ["rasterize", "stroke"] {
            for (class, lanes, numbers) in [("corners", 1, corners), ("narrow", 8, narrow), ("wide", 32, wide)] {
                // The host does not know how many there are: blocks go on until the list ends.
                let blocks = (count * lanes).div_ceil(THREADS as usize).min(MOST_BLOCKS);
                let rest: [&dyn Argument; 5] = [&numbers, &wide, &counts, &near, &spare];
                self.session.blocks(&self.geometry, &format!("{part}_{class}"), blocks, &rest)?;
            }
        }
        Ok(())
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

    /// Draws the meshlets that trim curves cross: what no curve comes near to, then the fragments that have to be tested, then
    /// strokes, which only count where they are nearer.
    fn trim(&mut self) -> Result<TrimCounts, GpuError> {
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

    fn pixels(&self) -> usize {
        self.near.len()
    }

    /// Counts what a kernel lists, and runs it again where there was no room for all of it.
    fn list(
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

    fn fill(&mut self) -> Result<Pixels, GpuError> {
        let pixels = self.pixels();
        let filled = self.list(pixels / 16 + 1, |stages, list, count| {
            let (near, spare) = (stages.near.pointer(), stages.spare.pointer());
            let (room, list, count) = (list.len() as u32, list.pointer(), count.pointer());
            stages.session.for_each_in(&stages.geometry, "fill_list", pixels, &[&near, &spare, &room, &list, &count])
        })?;
        let (near, spare, list) = (self.near.pointer(), self.spare.pointer(), filled.list.pointer());
        self.session.for_each("fill_take", filled.count as usize, &[&near, &spare, &list, &filled.count])?;
        Ok(filled)
    }

    /// Shades everything; returns the pixels that stay filled, ascending.
    fn shade(&mut self, filled: Pixels, doubtful: bool) -> Result<Vec<u32>, GpuError> {
        let abi::View { refine, fill, .. } = self.geometry.view;
        let exact = refine > 0 && fill == abi::FillRule::FILL_STROKE;
        if exact {
            self.session.for_each(
                "settle_ask",
                filled.count as usize,
                &[&self.geometry.view, &filled.list.pointer(), &filled.count],
            )?;
            self.settle(filled, true)?;
        } else if refine > 0 {
            let (near, list) = (self.near.pointer(), filled.list.pointer());
            self.session.for_each_in(
                &self.geometry,
                "shade_refuse",
                filled.count as usize,
                &[&near, &list, &filled.count],
            )?;
        }
        let doubts = self.shade_pixels(if exact && doubtful { DOUBTS } else { 0 })?;
        let mut lists = vec![filled];
        if exact {
            self.slots = self.session.upload(&vec![NO_SLOT; self.pixels()])?;
            self.settle(doubts, false)?;
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
            &[&near, &list, &pixels.count, &1u32, &parameters, &color],
        )
    }

    /// Gives each pixel of a list to the nearest surface exactly under its centre, where that is nearer than it asks for.
    fn settle(&mut self, pixels: Pixels, reaching: bool) -> Result<(), GpuError> {
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
        let total = self.session.zeroed::<u32>(1)?;
        self.session.for_each("settle_allocate", each, &[&list, &count, &total.pointer()])?;
        let total = self.session.count(&total)? as usize;
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
