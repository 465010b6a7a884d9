//! Evaluation of curves by formula, and their exact rational Bézier pieces.

use super::{CurveForm, CurveSpan};
use crate::geometry::{BezierCurve, CurvePiece, NurbsCurve, exact};
use glam::DVec3;
use std::f64::consts::TAU;

impl CurveForm {
    /// Position and derivative at `t`.
    pub fn tangent(&self, t: f64) -> (DVec3, DVec3) {
        match self {
            Self::Line { origin, direction } => (*origin + *direction * t, *direction),
            Self::Ellipse { frame, radii: [rx, ry] } => {
                let (s, c) = exact::sin_cos(t);
                (frame.point(rx * c, ry * s, 0.0), frame.x * (-rx * s) + frame.y * (ry * c))
            }
            Self::Parabola { frame, focal } => {
                let position = frame.point(focal * t * t, 2.0 * focal * t, 0.0);
                (position, (frame.x * t + frame.y) * (2.0 * focal))
            }
            Self::Hyperbola { frame, radii: [rx, ry] } => {
                let (s, c) = (t.sinh(), t.cosh());
                (frame.point(rx * c, ry * s, 0.0), frame.x * (rx * s) + frame.y * (ry * c))
            }
            Self::Nurbs(curve) => curve.tangent(t),
        }
    }

    /// Position at `t`.
    pub fn position(&self, t: f64) -> DVec3 {
        self.tangent(t).0
    }

    /// The parameter's period, for curves that close: ellipses, and NURBS whose ends are within `tolerance`.
    pub fn period(&self, tolerance: f64) -> Option<f64> {
        match self {
            Self::Ellipse { .. } => Some(TAU),
            Self::Nurbs(curve) => {
                let [a, b] = curve.domain();
                (curve.position(a).distance(curve.position(b)) <= tolerance).then_some(b - a)
            }
            _ => None,
        }
    }

    /// Exact rational Bézier pieces from `range[0]` to `range[1]`, in that direction. A NURBS that closes is taken
    /// round as often as the range says; one that does not is cut at its ends.
    pub fn pieces(&self, range: [f64; 2], closed: bool) -> Vec<CurvePiece> {
        let [a, b] = range;
        match self {
            Self::Line { origin, direction } => {
                let [p, q] = range.map(|t| *origin + *direction * t);
                vec![CurvePiece { curve: BezierCurve::line(p, q), domain: range }]
            }
            Self::Ellipse { frame, radii } => exact::ellipse(frame, *radii, range),
            Self::Parabola { frame, focal } => vec![exact::parabola(frame, *focal, range)],
            Self::Hyperbola { frame, radii } => vec![exact::hyperbola(frame, *radii, range)],
            Self::Nurbs(curve) if a <= b => nurbs_pieces(curve, range, closed),
            Self::Nurbs(curve) => {
                let mut pieces = nurbs_pieces(curve, [b, a], closed);
                pieces.reverse();
                for piece in &mut pieces {
                    *piece = CurvePiece { curve: piece.curve.reversed(), domain: [piece.domain[1], piece.domain[0]] };
                }
                pieces
            }
        }
    }
}

fn nurbs_pieces(curve: &NurbsCurve, [a, b]: [f64; 2], closed: bool) -> Vec<CurvePiece> {
    let [start, end] = curve.domain();
    let period = end - start;
    let turns = if closed { [((a - start) / period).floor(), ((b - start) / period).ceil()] } else { [0.0, 1.0] };
    // A thousand turns are senseless; the cut shows as a gap.
    let turns = turns.map(|k| k.clamp(-1000.0, 1000.0) as i32);
    let whole = curve.bezier_pieces();
    let mut pieces = Vec::with_capacity(whole.len());
    for turn in turns[0]..turns[1].max(turns[0] + 1) {
        let shift = f64::from(turn) * period;
        for piece in &whole {
            let domain = piece.domain.map(|t| t + shift);
            let [low, high] = [domain[0].max(a), domain[1].min(b)];
            let length = domain[1] - domain[0];
            // What is left over by rounding is no piece, but a short range is one.
            if high - low <= 1e-12 * length.min(b - a) {
                continue;
            }
            let local = [low, high].map(|t| (t - domain[0]) / length);
            let cut = if local == [0.0, 1.0] { piece.curve.clone() } else { piece.curve.restrict(local) };
            pieces.push(CurvePiece { curve: cut, domain: [low, high] });
        }
    }
    pieces
}

impl CurveSpan {
    /// Position and derivative (by the curve's own parameter) at `t`.
    pub fn tangent(&self, t: f64) -> (DVec3, DVec3) {
        self.curve.tangent(t)
    }

    /// The parameter of the span's point next to `point`, by Gauss-Newton from `t`, and the distance there.
    pub fn nearest(&self, point: DVec3, mut t: f64) -> (f64, f64) {
        let [low, high] = [self.range[0].min(self.range[1]), self.range[0].max(self.range[1])];
        let mut best = (t, f64::INFINITY);
        for _ in 0..10 {
            let (p, d) = self.tangent(t);
            let distance = p.distance(point);
            if distance >= best.1 {
                break;
            }
            best = (t, distance);
            let next = (t + (point - p).dot(d) / d.length_squared().max(f64::MIN_POSITIVE)).clamp(low, high);
            if next == t {
                break;
            }
            t = next;
        }
        best
    }

    /// As [`CurveSpan::nearest`], from the nearest of several points between all breaks.
    pub fn nearest_of_all(&self, point: DVec3) -> (f64, f64) {
        let breaks = self.breaks();
        let inside = |w: &[f64]| [0.0, 0.25, 0.5, 0.75, 1.0].map(|s| w[0] + (w[1] - w[0]) * s);
        let distance = |t: f64| self.curve.position(t).distance_squared(point);
        let starts = breaks.windows(2).flat_map(inside).map(|t| (distance(t), t));
        let start = starts.min_by(|a, b| a.0.total_cmp(&b.0)).map_or(self.range[0], |best| best.1);
        self.nearest(point, start)
    }

    /// Where the span starts and ends.
    pub fn ends(&self) -> [DVec3; 2] {
        self.range.map(|t| self.curve.position(t))
    }

    /// Parameters from start to end between which the curve is smooth: the knots of a NURBS, arcs of a conic of at most
    /// a quarter turn.
    pub fn breaks(&self) -> Vec<f64> {
        let [a, b] = self.range;
        let mut breaks = vec![a];
        match &self.curve {
            CurveForm::Line { .. } | CurveForm::Parabola { .. } | CurveForm::Hyperbola { .. } => {}
            CurveForm::Ellipse { .. } => {
                breaks.extend((1..exact::arc_count(self.range)).map(|k| exact::arc_border(self.range, k)));
            }
            CurveForm::Nurbs(curve) => {
                let [low, high] = [a.min(b), a.max(b)];
                let least = 1e-12 * (high - low);
                let inner = curve.knots().iter().copied().filter(|&t| t > low + least && t < high - least);
                breaks.extend(inner);
                if a > b {
                    breaks[1..].reverse();
                }
                breaks.dedup_by(|t, before| (*t - *before).abs() <= least);
            }
        }
        breaks.push(b);
        breaks
    }

    /// Exact rational Bézier pieces in the span's direction.
    pub fn pieces(&self) -> Vec<CurvePiece> {
        self.curve.pieces(self.range, false)
    }
}
