//! Rational Bézier curves and NURBS curves. Plane curves (trim loops) leave z at 0.

use super::net::{FEW, casteljau, check_points, elevate_line, restrict_line};
use super::{GeometryError, Knots, MAX_DEGREE};
use glam::{DVec2, DVec3, DVec4};

/// A rational Bézier curve over [0, 1], homogeneous points `(wx, wy, wz, w)`; its degree is one less than their number.
#[derive(Clone, Debug, PartialEq)]
pub struct BezierCurve {
    points: Vec<DVec4>,
}

/// One Bézier segment of a curve with its interval of the curve's own parameter.
#[derive(Clone, Debug, PartialEq)]
pub struct CurvePiece {
    pub curve: BezierCurve,
    pub domain: [f64; 2],
}

/// A NURBS curve of any degree up to [`MAX_DEGREE`].
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsCurve {
    knots: Knots,
    points: Vec<DVec4>,
}

/// Position and derivative in space from their homogeneous forms.
fn divide((point, derivative): (DVec4, DVec4)) -> (DVec3, DVec3) {
    let position = point.truncate() / point.w;
    (position, (derivative.truncate() - position * derivative.w) / point.w)
}

impl BezierCurve {
    /// A checked curve; `what` names it in the error.
    pub fn new(what: &str, points: Vec<DVec4>) -> Result<Self, GeometryError> {
        if !(2..=MAX_DEGREE + 1).contains(&points.len()) {
            let degree = points.len().saturating_sub(1);
            return Err(GeometryError::BadDegree { what: what.into(), degree, max: MAX_DEGREE });
        }
        check_points(what, &points)?;
        Ok(Self { points })
    }

    /// For points known to be good.
    pub(crate) fn from_points(points: Vec<DVec4>) -> Self {
        Self { points }
    }

    /// The straight segment from `a` to `b`.
    pub fn line(a: DVec3, b: DVec3) -> Self {
        Self { points: vec![a.extend(1.0), b.extend(1.0)] }
    }

    pub fn degree(&self) -> usize {
        self.points.len() - 1
    }

    pub fn points(&self) -> &[DVec4] {
        &self.points
    }

    /// Homogeneous point and derivative at `t`, by de Casteljau.
    pub fn jet(&self, t: f64) -> (DVec4, DVec4) {
        if self.points.len() <= FEW { self.jet_in::<FEW>(t) } else { self.jet_in::<{ MAX_DEGREE + 1 }>(t) }
    }

    fn jet_in<const N: usize>(&self, t: f64) -> (DVec4, DVec4) {
        let mut column = [DVec4::ZERO; N];
        let column = &mut column[..self.points.len()];
        column.copy_from_slice(&self.points);
        casteljau(column, t)
    }

    /// Position and derivative in space at `t`.
    pub fn tangent(&self, t: f64) -> (DVec3, DVec3) {
        divide(self.jet(t))
    }

    /// Position at `t`.
    pub fn position(&self, t: f64) -> DVec3 {
        self.tangent(t).0
    }

    /// The part over `[a, b]` as a curve over [0, 1]. Neighbouring parts share their end bit for bit.
    pub fn restrict(&self, [a, b]: [f64; 2]) -> Self {
        let mut points = self.points.clone();
        restrict_line(&mut points, a, b);
        Self { points }
    }

    /// The same curve with degree `degree`, at least its own and at most [`MAX_DEGREE`].
    pub fn elevate(&self, degree: usize) -> Self {
        Self { points: elevate_line(&self.points, degree) }
    }

    /// The same curve run through from its end.
    pub fn reversed(&self) -> Self {
        Self { points: self.points.iter().rev().copied().collect() }
    }
}

impl NurbsCurve {
    /// A checked curve of `points.len() + degree + 1` knots; `what` names it in the error.
    pub fn new(what: &str, degree: usize, knots: Vec<f64>, points: Vec<DVec4>) -> Result<Self, GeometryError> {
        let knots = Knots::new(what, degree, points.len(), knots)?;
        check_points(what, &points)?;
        Ok(Self { knots, points })
    }

    /// A periodic curve from one period: `points.len() + 1` knots, no point repeated.
    pub fn periodic(what: &str, degree: usize, knots: &[f64], points: &[DVec4]) -> Result<Self, GeometryError> {
        if knots.len() != points.len() + 1 {
            let [expected, found] = [points.len() + 1, knots.len()];
            return Err(GeometryError::KnotCount { what: what.into(), expected, found });
        }
        let knots = Knots::periodic(what, degree, knots)?;
        check_points(what, points)?;
        let points = points.iter().cycle().take(knots.point_count()).copied().collect();
        Ok(Self { knots, points })
    }

    pub fn degree(&self) -> usize {
        self.knots.degree()
    }

    pub fn knots(&self) -> &[f64] {
        self.knots.values()
    }

    pub fn points(&self) -> &[DVec4] {
        &self.points
    }

    /// `[t0, t1]`.
    pub fn domain(&self) -> [f64; 2] {
        self.knots.domain()
    }

    /// Homogeneous point and derivative at `t`, clamped to the domain, by de Boor.
    pub fn jet(&self, t: f64) -> (DVec4, DVec4) {
        let [low, high] = self.domain();
        let t = t.clamp(low, high);
        let span = self.knots.span(t);
        if self.degree() < FEW { self.jet_in::<FEW>(span, t) } else { self.jet_in::<{ MAX_DEGREE + 1 }>(span, t) }
    }

    fn jet_in<const N: usize>(&self, span: usize, t: f64) -> (DVec4, DVec4) {
        let [weights, slopes] = self.knots.weights::<N>(span, t);
        let points = &self.points[span - self.degree()..=span];
        let sum = |weights: &[f64; N]| points.iter().zip(weights).map(|(p, &w)| *p * w).sum();
        (sum(&weights), sum(&slopes))
    }

    /// Position and derivative in space at `t`.
    pub fn tangent(&self, t: f64) -> (DVec3, DVec3) {
        divide(self.jet(t))
    }

    /// Position at `t`.
    pub fn position(&self, t: f64) -> DVec3 {
        self.tangent(t).0
    }

    /// The same curve with the knot `t` once more; unchanged where `t` is outside the domain or a knot of multiplicity
    /// `degree + 1`.
    pub fn insert_knot(&self, t: f64) -> Self {
        let Some((knots, span)) = self.knots.inserted(t) else { return self.clone() };
        Self { knots, points: self.knots.insert_into_line(&self.points, span, t) }
    }

    /// The exact Bézier segments, one per non-empty knot interval.
    pub fn bezier_pieces(&self) -> Vec<CurvePiece> {
        let points = self.knots.bezier_points(&self.points);
        let pieces = self.knots.spans().zip(points.chunks_exact(self.degree() + 1));
        pieces
            .map(|(span, points)| CurvePiece {
                curve: BezierCurve { points: points.to_vec() },
                domain: self.knots.interval(span),
            })
            .collect()
    }
}

/// Squared distance of a point from the straight line between two others.
pub fn distance2_from_line(p: DVec2, [a, b]: [DVec2; 2]) -> f64 {
    let way = b - a;
    let share = ((p - a).dot(way) / way.length_squared()).clamp(0.0, 1.0);
    // Both ends in one place: no way to go.
    p.distance_squared(if share.is_nan() { a } else { a + way * share })
}
