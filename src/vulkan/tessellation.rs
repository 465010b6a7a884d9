//! Evaluation by fixed-function tessellation: what ETER's table 3 compares with, and Yeo 2012's pipeline. No frame uses it.
//!
//! A piece of a patch is one patch of one control point to the hardware; the control shader sets its levels, the evaluation
//! shader evaluates by Mann and DeRose's scheme. Triangles are discarded before they are rasterised. Hardware cuts quads along
//! diagonals of its own choice, and positions snap where it likes: the bounds of `stages` say nothing about either.

use super::memory::{Buffer, Use};
use super::rasterize::room;
use super::recorder::{Copy, Recorder};
use super::tessellation_pieces::{EdgeFactors, Piece, pieces};
use super::tessellation_pipelines::{TessellationPipelines, TessellationPush, Work};
use super::{Device, VulkanError};
use crate::cuda::{Pod, abi, pods};
use crate::report::Spread;
use ash::vk;
use std::collections::BTreeMap;
use std::ops::Range;
use std::sync::Arc;

/// Which parameters vertices have.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Parameters {
    /// The grid's lines, rounded once.
    #[default]
    Exact,
    /// As hardware interpolates them: fixed point of 16 bits on most, so a vertex may be off by 2^-17 of its patch.
    Hardware,
}

/// What is tessellated. Lists are those of `kernels/abi.h`; of the patches only nets, quads, degrees and places count.
#[derive(Clone, Copy, Debug)]
pub struct Tessellation<'a> {
    pub size: [u32; 2],
    pub view: &'a abi::View,
    pub patches: &'a [abi::Patch],
    pub nets: &'a [abi::Point],
    pub factors: EdgeFactors<'a>,
    pub parameters: Parameters,
}

/// The same patches with the same factor all around: 64 in ETER's table 3, which is 65 x 65 vertices a patch.
pub fn with_factor(patches: &[abi::Patch], factor: u16) -> Vec<abi::Patch> {
    patches.iter().map(|patch| abi::Patch { quads: [factor; 2], ..*patch }).collect()
}

/// A vertex as the evaluation shader emitted it. What hardware never asked for is NaN.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
#[repr(C)]
pub struct Sample {
    /// Pixels about the patch's centre (`Patch::base`), not snapped; and stored depth.
    pub position: [f32; 3],
    /// Unit vector along S_u x S_v in the space of the net; 0 where these are parallel.
    pub normal: [f32; 3],
    /// Of the patch's unit square.
    pub parameters: [f32; 2],
}

pods!(Sample);

/// What the tessellation pipeline made of patches.
#[derive(Clone, Debug, Default)]
pub struct Tessellated {
    pub pieces: Vec<Piece>,
    samples: Vec<Sample>,
}

impl Tessellated {
    /// All vertices of a piece: inner ones, u outermost, and then those of sides u=0, u=1, v=0, v=1 with both corners.
    pub fn samples(&self, piece: usize) -> &[Sample] {
        let piece = &self.pieces[piece];
        &self.samples[piece.samples as usize..][..piece.stored()]
    }

    /// The vertices along a side, in parameter order.
    pub fn side(&self, piece: usize, side: usize) -> &[Sample] {
        let found = &self.pieces[piece];
        let before: usize = found.outer[..side].iter().map(|&n| usize::from(n) + 1).sum();
        &self.samples(piece)[found.inside() + before..][..usize::from(found.outer[side]) + 1]
    }
}

/// A list that shaders read from the device's own memory: timings must not depend on a bus.
#[derive(Default)]
pub(super) struct Local {
    staging: Option<Buffer>,
    local: Option<Buffer>,
}

/// Tessellates patches; keeps its buffers.
pub struct Tessellator {
    // Before `recorder`, whose device they hold too; `drop` waits first.
    pub(super) patches: Local,
    pub(super) list: Local,
    pub(super) values: Local,
    samples: Option<Buffer>,
    found: Option<Buffer>,
    pub(super) pipelines: TessellationPipelines,
    pub(super) recorder: Recorder,
}

/// Pieces of patches of the same degrees: one draw.
struct Bin {
    pipeline: vk::Pipeline,
    pieces: Range<u32>,
}

/// What is drawn.
struct Prepared {
    pieces: Vec<Piece>,
    bins: Vec<Bin>,
    push: TessellationPush,
}

/// No sum of a vertex' coordinates is as large.
pub(super) const SENTINEL: f32 = 3e38;
/// A vertex that was never stored: NaN.
const NEVER: u32 = u32::MAX;

impl Tessellator {
    pub fn new(device: Arc<Device>) -> Result<Self, VulkanError> {
        if let Err(lacks) = &device.tessellation {
            let missing = lacks.iter().map(|&name| name.to_owned()).collect();
            return Err(VulkanError::Unfit { device: device.found.name.clone(), missing });
        }
        Ok(Self {
            patches: Local::default(),
            list: Local::default(),
            values: Local::default(),
            samples: None,
            found: None,
            pipelines: TessellationPipelines::new(&device)?,
            recorder: Recorder::new(device)?,
        })
    }

    pub fn device(&self) -> &Device {
        &self.recorder.device
    }

    /// Every vertex that the hardware asks for, as the evaluation shader emits it.
    pub fn evaluate(&mut self, input: &Tessellation) -> Result<Tessellated, VulkanError> {
        self.recorder.check()?;
        let Prepared { pieces, bins, push } = self.prepare(input, true)?;
        let count: usize = pieces.iter().map(Piece::stored).sum();
        let samples = self.store(push, count, |on, push| draw(on, &bins, push))?;
        Ok(Tessellated { pieces, samples })
    }

    /// Milliseconds to evaluate and discard all vertices, on the device's clock.
    pub fn time(&mut self, input: &Tessellation, rounds: u32) -> Result<Spread, VulkanError> {
        self.recorder.check()?;
        let Prepared { bins, push, .. } = self.prepare(input, false)?;
        self.clock(push, rounds, |on, push| draw(on, &bins, push))
    }

    /// Draws with pipelines that store: what they stored.
    pub(super) fn store(
        &mut self,
        mut push: TessellationPush,
        count: usize,
        draw: impl FnOnce(&On, &TessellationPush),
    ) -> Result<Vec<Sample>, VulkanError> {
        let Self { recorder, pipelines, samples, found, .. } = self;
        let bytes = count as u64 * size_of::<Sample>() as u64;
        if count > u32::MAX as usize {
            return Err(VulkanError::OutOfMemory { what: "storing vertices", bytes });
        }
        let device = recorder.device.clone();
        let samples = room(&device, samples, bytes, Use::Shaders)?;
        let found = room(&device, found, bytes, Use::Download)?;
        push.samples = samples.address;
        let regions = if bytes > 0 { vec![vk::BufferCopy::default().size(bytes)] } else { Vec::new() };
        let copies = [Copy { from: samples.raw, to: found.raw, regions }];
        recorder.run("tessellating", |recorder| {
            // SAFETY: commands are being recorded, outside of rendering; the buffer lives until they have run.
            unsafe { device.raw.cmd_fill_buffer(recorder.commands, samples.raw, 0, vk::WHOLE_SIZE, NEVER) };
            recorder.barrier(vk::PipelineStageFlags2::CLEAR, SHADERS);
            On { recorder, pipelines }.render(|on| draw(on, &push));
            recorder.barrier(SHADERS, vk::PipelineStageFlags2::COPY);
            recorder.copy(&copies);
            recorder.barrier(vk::PipelineStageFlags2::COPY, vk::PipelineStageFlags2::HOST);
        })?;
        Ok(found.read::<Sample>(count).to_vec())
    }

    /// Draws with pipelines that do not.
    pub(super) fn clock(
        &mut self,
        mut push: TessellationPush,
        rounds: u32,
        draw: impl Fn(&On, &TessellationPush),
    ) -> Result<Spread, VulkanError> {
        let Self { recorder, pipelines, samples, .. } = self;
        // Shaders must have a place where they could store.
        push.samples = room(&recorder.device.clone(), samples, size_of::<Sample>() as u64, Use::Shaders)?.address;
        recorder.time("tessellating", rounds, |recorder| {
            On { recorder, pipelines }.render(|on| draw(on, &push));
        })
    }

    fn prepare(&mut self, input: &Tessellation, stores: bool) -> Result<Prepared, VulkanError> {
        check(input)?;
        let device = self.recorder.device.clone();
        let largest = *device.tessellation.as_ref().unwrap_or(&1);
        let mut all = pieces(input.patches, input.factors, largest);
        let degree = |piece: &Piece| input.patches[piece.patch as usize].degree;
        all.sort_by_key(degree);
        let mut counts: BTreeMap<[u8; 2], u32> = BTreeMap::new();
        let mut samples = 0u64;
        for piece in &mut all {
            *counts.entry(degree(piece)).or_default() += 1;
            // Where that does not fit nothing is stored: `stored` refuses.
            piece.samples = samples as u32;
            samples += piece.stored() as u64;
        }
        let (mut bins, mut first) = (Vec::new(), 0);
        for (degree, count) in counts {
            let exact = input.parameters == Parameters::Exact;
            let pipeline = self.pipelines.of(Work::Tessellate { degree, exact }, stores)?;
            bins.push(Bin { pipeline, pieces: first..first + count });
            first += count;
        }
        let mut copies = Vec::new();
        let push = TessellationPush {
            patches: self.patches.fill(&device, input.patches, input.patches.len(), &mut copies)?,
            list: self.list.fill(&device, &all, all.len(), &mut copies)?,
            values: self.values.fill(&device, input.nets, input.nets.len(), &mut copies)?,
            ..pushed(&device, input.size, input.view)
        };
        self.upload(&copies)?;
        Ok(Prepared { pieces: all, bins, push })
    }

    pub(super) fn upload(&mut self, copies: &[Copy]) -> Result<(), VulkanError> {
        self.recorder.run("copying patches", |recorder| {
            recorder.copy(copies);
            recorder.barrier(vk::PipelineStageFlags2::COPY, SHADERS);
        })
    }
}

/// All shaders that are run here.
const SHADERS: vk::PipelineStageFlags2 = vk::PipelineStageFlags2::PRE_RASTERIZATION_SHADERS;

/// What draws are recorded with.
pub(super) struct On<'a> {
    pub recorder: &'a Recorder,
    pub pipelines: &'a TessellationPipelines,
}

impl On<'_> {
    /// Within a rendering without attachments.
    fn render(&self, draw: impl FnOnce(&Self)) {
        let (raw, commands) = (&self.recorder.device.raw, self.recorder.commands);
        let area = vk::Rect2D::default().extent(vk::Extent2D { width: 1, height: 1 });
        let rendering = vk::RenderingInfo::default().render_area(area).layer_count(1);
        // SAFETY: commands are being recorded.
        unsafe { raw.cmd_begin_rendering(commands, &rendering) };
        draw(self);
        // SAFETY: as above.
        unsafe { raw.cmd_end_rendering(commands) };
    }

    pub fn bind(&self, pipeline: vk::Pipeline, push: &TessellationPush) {
        let (raw, commands) = (&self.recorder.device.raw, self.recorder.commands);
        // SAFETY: commands are being recorded; pipelines live as long as the tessellator, which waits for what it runs.
        unsafe { raw.cmd_bind_pipeline(commands, vk::PipelineBindPoint::GRAPHICS, pipeline) };
        self.pipelines.push(commands, push);
    }
}

fn draw(on: &On, bins: &[Bin], push: &TessellationPush) {
    for Bin { pipeline, pieces } in bins {
        on.bind(*pipeline, &TessellationPush { first: pieces.start, count: pieces.end, ..*push });
        // SAFETY: commands are being recorded, in rendering, with all bound that the pipeline asks for.
        unsafe { on.recorder.device.raw.cmd_draw(on.recorder.commands, pieces.len() as u32, 1, 0, 0) };
    }
}

/// What shaders are told, but for addresses.
pub(super) fn pushed(device: &Device, size: [u32; 2], view: &abi::View) -> TessellationPush {
    TessellationPush {
        middle: size.map(|n| n as i32 / 2),
        half_viewport: device.half_viewport as i32,
        perspective: view.perspective,
        near: view.near_f32,
        depth_slope: view.depth_slope,
        sentinel: SENTINEL,
        ..TessellationPush::default()
    }
}

impl Local {
    /// Takes values to the device, again and again until there are `count`; their address once `copies` are made.
    pub fn fill<T: Pod>(
        &mut self,
        device: &Arc<Device>,
        values: &[T],
        count: usize,
        copies: &mut Vec<Copy>,
    ) -> Result<u64, VulkanError> {
        let (once, all) = (size_of_val(values) as u64, (count * size_of::<T>()) as u64);
        let from = room(device, &mut self.staging, once, Use::Upload)?;
        from.write(values.iter().copied());
        let to = room(device, &mut self.local, all, Use::Shaders)?;
        let at = (0..all).step_by(once.max(1) as usize);
        let regions = at.map(|at| vk::BufferCopy::default().dst_offset(at).size(once.min(all - at))).collect();
        copies.push(Copy { from: from.raw, to: to.raw, regions });
        Ok(to.address)
    }
}

/// Shaders read what patches say: all of it must be there.
fn check(input: &Tessellation) -> Result<(), VulkanError> {
    let sides = match input.factors {
        EdgeFactors::Own => input.patches.len(),
        EdgeFactors::Shared(sides) => sides.len(),
    };
    for (k, patch) in input.patches.iter().enumerate() {
        let points: usize = patch.degree.iter().map(|&d| usize::from(d) + 1).product();
        let reason = if patch.quads.contains(&0) {
            "its grid has no quads"
        } else if patch.degree.contains(&0) {
            "it is of degree 0"
        } else if patch.net as usize + points > input.nets.len() {
            "its net ends beyond the list"
        } else if k >= sides {
            "its sides have no names"
        } else {
            continue;
        };
        return Err(VulkanError::BadPatch { patch: k, reason });
    }
    Ok(())
}

impl Drop for Tessellator {
    fn drop(&mut self) {
        // Fields are dropped after this: nothing uses their buffers and pipelines any more.
        self.recorder.device.wait_idle();
    }
}

impl std::fmt::Debug for Tessellator {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.debug_tuple("Tessellator").field(&self.recorder.device).finish()
    }
}
