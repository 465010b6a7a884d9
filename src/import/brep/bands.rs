//! Rings that wind around a closed surface, closed in pairs or with a pole or border.

use super::BrepError;
use super::clip::Border;
use super::cover::free;
use super::ring::Ring;
use super::trace::Path;
use crate::geometry::Chart;
use glam::DVec2;

/// Rings closed in the cover.
pub(super) struct Closed<'a> {
    pub rings: Vec<Ring<'a>>,
    /// Where a window of one period starts best.
    pub corner: DVec2,
    /// The rings leave that window: only cut along it do they bound each place once.
    pub cut: bool,
}

/// Rings that wind, closed; `holes` are the face's other rings, which seams avoid where they can.
///
/// # Errors
/// Where rings that wind so would cross each other or themselves, or have no partner.
pub(super) fn close_winding<'a>(
    chart: &Chart,
    winding: Vec<Ring<'a>>,
    holes: &[Ring],
    warnings: &mut Vec<String>,
) -> Result<Closed<'a>, BrepError> {
    let class = winding[0].winding;
    let against = class.map(|w| -w);
    let odd = winding.iter().find(|ring| ring.winding != class && ring.winding != against);
    let [u, v] = odd.map_or(class, |ring| ring.winding);
    if odd.is_some() || gcd(u, v) != 1 {
        return Err(BrepError::Winding { u, v });
    }
    match class {
        [0, _] => Bands { chart, axis: 1 }.close(winding, holes, warnings),
        [_, 0] => Bands { chart, axis: 0 }.close(winding, holes, warnings),
        _ => Diagonal { chart, class }.close(winding),
    }
}

fn gcd(a: i32, b: i32) -> i32 {
    let (mut a, mut b) = (a.abs(), b.abs());
    while b != 0 {
        (a, b) = (b, a % b);
    }
    a
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

    fn close<'a>(
        &self,
        mut rings: Vec<Ring<'a>>,
        holes: &[Ring],
        warnings: &mut Vec<String>,
    ) -> Result<Closed<'a>, BrepError> {
        let seam = self.seam(&rings, holes);
        rings.iter_mut().for_each(|ring| self.rotate(ring, seam));
        let closed = self.pairs(rings, warnings)?;
        let (across, period) = (1 - self.axis, self.chart.periods()[self.axis].unwrap_or(f64::INFINITY));
        let [low, high] = bounds(&closed);
        let cut = high[self.axis] - low[self.axis] > period * (1.0 + 1e-9);
        let mut corner = DVec2::ZERO;
        corner[self.axis] = seam;
        if let Some(period) = self.chart.periods()[across] {
            let taken: Vec<[f64; 2]> = closed.iter().map(|ring| ring.reach().map(|p| p[across])).collect();
            corner[across] = free(period, low[across], &taken);
        }
        Ok(Closed { rings: closed, corner, cut })
    }

    /// Where along the axis a straight seam meets each of the rings once and none of the holes, if there is such a place.
    fn seam(&self, rings: &[Ring], holes: &[Ring]) -> f64 {
        let axis = self.axis;
        let default = rings[0].paths[0].start[axis];
        let Some(period) = self.chart.periods()[axis] else { return default };
        let mut taken: Vec<[f64; 2]> = holes.iter().map(|ring| ring.reach().map(|p| p[axis])).collect();
        for ring in rings {
            let forward = f64::from(ring.winding[axis]);
            let mut before = ring.paths[0].start;
            for p in ring.points() {
                let step = p[axis] - before[axis];
                // Noise in a seam edge is no way back.
                if step * forward < -1e-9 * period {
                    taken.push([p[axis].min(before[axis]), p[axis].max(before[axis])]);
                }
                before = p;
            }
        }
        free(period, default, &taken)
    }

    fn pairs<'a>(&self, mut rings: Vec<Ring<'a>>, warnings: &mut Vec<String>) -> Result<Vec<Ring<'a>>, BrepError> {
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
            closed.push(self.with_end(ring, warnings)?);
        }
        while let Some(ring) = rings.next() {
            match rings.next() {
                Some(other) => closed.push(self.pair(ring, other)),
                None => closed.push(self.with_end(ring, warnings)?),
            }
        }
        Ok(closed)
    }

    /// Where the surface ends across the rings, at its first (0) or last (1) value.
    fn end(&self, end: usize) -> Option<f64> {
        let limit = self.chart.form().limits()[1 - self.axis][end];
        limit.is_finite().then_some(limit)
    }

    /// A ring alone: up to the pole or border on the side of its material.
    fn with_end<'a>(&self, ring: Ring<'a>, warnings: &mut Vec<String>) -> Result<Ring<'a>, BrepError> {
        let across = 1 - self.axis;
        let at = middle(&ring, across);
        if let Some(period) = self.chart.periods()[across] {
            let mut other = ring.clone();
            let mut by = DVec2::ZERO;
            by[across] = period;
            other.shift(by);
            return Ok(self.pair(ring, other));
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
        let end = end.ok_or(BrepError::NoPartner)?;
        let line = self.line(&ring, end);
        Ok(self.pair(ring, line))
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
        let border = Border { axis, at, tolerance: 0.0 };
        let first = if near(path.start[axis]) {
            k
        } else if !near(path.end[axis])
            && let Some(parts) = border.cut(self.chart, &path)
        {
            ring.paths.splice(k..=k, parts);
            k + 1
        } else {
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

fn bounds(rings: &[Ring]) -> [DVec2; 2] {
    let bounds = rings.iter().map(Ring::bounds);
    bounds.fold([DVec2::INFINITY, DVec2::NEG_INFINITY], |[a, b], [p, q]| [a.min(p), b.max(q)])
}

fn reversed(ring: Ring<'_>) -> Ring<'_> {
    Ring {
        paths: ring.paths.into_iter().rev().map(Path::reversed).collect(),
        winding: ring.winding.map(|w| -w),
        bridged: ring.bridged,
    }
}

/// Rings that wind around both parameters, all of them as often.
struct Diagonal<'b> {
    chart: &'b Chart,
    class: [i32; 2],
}

impl Diagonal<'_> {
    fn periods(&self) -> DVec2 {
        self.chart.periods().map(|period| period.unwrap_or(0.0)).into()
    }

    /// How far to the left of the rings' way a point is: moving by a whole period of either parameter changes it by a
    /// whole number, and there is such a move that changes it by 1.
    fn left(&self, p: DVec2) -> f64 {
        let q = p / self.periods();
        f64::from(self.class[0]) * q.y - f64::from(self.class[1]) * q.x
    }

    fn place(&self, ring: &Ring) -> f64 {
        let (sum, count) = ring.points().fold((0.0, 0.0), |(sum, count), p| (sum + self.left(p), count + 1.0));
        sum / count
    }

    /// The move by whole periods that goes `steps` to the left.
    fn step(&self, steps: f64) -> DVec2 {
        let [p, q] = self.class;
        // p j - q i = 1 has a solution with 0 <= i < |p|.
        let i = (0..p.abs()).find(|i| (1 + q * i) % p == 0).unwrap_or(0);
        DVec2::new(f64::from(i), f64::from((1 + q * i) / p)) * steps * self.periods()
    }

    fn close<'a>(&self, mut rings: Vec<Ring<'a>>) -> Result<Closed<'a>, BrepError> {
        let count = rings.len();
        if count > 1 && count % 2 == 1 {
            return Err(BrepError::NoPartner);
        }
        // From a ring with the material to its left to the next one.
        let base = self.place(&rings[0]);
        for ring in &mut rings[1..] {
            ring.shift(self.step(-(self.place(ring) - base).floor()));
        }
        rings.sort_by(|a, b| self.place(a).total_cmp(&self.place(b)));
        if count == 1 {
            let mut other = rings[0].clone();
            other.shift(self.step(1.0));
            rings.push(other);
        }
        let mut closed = Vec::new();
        let mut rings = rings.into_iter();
        while let (Some(ring), Some(other)) = (rings.next(), rings.next()) {
            closed.push(self.pair(ring, other));
        }
        let corner = bounds(&closed)[0];
        Ok(Closed { rings: closed, corner, cut: true })
    }

    /// Two rings as one, joined by the same way there and back.
    fn pair<'a>(&self, ring: Ring<'a>, mut other: Ring<'a>) -> Ring<'a> {
        if other.winding == ring.winding {
            other = reversed(other);
        }
        let bridged = ring.bridged.max(other.bridged);
        let turn = ring.turn(self.chart);
        let mut paths = ring.paths;
        let (start, to) = (paths[0].start, other.paths[0].start);
        let corner = DVec2::new(to.x, start.y + turn.y);
        paths.extend([Path::bridge(start + turn, corner), Path::bridge(corner, to)]);
        paths.append(&mut other.paths);
        paths.extend([Path::bridge(to - turn, corner - turn), Path::bridge(corner - turn, start)]);
        Ring { paths, winding: [0, 0], bridged }
    }
}
