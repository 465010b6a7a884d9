//! Random nets for the kernels that evaluate meshlets, and what an evaluation in f64 says of them.

use crate::support::Random;
use halfpixel::cuda::Count;
use halfpixel::cuda::abi::{Meshlet, Patch, Point, SUBPIXELS, Vertex, View};
use halfpixel::cuda::precision::Hull;
use halfpixel::emulated::{Device, Shape};

/// Camera depth that nets are centred on.
pub const DEPTH: f64 = 10.0;
/// What is nearest in perspective.
const NEAR: f64 = 5.0;
/// Meshlets' vertices lie this far apart: no kernel may write between them.
const GAP: usize = 3;

/// What all patches of a scene are like.
#[derive(Clone, Copy, Debug)]
pub struct Kind {
    /// Weights from 0.3 to 3, else 1.
    pub rational: bool,
    /// Pixels across.
    pub width: f64,
    pub perspective: bool,
}

/// A patch and what it is drawn in: a meshlet's first quad and number of quads.
pub struct Surface<'a> {
    pub degree: [usize; 2],
    /// (X, Y, Z, w) about the patch's centre, in pixels times denominator.
    pub net: &'a [[f64; 4]],
    pub quads: [usize; 2],
    pub meshlets: &'a [([usize; 2], [usize; 2])],
}

impl Kind {
    pub const ALL: [Self; 8] = {
        let mut all = [Self { rational: false, width: 30.0, perspective: false }; 8];
        let mut k = 0;
        while k < 8 {
            all[k] =
                Self { rational: k & 1 != 0, width: if k & 2 != 0 { 1000.0 } else { 30.0 }, perspective: k & 4 != 0 };
            k += 1;
        }
        all
    };
}

/// What a vertex should be.
#[derive(Clone, Copy)]
struct Exact {
    patch: usize,
    /// Pixels about the patch's centre.
    place: [f64; 2],
    depth: f64,
    weight: f64,
    /// Pixels that the patch is wide or high.
    extent: f64,
    centre: [i32; 2],
}

/// Largest errors over a scene.
#[derive(Clone, Copy, Debug, Default)]
pub struct Errors {
    pub px: f64,
    /// Over the extent of the patch on the screen.
    pub of_extent: f64,
    /// Relative in perspective.
    pub depth: f64,
    /// Relative.
    pub weight: f64,
}

impl Errors {
    /// No more than so many times as large.
    pub fn within(self, factor: f64, other: Self) -> bool {
        let parts = |e: Self| [e.of_extent, e.depth, e.weight];
        parts(self).iter().zip(parts(other)).all(|(mine, its)| *mine <= factor * its)
    }

    pub fn max(self, other: Self) -> Self {
        let [px, of_extent] = [self.px.max(other.px), self.of_extent.max(other.of_extent)];
        let [depth, weight] = [self.depth.max(other.depth), self.weight.max(other.weight)];
        Self { px, of_extent, depth, weight }
    }
}

/// The arguments of a launch.
pub struct Scene {
    kind: Kind,
    /// x and y are so many times as large as the test says, so that snapping to sub-pixels does not hide what it measures. A
    /// power of two: it changes no significand.
    magnified: f64,
    pub view: View,
    pub patches: Vec<Patch>,
    pub meshlets: Vec<Meshlet>,
    pub nets: Vec<Point>,
    basis: Vec<f32>,
    /// By number of the vertex; `None`: a gap.
    exact: Vec<Option<Exact>>,
    random: Random,
}

impl Scene {
    pub fn new(kind: Kind) -> Self {
        let view = View {
            near_f32: NEAR as f32,
            depth_slope: 1.0 / 32.0,
            perspective: u32::from(kind.perspective),
            projective: u32::from(kind.rational),
            ..View::default()
        };
        let (patches, meshlets, nets, basis) = (Vec::new(), Vec::new(), Vec::new(), Vec::new());
        // As large as 32 bits hold.
        let magnified = 2.0_f64.powi(21 - kind.width.log2().ceil() as i32);
        Self { kind, magnified, view, patches, meshlets, nets, basis, exact: Vec::new(), random: Random(2026) }
    }

    /// Pixels that snapping may be off by.
    pub fn snapping(&self) -> f64 {
        0.5 / f64::from(SUBPIXELS) / self.magnified
    }

    /// Of one patch, and the pixels that one of its own stands for.
    pub fn hull(&self, patch: usize) -> (Hull, f64) {
        let net = &self.nets[self.patches[patch].net as usize..];
        let points = self.patches[patch].degree.iter().map(|&d| usize::from(d) + 1).product();
        (Hull::new(&self.view, &self.patches[patch], &net[..points]), 1.0 / self.magnified)
    }

    /// A patch of each pair of degrees from 1 to 7, in two meshlets of 8 x 8 vertices.
    pub fn of_all_degrees(kind: Kind) -> Self {
        let mut scene = Self::new(kind);
        for degree in (0..49).map(|k| [1 + k / 7, 1 + k % 7]) {
            scene.push(degree, [14, 7], &[([0, 0], [7, 7]), ([7, 0], [7, 7])]);
        }
        scene
    }

    /// Adds a patch of a random net and meshlets of it: first quad, number of quads.
    pub fn push(&mut self, degree: [usize; 2], quads: [usize; 2], meshlets: &[([usize; 2], [usize; 2])]) {
        let net = self.random_net(degree);
        self.push_net(&Surface { degree, net: &net, quads, meshlets });
    }

    pub fn push_net(&mut self, surface: &Surface) {
        let Surface { degree, quads, .. } = *surface;
        let magnified = |&[x, y, z, w]: &[f64; 4]| [x * self.magnified, y * self.magnified, z, w];
        let net: Vec<[f64; 4]> = surface.net.iter().map(magnified).collect();
        let lines = |k: usize| (0..=quads[k]).map(move |q| bernstein(degree[k], q as f64 / quads[k] as f64));
        let [lines_u, lines_v] = [0, 1].map(|k| lines(k).collect::<Vec<_>>());
        let centre = [300 + 7 * degree[0] as i32, -40];
        self.patches.push(Patch {
            net: self.nets.len() as u32,
            basis: [self.basis.len() as u32, (self.basis.len() + lines_u.len() * (degree[0] + 1)) as u32],
            quads: quads.map(|q| q as u16),
            degree: degree.map(|d| d as u8),
            base: centre.map(|c| c * SUBPIXELS),
            depth_origin: DEPTH as f32,
            depth_offset: 0.5,
            ..Patch::default()
        });
        self.nets.extend(net.iter().map(|p| {
            let [x, y, z, w] = p.map(|c| c as f32);
            Point { x, y, z, w }
        }));
        self.basis.extend(lines_u.iter().chain(&lines_v).flatten().map(|&b| b as f32));
        let patch = self.patches.len() - 1;
        let extent = self.extent(&net);
        for &(first, size) in surface.meshlets {
            self.meshlets.push(Meshlet {
                patch: patch as u32,
                vertices: self.exact.len() as u32,
                first: first.map(|f| f as u16),
                quads: size.map(|s| s as u8),
                ..Meshlet::default()
            });
            for u in &lines_u[first[0]..=first[0] + size[0]] {
                for v in &lines_v[first[1]..=first[1] + size[1]] {
                    let [x, y, depth, weight] = self.project(sum(&net, u, v));
                    self.exact.push(Some(Exact { patch, place: [x, y], depth, weight, extent, centre }));
                }
            }
            self.exact.extend([None; GAP]);
        }
    }

    /// Runs a kernel. What it leaves alone is -1 in every bit.
    pub fn evaluate(&self, device: &mut Device, kernel: &str) -> Vec<Vertex> {
        let (patches, meshlets) = (device.upload(&self.patches), device.upload(&self.meshlets));
        let (nets, basis) = (device.upload(&self.nets), device.upload(&self.basis));
        let vertices = device.allocate::<Vertex>(self.exact.len());
        let count = self.meshlets.len() as u32;
        let arguments = [
            &self.view as _,
            &patches.pointer() as _,
            &meshlets.pointer() as _,
            &nets.pointer() as _,
            &basis.pointer() as _,
            &vertices.pointer() as _,
            &Count::known(count) as _,
        ];
        device.launch(kernel, Shape::row(count.div_ceil(4), 128), &arguments).expect("a launch");
        device.download(&vertices).expect("vertices")
    }

    /// Compares with f64; a vertex that is missing or one that should not be there fails.
    pub fn errors(&self, vertices: &[Vertex]) -> Errors {
        self.errors_by_patch(vertices).into_iter().fold(Errors::default(), Errors::max)
    }

    pub fn errors_by_patch(&self, vertices: &[Vertex]) -> Vec<Errors> {
        let mut errors = vec![Errors::default(); self.patches.len()];
        for (k, (vertex, exact)) in vertices.iter().zip(&self.exact).enumerate() {
            let Some(exact) = exact else {
                assert!(vertex.depth.is_nan() && vertex.x == -1, "vertex {k} is between meshlets");
                continue;
            };
            let off = |k: usize| {
                let found = f64::from([vertex.x, vertex.y][k] - exact.centre[k] * SUBPIXELS) / f64::from(SUBPIXELS);
                (found / self.magnified - exact.place[k]).abs()
            };
            let px = off(0).max(off(1));
            let scale = if self.kind.perspective { exact.depth } else { 1.0 };
            let depth = (f64::from(vertex.depth) - exact.depth).abs() / scale;
            assert!(depth.is_finite(), "vertex {k} was not written");
            let weight = (f64::from(vertex.weight) / exact.weight - 1.0).abs();
            let of_patch = &mut errors[exact.patch];
            *of_patch = of_patch.max(Errors { px, of_extent: px / exact.extent, depth, weight });
        }
        errors
    }

    fn random_net(&mut self, [m, n]: [usize; 2]) -> Vec<[f64; 4]> {
        let Kind { rational, width, perspective } = self.kind;
        let mut unit = || self.random.unit();
        let mut net = Vec::new();
        for (i, j) in (0..=m).flat_map(|i| (0..=n).map(move |j| (i, j))) {
            let mut along = |k: usize, degree: usize| width * ((k as f64 + 0.4 * unit()) / degree as f64 - 0.5);
            let [x, y] = [along(i, m), along(j, n)];
            let z = 0.2 * DEPTH * unit();
            // Below 1 as often as above.
            let weight = [0.3 + 0.7 * unit().abs(), 1.0 + 2.0 * unit().abs()][usize::from(unit() > 0.0)];
            let w = if rational { weight } else { 1.0 };
            let scale = if perspective { DEPTH + z } else { 1.0 };
            net.push([x * scale * w, y * scale * w, z * w, w]);
        }
        net
    }

    /// Pixels, stored depth and weight of a point of a net. Rational ones are interpolated projectively.
    fn project(&self, [x, y, z, w]: [f64; 4]) -> [f64; 4] {
        let Kind { rational, perspective, .. } = self.kind;
        let denominator = if perspective { z + DEPTH * w } else { w };
        let depth = if perspective { NEAR * w / denominator } else { 0.5 - z / w / 32.0 };
        let weight = match (rational, perspective) {
            (true, _) => 1.0 / denominator,
            (false, true) => depth,
            (false, false) => 1.0,
        };
        [x / denominator / self.magnified, y / denominator / self.magnified, depth, weight]
    }

    /// The larger side of the box about the projected control points.
    fn extent(&self, net: &[[f64; 4]]) -> f64 {
        let side = |k: usize| {
            let places = net.iter().map(|&p| self.project(p)[k]);
            let (low, high) = places.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), x| (l.min(x), h.max(x)));
            high - low
        };
        side(0).max(side(1))
    }
}

pub fn sum(net: &[[f64; 4]], u: &[f64], v: &[f64]) -> [f64; 4] {
    let mut sum = [0.0; 4];
    for (i, bu) in u.iter().enumerate() {
        for (j, bv) in v.iter().enumerate() {
            let point = net[i * v.len() + j];
            (0..4).for_each(|c| sum[c] += point[c] * bu * bv);
        }
    }
    sum
}

/// All Bernstein polynomials of a degree at t.
pub fn bernstein(degree: usize, t: f64) -> Vec<f64> {
    let mut binomial = 1.0;
    let mut values = Vec::new();
    for i in 0..=degree {
        values.push(binomial * t.powi(i as i32) * (1.0 - t).powi((degree - i) as i32));
        binomial = binomial * (degree - i) as f64 / (i + 1) as f64;
    }
    values
}
