//! Rings that wind are closed along a seam; rings that don't are brought into one window of the cover.

use super::bands::{Closed, close_winding};
use super::clip::windowed;
use super::ring::Ring;
use super::trace::Path;
use super::{BrepError, MAX_TURNS};
use crate::geometry::Chart;
use glam::DVec2;

/// A rectangle of parameters: `[[u0, u1], [v0, v1]]`.
pub(super) type Rectangle = [[f64; 2]; 2];

/// Closed rings of one face, none of which winds.
pub(super) fn closed_rings<'a>(
    chart: &Chart,
    rings: Vec<Ring<'a>>,
    warnings: &mut Vec<String>,
) -> Result<Vec<Ring<'a>>, BrepError> {
    let (winding, mut holes): (Vec<_>, Vec<_>) = rings.into_iter().partition(|ring| ring.winding != [0, 0]);
    // A seam walked both ways and nothing else bounds nothing.
    holes.retain(Ring::bounds_something);
    let mut closed = if winding.is_empty() {
        let Some(largest) = largest(&holes) else { return Ok(Vec::new()) };
        if holes[largest].area() < 0.0 && is_closed(chart) {
            let [low, high] = holes[largest].bounds();
            let default = whole_about(chart, 0.5 * (low + high));
            let window = free_window(chart, DVec2::new(default[0][0], default[1][0]), &holes);
            Closed { rings: vec![rectangle(&window)], corner: window.map(|range| range[0]).into(), cut: false }
        } else {
            let outer = holes.swap_remove(largest);
            Closed { corner: outer.bounds()[0], rings: vec![outer], cut: false }
        }
    } else {
        close_winding(chart, winding, &holes, warnings)?
    };
    holes.iter_mut().for_each(|hole| into_window(chart, hole, &closed.rings));
    let cut = closed.cut || holes.iter().any(|hole| straddles(chart, hole, &closed.rings));
    closed.rings.append(&mut holes);
    if !cut {
        return Ok(closed.rings);
    }
    let window = [0, 1].map(|axis| {
        let low = closed.corner[axis];
        chart.periods()[axis].map_or([f64::NEG_INFINITY, f64::INFINITY], |period| [low, low + period])
    });
    windowed(chart, closed.rings, &window)
}

/// Whether the ring leaves a window of a whole period that `outer` makes.
fn straddles(chart: &Chart, ring: &Ring, outer: &[Ring]) -> bool {
    let [low, high] = ring.reach();
    let bounds = outer.iter().map(Ring::bounds);
    let [a, b] = bounds.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[a, b], [p, q]| [a.min(p), b.max(q)]);
    (0..2).any(|axis| {
        let Some(period) = chart.periods()[axis] else { return false };
        let near = 1e-6 * period;
        let whole = ((b - a)[axis] - period).abs() <= near;
        whole && (low[axis] < a[axis] - 1e-3 * near || high[axis] > b[axis] + 1e-3 * near)
    })
}

/// One period from where no ring is, or the least of `default` where there is no such place; all of a parameter that
/// has none.
fn free_window(chart: &Chart, default: DVec2, rings: &[Ring]) -> Rectangle {
    let limits = chart.form().limits();
    [0, 1].map(|axis| match chart.periods()[axis] {
        Some(period) => {
            let ranges: Vec<[f64; 2]> = rings.iter().map(|ring| ring.reach().map(|p| p[axis])).collect();
            let low = free(period, default[axis], &ranges);
            [low, low + period]
        }
        None => limits[axis],
    })
}

/// A value in none of the ranges or their copies by whole periods: `default` if it is one, else the middle of the
/// widest gap between them; `default` where there is no gap.
pub(super) fn free(period: f64, default: f64, ranges: &[[f64; 2]]) -> f64 {
    let least = 1e-6 * period;
    let mut ranges: Vec<[f64; 2]> = ranges
        .iter()
        .map(|[a, b]| {
            let start = (a - default).rem_euclid(period);
            [start, start + (b - a)]
        })
        .collect();
    if ranges.iter().all(|[a, b]| *a > least && *b < period - least) {
        return default;
    }
    ranges.sort_by(|p, q| p[0].total_cmp(&q[0]));
    let mut covered = ranges.iter().map(|range| range[1]).fold(f64::NEG_INFINITY, f64::max) - period;
    let mut best = (least, default);
    for [a, b] in ranges {
        if a - covered > best.0 {
            best = (a - covered, default + 0.5 * (a + covered));
        }
        covered = covered.max(b);
    }
    best.1
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

/// Moves `hole` by whole periods to where it lies inside one of the `outer` rings, or overlaps one most.
fn into_window(chart: &Chart, hole: &mut Ring, outer: &[Ring]) {
    let [low, high] = hole.bounds();
    let center = 0.5 * (low + high);
    let mut places = Vec::new();
    for ring in outer {
        let window = ring.bounds();
        let near = chart.shifted(center, 0.5 * (window[0] + window[1])) - center;
        let steps = [0, 1].map(|axis| match chart.periods()[axis] {
            Some(period) => {
                (period, (0.5 * (window[1] - window[0])[axis] / period).ceil().clamp(1.0, MAX_TURNS) as i32)
            }
            None => (0.0, 0),
        });
        for i in -steps[0].1..=steps[0].1 {
            for j in -steps[1].1..=steps[1].1 {
                let by = near + DVec2::new(f64::from(i) * steps[0].0, f64::from(j) * steps[1].0);
                let common = (window[1].min(high + by) - window[0].max(low + by)).min_element();
                places.push((common, by.abs().element_sum(), by, ring));
            }
        }
    }
    places.sort_by(|p, q| q.0.total_cmp(&p.0).then(p.1.total_cmp(&q.1)));
    let Some(first) = places.first() else { return };
    let overlapping = places.iter().filter(|place| place.0 > 0.0);
    let inside = overlapping.clone().map(|place| (place.3.share_inside(hole, place.2), place.2));
    // Where a loop is wider than a period, boxes overlap at several places.
    let best = match overlapping.count() {
        0 | 1 => first.2,
        _ => inside.fold((-1.0, first.2), |best, place| if place.0 > best.0 + 1e-9 { place } else { best }).1,
    };
    hole.shift(best);
}
