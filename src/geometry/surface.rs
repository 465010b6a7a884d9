//! NURBS surfaces and their exact decomposition into rational Bézier patches.

use super::net::{FEW, check_points};
use super::{BezierPatch, GeometryError, Jet, Knots, MAX_DEGREE, SurfacePoint};
use glam::{DVec3, DVec4};

/// One Bézier patch of a surface with its rectangle `[[u0, u1], [v0, v1]]` of the surface's own parameters.
#[derive(Clone, Debug, PartialEq)]
pub struct PatchPiece {
    pub patch: BezierPatch,
    pub domain: [[f64; 2]; 2],
}

impl PatchPiece {
    /// `pieces` if all their points are finite and all weights positive; `what` names them in the error.
    pub fn checked(what: &str, pieces: Vec<Self>) -> Result<Vec<Self>, GeometryError> {
        pieces.iter().try_for_each(|piece| check_points(what, piece.patch.points()))?;
        Ok(pieces)
    }
}

/// A NURBS surface of any degree up to [`MAX_DEGREE`]; homogeneous points, u outermost.
#[derive(Clone, Debug, PartialEq)]
pub struct NurbsSurface {
    /// u, v
    knots: [Knots; 2],
    points: Vec<DVec4>,
}

impl NurbsSurface {
    /// A checked surface with `counts[0] * counts[1]` control points, `points[i * counts[1] + j]`, and
    /// `counts[a] + degree[a] + 1` knots in direction a; `what` names it in the error.
    pub fn new(
        what: &str,
        degree: [usize; 2],
        counts: [usize; 2],
        knots: [Vec<f64>; 2],
        points: Vec<DVec4>,
    ) -> Result<Self, GeometryError> {
        let [u, v] = knots;
        let u = Knots::new(&format!("{what}, u direction"), degree[0], counts[0], u)?;
        let v = Knots::new(&format!("{what}, v direction"), degree[1], counts[1], v)?;
        let expected = counts[0].checked_mul(counts[1]);
        if expected != Some(points.len()) {
            let expected = expected.unwrap_or(usize::MAX);
            return Err(GeometryError::PointCount { what: what.into(), expected, found: points.len() });
        }
        check_points(what, &points)?;
        Ok(Self { knots: [u, v], points })
    }

    /// A surface that is periodic in the directions where `periodic` says so: there `knots` holds one period,
    /// `counts[a] + 1` values, and no control point is repeated. Otherwise as [`NurbsSurface::new`].
    pub fn periodic(
        what: &str,
        degree: [usize; 2],
        counts: [usize; 2],
        knots: [Vec<f64>; 2],
        points: &[DVec4],
        periodic: [bool; 2],
    ) -> Result<Self, GeometryError> {
        let expected = counts[0].saturating_mul(counts[1]);
        if points.len() != expected {
            return Err(GeometryError::PointCount { what: what.into(), expected, found: points.len() });
        }
        let wrapped = [0, 1].map(|axis| counts[axis] + if periodic[axis] { degree[axis] } else { 0 });
        let mut full = knots;
        for (axis, direction) in ["u", "v"].into_iter().enumerate() {
            if periodic[axis] {
                let what = format!("{what}, {direction} direction");
                let (expected, found) = (counts[axis] + 1, full[axis].len());
                if found != expected {
                    return Err(GeometryError::KnotCount { what, expected, found });
                }
                full[axis] = Knots::periodic(&what, degree[axis], &full[axis])?.values().to_vec();
            }
        }
        let at = |i: usize, j: usize| points[i % counts[0] * counts[1] + j % counts[1]];
        let points = (0..wrapped[0]).flat_map(|i| (0..wrapped[1]).map(move |j| at(i, j))).collect();
        Self::new(what, degree, wrapped, full, points)
    }

    pub fn degree(&self) -> [usize; 2] {
        [self.knots[0].degree(), self.knots[1].degree()]
    }

    /// Knots in u and v.
    pub fn knots(&self) -> &[Knots; 2] {
        &self.knots
    }

    /// Number of control points in u and v.
    pub fn counts(&self) -> [usize; 2] {
        [self.knots[0].point_count(), self.knots[1].point_count()]
    }

    pub fn points(&self) -> &[DVec4] {
        &self.points
    }

    /// `[[u0, u1], [v0, v1]]`.
    pub fn domain(&self) -> [[f64; 2]; 2] {
        [self.knots[0].domain(), self.knots[1].domain()]
    }

    /// Homogeneous point and first derivatives at (u, v), clamped to the domain, by de Boor in each direction.
    pub fn jet(&self, u: f64, v: f64) -> Jet {
        let [ku, kv] = &self.knots;
        let clamp = |knots: &Knots, t: f64| t.clamp(knots.domain()[0], knots.domain()[1]);
        let [u, v] = [clamp(ku, u), clamp(kv, v)];
        let degree = ku.degree().max(kv.degree());
        if degree < FEW { self.jet_in::<FEW>(u, v) } else { self.jet_in::<{ MAX_DEGREE + 1 }>(u, v) }
    }

    fn jet_in<const N: usize>(&self, u: f64, v: f64) -> Jet {
        let [ku, kv] = &self.knots;
        let [su, sv] = [ku.span(u), kv.span(v)];
        let ([m, n], stride) = (self.degree(), kv.point_count());
        let [across_u, slope_u] = ku.weights::<N>(su, u);
        let [across_v, slope_v] = kv.weights::<N>(sv, v);
        let [mut point, mut du, mut dv] = [DVec4::ZERO; 3];
        for i in 0..=m {
            let start = (su - m + i) * stride + sv - n;
            let row = &self.points[start..=start + n];
            let sum = |weights: &[f64; N]| row.iter().zip(weights).map(|(p, &w)| *p * w).sum::<DVec4>();
            let here = sum(&across_v);
            point += here * across_u[i];
            du += here * slope_u[i];
            dv += sum(&slope_v) * across_u[i];
        }
        Jet { point, du, dv }
    }

    /// Position and first derivatives in space at (u, v).
    pub fn surface_point(&self, u: f64, v: f64) -> SurfacePoint {
        self.jet(u, v).divide()
    }

    /// Position at (u, v).
    pub fn position(&self, u: f64, v: f64) -> DVec3 {
        self.surface_point(u, v).position
    }

    /// The same surface with the knot `t` once more along `axis` (0: u, 1: v); unchanged where `t` is outside the
    /// domain or a knot of multiplicity `degree + 1`.
    pub fn insert_knot(&self, axis: usize, t: f64) -> Self {
        let old = &self.knots[axis];
        let Some((inserted, span)) = old.inserted(t) else { return self.clone() };
        let points = if axis == 0 {
            let columns = transpose(&self.points, self.counts()[1]);
            let columns: Vec<DVec4> =
                columns.chunks_exact(old.point_count()).flat_map(|line| old.insert_into_line(line, span, t)).collect();
            transpose(&columns, inserted.point_count())
        } else {
            self.points.chunks_exact(old.point_count()).flat_map(|line| old.insert_into_line(line, span, t)).collect()
        };
        let mut knots = self.knots.clone();
        knots[axis] = inserted;
        Self { knots, points }
    }

    /// The exact Bézier patches, one per non-empty knot rectangle, u outermost. Neighbours share their border's
    /// control points bit for bit wherever the surface is continuous across it.
    pub fn bezier_pieces(&self) -> Vec<PatchPiece> {
        let [ku, kv] = &self.knots;
        let [m, n] = self.degree();
        let columns = transpose(&self.points, kv.point_count());
        let columns: Vec<DVec4> =
            columns.chunks_exact(ku.point_count()).flat_map(|line| ku.bezier_points(line)).collect();
        let rows = transpose(&columns, columns.len() / kv.point_count());
        let mut pieces = Vec::new();
        for (su, rows) in ku.spans().zip(rows.chunks_exact((m + 1) * kv.point_count())) {
            let rows: Vec<Vec<DVec4>> =
                rows.chunks_exact(kv.point_count()).map(|line| kv.bezier_points(line)).collect();
            for (k, sv) in kv.spans().enumerate() {
                let points = rows.iter().flat_map(|row| &row[k * (n + 1)..(k + 1) * (n + 1)]).copied().collect();
                let patch = BezierPatch::from_points([m, n], points);
                pieces.push(PatchPiece { patch, domain: [ku.interval(su), kv.interval(sv)] });
            }
        }
        pieces
    }
}

/// Rows of `width` points as columns.
fn transpose(points: &[DVec4], width: usize) -> Vec<DVec4> {
    let height = points.len() / width;
    (0..width).flat_map(|j| (0..height).map(move |i| points[i * width + j])).collect()
}
