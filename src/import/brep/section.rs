//! Plane sections of ruled patches, whose images in the parameter plane are rational: ellipses on cylinders, conics on
//! cones, plane cuts of extrusions.
//!
//! On a patch of degree 1 in v the homogeneous point is `P(s) + t (Q(s) - P(s))`. The equation L of a plane is linear in it:
//! `L(P) + t (L(Q) - L(P)) = 0`, so that t is a quotient of two polynomials of the patch's degree in s. With s as the first
//! coordinate that is a rational curve of one degree more. (As for conics: Farin, "Curves and Surfaces for CAGD", 5th ed.,
//! chapter 12.)

use super::trace::standard;
use crate::geometry::bernstein::Bernstein;
use crate::geometry::{BezierCurve, CurveForm, CurveSpan};
use crate::model::SurfacePatch;
use glam::{DVec2, DVec3, DVec4};

/// Weights may not differ more: beyond, a fit is as good.
const MAX_RATIO: f64 = 1e3;

/// Where the rulings of a patch meet a plane.
pub(super) struct Section<'b> {
    patch: &'b SurfacePatch,
    /// The axis across the rulings: the other one is that of degree 1.
    along: usize,
    /// x over y is the place on the ruling, from 0 to 1 over the patch.
    quotient: BezierCurve,
}

/// The plane through a part of a curve: a point and a normal. `None` for what is no plane curve, or nearly straight.
pub(super) fn plane_of(span: &CurveSpan, [a, b]: [f64; 2]) -> Option<[DVec3; 2]> {
    match &span.curve {
        CurveForm::Line { .. } => None,
        CurveForm::Ellipse { frame, .. } | CurveForm::Parabola { frame, .. } | CurveForm::Hyperbola { frame, .. } => {
            Some([frame.origin, frame.z])
        }
        CurveForm::Nurbs(curve) => {
            let [p, q, r] = [a, 0.5 * (a + b), b].map(|t| curve.position(t));
            let normal = (q - p).cross(r - p);
            (normal.length() > 1e-4 * (r - p).length_squared()).then(|| [q, normal.normalize()])
        }
    }
}

impl<'b> Section<'b> {
    /// The section of the patch that both ends lie on.
    pub fn new(patches: &'b [SurfacePatch], [origin, normal]: [DVec3; 2], ends: [DVec2; 2]) -> Option<Self> {
        let degree = patches.first()?.patch.degree();
        let along = if degree[1] == 1 { 0 } else { 1 };
        if degree[1 - along] != 1 {
            return None;
        }
        let holds = |patch: &&SurfacePatch| {
            (0..2).all(|axis| {
                let [low, high] = patch.domain[axis];
                let slack = 1e-9 * (high - low);
                ends.iter().all(|p| (low - slack..=high + slack).contains(&p[axis]))
            })
        };
        let patch = patches.iter().find(holds).filter(|patch| patch.patch.degree() == degree)?;
        let net = patch.patch.net();
        let level = |p: DVec4| normal.dot(p.truncate() - origin * p.w);
        let point = |k: usize| {
            let [p, q] = [0, 1].map(|end| if along == 0 { net.point(k, end) } else { net.point(end, k) }).map(level);
            DVec4::new(p, p - q, 0.0, 1.0)
        };
        let quotient = BezierCurve::from_points((0..=degree[along]).map(point).collect());
        Some(Self { patch, along, quotient })
    }

    /// The parameter along the rulings at one across them.
    fn at(&self, along: f64) -> f64 {
        let [[a0, a1], [b0, b1]] = [self.along, 1 - self.along].map(|axis| self.patch.domain[axis]);
        let ratio = self.quotient.jet((along - a0) / (a1 - a0)).0;
        b0 + (b1 - b0) * (ratio.x / ratio.y)
    }

    /// How far, along the rulings, the points are from the section; infinite where they turn back.
    pub fn distance(&self, points: &[DVec2], speed: DVec2) -> f64 {
        let ordered = |sign: f64| points.windows(2).all(|w| sign * (w[1] - w[0])[self.along] > 0.0);
        if !(ordered(1.0) || ordered(-1.0)) {
            return f64::INFINITY;
        }
        let off = |p: &DVec2| (self.at(p[self.along]) - p[1 - self.along]).abs() * speed[1 - self.along];
        points.iter().map(off).fold(0.0, |worst, off| if off <= worst { worst } else { off })
    }

    /// The section between its points at two places, its ends there bit for bit.
    pub fn curve(&self, ends: [DVec2; 2]) -> Option<BezierCurve> {
        let [[a0, a1], [b0, b1]] = [self.along, 1 - self.along].map(|axis| self.patch.domain[axis]);
        let [from, to] = ends.map(|p| ((p[self.along] - a0) / (a1 - a0)).clamp(0.0, 1.0));
        let mut part = self.quotient.restrict([from.min(to), from.max(to)]);
        if from > to {
            part = part.reversed();
        }
        let degree = part.degree();
        let side = part.points()[0].y.signum();
        let polynomial = |value: &dyn Fn(&DVec4) -> f64| Bernstein::new([degree, 0], part.points().iter().map(value));
        let weight = polynomial(&|p| side * p.y);
        let across = polynomial(&|p| side * (b0 * p.y + (b1 - b0) * p.x)).elevate([degree + 1, 0]).coefficients();
        let run = Bernstein::new([1, 0], ends.map(|p| p[self.along]));
        let (along, weights) = (weight.product(&run).coefficients(), weight.elevate([degree + 1, 0]).coefficients());
        let [low, high] = weights.iter().fold([f64::INFINITY, 0.0], |[a, b], w| [w.min(a), w.max(b)]);
        if !(low > 0.0 && high < MAX_RATIO * low) {
            return None;
        }
        let point = |k: usize| {
            let mut p = DVec4::new(0.0, 0.0, 0.0, weights[k]);
            (p[self.along], p[1 - self.along]) = (along[k], across[k]);
            p
        };
        let mut points: Vec<DVec4> = (0..weights.len()).map(point).collect();
        standard(&mut points);
        let last = points.len() - 1;
        (points[0], points[last]) = (ends[0].extend(0.0).extend(1.0), ends[1].extend(0.0).extend(1.0));
        Some(BezierCurve::from_points(points))
    }
}
