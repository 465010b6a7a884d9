//! Part of trim: a leaf in the plane of its face's loops, and whether a surface point belongs to the face.

use super::cull::Leaf;
use super::estimate::Tessellation;
use super::evaluate::{Meshlet, SUBPIXELS, Vertex};
use super::lens::Lens;
use super::newton::{Batch, LANES, Surface};
use super::shade::Shader;
use super::topology::triangles;
use super::{Options, Trim};
use crate::scene::{ParameterBox, Region, Scene, TrimTree};

/// Pixels that a face reaches over its own gap at most, so that two faces close one of a pixel; larger ones are shown.
pub(super) const MAX_GAP: f64 = 0.5;
/// Pixels that refinement leaves (1/512), and the rounding of f32 parameters on top of `Leaf::rounding`.
const REFINED: f64 = 1.0 / 512.0 + 1.0 / 1024.0;
/// The surface's parameters change up to this many times as fast as its triangle's.
const BENT: f64 = 2.0;

/// A leaf in the plane of its face's trims.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cut<'a> {
    pub tree: TrimTree<'a>,
    /// Leaf parameters (0, 0) in the plane, and what one is there.
    origin: [f64; 2],
    size: [f64; 2],
    /// Pixels a unit of length at most, anywhere on the leaf.
    pixels_per_unit: f64,
    /// Pixels that a refined point may be off by.
    rounding: f64,
}

impl<'a> Cut<'a> {
    /// `None` where no loop cuts the leaf's patch, or trims are off.
    pub fn new(scene: &'a Scene, lens: &Lens, options: &Options, leaf: &Leaf) -> Option<Self> {
        let patch = &scene.patches[leaf.patch as usize];
        let tree = scene.trim_tree(patch).filter(|_| options.trim != Trim::Off)?;
        let size = [0, 1].map(|k| (patch.domain[k][1] - patch.domain[k][0]) * leaf.extent[k]);
        Some(Self {
            tree,
            origin: patch.to_plane(leaf.corner),
            size,
            pixels_per_unit: pixels_per_unit(scene, lens, leaf),
            rounding: REFINED + leaf.rounding,
        })
    }

    pub fn to_plane(self, s: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| self.origin[k] + self.size[k] * s[k])
    }

    pub fn leaf_point(self, p: [f64; 2]) -> [f64; 2] {
        [0, 1].map(|k| (p[k] - self.origin[k]) / self.size[k])
    }

    /// Pixels within which a curve with this gap keeps points outside.
    fn margin(&self, gap: f64) -> f64 {
        (gap * self.pixels_per_unit).min(MAX_GAP) + self.rounding
    }

    /// A box of leaf parameters in the plane.
    pub fn plane_box(&self, low: [f64; 2], high: [f64; 2]) -> ParameterBox {
        ParameterBox::around([self.to_plane(low), self.to_plane(high)])
    }

    /// Where a box of leaf parameters lies.
    pub fn classify(&self, low: [f64; 2], high: [f64; 2]) -> Region {
        self.tree.classify(&self.plane_box(low, high))
    }

    /// Pixels on its triangle that a fragment may be off by, at a curve with this gap, where its grid is off by `deviation`.
    pub fn reach(&self, deviation: f32, gap: f64) -> f64 {
        (f64::from(deviation) + self.margin(gap)) * BENT
    }

    /// Quads that the parameters of a triangle's fragments may be off by where its grid is off by `deviation` pixels.
    pub fn spread(&self, corners: [[usize; 2]; 3], vertices: &[Vertex; 3], deviation: f32) -> [f64; 2] {
        let reach = self.reach(deviation, self.tree.gap()) * f64::from(SUBPIXELS);
        quads_per_subpixel(corners, vertices).map(|e| e * reach)
    }
}

/// Pixels that a unit of length covers at most, anywhere on a leaf.
pub(crate) fn pixels_per_unit(scene: &Scene, lens: &Lens, leaf: &Leaf) -> f64 {
    let map = lens.patch_map(&scene.instances[leaf.instance as usize], scene.patches[leaf.patch as usize].origin);
    let [x, y, z] = map.axes.map(|axis| axis.length());
    let across = x.max(y) * lens.scale;
    if !lens.perspective {
        return across;
    }
    let aside = [leaf.low.x, leaf.low.y, leaf.high.x, leaf.high.y].map(f64::abs).into_iter().fold(0.0, f64::max);
    (across + aside * z) / leaf.low.z
}

/// The model's gaps about a leaf in pixels, as far as they are closed: along its patch's borders, and of all its curves.
pub(crate) fn gaps(scene: &Scene, lens: &Lens, leaf: &Leaf) -> [f64; 2] {
    let patch = &scene.patches[leaf.patch as usize];
    let border = patch.trim.gap;
    let all = scene.trim_tree(patch).map_or(0.0, |tree| tree.gap()).max(border);
    if all == 0.0 {
        return [0.0; 2];
    }
    let scale = pixels_per_unit(scene, lens, leaf);
    [border, all].map(|gap| (gap * scale).min(MAX_GAP))
}

/// How fast the parameters change across a triangle, along both screen axes together: quads a sub-pixel in u and in v.
/// `corners` are places in the meshlet's grid.
fn quads_per_subpixel(corners: [[usize; 2]; 3], [a, b, c]: &[Vertex; 3]) -> [f64; 2] {
    let side = |to: &Vertex| [f64::from(to.x) - f64::from(a.x), f64::from(to.y) - f64::from(a.y)];
    let ([ux, uy], [vx, vy]) = (side(b), side(c));
    let weights = [a.weight, b.weight, c.weight].map(f64::from);
    // Perspective-correct: the gradient grows by the weights' ratio, squared at most.
    let ratio = weights.into_iter().fold(0.0, f64::max) / weights.into_iter().fold(f64::INFINITY, f64::min);
    let inverse = ratio * ratio / (ux * vy - uy * vx).abs();
    [0, 1].map(|k| {
        let [first, second] = [1, 2].map(|n| corners[n][k] as f64 - corners[0][k] as f64);
        ((first * vy - second * uy).abs() + (second * ux - first * vx).abs()) * inverse
    })
}

/// Where a meshlet lies, its fragments' errors included.
pub(super) fn region(cut: &Cut, grid: &Tessellation, meshlet: &Meshlet, vertices: &[Vertex]) -> Region {
    let quads = grid.quads;
    let mut spread = [0.0f64; 2];
    let across = usize::from(meshlet.quads[1]) + 1;
    for a in 0..usize::from(meshlet.quads[0]) {
        for b in 0..usize::from(meshlet.quads[1]) {
            for corners in triangles(a, b, meshlet.diagonal) {
                let here = cut.spread(corners, &corners.map(|[i, j]| vertices[i * across + j]), grid.deviation[0]);
                // Triangles that are edge-on have no fragments.
                if here.iter().all(|s| s.is_finite()) {
                    spread = [0, 1].map(|k| spread[k].max(here[k]));
                }
            }
        }
    }
    let first = meshlet.first.map(f64::from);
    let low = [0, 1].map(|k| (first[k] - spread[k]) / f64::from(quads[k]));
    let high = [0, 1].map(|k| (first[k] + f64::from(meshlet.quads[k]) + spread[k]) / f64::from(quads[k]));
    cut.classify(low, high)
}

/// A refined point is inside the loops, or on the screen within a curve's gap and rounding of one.
pub(super) fn keeps(shader: &Shader, leaf: u32, cut: &Cut, surface: &Surface, batch: &Batch, lane: usize) -> bool {
    let s = [batch.s[lane], batch.t[lane]].map(f64::from);
    if let Some(texture) = shader.texture(leaf) {
        return texture.contains(s);
    }
    let p = cut.to_plane(s);
    if cut.tree.contains(p) {
        return true;
    }
    if shader.options.refine == 0 {
        return false;
    }
    // By the plane's parameters: x and y in pixels, depth in units.
    let by = |derivative: &[[f32; LANES]; 3], axis: usize| {
        [0, 1, 2].map(|c| f64::from(derivative[c][lane]) / cut.size[axis])
    };
    let (du, dv) = (by(&batch.ds, 0), by(&batch.dt, 1));
    let tolerance = f64::from(surface.depth_tolerance);
    let half = |gap: f64| {
        let margin = cut.margin(gap);
        [margin, margin, tolerance * (1.0 + margin)]
    };
    let image = |q: [f64; 2]| {
        let d = [q[0] - p[0], q[1] - p[1]];
        [0, 1, 2].map(|c| du[c] * d[0] + dv[c] * d[1])
    };
    let reach = preimage(&du, &dv, half(cut.tree.gap()));
    let within = ParameterBox { low: p, high: p }.grown(reach);
    cut.tree.comes_near(&within, &image, half)
}

/// Half sizes of a box that holds all (u, v) with `|du u + dv v| <= half` in each component.
fn preimage(du: &[f64; 3], dv: &[f64; 3], half: [f64; 3]) -> [f64; 2] {
    let mut reach = [f64::INFINITY; 2];
    for (i, j) in [(0, 1), (0, 2), (1, 2)] {
        let det = (du[i] * dv[j] - dv[i] * du[j]).abs();
        let u = (dv[j].abs() * half[i] + dv[i].abs() * half[j]) / det;
        let v = (du[j].abs() * half[i] + du[i].abs() * half[j]) / det;
        // Not where the determinant is zero.
        if u.is_finite() && v.is_finite() {
            reach = [reach[0].min(u), reach[1].min(v)];
        }
    }
    reach
}
