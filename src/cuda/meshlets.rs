//! The list of meshlets, made on the device: second half of `evaluate`'s twin, src/stages/evaluate.rs.

use super::cull::Seen;
use super::estimate::{Leaves, Stopped};
use super::evaluate::{WARPS, evaluate};
use super::gpu::pods;
use super::precision::Arithmetic;
use super::scan::scan;
use super::session::Session;
use super::{Buffer, Gpu, GpuError, Shape, abi};

pods!(abi::MeshletCounts);

/// Vertices of all grids together, as src/stages/estimate.rs has it, and meshlets that a visibility word can name.
const MAX_VERTICES: u64 = 1 << 28;
const MAX_MESHLETS: u64 = 1 << (32 - abi::INDEX_BITS);
/// Warps a block of `meshlet_region`.
const REGION_WARPS: u32 = 4;

/// A frame's meshlets.
pub(crate) struct Meshlets {
    /// In the order of their numbers.
    pub meshlets: Buffer<abi::Meshlet>,
    /// Vertices of all of them.
    pub vertices: u64,
    pub quads: u64,
    /// Of trimmed leaves: those that no curve crosses, and those that were dropped.
    pub inside: u64,
    pub boundary: u64,
    pub outside: u64,
}

/// Cuts all grids into meshlets.
pub(crate) fn meshlets<G: Gpu>(session: &mut Session<G>, seen: &Seen, leaves: &Leaves) -> Result<Meshlets, Stopped> {
    let count = leaves.patches.len();
    let (blocks, vertices) = (session.allocate(count)?, session.allocate(count)?);
    let patches = leaves.patches.pointer();
    session.for_each("meshlet_counts", count, &[&(count as u32), &patches, &blocks.pointer(), &vertices.pointer()])?;
    let (first_blocks, needed) = scan(session, &blocks)?;
    let (first_vertices, vertices) = scan(session, &vertices)?;
    if vertices > MAX_VERTICES {
        return Err(Stopped::Vertices);
    }
    if needed > MAX_MESHLETS {
        return Err(Stopped::Meshlets { needed });
    }
    let meshlets = session.allocate(needed as usize)?;
    session.for_each(
        "meshlet_list",
        count,
        &[&(count as u32), &patches, &first_blocks.pointer(), &first_vertices.pointer(), &meshlets.pointer()],
    )?;
    let counts = session.zeroed::<abi::MeshletCounts>(1)?;
    let mut all = Meshlets { meshlets, vertices, quads: 0, inside: 0, boundary: 0, outside: 0 };
    if seen.view.trim != 0 && seen.scene.trimmed {
        all = trim(session, seen, leaves, all, &counts)?;
    }
    let kept = all.meshlets.len();
    // Whole warps: they sum together.
    session.for_each("meshlet_quads", kept, &[&(kept as u32), &all.meshlets.pointer(), &counts.pointer()])?;
    let counts = session.download(&counts)?[0];
    Ok(Meshlets { quads: counts.quads, inside: counts.inside.into(), boundary: counts.boundary.into(), ..all })
}

/// Drops what lies outside the trims, and marks what curves cross.
fn trim<G: Gpu>(
    session: &mut Session<G>,
    seen: &Seen,
    leaves: &Leaves,
    all: Meshlets,
    counts: &Buffer<abi::MeshletCounts>,
) -> Result<Meshlets, GpuError> {
    let length = all.meshlets.len();
    let count = length as u32;
    let states = session.allocate::<u8>(length)?;
    let (flags, vertices) = (session.allocate::<u32>(length)?, session.allocate::<u32>(length)?);
    let (patches, descriptions) = (leaves.patches.pointer(), leaves.leaves.pointer());
    let (meshlets, states) = (all.meshlets.pointer(), states.pointer());
    let (flag, vertex) = (flags.pointer(), vertices.pointer());
    let trims = seen.scene.trims();
    session.for_each(
        "meshlet_drop",
        length,
        &[&count, &trims, &patches, &descriptions, &meshlets, &states, &flag, &vertex],
    )?;
    let (slots, looked_at) = scan(session, &flags)?;
    let (firsts, evaluated) = scan(session, &vertices)?;
    if looked_at > 0 {
        let list = session.allocate::<abi::Meshlet>(looked_at as usize)?;
        let numbers = session.allocate::<u32>(looked_at as usize)?;
        session.for_each(
            "meshlet_look",
            length,
            &[&count, &meshlets, &states, &slots.pointer(), &firsts.pointer(), &list.pointer(), &numbers.pointer()],
        )?;
        let vertices = evaluated_vertices(session, seen, leaves, &list, evaluated)?;
        let looked_at = looked_at as u32;
        let (list, numbers, vertices) = (list.pointer(), numbers.pointer(), vertices.pointer());
        session.launch(
            "meshlet_region",
            Shape::row(looked_at.div_ceil(REGION_WARPS), REGION_WARPS * 32),
            &[
                &looked_at,
                &trims,
                &patches,
                &descriptions,
                &list,
                &numbers,
                &vertices,
                &meshlets,
                &states,
                &counts.pointer(),
            ],
        )?;
    }
    session.for_each("meshlet_keep", length, &[&count, &patches, &meshlets, &states, &flag, &vertex])?;
    let (slots, kept) = scan(session, &flags)?;
    let (firsts, vertices) = scan(session, &vertices)?;
    let list = session.allocate::<abi::Meshlet>(kept as usize)?;
    session.for_each(
        "meshlet_compact",
        length,
        &[&count, &meshlets, &states, &slots.pointer(), &firsts.pointer(), &list.pointer()],
    )?;
    Ok(Meshlets { meshlets: list, vertices, outside: length as u64 - kept, ..all })
}

/// The vertices of blocks that are looked at: their triangles say how far fragments' parameters may be off.
fn evaluated_vertices<G: Gpu>(
    session: &mut Session<G>,
    seen: &Seen,
    leaves: &Leaves,
    list: &Buffer<abi::Meshlet>,
    vertices: u64,
) -> Result<Buffer<abi::Vertex>, GpuError> {
    let (count, vertices) = (list.len() as u32, session.allocate(vertices as usize)?);
    // As they will be drawn.
    if seen.rules.precision != Arithmetic::F32 as u32 {
        evaluate(session, &leaves.geometry(&seen.view, *list), &vertices)?;
        return Ok(vertices);
    }
    let (patches, nets, basis) = (leaves.patches.pointer(), leaves.nets.pointer(), leaves.basis.pointer());
    session.launch(
        "evaluate_f32",
        Shape::row(count.div_ceil(WARPS), WARPS * 32),
        &[&seen.view, &patches, &list.pointer(), &nets, &basis, &vertices.pointer(), &count],
    )?;
    Ok(vertices)
}
