//! cull: which patches can be seen, split until the later stages can trust them (DESIGN sections 3 and 4).
//!
//! A *leaf* is a patch or a part of one whose control net lies in front of the near plane, spans a depth ratio of at
//! most 3, and is small enough in pixels that f32 arithmetic about its own screen position stays within its budget.

use super::cone::Cone;
use super::lens::{Lens, PatchMap};
use super::{Cull, Options, Precision, RenderError, Trim};
use crate::cuda::abi;
use crate::cuda::evaluate::view;
use crate::cuda::precision::{Arithmetic, Hull};
use crate::cuda::selection::Selection;
use crate::geometry::{BezierPatch, Net};
use crate::scene::{Enclosure, ParameterBox, Patch, Region, Scene, Sides, enclose};
use glam::{DVec3, DVec4, Vec4};

/// Largest depth ratio within a leaf; research "tessellation-bounds" section 4c.
const DEPTH_RATIO: f64 = 3.0;
/// Pixels of rounding that f32 may take out of the tolerance.
pub(super) const ROUNDING_BUDGET: f64 = 1.0 / 256.0;
/// Pixels that f32 parameters may be off by where weights differ; next to nothing else.
const PARAMETER_BUDGET: f64 = 1.0 / 64.0;
/// Strokes reach a quarter of a pixel past a patch; a whole one is kept.
const MARGIN: f64 = 1.0;
/// Halvings of a patch, of both directions together: 2^-50 of either range is all that f64 can tell apart.
const MAX_DEPTH: u32 = 100;
/// Leaves one patch may be split into.
pub(super) const MAX_LEAVES: usize = 1 << 20;

/// A drawn piece of a patch.
#[derive(Clone, Debug)]
pub(crate) struct Leaf {
    pub instance: u32,
    pub patch: u32,
    /// Lower corner of its rectangle in the patch's unit square.
    pub corner: [f64; 2],
    /// Size of that rectangle.
    pub extent: [f64; 2],
    /// The piece's own net and enclosure where the patch was split.
    pub sub: Option<Box<SubPatch>>,
    pub degree: [usize; 2],
    /// Its f32 net in `Leaves::nets`: (X, Y, Z, w) about `center` and `depth_origin`.
    pub net: u32,
    /// Pixel, about the image centre, that the f32 net is centred on.
    pub center: [i32; 2],
    /// Camera depth that the f32 net is centred on.
    pub depth_origin: f64,
    /// Box of the control net: pixels about the image centre (x, y) and camera depth.
    pub low: DVec3,
    pub high: DVec3,
    /// A-priori bound of the rounding in f32 of a point's screen position, in pixels.
    pub rounding: f64,
    /// What its grid is evaluated in; on the CPU always f32.
    pub arithmetic: Arithmetic,
    /// What evaluation takes of the tolerances: pixels, and camera depth in model units beyond what f32 is off by.
    pub evaluation: [f64; 2],
    /// Halvings of its patch.
    pub depth: u32,
    /// Sign of the screen area, in parameter order, of triangles that face away on a solid; 0: both sides can be seen.
    pub hidden: i8,
}

/// The exact part of a split patch.
#[derive(Clone, Debug)]
pub(crate) struct SubPatch {
    pub net: BezierPatch,
    pub enclosure: Enclosure,
}

/// What cull hands on.
#[derive(Clone, Debug, Default)]
pub(crate) struct Leaves {
    pub leaves: Vec<Leaf>,
    pub nets: Vec<Vec4>,
    pub patches_visible: u64,
}

impl Leaf {
    pub fn source<'a>(&'a self, scene: &'a Scene) -> (Net<'a>, &'a Enclosure) {
        match &self.sub {
            Some(sub) => (sub.net.net(), &sub.enclosure),
            None => {
                let patch = &scene.patches[self.patch as usize];
                (scene.net(patch), &patch.enclosure)
            }
        }
    }

    pub fn points(&self) -> usize {
        (self.degree[0] + 1) * (self.degree[1] + 1)
    }

    /// Leaf parameters to the patch's unit square.
    pub fn to_patch(&self, s: [f64; 2]) -> [f64; 2] {
        [self.corner[0] + s[0] * self.extent[0], self.corner[1] + s[1] * self.extent[1]]
    }
}

/// A patch, or a part of one, on its way to being a leaf.
struct Piece {
    net: Option<BezierPatch>,
    corner: [f64; 2],
    extent: [f64; 2],
    depth: u32,
}

enum Verdict {
    Culled,
    Split,
    /// No piece that f64 can tell from its neighbour is small enough.
    TooClose,
    Keep(Box<Leaf>),
}

/// The leaves of one patch, appended in parameter order.
pub(super) struct Culler<'a> {
    pub scene: &'a Scene,
    pub lens: &'a Lens,
    pub options: &'a Options,
    selection: &'a Selection,
    view: abi::View,
    /// The near plane cuts nothing open: solids can only be seen from outside.
    whole: bool,
    scratch: Vec<DVec4>,
}

impl<'a> Culler<'a> {
    pub fn new(scene: &'a Scene, lens: &'a Lens, options: &'a Options, selection: &'a Selection) -> Self {
        let whole = lens.shows_whole(scene.bounds.center(), scene.bounds.radius());
        Self { scene, lens, options, selection, view: view(lens, options), whole, scratch: Vec::new() }
    }

    /// Appends what can be seen of a patch.
    pub fn patch(&mut self, instance: u32, index: u32, out: &mut Leaves) -> Result<(), RenderError> {
        let patch = &self.scene.patches[index as usize];
        let map = self.lens.patch_map(&self.scene.instances[instance as usize], patch.origin);
        if self.is_outside(patch.radius, &map) || self.is_back_patch(patch, &map) {
            return Ok(());
        }
        let before = out.leaves.len();
        let whole = Piece { net: None, corner: [0.0; 2], extent: [1.0; 2], depth: 0 };
        self.pieces(instance, index, &map, whole, out)?;
        out.patches_visible += u64::from(out.leaves.len() > before);
        Ok(())
    }

    /// Splits a leaf once more and culls its halves again: for grids that would not fit.
    pub fn split_leaf(&mut self, leaf: &Leaf, axis: usize, out: &mut Leaves) -> Result<(), RenderError> {
        let patch = &self.scene.patches[leaf.patch as usize];
        let map = self.lens.patch_map(&self.scene.instances[leaf.instance as usize], patch.origin);
        let piece = Piece { net: None, corner: leaf.corner, extent: leaf.extent, depth: leaf.depth };
        let halves = halve(leaf.source(self.scene).0, &piece, axis);
        for half in halves {
            self.pieces(leaf.instance, leaf.patch, &map, half, out)?;
        }
        Ok(())
    }

    fn pieces(
        &mut self,
        instance: u32,
        index: u32,
        map: &PatchMap,
        first: Piece,
        out: &mut Leaves,
    ) -> Result<(), RenderError> {
        let patch = &self.scene.patches[index as usize];
        let limit = out.leaves.len() + MAX_LEAVES;
        let mut stack = vec![first];
        while let Some(piece) = stack.pop() {
            if self.trimmed_away(patch, &piece) {
                continue;
            }
            let net = piece.net.as_ref().map_or(self.scene.net(patch), BezierPatch::net);
            match self.judge(net, map, &piece) {
                Verdict::Culled => {}
                Verdict::TooClose => {
                    return Err(RenderError::TooClose { face: self.face_of(index), patch: index });
                }
                Verdict::Keep(mut leaf) => {
                    if out.leaves.len() >= limit {
                        let face = self.face_of(index);
                        return Err(RenderError::TooManyLeaves { face, patch: index, limit: MAX_LEAVES });
                    }
                    leaf.instance = instance;
                    leaf.patch = index;
                    leaf.hidden = self.hidden_sign(patch, map);
                    leaf.net = out.nets.len() as u32;
                    self.push_net(&leaf, &mut out.nets);
                    if let Some(net) = piece.net {
                        let enclosure = enclose(net.net());
                        leaf.sub = Some(Box::new(SubPatch { net, enclosure }));
                    }
                    out.leaves.push(*leaf);
                }
                Verdict::Split => {
                    let axis = self.longer_axis(net.degree());
                    // The lower half is looked at first: leaves stay in parameter order.
                    let [low, high] = halve(net, &piece, axis);
                    stack.push(high);
                    stack.push(low);
                }
            }
        }
        Ok(())
    }

    /// The loops leave nothing of the piece.
    fn trimmed_away(&self, patch: &Patch, piece: &Piece) -> bool {
        let Some(tree) = self.scene.trim_tree(patch).filter(|_| self.options.trim != Trim::Off) else { return false };
        let high = [0, 1].map(|k| piece.corner[k] + piece.extent[k]);
        let area = ParameterBox::around([patch.to_plane(piece.corner), patch.to_plane(high)]);
        tree.classify(&area) == Region::Outside
    }

    /// The file's number of a patch's face.
    fn face_of(&self, patch: u32) -> u32 {
        self.scene.faces[self.scene.patches[patch as usize].face as usize].id
    }

    /// Projects the net into `scratch` and decides; on `Keep` the net stays in `scratch`.
    fn judge(&mut self, net: Net, map: &PatchMap, piece: &Piece) -> Verdict {
        let lens = self.lens;
        self.scratch.clear();
        self.scratch.extend(net.points().iter().map(|&p| map.apply(p)));
        let (z_min, z_max) = range(self.scratch.iter().map(|p| p.z / p.w));
        // What is not a number is culled.
        if z_max.is_nan() || z_max < lens.near || self.outside() {
            return Verdict::Culled;
        }
        let split = if piece.depth < MAX_DEPTH { Verdict::Split } else { Verdict::TooClose };
        if z_min < lens.near {
            return if self.smaller_than_half_pixel() { Verdict::Culled } else { split };
        }
        if lens.perspective && z_max > DEPTH_RATIO * z_min {
            return split;
        }
        let (x_min, x_max) = range(self.scratch.iter().map(|p| p.x / lens.denominator(*p)));
        let (y_min, y_max) = range(self.scratch.iter().map(|p| p.y / lens.denominator(*p)));
        let center = [(x_min + x_max) * 0.5, (y_min + y_max) * 0.5].map(f64::round);
        let reach = (x_max - center[0]).max(center[0] - x_min).max((y_max - center[1]).max(center[1] - y_min));
        let weights = range(self.scratch.iter().map(|p| lens.denominator(*p)));
        let span = (x_max - x_min).max(y_max - y_min);
        if parameter_rounding(net.degree(), weights, span) > PARAMETER_BUDGET {
            return split;
        }
        let rounding = rounding_bound(net.degree(), reach);
        if rounding.is_nan() || rounding > ROUNDING_BUDGET {
            return split;
        }
        let depth_origin = f64::from(((z_min + z_max) * 0.5) as f32);
        let (mut arithmetic, mut evaluation) = (Arithmetic::F32, [rounding, 0.0]);
        if self.selection.precision != Precision::F32 {
            let relief = (z_max - depth_origin).max(depth_origin - z_min);
            let (degree, range) = (net.degree().map(|d| d as u8), weights.1 / weights.0);
            let hull = Hull::of(&self.view, degree, [reach, range], [z_min, depth_origin, relief]);
            let Some(chosen) = self.selection.choose(&self.view, &hull) else { return split };
            if chosen.arithmetic != Arithmetic::F32 {
                arithmetic = chosen.arithmetic;
                evaluation = [chosen.pixels, chosen.depth * lens.pixel_size(z_max)];
            }
        }
        Verdict::Keep(Box::new(Leaf {
            instance: 0,
            patch: 0,
            corner: piece.corner,
            extent: piece.extent,
            sub: None,
            degree: net.degree(),
            net: 0,
            center: center.map(|c| c as i32),
            depth_origin,
            low: DVec3::new(x_min, y_min, z_min),
            high: DVec3::new(x_max, y_max, z_max),
            rounding,
            arithmetic,
            evaluation,
            depth: piece.depth,
            hidden: 0,
        }))
    }

    /// A ball about a patch's origin lies beyond one side of the image, or nearer than what is drawn: most patches go so,
    /// without a look at their points.
    fn is_outside(&self, radius: f64, map: &PatchMap) -> bool {
        let lens = self.lens;
        let [x, y, z] = map.rows;
        let by = if lens.perspective { z } else { DVec4::W };
        // q is positive all over the ball.
        let positive = |q: DVec4| {
            let across = q.truncate();
            q.w > 0.0 && q.w * q.w > across.dot(across) * (radius * radius)
        };
        let beyond = |axis: usize, row: DVec4| {
            let limit = by * (lens.half(axis) + MARGIN);
            positive(row - limit) || positive(-row - limit)
        };
        beyond(0, x) || beyond(1, y) || positive(DVec4::W * lens.near - z)
    }

    /// The whole hull lies beyond one side of the image; holds for points behind the eye too.
    fn outside(&self) -> bool {
        let lens = self.lens;
        let beyond = |value: fn(DVec4) -> f64, axis: usize, sign: f64| {
            let limit = lens.half(axis) + MARGIN;
            self.scratch.iter().all(|&p| sign * value(p) > limit * lens.denominator(p))
        };
        beyond(|p| p.x, 0, 1.0) || beyond(|p| p.x, 0, -1.0) || beyond(|p| p.y, 1, 1.0) || beyond(|p| p.y, 1, -1.0)
    }

    /// Nothing of a net that crosses the near plane is wider than half a pixel there.
    fn smaller_than_half_pixel(&self) -> bool {
        let lens = self.lens;
        let pixel = lens.pixel_size(lens.near);
        let (x, y, z) = (
            range(self.scratch.iter().map(|p| p.x / p.w / lens.scale)),
            range(self.scratch.iter().map(|p| p.y / p.w / lens.scale)),
            range(self.scratch.iter().map(|p| p.z / p.w)),
        );
        [x, y, z].iter().all(|(lo, hi)| hi - lo < 0.5 * pixel)
    }

    /// The direction in which the projected control polygons are longer.
    fn longer_axis(&self, [m, n]: [usize; 2]) -> usize {
        let lens = self.lens;
        let near = lens.near;
        let place = |i: usize, j: usize| {
            let p = self.scratch[i * (n + 1) + j];
            let z = p.z / p.w;
            // Behind the near plane there is no screen: depth stands in, in pixels at the near plane.
            let d = if lens.perspective { z.max(near) } else { 1.0 };
            let depth = if lens.perspective { z * lens.scale / d } else { z * lens.scale };
            DVec3::new(p.x / p.w / d, p.y / p.w / d, if z < near { depth * 4.0 } else { depth })
        };
        let along_u = (0..m).flat_map(|i| (0..=n).map(move |j| (i, j)));
        let along_v = (0..=m).flat_map(|i| (0..n).map(move |j| (i, j)));
        let u: f64 = along_u.map(|(i, j)| place(i, j).distance(place(i + 1, j))).sum::<f64>() / (n + 1) as f64;
        let v: f64 = along_v.map(|(i, j)| place(i, j).distance(place(i, j + 1))).sum::<f64>() / (m + 1) as f64;
        usize::from(v > u)
    }

    /// Which way a face's visible side lies: 1 along `S_u x S_v`, -1 against it, 0: both sides can be seen.
    fn visible_side(&self, patch: &Patch) -> i8 {
        let sides = self.scene.faces[patch.face as usize].sides;
        match (self.options.cull, sides) {
            (Cull::Off, _) | (Cull::Auto, Sides::Both) => 0,
            (Cull::Auto, _) if !self.whole => 0,
            (_, Sides::Inside) => -1,
            _ => 1,
        }
    }

    /// The sign of the screen area, in parameter order, of what faces away. x is right, y down and z away from the eye:
    /// normals that point away have a positive one. A mirroring instance turns it round.
    fn hidden_sign(&self, patch: &Patch, map: &PatchMap) -> i8 {
        let [x, y, z] = map.axes;
        let side = self.visible_side(patch);
        if x.cross(y).dot(z) < 0.0 { -side } else { side }
    }

    /// All of a solid's patch faces away from an eye that is outside.
    fn is_back_patch(&self, patch: &Patch, map: &PatchMap) -> bool {
        let side = self.visible_side(patch);
        if side == 0 || patch.cone.cos_angle <= 0.0 {
            return false;
        }
        // Seen from its own coordinates a solid looks the same however its instance stretches or mirrors it.
        let normals = Cone { axis: patch.cone.axis * f64::from(side), cos: patch.cone.cos_angle };
        let rays =
            if self.lens.perspective { Cone::of_rays(patch.radius, map) } else { Some(Cone::of_parallel_rays(map)) };
        rays.is_some_and(|rays| normals.is_near(&rays))
    }

    /// Writes the f32 net of a leaf: centred in f64, then rounded.
    fn push_net(&self, leaf: &Leaf, nets: &mut Vec<Vec4>) {
        let [cx, cy] = leaf.center.map(f64::from);
        for &p in &self.scratch {
            let d = self.lens.denominator(p);
            let centred = DVec4::new(p.x - cx * d, p.y - cy * d, p.z - leaf.depth_origin * p.w, p.w);
            nets.push(centred.as_vec4());
        }
    }
}

/// Bound of the error of a projected vertex in pixels, for a net `reach` pixels about its centre.
///
/// Sums of `n + 1` positive multiples in f32 err by at most `(n + 3) 2^-24` relative to the sum of moduli (Higham,
/// section 3.1), for both directions, plus one rounding of the input; since all weights are positive that sum is at
/// most `reach` times the denominator. The denominator errs likewise, and the quotient rounds once more.
fn rounding_bound(degree: [usize; 2], reach: f64) -> f64 {
    let gamma = (degree[0] + degree[1] + 8) as f64;
    (2.0 * gamma + 2.0) * reach * 0.5f64.powi(24)
}

/// What the rounding of a parameter in [0, 1] to f32 moves a point in pixels, beyond what it would with equal weights.
///
/// A rational curve of degree n moves by at most `n span max(w) / min(w)` a unit of its parameter (Floater 1992); an
/// interpolated parameter errs by some four half-ulps, 2^-22. Where weights fall a million times towards t = 1, f32 has
/// next to no parameters for most of the curve.
fn parameter_rounding(degree: [usize; 2], (least, most): (f64, f64), span: f64) -> f64 {
    degree[0].max(degree[1]) as f64 * span * (most / least - 1.0) * 0.5f64.powi(22)
}

fn range(values: impl Iterator<Item = f64>) -> (f64, f64) {
    values.fold((f64::INFINITY, f64::NEG_INFINITY), |(lo, hi), v| (lo.min(v), hi.max(v)))
}

fn halve(net: Net, piece: &Piece, axis: usize) -> [Piece; 2] {
    let [low, high] = net.split(axis, 0.5);
    let mut extent = piece.extent;
    extent[axis] *= 0.5;
    let mut upper = piece.corner;
    upper[axis] += extent[axis];
    let depth = piece.depth + 1;
    [
        Piece { net: Some(low), corner: piece.corner, extent, depth },
        Piece { net: Some(high), corner: upper, extent, depth },
    ]
}
