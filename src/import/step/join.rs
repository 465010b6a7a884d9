//! One B-spline from several curves, and B-splines that follow what has no exact form.

use super::curve::Curve;
use super::error::{StepError, bad};
use super::place::Shapes;
use crate::geometry::{BezierCurve, CurveForm, CurvePiece, CurveSpan, NurbsCurve};
use glam::{DAffine3, DVec3, DVec4};

/// An approximation stays this close to what it follows, in millimetres.
pub(super) const FIT_TOLERANCE: f64 = 1e-6;
/// Pieces of an approximation.
const MAX_PIECES: usize = 4096;

/// All spans as one curve; its parameter is that of the spans one after the other. Exact.
pub(super) fn joined(id: u32, spans: &[CurveSpan]) -> Result<NurbsCurve, StepError> {
    let pieces: Vec<CurvePiece> = spans.iter().flat_map(CurveSpan::pieces).collect();
    of_pieces(id, &pieces, &DAffine3::IDENTITY)
}

/// Pieces in order as one curve, continuous where they meet.
pub(super) fn of_pieces(id: u32, pieces: &[CurvePiece], map: &DAffine3) -> Result<NurbsCurve, StepError> {
    let degree = pieces.iter().map(|p| p.curve.degree()).max().unwrap_or(1);
    let mut points: Vec<DVec4> = Vec::with_capacity(pieces.len() * degree + 1);
    let mut knot = pieces.first().map_or(0.0, |p| p.domain[0]);
    let mut knots = vec![knot];
    for piece in pieces {
        let elevated = piece.curve.elevate(degree);
        let mut own = elevated.points();
        // Neighbours share a point; a weight that differs is evened out over the whole piece.
        let mut factor = 1.0;
        if let Some(last) = points.last() {
            factor = last.w / own[0].w;
            own = &own[1..];
        }
        points
            .extend(own.iter().map(|p| (map.transform_point3(p.truncate() / p.w) * p.w * factor).extend(p.w * factor)));
        knots.extend(std::iter::repeat_n(knot, degree));
        let [from, to] = piece.domain;
        // Neighbours in ascending order keep their knots to the last bit.
        knot = if from == knot && from < to { to } else { knot + (to - from).abs() };
    }
    knots.extend(std::iter::repeat_n(knot, degree + 1));
    Ok(NurbsCurve::new(&format!("#{id}"), degree, knots, points)?)
}

impl Shapes<'_, '_> {
    /// The curve at `distance` along `axis x tangent` (ISO 10303-42, 4.4.33 and 4.4.34): exact for lines and for circles
    /// about the axis, else approximated.
    pub fn offset_curve(&self, id: u32, basis: Curve, distance: f64, axis: DVec3) -> Result<Curve, StepError> {
        let away = |d: DVec3| axis.cross(d).try_normalize().unwrap_or(DVec3::ZERO) * distance;
        match &basis {
            Curve::Whole(CurveForm::Line { origin, direction }) => {
                return Ok(Curve::Whole(CurveForm::Line { origin: *origin + away(*direction), direction: *direction }));
            }
            Curve::Whole(CurveForm::Ellipse { frame, radii: [a, b] }) if a == b => {
                let along = frame.z.dot(axis);
                let radius = a - along.signum() * distance;
                if 1.0 - along.abs() < 1e-12 && radius > 0.0 {
                    return Ok(Curve::Whole(CurveForm::Ellipse { frame: *frame, radii: [radius, radius] }));
                }
            }
            _ => {}
        }
        let Some(spans) = basis.spans() else { return bad(id, "an offset of a curve without ends") };
        let mut pieces = Vec::new();
        for span in &spans {
            let follow = |t: f64| {
                let (p, d) = span.tangent(t);
                p + away(d)
            };
            pieces.extend(followed(id, span.range, &follow)?);
        }
        self.note(id, format!("offset curve approximated to {FIT_TOLERANCE:e} mm"));
        Ok(Curve::Whole(CurveForm::Nurbs(of_pieces(id, &pieces, &DAffine3::IDENTITY)?)))
    }
}

/// Cubic pieces that follow `point` over `range` (which may descend) to [`FIT_TOLERANCE`]. They interpolate four points
/// each; halved until points between agree.
pub(super) fn followed(id: u32, range: [f64; 2], point: &dyn Fn(f64) -> DVec3) -> Result<Vec<CurvePiece>, StepError> {
    let mut pieces = Vec::new();
    let mut todo: Vec<[f64; 2]> = (0..4).rev().map(|k| [k, k + 1].map(|k| lerp(range, f64::from(k) / 4.0))).collect();
    while let Some(part) = todo.pop() {
        let curve = cubic(part, point);
        let [middle, ends] = [[1.0 / 6.0, 0.5, 5.0 / 6.0], [0.05, 0.5, 0.95]];
        let off = |&s: &f64| curve.position(s).distance(point(lerp(part, s)));
        let error = middle.iter().chain(&ends).map(off).fold(0.0, f64::max);
        if !error.is_finite() {
            return bad(id, "a curve whose points are not finite");
        }
        if error <= FIT_TOLERANCE {
            pieces.push(CurvePiece { curve, domain: part });
        } else if pieces.len() + todo.len() >= MAX_PIECES {
            return bad(id, format!("{MAX_PIECES} pieces don't follow this curve to {FIT_TOLERANCE:e} mm"));
        } else {
            let half = lerp(part, 0.5);
            todo.extend([[half, part[1]], [part[0], half]]);
        }
    }
    Ok(pieces)
}

fn lerp([a, b]: [f64; 2], s: f64) -> f64 {
    a + (b - a) * s
}

/// The cubic through the points at 0, 1/3, 2/3 and 1 of `range`.
fn cubic(range: [f64; 2], point: &dyn Fn(f64) -> DVec3) -> BezierCurve {
    let [p0, p1, p2, p3] = [0.0, 1.0 / 3.0, 2.0 / 3.0, 1.0].map(|s| point(lerp(range, s)));
    let b1 = (p0 * -5.0 + p1 * 18.0 - p2 * 9.0 + p3 * 2.0) / 6.0;
    let b2 = (p0 * 2.0 - p1 * 9.0 + p2 * 18.0 - p3 * 5.0) / 6.0;
    let points = [p0, b1, b2, p3].map(|p| p.extend(1.0)).to_vec();
    BezierCurve::new("", points).unwrap_or_else(|_| BezierCurve::line(p0, p3))
}
