//! Rings that wind are closed along a seam; rings that don't are brought into one window of the cover.

use super::ring::Ring;
use super::trace::{Path, Shape};
use crate::geometry::Chart;
use glam::DVec2;

/// A rectangle of parameters: `[[u0, u1], [v0, v1]]`.
pub(super) type Rectangle = [[f64; 2]; 2];

/// Closed rings of one face, none of which winds.
pub(super) fn closed_rings<'a>(chart: &Chart, rings: Vec<Ring<'a>>, warnings: &mut Vec<String>) -> Vec<Ring<'a>> {
    let (winding, mut holes): (Vec<_>, Vec<_>) = rings.into_iter().partition(|ring| ring.winding != [0, 0]);
    // A seam walked both ways and nothing else bounds nothing.
    holes.retain(|ring| {
        let [low, high] = ring.bounds();
        ring.area().abs() > 1e-12 * (high - low).element_product() && ring.area() != 0.0
    });
    let mut outer = bands(chart, winding, warnings);
    if outer.is_empty() {
        let Some(largest) = largest(&holes) else { return Vec::new() };
        if holes[largest].area() < 0.0 && is_closed(chart) {
            let [low, high] = holes[largest].bounds();
            outer.push(rectangle(&whole_about(chart, 0.5 * (low + high))));
        } else {
            outer.push(holes.swap_remove(largest));
        }
    }
    for mut hole in holes {
        into_window(chart, &mut hole, &outer);
        outer.push(hole);
    }
    outer
}

fn largest(rings: &[Ring]) -> Option<usize> {
    (0..rings.len()).max_by(|&a, &b| rings[a].area().abs().total_cmp(&rings[b].area().abs()))
}

/// Whether the surface has no border: every parameter closes or runs from pole to pole.
pub(super) fn is_closed(chart: &Chart) -> bool {
    let limits = chart.form().limits();
    [0, 1].into_iter().all(|axis| {
        let at_pole = |end: f64| chart.poles().iter().any(|pole| pole.axis == axis && pole.value == end);
        chart.periods()[axis].is_some() || limits[axis].into_iter().all(at_pole)
    })
}

/// All of the surface; where it closes, from half a period before `center` to half a period after.
pub(super) fn whole_about(chart: &Chart, center: DVec2) -> Rectangle {
    let limits = chart.form().limits();
    [0, 1].map(|axis| match chart.periods()[axis] {
        Some(period) => [center[axis] - 0.5 * period, center[axis] - 0.5 * period + period],
        None => limits[axis],
    })
}

fn rectangle<'a>(&[[u0, u1], [v0, v1]]: &Rectangle) -> Ring<'a> {
    let corners = [DVec2::new(u0, v0), DVec2::new(u1, v0), DVec2::new(u1, v1), DVec2::new(u0, v1)];
    let paths = (0..4).map(|k| Path::bridge(corners[k], corners[(k + 1) % 4])).collect();
    Ring { paths, ..Ring::default() }
}

/// Moves `hole` by whole periods to where it overlaps one of the `outer` rings most.
fn into_window(chart: &Chart, hole: &mut Ring, outer: &[Ring]) {
    let [low, high] = hole.bounds();
    let center = 0.5 * (low + high);
    let mut best = (f64::NEG_INFINITY, DVec2::ZERO);
    for ring in outer {
        let window = ring.bounds();
        let near = chart.shifted(center, 0.5 * (window[0] + window[1])) - center;
        let steps = chart.periods().map(|p| p.unwrap_or(0.0));
        for i in [0.0, -1.0, 1.0] {
            for j in [0.0, -1.0, 1.0] {
                if (i != 0.0 && steps[0] == 0.0) || (j != 0.0 && steps[1] == 0.0) {
                    continue;
                }
                let by = near + DVec2::new(i * steps[0], j * steps[1]);
                let common = (window[1].min(high + by) - window[0].max(low + by)).min_element();
                if common > best.0 + 1e-9 {
                    best = (common, by);
                }
            }
        }
    }
    hole.shift(best.1);
}

/// Rings that wind, closed in pairs or with a pole or border along a line across.
fn bands<'a>(chart: &Chart, winding: Vec<Ring<'a>>, warnings: &mut Vec<String>) -> Vec<Ring<'a>> {
    let mut closed = Vec::new();
    for axis in 0..2 {
        let along = |ring: &&Ring| ring.winding[axis].abs() == 1 && ring.winding[1 - axis] == 0;
        let rings: Vec<Ring> = winding.iter().filter(along).cloned().collect();
        if !rings.is_empty() {
            closed.extend(Bands { chart, axis }.close(rings, warnings));
        }
    }
    let odd = winding.iter().filter(|r| r.winding[0].abs() + r.winding[1].abs() != 1).count();
    if odd > 0 {
        warnings.push(format!("{odd} loops wind around the surface in both directions or more than once; left out"));
    }
    closed
}

/// Rings that wind once along `axis`.
struct Bands<'b> {
    chart: &'b Chart,
    axis: usize,
}

impl Bands<'_> {
    /// Whether the material lies beyond the ring, at greater values of the other parameter.
    fn beyond(&self, ring: &Ring) -> bool {
        (ring.winding[self.axis] > 0) == (self.axis == 0)
    }

    fn close<'a>(&self, mut rings: Vec<Ring<'a>>, warnings: &mut Vec<String>) -> Vec<Ring<'a>> {
        let across = 1 - self.axis;
        if let Some(period) = self.chart.periods()[across] {
            let first = rings.iter().position(|ring| self.beyond(ring)).unwrap_or(0);
            rings.swap(0, first);
            let base = middle(&rings[0], across);
            for ring in &mut rings[1..] {
                let mut by = DVec2::ZERO;
                by[across] = -((middle(ring, across) - base) / period).floor() * period;
                ring.shift(by);
            }
        }
        rings.sort_by(|a, b| middle(a, across).total_cmp(&middle(b, across)));
        let count = rings.len();
        let consistent = count.is_multiple_of(2) && self.beyond(&rings[0]) && !self.beyond(&rings[count - 1]);
        let mut closed = Vec::new();
        let mut rings = rings.into_iter().peekable();
        let alone = |ring: &Ring| !self.beyond(ring) && (count % 2 == 1 || self.end(0).is_some());
        if !consistent
            && self.chart.periods()[across].is_none()
            && let Some(ring) = rings.next_if(alone)
        {
            closed.extend(self.with_end(ring, warnings));
        }
        while let Some(ring) = rings.next() {
            match rings.next() {
                Some(other) => closed.push(self.pair(ring, other)),
                None => closed.extend(self.with_end(ring, warnings)),
            }
        }
        closed
    }

    /// Where the surface ends across the rings, at its first (0) or last (1) value.
    fn end(&self, end: usize) -> Option<f64> {
        let limit = self.chart.form().limits()[1 - self.axis][end];
        limit.is_finite().then_some(limit)
    }

    /// A ring alone: up to the pole or border on the side of its material.
    fn with_end<'a>(&self, ring: Ring<'a>, warnings: &mut Vec<String>) -> Option<Ring<'a>> {
        let across = 1 - self.axis;
        let at = middle(&ring, across);
        if let Some(period) = self.chart.periods()[across] {
            let mut other = ring.clone();
            let mut by = DVec2::ZERO;
            by[across] = period;
            other.shift(by);
            return Some(self.pair(ring, other));
        }
        let beyond = self.beyond(&ring);
        let side = |value: f64| (value > at) == beyond;
        let poles: Vec<f64> =
            self.chart.poles().iter().filter(|pole| pole.axis == across).map(|pole| pole.value).collect();
        let end = poles.iter().copied().find(|&v| side(v)).or_else(|| self.end(usize::from(beyond)));
        let end = end.or_else(|| {
            warnings.push(
                "a loop around the surface has its material on the side without end; the other side is taken".into(),
            );
            poles.first().copied().or_else(|| self.end(usize::from(!beyond)))
        });
        let Some(end) = end else {
            warnings.push("a loop around the surface has no partner; it is left out".into());
            return None;
        };
        let line = self.line(&ring, end);
        Some(self.pair(ring, line))
    }

    /// A straight ring at `value` that runs against `ring`.
    fn line<'a>(&self, ring: &Ring<'a>, value: f64) -> Ring<'a> {
        let turn = ring.turn(self.chart);
        let mut start = ring.paths.first().map_or(DVec2::ZERO, |path| path.start) + turn;
        start[1 - self.axis] = value;
        Ring { paths: vec![Path::bridge(start, start - turn)], winding: ring.winding.map(|w| -w), ..Ring::default() }
    }

    /// Two rings as one, joined by a straight line there and back at the first one's start.
    fn pair<'a>(&self, ring: Ring<'a>, mut other: Ring<'a>) -> Ring<'a> {
        if other.winding == ring.winding {
            other = reversed(other);
        }
        let turn = ring.turn(self.chart);
        let start = ring.paths.first().map_or(DVec2::ZERO, |path| path.start);
        self.rotate(&mut other, (start + turn)[self.axis]);
        let mut paths = ring.paths;
        let mut returning = other.paths;
        if let (Some(last), Some(first)) = (paths.last_mut(), returning.last_mut()) {
            last.end = start + turn;
            let back = DVec2::select(glam::BVec2::new(self.axis == 0, self.axis == 1), start, first.end);
            first.end = back;
        }
        let [to, from] = [returning.first().map(|p| p.start), returning.last().map(|p| p.end)];
        let (Some(to), Some(from)) = (to, from) else { return Ring { paths, ..Ring::default() } };
        paths.push(Path::bridge(start + turn, to));
        paths.append(&mut returning);
        paths.push(Path::bridge(from, start));
        Ring { paths, winding: [0, 0], bridged: ring.bridged.max(other.bridged) }
    }

    /// Makes the ring start where its parameter along the axis is `value` or that and whole periods, and moves it there.
    fn rotate(&self, ring: &mut Ring, value: f64) {
        let (axis, turn) = (self.axis, ring.turn(self.chart));
        let Some(period) = self.chart.periods()[axis] else { return };
        let crossing = |path: &Path| {
            let [a, b] = [path.start[axis], path.end[axis]];
            let [low, high] = [a.min(b), a.max(b)];
            let k = ((low - value) / period - 1e-12).ceil();
            let at = value + k * period;
            (at <= high + 1e-12 * period).then_some(at)
        };
        let Some((k, at)) = ring.paths.iter().enumerate().find_map(|(k, path)| Some((k, crossing(path)?))) else {
            return;
        };
        let path = ring.paths[k].clone();
        let near = |t: f64| (t - at).abs() <= 1e-9 * period;
        let first = if near(path.start[axis]) {
            k
        } else if near(path.end[axis]) {
            k + 1
        } else {
            let [low, high] = split(self.chart, &path, axis, at);
            ring.paths.splice(k..=k, [low, high]);
            k + 1
        };
        let mut moved = ring.paths.split_off(first);
        ring.paths.iter_mut().for_each(|path| path.shift(turn));
        moved.append(&mut ring.paths);
        ring.paths = moved;
        let mut by = DVec2::ZERO;
        by[axis] = ((value - ring.paths[0].start[axis]) / period).round() * period;
        ring.shift(by);
        ring.paths[0].start[axis] = value;
    }
}

fn middle(ring: &Ring, axis: usize) -> f64 {
    let [low, high] = ring.bounds();
    0.5 * (low[axis] + high[axis])
}

/// The two parts of a path on either side of where its parameter `axis` is `at`.
fn split<'a>(chart: &Chart, path: &Path<'a>, axis: usize, at: f64) -> [Path<'a>; 2] {
    let [mut low, mut high] = [path.clone(), path.clone()];
    let part = (at - path.start[axis]) / (path.end[axis] - path.start[axis]);
    let mut uv = path.start.lerp(path.end, part);
    if let Some(source) = path.source {
        let [a, b] = source.range;
        let mut t = a + (b - a) * part;
        if let Shape::Traced(samples) = &path.shape {
            let crosses = |w: &[(f64, DVec2)]| (w[0].1[axis] - at) * (w[1].1[axis] - at) <= 0.0;
            let k = samples.windows(2).position(crosses).unwrap_or(0);
            let [mut a, mut b] = [samples[k], samples[k + 1]];
            for _ in 0..100 {
                t = 0.5 * (a.0 + b.0);
                uv = chart.invert(source.span.curve.position(t), Some(a.1), f64::INFINITY);
                if t == a.0 || t == b.0 {
                    break;
                }
                if (uv[axis] - at) * (a.1[axis] - at) > 0.0 { a = (t, uv) } else { b = (t, uv) }
            }
            let mut before = samples[..=k].to_vec();
            let mut after = samples[k + 1..].to_vec();
            uv[axis] = at;
            before.push((t, uv));
            after.insert(0, (t, uv));
            (low.shape, high.shape) = (Shape::Traced(before), Shape::Traced(after));
        }
        low.source = path.source.map(|s| super::trace::Source { range: [a, t], ..s });
        high.source = path.source.map(|s| super::trace::Source { range: [t, b], ..s });
    }
    uv[axis] = at;
    (low.end, high.start) = (uv, uv);
    (low.poles[1], high.poles[0]) = (None, None);
    [low, high]
}

fn reversed(ring: Ring<'_>) -> Ring<'_> {
    Ring {
        paths: ring.paths.into_iter().rev().map(Path::reversed).collect(),
        winding: ring.winding.map(|w| -w),
        bridged: ring.bridged,
    }
}
