//! The five tessellation bounds, each as constraints on the grid (research "tessellation-bounds", section 2).
//!
//! A constraint `[a, b, c]` asks for `a / nu^2 + b / (nu nv) + c / nv^2 <= 1` where the patch is cut into `nu x nv`
//! quads. Tolerances are in pixels; z is camera depth.

use super::cull::Leaf;
use super::estimate::Tessellation;
use super::lens::{Lens, PatchMap};
use super::{Bound, slefe};
use crate::geometry::Net;
use crate::scene::Enclosure;
use glam::{DVec3, DVec4, Vec4};

/// Constraints for the two diagonals: 0 runs (0,0)-(1,1), 1 runs (1,0)-(0,1).
#[derive(Clone, Copy, Debug)]
pub(super) struct Constraints {
    list: [[[f64; 3]; Self::CAPACITY]; 2],
    count: [usize; 2],
    /// Where those on depth begin: the ones before are on pixels.
    depth: [usize; 2],
    /// A direction in which the leaf is narrower than the tolerance has none.
    narrow: bool,
}

/// Pixels a side of the boxes that small triangles fit.
const SMALL_TRIANGLE: f64 = 16.0;

/// What a bound looks at.
pub(super) struct Subject<'a> {
    pub leaf: &'a Leaf,
    pub lens: &'a Lens,
    pub map: &'a PatchMap,
    /// The leaf's exact net, object space.
    pub net: Net<'a>,
    pub enclosure: &'a Enclosure,
    /// The leaf's projected net, centred.
    pub projected: &'a [Vec4],
    /// Pixels that the grid may be off, snapping and rounding already taken out.
    pub tolerance: f64,
    /// Model units that the depth may be off.
    pub depth_tolerance: f64,
}

impl Constraints {
    /// Two ends of two axes with two signs, and two signs of depth.
    const CAPACITY: usize = 10;

    pub fn new() -> Self {
        Self { list: [[[0.0; 3]; Self::CAPACITY]; 2], count: [0; 2], depth: [0; 2], narrow: false }
    }

    pub fn of(&self, diagonal: usize) -> &[[f64; 3]] {
        &self.list[diagonal][..self.count[diagonal]]
    }

    pub fn push(&mut self, diagonal: usize, constraint: [f64; 3]) {
        if constraint.iter().any(|&c| c > 0.0) {
            self.list[diagonal][self.count[diagonal]] = constraint;
            self.count[diagonal] += 1;
        }
    }

    /// The largest shares of the tolerances, in pixels and in depth, that a grid uses up.
    fn shares(&self, grid: &Tessellation) -> [f64; 2] {
        let diagonal = usize::from(grid.diagonal);
        let (pixels, depth) = self.of(diagonal).split_at(self.depth[diagonal]);
        let [nu, nv] = grid.quads.map(f64::from);
        let share = |[a, b, c]: &[f64; 3]| a / (nu * nu) + b / (nu * nv) + c / (nv * nv);
        [pixels, depth].map(|list| list.iter().map(share).fold(0.0, f64::max))
    }

    /// At least `sqrt(pieces)` quads in each direction.
    pub fn isotropic(pieces: f64) -> Self {
        let mut out = Self::new();
        out.push_both([pieces, 0.0, 0.0]);
        out.push_both([0.0, 0.0, pieces]);
        out
    }

    fn push_both(&mut self, constraint: [f64; 3]) {
        self.push(0, constraint);
        self.push(1, constraint);
    }
}

/// The constraints of `bound` on a leaf.
pub(super) fn constraints(bound: Bound, subject: &Subject) -> Constraints {
    match bound {
        Bound::Screen => screen(subject),
        Bound::Eter => eter(subject),
        Bound::Filip => filip(subject),
        Bound::Projective => projective(subject),
        Bound::Slefe => slefe::constraints(subject),
    }
}

impl Subject<'_> {
    fn z_min(&self) -> f64 {
        self.leaf.low.z
    }

    /// The pixels `xi` at which an axis' bound is taken: the ends of what the image shows of the leaf, drawn in by
    /// the tolerance. `None`: the leaf is narrower than the tolerance. Section 2, M4 ("r - eps, per axis").
    fn ends(&self, axis: usize) -> Option<[f64; 2]> {
        let (a, b) = (self.leaf.low[axis], self.leaf.high[axis]);
        let half = self.lens.half(axis);
        (b - a > self.tolerance).then(|| [(a + self.tolerance).max(-half), (b - self.tolerance).min(half)])
    }

    /// ETER section 4.1: the radius of a cube about any point of the leaf's camera-space box whose projection stays
    /// within the tolerance; in orthographic views the tolerance over the scale.
    fn object_epsilon(&self) -> f64 {
        let lens = self.lens;
        if !lens.perspective {
            return self.tolerance / lens.scale;
        }
        let z = self.z_min();
        (0..2)
            .map(|axis| {
                // Largest |x / z| of the box: its x extent in model units over its nearest depth.
                let slope = self.camera_reach(axis) / z;
                let tau = self.tolerance / lens.scale;
                z * tau / (1.0 + slope + tau)
            })
            .fold(f64::INFINITY, f64::min)
    }

    /// Largest |x| (or |y|) of the control net in camera space, model units.
    fn camera_reach(&self, axis: usize) -> f64 {
        let row = self.map.rows[axis];
        let points = self.net.points().iter();
        points.map(|&p| (row.dot(p) / p.w).abs()).fold(0.0, f64::max) / self.lens.scale
    }
}

/// M7bn: `q . S_ab` for the directions q in which pixel xi's plane faces; affine interpolation.
fn screen(subject: &Subject) -> Constraints {
    let Subject { lens, map, tolerance, .. } = *subject;
    let mut out = Constraints::new();
    let z_min = if lens.perspective { subject.z_min() } else { 1.0 };
    let unit = 1.0 / (8.0 * tolerance * z_min);
    for axis in 0..2 {
        let Some(ends) = subject.ends(axis) else {
            out.narrow = true;
            continue;
        };
        // Without perspective the direction does not depend on the pixel.
        let ends = if lens.perspective { &ends[..] } else { &ends[..1] };
        for &xi in ends {
            let tilt = if lens.perspective { xi } else { 0.0 };
            signed(&mut out, subject.enclosure, map.axes[axis] * lens.scale - map.axes[2] * tilt, unit);
        }
    }
    out.depth = out.count;
    signed(&mut out, subject.enclosure, map.axes[2], 1.0 / (8.0 * subject.depth_tolerance));
    out
}

/// What a grid is off by at most, where it is interpolated as its bound has it: pixels in x and in y, and camera depth in
/// model units. `None`: the bound says no more than that the tolerances are kept.
pub(super) fn deviation(bound: Bound, subject: &Subject, used: &Constraints, grid: &Tessellation) -> Option<[f64; 2]> {
    let (tolerance, depth_tolerance) = (subject.tolerance, subject.depth_tolerance);
    match bound {
        Bound::Screen if !used.narrow => {
            let [pixels, depth] = used.shares(grid);
            let depth = depth * depth_tolerance;
            // The constraints are for pixels up to a tolerance farther in than some that see the leaf: `tilt` times depth.
            let tilt = if subject.lens.perspective { depth / subject.z_min() } else { 0.0 };
            Some([(pixels + tilt) * tolerance, depth])
        }
        Bound::Screen | Bound::Filip => Some(affine_deviation(subject, grid)),
        Bound::Eter => {
            // A smaller error projects to less than its share of the tolerance: the projection is convex in it.
            let share = eter_within(subject, isotropic_epsilon(subject), 0.0).shares(grid)[1];
            Some([share * tolerance, share * depth_tolerance])
        }
        Bound::Projective | Bound::Slefe => None,
    }
}

/// `screen` read the other way round, for all pixels that see the leaf.
fn affine_deviation(subject: &Subject, grid: &Tessellation) -> [f64; 2] {
    let Subject { leaf, lens, map, enclosure, .. } = *subject;
    let (mut pixels, mut depth) = (Constraints::new(), Constraints::new());
    let z_min = if lens.perspective { subject.z_min() } else { 1.0 };
    for axis in 0..2 {
        let half = lens.half(axis);
        let ends = [leaf.low[axis].clamp(-half, half), leaf.high[axis].clamp(-half, half)];
        for &xi in if lens.perspective { &ends[..] } else { &ends[..1] } {
            let tilt = if lens.perspective { xi } else { 0.0 };
            signed(&mut pixels, enclosure, map.axes[axis] * lens.scale - map.axes[2] * tilt, 1.0 / (8.0 * z_min));
        }
    }
    signed(&mut depth, enclosure, map.axes[2], 1.0 / 8.0);
    [pixels, depth].map(|constraints| constraints.shares(grid)[1])
}

/// Both signs of one direction: the sign and diagonal refinement of section 2.
fn signed(out: &mut Constraints, enclosure: &Enclosure, q: DVec3, unit: f64) {
    let length = q.length();
    let interval = |k: usize| {
        let (low, high) = (enclosure.low[k], enclosure.high[k]);
        let middle = q.dot(low + high) * 0.5;
        let spread = q.abs().dot(high - low) * 0.5;
        let ball = length * enclosure.radius[k];
        ((middle - spread).max(-ball), (middle + spread).min(ball))
    };
    let (uu, uv, vv) = (interval(0), interval(1), interval(2));
    let half_width = (uv.1 - uv.0) * 0.5;
    for positive in [true, false] {
        let a = if positive { uu.1 } else { -uu.0 }.max(0.0);
        let c = if positive { vv.1 } else { -vv.0 }.max(0.0);
        for diagonal in 0..2 {
            let b = half_width.max(if positive == (diagonal == 0) { uv.1 } else { -uv.0 });
            out.push(diagonal, [a * unit, 2.0 * b * unit, c * unit]);
        }
    }
}

/// M3: Guthe 2005 section 5.2 after Filip: norms of the second derivatives against the object-space epsilon.
fn filip(subject: &Subject) -> Constraints {
    let mut out = Constraints::new();
    let unit = 1.0 / (8.0 * isotropic_epsilon(subject));
    let [uu, uv, vv] = subject.enclosure.radius;
    let scale = axis_scale(subject.map);
    out.push_both([uu * unit * scale, 2.0 * uv * unit * scale, vv * unit * scale]);
    out
}

/// One epsilon for all three axes, ETER's `min(eps, eps_z)`.
fn isotropic_epsilon(subject: &Subject) -> f64 {
    subject.object_epsilon().min(subject.depth_tolerance)
}

/// Largest stretch of an instance: object lengths times this bound camera lengths.
fn axis_scale(map: &PatchMap) -> f64 {
    // The Frobenius norm over sqrt(3) is exact for similarities; the norm itself bounds any other map.
    let [x, y, z] = map.axes.map(|a| a.length());
    let similar = (x - y).abs().max((x - z).abs()) <= 1e-9 * x;
    let norm = (x * x + y * y + z * z).sqrt();
    if similar { norm / 3f64.sqrt() * (1.0 + 1e-9) } else { norm }
}

/// M1: ETER section 4.1 with Zheng and Sederberg's bound on homogeneous second derivatives, about the box centre.
fn eter(subject: &Subject) -> Constraints {
    let epsilon = isotropic_epsilon(subject);
    eter_within(subject, epsilon, epsilon)
}

/// The same, in terms of the share of `epsilon` that is used up; points are within `drawn_in` of where their net allows.
fn eter_within(subject: &Subject, epsilon: f64, drawn_in: f64) -> Constraints {
    let net = subject.net;
    let [epsilon, drawn_in] = [epsilon, drawn_in].map(|e| e / axis_scale(subject.map));
    let (origin, radius) = ball(net);
    let mut out = Constraints::new();
    if drawn_in >= 2.0 * radius {
        return out;
    }
    let reach = (radius - drawn_in).max(0.0);
    let size = |d: DVec4| (d.truncate() - origin * d.w).length() + reach * d.w.abs();
    let [uu, uv, vv] = second_differences(net, size);
    let unit = 1.0 / (8.0 * epsilon * least_weight(net));
    out.push_both([uu * unit, 2.0 * uv * unit, vv * unit]);
    out
}

/// ETER section 6.2, equation (2): the fewest quads, along u and v, whose triangles fit boxes of 16 x 16 pixels.
pub(super) fn small_triangles(subject: &Subject) -> [f64; 2] {
    let (net, [m, n]) = (subject.net, subject.net.degree());
    let epsilon = Subject { tolerance: SMALL_TRIANGLE, ..*subject }.object_epsilon() / axis_scale(subject.map);
    let (origin, radius) = ball(net);
    if epsilon >= 2.0 * radius {
        return [1.0; 2];
    }
    let reach = (radius - epsilon).max(0.0);
    let size = |d: DVec4| (d.truncate() - origin * d.w).length() + reach * d.w.abs();
    let mut largest = [0.0f64; 2];
    for (i, j) in (0..=m).flat_map(|i| (0..=n).map(move |j| (i, j))) {
        if i < m {
            largest[0] = largest[0].max(size(net.point(i + 1, j) - net.point(i, j)));
        }
        if j < n {
            largest[1] = largest[1].max(size(net.point(i, j + 1) - net.point(i, j)));
        }
    }
    let unit = 2.0 / (epsilon * least_weight(net));
    [largest[0] * m as f64 * unit, largest[1] * n as f64 * unit].map(|quads| quads.ceil().max(1.0))
}

/// The middle of a hull's box, and how far its points are from there.
fn ball(net: Net) -> (DVec3, f64) {
    let (low, high) = net.hull().fold((DVec3::INFINITY, DVec3::NEG_INFINITY), |(l, h), p| (l.min(p), h.max(p)));
    let origin = (low + high) * 0.5;
    (origin, net.hull().map(|p| p.distance(origin)).fold(0.0, f64::max))
}

fn least_weight(net: Net) -> f64 {
    net.points().iter().map(|p| p.w).fold(f64::INFINITY, f64::min)
}

/// M4: second differences of the clip-space net, per axis; projective interpolation.
fn projective(subject: &Subject) -> Constraints {
    let Subject { leaf, lens, tolerance, .. } = *subject;
    let projected: Vec<DVec4> = subject.projected.iter().map(|p| p.as_dvec4()).collect();
    let net = Net::new(leaf.degree, &projected);
    let denominator = |p: DVec4| if lens.perspective { p.z + leaf.depth_origin * p.w } else { p.w };
    let d_min = projected.iter().map(|&p| denominator(p)).fold(f64::INFINITY, f64::min);
    let mut out = Constraints::new();
    let mut push = |value: &dyn Fn(DVec4) -> f64, unit: f64| {
        let [uu, uv, vv] = second_differences(net, |d| value(d).abs());
        out.push_both([uu * unit, 2.0 * uv * unit, vv * unit]);
    };
    for axis in 0..2 {
        for xi in subject.ends(axis).into_iter().flatten() {
            // The net is centred on the leaf: so is xi.
            let xi = xi - f64::from(leaf.center[axis]);
            push(&|d| d[axis] - xi * denominator(d), 1.0 / (8.0 * tolerance * d_min));
        }
    }
    let w_min = projected.iter().map(|p| p.w).fold(f64::INFINITY, f64::min);
    let (near, far) = (leaf.low.z - leaf.depth_origin, leaf.high.z - leaf.depth_origin);
    let t = subject.depth_tolerance;
    if far - near > t {
        for zeta in [near + t, far - t] {
            push(&|d| d.z - zeta * d.w, 1.0 / (8.0 * t * w_min));
        }
    }
    out
}

/// Largest `size` of the control points of F_uu, F_uv, F_vv.
fn second_differences(net: Net, size: impl Fn(DVec4) -> f64) -> [f64; 3] {
    let [m, n] = net.degree();
    let p = |i: usize, j: usize| net.point(i, j);
    let mut largest = [0.0f64; 3];
    for i in 0..=m {
        for j in 0..=n {
            if i + 2 <= m {
                largest[0] = largest[0].max(size(p(i + 2, j) - p(i + 1, j) * 2.0 + p(i, j)));
            }
            if j + 2 <= n {
                largest[2] = largest[2].max(size(p(i, j + 2) - p(i, j + 1) * 2.0 + p(i, j)));
            }
            if i < m && j < n {
                largest[1] = largest[1].max(size(p(i + 1, j + 1) - p(i, j + 1) - p(i + 1, j) + p(i, j)));
            }
        }
    }
    let (m, n) = (m as f64, n as f64);
    [largest[0] * m * (m - 1.0), largest[1] * m * n, largest[2] * n * (n - 1.0)]
}
