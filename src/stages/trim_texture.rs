//! `--trim texture`: a parity texture for each leaf that loops cut, sized for the error (Guthe, Balázs & Klein 2005,
//! sections 4 and 5.3); kept for comparison.
//!
//! A texel is no farther from the next than the tolerance on the screen, and set where its centre is inside or a curve
//! passes it: Guthe's line strip against cracks. Fragments look it up at their interpolated parameters.

use super::cull::Leaf;
use super::trim_cut::Cut;
use glam::Vec4;

/// Texels a side at most, 8 MiB: what would need more is coarser than the tolerance, and counted.
const LARGEST: usize = 8192;

/// One leaf's texture over its unit square: a bit a texel, rows of constant v.
#[derive(Clone, Debug)]
pub(super) struct Texture {
    size: [usize; 2],
    bits: Vec<u64>,
    too_coarse: bool,
}

impl Texture {
    /// For a leaf with its projected net, `tolerance` in pixels.
    pub fn new(cut: &Cut, leaf: &Leaf, net: &[Vec4], perspective: bool, tolerance: f64) -> Self {
        let needed = sizes(leaf, net, perspective, tolerance);
        let size = needed.map(|side| side.min(LARGEST));
        let too_coarse = size != needed;
        let mut texture = Self { size, bits: vec![0; (size[0] * size[1]).div_ceil(64)], too_coarse };
        let texel = |u: f64| (cut.leaf_point([u, 0.0])[0] * size[0] as f64).clamp(0.0, size[0] as f64);
        let mut crossings = Vec::new();
        for row in 0..size[1] {
            let v = |offset: f64| cut.to_plane([0.0, (row as f64 + offset) / size[1] as f64])[1];
            cut.tree.crossings(v(0.5), &mut crossings);
            for pair in crossings.chunks_exact(2) {
                // Texels whose centres lie between the two.
                texture.set(row, (texel(pair[0]) - 0.5).ceil(), (texel(pair[1]) - 0.5).ceil());
            }
            cut.tree.strips([v(0.0), v(1.0)], &mut |a, b| {
                if cut.leaf_point([b, 0.0])[0] >= 0.0 && cut.leaf_point([a, 0.0])[0] < 1.0 {
                    texture.set(row, texel(a).floor(), texel(b).floor() + 1.0);
                }
            });
        }
        texture
    }

    fn set(&mut self, row: usize, from: f64, to: f64) {
        let end = (to.max(0.0) as usize).min(self.size[0]);
        for column in from.max(0.0) as usize..end {
            let index = row * self.size[0] + column;
            self.bits[index / 64] |= 1 << (index % 64);
        }
    }

    /// The texel at leaf parameters in the unit square.
    pub fn contains(&self, s: [f64; 2]) -> bool {
        let [column, row] = [0, 1].map(|k| ((s[k] * self.size[k] as f64).max(0.0) as usize).min(self.size[k] - 1));
        let index = row * self.size[0] + column;
        self.bits[index / 64] >> (index % 64) & 1 == 1
    }

    /// It would need more than 8192 texels a side.
    pub fn is_too_coarse(&self) -> bool {
        self.too_coarse
    }

    pub fn bytes(&self) -> usize {
        size_of_val(&self.bits[..])
    }
}

/// Texels in u and v: the length of the first derivatives over the tolerance, from the projected control points. Where
/// weights differ, a rational curve moves at most `max(w) / min(w)` times as fast as its control polygon says (Floater
/// 1992).
fn sizes(leaf: &Leaf, net: &[Vec4], perspective: bool, tolerance: f64) -> [usize; 2] {
    let [m, n] = leaf.degree;
    let weight = |p: Vec4| f64::from(if perspective { p.z + leaf.depth_origin as f32 * p.w } else { p.w });
    let (least, most) = net.iter().map(|&p| weight(p)).fold((f64::INFINITY, 0.0f64), |(l, h), w| (l.min(w), h.max(w)));
    let place = |i: usize, j: usize| {
        let p = net[i * (n + 1) + j];
        [f64::from(p.x), f64::from(p.y)].map(|c| c / weight(p))
    };
    let distance = |a: [f64; 2], b: [f64; 2]| (a[0] - b[0]).hypot(a[1] - b[1]);
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
    [(u, m), (v, n)].map(|(length, degree)| {
        let texels = length * degree as f64 * most / least / tolerance;
        texels.ceil().max(1.0) as usize
    })
}
