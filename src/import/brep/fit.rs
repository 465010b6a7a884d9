//! Paths as rational Bézier curves in the parameter plane of the patches.

use super::Scale;
use super::cover::Rectangle;
use super::section::{Section, plane_of};
use super::trace::{Path, Shape, Source};
use crate::geometry::interpolate::{FIT_DEGREE, coefficients, node, value};
use crate::geometry::{Axis, BezierCurve, Chart, CurveForm, CurveSpan, SurfaceForm};
use crate::model::{Approximation, SurfacePatch, TrimCurve};
use glam::{DVec2, DVec4};

/// A section is halved at most this often, and an edge becomes at most this many curves; what is off then is stated. An
/// edge off its surface has kinks in its projection where the surface's curvature jumps: only halving gets near those.
const MAX_HALVINGS: usize = 24;
const MAX_CURVES: usize = 256;

/// Makes trim curves of paths.
pub(super) struct Fitter<'b> {
    pub chart: &'b Chart,
    axes: [Axis; 2],
    patches: &'b [SurfacePatch],
    pub scale: &'b Scale,
    pub approximation: Approximation,
    /// Largest distance in space of a fit from the exact image that was left.
    pub worst: f64,
    /// How many curves there were before those of the present path.
    first: usize,
}

impl<'b> Fitter<'b> {
    /// For curves on `patches`, which cover `area`.
    pub fn new(chart: &'b Chart, area: Rectangle, patches: &'b [SurfacePatch], scale: &'b Scale) -> Self {
        let approximation = Approximation::default();
        Self { chart, axes: chart.axes(area), patches, scale, approximation, worst: 0.0, first: 0 }
    }

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
                let gap = source.map_or(0.0, |source| self.gap(curve, source, source.range));
                out.push(TrimCurve { curve: curve.clone(), gap, edge: source.map(|s| s.edge) });
            }
            (Shape::Traced(samples), Some(source)) => self.traced(path, samples, source, out),
            _ => self.straight(path, out),
        }
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
        self.first = out.len();
        for part in breaks.windows(2) {
            self.fit(&image, [part[0].0, part[1].0], [part[0].1, part[1].1], 0, out);
        }
    }

    fn fit(&mut self, image: &Image, [a, b]: [f64; 2], ends: [DVec2; 2], depth: usize, out: &mut Vec<TrimCurve>) {
        let at = |s: f64, guess: Option<DVec2>| image.plane(self, a + (b - a) * s, guess);
        let mut values = [ends[0]; FIT_DEGREE + 1];
        values[FIT_DEGREE] = ends[1];
        (2..FIT_DEGREE).step_by(2).for_each(|k| values[k] = at(node(k, FIT_DEGREE), None));
        let quartic = coefficients(values.iter().step_by(2).copied());
        let guess = |k: usize| Some(value(&quartic, node(k, FIT_DEGREE)));
        (1..FIT_DEGREE).step_by(2).for_each(|k| values[k] = at(node(k, FIT_DEGREE), guess(k)));
        let speeds = [0, FIT_DEGREE / 2, FIT_DEGREE].map(|k| self.speed(values[k]));
        let speed = speeds[0].max(speeds[1]).max(speeds[2]);
        let size = |d: DVec2| (d * speed).length();
        let chord = (ends[1] - ends[0]) * speed;
        let lateral = |p: DVec2| ((p - ends[0]) * speed).perp_dot(chord).abs() / chord.length().max(1e-300);
        let forward = values.windows(2).all(|w| ((w[1] - w[0]) * speed).dot(chord) >= 0.0);
        let tolerance = self.scale.fine;
        let bend = values[1..FIT_DEGREE].iter().map(|&p| lateral(p)).fold(0.0, f64::max);
        let points = if forward && bend <= tolerance {
            self.note(bend);
            vec![ends[0], ends[1]]
        } else if let Some((curve, off)) = self.section(image.source.span, [a, b], &values, speed) {
            self.note(off);
            let gap = self.gap(&curve, image.source, [a, b]);
            out.push(TrimCurve { curve, gap, edge: Some(image.source.edge) });
            return;
        } else {
            let odd = (1..FIT_DEGREE).step_by(2);
            let off = odd.map(|k| size(value(&quartic, node(k, FIT_DEGREE)) - values[k])).fold(0.0, f64::max);
            if off <= tolerance {
                self.note(off);
                quartic
            } else {
                let octic = coefficients(values.iter().copied());
                let between = (0..FIT_DEGREE).map(|k| node(2 * k + 1, 2 * FIT_DEGREE));
                let off = between.map(|s| (value(&octic, s), s));
                let off = off.map(|(p, s)| size(p - at(s, Some(p)))).fold(0.0, f64::max);
                if off > tolerance && depth < MAX_HALVINGS && out.len() - self.first < MAX_CURVES {
                    let middle = 0.5 * (a + b);
                    let p = values[FIT_DEGREE / 2];
                    self.fit(image, [a, middle], [ends[0], p], depth + 1, out);
                    self.fit(image, [middle, b], [p, ends[1]], depth + 1, out);
                    return;
                }
                if off > tolerance {
                    self.worst = self.worst.max(off);
                }
                self.note(off);
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

    /// Counts a curve that is off by so much; what is no more than rounding is no approximation.
    fn note(&mut self, off: f64) {
        if off > 1e-3 * self.scale.fine {
            self.approximation.curves += 1;
            self.approximation.error = self.approximation.error.max(off);
        }
    }

    /// The exact image where the edge is a plane section of a ruled patch, and how far it is from the image's points.
    fn section(&self, span: &CurveSpan, range: [f64; 2], values: &[DVec2], speed: DVec2) -> Option<(BezierCurve, f64)> {
        let ends = [values[0], values[values.len() - 1]];
        let section = Section::new(self.patches, plane_of(span, range)?, ends)?;
        let off = section.distance(values, speed);
        let curve = (off <= self.scale.fine).then(|| section.curve(ends)).flatten()?;
        Some((curve, off))
    }

    /// Lengths of the surface's derivatives at a point of the plane, by the plane's coordinates to within a factor 2.
    fn speed(&self, p: DVec2) -> DVec2 {
        let point = self.chart.surface_point(self.to_surface(p));
        DVec2::new(point.du.length(), point.dv.length())
    }

    /// Largest distance of the image of `curve` from the edge, at 9 parameters; `range` is the edge's part next to it.
    fn gap(&self, curve: &BezierCurve, source: Source, range: [f64; 2]) -> f64 {
        let straight = matches!(self.chart.form(), SurfaceForm::Plane(_)) && curve.degree() == 1;
        // The difference of two straight lines is largest at an end.
        let count = if straight && matches!(source.span.curve, CurveForm::Line { .. }) { 1 } else { 8 };
        let at = |k: u32| {
            let s = f64::from(k) / f64::from(count);
            let x = self.chart.position(self.to_surface(curve.position(s).truncate()));
            let found = source.span.nearest(x, range[0] + (range[1] - range[0]) * s).1;
            // The image may run along the edge at quite another pace.
            if found > self.scale.accept { found.min(source.span.nearest_of_all(x).1) } else { found }
        };
        (0..=count).map(at).fold(0.0, f64::max)
    }
}

/// The exact image of an edge, as a function of the edge's parameter.
struct Image<'a, 'b> {
    path: &'b Path<'a>,
    samples: &'b [(f64, DVec2)],
    source: Source<'a>,
    plane_ends: [DVec2; 2],
    /// How far joining moved the ends.
    moved: [DVec2; 2],
}

impl<'a, 'b> Image<'a, 'b> {
    fn new(fitter: &Fitter, path: &'b Path<'a>, samples: &'b [(f64, DVec2)], source: Source<'a>) -> Self {
        let ends = [path.start, path.end];
        let moved = [path.start - samples[0].1, path.end - samples[samples.len() - 1].1];
        let plane_ends = ends.map(|uv| fitter.to_plane(uv));
        Self { path, samples, source, plane_ends, moved }
    }

    /// Surface parameters at `t`; the inversion starts from the samples on either side, or from a guess that is not far
    /// from them.
    fn surface(&self, fitter: &Fitter, t: f64, guess: Option<DVec2>) -> DVec2 {
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
        let between = low.1.lerp(high.1, ((t - low.0) / (high.0 - low.0)).clamp(0.0, 1.0));
        let moved = self.moved[0].lerp(self.moved[1], (t - a) / (b - a));
        let guess = guess.map(|p| fitter.to_surface(p) - moved);
        let near = guess.filter(|uv| uv.distance(between) <= low.1.distance(high.1)).unwrap_or(between);
        fitter.chart.invert(self.source.span.curve.position(t), Some(near), fitter.scale.follow) + moved
    }

    fn plane(&self, fitter: &Fitter, t: f64, guess: Option<DVec2>) -> DVec2 {
        fitter.to_plane(self.surface(fitter, t, guess))
    }

    /// Edge parameters and points between which the image is smooth in the plane: the edge's own knots, and where it
    /// crosses from one patch's arc to the next.
    fn breaks(&self, fitter: &Fitter) -> Vec<(f64, DVec2)> {
        let [a, b] = self.source.range;
        let inside = |t: f64| (t - a) * (t - b) < 0.0;
        let mut breaks = vec![(a, self.plane_ends[0])];
        let knots = self.source.span.breaks();
        let mut inner: Vec<(f64, DVec2)> =
            knots.into_iter().filter(|&t| inside(t)).map(|t| (t, self.plane(fitter, t, None))).collect();
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
        let low = self.surface(fitter, a, None)[axis] < kink;
        if (self.surface(fitter, b, None)[axis] < kink) == low {
            return None;
        }
        for _ in 0..60 {
            let t = 0.5 * (a + b);
            if t == a || t == b {
                break;
            }
            if (self.surface(fitter, t, None)[axis] < kink) == low { a = t } else { b = t }
        }
        let [start, end] = self.source.range;
        let t = 0.5 * (a + b);
        if ((t - start) / (end - start)).min((end - t) / (end - start)) < 1e-9 {
            return None;
        }
        let mut uv = self.surface(fitter, t, None);
        uv[axis] = kink;
        Some((t, fitter.to_plane(uv)))
    }
}
