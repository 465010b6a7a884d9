//! The frame after estimate: its buffers, and the order of its stages, one file each.

use super::count::{Count, List};
use super::evaluate::evaluate;
use super::hardware::{ByHardware, Hardware};
use super::session::{Geometry, Session};
use super::shared::Role;
use super::trims::TrimPointers;
use super::{Buffer, Gpu, GpuError, Pod, Pointer, abi};
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
    /// Triangles that mesh shaders were given, and what was copied for that.
    pub triangles_hardware: u64,
    pub bytes_copied: u64,
    pub buffer_bytes: u64,
}

/// Entries of a list: places in it have 32 bits.
const MOST: u64 = u32::MAX as u64;
/// What a kernel that lists something counts at most.
const COUNTERS: usize = 3;

/// Where stages end: their name, once they have.
pub(crate) type Ended<'a> = &'a mut dyn FnMut(&'static str);

/// What cull, estimate and the list of meshlets left on the device.
pub(crate) struct Input {
    pub geometry: Geometry,
    /// How many leaves there are.
    pub leaves: Count,
    /// In ETER's shape: all meshlets are drawn by warps, from vertices in memory.
    pub staged: bool,
    pub trims: TrimPointers,
    /// The scene has trims: meshlets may have to be tested, and pixels whose exact depth is not what was taken for it are in
    /// doubt.
    pub trimmed: bool,
    /// By textures.
    pub textured: bool,
}

/// Draws it; `ended` is told where stages end. None: there was no room for something.
pub(crate) fn draw<G: Gpu>(
    session: &mut Session<'_, G>,
    input: &Input,
    hardware: Option<&mut Hardware>,
    ended: Ended,
) -> Result<Option<Drawn>, GpuError> {
    Stages::new(session, input)?.run(input, hardware, ended)
}

pub(super) struct Stages<'s, 'g, G: Gpu> {
    pub session: &'s mut Session<'g, G>,
    pub geometry: Geometry,
    pub leaves: Count,
    pub staged: bool,
    pub trims: TrimPointers,
    pub textured: bool,
    pub hardware: ByHardware,
    pub near: Buffer<u64>,
    pub spare: Buffer<u64>,
    pub parameters: Buffer<[f32; 2]>,
    pub color: Buffer<[f32; 3]>,
    /// By pixel its place in the list of those that are asked about, from 1; 0: in none.
    pub slots: Buffer<u32>,
}

/// A list of pixels on the device.
pub(super) type Pixels = List<abi::Filled>;

impl<'s, 'g, G: Gpu> Stages<'s, 'g, G> {
    fn new(session: &'s mut Session<'g, G>, input: &Input) -> Result<Self, GpuError> {
        let Input { geometry, leaves, staged, trims, textured, .. } = *input;
        let view = geometry.view;
        let pixels = view.size[0] as usize * view.size[1] as usize;
        Ok(Self {
            geometry,
            leaves,
            staged,
            trims,
            textured,
            hardware: ByHardware::default(),
            near: session.zeroed_as(Role::Near, pixels)?,
            spare: session.zeroed_as(Role::Spare, pixels)?,
            parameters: session.allocate(pixels)?,
            color: session.allocate(pixels)?,
            slots: session.zeroed(pixels)?,
            session,
        })
    }

    fn run(&mut self, input: &Input, hardware: Option<&mut Hardware>, ended: Ended) -> Result<Option<Drawn>, GpuError> {
        if let Some(vertices) = self.geometry.vertices {
            self.session.group("vertices", |session| evaluate(session, &self.geometry, &vertices))?;
        }
        self.end("evaluate", ended)?;
        if let Some(hardware) = hardware {
            self.group("hardware", |stages| stages.rasterize_by_hardware(hardware))?;
        }
        self.rasterize()?;
        self.end("rasterize", ended)?;
        let trim = match (input.trimmed, input.textured) {
            (false, _) => Trimmed::default(),
            (true, false) => self.trim()?,
            (true, true) => self.trim_by_textures()?,
        };
        self.end("trim", ended)?;
        let filled = self.fill()?;
        self.end("fill", ended)?;
        let filled = self.shade(filled, input.trimmed)?;
        self.end("shade", ended)?;
        self.group("download", |stages| {
            stages.session.run()?;
            if !stages.session.fits()? {
                return Ok(None);
            }
            Ok(Some(Drawn {
                near: stages.session.download(&stages.near)?,
                parameters: stages.session.download(&stages.parameters)?,
                color: stages.session.download(&stages.color)?,
                shown: stages.shown()?,
                filled: stages.filled(&filled)?,
                trim: trim.counts(stages.session)?,
                triangles_hardware: stages.hardware.triangles,
                bytes_copied: stages.hardware.copied,
                buffer_bytes: stages.session.bytes(),
            }))
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

    /// What a kernel lists; it is told where, with how much room, and where to count. Where the frame asks, it is run again if
    /// there was no room for all of it.
    pub(super) fn list<T: Pod>(
        &mut self,
        guess: usize,
        what: &'static str,
        run: impl Fn(&mut Self, &Buffer<T>, Pointer<u64>) -> Result<(), GpuError>,
    ) -> Result<(List<T>, Pointer<u64>), GpuError> {
        let planned = self.session.planned(MOST);
        let mut room = planned.unwrap_or(guess as u64);
        loop {
            let (buffer, counted) = (self.session.allocate(room as usize)?, self.session.counters(COUNTERS)?);
            run(self, &buffer, counted)?;
            if planned.is_some() {
                let count = self.session.counted(counted, room as u32);
                return Ok((List { buffer, count }, counted));
            }
            let needed = self.session.value(counted)?;
            if needed > MOST {
                return Err(GpuError::TooMany { what, needed, limit: MOST });
            }
            if needed <= room {
                self.session.remember(needed);
                return Ok((List { buffer, count: Count::known(needed as u32) }, counted));
            }
            room = needed;
        }
    }

    /// Pixels of these lists that stay filled, ascending.
    fn filled(&mut self, lists: &[Pixels]) -> Result<Vec<u32>, GpuError> {
        let stays = |f: &&abi::Filled| f.best != 0;
        let all = self.geometry.view.refine == 0;
        let mut pixels = Vec::new();
        for list in lists {
            let length = self.session.length(list.count)? as usize;
            let entries = self.session.download(&list.buffer)?;
            pixels.extend(entries[..length].iter().filter(|f| all || stays(f)).map(|f| f.pixel));
        }
        pixels.sort_unstable();
        Ok(pixels)
    }
}

/// What trimming did, as far as it is known before the frame's end.
#[derive(Default)]
pub(super) struct Trimmed {
    pub known: TrimCounts,
    /// Fragments that were tested, rejected, and that propose pixels.
    pub counted: Option<Pointer<u64>>,
}

impl Trimmed {
    fn counts<G: Gpu>(self, session: &mut Session<G>) -> Result<TrimCounts, GpuError> {
        let Some(counted) = self.counted else { return Ok(self.known) };
        let mut of = |k: usize| session.value(counted.offset(k));
        let known = self.known.tested;
        Ok(TrimCounts { tested: known + of(0)?, rejected: of(1)?, proposed: of(2)?, ..self.known })
    }
}
