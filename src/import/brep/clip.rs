//! Loops cut along a window of one period, for faces on closed surfaces that no seam can be laid through untouched.

use super::cover::Rectangle;
use super::ring::Ring;
use super::trace::{Path, Shape, Source};
use super::{BrepError, MAX_CUTS, MAX_TURNS};
use crate::geometry::Chart;
use glam::DVec2;

/// The part in `window` of all copies of all rings, by whole periods.
///
/// Counted odd and even, a loop's copies together bound the same part of the closed surface as the loop does, wherever
/// they are cut: what is inside two copies is inside none, and lines that were added to close a loop cancel.
///
/// # Errors
/// Where an edge runs to and fro across the window's border without end.
pub(super) fn windowed<'a>(
    chart: &Chart,
    rings: Vec<Ring<'a>>,
    window: &Rectangle,
) -> Result<Vec<Ring<'a>>, BrepError> {
    let mut inside = Vec::new();
    for ring in rings {
        let [low, high] = ring.reach();
        let copies = [0, 1].map(|axis| match chart.periods()[axis] {
            Some(period) => {
                let first = ((window[axis][0] - high[axis]) / period).ceil();
                let last = ((window[axis][1] - low[axis]) / period).floor();
                // Rings were not farther off, and closing them moves them by a few periods.
                [first, last].map(|k| k.clamp(-2.0 * MAX_TURNS, 2.0 * MAX_TURNS) as i32)
            }
            None => [0, 0],
        });
        for i in copies[0][0]..=copies[0][1] {
            for j in copies[1][0]..=copies[1][1] {
                let mut copy = ring.clone();
                let steps = [i, j].map(f64::from);
                let by = [0, 1].map(|axis| steps[axis] * chart.periods()[axis].unwrap_or(0.0));
                copy.shift(DVec2::from(by));
                inside.extend(clipped(chart, copy, window)?);
            }
        }
    }
    Ok(inside)
}

/// The part of a ring in `window`, along the axes with a period.
fn clipped<'a>(chart: &Chart, mut ring: Ring<'a>, window: &Rectangle) -> Result<Option<Ring<'a>>, BrepError> {
    for (axis, borders) in window.iter().enumerate() {
        let Some(period) = chart.periods()[axis] else { continue };
        for (at, side) in borders.iter().zip([1.0, -1.0]) {
            let border = Border { axis, at: *at, tolerance: 1e-10 * period };
            ring.paths = border.half(chart, ring.paths, side)?;
        }
    }
    let runs = ring.paths.iter().any(|path| path.source.is_some() || path.start != path.end);
    Ok((runs && ring.bounds_something()).then_some(ring))
}

/// A line of constant parameter.
pub(super) struct Border {
    pub axis: usize,
    pub at: f64,
    /// What is nearer lies on it.
    pub tolerance: f64,
}

impl Border {
    /// The side on which a point is: -1, 0 or 1.
    fn side(&self, p: DVec2) -> i32 {
        let off = p[self.axis] - self.at;
        if off.abs() <= self.tolerance { 0 } else { off.signum() as i32 }
    }

    /// The parts of a closed ring on the side of `sign` and on the border itself; the ways between them run along the
    /// border (Sutherland and Hodgman, "Reentrant polygon clipping", CACM 17, 1974).
    fn half<'a>(&self, chart: &Chart, paths: Vec<Path<'a>>, sign: f64) -> Result<Vec<Path<'a>>, BrepError> {
        let mut kept: Vec<Path> = Vec::with_capacity(paths.len());
        let mut left_out = false;
        for mut rest in paths {
            let mut parts = Vec::new();
            while let Some([before, after]) = self.cut(chart, &rest) {
                if parts.len() >= MAX_CUTS {
                    return Err(BrepError::Cuts);
                }
                parts.push(before);
                rest = after;
            }
            parts.push(rest);
            for mut part in parts {
                if self.farthest(&part) * sign < 0.0 {
                    left_out = true;
                    continue;
                }
                self.snap(&mut part);
                if left_out && let Some(last) = kept.last() {
                    kept.push(Path::bridge(last.end, part.start));
                }
                left_out = false;
                kept.push(part);
            }
        }
        if let (Some(first), Some(last)) = (kept.first(), kept.last())
            && first.start.distance(last.end) > 0.0
        {
            kept.push(Path::bridge(last.end, first.start));
        }
        Ok(kept)
    }

    /// How far the path goes off the border, signed; 0 where it stays on it.
    fn farthest(&self, path: &Path) -> f64 {
        let off = knots(path).into_iter().filter(|k| self.side(k.1) != 0).map(|k| k.1[self.axis] - self.at);
        off.fold(0.0, |a: f64, b| if b.abs() > a.abs() { b } else { a })
    }

    /// Ends on the border are on it bit for bit.
    fn snap(&self, path: &mut Path) {
        for end in [&mut path.start, &mut path.end] {
            if self.side(*end) == 0 {
                end[self.axis] = self.at;
            }
        }
    }

    /// The two parts of a path on either side of where it first crosses the border.
    pub fn cut<'a>(&self, chart: &Chart, path: &Path<'a>) -> Option<[Path<'a>; 2]> {
        let knots = knots(path);
        let first = knots.iter().position(|k| self.side(k.1) != 0)?;
        let side = self.side(knots[first].1);
        let after = first + knots[first..].iter().position(|k| self.side(k.1) == -side)?;
        let before = (first..after).rev().find(|&k| self.side(knots[k].1) == side)?;
        if after - before > 1 {
            // There is a knot on the border.
            let (s, uv) = knots[before + 1];
            return Some(self.parts(path, s, uv));
        }
        let [mut a, mut b] = [knots[before], knots[after]];
        let mut middle = a;
        if matches!(path.shape, Shape::Straight) {
            let part = (self.at - a.1[self.axis]) / (b.1[self.axis] - a.1[self.axis]);
            middle = (part, a.1.lerp(b.1, part));
        } else {
            for _ in 0..100 {
                let s = 0.5 * (a.0 + b.0);
                middle = (s, position(chart, path, s, a.1));
                if s == a.0 || s == b.0 {
                    break;
                }
                if (middle.1[self.axis] - self.at) * f64::from(side) > 0.0 { a = middle } else { b = middle }
            }
        }
        Some(self.parts(path, middle.0, middle.1))
    }

    /// The two parts on either side of the path's parameter `s`.
    fn parts<'a>(&self, path: &Path<'a>, s: f64, mut uv: DVec2) -> [Path<'a>; 2] {
        uv[self.axis] = self.at;
        let [mut low, mut high] = [path.clone(), path.clone()];
        let mut t = s;
        match &path.shape {
            Shape::Traced(samples) => {
                let ascending = samples[samples.len() - 1].0 > samples[0].0;
                let is_before = |p: &&(f64, DVec2)| p.0 != s && (p.0 < s) == ascending;
                let is_after = |p: &&(f64, DVec2)| p.0 != s && (p.0 > s) == ascending;
                let before = samples.iter().filter(is_before).copied().chain([(s, uv)]).collect();
                let after = [(s, uv)].into_iter().chain(samples.iter().filter(is_after).copied()).collect();
                (low.shape, high.shape) = (Shape::Traced(before), Shape::Traced(after));
            }
            Shape::Exact(curve) => {
                let halves = [[0.0, s], [s, 1.0]].map(|range| {
                    let mut points = curve.restrict(range).points().to_vec();
                    super::trace::standard(&mut points);
                    Shape::Exact(crate::geometry::BezierCurve::from_points(points))
                });
                [low.shape, high.shape] = halves;
            }
            Shape::Straight => {}
        }
        if let Some(Source { range: [a, b], .. }) = path.source {
            if !matches!(path.shape, Shape::Traced(_)) {
                t = a + (b - a) * s;
            }
            low.source = path.source.map(|source| Source { range: [a, t], ..source });
            high.source = path.source.map(|source| Source { range: [t, b], ..source });
        }
        (low.end, high.start) = (uv, uv);
        (low.poles[1], high.poles[0]) = (None, None);
        [low, high]
    }
}

/// Where the path is at some of its parameters, both ends among them.
fn knots(path: &Path) -> Vec<(f64, DVec2)> {
    match &path.shape {
        Shape::Straight => vec![(0.0, path.start), (1.0, path.end)],
        Shape::Exact(curve) => {
            let count = 8 * curve.degree();
            let at = |k: usize| {
                let s = k as f64 / count as f64;
                (s, curve.position(s).truncate())
            };
            (0..=count).map(at).collect()
        }
        Shape::Traced(samples) => {
            let mut knots = samples.clone();
            let last = knots.len() - 1;
            (knots[0].1, knots[last].1) = (path.start, path.end);
            knots
        }
    }
}

/// The path's position at its parameter `s`, next to `near`.
fn position(chart: &Chart, path: &Path, s: f64, near: DVec2) -> DVec2 {
    match (&path.shape, path.source) {
        (Shape::Traced(_), Some(source)) => chart.invert(source.span.curve.position(s), Some(near), f64::INFINITY),
        (Shape::Exact(curve), _) => curve.position(s).truncate(),
        _ => near,
    }
}
