//! Which workgroups a frame takes: one a meshlet for its triangles, one for each 32 of its other items, and none where it has
//! no such items.

use super::pipeline::{Kind, Push};
use super::rasterize::Input;
use crate::cuda::{Pod, abi};
use crate::stages::Fill;

/// Items of a meshlet that one workgroup of vk_shaders/outlines.mesh looks at.
const ITEMS: u32 = 32;
/// Bits of a meshlet's number; which of its workgroups it is stands above.
const NUMBER_BITS: u32 = 32 - abi::INDEX_BITS;

/// Workgroups of one pipeline in the list of jobs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Draw {
    pub kind: Kind,
    pub trimmed: bool,
    pub first: u32,
    pub count: u32,
}

/// The kinds that are drawn into the near buffer; then, once that is done, into the spare one.
pub(super) fn passes(fill: Fill) -> [&'static [Kind]; 2] {
    let outlines: &[Kind] = match fill {
        Fill::Off => &[],
        Fill::Stroke => &[Kind::Borders, Kind::Folds, Kind::TurnedAway],
        Fill::Eter | Fill::Conservative => &[Kind::Conservative],
    };
    [&[Kind::Triangles, Kind::Far], outlines]
}

/// The list that `push.numbers` names, and who draws what of it.
pub(super) fn jobs(input: &Input, push: &Push) -> (Vec<u32>, Vec<Draw>) {
    let (mut jobs, mut draws) = (Vec::new(), Vec::new());
    for &kind in passes(input.fill).into_iter().flatten() {
        for trimmed in [false, true] {
            let first = jobs.len() as u32;
            for &number in input.numbers {
                let meshlet = &input.meshlets[number as usize];
                if (meshlet.tested != 0) == trimmed {
                    let groups = groups(kind, meshlet, input, push);
                    jobs.extend((0..groups).map(|part| number | part << NUMBER_BITS));
                }
            }
            let count = jobs.len() as u32 - first;
            if count > 0 {
                draws.push(Draw { kind, trimmed, first, count });
            }
        }
    }
    (jobs, draws)
}

/// Kinds, each without trims and with them.
pub(crate) const BINS: usize = 12;

/// What a device that lists workgroups itself is told: `Wanted` of kernels/hardware.cu.
#[derive(Clone, Copy, Debug)]
#[repr(C)]
pub(crate) struct Wanted {
    /// A bit for each kind that the fill rule draws.
    pub kinds: u32,
    pub middle: [i32; 2],
    pub half_viewport: i32,
}

// SAFETY: numbers, without padding; any bytes are a value of it.
unsafe impl Pod for Wanted {}

/// A list of workgroups that a device makes.
#[derive(Clone, Debug)]
pub(crate) struct Jobs {
    /// Where each bin begins in it.
    pub first: [u32; BINS],
    /// How long it is.
    pub all: u32,
    pub(super) draws: Vec<Draw>,
}

impl Wanted {
    pub fn new(fill: Fill, size: [u32; 2], half_viewport: i32) -> Self {
        let kinds = passes(fill).into_iter().flatten().fold(0, |bits, &kind| bits | 1 << kind as u32);
        Self { kinds, middle: middle(size), half_viewport }
    }
}

impl Jobs {
    /// Of as many workgroups in each bin; None: of more than lists hold.
    pub fn new(counts: &[u64; BINS], fill: Fill) -> Option<Self> {
        let mut jobs = Self { first: [0; BINS], all: 0, draws: Vec::new() };
        for (&kind, trimmed) in passes(fill).into_iter().flatten().flat_map(|kind| [(kind, false), (kind, true)]) {
            let bin = 2 * kind as usize + usize::from(trimmed);
            let (first, count) = (jobs.all, u32::try_from(counts[bin]).ok()?);
            jobs.first[bin] = first;
            jobs.all = first.checked_add(count)?;
            if count > 0 {
                jobs.draws.push(Draw { kind, trimmed, first, count });
            }
        }
        Some(jobs)
    }
}

/// The pixel in the viewport's middle.
pub(super) fn middle(size: [u32; 2]) -> [i32; 2] {
    size.map(|n| n as i32 / 2)
}

/// How many workgroups a meshlet's items of a kind take.
fn groups(kind: Kind, meshlet: &abi::Meshlet, input: &Input, push: &Push) -> u32 {
    let quads = meshlet.quads.map(u32::from).iter().product::<u32>();
    let (patch, leaf) = (&input.patches[meshlet.patch as usize], &input.leaves[meshlet.patch as usize]);
    let (is_drawn, items) = match kind {
        Kind::Triangles => (true, 1),
        Kind::Far => (is_far(input, meshlet, push), 2 * quads),
        Kind::Borders => (meshlet.outer != 0, 1),
        Kind::Folds => (leaf.pen_fold > 0, 3 * quads),
        Kind::TurnedAway => (leaf.pen_fold > 0 && patch.hidden != 0, 2 * quads),
        Kind::Conservative => (true, 2 * quads),
    };
    if is_drawn { items.div_ceil(ITEMS) } else { 0 }
}

/// Some vertex lies beyond the viewport: the same question as `is_far` of vk_shaders/geometry.glsl.
fn is_far(input: &Input, meshlet: &abi::Meshlet, push: &Push) -> bool {
    let count = (usize::from(meshlet.quads[0]) + 1) * (usize::from(meshlet.quads[1]) + 1);
    let most = (push.half_viewport - 1) * abi::SUBPIXELS;
    let off = |place: i32, axis: usize| (place - push.middle[axis] * abi::SUBPIXELS).abs() > most;
    input.vertices[meshlet.vertices as usize..][..count].iter().any(|v| off(v.x, 0) || off(v.y, 1))
}
