//! Knot vectors and the blossom, from which all B-spline algorithms here follow.
//!
//! Ramshaw, "Blossoms are polar forms", 1989; Piegl & Tiller, "The NURBS Book", chapters 2 and 5.

use super::{GeometryError, MAX_DEGREE};
use glam::DVec4;

/// A checked knot vector of `point_count + degree + 1` finite, non-decreasing values.
///
/// Unclamped vectors and multiplicities above the degree are fine; the domain is `[knots[degree], knots[point_count]]`.
#[derive(Clone, Debug, PartialEq)]
pub struct Knots {
    degree: usize,
    values: Vec<f64>,
}

impl Knots {
    /// Checks `values` for `point_count` control points; `what` names the curve or surface in errors.
    pub fn new(what: &str, degree: usize, point_count: usize, values: Vec<f64>) -> Result<Self, GeometryError> {
        check_degree(what, degree)?;
        let what = || what.to_string();
        if point_count <= degree {
            return Err(GeometryError::PointCount { what: what(), expected: degree + 1, found: point_count });
        }
        let expected = point_count + degree + 1;
        if values.len() != expected {
            return Err(GeometryError::KnotCount { what: what(), expected, found: values.len() });
        }
        if let Some(index) = values.iter().position(|t| !t.is_finite()) {
            return Err(GeometryError::KnotNotFinite { what: what(), index });
        }
        if let Some(k) = values.windows(2).position(|t| t[1] < t[0]) {
            let [before, value] = [values[k], values[k + 1]];
            return Err(GeometryError::DecreasingKnots { what: what(), index: k + 1, before, value });
        }
        if values[degree] == values[point_count] {
            return Err(GeometryError::EmptyDomain { what: what(), value: values[degree] });
        }
        if !(values[expected - 1] - values[0]).is_finite() {
            return Err(GeometryError::BadShape { what: what(), reason: "the knots' range overflows".into() });
        }
        Ok(Self { degree, values })
    }

    /// The full vector of a periodic B-spline from the knots `t_0..t_n` of one period (`n` control points, to be
    /// wrapped: point `k` is point `k mod n`, `n + degree` in all). The domain is `[t_0, t_n]`.
    pub fn periodic(what: &str, degree: usize, period: &[f64]) -> Result<Self, GeometryError> {
        check_degree(what, degree)?;
        let n = period.len().saturating_sub(1);
        if n == 0 {
            return Err(GeometryError::KnotCount { what: what.into(), expected: 2, found: period.len() });
        }
        let length = period[n] - period[0];
        let values = (0..=n + 2 * degree).map(|k| {
            let k = k as isize - degree as isize;
            let turn = k.div_euclid(n as isize);
            // The last knot of the domain is t_n itself, not t_0 and a period.
            if k == n as isize { period[n] } else { period[k.rem_euclid(n as isize) as usize] + turn as f64 * length }
        });
        Self::new(what, degree, n + degree, values.collect())
    }

    pub fn degree(&self) -> usize {
        self.degree
    }

    pub fn values(&self) -> &[f64] {
        &self.values
    }

    /// Number of control points that go with these knots.
    pub fn point_count(&self) -> usize {
        self.values.len() - self.degree - 1
    }

    /// `[t0, t1]` with `t0 < t1`.
    pub fn domain(&self) -> [f64; 2] {
        [self.values[self.degree], self.values[self.point_count()]]
    }

    /// The non-empty intervals of the domain, each as the index of its left knot.
    pub fn spans(&self) -> impl Iterator<Item = usize> + '_ {
        (self.degree..self.point_count()).filter(|&s| self.values[s] < self.values[s + 1])
    }

    /// `[knots[span], knots[span + 1]]`.
    pub fn interval(&self, span: usize) -> [f64; 2] {
        [self.values[span], self.values[span + 1]]
    }

    /// The non-empty span that holds `t` (its left end included; at the end of the domain the last one).
    /// Values outside the domain get the first or last span.
    pub fn span(&self, t: f64) -> usize {
        let inside = &self.values[self.degree..self.point_count()];
        let span = self.degree + inside.partition_point(|&k| k <= t).max(1) - 1;
        // Step over empty spans: right at the start of the domain, left elsewhere.
        let full = |&s: &usize| self.values[s] < self.values[s + 1];
        (self.degree..=span).rev().find(full).or_else(|| self.spans().next()).unwrap_or(span)
    }

    /// One level of the blossom on the `degree + 1` control points of `span`; `level` counts from 1.
    fn blossom_level(&self, local: &mut [DVec4], span: usize, level: usize, t: f64) {
        for k in 0..=self.degree - level {
            let i = span + level + k - self.degree;
            let [low, high] = [self.values[i], self.values[span + 1 + k]];
            let s = (t - low) / (high - low);
            local[k] = local[k] * (1.0 - s) + local[k + 1] * s;
        }
    }

    /// Weights of the `degree + 1` control points of `span` in the point at `t` and in its derivative; `N` must be more
    /// than the degree.
    ///
    /// De Boor's triangle from its top: each step splits a weight in two convex parts. Backward stable for `t` inside the
    /// span, and exact at its ends.
    pub fn weights<const N: usize>(&self, span: usize, t: f64) -> [[f64; N]; 2] {
        let p = self.degree;
        let knot = |k: usize| self.values[span + k - p];
        // Of the points after the first level: the control points of the derivative have the same weights.
        let mut lower = [0.0; N];
        lower[0] = 1.0;
        for level in (2..=p).rev() {
            for k in (0..=p - level).rev() {
                let [low, high] = [knot(level + k), knot(p + 1 + k)];
                let s = (t - low) / (high - low);
                lower[k + 1] += lower[k] * s;
                lower[k] *= 1.0 - s;
            }
        }
        let (mut point, mut slope) = ([0.0; N], [0.0; N]);
        for k in 0..p {
            let [low, high] = [knot(1 + k), knot(p + 1 + k)];
            let inverse = 1.0 / (high - low);
            let s = (t - low) / (high - low);
            point[k] += lower[k] * (1.0 - s);
            point[k + 1] = lower[k] * s;
            let change = lower[k] * (p as f64 * inverse);
            slope[k] -= change;
            slope[k + 1] = change;
        }
        [point, slope]
    }

    /// The Bézier points of all spans of one line of control points, `degree + 1` for each, one span after the other.
    ///
    /// Point k over [a, b] is the blossom at (a, ..., a, b, ..., b) with k times b. All combinations are convex. Where
    /// neighbours meet (multiplicity up to the degree) they share the point bit for bit.
    pub fn bezier_points(&self, line: &[DVec4]) -> Vec<DVec4> {
        let p = self.degree;
        let mut points: Vec<DVec4> = Vec::with_capacity(self.spans().count() * (p + 1));
        let mut local = line[..=p].to_vec();
        let mut before = None;
        for span in self.spans() {
            let [a, b] = self.interval(span);
            for k in 0..=p {
                local.copy_from_slice(&line[span - p..=span]);
                for level in 1..=p {
                    self.blossom_level(&mut local, span, level, if level <= k { b } else { a });
                }
                points.push(local[0]);
            }
            if before.is_some_and(|s| span - s <= p) {
                let first = points.len() - p - 1;
                points[first] = points[first - 1];
            }
            before = Some(span);
        }
        points
    }

    /// These knots with `t` inserted once, and the span it went into; `None` where `t` is outside the domain or its
    /// multiplicity is `degree + 1` already.
    pub(super) fn inserted(&self, t: f64) -> Option<(Self, usize)> {
        let [low, high] = self.domain();
        let multiplicity = self.values.iter().filter(|&&k| k == t).count();
        if !(low <= t && t <= high) || multiplicity > self.degree {
            return None;
        }
        let span = self.span(t);
        let mut values = self.values.clone();
        values.insert(span + 1, t);
        Some((Self { degree: self.degree, values }, span))
    }

    /// The control points of one line after `t` was inserted into `span` (Boehm 1980).
    pub(super) fn insert_into_line(&self, line: &[DVec4], span: usize, t: f64) -> Vec<DVec4> {
        let p = self.degree;
        let point = |i: usize| {
            if i <= span - p {
                return line[i];
            }
            if i > span {
                return line[i - 1];
            }
            let [low, high] = [self.values[i], self.values[i + p]];
            let s = (t - low) / (high - low);
            line[i - 1] * (1.0 - s) + line[i] * s
        };
        (0..=line.len()).map(point).collect()
    }
}

fn check_degree(what: &str, degree: usize) -> Result<(), GeometryError> {
    if (1..=MAX_DEGREE).contains(&degree) {
        return Ok(());
    }
    Err(GeometryError::BadDegree { what: what.into(), degree, max: MAX_DEGREE })
}
