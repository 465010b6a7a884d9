//! Rational Bézier patches: evaluation, derivatives, subdivision.

use super::GeometryError;
use glam::{DAffine3, DVec3, DVec4};

/// Largest degree in one direction; binomial sums stay well inside f64 there.
pub const MAX_DEGREE: usize = 63;

/// Points in a line up to which scratch space is small, fits of degree 8 among them: clearing room for the highest degree
/// costs more than a cubic.
pub(super) const FEW: usize = 9;

/// A borrowed control net of a rational tensor-product Bézier patch over [0, 1]².
#[derive(Clone, Copy, Debug)]
pub struct Net<'a> {
    degree: [usize; 2],
    points: &'a [DVec4],
}

/// An owned control net of a rational tensor-product Bézier patch over [0, 1]².
#[derive(Clone, Debug, PartialEq)]
pub struct BezierPatch {
    degree: [usize; 2],
    points: Vec<DVec4>,
}

/// A homogeneous point with its first partial derivatives.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Jet {
    pub point: DVec4,
    pub du: DVec4,
    pub dv: DVec4,
}

/// A point of the surface with its first partial derivatives, in space.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SurfacePoint {
    pub position: DVec3,
    pub du: DVec3,
    pub dv: DVec3,
}

impl Jet {
    /// Division by the weight and the quotient rule.
    pub fn divide(&self) -> SurfacePoint {
        let inv = 1.0 / self.point.w;
        let position = self.point.truncate() * inv;
        let quotient = |d: DVec4| (d.truncate() - position * d.w) * inv;
        SurfacePoint { position, du: quotient(self.du), dv: quotient(self.dv) }
    }
}

/// One step of de Casteljau with stride: `points[base + k*stride]`, `count` of them, at parameter `t`.
fn casteljau_levels(column: &mut [DVec4], t: f64) {
    let n = column.len();
    for level in 1..n {
        for k in 0..n - level {
            column[k] = column[k] * (1.0 - t) + column[k + 1] * t;
        }
    }
}

/// Point and derivative of a Bézier curve by de Casteljau; `column` is overwritten.
pub(super) fn casteljau(column: &mut [DVec4], t: f64) -> (DVec4, DVec4) {
    let degree = column.len() - 1;
    if degree == 0 {
        return (column[0], DVec4::ZERO);
    }
    for level in 1..degree {
        for k in 0..=degree - level {
            column[k] = column[k] * (1.0 - t) + column[k + 1] * t;
        }
    }
    let derivative = (column[1] - column[0]) * degree as f64;
    (column[0] * (1.0 - t) + column[1] * t, derivative)
}

/// Replaces a Bézier curve by its part over `[a, b]`: point k is the blossom at (a, ..., a, b, ..., b) with k times b,
/// so that neighbouring parts share their common point bit for bit.
pub(super) fn restrict_line(line: &mut [DVec4], a: f64, b: f64) {
    if line.len() <= FEW { restrict_in::<FEW>(line, a, b) } else { restrict_in::<{ MAX_DEGREE + 1 }>(line, a, b) }
}

fn restrict_in<const N: usize>(line: &mut [DVec4], a: f64, b: f64) {
    let degree = line.len() - 1;
    let (mut source, mut column) = ([DVec4::ZERO; N], [DVec4::ZERO; N]);
    source[..=degree].copy_from_slice(line);
    for (k, out) in line.iter_mut().enumerate() {
        column[..=degree].copy_from_slice(&source[..=degree]);
        for level in 1..=degree {
            let t = if level <= k { b } else { a };
            for i in 0..=degree - level {
                column[i] = column[i] * (1.0 - t) + column[i + 1] * t;
            }
        }
        *out = column[0];
    }
}

/// The control points of the same Bézier curve at a higher degree.
pub(super) fn elevate_line(line: &[DVec4], degree: usize) -> Vec<DVec4> {
    assert!((line.len() - 1..=MAX_DEGREE).contains(&degree), "degree elevation to {degree}");
    let mut points = line.to_vec();
    for count in line.len()..=degree {
        points.push(points[count - 1]);
        for k in (1..count).rev() {
            let s = k as f64 / count as f64;
            points[k] = points[k - 1] * s + points[k] * (1.0 - s);
        }
    }
    points
}

impl<'a> Net<'a> {
    /// A view of `points`; `points.len()` must be `(degree_u + 1) (degree_v + 1)`.
    pub fn new(degree: [usize; 2], points: &'a [DVec4]) -> Self {
        assert_eq!(points.len(), (degree[0] + 1) * (degree[1] + 1), "control net size");
        Self { degree, points }
    }

    pub fn degree(&self) -> [usize; 2] {
        self.degree
    }

    pub fn points(&self) -> &'a [DVec4] {
        self.points
    }

    pub fn point(&self, i: usize, j: usize) -> DVec4 {
        self.points[i * (self.degree[1] + 1) + j]
    }

    /// True where the weights differ by more than rounding.
    pub fn is_rational(&self) -> bool {
        let w0 = self.points[0].w;
        self.points.iter().any(|p| (p.w - w0).abs() > 1e-14 * w0.abs())
    }

    /// Homogeneous point and first derivatives at (u, v) in [0, 1]², by de Casteljau.
    ///
    /// With m and n the degrees, e = 2^-53 and P the largest control coordinate in that component, the point is within
    /// 3 (m + n) e P of the exact one and `du` within 2 m (3 (m + n) + 2) e P (`dv` likewise), to first order in e:
    /// every level is a convex combination with three roundings.
    pub fn jet(&self, u: f64, v: f64) -> Jet {
        let few = self.degree.iter().all(|&degree| degree < FEW);
        if few { self.jet_in::<FEW>(u, v) } else { self.jet_in::<{ MAX_DEGREE + 1 }>(u, v) }
    }

    fn jet_in<const N: usize>(&self, u: f64, v: f64) -> Jet {
        let [m, n] = self.degree;
        let mut row = [DVec4::ZERO; N];
        let mut along_u = [DVec4::ZERO; N];
        let mut along_u_dv = [DVec4::ZERO; N];
        for i in 0..=m {
            row[..=n].copy_from_slice(&self.points[i * (n + 1)..(i + 1) * (n + 1)]);
            (along_u[i], along_u_dv[i]) = casteljau(&mut row[..=n], v);
        }
        casteljau_levels(&mut along_u_dv[..=m], u);
        let (point, du) = casteljau(&mut along_u[..=m], u);
        Jet { point, du, dv: along_u_dv[0] }
    }

    /// Position and first derivatives in space at (u, v).
    pub fn surface_point(&self, u: f64, v: f64) -> SurfacePoint {
        self.jet(u, v).divide()
    }

    /// Position at (u, v).
    pub fn position(&self, u: f64, v: f64) -> DVec3 {
        let p = self.jet(u, v).point;
        p.truncate() / p.w
    }

    /// The control net in space (weights divided out).
    pub fn hull(&self) -> impl Iterator<Item = DVec3> + use<'a> {
        self.points.iter().map(|p| p.truncate() / p.w)
    }

    /// The two halves on either side of parameter `t` along `axis` (0: u, 1: v), by de Casteljau.
    pub fn split(&self, axis: usize, t: f64) -> [BezierPatch; 2] {
        let [m, n] = self.degree;
        let (count, stride, lines, line_stride) =
            if axis == 0 { (m + 1, n + 1, n + 1, 1) } else { (n + 1, 1, m + 1, n + 1) };
        let mut low = self.points.to_vec();
        let mut high = self.points.to_vec();
        for line in 0..lines {
            let at = |k: usize| line * line_stride + k * stride;
            for level in 1..count {
                for k in 0..count - level {
                    high[at(k)] = high[at(k)] * (1.0 - t) + high[at(k + 1)] * t;
                }
                low[at(level)] = high[at(0)];
            }
        }
        [low, high].map(|points| BezierPatch { degree: self.degree, points })
    }

    /// The part over `[[u0, u1], [v0, v1]]` as a patch over [0, 1]². Parts that meet along a line of constant u or v and
    /// have the same range along it share their border's control points bit for bit.
    pub fn restrict(&self, [[u0, u1], [v0, v1]]: [[f64; 2]; 2]) -> BezierPatch {
        let [m, n] = self.degree;
        let mut points = self.points.to_vec();
        let mut column = [DVec4::ZERO; MAX_DEGREE + 1];
        for j in 0..=n {
            (0..=m).for_each(|i| column[i] = points[i * (n + 1) + j]);
            restrict_line(&mut column[..=m], u0, u1);
            (0..=m).for_each(|i| points[i * (n + 1) + j] = column[i]);
        }
        points.chunks_exact_mut(n + 1).for_each(|row| restrict_line(row, v0, v1));
        BezierPatch { degree: self.degree, points }
    }

    /// The same patch with `degree`, at least its own and at most [`MAX_DEGREE`] in each direction.
    pub fn elevate(&self, degree: [usize; 2]) -> BezierPatch {
        let rows = self.points.chunks_exact(self.degree[1] + 1).flat_map(|row| elevate_line(row, degree[1]));
        let wide = BezierPatch { degree: [self.degree[0], degree[1]], points: rows.collect() }.swapped();
        let columns = wide.points.chunks_exact(self.degree[0] + 1).flat_map(|column| elevate_line(column, degree[0]));
        BezierPatch { degree: [degree[1], degree[0]], points: columns.collect() }.swapped()
    }

    pub fn to_patch(&self) -> BezierPatch {
        BezierPatch { degree: self.degree, points: self.points.to_vec() }
    }
}

impl BezierPatch {
    /// A checked patch; `what` names it in the error.
    pub fn new(what: &str, degree: [usize; 2], points: Vec<DVec4>) -> Result<Self, GeometryError> {
        for d in degree {
            if !(1..=MAX_DEGREE).contains(&d) {
                return Err(GeometryError::BadDegree { what: what.into(), degree: d, max: MAX_DEGREE });
            }
        }
        let expected = (degree[0] + 1) * (degree[1] + 1);
        if points.len() != expected {
            return Err(GeometryError::PointCount { what: what.into(), expected, found: points.len() });
        }
        check_points(what, &points)?;
        Ok(Self { degree, points })
    }

    /// For points known to be good.
    pub(crate) fn from_points(degree: [usize; 2], points: Vec<DVec4>) -> Self {
        debug_assert_eq!(points.len(), (degree[0] + 1) * (degree[1] + 1));
        Self { degree, points }
    }

    /// The patch with u and v exchanged; its normal `S_u x S_v` turns round.
    pub fn swapped(&self) -> Self {
        let [m, n] = self.degree;
        let points = (0..=n).flat_map(|j| (0..=m).map(move |i| self.points[i * (n + 1) + j])).collect();
        Self { degree: [n, m], points }
    }

    /// The patch moved by an affine map.
    pub fn transformed(&self, map: &DAffine3) -> Self {
        let points = self.points.iter().map(|p| (map.matrix3 * p.truncate() + map.translation * p.w).extend(p.w));
        Self { degree: self.degree, points: points.collect() }
    }

    pub fn net(&self) -> Net<'_> {
        Net { degree: self.degree, points: &self.points }
    }

    pub fn degree(&self) -> [usize; 2] {
        self.degree
    }

    pub fn points(&self) -> &[DVec4] {
        &self.points
    }

    pub fn points_mut(&mut self) -> &mut [DVec4] {
        &mut self.points
    }
}

/// Finite coordinates, positive finite weights.
pub(super) fn check_points(what: &str, points: &[DVec4]) -> Result<(), GeometryError> {
    for (index, p) in points.iter().enumerate() {
        if !(p.w > 0.0 && p.w.is_finite()) {
            return Err(GeometryError::BadWeight { what: what.into(), index, value: p.w });
        }
        if !p.truncate().is_finite() {
            return Err(GeometryError::PointNotFinite { what: what.into(), index });
        }
    }
    Ok(())
}
