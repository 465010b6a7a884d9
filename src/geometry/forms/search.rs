//! Nearest points on NURBS surfaces and on the profiles of swept ones.

use super::chart::{local, wrap, wrap_axis};
use super::{CurveSpan, SurfaceForm};
use crate::geometry::{BezierPatch, NurbsSurface, PatchPiece, exact::Frame};
use glam::{DVec2, DVec3};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering as AtomicOrdering};
use std::{cmp::Ordering, collections::BinaryHeap, f64::consts::TAU};

/// Gauss-Newton takes 4 or 5 steps from a good start; more than this is a start in the wrong place.
const MAX_STEPS: usize = 40;

/// Boxes that branch and bound looks into before it is content with what it has, which [`NetSearch::open`] counts.
const MAX_BOXES: usize = 500;

/// Nearest points of a NURBS surface.
#[derive(Clone, Debug)]
pub(super) struct NetSearch {
    surface: NurbsSurface,
    periods: [Option<f64>; 2],
    pieces: Vec<PatchPiece>,
    boxes: Vec<[DVec3; 2]>,
    open: Arc<AtomicUsize>,
}

/// A parameter rectangle whose points are all at least `distance` away.
struct Candidate {
    distance: f64,
    patch: Option<BezierPatch>,
    piece: usize,
    domain: [[f64; 2]; 2],
}

impl Ord for Candidate {
    /// The nearest is the greatest.
    fn cmp(&self, other: &Self) -> Ordering {
        other.distance.total_cmp(&self.distance)
    }
}

impl PartialOrd for Candidate {
    fn partial_cmp(&self, other: &Self) -> Option<Ordering> {
        Some(self.cmp(other))
    }
}

impl PartialEq for Candidate {
    fn eq(&self, other: &Self) -> bool {
        self.cmp(other).is_eq()
    }
}

impl Eq for Candidate {}

fn box_distance([low, high]: [DVec3; 2], point: DVec3) -> f64 {
    (point - point.clamp(low, high)).length()
}

/// How far the hull is at least, along the direction from it to the point: of a small patch that leans much nearer to
/// the truth than its box.
fn slab_distance(patch: &BezierPatch, point: DVec3) -> f64 {
    let Some(toward) = (point - patch.net().position(0.5, 0.5)).try_normalize() else { return 0.0 };
    patch.net().hull().map(|p| toward.dot(point - p)).fold(f64::INFINITY, f64::min)
}

fn hull_box(patch: &BezierPatch) -> [DVec3; 2] {
    let mut bounds = [DVec3::INFINITY, DVec3::NEG_INFINITY];
    for p in patch.net().hull() {
        bounds = [bounds[0].min(p), bounds[1].max(p)];
    }
    bounds
}

impl NetSearch {
    pub fn new(surface: &NurbsSurface, periods: [Option<f64>; 2]) -> Self {
        let pieces = surface.bezier_pieces();
        let boxes = pieces.iter().map(|piece| hull_box(&piece.patch)).collect();
        Self { surface: surface.clone(), periods, pieces, boxes, open: Arc::default() }
    }

    /// Searches that ended without knowing that nothing is nearer.
    pub fn open(&self) -> usize {
        self.open.load(AtomicOrdering::Relaxed)
    }

    pub fn pieces(&self) -> &[PatchPiece] {
        &self.pieces
    }

    pub fn invert(&self, point: DVec3, near: Option<DVec2>, accept: f64) -> DVec2 {
        if let Some(near) = near {
            let (uv, distance) = self.descend(point, near);
            if distance <= accept {
                return uv;
            }
        }
        // What continues a curve but lost it wants the nearest point, not just a near one.
        self.nearest(point, near, if near.is_some() { 0.0 } else { accept })
    }

    /// Damped Gauss-Newton on the distance from `point`, kept inside the domain: where the surface ends, along its
    /// border. The parameters and the distance there.
    fn descend(&self, point: DVec3, start: DVec2) -> (DVec2, f64) {
        let domain = self.surface.domain();
        let extent = DVec2::new(domain[0][1] - domain[0][0], domain[1][1] - domain[1][0]);
        let mut uv = wrap(start, domain, self.periods);
        let mut at = self.surface.surface_point(uv.x, uv.y);
        let mut damping = 0.0;
        let mut moved_before = 0.0;
        for _ in 0..MAX_STEPS {
            let offset = point - at.position;
            let gradient = DVec2::new(at.du.dot(offset), at.dv.dot(offset));
            // A parameter at the end of its domain that wants to leave it stays there.
            let held = [0, 1].map(|axis| {
                let [a, b] = domain[axis];
                self.periods[axis].is_none()
                    && ((uv[axis] <= a && gradient[axis] < 0.0) || (uv[axis] >= b && gradient[axis] > 0.0))
            });
            let step = damped_step([at.du, at.dv], gradient, held, damping);
            let target = wrap(uv + step.clamp(-0.3 * extent, 0.3 * extent), domain, self.periods);
            let next = self.surface.surface_point(target.x, target.y);
            let (before, after) = (offset.length_squared(), next.position.distance_squared(point));
            let moved = (at.du * step.x + at.dv * step.y).length();
            // Steps shrink at least as fast as they did: by a constant factor off the surface, quadratically on it.
            let mut next_move = f64::INFINITY;
            if after <= before * (1.0 + 1e-14) {
                (uv, at) = (target, next);
                if damping == 0.0 {
                    next_move = moved * (moved / moved_before);
                }
                damping = if damping < 1e-3 { 0.0 } else { damping * 0.1 };
            } else {
                damping = if damping == 0.0 { 1e-3 } else { damping * 10.0 };
            }
            moved_before = moved;
            let scale = at.position.abs().max_element() + (at.du * extent.x).length() + (at.dv * extent.y).length();
            if moved.min(next_move) <= 2e-15 * scale || damping > 1e9 {
                break;
            }
        }
        (uv, at.position.distance(point))
    }

    /// Branch and bound: boxes of control nets bound the distance from below, descents from their middles from above.
    fn nearest(&self, point: DVec3, near: Option<DVec2>, accept: f64) -> DVec2 {
        let domain = self.surface.domain();
        let middle = |d: [[f64; 2]; 2]| DVec2::new(0.5 * (d[0][0] + d[0][1]), 0.5 * (d[1][0] + d[1][1]));
        let mut best = (near.map_or_else(|| middle(domain), |uv| wrap(uv, domain, self.periods)), f64::INFINITY);
        let mut heap = BinaryHeap::with_capacity(self.pieces.len());
        for (piece, bounds) in self.boxes.iter().enumerate() {
            let distance = box_distance(*bounds, point);
            heap.push(Candidate { distance, patch: None, piece, domain: self.pieces[piece].domain });
        }
        for looked in 0.. {
            let Some(candidate) = heap.pop() else { break };
            if candidate.distance >= best.1 * 0.999 || best.1 <= accept {
                break;
            }
            if looked == MAX_BOXES {
                self.open.fetch_add(1, AtomicOrdering::Relaxed);
                break;
            }
            let found = self.descend(point, middle(candidate.domain));
            if found.1 < best.1 {
                best = found;
            }
            let patch = candidate.patch.as_ref().unwrap_or(&self.pieces[candidate.piece].patch);
            let [du, dv] =
                [candidate.domain[0][1] - candidate.domain[0][0], candidate.domain[1][1] - candidate.domain[1][0]];
            let at = patch.net().surface_point(0.5, 0.5);
            let axis = usize::from(at.dv.length_squared() > at.du.length_squared());
            if du.max(dv) <= 1e-6 * (domain[axis][1] - domain[axis][0]) {
                continue;
            }
            for (half, patch) in patch.net().split(axis, 0.5).into_iter().enumerate() {
                let mut part = candidate.domain;
                part[axis][1 - half] = 0.5 * (part[axis][0] + part[axis][1]);
                let distance = box_distance(hull_box(&patch), point).max(slab_distance(&patch, point));
                if distance < best.1 {
                    heap.push(Candidate { distance, patch: Some(patch), piece: candidate.piece, domain: part });
                }
            }
        }
        best.0
    }
}

/// The step of `(JᵀJ + damping diag(JᵀJ)) step = gradient` with held parameters left out.
fn damped_step([du, dv]: [DVec3; 2], gradient: DVec2, held: [bool; 2], damping: f64) -> DVec2 {
    let (a, b, c) = (du.length_squared() * (1.0 + damping), du.dot(dv), dv.length_squared() * (1.0 + damping));
    let alone = |g: f64, a: f64| if a > 0.0 { g / a } else { 0.0 };
    match held {
        [true, true] => DVec2::ZERO,
        [true, false] => DVec2::new(0.0, alone(gradient.y, c)),
        [false, true] => DVec2::new(alone(gradient.x, a), 0.0),
        [false, false] => {
            let determinant = a * c - b * b;
            // At a pole one derivative vanishes; the other still leads on.
            if determinant <= 1e-14 * a * c {
                let one = if a >= c { DVec2::X } else { DVec2::Y };
                return one * DVec2::new(alone(gradient.x, a), alone(gradient.y, c));
            }
            DVec2::new(c * gradient.x - b * gradient.y, a * gradient.y - b * gradient.x) / determinant
        }
    }
}

/// Nearest points on a profile, in the two coordinates that a sweep leaves: across the direction of an extrusion, or
/// distance from the axis and height of a revolution.
#[derive(Clone, Debug)]
pub(super) struct ProfileSearch {
    profile: CurveSpan,
    sweep: Sweep,
    period: Option<f64>,
    limits: [f64; 2],
    samples: Vec<(f64, DVec2)>,
}

#[derive(Clone, Copy, Debug)]
enum Sweep {
    /// Axes across the direction, and the direction.
    Along {
        across: [DVec3; 2],
        direction: DVec3,
    },
    About(Frame),
}

impl Sweep {
    /// The two coordinates of a point, and how they change with its derivative.
    fn flat(&self, (p, d): (DVec3, DVec3)) -> (DVec2, DVec2) {
        match self {
            Self::Along { across: [x, y], .. } => (DVec2::new(p.dot(*x), p.dot(*y)), DVec2::new(d.dot(*x), d.dot(*y))),
            Self::About(frame) => {
                let q = local(frame, p);
                let r = q.x.hypot(q.y);
                let dr = if r > 0.0 {
                    (q.x * d.dot(frame.x) + q.y * d.dot(frame.y)) / r
                } else {
                    d.reject_from(frame.z).length()
                };
                (DVec2::new(r, q.z), DVec2::new(dr, d.dot(frame.z)))
            }
        }
    }
}

impl ProfileSearch {
    pub fn extruded(profile: &CurveSpan, direction: DVec3, period: Option<f64>) -> Self {
        let (x, y) = direction.normalize_or(DVec3::Z).any_orthonormal_pair();
        let form = SurfaceForm::Extrusion { profile: profile.clone(), direction };
        Self::new(profile, Sweep::Along { across: [x, y], direction }, period, form.limits()[0])
    }

    pub fn turned(profile: &CurveSpan, frame: Frame, period: Option<f64>) -> Self {
        let form = SurfaceForm::Revolution { profile: profile.clone(), frame };
        Self::new(profile, Sweep::About(frame), period, form.limits()[1])
    }

    fn new(profile: &CurveSpan, sweep: Sweep, period: Option<f64>, limits: [f64; 2]) -> Self {
        let [a, b] = if (limits[1] - limits[0]).is_finite() { limits } else { [0.0, period.unwrap_or(TAU)] };
        let breaks = CurveSpan { curve: profile.curve.clone(), range: [a, b] }.breaks();
        let mut samples = Vec::with_capacity(breaks.len() * 12);
        for piece in breaks.windows(2) {
            for k in 0..=12 {
                let t = piece[0] + (piece[1] - piece[0]) * (f64::from(k) / 12.0);
                samples.push((t, sweep.flat(profile.tangent(t)).0));
            }
        }
        Self { profile: profile.clone(), sweep, period, limits, samples }
    }

    pub fn wrapped(&self, t: f64) -> f64 {
        if self.limits[0].is_finite() { wrap_axis(t, self.limits, self.period) } else { t }
    }

    pub fn invert(&self, form: &SurfaceForm, point: DVec3, near: Option<DVec2>, accept: f64) -> DVec2 {
        let target = self.sweep.flat((point, DVec3::ZERO)).0;
        let axis = usize::from(matches!(form, SurfaceForm::Revolution { .. }));
        let started = near.map(|near| self.descend(target, near[axis]));
        let (t, _) = started.filter(|found| found.1 <= accept).unwrap_or_else(|| self.nearest(target, accept));
        let (foot, _) = self.profile.tangent(t);
        match self.sweep {
            Sweep::Along { direction, .. } => DVec2::new(t, (point - foot).dot(direction) / direction.length_squared()),
            Sweep::About(frame) => {
                let [p, q] = [point, foot].map(|p| local(&frame, p));
                DVec2::new(p.y.atan2(p.x) - q.y.atan2(q.x), t)
            }
        }
    }

    fn descend(&self, target: DVec2, start: f64) -> (f64, f64) {
        let mut t = self.wrapped(start);
        let at = |t: f64| self.sweep.flat(self.profile.tangent(t));
        let (mut p, mut d) = at(t);
        for _ in 0..MAX_STEPS {
            let full = if d.length_squared() > 0.0 { (target - p).dot(d) / d.length_squared() } else { 0.0 };
            let mut step = full;
            let mut next = self.wrapped(t + step);
            let mut found = at(next);
            while found.0.distance_squared(target) > p.distance_squared(target) * (1.0 + 1e-14)
                && step.abs() > 1e-3 * full.abs()
            {
                step *= 0.3;
                next = self.wrapped(t + step);
                found = at(next);
            }
            let moved = found.0.distance(p);
            if found.0.distance_squared(target) > p.distance_squared(target) * (1.0 + 1e-14) {
                break;
            }
            (t, (p, d)) = (next, found);
            if moved <= 4e-16 * p.length() {
                break;
            }
        }
        (t, p.distance(target))
    }

    fn nearest(&self, target: DVec2, accept: f64) -> (f64, f64) {
        let mut order: Vec<(f64, f64)> = self.samples.iter().map(|&(t, p)| (p.distance_squared(target), t)).collect();
        order.sort_by(|a, b| a.0.total_cmp(&b.0));
        let mut best = (0.0, f64::INFINITY);
        for (_, t) in order.into_iter().take(12) {
            let found = self.descend(target, t);
            if found.1 < best.1 {
                best = found;
            }
            if best.1 <= accept {
                break;
            }
        }
        best
    }
}
