//! Is a point of the parameter plane inside a face's trim loops? On the exact curves, by the odd-even rule.

use crate::geometry::BezierCurve;
use crate::model::Loop;
use glam::{DVec2, DVec4};

/// The loops of one face, with rows of the plane that list the curves in them.
#[derive(Debug)]
pub(super) struct Region<'a> {
    curves: Vec<Side<'a>>,
    low: DVec2,
    high: DVec2,
    /// Curves of row k: `listed[starts[k]..starts[k + 1]]`.
    starts: Vec<u32>,
    listed: Vec<u32>,
}

/// A curve of a loop. It ends where the next one starts, whatever rounding its own last control point has.
#[derive(Debug)]
struct Side<'a> {
    curve: &'a BezierCurve,
    end: DVec2,
    low: DVec2,
    high: DVec2,
}

/// Entries a curve may have in the lists, on average.
const ENTRIES_A_CURVE: usize = 8;

/// Halvings before a piece counts as straight: below that a double has no more digits.
const MAX_HALVINGS: u32 = 52;

/// A control point of a plane curve.
fn plane(q: &DVec4) -> DVec2 {
    q.truncate().truncate() / q.w
}

/// Box of control points and an end.
fn hull(points: &[DVec4], end: DVec2) -> (DVec2, DVec2) {
    points.iter().map(plane).fold((end, end), |(low, high), p| (low.min(p), high.max(p)))
}

impl<'a> Region<'a> {
    pub fn new(loops: &'a [Loop]) -> Self {
        let mut curves = Vec::with_capacity(loops.iter().map(|l| l.curves.len()).sum());
        for closed in loops {
            for (k, piece) in closed.curves.iter().enumerate() {
                let next = &closed.curves[(k + 1) % closed.curves.len()].curve;
                let end = plane(&next.points()[0]);
                let (low, high) = hull(piece.curve.points(), end);
                curves.push(Side { curve: &piece.curve, end, low, high });
            }
        }
        let empty = (DVec2::INFINITY, DVec2::NEG_INFINITY);
        let (low, high) = curves.iter().fold(empty, |(l, h), c| (l.min(c.low), h.max(c.high)));
        let mut region = Self { curves, low, high, starts: Vec::new(), listed: Vec::new() };
        region.list_rows();
        region
    }

    /// Memory beside the curves themselves.
    pub fn bytes(&self) -> usize {
        self.curves.capacity() * size_of::<Side>()
            + (self.starts.capacity() + self.listed.capacity()) * size_of::<u32>()
    }

    /// As many rows as curves, fewer where long curves would be listed too often.
    fn list_rows(&mut self) {
        let mut rows = self.curves.len().max(1);
        let entries = |region: &Self, rows: usize| -> usize {
            region.curves.iter().map(|c| region.row(c.high.y, rows) - region.row(c.low.y, rows) + 1).sum()
        };
        while rows > 1 && entries(self, rows) > ENTRIES_A_CURVE * self.curves.len() {
            rows /= 2;
        }
        let mut lists = vec![Vec::new(); rows];
        for (k, curve) in self.curves.iter().enumerate() {
            for list in &mut lists[self.row(curve.low.y, rows)..=self.row(curve.high.y, rows)] {
                list.push(k as u32);
            }
        }
        self.starts.push(0);
        for list in lists {
            self.listed.extend(list);
            self.starts.push(self.listed.len() as u32);
        }
    }

    /// The row of a height; the same height has one row, so a curve is listed wherever it may matter.
    fn row(&self, y: f64, rows: usize) -> usize {
        let at = (y - self.low.y) / (self.high.y - self.low.y) * rows as f64;
        // Casts saturate, and what is not a number (a region without height) becomes 0.
        (at as usize).min(rows - 1)
    }

    /// Odd-even, decided on the exact curves; on a curve itself either answer may come.
    pub fn contains(&self, p: DVec2) -> bool {
        if !(p.cmpge(self.low).all() && p.cmple(self.high).all()) {
            return false;
        }
        let row = self.row(p.y, self.starts.len() - 1);
        let listed = &self.listed[self.starts[row] as usize..self.starts[row + 1] as usize];
        listed.iter().fold(false, |inside, &k| inside ^ self.curves[k as usize].crosses(p))
    }
}

impl Side<'_> {
    /// The curve crosses the ray from `p` in the direction of x an odd number of times.
    fn crosses(&self, p: DVec2) -> bool {
        if p.y < self.low.y || p.y > self.high.y || p.x > self.high.x {
            return false;
        }
        let points = self.curve.points();
        let start = plane(&points[0]);
        if p.x < self.low.x {
            return separates(start, self.end, p);
        }
        if points.len() == 2 {
            return straight_crosses(start, self.end, p);
        }
        odd_crossings(points, start, self.end, p, MAX_HALVINGS)
    }
}

/// The ends lie on different sides of the line of height `p.y`, each on one side only.
fn separates(start: DVec2, end: DVec2, p: DVec2) -> bool {
    (start.y > p.y) != (end.y > p.y)
}

fn straight_crosses(start: DVec2, end: DVec2, p: DVec2) -> bool {
    separates(start, end, p) && ((end - start).perp_dot(p - start) > 0.0) == (end.y > start.y)
}

/// As [`Side::crosses`], for a curve from `start` to `end`. Where the hull lies to one side of `p`, only the ends matter;
/// else the curve is halved.
fn odd_crossings(points: &[DVec4], start: DVec2, end: DVec2, p: DVec2, halvings: u32) -> bool {
    let (low, high) = hull(points, end);
    let (low, high) = (low.min(start), high.max(start));
    if p.y < low.y || p.y > high.y || p.x > high.x {
        return false;
    }
    if p.x < low.x {
        return separates(start, end, p);
    }
    if halvings == 0 || beside(points, start, end, p) {
        return straight_crosses(start, end, p);
    }
    let [first, second] = halves(points);
    let middle = plane(&second[0]);
    odd_crossings(&first, start, middle, p, halvings - 1) ^ odd_crossings(&second, middle, end, p, halvings - 1)
}

/// `p` lies beside the hull, seen along the chord: then the curve can be drawn tight to its chord inside the hull without
/// passing over `p`, and both cross the ray equally often, mod 2.
fn beside(points: &[DVec4], start: DVec2, end: DVec2, p: DVec2) -> bool {
    let chord = end - start;
    let offset = |q: DVec2| chord.perp_dot(q - start);
    let at = offset(p);
    // The strip of the hull along the chord's direction.
    let (low, high) =
        points.iter().map(|q| offset(plane(q))).fold((0.0, 0.0), |(l, h): (f64, f64), o| (l.min(o), h.max(o)));
    at < low || at > high
}

fn halves(points: &[DVec4]) -> [Vec<DVec4>; 2] {
    let mut second = points.to_vec();
    let mut first = Vec::with_capacity(points.len());
    for level in 0..points.len() {
        first.push(second[0]);
        for k in 0..points.len() - 1 - level {
            second[k] = (second[k] + second[k + 1]) * 0.5;
        }
    }
    [first, second]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::model::TrimCurve;

    fn closed(curves: Vec<Vec<DVec4>>) -> Loop {
        let curve = |points| TrimCurve { curve: BezierCurve::new("test", points).unwrap(), gap: 0.0, edge: None };
        Loop { curves: curves.into_iter().map(curve).collect() }
    }

    /// A circle of four rational quadratics.
    fn circle(center: DVec2, radius: f64) -> Loop {
        let w = 0.5_f64.sqrt();
        let corner =
            [(1.0, 0.0), (1.0, 1.0), (0.0, 1.0), (-1.0, 1.0), (-1.0, 0.0), (-1.0, -1.0), (0.0, -1.0), (1.0, -1.0)];
        let point = |k: usize, w: f64| {
            let p = center + DVec2::from(corner[k % 8]) * radius;
            DVec4::new(p.x * w, p.y * w, 0.0, w)
        };
        closed((0..4).map(|k| vec![point(2 * k, 1.0), point(2 * k + 1, w), point(2 * k + 2, 1.0)]).collect())
    }

    fn scattered(k: u32) -> DVec2 {
        let part = |f: f64| (f64::from(k) * f).fract() * 2.6 - 1.3;
        DVec2::new(part(0.754877666), part(0.569840290))
    }

    #[test]
    fn ring_contains_what_its_radii_say() {
        let loops = [circle(DVec2::ZERO, 1.2), circle(DVec2::new(0.3, 0.1), 0.5)];
        let region = Region::new(&loops);
        for k in 0..20_000 {
            let p = scattered(k);
            let expected = p.length() < 1.2 && p.distance(DVec2::new(0.3, 0.1)) > 0.5;
            assert_eq!(region.contains(p), expected, "{p}");
        }
        for k in 0..1000 {
            let direction = DVec2::from_angle(f64::from(k) * 0.00629);
            assert!(region.contains(direction * (1.2 - 1e-13)) && !region.contains(direction * (1.2 + 1e-13)), "{k}");
        }
    }

    #[test]
    fn many_curves_are_found_in_rows() {
        let corner = |k: i32| {
            let (angle, radius) = (f64::from(k % 4000) / 4000.0 * std::f64::consts::TAU, [0.5, 1.2][(k % 2) as usize]);
            (DVec2::from_angle(angle) * radius).extend(0.0).extend(1.0)
        };
        let loops = [closed((0..4000).map(|k| vec![corner(k), corner(k + 1)]).collect())];
        let region = Region::new(&loops);
        let sides: Vec<[DVec2; 2]> = (0..4000).map(|k| [corner(k), corner(k + 1)].map(|q| plane(&q))).collect();
        for k in 0..2000 {
            let p = scattered(k);
            let crossed = sides.iter().filter(|[a, b]| straight_crosses(*a, *b, p)).count();
            assert_eq!(region.contains(p), crossed % 2 == 1, "{p}");
        }
    }

    #[test]
    fn high_degree_and_horizontal_sides() {
        // A closed curve of degree 9 that loops, against its polygon of 4096 sides; and the unit square.
        let points: Vec<DVec4> = (0..=9)
            .map(|k| {
                let angle = f64::from(k) / 9.0 * 2.0 * std::f64::consts::TAU;
                let w = 1.0 + 0.5 * f64::from(k % 3);
                (DVec2::from_angle(angle) * (if k % 2 == 0 || k == 9 { 3.0 } else { 1.0 })).extend(0.0).extend(1.0) * w
            })
            .collect();
        let curve = BezierCurve::new("test", points.clone()).unwrap();
        let loops = [closed(vec![points])];
        let region = Region::new(&loops);
        let at = |k: u32| curve.position(f64::from(k) / 4096.0).truncate();
        let sides: Vec<[DVec2; 2]> = (0..4096).map(|k| [at(k), at(k + 1)]).collect();
        let mut inside = 0;
        for k in 0..3000 {
            let p = scattered(k) * 2.0;
            if sides.iter().any(|[a, b]| a.distance(p).min(b.distance(p)) < 1e-2) {
                continue;
            }
            let odd = sides.iter().filter(|[a, b]| straight_crosses(*a, *b, p)).count() % 2 == 1;
            inside += u32::from(odd);
            assert_eq!(region.contains(p), odd, "{p}");
        }
        assert!(inside > 100, "{inside}");
        let corner = |x: f64, y: f64| DVec4::new(x, y, 0.0, 1.0);
        let corners = [corner(0.0, 0.0), corner(1.0, 0.0), corner(1.0, 1.0), corner(0.0, 1.0)];
        let square = [closed((0..4).map(|k| vec![corners[k], corners[(k + 1) % 4]]).collect())];
        let square = Region::new(&square);
        assert!(square.contains(DVec2::new(0.5, 1e-300)) && !square.contains(DVec2::new(0.5, -1e-300)));
        assert!(square.contains(DVec2::splat(0.5)) && !square.contains(DVec2::new(1.5, 0.5)));
    }
}
