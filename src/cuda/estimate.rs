//! estimate, host side: the leaves of all visible patches with their grids. Twin of src/stages/estimate.rs.

use super::count::{Count, List};
use super::cull::Seen;
use super::gpu::pods;
use super::scan::scan;
use super::session::{Geometry, Session};
use super::shared::Role;
use super::{Argument, Buffer, Gpu, GpuError, Pointer, Shape, abi, basis};
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
    pub count: Count,
    pub patches: Buffer<abi::Patch>,
    /// The same leaves, for the stages that draw them.
    pub leaves: Buffer<abi::Leaf>,
    pub nets: Buffer<abi::Point>,
    pub basis: Buffer<f32>,
    /// What was counted of the visible patches.
    visible: Count,
    counters: Buffer<abi::Counters>,
}

impl Leaves {
    /// Meshlets of these leaves, as the stages that draw them are given them; without vertices.
    pub fn geometry(&self, view: &abi::View, meshlets: List<abi::Meshlet>) -> Geometry {
        let Self { patches, leaves, nets, basis, .. } = *self;
        Geometry { view: *view, patches, leaves, nets, basis, meshlets, vertices: None }
    }

    /// Patches of which something is kept.
    pub fn patches_visible<G: Gpu>(&self, session: &mut Session<G>) -> Result<u64, GpuError> {
        let visible = session.length(self.visible)?;
        let counters = session.download(&self.counters)?.first().copied().unwrap_or_default();
        Ok(visible - u64::from(counters.split) + u64::from(counters.visible))
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
    visible: List<abi::Visible>,
    /// Leaves of each, and their control points.
    leaf_counts: Buffer<u32>,
    point_counts: Buffer<u32>,
    /// Those that are to be split.
    work: Buffer<u32>,
    counters: Buffer<abi::Counters>,
}

/// Leaves with their nets, and where they belong.
struct PartLists {
    places: Buffer<abi::PartPlace>,
    patches: Buffer<abi::Patch>,
    leaves: Buffer<abi::Leaf>,
    nets: Buffer<abi::Point>,
}

/// The leaves that splitting made, in no order, and what was counted.
struct Parts {
    lists: PartLists,
    room: Room,
    counters: Buffer<abi::Counters>,
}

/// The leaves of the visible patches, in the order of instances, patches and parameters.
pub(crate) fn estimate<G: Gpu>(
    session: &mut Session<G>,
    seen: &Seen,
    visible: List<abi::Visible>,
) -> Result<Leaves, Stopped> {
    let estimated = session.group("grids", |session| grids(session, seen, visible))?;
    let parts = session.group("split", |session| split(session, seen, &estimated))?;
    let (first_leaves, leaf_total) = scan(session, &estimated.leaf_counts, visible.count)?;
    let (first_points, point_total) = scan(session, &estimated.point_counts, visible.count)?;
    let leaf_count = session.count(leaf_total, u64::from(MAX_PARTS))?.map_err(|_| Stopped::Vertices)?;
    let point_count = session.count(point_total, u64::from(u32::MAX))?.map_err(|_| Stopped::Vertices)?;
    let count = whole(session, &parts, leaf_count, point_count)?;
    let patches = session.allocate_as::<abi::Patch>(Role::Patches, count.room())?;
    let leaves = session.allocate_as::<abi::Leaf>(Role::Leaves, count.room())?;
    let nets = session.allocate::<abi::Point>(point_count.room())?;
    let Seen { scene, view, rules } = seen;
    let (firsts, points) = (first_leaves.pointer(), first_points.pointer());
    let lists = (patches.pointer(), leaves.pointer(), nets.pointer());
    let (pointers, instances) = (scene.pointers(), scene.instances());
    session.for_all(
        "estimate_leaves",
        visible.count,
        &[
            view,
            rules,
            &pointers,
            &instances,
            &visible.count,
            &visible.pointer(),
            &firsts,
            &points,
            &count,
            &lists.0,
            &lists.1,
            &lists.2,
        ],
    )?;
    let PartLists { places, patches: part_patches, leaves: part_leaves, nets: part_nets } = &parts.lists;
    let from = (places.pointer(), part_patches.pointer(), part_leaves.pointer(), part_nets.pointer());
    let counters = parts.counters.pointer();
    session.for_each(
        "place_parts",
        parts.room.parts,
        &[&counters, &count, &from.0, &from.1, &from.2, &from.3, &firsts, &points, &lists.0, &lists.1, &lists.2],
    )?;
    let tables = |session: &mut Session<G>| basis::tables(session, &patches, count, scene.degree);
    let (basis, count) = session.group("basis", tables)?;
    Ok(Leaves { count, patches, leaves, nets, basis, visible: visible.count, counters: parts.counters })
}

/// As many leaves as there are, where splitting and all control points had room.
fn whole<G: Gpu>(session: &mut Session<G>, parts: &Parts, leaves: Count, points: Count) -> Result<Count, GpuError> {
    if session.asks() {
        return Ok(leaves);
    }
    let out = session.counters(1)?;
    let room = (parts.room.parts as u32, parts.room.part_points as u32);
    let arguments: [&dyn Argument; 6] = [&parts.counters.pointer(), &room.0, &room.1, &leaves, &points, &out];
    session.launch("split_check", Shape::row(1, 1), &arguments)?;
    Ok(session.counted(out, leaves.room() as u32))
}

/// The grids of the patches that are drawn as a whole.
fn grids<G: Gpu>(session: &mut Session<G>, seen: &Seen, visible: List<abi::Visible>) -> Result<Estimated, Stopped> {
    let Seen { scene, view, rules } = seen;
    let room = visible.room();
    let leaf_counts = session.allocate::<u32>(room)?;
    let point_counts = session.allocate::<u32>(room)?;
    let work = session.allocate::<u32>(room)?;
    let counters = session.allocate::<abi::Counters>(1)?;
    session.launch("estimate_begin", Shape::row(1, 1), &[&counters.pointer()])?;
    if room > 0 {
        let small = rules.grid == abi::GridRule::GRID_ETER16;
        let default = rules.bound == abi::BoundRule::BOUND_SCREEN && !small;
        session.launch(
            if default { "estimate_patches_screen" } else { "estimate_patches" },
            Shape::of(room, THREADS),
            &[
                view,
                rules,
                &scene.pointers(),
                &scene.instances(),
                &visible.count,
                &visible.pointer(),
                &leaf_counts.pointer(),
                &point_counts.pointer(),
                &work.pointer(),
                &counters.pointer(),
            ],
        )?;
    }
    Ok(Estimated { visible, leaf_counts, point_counts, work, counters })
}

/// What splitting has room for.
#[derive(Clone, Copy)]
struct Room {
    /// Patches that are split at once at most.
    warps: usize,
    halves: usize,
    parts: usize,
    part_points: usize,
}

impl Room {
    /// As much as an earlier frame needed, and some more.
    fn planned<G: Gpu>(session: &mut Session<G>) -> Result<Self, GpuError> {
        let mut next = |limit: u64| session.number(limit, |_| Ok(0)).map(|n| n as usize);
        let most = u64::from(u32::MAX);
        Ok(Self {
            warps: next(most)?,
            halves: next(most)?,
            parts: next(u64::from(MAX_PARTS))?,
            part_points: next(most)?,
        })
    }
}

/// The leaves of all other patches. Where the frame asks, what there was no room for is counted, and made in a second run.
fn split<G: Gpu>(session: &mut Session<G>, seen: &Seen, from: &Estimated) -> Result<Parts, Stopped> {
    if !session.asks() {
        let room = Room::planned(session)?;
        let lists = split_within(session, seen, from, &from.counters, &room)?;
        return Ok(Parts { lists, room, counters: from.counters });
    }
    let work = session.download(&from.counters)?[0].split as usize;
    let parts = PARTS * work;
    let mut room = Room { warps: work, halves: HALVES, parts, part_points: parts * seen.scene.most_points.min(64) };
    loop {
        let start = abi::Counters { error: abi::NO_ERROR, split: work as u32, ..abi::Counters::default() };
        let counters = session.upload(&[start])?;
        let lists = split_within(session, seen, from, &counters, &room)?;
        let found = session.download(&counters)?[0];
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
            for number in [room.warps, room.halves, parts, part_points] {
                session.number(0, |_| Ok(number as u64))?;
            }
            return Ok(Parts { lists, room: Room { parts, ..room }, counters });
        }
        room.parts = room.parts.max(parts);
        room.part_points = room.part_points.max(part_points);
    }
}

fn split_within<G: Gpu>(
    session: &mut Session<G>,
    seen: &Seen,
    from: &Estimated,
    counters: &Buffer<abi::Counters>,
    room: &Room,
) -> Result<PartLists, GpuError> {
    let Seen { scene, view, rules } = seen;
    let bytes = 8 * scene.memory + room.halves * size_of::<abi::Half>();
    let warps = (SPLIT_BYTES / bytes).clamp(1, SPLIT_WARPS).min(room.warps);
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
    if warps > 0 {
        let shape = Shape::row(warps as u32, 32);
        session.launch("split_patches", shape, &[view, rules, &scene.pointers(), &pointers, &sizes])?;
    }
    Ok(lists)
}
