//! Which part of a curve lies between two points of it.

use super::curve::{Curve, backward};
use crate::geometry::exact::Frame;
use crate::geometry::{CurveForm, CurveSpan, NurbsCurve};
use glam::DVec3;
use std::f64::consts::TAU;

/// Samples in each knot interval, for each degree, in which the nearest point is looked for.
const SAMPLES: usize = 4;
/// The nearest samples from which Newton starts.
const STARTS: usize = 4;
const NEWTON_STEPS: usize = 30;

/// Where a part of a curve starts or ends.
#[derive(Clone, Copy, Debug)]
pub(super) enum End {
    Point(DVec3),
    Parameter(f64),
}

impl Curve {
    /// The part from `start` to `end`, in the curve's direction or (`forward` false) against it. Where both are the same
    /// place on a closed curve it is the full turn.
    pub fn between(&self, start: End, end: End, forward: bool, tolerance: f64) -> Vec<CurveSpan> {
        match self {
            Self::Whole(form) => {
                let [t0, t1] = [start, end].map(|end| match end {
                    End::Point(point) => parameter_of(form, point, tolerance),
                    End::Parameter(t) => t,
                });
                let same = same_place(form, start, end, tolerance);
                ranges(form, [t0, t1], forward, same, tolerance)
                    .into_iter()
                    .map(|range| CurveSpan { curve: form.clone(), range })
                    .collect()
            }
            Self::Pieces(spans) if forward => between_pieces(spans, start, end, tolerance),
            Self::Pieces(spans) => between_pieces(&backward(spans.clone()), start, end, tolerance),
        }
    }
}

/// Both ends are one point, or one turn apart.
fn same_place(form: &CurveForm, start: End, end: End, tolerance: f64) -> bool {
    match (start, end) {
        (End::Point(a), End::Point(b)) => a.distance(b) <= 1e-3 * tolerance.min(1e-3),
        (End::Parameter(a), End::Parameter(b)) => a == b && matches!(form, CurveForm::Ellipse { .. }),
        _ => false,
    }
}

/// From parameter t0 to t1, in one range or, across the joint of a closed curve, two.
fn ranges(form: &CurveForm, [t0, t1]: [f64; 2], forward: bool, same: bool, tolerance: f64) -> Vec<[f64; 2]> {
    let sign = if forward { 1.0 } else { -1.0 };
    match form {
        CurveForm::Ellipse { .. } => {
            let turn = (sign * (t1 - t0)).rem_euclid(TAU);
            vec![[t0, t0 + sign * if same || turn == 0.0 { TAU } else { turn }]]
        }
        CurveForm::Nurbs(curve) => {
            let [a, b] = curve.domain();
            // Both ends at one vertex: the curve is meant to close, be it a little off.
            let slack = if same { tolerance.max(1e-2 * length(curve)) } else { tolerance };
            let closed = form.period(slack).is_some();
            if !closed {
                return vec![[t0, t1]];
            }
            let [first, last] = if forward { [a, b] } else { [b, a] };
            let start = if t0 == last { first } else { t0 };
            let end = if t1 == first { last } else { t1 };
            if same && (start == first || end == last) {
                vec![[first, last]]
            } else if same || sign * (end - start) < 0.0 {
                vec![[start, last], [first, end]]
            } else {
                vec![[start, end]]
            }
        }
        _ => vec![[t0, t1]],
    }
}

/// Of the control polygon.
fn length(curve: &NurbsCurve) -> f64 {
    let at = |k: usize| curve.points()[k].truncate() / curve.points()[k].w;
    (1..curve.points().len()).map(|k| at(k - 1).distance(at(k))).sum()
}

/// The parameter of the point of `form` nearest to `point` (on conics: nearest or as good, for points near the curve).
pub(super) fn parameter_of(form: &CurveForm, point: DVec3, tolerance: f64) -> f64 {
    let local = |frame: &Frame| [(point - frame.origin).dot(frame.x), (point - frame.origin).dot(frame.y)];
    match form {
        CurveForm::Line { origin, direction } => (point - *origin).dot(*direction) / direction.length_squared(),
        CurveForm::Ellipse { frame, radii: [a, b] } => {
            let [x, y] = local(frame);
            (y / b).atan2(x / a)
        }
        CurveForm::Parabola { frame, focal } => local(frame)[1] / (2.0 * focal),
        CurveForm::Hyperbola { frame, radii: [_, b] } => (local(frame)[1] / b).asinh(),
        CurveForm::Nurbs(curve) => nurbs_parameter(curve, point, tolerance),
    }
}

/// The parameter of the nearest point: an end where that is within the tolerance, else the best of several Newton
/// iterations from the nearest of many samples.
fn nurbs_parameter(curve: &NurbsCurve, point: DVec3, tolerance: f64) -> f64 {
    let ends = curve.domain();
    let [first, last] = ends.map(|t| curve.position(t).distance(point));
    if first.min(last) <= tolerance.min(1e-3 * length(curve)) {
        return ends[usize::from(last < first)];
    }
    let count = SAMPLES * curve.degree();
    let knots = curve.knots();
    let mut samples: Vec<(f64, f64)> = (knots.windows(2).filter(|k| k[0] >= ends[0] && k[1] <= ends[1] && k[0] < k[1]))
        .flat_map(|k| (0..=count).map(move |i| k[0] + (k[1] - k[0]) * (i as f64 / count as f64)))
        .map(|t| (curve.position(t).distance_squared(point), t))
        .collect();
    samples.sort_by(|a, b| a.0.total_cmp(&b.0));
    let best = samples.iter().take(STARTS).map(|&(_, t)| newton(curve, point, t)).min_by(|a, b| a.0.total_cmp(&b.0));
    best.map_or(ends[0], |(_, t)| t)
}

/// Gauss-Newton on the distance, halved until it doesn't grow; also the squared distance that is left.
fn newton(curve: &NurbsCurve, point: DVec3, start: f64) -> (f64, f64) {
    let [a, b] = curve.domain();
    let (mut t, mut squared) = (start, curve.position(start).distance_squared(point));
    for _ in 0..NEWTON_STEPS {
        let (position, derivative) = curve.tangent(t);
        let step = (point - position).dot(derivative) / derivative.length_squared();
        if !step.is_finite() {
            break;
        }
        let mut factor = 1.0;
        let better = loop {
            let next = (t + factor * step).clamp(a, b);
            let distance = curve.position(next).distance_squared(point);
            if distance < squared {
                break Some((next, distance));
            }
            factor *= 0.5;
            if factor < 1e-3 {
                break None;
            }
        };
        let Some((next, distance)) = better else { break };
        (t, squared) = (next, distance);
    }
    (squared, t)
}

/// A place on joined pieces: which one, and its parameter.
#[derive(Clone, Copy, PartialEq)]
struct Place {
    piece: usize,
    t: f64,
}

/// The part of joined pieces from one place to another, in their direction.
fn between_pieces(spans: &[CurveSpan], start: End, end: End, tolerance: f64) -> Vec<CurveSpan> {
    let (End::Point(from), End::Point(to)) = (start, end) else { return spans.to_vec() };
    let ends = spans.first().zip(spans.last());
    let Some((first, last)) = ends.map(|(f, l)| (f.ends()[0], l.ends()[1])) else {
        return Vec::new();
    };
    if first.distance(from) <= tolerance && last.distance(to) <= tolerance {
        return spans.to_vec();
    }
    let (Some(a), Some(b)) = (locate(spans, from, tolerance), locate(spans, to, tolerance)) else {
        return spans.to_vec();
    };
    let part = |piece: usize, range: [f64; 2]| CurveSpan { curve: spans[piece].curve.clone(), range };
    let whole = |piece: usize| spans[piece].clone();
    let ahead = |a: Place, b: Place| {
        let range = spans[b.piece].range;
        a.piece < b.piece || (a.piece == b.piece && (b.t - a.t) * (range[1] - range[0]).signum() > 0.0)
    };
    if a.piece == b.piece && ahead(a, b) {
        return vec![part(a.piece, [a.t, b.t])];
    }
    let closed = first.distance(last) <= tolerance;
    let mut parts = vec![part(a.piece, [a.t, spans[a.piece].range[1]])];
    if ahead(a, b) {
        parts.extend((a.piece + 1..b.piece).map(whole));
    } else if closed {
        parts.extend((a.piece + 1..spans.len()).map(whole));
        parts.extend((0..b.piece).map(whole));
    } else {
        return spans.to_vec();
    }
    parts.push(part(b.piece, [spans[b.piece].range[0], b.t]));
    parts.retain(|span| span.range[0] != span.range[1]);
    parts
}

/// The nearest place to `point`.
fn locate(spans: &[CurveSpan], point: DVec3, tolerance: f64) -> Option<Place> {
    let places = spans.iter().enumerate().map(|(piece, span)| {
        let [low, high] = [span.range[0].min(span.range[1]), span.range[0].max(span.range[1])];
        let mut t = parameter_of(&span.curve, point, tolerance);
        if matches!(span.curve, CurveForm::Ellipse { .. }) {
            t += ((low - t) / TAU).ceil() * TAU;
            // Outside the arc the nearer end is nearest.
            t = if t <= high {
                t
            } else if t - high < low + TAU - t {
                high
            } else {
                low
            };
        }
        let t = t.clamp(low, high);
        (span.curve.position(t).distance_squared(point), Place { piece, t })
    });
    places.min_by(|a, b| a.0.total_cmp(&b.0)).map(|(_, place)| place)
}
