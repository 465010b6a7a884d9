//! Area of the part of a surface that trim loops leave, by Green's theorem.
//!
//! With g the area of the surface over a unit of its parameter plane and `F(u, v)` the integral of g along u from any
//! fixed start, a loop encloses the curve integral of `F dv`. Its integrand is smooth wherever surface and curve are, so
//! Gauss quadrature along each curve converges fast and nothing is cut.

use super::area::{Estimate, GAUSS};
use super::crossing_area::{cross, odd_even};
use super::{BezierCurve, Net};
use glam::{DMat3, DVec2, DVec3};

/// A patch and its rectangle `[[u0, u1], [v0, v1]]` in the parameter plane; the tiles of a surface do not overlap.
#[derive(Clone, Copy, Debug)]
pub struct Tile<'a> {
    pub net: Net<'a>,
    pub domain: [[f64; 2]; 2],
}

/// A closed sequence of curves in the parameter plane.
pub type Outline<'a> = Vec<&'a BezierCurve>;

/// Curve parts that one outline may be cut into.
const MAX_PARTS: usize = 1 << 14;
/// Cells along u that one tile may be cut into.
const MAX_CELLS: usize = 64;
/// Points a curve by which loops are told to be inside others.
const SAMPLES: usize = 8;

/// Area inside `outlines` by the odd-even rule, after the linear map `map`, in squared units, to about `tolerance` of it;
/// the stated error is an estimate. Which way outlines run does not matter. Where they cross each other or themselves
/// rows are summed instead, which takes longer.
pub fn trimmed_area(tiles: &[Tile], outlines: &[Outline], map: DMat3, tolerance: f64) -> Estimate {
    let Some(sheet) = Sheet::new(tiles, map, tolerance) else { return Estimate::default() };
    if cross(outlines) {
        return odd_even(&sheet, outlines, tolerance);
    }
    let inside = depths(outlines);
    let mut sum = Estimate::default();
    for (outline, depth) in outlines.iter().zip(inside) {
        let part = sheet.enclosed(outline, tolerance);
        sum.value += if depth % 2 == 0 { part.value.abs() } else { -part.value.abs() };
        sum.error += part.error;
    }
    Estimate { value: sum.value.max(0.0), error: sum.error }
}

/// A surface as `F` needs it.
pub(super) struct Sheet<'a> {
    cells: Vec<Strip<'a>>,
    map: DMat3,
    /// Heights at which it lies.
    range: [f64; 2],
    /// Where tiles begin and end in u and in v, sorted: g may jump there.
    borders: [Vec<f64>; 2],
    /// Of F, relative.
    error: f64,
}

struct Strip<'a> {
    tile: Tile<'a>,
    /// g where it is the same everywhere.
    constant: Option<f64>,
    /// Gauss cells along u.
    cells: usize,
}

impl<'a> Sheet<'a> {
    fn new(tiles: &[Tile<'a>], map: DMat3, tolerance: f64) -> Option<Self> {
        let low = tiles.iter().map(|t| t.domain[1][0]).fold(f64::INFINITY, f64::min);
        let high = tiles.iter().map(|t| t.domain[1][1]).fold(f64::NEG_INFINITY, f64::max);
        if low >= high || tiles.is_empty() {
            return None;
        }
        let borders = [0, 1].map(|axis| {
            let mut ends: Vec<f64> = tiles.iter().flat_map(|t| t.domain[axis]).collect();
            ends.sort_unstable_by(f64::total_cmp);
            ends.dedup();
            ends
        });
        let mut sheet = Self { cells: Vec::with_capacity(tiles.len()), map, range: [low, high], borders, error: 0.0 };
        for &tile in tiles {
            let mut strip = Strip { tile, constant: constant(&tile, map), cells: 1 };
            if strip.constant.is_none() {
                let error = strip.refine(map, 0.1 * tolerance);
                sheet.error = sheet.error.max(error);
            }
            sheet.cells.push(strip);
        }
        Some(sheet)
    }

    /// Of F, relative.
    pub fn error(&self) -> f64 {
        self.error
    }

    /// Where rows of tiles meet.
    pub fn rows(&self) -> impl Iterator<Item = f64> + '_ {
        self.borders[1].iter().copied()
    }

    /// The integral of g over u from `start` to `end` at height v.
    pub fn along(&self, [start, end]: [f64; 2], v: f64) -> f64 {
        // The topmost tiles are closed, the others have no upper border: each height has one row.
        let v = v.clamp(self.range[0], self.range[1].next_down());
        let (low, high, sign) = if start <= end { (start, end, 1.0) } else { (end, start, -1.0) };
        let strips = self.cells.iter().filter(|s| s.tile.domain[1][0] <= v && v < s.tile.domain[1][1]);
        sign * strips.map(|s| s.along([low, high], v, self.map)).sum::<f64>()
    }

    /// What an outline encloses; negative where it runs clockwise.
    fn enclosed(&self, outline: &[&BezierCurve], tolerance: f64) -> Estimate {
        let Some(first) = outline.first() else { return Estimate::default() };
        let base = first.position(0.0).x;
        let rule = |curve: &BezierCurve, [a, b]: [f64; 2]| -> f64 {
            let node = |&(x, weight): &(f64, f64)| {
                let (p, tangent) = curve.tangent(a + x * (b - a));
                if tangent.y == 0.0 { 0.0 } else { weight * tangent.y * self.along([base, p.x], p.y) }
            };
            GAUSS.iter().map(node).sum::<f64>() * (b - a)
        };
        // A curve and its parts: range, and what one rule says of it.
        let mut work: Vec<(&BezierCurve, [f64; 2], f64)> = outline
            .iter()
            .flat_map(|&curve| self.smooth_parts(curve).into_iter().map(move |part| (curve, part)))
            .map(|(curve, part)| (curve, part, rule(curve, part)))
            .collect();
        let rough: f64 = work.iter().map(|w| w.2.abs()).sum();
        let allowed = tolerance * rough / outline.len() as f64;
        let mut sum = Estimate { value: 0.0, error: self.error * rough };
        let mut parts = work.len();
        while let Some((curve, [a, b], whole)) = work.pop() {
            let middle = 0.5 * (a + b);
            let halves = [[a, middle], [middle, b]].map(|range| (range, rule(curve, range)));
            let change = (halves[0].1 + halves[1].1 - whole).abs();
            // Parts get their share of the tolerance; what is not a number ends here as well.
            if change > allowed * (b - a).max(1e-3) && parts < MAX_PARTS {
                parts += 1;
                work.extend(halves.map(|(range, value)| (curve, range, value)));
            } else {
                sum.value += halves[0].1 + halves[1].1;
                sum.error += change;
            }
        }
        sum
    }
}

impl Sheet<'_> {
    /// A straight line between its crossings of tile borders; other curves cross none where g jumps.
    fn smooth_parts(&self, curve: &BezierCurve) -> Vec<[f64; 2]> {
        let (a, b) = (curve.position(0.0), curve.position(1.0));
        let mut cuts = vec![0.0, 1.0];
        if curve.degree() == 1 && curve.points()[0].w == curve.points()[1].w {
            for (borders, a, b) in [(&self.borders[0], a.x, b.x), (&self.borders[1], a.y, b.y)] {
                let inside = |v: &&f64| a.min(b) < **v && **v < a.max(b);
                cuts.extend(borders.iter().filter(inside).map(|v| (v - a) / (b - a)));
            }
            cuts.sort_unstable_by(f64::total_cmp);
        }
        cuts.windows(2).map(|w| [w[0], w[1]]).filter(|[from, to]| from < to).collect()
    }
}

impl Strip<'_> {
    /// The integral of g over the part of `[low, high]` on this tile, at height v.
    fn along(&self, [low, high]: [f64; 2], v: f64, map: DMat3) -> f64 {
        let [[u0, u1], [v0, v1]] = self.tile.domain;
        let (a, b) = (low.max(u0), high.min(u1));
        if a >= b {
            return 0.0;
        }
        if let Some(g) = self.constant {
            return g * (b - a);
        }
        let (from, to) = ((a - u0) / (u1 - u0), (b - u0) / (u1 - u0));
        self.row([from, to], (v - v0) / (v1 - v0), map, self.cells) / (v1 - v0)
    }

    /// The same in the patch's own parameters, with so many cells for all of it.
    fn row(&self, [from, to]: [f64; 2], v: f64, map: DMat3, cells: usize) -> f64 {
        let count = ((to - from) * cells as f64).ceil().max(1.0);
        let width = (to - from) / count;
        let mut sum = 0.0;
        for cell in 0..count as usize {
            for (x, weight) in GAUSS {
                let point = self.tile.net.surface_point(from + (cell as f64 + x) * width, v);
                sum += weight * (map * point.du).cross(map * point.dv).length();
            }
        }
        sum * width
    }

    /// Doubles the cells until rows settle to `tolerance`; returns what they are off by, relative.
    fn refine(&mut self, map: DMat3, tolerance: f64) -> f64 {
        let rows = |cells: usize| [0.07, 0.37, 0.63, 0.93].map(|v| self.row([0.0, 1.0], v, map, cells));
        let mut cells = 1;
        let mut coarse = rows(cells);
        loop {
            cells *= 2;
            let fine = rows(cells);
            let whole: f64 = fine.iter().sum();
            let change: f64 = coarse.iter().zip(fine).map(|(a, b)| (a - b).abs()).sum();
            // Halving cells makes the error of the rule about 2^-10 of what it was.
            let error = change / whole.max(f64::MIN_POSITIVE) / 64.0;
            if error.is_nan() || error <= tolerance || cells >= MAX_CELLS {
                self.cells = cells;
                return error;
            }
            coarse = fine;
        }
    }
}

/// g, in the parameter plane, of a parallelogram.
fn constant(tile: &Tile, map: DMat3) -> Option<f64> {
    let net = tile.net;
    if net.degree() != [1, 1] || net.is_rational() {
        return None;
    }
    let point = |i: usize, j: usize| net.point(i, j).truncate() / net.point(i, j).w;
    let (u, v) = (point(1, 0) - point(0, 0), point(0, 1) - point(0, 0));
    let twist: DVec3 = point(1, 1) - point(0, 0) - u - v;
    let [[u0, u1], [v0, v1]] = tile.domain;
    let size = u.length().max(v.length());
    (twist.length() <= 1e-13 * size).then(|| (map * u).cross(map * v).length() / ((u1 - u0) * (v1 - v0)))
}

/// In how many others each outline lies.
fn depths(outlines: &[Outline]) -> Vec<usize> {
    if outlines.len() < 2 {
        return vec![0; outlines.len()];
    }
    let polygon = |outline: &Outline| -> Vec<DVec2> {
        let count = |curve: &BezierCurve| if curve.degree() == 1 { 1 } else { SAMPLES };
        let points = |curve: &&BezierCurve| {
            let (curve, n) = (*curve, count(curve));
            (0..n).map(|k| curve.position(k as f64 / n as f64).truncate()).collect::<Vec<_>>()
        };
        outline.iter().flat_map(points).collect()
    };
    let polygons: Vec<_> = outlines.iter().map(polygon).collect();
    let boxes: Vec<_> = (polygons.iter())
        .map(|p| p.iter().fold((DVec2::INFINITY, DVec2::NEG_INFINITY), |(l, h), &q| (l.min(q), h.max(q))))
        .collect();
    let inner: Vec<_> = polygons.iter().zip(&boxes).map(|(p, &(low, high))| inner_point(p, [low, high])).collect();
    let is_in = |k: usize, other: usize| {
        let ((low, high), (l, h)) = (boxes[k], boxes[other]);
        // An outline that lies in another can't reach beyond its box; its polygon hardly.
        let slack = (h - l) * 0.1;
        k != other
            && low.cmpge(l - slack).all()
            && high.cmple(h + slack).all()
            && (high - low).element_product() < (h - l).element_product()
            && is_inside(inner[k], &polygons[other])
    };
    (0..outlines.len()).map(|k| (0..outlines.len()).filter(|&other| is_in(k, other)).count()).collect()
}

/// A point well inside a polygon: the middle of the widest of some spans across it.
fn inner_point(polygon: &[DVec2], [low, high]: [DVec2; 2]) -> DVec2 {
    let (mut widest, mut inner) = (-1.0, low);
    for part in [0.31, 0.52, 0.77] {
        let y = low.y + part * (high.y - low.y);
        let crossing = |k: usize| {
            let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
            ((a.y > y) != (b.y > y)).then(|| a.x + (b.x - a.x) * ((y - a.y) / (b.y - a.y)))
        };
        let mut across: Vec<f64> = (0..polygon.len()).filter_map(crossing).collect();
        across.sort_unstable_by(f64::total_cmp);
        for span in across.chunks_exact(2) {
            if span[1] - span[0] > widest {
                (widest, inner) = (span[1] - span[0], DVec2::new(0.5 * (span[0] + span[1]), y));
            }
        }
    }
    inner
}

fn is_inside(p: DVec2, polygon: &[DVec2]) -> bool {
    let crosses = |k: usize| {
        let (a, b) = (polygon[k], polygon[(k + 1) % polygon.len()]);
        (a.y > p.y) != (b.y > p.y) && ((b - a).perp_dot(p - a) > 0.0) == (b.y > a.y)
    };
    (0..polygon.len()).filter(|&k| crosses(k)).count() % 2 == 1
}
