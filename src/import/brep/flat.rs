//! Planes, also those that are written as B-splines: the image of an edge is affine, hence exact.

use super::Scale;
use super::trace::{Path, Shape, Source, standard};
use crate::geometry::{BezierCurve, CurveForm, CurveSpan, NurbsSurface, SurfaceForm};
use glam::{DVec2, DVec3, DVec4};

/// A surface whose parameters are affine in space.
pub(super) struct Flat {
    origin: DVec3,
    /// Of the origin.
    base: DVec2,
    /// What each parameter grows by along a vector.
    rates: [DVec3; 2],
}

impl Flat {
    pub fn of(form: &SurfaceForm) -> Option<Self> {
        match form {
            SurfaceForm::Plane(frame) => {
                Some(Self { origin: frame.origin, base: DVec2::ZERO, rates: [frame.x, frame.y] })
            }
            SurfaceForm::Nurbs(surface) => Self::of_parallelogram(surface),
            _ => None,
        }
    }

    fn of_parallelogram(surface: &NurbsSurface) -> Option<Self> {
        if surface.degree() != [1, 1] || surface.counts() != [2, 2] {
            return None;
        }
        let points = surface.points();
        if points.iter().any(|p| p.w != points[0].w) {
            return None;
        }
        let corner = |k: usize| points[k].truncate() / points[k].w;
        let (origin, v, u) = (corner(0), corner(1) - corner(0), corner(2) - corner(0));
        let twist = corner(3) - origin - u - v;
        let (a, b, c) = (u.length_squared(), u.dot(v), v.length_squared());
        let area = a * c - b * b;
        if twist.length_squared() > 1e-26 * a.max(c) || area < 1e-6 * a * c {
            return None;
        }
        let domain = surface.domain();
        let [du, dv] = domain.map(|[low, high]| high - low);
        let rates = [(u * c - v * b) * (du / area), (v * a - u * b) * (dv / area)];
        Some(Self { origin, base: DVec2::new(domain[0][0], domain[1][0]), rates })
    }

    /// A homogeneous point, its z left at 0.
    fn image(&self, p: DVec4) -> DVec4 {
        let q = p.truncate() - self.origin * p.w;
        let [u, v] = self.rates.map(|rate| q.dot(rate));
        DVec4::new(self.base.x * p.w + u, self.base.y * p.w + v, 0.0, p.w)
    }

    /// The image of a span, as paths.
    pub fn paths<'a>(&self, scale: &Scale, edge: u32, span: &'a CurveSpan, paths: &mut Vec<Path<'a>>) {
        if matches!(span.curve, CurveForm::Line { .. }) {
            let [mut start, mut end] = span.ends().map(|p| self.image(p.extend(1.0)).truncate().truncate());
            for axis in 0..2 {
                let middle = 0.5 * (start[axis] + end[axis]);
                if (end[axis] - start[axis]).abs() <= scale.straight * self.rates[axis].length() {
                    (start[axis], end[axis]) = (middle, middle);
                }
            }
            let source = Some(Source { edge, span, range: span.range });
            paths.push(Path { start, end, shape: Shape::Straight, source, poles: [None, None] });
            return;
        }
        for piece in span.pieces() {
            let mut points: Vec<DVec4> = piece.curve.points().iter().map(|&p| self.image(p)).collect();
            standard(&mut points);
            let [start, end] = [points[0], points[points.len() - 1]].map(|p| p.truncate().truncate());
            let shape = Shape::Exact(BezierCurve::from_points(points));
            let source = Some(Source { edge, span, range: piece.domain });
            paths.push(Path { start, end, shape, source, poles: [None, None] });
        }
    }
}
