//! Area inside outlines that cross each other or themselves, by the odd-even rule: row by row.

use super::BezierCurve;
use super::area::{Estimate, GAUSS};
use super::trimmed_area::{Outline, Sheet};
use glam::DVec2;

/// Points a curve by which crossings are found.
const SAMPLES: usize = 8;
/// Rows of Gauss nodes that one sum may take.
const MAX_PARTS: usize = 1 << 13;
/// Halvings of a curve until it is monotone in v.
const MAX_HALVINGS: usize = 40;

/// Whether an outline crosses another one or itself: as polygons through points of theirs. Outlines that touch do not.
pub(super) fn cross(outlines: &[Outline]) -> bool {
    let mut edges: Vec<[DVec2; 2]> = Vec::new();
    for outline in outlines {
        let count = |curve: &BezierCurve| if curve.degree() == 1 { 1 } else { SAMPLES };
        let points = |curve: &&BezierCurve| {
            let (curve, n) = (*curve, count(curve));
            (0..n).map(|k| curve.position(k as f64 / n as f64).truncate()).collect::<Vec<_>>()
        };
        let points: Vec<DVec2> = outline.iter().flat_map(points).collect();
        edges.extend((0..points.len()).map(|k| [points[k], points[(k + 1) % points.len()]]));
    }
    let low = |edge: &[DVec2; 2]| edge[0].x.min(edge[1].x);
    edges.sort_by(|a, b| low(a).total_cmp(&low(b)));
    edges.iter().enumerate().any(|(k, edge)| {
        let high = edge[0].x.max(edge[1].x);
        let near = edges[k + 1..].iter().take_while(|other| low(other) <= high);
        near.into_iter().any(|other| cross_each_other(edge, other))
    })
}

/// Whether two edges cross well inside both.
fn cross_each_other([a, b]: &[DVec2; 2], [c, d]: &[DVec2; 2]) -> bool {
    if a.y.max(b.y) < c.y.min(d.y) || c.y.max(d.y) < a.y.min(b.y) {
        return false;
    }
    // The share of an edge on either side of the other's line.
    let apart = |[p, q]: [DVec2; 2], [r, s]: [DVec2; 2]| {
        let [one, two] = [r, s].map(|x| (q - p).perp_dot(x - p));
        let least = 1e-6 * (one.abs() + two.abs()).max(1e-6 * (q - p).length() * (s - r).length());
        one * two < 0.0 && one.abs() > least && two.abs() > least
    };
    apart([*a, *b], [*c, *d]) && apart([*c, *d], [*a, *b])
}

/// A part of a curve on which v only grows or only falls.
struct Rise {
    curve: BezierCurve,
    range: [f64; 2],
    /// A box's u.
    across: [f64; 2],
}

/// Positive weights and control points in order make a curve monotone (variation diminution).
fn rises(curve: BezierCurve, halvings: usize, out: &mut Vec<Rise>) {
    let heights: Vec<f64> = curve.points().iter().map(|p| p.y / p.w).collect();
    let monotone = heights.windows(2).all(|w| w[0] <= w[1]) || heights.windows(2).all(|w| w[0] >= w[1]);
    if !monotone && halvings < MAX_HALVINGS {
        for half in [[0.0, 0.5], [0.5, 1.0]] {
            rises(curve.restrict(half), halvings + 1, out);
        }
        return;
    }
    let [a, b] = [heights[0], heights[heights.len() - 1]];
    if a != b {
        let places = curve.points().iter().map(|p| p.x / p.w);
        let across = places.fold([f64::INFINITY, f64::NEG_INFINITY], |[low, high], u| [low.min(u), high.max(u)]);
        out.push(Rise { range: [a.min(b), a.max(b)], across, curve });
    }
}

impl Rise {
    /// Where the curve has the height v, which lies in its range.
    fn across(&self, v: f64) -> f64 {
        let points = self.curve.points();
        let [a, b] = [points[0], points[points.len() - 1]].map(|p| p.truncate().truncate() / p.w);
        if self.curve.degree() == 1 {
            return a.x + (b.x - a.x) * ((v - a.y) / (b.y - a.y));
        }
        let up = b.y > a.y;
        let [mut low, mut high] = [0.0, 1.0];
        while high - low > 1e-15 {
            let middle = 0.5 * (low + high);
            if middle == low || middle == high {
                break;
            }
            if (self.curve.position(middle).y < v) == up { low = middle } else { high = middle }
        }
        self.curve.position(0.5 * (low + high)).x
    }
}

/// Heights where parts of outlines cross: rows have kinks there. Sought between as many rows as a quartic needs.
fn crossings(parts: &[Rise]) -> Vec<f64> {
    let mut heights = Vec::new();
    for (k, part) in parts.iter().enumerate() {
        for other in &parts[k + 1..] {
            let [low, high] = [part.range[0].max(other.range[0]), part.range[1].min(other.range[1])];
            if low >= high || part.across[0] > other.across[1] || other.across[0] > part.across[1] {
                continue;
            }
            let apart = |v: f64| part.across(v) - other.across(v);
            let row = |k: usize| low + (high - low) * (k as f64 / SAMPLES as f64);
            for k in 0..SAMPLES {
                let [mut a, mut b] = [row(k), row(k + 1)];
                let below = apart(a) < 0.0;
                if below == (apart(b) < 0.0) {
                    continue;
                }
                for _ in 0..60 {
                    let middle = 0.5 * (a + b);
                    if (apart(middle) < 0.0) == below { a = middle } else { b = middle }
                }
                heights.push(0.5 * (a + b));
            }
        }
    }
    heights
}

/// The area inside an odd number of outlines, to about `tolerance` of it.
pub(super) fn odd_even(sheet: &Sheet, outlines: &[Outline], tolerance: f64) -> Estimate {
    let mut parts = Vec::new();
    outlines.iter().flatten().for_each(|curve| rises((*curve).clone(), 0, &mut parts));
    let ends = parts.iter().flat_map(|part| part.range);
    let mut stops: Vec<f64> = ends.chain(crossings(&parts)).chain(sheet.rows()).collect();
    stops.sort_by(f64::total_cmp);
    stops.dedup();
    let row = |v: f64| {
        let here = parts.iter().filter(|part| part.range[0] <= v && v < part.range[1]);
        let mut across: Vec<f64> = here.map(|part| part.across(v)).collect();
        across.sort_by(f64::total_cmp);
        across.chunks_exact(2).map(|span| sheet.along([span[0], span[1]], v)).sum::<f64>()
    };
    let rule = |[a, b]: [f64; 2]| (b - a) * GAUSS.iter().map(|(x, weight)| weight * row(a + x * (b - a))).sum::<f64>();
    let mut work: Vec<([f64; 2], f64)> = stops.windows(2).map(|w| [w[0], w[1]]).map(|w| (w, rule(w))).collect();
    let whole: f64 = work.iter().map(|w| w.1).sum();
    let mut sum = Estimate { value: 0.0, error: sheet.error() * whole };
    let mut count = work.len();
    while let Some(([a, b], value)) = work.pop() {
        let middle = 0.5 * (a + b);
        let halves = [[a, middle], [middle, b]].map(|half| (half, rule(half)));
        let fine = halves[0].1 + halves[1].1;
        let change = (fine - value).abs();
        // A crossing or an end of a row makes a kink: only the intervals next to it go on being halved.
        if change > 1e-2 * tolerance * whole && count < MAX_PARTS && middle > a && middle < b {
            count += 1;
            work.extend(halves);
        } else {
            sum.value += fine;
            sum.error += change;
        }
    }
    sum
}
