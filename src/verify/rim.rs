//! The trim curves of one face as curves in space, and where a ray passes near them.

use crate::geometry::BezierCurve;
use crate::model::Loop;
use crate::scene::Scene;
use glam::{DVec2, DVec3};

/// A face's trim curves on its surface, in the part's coordinates, as chords in a hierarchy of boxes.
#[derive(Debug)]
pub(super) struct Rim<'a> {
    curves: Vec<RimCurve<'a>>,
    chords: Vec<Chord>,
    nodes: Vec<Node>,
    /// Largest `TrimCurve::gap`.
    pub gap: f64,
}

#[derive(Debug)]
struct RimCurve<'a> {
    curve: &'a BezierCurve,
    gap: f64,
    edge: Option<u32>,
}

/// A part of a curve, and how far it may be from its chord.
#[derive(Clone, Copy, Debug)]
struct Chord {
    curve: u32,
    range: [f64; 2],
    ends: [DVec3; 2],
    deviation: f64,
}

#[derive(Clone, Copy, Debug)]
struct Node {
    low: DVec3,
    high: DVec3,
    skip: u32,
    first: u32,
    count: u32,
}

/// A ray in the part's coordinates: `origin + z step` has camera depth z.
#[derive(Clone, Copy, Debug)]
pub(super) struct SpaceRay {
    pub origin: DVec3,
    pub step: DVec3,
    /// Nothing is nearer than this.
    pub near: f64,
}

/// Where a ray passes near a trim curve.
#[derive(Clone, Copy, Debug)]
pub(super) struct Passing {
    pub patch: u32,
    /// On the curve, in the patch's unit square.
    pub parameter: [f64; 2],
    /// Camera depth of the curve there.
    pub depth: f64,
    /// From the ray, in the part's units.
    pub distance: f64,
    pub edge: Option<u32>,
}

/// A face's surface by points of its parameter plane.
#[derive(Clone, Copy, Debug)]
pub(super) struct Sheet<'a> {
    pub scene: &'a Scene,
    pub patches: &'a [u32],
}

/// Chords are cut until the curve is this close to them, as a fraction of their length.
const STRAIGHTNESS: f64 = 0.1;
const MAX_CUTS: u32 = 10;
/// Halvings of one chord for one ray.
const MAX_HALVINGS: u32 = 40;
const CHORDS_PER_LEAF: usize = 4;

impl<'a> Sheet<'a> {
    /// The patch that a point of the plane belongs to, and where in its unit square; the nearest where it is on none.
    pub fn locate(&self, p: DVec2) -> Option<(u32, [f64; 2])> {
        let mut nearest = None;
        let mut least = f64::INFINITY;
        for &patch in self.patches {
            let domain = self.scene.patches[patch as usize].domain;
            let beyond = |axis: usize| (domain[axis][0] - p[axis]).max(p[axis] - domain[axis][1]).max(0.0);
            let off = beyond(0) + beyond(1);
            if off < least {
                let at = |axis: usize| {
                    let [low, high] = domain[axis];
                    if high > low { ((p[axis] - low) / (high - low)).clamp(0.0, 1.0) } else { 0.5 }
                };
                (nearest, least) = (Some((patch, [at(0), at(1)])), off);
                if off == 0.0 {
                    break;
                }
            }
        }
        nearest
    }

    /// The surface over a point of the plane, in the part's coordinates.
    pub fn position(&self, p: DVec2) -> Option<DVec3> {
        let (patch, [u, v]) = self.locate(p)?;
        let patch = &self.scene.patches[patch as usize];
        Some(patch.origin + self.scene.net(patch).position(u, v))
    }
}

impl<'a> Rim<'a> {
    pub fn new(sheet: &Sheet, loops: &'a [Loop]) -> Self {
        let of = |c: &'a crate::model::TrimCurve| RimCurve { curve: &c.curve, gap: c.gap.max(0.0), edge: c.edge };
        let curves: Vec<_> = loops.iter().flat_map(|l| &l.curves).map(of).collect();
        let mut rim = Self { curves, chords: Vec::new(), nodes: Vec::new(), gap: 0.0 };
        for k in 0..rim.curves.len() {
            rim.gap = rim.gap.max(rim.curves[k].gap);
            rim.cut(sheet, k as u32);
        }
        if !rim.chords.is_empty() {
            let count = rim.chords.len();
            build(&mut rim.nodes, &mut rim.chords, 0, count);
        }
        rim
    }

    /// Memory beside the curves themselves.
    pub fn bytes(&self) -> usize {
        self.curves.capacity() * size_of::<RimCurve>()
            + self.chords.capacity() * size_of::<Chord>()
            + self.nodes.capacity() * size_of::<Node>()
    }

    fn at(&self, sheet: &Sheet, curve: u32, t: f64) -> Option<DVec3> {
        sheet.position(self.curves[curve as usize].curve.position(t).truncate())
    }

    /// Halves a curve until each part is nearly straight on the surface. Parts that lie on no patch are left out.
    fn cut(&mut self, sheet: &Sheet, curve: u32) {
        let mut work = vec![([0.0, 1.0], 0)];
        while let Some((range, cuts)) = work.pop() {
            let at = |f: f64| self.at(sheet, curve, range[0] + (range[1] - range[0]) * f);
            let [Some(a), Some(p), Some(q), Some(r), Some(b)] = [0.0, 0.25, 0.5, 0.75, 1.0].map(at) else { continue };
            // Twice what five points show.
            let deviation = 2.0 * [p, q, r].map(|x| to_segment(x, a, b)).into_iter().fold(0.0, f64::max);
            if cuts < MAX_CUTS && deviation > STRAIGHTNESS * a.distance(b) {
                let middle = 0.5 * (range[0] + range[1]);
                work.extend([([middle, range[1]], cuts + 1), ([range[0], middle], cuts + 1)]);
            } else if deviation.is_finite() {
                self.chords.push(Chord { curve, range, ends: [a, b], deviation });
            }
        }
    }

    /// The places where the ray passes within `reach(gap of the curve, camera depth)` of a curve, at most one a chord.
    /// `widest` is at least every reach.
    pub fn passings(
        &self,
        sheet: &Sheet,
        ray: &SpaceRay,
        widest: f64,
        reach: &impl Fn(f64, f64) -> f64,
        mut found: impl FnMut(Passing),
    ) {
        let mut at = 0;
        while let Some(node) = self.nodes.get(at) {
            if !ray.meets(node.low - widest, node.high + widest) {
                at = node.skip as usize;
                continue;
            }
            for chord in &self.chords[node.first as usize..(node.first + node.count) as usize] {
                if let Some(passing) = self.pass(sheet, ray, *chord, reach, MAX_HALVINGS) {
                    found(passing);
                }
            }
            at += 1;
        }
    }

    /// Halves the chord while it can't be told whether the ray is near enough; the nearer half first.
    fn pass(
        &self,
        sheet: &Sheet,
        ray: &SpaceRay,
        chord: Chord,
        reach: &impl Fn(f64, f64) -> f64,
        halvings: u32,
    ) -> Option<Passing> {
        let RimCurve { curve, gap, edge } = self.curves[chord.curve as usize];
        let (along, z, distance) = ray.approach(chord.ends);
        let reached = reach(gap, z.max(ray.near));
        if distance > reached + chord.deviation {
            return None;
        }
        if chord.deviation > 0.01 * reached && halvings > 0 {
            let middle = 0.5 * (chord.range[0] + chord.range[1]);
            let point = self.at(sheet, chord.curve, middle)?;
            // Halving quarters the deviation of a smooth curve; a third allows for one that is not.
            let half = |range, ends| Chord { range, ends, deviation: chord.deviation / 3.0, ..chord };
            let first = half([chord.range[0], middle], [chord.ends[0], point]);
            let second = half([middle, chord.range[1]], [point, chord.ends[1]]);
            let order = if along < 0.5 { [first, second] } else { [second, first] };
            return order.into_iter().find_map(|half| self.pass(sheet, ray, half, reach, halvings - 1));
        }
        let t = chord.range[0] + (chord.range[1] - chord.range[0]) * along;
        let (patch, parameter) = sheet.locate(curve.position(t).truncate())?;
        (distance <= reached && z >= ray.near).then_some(Passing { patch, parameter, depth: z, distance, edge })
    }
}

fn to_segment(p: DVec3, a: DVec3, b: DVec3) -> f64 {
    let along = b - a;
    let t = if along.length_squared() > 0.0 { (p - a).dot(along) / along.length_squared() } else { 0.0 };
    p.distance(a + along * t.clamp(0.0, 1.0))
}

impl SpaceRay {
    /// The ray, from near on, meets the box.
    fn meets(&self, low: DVec3, high: DVec3) -> bool {
        let (mut from, mut to) = (self.near, f64::INFINITY);
        for axis in 0..3 {
            let (origin, step) = (self.origin[axis], self.step[axis]);
            if step == 0.0 {
                if origin < low[axis] || origin > high[axis] {
                    return false;
                }
                continue;
            }
            let (a, b) = ((low[axis] - origin) / step, (high[axis] - origin) / step);
            from = from.max(a.min(b));
            to = to.min(a.max(b));
        }
        // Rounding of the divisions must not lose a box that is met.
        from <= to + 1e-12 * to.abs()
    }

    /// The line through the ray and the segment come nearest: where on the segment, at which z, how near.
    fn approach(&self, [a, b]: [DVec3; 2]) -> (f64, f64, f64) {
        let scale = self.step.length();
        let direction = self.step / scale;
        // What is across the ray.
        let across = |p: DVec3| (p - self.origin) - direction * (p - self.origin).dot(direction);
        let (p, q) = (across(a), across(b));
        let d = q - p;
        let length = d.length_squared();
        let s = if length > 0.0 { (-p.dot(d) / length).clamp(0.0, 1.0) } else { 0.0 };
        let z = (a.lerp(b, s) - self.origin).dot(direction) / scale;
        (s, z, (p + d * s).length())
    }
}

/// Appends the tree over chords `first..last`; halves at the median.
fn build(nodes: &mut Vec<Node>, chords: &mut [Chord], first: usize, last: usize) {
    let part = &mut chords[first..last];
    let (mut low, mut high) = (DVec3::INFINITY, DVec3::NEG_INFINITY);
    for chord in part.iter() {
        for end in chord.ends {
            low = low.min(end - chord.deviation);
            high = high.max(end + chord.deviation);
        }
    }
    let at = nodes.len();
    let leaf = part.len() <= CHORDS_PER_LEAF;
    nodes.push(Node { low, high, skip: 0, first: first as u32, count: if leaf { part.len() as u32 } else { 0 } });
    if !leaf {
        let size = high - low;
        let axis = if size.x >= size.y && size.x >= size.z { 0 } else { 1 + usize::from(size.z > size.y) };
        let middle = part.len() / 2;
        let center = |c: &Chord| c.ends[0][axis] + c.ends[1][axis];
        part.select_nth_unstable_by(middle, |a, b| center(a).total_cmp(&center(b)).then(a.curve.cmp(&b.curve)));
        build(nodes, chords, first, first + middle);
        build(nodes, chords, first + middle, last);
    }
    nodes[at].skip = nodes.len() as u32;
}
