//! The list of meshlets, made on the device: second half of `evaluate`'s twin, src/stages/evaluate.rs.

use super::count::{Count, List};
use super::cull::Seen;
use super::estimate::{Leaves, Stopped};
use super::evaluate::{WARPS, evaluate};
use super::gpu::pods;
use super::precision::Arithmetic;
use super::scan::scan;
use super::session::Session;
use super::shared::Role;
use super::{Buffer, Gpu, GpuError, Pointer, Shape, abi};

pods!(abi::MeshletCounts);

/// Vertices of all grids together, as src/stages/estimate.rs has it, and meshlets that a visibility word can name.
const MAX_VERTICES: u64 = 1 << 28;
const MAX_MESHLETS: u64 = 1 << (32 - abi::INDEX_BITS);
/// Warps a block of `meshlet_region`.
const REGION_WARPS: u32 = 4;

/// A frame's meshlets.
pub(crate) struct Meshlets {
    /// In the order of their numbers.
    pub meshlets: List<abi::Meshlet>,
    /// Vertices of all of them.
    pub vertices: Count,
    /// Those before any were dropped.
    all: Count,
    counts: Buffer<abi::MeshletCounts>,
}

/// What was counted of a frame's meshlets.
pub(crate) struct Counted {
    pub quads: u64,
    /// Of trimmed leaves: those that no curve crosses, those that one may cross, and those that were dropped.
    pub inside: u64,
    pub boundary: u64,
    pub outside: u64,
}

impl Meshlets {
    pub fn counted<G: Gpu>(&self, session: &mut Session<G>) -> Result<Counted, GpuError> {
        let outside = session.length(self.all)? - session.length(self.meshlets.count)?;
        let abi::MeshletCounts { quads, inside, boundary } =
            session.download(&self.counts)?.first().copied().unwrap_or_default();
        Ok(Counted { quads, inside: inside.into(), boundary: boundary.into(), outside })
    }
}

/// Cuts all grids into meshlets.
pub(crate) fn meshlets<G: Gpu>(session: &mut Session<G>, seen: &Seen, leaves: &Leaves) -> Result<Meshlets, Stopped> {
    let count = leaves.count;
    let (blocks, vertices) = (session.allocate(count.room())?, session.allocate(count.room())?);
    let patches = leaves.patches.pointer();
    session.for_all("meshlet_counts", count, &[&count, &patches, &blocks.pointer(), &vertices.pointer()])?;
    let (first_blocks, needed) = scan(session, &blocks, count)?;
    let (first_vertices, vertices) = scan(session, &vertices, count)?;
    let vertices = session.count(vertices, MAX_VERTICES)?.map_err(|_| Stopped::Vertices)?;
    let needed = session.count(needed, MAX_MESHLETS)?.map_err(|needed| Stopped::Meshlets { needed })?;
    let all = session.both(needed, vertices)?;
    let trims = seen.view.trim != 0 && seen.scene.trimmed;
    // Those that trims leave are the final ones.
    let meshlets = if trims { session.list(all)? } else { session.list_as(Role::Meshlets, all)? };
    session.for_all(
        "meshlet_list",
        count,
        &[&count, &patches, &first_blocks.pointer(), &first_vertices.pointer(), &all, &meshlets.pointer()],
    )?;
    let counts = session.zeroed::<abi::MeshletCounts>(1)?;
    let mut found = Meshlets { meshlets, vertices, all, counts };
    if trims {
        found = trim(session, seen, leaves, found)?;
    }
    let kept = found.meshlets.count;
    // Whole warps: they sum together.
    session.for_all("meshlet_quads", kept, &[&kept, &found.meshlets.pointer(), &counts.pointer()])?;
    Ok(found)
}

/// Drops what lies outside the trims, and marks what curves cross.
fn trim<G: Gpu>(session: &mut Session<G>, seen: &Seen, leaves: &Leaves, from: Meshlets) -> Result<Meshlets, GpuError> {
    let count = from.all;
    let states = session.allocate::<u8>(count.room())?;
    let (flags, vertices) = (session.allocate::<u32>(count.room())?, session.allocate::<u32>(count.room())?);
    let (patches, descriptions) = (leaves.patches.pointer(), leaves.leaves.pointer());
    let (meshlets, states) = (from.meshlets.pointer(), states.pointer());
    let (flag, vertex) = (flags.pointer(), vertices.pointer());
    let trims = seen.scene.trims();
    session.for_all(
        "meshlet_drop",
        count,
        &[&count, &trims, &patches, &descriptions, &meshlets, &states, &flag, &vertex],
    )?;
    let (slots, looked_at) = scan(session, &flags, count)?;
    let (firsts, evaluated) = scan(session, &vertices, count)?;
    let looked_at = session.count_of(looked_at, "meshlets to look at")?;
    let evaluated = session.count_of(evaluated, "vertices of meshlets to look at")?;
    let looked_at = session.both(looked_at, evaluated)?;
    let list = session.list::<abi::Meshlet>(looked_at)?;
    let numbers = session.allocate::<u32>(looked_at.room())?;
    let (slots, firsts) = (slots.pointer(), firsts.pointer());
    session.for_all(
        "meshlet_look",
        count,
        &[&count, &meshlets, &states, &slots, &firsts, &looked_at, &list.pointer(), &numbers.pointer()],
    )?;
    let looked = evaluated_vertices(session, seen, leaves, list, evaluated)?;
    let (list, numbers, looked) = (list.pointer(), numbers.pointer(), looked.pointer());
    let counts = from.counts.pointer();
    if looked_at.room() > 0 {
        session.launch(
            "meshlet_region",
            Shape::row(looked_at.room().div_ceil(REGION_WARPS as usize) as u32, REGION_WARPS * 32),
            &[&looked_at, &trims, &patches, &descriptions, &list, &numbers, &looked, &meshlets, &states, &counts],
        )?;
    }
    session.for_all("meshlet_keep", count, &[&count, &patches, &meshlets, &states, &flag, &vertex])?;
    compact(session, from, states, &flags, &vertices)
}

/// Those that are kept.
fn compact<G: Gpu>(
    session: &mut Session<G>,
    from: Meshlets,
    states: Pointer<u8>,
    flags: &Buffer<u32>,
    vertices: &Buffer<u32>,
) -> Result<Meshlets, GpuError> {
    let count = from.all;
    let (slots, kept) = scan(session, flags, count)?;
    let (firsts, all_vertices) = scan(session, vertices, count)?;
    let kept = session.count_of(kept, "meshlets")?;
    let vertices = session.count_of(all_vertices, "vertices")?;
    let kept = session.both(kept, vertices)?;
    let list = session.list_as(Role::Meshlets, kept)?;
    let (meshlets, slots, firsts) = (from.meshlets.pointer(), slots.pointer(), firsts.pointer());
    session.for_all(
        "meshlet_compact",
        count,
        &[&count, &meshlets, &states, &slots, &firsts, &kept, &list.pointer()],
    )?;
    Ok(Meshlets { meshlets: list, vertices, ..from })
}

/// The vertices of blocks that are looked at: their triangles say how far fragments' parameters may be off.
fn evaluated_vertices<G: Gpu>(
    session: &mut Session<G>,
    seen: &Seen,
    leaves: &Leaves,
    list: List<abi::Meshlet>,
    vertices: Count,
) -> Result<Buffer<abi::Vertex>, GpuError> {
    let vertices = session.allocate(vertices.room())?;
    // As they will be drawn.
    if seen.rules.precision != Arithmetic::F32 as u32 {
        evaluate(session, &leaves.geometry(&seen.view, list), &vertices)?;
        return Ok(vertices);
    }
    let (patches, nets, basis) = (leaves.patches.pointer(), leaves.nets.pointer(), leaves.basis.pointer());
    let blocks = list.room().div_ceil(WARPS as usize) as u32;
    if blocks > 0 {
        let (meshlets, out) = (list.pointer(), vertices.pointer());
        session.launch(
            "evaluate_f32",
            Shape::row(blocks, WARPS * 32),
            &[&seen.view, &patches, &meshlets, &nets, &basis, &out, &list.count],
        )?;
    }
    Ok(vertices)
}
