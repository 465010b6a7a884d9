//! Edges joined to rings in the universal cover of the parameter plane.

use super::trace::{Path, Shape, trace_edge};
use super::{EdgeUse, Scale};
use crate::geometry::Chart;
use glam::DVec2;

/// Paths end to end. A ring that winds around a period ends that many periods from where it starts.
#[derive(Clone, Debug, Default)]
pub(super) struct Ring<'a> {
    pub paths: Vec<Path<'a>>,
    /// Periods from start to end, u and v.
    pub winding: [i32; 2],
    /// Distance in space of the largest gap between consecutive edges that was bridged.
    pub bridged: f64,
}

impl<'a> Ring<'a> {
    /// The ring of a bound's edges; `None` where they are all of zero length.
    pub fn new(chart: &Chart, scale: &Scale, edges: &'a [EdgeUse]) -> Option<Self> {
        let mut ring = Self { paths: Vec::with_capacity(edges.len()), ..Self::default() };
        // Where a path from pole to pole could have turned by nothing or by a whole period.
        let mut open_turns = Vec::new();
        for edge in edges {
            let near = ring.paths.last().map(|path| path.end);
            let mut paths = trace_edge(chart, scale, edge, near);
            for path in &mut paths {
                ring.append(chart, path.clone(), &mut open_turns);
            }
        }
        if ring.paths.is_empty() {
            return None;
        }
        ring.close(chart, &open_turns);
        Some(ring)
    }

    fn append(&mut self, chart: &Chart, mut path: Path<'a>, open_turns: &mut Vec<usize>) {
        let Some(last) = self.paths.last() else {
            self.paths.push(path);
            return;
        };
        let start = chart.shifted(path.start, last.end);
        match last.poles[1].zip(path.poles[0]) {
            Some((pole, other)) if pole == other => {
                let (end, open) = pole_end(chart, last, path.start, pole.axis, pole.value);
                if open {
                    open_turns.push(self.paths.len());
                }
                self.paths.push(Path::bridge(last.end, end));
                path.shift(end - path.start);
            }
            _ => path.shift(start - path.start),
        }
        self.paths.push(path);
    }

    /// The winding; a turn at a pole that was left open is the one that keeps the ring from winding.
    fn close(&mut self, chart: &Chart, open_turns: &[usize]) {
        let (Some(first), Some(last)) = (self.paths.first(), self.paths.last()) else { return };
        let mut open_turns = open_turns.to_vec();
        if let Some((pole, other)) = last.poles[1].zip(first.poles[0])
            && pole == other
        {
            let (end, open) = pole_end(chart, last, first.start, pole.axis, pole.value);
            if open {
                open_turns.push(self.paths.len());
            }
            let bridge = Path::bridge(last.end, end);
            self.paths.push(bridge);
        }
        self.measure_winding(chart);
        for axis in 0..2 {
            let turn = open_turns.iter().find(|&&k| self.paths[k].start[1 - axis] == self.paths[k].end[1 - axis]);
            if let (Some(&k), Some(period), true) = (turn, chart.periods()[axis], self.winding[axis] != 0) {
                let mut by = DVec2::ZERO;
                by[axis] = -f64::from(self.winding[axis]) * period;
                self.paths[k].end += by;
                self.paths[k + 1..].iter_mut().for_each(|path| path.shift(by));
                self.winding[axis] = 0;
            }
        }
    }

    fn measure_winding(&mut self, chart: &Chart) {
        let (Some(first), Some(last)) = (self.paths.first(), self.paths.last()) else { return };
        let across = last.end - first.start;
        self.winding = [0, 1].map(|axis| match chart.periods()[axis] {
            Some(period) => (across[axis] / period).round() as i32,
            None => 0,
        });
    }

    /// From the ring's start to where it ends by its winding.
    pub fn turn(&self, chart: &Chart) -> DVec2 {
        let turn = |axis: usize| f64::from(self.winding[axis]) * chart.periods()[axis].unwrap_or(0.0);
        DVec2::new(turn(0), turn(1))
    }

    pub fn points(&self) -> impl Iterator<Item = DVec2> + '_ {
        self.paths.iter().flat_map(Path::points)
    }

    /// Least and greatest parameters of the samples.
    pub fn bounds(&self) -> [DVec2; 2] {
        self.points().fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[a, b], p| [a.min(p), b.max(p)])
    }

    /// A box that holds the ring: that of the samples with room for what bulges out between them.
    pub fn reach(&self) -> [DVec2; 2] {
        let bounds = self.paths.iter().map(Path::bounds);
        bounds.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[a, b], [p, q]| [a.min(p), b.max(q)])
    }

    /// The share of another ring's points, moved by `by`, that lie inside the polygon through the samples.
    pub fn share_inside(&self, other: &Ring, by: DVec2) -> f64 {
        let (mut inside, mut count) = (0.0, 0.0);
        for p in other.points().map(|p| p + by) {
            let mut odd = false;
            let Some(mut a) = self.paths.last().map(|path| path.end) else { return 0.0 };
            for b in self.points() {
                if (a.y > p.y) != (b.y > p.y) && p.x < a.x + (b.x - a.x) * (p.y - a.y) / (b.y - a.y) {
                    odd = !odd;
                }
                a = b;
            }
            inside += f64::from(u8::from(odd));
            count += 1.0;
        }
        inside / count
    }

    /// Signed area of the polygon through the samples; positive where the ring runs counter-clockwise.
    pub fn area(&self) -> f64 {
        let Some(first) = self.paths.first().map(|path| path.start) else { return 0.0 };
        let mut before = first;
        let mut twice = 0.0;
        for p in self.points() {
            twice += (before - first).perp_dot(p - first);
            before = p;
        }
        0.5 * twice
    }

    /// Whether some place lies inside the polygon through the samples, by the odd-even rule and beyond rounding: none in a
    /// seam walked there and back, but in two lobes that run against each other.
    pub fn bounds_something(&self) -> bool {
        let [low, high] = self.bounds();
        let size = high - low;
        if self.area().abs() > 1e-12 * size.element_product() && self.area() != 0.0 {
            return true;
        }
        let Some(start) = self.paths.last().map(|path| path.end) else { return false };
        [0.17, 0.41, 0.73].into_iter().any(|part| {
            let v = low.y + part * size.y;
            let (mut a, mut across) = (start, Vec::new());
            for b in self.points() {
                if (a.y > v) != (b.y > v) {
                    across.push(a.x + (b.x - a.x) * (v - a.y) / (b.y - a.y));
                }
                a = b;
            }
            across.sort_by(f64::total_cmp);
            across.chunks_exact(2).map(|span| span[1] - span[0]).sum::<f64>() > 1e-6 * size.x
        })
    }

    pub fn shift(&mut self, by: DVec2) {
        self.paths.iter_mut().for_each(|path| path.shift(by));
    }

    /// Makes each path end where the next one starts, bit for bit: by moving ends where they are near enough, else by
    /// a path in between.
    pub fn join(&mut self, chart: &Chart, scale: &Scale) {
        let turn = self.turn(chart);
        let count = self.paths.len();
        let mut bridges = Vec::new();
        for k in 0..count {
            let next = (k + 1) % count;
            let across = if next == 0 { turn } else { DVec2::ZERO };
            let (end, start) = (self.paths[k].end, self.paths[next].start + across);
            if end == start {
                continue;
            }
            let distance = chart.position(end).distance(chart.position(start));
            let pole = self.paths[k].poles[1].is_some() || self.paths[next].poles[0].is_some();
            if distance > scale.snap || (pole && end.distance(start) > 1e-6) {
                if !pole {
                    self.bridged = self.bridged.max(distance);
                }
                bridges.push((k, Path::bridge(end, start)));
                continue;
            }
            let corner = corner(&self.paths[k], &self.paths[next], end, start);
            self.paths[k].end = corner;
            self.paths[next].start = corner - across;
            if self.paths[next].start + across != corner {
                // The sum is rounded: the end follows it.
                self.paths[k].end = self.paths[next].start + across;
            }
        }
        for (k, bridge) in bridges.into_iter().rev() {
            self.paths.insert(k + 1, bridge);
        }
        for path in &mut self.paths {
            if let Shape::Exact(curve) = &mut path.shape {
                *curve = with_ends(curve, path.start, path.end);
            }
        }
    }
}

/// Where two paths meet that nearly do: straight paths keep the parameter that is constant on them.
fn corner(before: &Path, after: &Path, end: DVec2, start: DVec2) -> DVec2 {
    let mut corner = end;
    if let Some(axis) = after.fixed_axis()
        && before.fixed_axis() != Some(axis)
    {
        corner[axis] = start[axis];
    }
    corner
}

fn with_ends(curve: &crate::geometry::BezierCurve, start: DVec2, end: DVec2) -> crate::geometry::BezierCurve {
    let mut points = curve.points().to_vec();
    let last = points.len() - 1;
    points[0] = start.extend(0.0).extend(1.0);
    points[last] = end.extend(0.0).extend(1.0);
    crate::geometry::BezierCurve::from_points(points)
}

/// Where the way along a pole ends that leads from the end of `last` to a path that starts at `start`, with the material
/// to its left; and whether nothing or a whole turn would be as good.
fn pole_end(chart: &Chart, last: &Path, start: DVec2, axis: usize, value: f64) -> (DVec2, bool) {
    let along = 1 - axis;
    let mut end = start;
    end[axis] = value;
    let Some(period) = chart.periods()[along] else { return (end, false) };
    let before = last.points().map(|p| p[axis] - value).fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a });
    // Material beyond a line of constant v lies to its left where u grows; beyond one of constant u, where v falls.
    let sign = if (before > 0.0) == (axis == 1) { 1.0 } else { -1.0 };
    let turn = (sign * (start[along] - last.end[along])).rem_euclid(period);
    let open = turn.min(period - turn) < 1e-6 * period;
    end[along] = last.end[along] + if open { 0.0 } else { sign * turn };
    (end, open)
}
