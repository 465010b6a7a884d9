//! Paths as rational Bézier curves in the parameter plane of the patches.

use super::Scale;
use super::trace::{Path, Shape, Source};
use crate::geometry::{Axis, BezierCurve, Chart};
use crate::model::TrimCurve;
use glam::{DVec2, DVec4};
use std::f64::consts::PI;
use std::sync::LazyLock;

/// A section is halved at most this often; what is off then shows in the measured gap.
const MAX_HALVINGS: usize = 8;

/// Degree 8, and 4 on every other node.
const DEGREE: usize = 8;

/// Chebyshev-Lobatto nodes on [0, 1]; those of degree 4 are every other one.
static NODES: LazyLock<[f64; DEGREE + 1]> = LazyLock::new(|| std::array::from_fn(|k| node(k, DEGREE)));

/// From values at the nodes to Bernstein coefficients, degree 4 and 8, row by row.
static TO_BERNSTEIN: LazyLock<[Vec<f64>; 2]> = LazyLock::new(|| [inverse(4), inverse(8)]);

fn node(k: usize, degree: usize) -> f64 {
    0.5 - 0.5 * (PI * k as f64 / degree as f64).cos()
}

/// Bernstein polynomials of `degree` at `t`.
fn bernstein(degree: usize, t: f64) -> Vec<f64> {
    let mut values = vec![1.0];
    for _ in 0..degree {
        let mut next = vec![0.0; values.len() + 1];
        for (k, value) in values.iter().enumerate() {
            next[k] += value * (1.0 - t);
            next[k + 1] += value * t;
        }
        values = next;
    }
    values
}

/// The inverse of the matrix of Bernstein values at the nodes, by Gauss-Jordan with pivoting.
fn inverse(degree: usize) -> Vec<f64> {
    let n = degree + 1;
    let mut rows: Vec<Vec<f64>> = (0..n)
        .map(|k| {
            let mut row = bernstein(degree, node(k, degree));
            row.extend((0..n).map(|j| f64::from(u8::from(j == k))));
            row
        })
        .collect();
    for c in 0..n {
        let pivot = (c..n).max_by(|&a, &b| rows[a][c].abs().total_cmp(&rows[b][c].abs())).unwrap_or(c);
        rows.swap(c, pivot);
        let scale = 1.0 / rows[c][c];
        rows[c].iter_mut().for_each(|x| *x *= scale);
        let row = rows[c].clone();
        for other in (0..n).filter(|&k| k != c) {
            let factor = rows[other][c];
            rows[other].iter_mut().zip(&row).for_each(|(x, r)| *x -= factor * r);
        }
    }
    rows.into_iter().flat_map(|row| row[n..].to_vec()).collect()
}

/// Makes trim curves of paths.
pub(super) struct Fitter<'b> {
    pub chart: &'b Chart,
    pub axes: [Axis; 2],
    pub scale: &'b Scale,
    /// Largest distance in space of a fit from the exact image that was left.
    pub worst: f64,
}

impl Fitter<'_> {
    fn to_plane(&self, uv: DVec2) -> DVec2 {
        DVec2::new(self.axes[0].to_plane(uv.x), self.axes[1].to_plane(uv.y))
    }

    fn to_surface(&self, p: DVec2) -> DVec2 {
        DVec2::new(self.axes[0].to_surface(p.x), self.axes[1].to_surface(p.y))
    }

    /// The path's trim curves, end to end.
    pub fn curves(&mut self, path: &Path, out: &mut Vec<TrimCurve>) {
        match (&path.shape, path.source) {
            (Shape::Exact(curve), source) => {
                let gap = self.exact_gap(curve, source);
                out.push(TrimCurve { curve: curve.clone(), gap, edge: source.map(|s| s.edge) });
            }
            (Shape::Traced(samples), Some(source)) => self.traced(path, samples, source, out),
            _ => self.straight(path, out),
        }
    }

    /// Distance between an image on a plane and its edge: both are in the hull of their control points' differences.
    fn exact_gap(&self, curve: &BezierCurve, source: Option<Source>) -> f64 {
        let Some(source) = source else { return 0.0 };
        self.gap(curve, source, source.range)
    }

    fn straight(&self, path: &Path, out: &mut Vec<TrimCurve>) {
        // Part of the way, and where that is.
        let mut stops = vec![(0.0, path.start)];
        if let Some(fixed) = path.fixed_axis() {
            let [a, b] = [path.start[1 - fixed], path.end[1 - fixed]];
            for kink in self.axes[1 - fixed].kinks() {
                let part = (kink - a) / (b - a);
                if part > 1e-12 && part < 1.0 - 1e-12 {
                    let mut uv = path.start;
                    uv[1 - fixed] = kink;
                    stops.push((part, uv));
                }
            }
            stops.sort_by(|p, q| p.0.total_cmp(&q.0));
        }
        stops.push((1.0, path.end));
        for part in stops.windows(2) {
            let [a, b] = [part[0].1, part[1].1].map(|uv| self.to_plane(uv));
            if a == b {
                continue;
            }
            let curve = BezierCurve::line(a.extend(0.0), b.extend(0.0));
            let gap = path.source.map_or(0.0, |source| {
                let [t0, t1] = source.range;
                self.gap(&curve, source, [part[0].0, part[1].0].map(|s| t0 + (t1 - t0) * s))
            });
            out.push(TrimCurve { curve, gap, edge: path.source.map(|s| s.edge) });
        }
    }

    fn traced(&mut self, path: &Path, samples: &[(f64, DVec2)], source: Source, out: &mut Vec<TrimCurve>) {
        let image = Image::new(self, path, samples, source);
        let breaks = image.breaks(self);
        let first = out.len();
        for part in breaks.windows(2) {
            self.fit(&image, [part[0].0, part[1].0], [part[0].1, part[1].1], 0, out);
        }
        // The ends of consecutive pieces are the same points; the path's own ends are those of its neighbours.
        debug_assert!(out.len() > first);
    }

    fn fit(&mut self, image: &Image, [a, b]: [f64; 2], ends: [DVec2; 2], depth: usize, out: &mut Vec<TrimCurve>) {
        let at = |s: f64| image.plane(self, a + (b - a) * s);
        let values: [DVec2; DEGREE + 1] = std::array::from_fn(|k| match k {
            0 => ends[0],
            DEGREE => ends[1],
            _ => at(NODES[k]),
        });
        let speeds = [0, DEGREE / 2, DEGREE].map(|k| self.speed(values[k]));
        let speed = speeds[0].max(speeds[1]).max(speeds[2]);
        let size = |d: DVec2| (d * speed).length();
        let chord = (ends[1] - ends[0]) * speed;
        let lateral = |p: DVec2| ((p - ends[0]) * speed).perp_dot(chord).abs() / chord.length().max(1e-300);
        let forward = values.windows(2).all(|w| ((w[1] - w[0]) * speed).dot(chord) >= 0.0);
        let tolerance = self.scale.fine;
        let points = if forward && values[1..DEGREE].iter().all(|&p| lateral(p) <= tolerance) {
            vec![ends[0], ends[1]]
        } else {
            let quartic = coefficients(&TO_BERNSTEIN[0], values.iter().step_by(2).copied());
            let odd = (1..DEGREE).step_by(2);
            let off = odd.map(|k| size(value(&quartic, NODES[k]) - values[k])).fold(0.0, f64::max);
            if off <= tolerance {
                quartic
            } else {
                let octic = coefficients(&TO_BERNSTEIN[1], values.iter().copied());
                let between = (0..DEGREE).map(|k| node(2 * k + 1, 2 * DEGREE));
                let off = between.map(|s| size(value(&octic, s) - at(s))).fold(0.0, f64::max);
                if off > tolerance && depth < MAX_HALVINGS {
                    let middle = 0.5 * (a + b);
                    let p = image.plane(self, middle);
                    self.fit(image, [a, middle], [ends[0], p], depth + 1, out);
                    self.fit(image, [middle, b], [p, ends[1]], depth + 1, out);
                    return;
                }
                self.worst = self.worst.max(off);
                octic
            }
        };
        let last = points.len() - 1;
        let points = points.into_iter().enumerate().map(|(k, p)| match k {
            0 => ends[0],
            _ if k == last => ends[1],
            _ => p,
        });
        let points: Vec<DVec4> = points.map(|p| p.extend(0.0).extend(1.0)).collect();
        let curve = BezierCurve::from_points(points);
        let gap = self.gap(&curve, image.source, [a, b]);
        out.push(TrimCurve { curve, gap, edge: Some(image.source.edge) });
    }

    /// Lengths of the surface's derivatives at a point of the plane, by the plane's coordinates to within a factor 2.
    fn speed(&self, p: DVec2) -> DVec2 {
        let point = self.chart.surface_point(self.to_surface(p));
        DVec2::new(point.du.length(), point.dv.length())
    }

    /// Largest distance of the image of `curve` from the edge, at 9 parameters; `range` is the edge's part next to it.
    fn gap(&self, curve: &BezierCurve, source: Source, range: [f64; 2]) -> f64 {
        let mut gap: f64 = 0.0;
        let (count, span) = (8, source.span);
        let [low, high] = [span.range[0].min(span.range[1]), span.range[0].max(span.range[1])];
        for k in 0..=count {
            let s = f64::from(k) / f64::from(count);
            let x = self.chart.position(self.to_surface(curve.position(s).truncate()));
            let mut t = range[0] + (range[1] - range[0]) * s;
            let mut distance = f64::INFINITY;
            for _ in 0..8 {
                let (p, d) = span.tangent(t);
                let now = p.distance(x);
                if now >= distance {
                    break;
                }
                distance = now;
                let next = (t + (x - p).dot(d) / d.length_squared().max(1e-300)).clamp(low, high);
                if next == t {
                    break;
                }
                t = next;
            }
            gap = gap.max(distance);
        }
        gap
    }
}

fn coefficients(matrix: &[f64], values: impl ExactSizeIterator<Item = DVec2> + Clone) -> Vec<DVec2> {
    let n = values.len();
    matrix.chunks_exact(n).map(|row| row.iter().zip(values.clone()).map(|(m, p)| p * *m).sum()).collect()
}

/// The value of a polynomial in Bernstein form.
fn value(points: &[DVec2], t: f64) -> DVec2 {
    let mut column = [DVec2::ZERO; DEGREE + 1];
    let column = &mut column[..points.len()];
    column.copy_from_slice(points);
    for level in 1..points.len() {
        for k in 0..points.len() - level {
            column[k] = column[k].lerp(column[k + 1], t);
        }
    }
    column[0]
}

/// The exact image of an edge, as a function of the edge's parameter.
struct Image<'a, 'b> {
    path: &'b Path<'a>,
    samples: &'b [(f64, DVec2)],
    source: Source<'a>,
    plane_ends: [DVec2; 2],
    /// How far joining moved the ends.
    moved: [DVec2; 2],
    accept: f64,
}

impl<'a, 'b> Image<'a, 'b> {
    fn new(fitter: &Fitter, path: &'b Path<'a>, samples: &'b [(f64, DVec2)], source: Source<'a>) -> Self {
        let ends = [path.start, path.end];
        let moved = [path.start - samples[0].1, path.end - samples[samples.len() - 1].1];
        let plane_ends = ends.map(|uv| fitter.to_plane(uv));
        let mut image = Self { path, samples, source, plane_ends, moved, accept: fitter.scale.accept };
        image.accept = fitter.scale.accept;
        image
    }

    /// Surface parameters at `t`; the inversion starts from the samples on either side.
    fn surface(&self, fitter: &Fitter, t: f64) -> DVec2 {
        let [a, b] = [self.samples[0].0, self.samples[self.samples.len() - 1].0];
        if t == a {
            return self.path.start;
        }
        if t == b {
            return self.path.end;
        }
        let ascending = b > a;
        let k = self.samples.partition_point(|s| (s.0 <= t) == ascending && s.0 != t || s.0 == a);
        let k = k.clamp(1, self.samples.len() - 1);
        let [low, high] = [self.samples[k - 1], self.samples[k]];
        let near = low.1.lerp(high.1, ((t - low.0) / (high.0 - low.0)).clamp(0.0, 1.0));
        let uv = fitter.chart.invert(self.source.span.curve.position(t), Some(near), self.accept);
        uv + self.moved[0].lerp(self.moved[1], (t - a) / (b - a))
    }

    fn plane(&self, fitter: &Fitter, t: f64) -> DVec2 {
        fitter.to_plane(self.surface(fitter, t))
    }

    /// Edge parameters and points between which the image is smooth in the plane: the edge's own knots, and where it
    /// crosses from one patch's arc to the next.
    fn breaks(&self, fitter: &Fitter) -> Vec<(f64, DVec2)> {
        let [a, b] = self.source.range;
        let inside = |t: f64| (t - a) * (t - b) < 0.0;
        let mut breaks = vec![(a, self.plane_ends[0])];
        let knots = self.source.span.breaks();
        let mut inner: Vec<(f64, DVec2)> =
            knots.into_iter().filter(|&t| inside(t)).map(|t| (t, self.plane(fitter, t))).collect();
        for axis in 0..2 {
            for kink in fitter.axes[axis].kinks() {
                for w in self.samples.windows(2) {
                    if (w[0].1[axis] < kink) != (w[1].1[axis] < kink) {
                        inner.extend(self.crossing(fitter, [w[0].0, w[1].0], axis, kink));
                    }
                }
            }
        }
        inner.sort_by(|p, q| ((p.0 - a) / (b - a)).total_cmp(&((q.0 - a) / (b - a))));
        inner.dedup_by(|p, q| ((p.0 - q.0) / (b - a)).abs() < 1e-9);
        breaks.append(&mut inner);
        breaks.push((b, self.plane_ends[1]));
        breaks
    }

    /// Where the image's parameter `axis` takes the value `kink`, between two edge parameters.
    fn crossing(&self, fitter: &Fitter, [mut a, mut b]: [f64; 2], axis: usize, kink: f64) -> Option<(f64, DVec2)> {
        let low = self.surface(fitter, a)[axis] < kink;
        if (self.surface(fitter, b)[axis] < kink) == low {
            return None;
        }
        for _ in 0..60 {
            let t = 0.5 * (a + b);
            if t == a || t == b {
                break;
            }
            if (self.surface(fitter, t)[axis] < kink) == low { a = t } else { b = t }
        }
        let [start, end] = self.source.range;
        let t = 0.5 * (a + b);
        if ((t - start) / (end - start)).min((end - t) / (end - start)) < 1e-9 {
            return None;
        }
        let mut uv = self.surface(fitter, t);
        uv[axis] = kink;
        Some((t, fitter.to_plane(uv)))
    }
}
