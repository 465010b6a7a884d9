//! Patches cut to what hardware tessellates at once: pieces whose sides have no more quads than its largest level.

use crate::cuda::{abi, pods};

/// Where the outer levels of a patch come from. Inner levels are always those of its grid.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub enum EdgeFactors<'a> {
    /// Its grid.
    #[default]
    Own,
    /// Borders that coincide take the larger number of quads (Yeo 2012, section 4). By patch, the names of its sides u=0, u=1,
    /// v=0, v=1: `Borders::sides`.
    Shared(&'a [[u32; 4]]),
}

/// A rectangle of a patch that is one patch to the hardware: [low, low + size] of `whole`, along both axes. `Piece` of
/// vk_shaders/tessellation.glsl.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
#[repr(C)]
pub struct Piece {
    pub patch: u32,
    /// First of its samples.
    pub(super) samples: u32,
    pub low: [u16; 2],
    pub size: [u16; 2],
    pub whole: [u16; 2],
    /// Quads along u and v.
    pub inner: [u16; 2],
    /// Quads of sides u=0, u=1, v=0, v=1.
    pub outer: [u16; 4],
}

pods!(Piece);

/// Products of a number of quads or pieces and a level are below 2^24: shaders divide them as f32.
const LARGEST_LEVEL: u32 = 256;

impl Piece {
    /// Levels inside as hardware takes them: 1 is 2 where any other level is larger (Vulkan, "Quad Tessellation"). So a strip
    /// of one row of quads gets vertices that no grid has.
    pub fn levels(&self) -> [usize; 2] {
        let any = self.inner.iter().chain(&self.outer).any(|&level| level > 1);
        self.inner.map(|level| usize::from(level).max(if any { 2 } else { 1 }))
    }

    /// Vertices that are not on its borders.
    pub(super) fn inside(&self) -> usize {
        self.levels().map(|level| level - 1).iter().product()
    }

    /// All vertices; corners belong to two sides.
    pub(super) fn stored(&self) -> usize {
        self.inside() + self.outer.iter().map(|&n| usize::from(n) + 1).sum::<usize>()
    }
}

/// All patches in pieces; patches have quads and, for shared factors, sides.
pub(super) fn pieces(patches: &[abi::Patch], factors: EdgeFactors, largest: u32) -> Vec<Piece> {
    let largest = largest.clamp(1, LARGEST_LEVEL);
    match factors {
        EdgeFactors::Own => patches.iter().enumerate().flat_map(|(k, patch)| own(k, patch, largest)).collect(),
        EdgeFactors::Shared(sides) => shared(patches, sides, 1 << largest.ilog2()),
    }
}

/// The fewest pieces, along grid lines, as even as they go.
fn own(number: usize, patch: &abi::Patch, largest: u32) -> impl Iterator<Item = Piece> {
    let [along_u, along_v] = patch.quads.map(|quads| {
        let size = u32::from(quads).div_ceil(u32::from(quads).div_ceil(largest)) as u16;
        (0..quads).step_by(size.into()).map(move |low| (low, size.min(quads - low)))
    });
    let whole = patch.quads;
    along_u.flat_map(move |u| along_v.clone().map(move |v| (u, v))).map(move |((low_u, u), (low_v, v))| Piece {
        patch: number as u32,
        samples: 0,
        low: [low_u, low_v],
        size: [u, v],
        whole,
        inner: [u, v],
        outer: [v, v, u, u],
    })
}

/// A side and the axis that it runs along.
const SIDES: [(usize, usize); 4] = [(0, 1), (1, 1), (2, 0), (3, 0)];

/// What all patches at a border have in common.
#[derive(Clone, Copy, Default)]
struct Border {
    quads: u32,
    /// The most pieces that a patch there is cut into.
    pieces: u32,
}

/// Pieces of equal size, a power of two along each axis: so a border of any number of pieces has the vertices of both sides once
/// its quads are a multiple of the larger number of pieces. `largest` is a power of two.
fn shared(patches: &[abi::Patch], sides: &[[u32; 4]], largest: u32) -> Vec<Piece> {
    let count = sides.iter().flatten().map(|&side| side as usize + 1).max().unwrap_or(0);
    let mut borders = vec![Border::default(); count];
    for (patch, names) in patches.iter().zip(sides) {
        for (side, axis) in SIDES {
            let border = &mut borders[names[side] as usize];
            border.quads = border.quads.max(u32::from(patch.quads[axis]));
        }
    }
    let cuts = |quads: u32| quads.div_ceil(largest).next_power_of_two();
    let mut counts: Vec<[u32; 2]> = patches.iter().map(|p| p.quads.map(|quads| cuts(quads.into()))).collect();
    // A patch has as many pieces as its borders ask for; counts grow to 1024 at most, so this ends.
    let mut grew = true;
    while grew {
        grew = false;
        for (count, names) in counts.iter_mut().zip(sides) {
            for (side, axis) in SIDES {
                let border = &mut borders[names[side] as usize];
                let least = cuts(border.quads).max(cuts(border.pieces));
                grew |= count[axis] < least || border.pieces < count[axis];
                count[axis] = count[axis].max(least);
                border.pieces = border.pieces.max(count[axis]);
            }
        }
    }
    let mut all = Vec::new();
    for (k, ((patch, names), count)) in patches.iter().zip(sides).zip(&counts).enumerate() {
        let level = |side: usize, axis: usize| {
            let border = borders[names[side] as usize];
            (border.quads.next_multiple_of(border.pieces) / count[axis]) as u16
        };
        let inner = [0, 1].map(|axis| u32::from(patch.quads[axis]).div_ceil(count[axis]) as u16);
        for (u, v) in (0..count[0]).flat_map(|u| (0..count[1]).map(move |v| (u, v))) {
            // Cuts inside a patch are its own: both pieces there have its inner level.
            let ends = [u == 0, u + 1 == count[0], v == 0, v + 1 == count[1]];
            let outer = SIDES.map(|(side, axis)| if ends[side] { level(side, axis) } else { inner[axis] });
            all.push(Piece {
                patch: k as u32,
                samples: 0,
                low: [u as u16, v as u16],
                size: [1, 1],
                whole: count.map(|n| n as u16),
                inner,
                outer,
            });
        }
    }
    all
}

#[cfg(test)]
mod tests {
    use super::*;

    fn patch(quads: [u16; 2]) -> abi::Patch {
        abi::Patch { quads, ..abi::Patch::default() }
    }

    /// The places of a side's vertices, in `parts` of it.
    fn places(all: &[Piece], patch: u32, side: usize, parts: u64) -> Vec<u64> {
        let (axis, end) = (SIDES[side].1, side % 2 == 1);
        let across = 1 - axis;
        let at = |p: &&Piece| {
            p.patch == patch && if end { p.low[across] + p.size[across] == p.whole[across] } else { p.low[across] == 0 }
        };
        let mut found = Vec::new();
        for p in all.iter().filter(at) {
            let level = u64::from(p.outer[side]);
            let [low, size, whole] = [p.low, p.size, p.whole].map(|n| u64::from(n[axis]));
            for line in 0..=level {
                let place = parts * (low * level + line * size);
                assert_eq!(place % (whole * level), 0);
                found.push(place / (whole * level));
            }
        }
        found.sort_unstable();
        found.dedup();
        found
    }

    #[test]
    fn own_pieces_cover_the_grid() {
        let all = pieces(&[patch([150, 3]), patch([64, 65])], EdgeFactors::Own, 64);
        let sizes: Vec<_> = all.iter().map(|p| (p.patch, p.low, p.size)).collect();
        let expected = [
            (0, [0, 0], [50, 3]),
            (0, [50, 0], [50, 3]),
            (0, [100, 0], [50, 3]),
            (1, [0, 0], [64, 33]),
            (1, [0, 33], [64, 32]),
        ];
        assert_eq!(sizes, expected);
        assert!(all.iter().all(|p| p.outer == [p.size[1], p.size[1], p.size[0], p.size[0]]));
    }

    #[test]
    fn borders_have_the_larger_factor_on_both_sides() {
        // The first one's u=1 is the second one's u=0, and the second one's u=1 the third one's.
        let patches = [patch([3, 5]), patch([70, 9]), patch([2, 300])];
        let sides = [[0, 1, 2, 3], [1, 4, 5, 6], [4, 7, 8, 9]];
        let all = pieces(&patches, EdgeFactors::Shared(&sides), 64);
        assert!(all.iter().all(|p| p.outer.iter().chain(&p.inner).all(|&level| (1..=64).contains(&level))));
        // The second one is cut into 8 along v, for the third one's sake: 9 quads become 16 on its other side too.
        assert_eq!(places(&all, 0, 1, 16), (0..=16).collect::<Vec<_>>());
        assert_eq!(places(&all, 1, 0, 16), (0..=16).collect::<Vec<_>>());
        let border = places(&all, 1, 1, 304);
        assert_eq!(border, places(&all, 2, 0, 304));
        assert_eq!(border.len(), 305);
    }

    #[test]
    fn a_fine_neighbour_of_a_coarse_patch_cuts_it() {
        let patches = [patch([1, 1]), patch([1, 65_535])];
        let all = pieces(&patches, EdgeFactors::Shared(&[[0, 1, 2, 3], [1, 4, 5, 6]]), 64);
        assert_eq!(all.iter().filter(|p| p.patch == 0).count(), 1024);
        assert!(all.iter().all(|p| p.outer.iter().all(|&level| level <= 64)));
        assert_eq!(places(&all, 0, 1, 65_536).len(), 65_537);
    }

    #[test]
    fn strips_of_one_row_get_another() {
        let [piece] = pieces(&[patch([5, 1])], EdgeFactors::Own, 64)[..] else { panic!("one piece") };
        assert_eq!((piece.levels(), piece.stored()), ([5, 2], 4 + 2 * 2 + 2 * 6));
        let [piece] = pieces(&[patch([1, 1])], EdgeFactors::Own, 64)[..] else { panic!("one piece") };
        assert_eq!((piece.levels(), piece.stored()), ([1, 1], 8));
    }
}
