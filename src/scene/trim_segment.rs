//! Trim curves as segments that are monotone in u and in v, and on which side of one a point lies.
//!
//! A segment over any part of its parameter lies in the box of that part's end points. So bisection decides a point's
//! side as soon as the point leaves the box between the brackets, mostly after one or two evaluations (Schollmeyer &
//! Fröhlich, "Direct trimming of NURBS surfaces on the GPU", 2009, section 4).

use crate::geometry::BezierCurve;
use glam::{DVec3, DVec4};

/// Evaluations that decide a point's side; doubles have no more bits.
const STEPS: usize = 128;
/// Splits of a curve in search of monotone parts: what turns even then goes as it is, kept between its ends.
const MAX_DEPTH: usize = 20;
/// Points of the curves that fits make, at most.
pub(super) const FEW: usize = 9;
/// Differences below this share of the curve's largest coordinate are rounding.
const ROUNDING: f64 = 64.0 * f64::EPSILON;

/// A monotone piece of a trim curve, from its lower end (smaller v) to its upper.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Segment {
    /// `[u, v]`, `ends[0][1] <= ends[1][1]`.
    pub ends: [[f64; 2]; 2],
    /// `TrimCurve::gap`, in the part's units.
    pub gap: f64,
    /// Its homogeneous points `(wu, wv, w)` in the list they were added to; none for straight ones.
    pub(crate) first: u32,
    pub(crate) count: u32,
}

/// A box of the parameter plane: `[u, v]` of its lowest and its highest corner.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterBox {
    pub low: [f64; 2],
    pub high: [f64; 2],
}

impl ParameterBox {
    pub const EMPTY: Self = Self { low: [f64::INFINITY; 2], high: [f64::NEG_INFINITY; 2] };

    /// The box of a patch's domain `[[u0, u1], [v0, v1]]`.
    pub fn of_domain([u, v]: [[f64; 2]; 2]) -> Self {
        Self { low: [u[0], v[0]], high: [u[1], v[1]] }
    }

    pub fn around([a, b]: [[f64; 2]; 2]) -> Self {
        Self { low: [a[0].min(b[0]), a[1].min(b[1])], high: [a[0].max(b[0]), a[1].max(b[1])] }
    }

    pub fn center(&self) -> [f64; 2] {
        [0, 1].map(|k| self.low[k] * 0.5 + self.high[k] * 0.5)
    }

    pub fn union(&self, other: &Self) -> Self {
        Self {
            low: [0, 1].map(|k| self.low[k].min(other.low[k])),
            high: [0, 1].map(|k| self.high[k].max(other.high[k])),
        }
    }

    /// Larger by `by[k]` on both sides.
    pub fn grown(&self, by: [f64; 2]) -> Self {
        Self { low: [0, 1].map(|k| self.low[k] - by[k]), high: [0, 1].map(|k| self.high[k] + by[k]) }
    }

    /// The closed boxes share a point.
    pub fn touches(&self, other: &Self) -> bool {
        (0..2).all(|k| self.low[k] <= other.high[k] && other.low[k] <= self.high[k])
    }
}

impl Segment {
    pub fn line(a: [f64; 2], b: [f64; 2], gap: f64) -> Self {
        let ends = if a[1] <= b[1] { [a, b] } else { [b, a] };
        Self { ends, gap, first: 0, count: 0 }
    }

    /// The same segment where its points' list stands `offset` further on.
    pub fn moved(self, offset: u32) -> Self {
        Self { first: self.first + offset, ..self }
    }

    pub fn bounds(&self) -> ParameterBox {
        ParameterBox::around(self.ends)
    }

    /// Its homogeneous points `(wu, wv, w)`; none where it is straight.
    pub fn points<'a>(&self, points: &'a [DVec3]) -> &'a [DVec3] {
        &points[self.first as usize..(self.first + self.count) as usize]
    }

    fn rises(&self) -> bool {
        self.ends[1][0] >= self.ends[0][0]
    }

    /// The point at `t`, between the ends whatever rounding does.
    fn at(&self, points: &[DVec3], t: f64) -> [f64; 2] {
        let [a, b] = self.ends;
        if self.count == 0 {
            return [a[0] + (b[0] - a[0]) * t, a[1] + (b[1] - a[1]) * t];
        }
        let p = homogeneous(self.points(points), t);
        let bounds = self.bounds();
        [(p.x / p.z).clamp(bounds.low[0], bounds.high[0]), (p.y / p.z).clamp(bounds.low[1], bounds.high[1])]
    }

    /// Follows the segment to the value `x` of coordinate `axis`, which lies between its ends: brackets shrink until
    /// `decided` says something of the two points between which the segment passes `x`.
    fn follow<T>(
        &self,
        points: &[DVec3],
        axis: usize,
        x: f64,
        decided: impl Fn([[f64; 2]; 2]) -> Option<T>,
        otherwise: impl Fn([[f64; 2]; 2]) -> T,
    ) -> T {
        // a: not beyond x, b: beyond it.
        let upwards = self.ends[0][axis] <= self.ends[1][axis];
        let ([mut ta, mut tb], mut a, mut b) = match upwards {
            true => ([0.0, 1.0], self.ends[0], self.ends[1]),
            false => ([1.0, 0.0], self.ends[1], self.ends[0]),
        };
        for step in 0..STEPS {
            if let Some(value) = decided([a, b]) {
                return value;
            }
            let width = b[axis] - a[axis];
            // Every third step halves: the others may creep.
            let share = if step % 3 == 2 || width <= 0.0 { 0.5 } else { ((x - a[axis]) / width).clamp(0.01, 0.99) };
            let t = ta + (tb - ta) * share;
            if t == ta || t == tb {
                break;
            }
            let p = self.at(points, t);
            if p[axis] <= x {
                (ta, a) = (t, p);
            } else {
                (tb, b) = (t, p);
            }
        }
        otherwise([a, b])
    }

    /// The other coordinate where coordinate `axis` is `x`; what is beyond an end gives that end. Told as a `place`, a
    /// monotone function of it: the segment is followed no farther than its place takes.
    pub fn crossing<T: PartialEq>(&self, points: &[DVec3], axis: usize, x: f64, place: impl Fn(f64) -> T) -> T {
        let [a, b] = self.ends;
        let other = 1 - axis;
        let (low, high) = if a[axis] <= b[axis] { (a, b) } else { (b, a) };
        if x <= low[axis] {
            return place(low[other]);
        }
        if x >= high[axis] {
            return place(high[other]);
        }
        if self.count == 0 {
            return place(between(a, b, axis, x));
        }
        let decided = |[a, b]: [[f64; 2]; 2]| {
            let here = place(a[other]);
            (here == place(b[other])).then_some(here)
        };
        self.follow(points, axis, x, decided, |[a, b]| place(between(a, b, axis, x)))
    }

    /// The segment passes the height `v`, within its ends', at a larger u than `u`.
    pub fn is_right_of(&self, points: &[DVec3], p: [f64; 2]) -> bool {
        self.compares(points, p, |at, u| at > u)
    }

    /// The segment passes the height of `p` where `holds` says so of its u and the point's: a comparison.
    fn compares(&self, points: &[DVec3], [u, v]: [f64; 2], holds: impl Fn(f64, f64) -> bool) -> bool {
        // What holds at both brackets holds between them.
        let decided = |[a, b]: [[f64; 2]; 2]| {
            let here = holds(a[0], u);
            (here == holds(b[0], u)).then_some(here)
        };
        if let Some(answer) = decided(self.ends) {
            return answer;
        }
        if self.count == 0 {
            return holds(between(self.ends[0], self.ends[1], 1, v), u);
        }
        self.follow(points, 1, v, decided, |[a, b]| holds(between(a, b, 1, v), u))
    }

    /// The segment has a point in the closed box.
    pub fn meets(&self, points: &[DVec3], within: &ParameterBox) -> bool {
        if !self.bounds().touches(within) {
            return false;
        }
        // Both corners across the segment's direction must be on different sides.
        let [a, b] = self.ends;
        let (low, high) = (within.low, within.high);
        let [left, right] = if self.rises() { [[low[0], high[1]], [high[0], low[1]]] } else { [low, high] };
        // Beyond the segment's height only one side is left, given that the boxes touch.
        let passes = |p: [f64; 2], holds: fn(f64, f64) -> bool| {
            if p[1] <= a[1] {
                holds(a[0], p[0])
            } else if p[1] >= b[1] {
                holds(b[0], p[0])
            } else {
                self.compares(points, p, holds)
            }
        };
        !passes(left, |at, u| at < u) && !passes(right, |at, u| at > u)
    }

    /// Some point of the segment is carried by `image` into the box of half sizes `half` about the origin; parts are
    /// told apart down to an eighth of it.
    pub fn comes_near(&self, points: &[DVec3], image: &impl Fn([f64; 2]) -> [f64; 3], half: [f64; 3]) -> bool {
        self.part_comes_near(points, image, half, [0.0, 1.0], self.ends)
    }

    fn part_comes_near(
        &self,
        points: &[DVec3],
        image: &impl Fn([f64; 2]) -> [f64; 3],
        half: [f64; 3],
        [ta, tb]: [f64; 2],
        [a, b]: [[f64; 2]; 2],
    ) -> bool {
        let corners = [a, b, [a[0], b[1]], [b[0], a[1]]].map(image);
        let range =
            |k: usize| corners.iter().fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), c| (l.min(c[k]), h.max(c[k])));
        let ranges = [0, 1, 2].map(range);
        // What is not a number is not near.
        if !(0..3).all(|k| ranges[k].0 <= half[k] && ranges[k].1 >= -half[k]) {
            return false;
        }
        let t = 0.5 * (ta + tb);
        let inside = |p: [f64; 3]| (0..3).all(|k| p[k].abs() <= half[k]);
        let small = (0..3).all(|k| ranges[k].1 - ranges[k].0 <= 0.125 * half[k]) || t == ta || t == tb;
        if small || inside(corners[0]) || inside(corners[1]) {
            return true;
        }
        let p = self.at(points, t);
        self.part_comes_near(points, image, half, [ta, t], [a, p])
            || self.part_comes_near(points, image, half, [t, tb], [p, b])
    }
}

/// The other coordinate of the straight line from a to b where coordinate `axis` is `x`, between theirs.
fn between(a: [f64; 2], b: [f64; 2], axis: usize, x: f64) -> f64 {
    let other = 1 - axis;
    let width = b[axis] - a[axis];
    let share = if width == 0.0 { 0.5 } else { (x - a[axis]) / width };
    let (low, high) = (a[other].min(b[other]), a[other].max(b[other]));
    (a[other] + (b[other] - a[other]) * share).clamp(low, high)
}

/// The homogeneous point at `t`. Twin: kernels/trim_tree.cuh.
fn homogeneous(points: &[DVec3], t: f64) -> DVec3 {
    let s = 1.0 - t;
    match *points {
        [a, b, c] => (a * s + b * (2.0 * t)) * s + c * (t * t),
        [a, b, c, d] => ((a * s + b * (3.0 * t)) * s + c * (3.0 * (t * t))) * s + d * (t * t * t),
        [first, ref others @ ..] => horner(first, others, t),
        [] => DVec3::ZERO,
    }
}

/// Horner's scheme in Bernstein form: no room for a column of points is needed, on a GPU either.
fn horner(first: DVec3, others: &[DVec3], t: f64) -> DVec3 {
    let (s, degree) = (1.0 - t, others.len());
    let (mut sum, mut power, mut choose) = (first, 1.0, 1.0);
    for (k, &point) in (1..).zip(others) {
        power *= t;
        choose = choose * (degree + 1 - k) as f64 / k as f64;
        sum = sum * s + point * (choose * power);
    }
    sum
}

/// Appends the monotone segments of a curve that runs from `start` to `end` (its own ends, but for rounding).
///
/// A rational curve with positive weights crosses no line more often than its control polygon does (variation
/// diminishing): where the control points' u runs one way, the curve's does, and likewise v.
pub fn split(
    curve: &BezierCurve,
    [start, end]: [[f64; 2]; 2],
    gap: f64,
    segments: &mut Vec<Segment>,
    points: &mut Vec<DVec3>,
) {
    if curve.degree() == 1 {
        return segments.push(Segment::line(start, end, gap));
    }
    let size = reach_of(curve);
    let mut stack = vec![(curve.clone(), start, end, 0)];
    while let Some((part, start, end, depth)) = stack.pop() {
        let turns = [0, 1].map(|axis| turn(&part, axis, size));
        let t = match turns {
            _ if depth == MAX_DEPTH => {
                segments.push(curved(&part, [start, end], gap, points));
                continue;
            }
            [Turn::None, Turn::None] => {
                segments.push(curved(&part, [start, end], gap, points));
                continue;
            }
            [Turn::At(t), _] | [_, Turn::At(t)] => t,
            _ => 0.5,
        };
        let [low, high] = [part.restrict([0.0, t]), part.restrict([t, 1.0])];
        let middle = plane_point(high.points()[0]);
        // The lower part is looked at first: segments come in the curve's order.
        stack.push((high, middle, end, depth + 1));
        stack.push((low, start, middle, depth + 1));
    }
}

fn curved(part: &BezierCurve, [start, end]: [[f64; 2]; 2], gap: f64, points: &mut Vec<DVec3>) -> Segment {
    let flat = |p: &DVec4| DVec3::new(p.x, p.y, p.w);
    let (first, count) = (points.len() as u32, part.points().len() as u32);
    if start[1] <= end[1] {
        points.extend(part.points().iter().map(flat));
        Segment { ends: [start, end], gap, first, count }
    } else {
        points.extend(part.points().iter().rev().map(flat));
        Segment { ends: [end, start], gap, first, count }
    }
}

/// A homogeneous curve point in the plane.
pub fn plane_point(p: DVec4) -> [f64; 2] {
    [p.x / p.w, p.y / p.w]
}

/// Largest magnitude of either coordinate: what rounding goes by.
fn reach_of(curve: &BezierCurve) -> [f64; 2] {
    let points = curve.points().iter().map(|&p| plane_point(p));
    points.fold([0.0; 2], |r: [f64; 2], p| [0, 1].map(|k| r[k].max(p[k].abs())))
}

/// Whether a coordinate of a curve turns round.
enum Turn {
    None,
    At(f64),
    /// It may, more than once.
    Unknown,
}

fn turn(part: &BezierCurve, axis: usize, size: [f64; 2]) -> Turn {
    let values = || part.points().iter().map(|&p| plane_point(p)[axis]);
    let rounding = ROUNDING * size[axis];
    let mut changes = 0;
    let mut direction = 0.0;
    for (a, b) in values().zip(values().skip(1)) {
        let step = b - a;
        if step.abs() > rounding {
            changes += usize::from(step * direction < 0.0);
            direction = step;
        }
    }
    match changes {
        0 => Turn::None,
        1 => extreme(part, axis),
        _ => Turn::Unknown,
    }
}

/// Where a coordinate with one turn of its control points turns: brackets about the zero of the derivative.
fn extreme(part: &BezierCurve, axis: usize) -> Turn {
    let slope = |t: f64| {
        let (p, d) = part.jet(t);
        d[axis] * p.w - p[axis] * d.w
    };
    let (mut a, mut b) = ((0.0, slope(0.0)), (1.0, slope(1.0)));
    let from = a.1;
    if from * b.1 >= 0.0 {
        return Turn::Unknown;
    }
    for step in 0..STEPS {
        // The secant comes close from one side; kept off the ends it soon brings up the other one. Every third step halves.
        let share = if step % 3 == 2 { 0.5 } else { (a.1 / (a.1 - b.1)).clamp(0.01, 0.99) };
        let t = a.0 + (b.0 - a.0) * share;
        if t == a.0 || t == b.0 {
            break;
        }
        let here = (t, slope(t));
        if here.1 * from > 0.0 { a = here } else { b = here }
    }
    Turn::At(0.5 * (a.0 + b.0))
}
