//! The numbering inside a meshlet: its triangles and outer edges, in the low 7 bits of a visibility word.

use super::evaluate::Meshlet;
use crate::cuda::abi;

/// Bits of a visibility word's index; the meshlet number starts above.
pub(super) const INDEX_BITS: u32 = abi::INDEX_BITS;
pub(super) const INDEX_MASK: u32 = (1 << INDEX_BITS) - 1;
/// Meshlets that fit beside 7 bits of index in 32.
pub(super) const MAX_MESHLETS: u64 = 1 << (32 - INDEX_BITS);
/// 7 x 7 quads have 98 triangles; the outer edges follow: 7 on each of four sides.
const FIRST_EDGE: u32 = abi::FIRST_EDGE;
const EDGES_A_SIDE: u32 = abi::EDGES_A_SIDE;

/// A stroke along a fold of the grid: it proposes a pixel to settle.rs and never stays.
pub(super) const FOLD: u32 = abi::FOLD_INDEX;

/// What a visibility word's index names.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Primitive {
    /// Three vertices as (i, j) in the meshlet's grid.
    Triangle([[usize; 2]; 3]),
    /// An outer edge a-b and the third vertex of its triangle.
    Edge([[usize; 2]; 3]),
}

/// Visibility word of a fragment: depth bits, meshlet, index. The larger wins.
pub(super) fn word(depth: f32, meshlet: u32, index: u32) -> u64 {
    u64::from(depth.to_bits()) << 32 | u64::from(meshlet << INDEX_BITS | index)
}

/// The same word at another depth.
pub(super) fn with_depth(word: u64, depth: f32) -> u64 {
    u64::from(depth.to_bits()) << 32 | u64::from(word as u32)
}

pub(super) fn depth_of(word: u64) -> f32 {
    f32::from_bits((word >> 32) as u32)
}

pub(super) fn meshlet_of(word: u64) -> u32 {
    word as u32 >> INDEX_BITS
}

pub(super) fn index_of(word: u64) -> u32 {
    word as u32 & INDEX_MASK
}

/// True for words that a stroke wrote.
pub(super) fn is_edge(word: u64) -> bool {
    index_of(word) >= FIRST_EDGE
}

/// The two triangles of quad (a, b).
pub(super) fn triangles(a: usize, b: usize, diagonal: u8) -> [[[usize; 2]; 3]; 2] {
    let (p, q, r, s) = ([a, b], [a + 1, b], [a + 1, b + 1], [a, b + 1]);
    if diagonal == 0 { [[p, q, r], [p, r, s]] } else { [[p, q, s], [q, r, s]] }
}

/// Index of the first triangle of quad (a, b); the second follows.
pub(super) fn triangle_index(meshlet: &Meshlet, a: usize, b: usize) -> u32 {
    2 * (a as u32 * u32::from(meshlet.quads[1]) + b as u32)
}

/// Index of the k-th outer edge of a side (0: u=0, 1: u=1, 2: v=0, 3: v=1).
pub(super) fn edge_index(side: usize, k: usize) -> u32 {
    FIRST_EDGE + side as u32 * EDGES_A_SIDE + k as u32
}

/// Edge k of a side with the third vertex of the triangle behind it.
pub(super) fn edge(meshlet: &Meshlet, side: usize, k: usize) -> [[usize; 2]; 3] {
    let (a, b) = match side {
        0 => (0, k),
        1 => (meshlet.quads[0] as usize - 1, k),
        2 => (k, 0),
        _ => (k, meshlet.quads[1] as usize - 1),
    };
    let (p, q, r, s) = ([a, b], [a + 1, b], [a + 1, b + 1], [a, b + 1]);
    let main = meshlet.diagonal == 0;
    match side {
        0 => [p, s, if main { r } else { q }],
        1 => [q, r, if main { p } else { s }],
        2 => [p, q, if main { r } else { s }],
        _ => [s, r, if main { p } else { q }],
    }
}

/// Decodes an index.
pub(super) fn primitive(meshlet: &Meshlet, index: u32) -> Primitive {
    if index >= FIRST_EDGE {
        let k = index - FIRST_EDGE;
        return Primitive::Edge(edge(meshlet, (k / EDGES_A_SIDE) as usize, (k % EDGES_A_SIDE) as usize));
    }
    // Divisions of bytes are the cheapest.
    let (quad, across) = ((index / 2) as u8, meshlet.quads[1]);
    let [a, b] = [quad / across, quad % across].map(usize::from);
    Primitive::Triangle(triangles(a, b, meshlet.diagonal)[index as usize % 2])
}
