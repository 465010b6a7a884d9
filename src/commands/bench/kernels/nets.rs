//! Patches made up for kernels of evaluate, and what an evaluation in f64 says of them.

use crate::cuda::abi;
use crate::cuda::precision::Hull;
use crate::cuda::surfaces::Surfaces;
use crate::stages::basis::bernstein;
use rayon::prelude::*;

/// Quads along each side: with those that meshlets share, 64 x 64 vertices are stored.
pub const QUADS: u16 = 56;
/// Vertices of a patch's meshlets.
pub const VERTICES: usize = 64 * 64;
pub const MESHLETS: usize = 64;
/// Camera depth that nets are centred on, and the nearest one, in perspective.
const DEPTH: f64 = 10.0;
const NEAR: f64 = 5.0;

/// What all patches of a set are like.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Kind {
    pub degree: u8,
    /// Weights are from 1 / this to this.
    pub weights: f64,
    /// Pixels across.
    pub width: f64,
    /// Widths that the patch lies off the origin.
    pub offset: f64,
    /// The offset is taken off in f64 before numbers are rounded, as a scene does.
    pub centred: bool,
    pub perspective: bool,
}

impl Default for Kind {
    fn default() -> Self {
        Self { degree: 3, weights: 1.0, width: 1000.0, offset: 0.0, centred: true, perspective: false }
    }
}

/// Patches of one kind, as kernels get them.
pub struct Nets {
    pub kind: Kind,
    pub view: abi::View,
    pub surfaces: Surfaces,
    /// Pixels are so many times as large as the kind says, so that snapping does not hide errors. A power of two.
    magnified: f64,
    /// The same nets before they were rounded, about where the kernels' origin is.
    exact: Vec<Vec<[f64; 4]>>,
}

/// A point where it belongs: pixels and, in perspective, camera depth.
pub type Point = [f64; 3];

impl Nets {
    pub fn new(kind: Kind, count: usize) -> Self {
        let extent = if kind.centred { kind.width } else { kind.width * (1.0 + kind.offset) };
        // As large as sub-pixels in 32 bits can be.
        let magnified = 2.0_f64.powi(21 - extent.log2().ceil() as i32);
        let exact: Vec<_> = (0..count).into_par_iter().map(|k| net(&kind, magnified, k as u64)).collect();
        let mut surfaces = Surfaces::default();
        for net in &exact {
            let point = |p: &[f64; 4]| {
                let [x, y, z, w] = p.map(|c| c as f32);
                abi::Point { x, y, z, w }
            };
            let points: Vec<abi::Point> = net.iter().map(point).collect();
            surfaces.push(&points, [kind.degree; 2], [QUADS; 2]);
        }
        for patch in &mut surfaces.patches {
            (patch.depth_origin, patch.depth_offset) = (DEPTH as f32, 0.5);
        }
        let view = abi::View {
            near_f32: NEAR as f32,
            depth_slope: 1.0 / 32.0,
            perspective: kind.perspective.into(),
            ..abi::View::default()
        };
        Self { kind, view, surfaces, magnified, exact }
    }

    pub fn len(&self) -> usize {
        self.exact.len()
    }

    /// Pixels between what a kernel that projects stored for a vertex and where it belongs.
    pub fn off_in_pixels(&self, found: &abi::Vertex, exact: Point) -> f64 {
        let pixels = f64::from(abi::SUBPIXELS) * self.magnified;
        let off = |found: i32, exact: f64| (f64::from(found) / pixels - exact / self.magnified).abs();
        off(found.x, exact[0]).max(off(found.y, exact[1]))
    }

    /// The same for one that stores positions in space; only without perspective.
    pub fn off_in_space(&self, found: [f32; 3], exact: Point) -> f64 {
        let off = |k: usize| (f64::from(found[k]) - exact[k]).abs() / self.magnified;
        off(0).max(off(1))
    }

    /// Points of a patch's meshlets, in the order in which kernels store them.
    pub fn points(&self, patch: usize) -> Vec<Point> {
        let n = usize::from(self.kind.degree);
        let lines: Vec<Vec<f64>> = (0..=QUADS)
            .map(|line| {
                let mut values = vec![0.0; n + 1];
                bernstein(f64::from(line) / f64::from(QUADS), &mut values);
                values
            })
            .collect();
        let meshlets = &self.surfaces.meshlets[patch * MESHLETS..][..MESHLETS];
        let net = &self.exact[patch];
        let mut points = Vec::with_capacity(VERTICES);
        for m in meshlets {
            for u in m.first[0]..=m.first[0] + u16::from(m.quads[0]) {
                for v in m.first[1]..=m.first[1] + u16::from(m.quads[1]) {
                    points.push(self.project(sum(net, &lines[usize::from(u)], &lines[usize::from(v)])));
                }
            }
        }
        points
    }

    /// Where a patch has the parameters `t`.
    pub fn point(&self, patch: usize, t: [f64; 2]) -> Point {
        let [u, v] = t.map(|t| {
            let mut values = vec![0.0; usize::from(self.kind.degree) + 1];
            bernstein(t, &mut values);
            values
        });
        self.project(sum(&self.exact[patch], &u, &v))
    }

    /// The a-priori bound's view of a patch, and the pixels that one of its own stands for.
    pub fn hull(&self, patch: usize) -> (Hull, f64) {
        let patch = &self.surfaces.patches[patch];
        let points = (usize::from(self.kind.degree) + 1).pow(2);
        (Hull::new(&self.view, patch, &self.surfaces.nets[patch.net as usize..][..points]), 1.0 / self.magnified)
    }

    /// Pixels that snapping to sub-pixels may be off by.
    pub fn snapping(&self) -> f64 {
        0.5 / f64::from(abi::SUBPIXELS) / self.magnified
    }

    fn project(&self, [x, y, z, w]: [f64; 4]) -> Point {
        let denominator = if self.kind.perspective { z + DEPTH * w } else { w };
        [x / denominator, y / denominator, z / w]
    }
}

/// A lattice with bumps, v innermost: (X, Y, Z, w) in pixels times denominator.
fn net(kind: &Kind, magnified: f64, seed: u64) -> Vec<[f64; 4]> {
    let mut random = Random(seed);
    let n = usize::from(kind.degree);
    let far = kind.offset * kind.width;
    let mut net = Vec::with_capacity((n + 1) * (n + 1));
    for (i, j) in (0..=n).flat_map(|i| (0..=n).map(move |j| (i, j))) {
        let mut along = |k: usize| kind.width * ((k as f64 + 0.4 * random.unit()) / n as f64 - 0.5);
        let place = [along(i), along(j)].map(|x| {
            let far_off = x + far;
            magnified * if kind.centred { far_off - far } else { far_off }
        });
        let z = 0.2 * DEPTH * random.unit();
        let w = kind.weights.powf(random.unit());
        let scale = w * if kind.perspective { DEPTH + z } else { 1.0 };
        net.push([place[0] * scale, place[1] * scale, z * w, w]);
    }
    net
}

fn sum(net: &[[f64; 4]], u: &[f64], v: &[f64]) -> [f64; 4] {
    let mut sum = [0.0; 4];
    for (row, bu) in net.chunks_exact(v.len()).zip(u) {
        for (point, bv) in row.iter().zip(v) {
            (0..4).for_each(|c| sum[c] += point[c] * bu * bv);
        }
    }
    sum
}

/// Numbers without a pattern, the same in every run: Steele, Lea and Flood 2014, SplitMix64.
struct Random(u64);

impl Random {
    /// From -1 to 1.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9e37_79b9_7f4a_7c15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
        (z ^ (z >> 31)) as f64 / u64::MAX as f64 * 2.0 - 1.0
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn patches_are_as_large_as_said() {
        for kind in [Kind::default(), Kind { perspective: true, weights: 1e3, width: 30.0, ..Kind::default() }] {
            let nets = Nets::new(kind, 2);
            let points = nets.points(1);
            assert_eq!((nets.len(), points.len(), nets.surfaces.points), (2, VERTICES, 2 * VERTICES));
            let widest = points.iter().map(|p| p[0].abs().max(p[1].abs()) / nets.magnified).fold(0.0, f64::max);
            assert!((0.3..0.7).contains(&(widest / kind.width)), "{widest}");
        }
    }

    #[test]
    fn patches_far_off_are_the_same_once_centred() {
        let far = Kind { offset: 1e6, ..Kind::default() };
        let (near, far) = (Nets::new(Kind::default(), 1), Nets::new(far, 1));
        let off = near.points(0).into_iter().zip(far.points(0)).map(|(a, b)| (a[0] - b[0]).abs() / near.magnified);
        assert!(off.fold(0.0, f64::max) < 1e-6);
    }
}
