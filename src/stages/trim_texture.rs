//! `--trim texture`: a parity texture for each leaf that loops cut, sized for the error (Guthe, Balázs & Klein 2005,
//! sections 4 and 5.3); kept for comparison.
//!
//! A texel is no farther from the next than the tolerance on the screen, and set where it is inside or a curve passes it:
//! Guthe's line strip against cracks. Fragments look it up at their interpolated parameters.
//!
//! A texel that no curve passes is inside where an odd number of curves crosses its row's lower side on the way from the left:
//! each crossing is a bit at the texel behind the one it is on, and of bits in a row the parities of all before them are taken,
//! a word at a time. So crossings need no list and no order. Twin: kernels/trim_texture.cu.

use super::cull::Leaf;
use super::interpolate::Shown;
use super::rasterize::{Band, Coverage};
use super::shade::Shader;
use super::trim_cut::Cut;
use super::{Trim, TrimCounts};
use glam::Vec4;
use rayon::prelude::*;

/// Texels a side at most, 8 MiB: what would need more is coarser than the tolerance, and counted.
const LARGEST: f64 = 8192.0;
/// Texels a word.
const WORD: usize = u32::BITS as usize;
/// Rows that are worth a task of their own.
const ROWS: usize = 64;

/// One leaf's texture over its unit square: a bit a texel, rows of constant v in whole words.
#[derive(Clone, Debug)]
pub(super) struct Texture {
    size: [usize; 2],
    /// A row after the other.
    bits: Vec<u32>,
    too_coarse: bool,
}

/// The textures of `--trim texture`, by leaf; none otherwise.
pub(super) fn textures(shader: &Shader) -> Vec<Option<Texture>> {
    let Shader { scene, lens, options, leaves, nets, .. } = *shader;
    if options.trim != Trim::Texture {
        return Vec::new();
    }
    let texture = |leaf: &Leaf| {
        let cut = Cut::new(scene, lens, options, leaf)?;
        let net = &nets[leaf.net as usize..leaf.net as usize + leaf.points()];
        Some(Texture::new(&cut, sizes(leaf, net, lens.perspective, options.tolerance)))
    };
    leaves.par_iter().map(texture).collect()
}

/// What there is to say of them.
pub(super) fn counts(textures: &[Option<Texture>]) -> TrimCounts {
    let textures = || textures.iter().flatten();
    TrimCounts {
        textures_too_coarse: textures().filter(|t| t.too_coarse).count() as u64,
        texture_bytes: textures().map(|t| size_of_val(&t.bits[..]) as u64).sum(),
        ..TrimCounts::default()
    }
}

impl Texture {
    /// With as many texels in u and v as are needed, as far as they may be.
    pub fn new(cut: &Cut, needed: [f64; 2]) -> Self {
        let size = needed.map(|side| side.min(LARGEST) as usize);
        let words = size[0].div_ceil(WORD);
        let mut texture =
            Self { size, bits: vec![0; words * size[1]], too_coarse: needed.iter().any(|&n| n > LARGEST) };
        let rows = texture.bits.par_chunks_mut(words).with_min_len(ROWS);
        rows.enumerate().for_each(|(row, bits)| draw_row(cut, size, row, bits));
        texture
    }

    /// The texel at leaf parameters; beyond the unit square the nearest one.
    pub fn contains(&self, s: [f64; 2]) -> bool {
        let [column, row] = [0, 1].map(|k| ((s[k] * self.size[k] as f64).max(0.0) as usize).min(self.size[k] - 1));
        self.bits[row * self.size[0].div_ceil(WORD) + column / WORD] >> (column % WORD) & 1 == 1
    }

    /// Draws the fragments of a triangle that lie on texels that are set: how many were looked up, and how many were refused.
    pub fn draw(&self, shown: &Shown, coverage: &Coverage, id: u64, band: &mut Band) -> [u64; 2] {
        let first = band.rows[0] as u32;
        let (mut tested, mut rejected) = (0, 0);
        coverage.each(coverage.pixels, id, band, |near, [x, y], fragment| {
            tested += 1;
            if self.contains(shown.at(x, y + first).map(f64::from)) {
                *near = fragment;
            } else {
                rejected += 1;
            }
        });
        [tested, rejected]
    }
}

/// One row of texels.
fn draw_row(cut: &Cut, size: [usize; 2], row: usize, bits: &mut [u32]) {
    let columns = size[0] as f64;
    let [a, b] = [row, row + 1].map(|row| cut.to_plane([0.0, row as f64 / size[1] as f64])[1]);
    let (low, high) = (a.min(b), a.max(b));
    // One more than the texel that u is on, 0 left of them all.
    let behind = |u: f64| index((cut.leaf_point([u, 0.0])[0] * columns).floor() + 1.0, columns + 1.0);
    cut.tree.crossings(low, behind, &mut |column| {
        if column < size[0] {
            bits[column / WORD] ^= 1 << (column % WORD);
        }
    });
    let mut before = 0;
    for word in bits.iter_mut() {
        *word = parities(*word) ^ before;
        before = 0u32.wrapping_sub(*word >> (WORD - 1));
    }
    cut.tree.strips([low, high], behind, &mut |[a, b]| {
        let (first, last) = (a.min(b), a.max(b));
        if first <= size[0] && last > 0 {
            set(bits, first.saturating_sub(1), last.min(size[0]));
        }
    });
}

/// A whole number as an index up to `limit`: 0 for what is less, or none at all.
fn index(number: f64, limit: f64) -> usize {
    if number > 0.0 { number.min(limit) as usize } else { 0 }
}

/// Of each bit the parity of it and all lower ones.
fn parities(mut word: u32) -> u32 {
    for step in [1, 2, 4, 8, 16] {
        word ^= word << step;
    }
    word
}

/// Sets a row's texels from one to before another.
fn set(bits: &mut [u32], from: usize, to: usize) {
    for (k, word) in bits.iter_mut().enumerate().take(to.div_ceil(WORD)).skip(from / WORD) {
        let low = from.saturating_sub(k * WORD);
        let high = (to - k * WORD).min(WORD);
        *word |= (u32::MAX >> (WORD - (high - low))) << low;
    }
}

/// Texels in u and v: the length of the first derivatives over the tolerance, from the projected control points. Where
/// weights differ, a rational curve moves at most `max(w) / min(w)` times as fast as its control polygon says (Floater
/// 1992).
fn sizes(leaf: &Leaf, net: &[Vec4], perspective: bool, tolerance: f64) -> [f64; 2] {
    let [m, n] = leaf.degree;
    let weight = |p: Vec4| f64::from(if perspective { p.z + leaf.depth_origin as f32 * p.w } else { p.w });
    let (least, most) = net.iter().map(|&p| weight(p)).fold((f64::INFINITY, 0.0f64), |(l, h), w| (l.min(w), h.max(w)));
    let place = |i: usize, j: usize| {
        let p = net[i * (n + 1) + j];
        [f64::from(p.x), f64::from(p.y)].map(|c| c / weight(p))
    };
    // Not by hypot, of which each library has its own.
    let distance = |a: [f64; 2], b: [f64; 2]| {
        let [x, y] = [a[0] - b[0], a[1] - b[1]];
        (x * x + y * y).sqrt()
    };
    let (mut u, mut v) = (0.0f64, 0.0f64);
    for i in 0..=m {
        for j in 0..=n {
            if i < m {
                u = u.max(distance(place(i, j), place(i + 1, j)));
            }
            if j < n {
                v = v.max(distance(place(i, j), place(i, j + 1)));
            }
        }
    }
    [(u, m), (v, n)].map(|(length, degree)| (length * degree as f64 * most / least / tolerance).ceil().max(1.0))
}
