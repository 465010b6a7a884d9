//! estimate, host side: the leaves of all visible patches with their grids. Twin of src/stages/estimate.rs.

use super::cull::Seen;
use super::gpu::pods;
use super::scan::scan;
use super::session::{Geometry, Session};
use super::{Buffer, Gpu, GpuError, Pointer, Shape, abi, basis};
use thiserror::Error;

/// Threads a block of `estimate_patches`: as many columns has its list of constraints.
const THREADS: u32 = 64;
/// Memory for splitting patches, and warps that do.
const SPLIT_BYTES: usize = 256 << 20;
const SPLIT_WARPS: usize = 4096;
/// Halves that a warp has room for at first, and leaves that can be tried at once: each is a halving deeper.
const HALVES: usize = 128;
const TRIED: usize = 48;
/// Leaves of a split patch that there is room for at first.
const PARTS: usize = 8;
/// `MAX_PARTS` of kernels/split.cu: no frame has room for the vertices of more.
const MAX_PARTS: u32 = 1 << 26;

pods!(abi::Counters abi::Half abi::HalvedLeaf abi::PartPlace SplitPointers SplitSizes);

/// Why there is no list of leaves, or of meshlets.
#[derive(Clone, Debug, PartialEq, Error)]
pub(crate) enum Stopped {
    #[error(transparent)]
    Gpu(#[from] GpuError),
    /// At an item, the number of a patch among those of all instances.
    #[error("estimate stopped at item {item}: error {error}")]
    Item { item: u32, error: u32 },
    #[error("too many vertices")]
    Vertices,
    #[error("{needed} meshlets are needed")]
    Meshlets { needed: u64 },
}

/// The leaves of a frame.
pub(crate) struct Leaves {
    pub patches: Buffer<abi::Patch>,
    /// The same leaves, for the stages that draw them.
    pub leaves: Buffer<abi::Leaf>,
    pub nets: Buffer<abi::Point>,
    pub basis: Buffer<f32>,
    /// Patches of which something is kept.
    pub patches_visible: u64,
}

impl Leaves {
    /// Meshlets of these leaves, as the stages that draw them are given them; without vertices.
    pub fn geometry(&self, view: &abi::View, meshlets: Buffer<abi::Meshlet>) -> Geometry {
        let Self { patches, leaves, nets, basis, .. } = *self;
        Geometry { view: *view, patches, leaves, nets, basis, meshlets, vertices: None }
    }
}

/// `split::Buffers` of kernels/split.cu.
#[derive(Clone, Copy)]
#[repr(C)]
struct SplitPointers {
    visible: Pointer<abi::Visible>,
    work: Pointer<u32>,
    counters: Pointer<abi::Counters>,
    leaf_counts: Pointer<u32>,
    point_counts: Pointer<u32>,
    patches: Pointer<abi::Patch>,
    leaves: Pointer<abi::Leaf>,
    places: Pointer<abi::PartPlace>,
    nets: Pointer<abi::Point>,
    memory: Pointer<f64>,
    halves: Pointer<abi::Half>,
    tried: Pointer<abi::HalvedLeaf>,
}

/// `split::Sizes` of kernels/split.cu.
#[derive(Clone, Copy)]
#[repr(C)]
struct SplitSizes {
    instances: u32,
    parts: u32,
    part_points: u32,
    memory: u32,
    halves: u32,
    tried: u32,
}

/// What estimate keeps of the visible patches.
struct Estimated {
    visible: Buffer<abi::Visible>,
    /// Leaves of each, and their control points.
    leaf_counts: Buffer<u32>,
    point_counts: Buffer<u32>,
    /// Those that are to be split.
    work: Buffer<u32>,
    split: u32,
}

/// Leaves with their nets, and where they belong.
struct PartLists {
    places: Buffer<abi::PartPlace>,
    patches: Buffer<abi::Patch>,
    leaves: Buffer<abi::Leaf>,
    nets: Buffer<abi::Point>,
}

/// The leaves that splitting made, in no order.
#[derive(Default)]
struct Parts {
    lists: Option<PartLists>,
    count: u32,
    visible: u32,
}

/// The leaves of the visible patches, in the order of instances, patches and parameters.
pub(crate) fn estimate<G: Gpu>(
    session: &mut Session<G>,
    seen: &Seen,
    visible: Buffer<abi::Visible>,
) -> Result<Leaves, Stopped> {
    let estimated = session.group("grids", |session| grids(session, seen, visible))?;
    let parts = session.group("split", |session| split(session, seen, &estimated))?;
    let (first_leaves, leaf_count) = scan(session, &estimated.leaf_counts)?;
    let (first_points, point_count) = scan(session, &estimated.point_counts)?;
    if leaf_count > u64::from(MAX_PARTS) || point_count > u64::from(u32::MAX) {
        return Err(Stopped::Vertices);
    }
    let patches = session.allocate::<abi::Patch>(leaf_count as usize)?;
    let leaves = session.allocate::<abi::Leaf>(leaf_count as usize)?;
    let nets = session.allocate::<abi::Point>(point_count as usize)?;
    let Seen { scene, view, rules } = seen;
    let (firsts, points) = (first_leaves.pointer(), first_points.pointer());
    let lists = (patches.pointer(), leaves.pointer(), nets.pointer());
    let count = visible.len() as u32;
    let (pointers, instances) = (scene.pointers(), scene.instances());
    session.for_each(
        "estimate_leaves",
        visible.len(),
        &[
            view,
            rules,
            &pointers,
            &instances,
            &count,
            &visible.pointer(),
            &firsts,
            &points,
            &lists.0,
            &lists.1,
            &lists.2,
        ],
    )?;
    if let Some(PartLists { places, patches, leaves, nets }) = &parts.lists {
        let from = (places.pointer(), patches.pointer(), leaves.pointer(), nets.pointer());
        session.for_each(
            "place_parts",
            parts.count as usize,
            &[&parts.count, &from.0, &from.1, &from.2, &from.3, &firsts, &points, &lists.0, &lists.1, &lists.2],
        )?;
    }
    let basis = session.group("basis", |session| basis::tables(session, &patches, scene.degree))?;
    let patches_visible = u64::from(count - estimated.split + parts.visible);
    Ok(Leaves { patches, leaves, nets, basis, patches_visible })
}

/// The grids of the patches that are drawn as a whole.
fn grids<G: Gpu>(session: &mut Session<G>, seen: &Seen, visible: Buffer<abi::Visible>) -> Result<Estimated, Stopped> {
    let Seen { scene, view, rules } = seen;
    let leaf_counts = session.allocate::<u32>(visible.len())?;
    let point_counts = session.allocate::<u32>(visible.len())?;
    let work = session.allocate::<u32>(visible.len())?;
    let counters = session.upload(&[abi::Counters { error: abi::NO_ERROR, ..abi::Counters::default() }])?;
    if !visible.is_empty() {
        let default = rules.bound == abi::BoundRule::BOUND_SCREEN;
        session.launch(
            if default { "estimate_patches_screen" } else { "estimate_patches" },
            Shape::of(visible.len(), THREADS),
            &[
                view,
                rules,
                &scene.pointers(),
                &scene.instances(),
                &(visible.len() as u32),
                &visible.pointer(),
                &leaf_counts.pointer(),
                &point_counts.pointer(),
                &work.pointer(),
                &counters.pointer(),
            ],
        )?;
    }
    let split = session.download(&counters)?[0].split;
    Ok(Estimated { visible, leaf_counts, point_counts, work, split })
}

/// What splitting has room for.
struct Room {
    halves: usize,
    parts: usize,
    part_points: usize,
}

/// The leaves of all other patches. What there was no room for is counted, and made in a second run.
fn split<G: Gpu>(session: &mut Session<G>, seen: &Seen, from: &Estimated) -> Result<Parts, Stopped> {
    if from.split == 0 {
        return Ok(Parts::default());
    }
    let parts = PARTS * from.split as usize;
    let mut room = Room { halves: HALVES, parts, part_points: parts * seen.scene.most_points.min(64) };
    loop {
        let (found, lists) = split_within(session, seen, from, &room)?;
        if found.error != abi::NO_ERROR {
            return Err(Stopped::Item { item: (found.error >> 8) as u32, error: found.error as u32 & 0xff });
        }
        if found.parts > MAX_PARTS || found.part_points > u64::from(u32::MAX) {
            return Err(Stopped::Vertices);
        }
        let (parts, part_points) = (found.parts as usize, found.part_points as usize);
        if found.short_of_halves > 0 {
            room.halves *= 8;
        } else if parts <= room.parts && part_points <= room.part_points {
            return Ok(Parts { lists: Some(lists), count: found.parts, visible: found.visible });
        }
        room.parts = room.parts.max(parts);
        room.part_points = room.part_points.max(part_points);
    }
}

fn split_within<G: Gpu>(
    session: &mut Session<G>,
    seen: &Seen,
    from: &Estimated,
    room: &Room,
) -> Result<(abi::Counters, PartLists), GpuError> {
    let Seen { scene, view, rules } = seen;
    let start = abi::Counters { error: abi::NO_ERROR, split: from.split, ..abi::Counters::default() };
    let counters = session.upload(&[start])?;
    let bytes = 8 * scene.memory + room.halves * size_of::<abi::Half>();
    let warps = (SPLIT_BYTES / bytes).clamp(1, SPLIT_WARPS).min(from.split as usize);
    let lists = PartLists {
        places: session.allocate(room.parts)?,
        patches: session.allocate(room.parts)?,
        leaves: session.allocate(room.parts)?,
        nets: session.allocate(room.part_points)?,
    };
    let pointers = SplitPointers {
        visible: from.visible.pointer(),
        work: from.work.pointer(),
        counters: counters.pointer(),
        leaf_counts: from.leaf_counts.pointer(),
        point_counts: from.point_counts.pointer(),
        patches: lists.patches.pointer(),
        leaves: lists.leaves.pointer(),
        places: lists.places.pointer(),
        nets: lists.nets.pointer(),
        memory: session.allocate(warps * scene.memory)?.pointer(),
        halves: session.allocate(warps * room.halves)?.pointer(),
        tried: session.allocate(warps * TRIED)?.pointer(),
    };
    let sizes = SplitSizes {
        instances: scene.instances(),
        parts: room.parts as u32,
        part_points: room.part_points as u32,
        memory: scene.memory as u32,
        halves: room.halves as u32,
        tried: TRIED as u32,
    };
    let shape = Shape::row(warps as u32, 32);
    session.launch("split_patches", shape, &[view, rules, &scene.pointers(), &pointers, &sizes])?;
    Ok((session.download(&counters)?[0], lists))
}
