//! Edges in the surface's own parameters.

use super::flat::Flat;
use super::pcurve::file_image;
use super::{EdgeUse, Scale};
use crate::geometry::{BezierCurve, Chart, CurveForm, CurveSpan, Pole, SurfaceForm};
use glam::{DVec2, DVec3, DVec4};

/// Halvings of a parameter interval in which a periodic parameter seems to jump: enough to meet a pole.
const MAX_HALVINGS: usize = 40;

/// A part of an edge in space.
#[derive(Clone, Copy, Debug)]
pub(super) struct Source<'a> {
    pub edge: u32,
    pub span: &'a CurveSpan,
    pub range: [f64; 2],
}

/// A smooth part of a loop in the surface's own parameters.
#[derive(Clone, Debug)]
pub(super) struct Path<'a> {
    pub start: DVec2,
    pub end: DVec2,
    pub shape: Shape,
    /// `None` for what only closes a loop.
    pub source: Option<Source<'a>>,
    /// Where the start and the end lie on a pole.
    pub poles: [Option<Pole>; 2],
}

#[derive(Clone, Debug)]
pub(super) enum Shape {
    /// A straight line, as a rule along one parameter.
    Straight,
    /// The rational image itself, on surfaces whose parameters are those of the plane.
    Exact(BezierCurve),
    /// Curve parameters and where they lie.
    Traced(Vec<(f64, DVec2)>),
}

impl<'a> Path<'a> {
    /// What only closes a loop.
    pub fn bridge(start: DVec2, end: DVec2) -> Self {
        Self { start, end, shape: Shape::Straight, source: None, poles: [None, None] }
    }

    /// The parameter that is constant on a straight path along the other one.
    pub fn fixed_axis(&self) -> Option<usize> {
        if !matches!(self.shape, Shape::Straight) {
            return None;
        }
        [0, 1].into_iter().find(|&axis| self.start[axis] == self.end[axis])
    }

    pub fn shift(&mut self, by: DVec2) {
        if by == DVec2::ZERO {
            return;
        }
        self.start += by;
        self.end += by;
        match &mut self.shape {
            Shape::Straight => {}
            Shape::Exact(curve) => {
                let points = curve.points().iter().map(|p| *p + DVec4::new(by.x * p.w, by.y * p.w, 0.0, 0.0));
                *curve = BezierCurve::from_points(points.collect());
            }
            Shape::Traced(samples) => samples.iter_mut().for_each(|(_, uv)| *uv += by),
        }
    }

    /// The same path run through from its end.
    pub fn reversed(mut self) -> Self {
        std::mem::swap(&mut self.start, &mut self.end);
        self.poles.reverse();
        if let Some(source) = &mut self.source {
            source.range.reverse();
        }
        match &mut self.shape {
            Shape::Straight => {}
            Shape::Exact(curve) => *curve = curve.reversed(),
            Shape::Traced(samples) => samples.reverse(),
        }
        self
    }

    /// A box that holds the path: the control points', or the samples' with room for what bulges out between them.
    pub fn bounds(&self) -> [DVec2; 2] {
        let mut bounds = [self.start.min(self.end), self.start.max(self.end)];
        let mut add = |p: DVec2| bounds = [bounds[0].min(p), bounds[1].max(p)];
        match &self.shape {
            Shape::Straight => {}
            Shape::Exact(curve) => curve.points().iter().for_each(|p| add(p.truncate().truncate() / p.w)),
            Shape::Traced(samples) => {
                for w in samples.windows(3) {
                    // Between samples a curve leaves its chord by an eighth of the second derivative times the step
                    // squared; twice that for safety.
                    let [h, k] = [w[1].0 - w[0].0, w[2].0 - w[1].0];
                    let bend = ((w[2].1 - w[1].1) / k - (w[1].1 - w[0].1) / h) * 2.0 / (h + k);
                    let bulge = bend.abs() * (0.25 * h.abs().max(k.abs()).powi(2));
                    w.iter().for_each(|s| [s.1 - bulge, s.1 + bulge].into_iter().for_each(&mut add));
                }
            }
        }
        bounds
    }

    /// Points along the path, ends included.
    pub fn points(&self) -> impl Iterator<Item = DVec2> + '_ {
        let samples: &[(f64, DVec2)] = if let Shape::Traced(samples) = &self.shape { samples } else { &[] };
        let curve = if let Shape::Exact(curve) = &self.shape { Some(curve) } else { None };
        let count = curve.map_or(0, |curve| if curve.degree() == 1 { 0 } else { 8 });
        let inner = (1..count).filter_map(move |k| Some(curve?.position(f64::from(k) / f64::from(count)).truncate()));
        let inner = inner.chain(samples.iter().skip(1).map(|s| s.1).take(samples.len().saturating_sub(2)));
        std::iter::once(self.start).chain(inner).chain(std::iter::once(self.end))
    }
}

/// The same curve with both end weights 1, so that its ends are its end points bit for bit (Farin, "Curves and Surfaces
/// for CAGD", 5th ed., section 13.4: multiplying weights by a geometric sequence changes the parameter only).
pub(super) fn standard(points: &mut [DVec4]) {
    let [first, last] = [points[0].w, points[points.len() - 1].w];
    if first == 1.0 && last == 1.0 {
        return;
    }
    let degree = (points.len() - 1) as f64;
    let ratio = (first / last).powf(1.0 / degree);
    let mut factor = 1.0 / first;
    let count = points.len();
    for (k, p) in points.iter_mut().enumerate() {
        *p = if k == 0 || k + 1 == count { (p.truncate() / p.w).extend(1.0) } else { *p * factor };
        factor *= ratio;
    }
}

/// The edge as paths from its start to its end; the first starts next to `near`.
pub(super) fn trace_edge<'a>(chart: &Chart, scale: &Scale, edge: &'a EdgeUse, near: Option<DVec2>) -> Vec<Path<'a>> {
    if let Some(paths) = file_image(chart, scale, edge, near) {
        return paths;
    }
    let flat = Flat::of(chart.form());
    let mut paths = Vec::new();
    let mut near = near;
    for span in &edge.spans {
        if span.range[0] == span.range[1] {
            continue;
        }
        if let Some(flat) = &flat {
            flat.paths(scale, edge.edge, span, &mut paths);
            continue;
        }
        let tracer = Tracer { chart, scale, edge: edge.edge, span };
        tracer.trace(near, &mut paths);
        near = paths.last().filter(|path: &&Path| path.poles[1].is_none()).map(|path| path.end).or(near);
    }
    paths
}

/// A sample of an edge: its parameter, where it lies on the surface, and the pole it lies on.
#[derive(Clone, Copy, Debug)]
struct Sample {
    t: f64,
    uv: DVec2,
    pole: Option<Pole>,
}

struct Tracer<'a, 'b> {
    chart: &'b Chart,
    scale: &'b Scale,
    edge: u32,
    span: &'a CurveSpan,
}

impl<'a> Tracer<'a, '_> {
    fn trace(&self, near: Option<DVec2>, paths: &mut Vec<Path<'a>>) {
        let samples = self.samples(near);
        // Poles split the edge; what lies on a pole altogether is no path.
        let mut first = 0;
        for k in 1..samples.len() {
            if samples[k].pole.is_some() || k + 1 == samples.len() {
                if k - first > 1 || samples[k].pole.is_none() || samples[first].pole.is_none() {
                    paths.push(self.path(&samples[first..=k]));
                }
                first = k;
            }
        }
    }

    /// Samples along the edge, close enough that no periodic parameter moves by more than a fifth of its period
    /// between them except across a pole.
    fn samples(&self, near: Option<DVec2>) -> Vec<Sample> {
        let count = match (&self.span.curve, self.chart.form()) {
            (CurveForm::Line { .. }, SurfaceForm::Cylinder { .. } | SurfaceForm::Cone { .. }) => 2,
            (CurveForm::Ellipse { .. }, _) => 4,
            (CurveForm::Nurbs(_), _) => 5,
            _ => 8,
        };
        let breaks = self.span.breaks();
        let mut samples: Vec<Sample> = Vec::with_capacity(breaks.len() * count + 1);
        samples.push(self.sample(breaks[0], near));
        for piece in breaks.windows(2) {
            for k in 1..=count {
                let s = k as f64 / count as f64;
                let t = if k == count { piece[1] } else { piece[0] + (piece[1] - piece[0]) * s };
                self.extend(&mut samples, t, 0);
            }
        }
        samples
    }

    /// Samples up to `t`, more of them where they jump.
    fn extend(&self, samples: &mut Vec<Sample>, t: f64, depth: usize) {
        let Some(&last) = samples.last() else { return };
        let next = self.sample(t, last.pole.is_none().then_some(last.uv));
        let jumps = |axis: usize| {
            let limit = self.chart.periods()[axis].map_or(f64::INFINITY, |period| 0.2 * period);
            (next.uv[axis] - last.uv[axis]).abs() > limit
        };
        if last.pole.is_none() && next.pole.is_none() && (jumps(0) || jumps(1)) && depth < MAX_HALVINGS {
            let middle = 0.5 * (last.t + t);
            if middle != last.t && middle != t {
                self.extend(samples, middle, depth + 1);
                self.extend(samples, t, depth + 1);
                return;
            }
        }
        samples.push(next);
    }

    fn sample(&self, t: f64, near: Option<DVec2>) -> Sample {
        let point = self.span.curve.position(t);
        let accept = if near.is_some() { self.scale.follow } else { self.scale.accept };
        let uv = self.chart.invert(point, near, accept);
        Sample { t, uv, pole: self.pole_at(point) }
    }

    fn pole_at(&self, point: DVec3) -> Option<Pole> {
        self.chart.poles().iter().find(|pole| pole.point.distance(point) <= self.scale.pole).copied()
    }

    fn path(&self, samples: &[Sample]) -> Path<'a> {
        let mut samples = samples.to_vec();
        let last = samples.len() - 1;
        if samples[0].pole.is_some() {
            samples[0].uv = self.pole_limit(samples[0], samples[1]);
            if last > 1 {
                samples[0].uv = self.chart.shifted(samples[0].uv, samples[1].uv);
            }
        }
        if samples[last].pole.is_some() {
            samples[last].uv = self.pole_limit(samples[last], samples[last - 1]);
        }
        // At a pole the near one of the periodic copies was not known to the samples after it; they follow the first.
        let poles = [samples[0].pole, samples[last].pole];
        let source = Some(Source { edge: self.edge, span: self.span, range: [samples[0].t, samples[last].t] });
        let fixed = [0, 1].into_iter().find_map(|axis| Some((axis, self.constant(axis, &samples)?)));
        let (mut start, mut end) = (samples[0].uv, samples[last].uv);
        if let Some((axis, value)) = fixed {
            (start[axis], end[axis]) = (value, value);
            return Path { start, end, shape: Shape::Straight, source, poles };
        }
        let samples = samples.into_iter().map(|sample| (sample.t, sample.uv)).collect();
        Path { start, end, shape: Shape::Traced(samples), source, poles }
    }

    /// The limit of the parameters towards a pole, where one of them is undetermined: extrapolated from next to it.
    fn pole_limit(&self, at: Sample, next: Sample) -> DVec2 {
        let Some(pole) = at.pole else { return at.uv };
        let other = 1 - pole.axis;
        let h = 0.02 * (next.t - at.t);
        let mut near = (next.pole.is_none()).then_some(next.uv);
        let [far, middle, close] = [3.0, 2.0, 1.0].map(|k| {
            let uv = self.chart.invert(self.span.curve.position(at.t + k * h), near, self.scale.follow);
            near = Some(uv);
            uv[other]
        });
        let mut uv = DVec2::ZERO;
        uv[other] = 3.0 * close - 3.0 * middle + far;
        uv[pole.axis] = pole.value;
        uv
    }

    /// The value of the parameter `axis` where it is constant along the samples, to within the tolerance in space.
    fn constant(&self, axis: usize, samples: &[Sample]) -> Option<f64> {
        let inner = || samples.iter().filter(|s| s.pole.is_none_or(|pole| pole.axis == axis)).map(|s| s.uv[axis]);
        let (low, high) = inner().fold((f64::INFINITY, f64::NEG_INFINITY), |(a, b), t| (a.min(t), b.max(t)));
        if low > high {
            return None;
        }
        let value = 0.5 * (low + high);
        let other = samples.iter().map(|s| s.uv[1 - axis]);
        let reach = other.clone().fold(f64::NEG_INFINITY, f64::max) - other.fold(f64::INFINITY, f64::min);
        if high - low > (0.01 * reach).max(1e-9) {
            return None;
        }
        for sample in samples {
            let point = self.chart.surface_point(sample.uv);
            let speed = if axis == 0 { point.du } else { point.dv };
            if (sample.uv[axis] - value).abs() * speed.length() > self.scale.straight {
                return None;
            }
        }
        Some(self.snapped(axis, value, samples))
    }

    /// The end of the surface's own range next to `value`, where it is that within the tolerance.
    fn snapped(&self, axis: usize, value: f64, samples: &[Sample]) -> f64 {
        let middle = self.chart.surface_point(samples[samples.len() / 2].uv);
        let speed = if axis == 0 { middle.du } else { middle.dv }.length();
        let [a, b] = self.chart.form().limits()[axis];
        [a, b].into_iter().find(|end| (end - value).abs() * speed <= self.scale.straight).unwrap_or(value)
    }
}
