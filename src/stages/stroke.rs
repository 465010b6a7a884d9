//! Fragments that may close a crack: border strokes, and ETER's conservative ones (DESIGN section 4; research
//! "crack-closing", section 2, rules 1 to 4).

use super::cull::Leaf;
use super::estimate::Tessellation;
use super::evaluate::{SUBPIXELS, Vertex};
use super::rasterize::{Band, Coverage, Triangle, pixel_range};
use super::topology::depth_of;
use super::{Bound, Options};
use crate::geometry::distance2_from_line;
use glam::{DVec2, Vec4};

const HALF: i64 = SUBPIXELS as i64 / 2;
/// Depth is pushed back by a pen's width of slope and this many pixels.
const PUSH_MARGIN: f32 = 1.0 / 64.0;
/// Strokes lose against what they continue: a few f32 roundings.
const PUSH_FACTOR: f32 = 1.0 - 2e-6;

/// Derivatives of what a grid is off by, a quad's side, for each pixel of it.
const STEEPEST: f64 = 8.0;

/// The square pens that draw a leaf's outer edges: L-infinity radii in sub-pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Pen {
    /// For the edges of sides u = 0, u = 1, v = 0, v = 1 behind which the surface does not fold.
    pub sides: [i64; 4],
    /// For the others.
    pub radius: i64,
    /// Along folds; 0: none are drawn. The surface's own outline lies within the whole tolerance of its grid's.
    pub fold: i64,
    /// Pixels that the grid is off by.
    pub off: f32,
}

impl Pen {
    /// What the leaf's own grid is off by: two grids that both reach their common curve leave no gap. Where a bound tells no
    /// more than the tolerance, or fragments stay as they are, half of that: every gap point is so near to an edge of one of
    /// the two (research "crack-closing"). Not the lesser of the two: a fine grid's short reach and half a tolerance may not
    /// meet. Half a sub-pixel of snapping for each of the two borders, and their rounding.
    ///
    /// A border that is straight on the screen is its own grid's: only a surface that folds reaches beyond it.
    ///
    /// Folds only propose pixels: without `refine` nobody could tell which of them the surface covers.
    ///
    /// Where the face ends or is cut, nothing comes to meet it from the other side: `rim` is the model's own gap there in
    /// pixels, to be reached over on top of all that the grid is off by. These, too, only propose pixels.
    pub fn new(leaf: &Leaf, grid: &Tessellation, options: &Options, rim: Option<f64>, sags: [f64; 4]) -> Self {
        let (tolerance, refine) = (options.tolerance, options.refine > 0);
        let subpixels = f64::from(SUBPIXELS);
        let off = f64::from(grid.deviation[0]);
        let tells = matches!(options.bound, Bound::Screen | Bound::Filip | Bound::Eter);
        let half = 0.5 * (tolerance - 0.5 / subpixels - leaf.evaluation[0]).max(0.0) + leaf.evaluation[0];
        let radius = |reach: f64| (subpixels * reach + 0.5).ceil() as i64;
        let gap = rim.unwrap_or(0.0);
        let whole = radius(if refine && rim.is_some() {
            off + gap
        } else if refine && tells {
            off
        } else {
            half
        });
        let side = |sag: f64| radius(off.min(sag + 0.5 / subpixels + leaf.evaluation[0]) + gap);
        Self {
            sides: if refine && (tells || rim.is_some()) { sags.map(side) } else { [whole; 4] },
            radius: whole,
            fold: if refine { radius(off + gap) } else { 0 },
            off: grid.deviation[0],
        }
    }

    /// The surface over a triangle of the leaf may fold, and strokes only propose pixels.
    pub fn may_fold(&self, corners: &[Vertex; 3]) -> bool {
        self.fold > 0 && may_fold(corners, self.off)
    }

    /// The radius for an edge of a side, with the third corner of the triangle behind it.
    fn reach(&self, side: usize, corners: &[Vertex; 3]) -> i64 {
        let calm = self.sides[side];
        if calm < self.radius && self.may_fold(corners) { self.radius } else { calm }
    }
}

/// The image of the surface over a triangle may have a fold: where a grid is off by `off` pixels, its derivatives along the
/// sides of a quad are off by at most eight times that a side (`M h` for `M h^2 / 8`), and a triangle that is higher than
/// that keeps its sense of rotation.
pub(super) fn may_fold([a, b, c]: &[Vertex; 3], off: f32) -> bool {
    let way =
        |p: &Vertex, q: &Vertex| [i64::from(q.x) - i64::from(p.x), i64::from(q.y) - i64::from(p.y)].map(|d| d as f64);
    let ([ux, uy], [vx, vy], [wx, wy]) = (way(a, b), way(a, c), way(b, c));
    let longest2 = (ux * ux + uy * uy).max(vx * vx + vy * vy).max(wx * wx + wy * wy);
    (ux * vy - uy * vx).abs() <= STEEPEST * f64::from(off) * f64::from(SUBPIXELS) * longest2.sqrt()
}

/// How far the leaf's four borders (u = 0, u = 1, v = 0, v = 1) are from the straight lines between their ends, and so
/// from the edges of any grid, at most: twice their control points' distance, in pixels.
pub(super) fn sags(leaf: &Leaf, net: &[Vec4], perspective: bool) -> [f64; 4] {
    let [m, n] = leaf.degree;
    let at = |i: usize, j: usize| {
        let p = net[i * (n + 1) + j].as_dvec4();
        let denominator = if perspective { p.z + leaf.depth_origin * p.w } else { p.w };
        DVec2::new(p.x, p.y) / denominator
    };
    let sag = |count: usize, point: &dyn Fn(usize) -> DVec2| {
        let (a, b) = (point(0), point(count));
        2.0 * (1..count).map(|k| distance2_from_line(point(k), [a, b])).fold(0.0, f64::max).sqrt()
    };
    [sag(n, &|j| at(0, j)), sag(n, &|j| at(m, j)), sag(m, &|i| at(i, 0)), sag(m, &|i| at(i, n))]
}

impl Band<'_> {
    /// The larger word stays in the spare buffer.
    fn spare(&mut self, x: i64, y: i64, fragment: u64) {
        self.spare_fragment((y - i64::from(self.rows[0])) as u32 * self.width as u32 + x as u32, fragment);
    }

    /// The same for a pixel of the band by its number.
    fn spare_fragment(&mut self, index: u32, fragment: u64) {
        match &mut self.listed {
            Some(listed) => listed.push((index, fragment)),
            None => self.spare_at(index, fragment),
        }
    }

    /// The same, listed or not.
    pub fn spare_at(&mut self, index: u32, fragment: u64) {
        let pixel = &mut self.spare[index as usize];
        if *pixel == 0 {
            self.touched.push(index);
        }
        *pixel = (*pixel).max(fragment);
    }

    /// Pixels of this band with centres inside a box of sub-pixels: x range, y range (inclusive; may be empty).
    fn pixels(&self, x: (i64, i64), y: (i64, i64)) -> [(i64, i64); 2] {
        let (x0, x1) = pixel_range(x.0, x.1);
        let (y0, y1) = pixel_range(y.0, y.1);
        [
            (x0.max(0), x1.min(i64::from(self.width) - 1)),
            (y0.max(i64::from(self.rows[0])), y1.min(i64::from(self.rows[1]) - 1)),
        ]
    }
}

/// A segment that a square pen runs along; sub-pixels, the radius in L-infinity.
struct Segment {
    from: [i64; 2],
    way: [i64; 2],
    radius: i64,
}

impl Segment {
    fn new(a: &Vertex, b: &Vertex, radius: i64) -> Self {
        let from = [i64::from(a.x), i64::from(a.y)];
        Self { from, way: [i64::from(b.x) - from[0], i64::from(b.y) - from[1]], radius }
    }

    /// Calls `paint(x, y, side, s)` for the pixels whose centres the pen meets: `side` is positive to the right of the way
    /// (y runs down), `s` in [0, 1] says where on the segment the nearest point lies.
    fn draw(&self, band: &mut Band, mut paint: impl FnMut(&mut Band, i64, i64, i64, f32)) {
        let ([ax, ay], [dx, dy], r) = (self.from, self.way, self.radius);
        let reach = r * (dx.abs() + dy.abs());
        let length2 = dx * dx + dy * dy;
        let range = |a: i64, d: i64| (a.min(a + d) - r, a.max(a + d) + r);
        let [(x0, x1), (y0, y1)] = band.pixels(range(ax, dx), range(ay, dy));
        let subpixels = SUBPIXELS as i64;
        for y in y0..=y1 {
            let py = y * subpixels + HALF - ay;
            // Long slanted edges: only what lies between the two parallels, and a pixel to spare for rounding.
            let (low, high) = match dy {
                0 => (x0, x1),
                _ => {
                    let (a, b) = ((dx * py - reach) / dy, (dx * py + reach) / dy);
                    let pixel = |px: i64| (px + ax - HALF).div_euclid(subpixels);
                    (x0.max(pixel(a.min(b)) - 1), x1.min(pixel(a.max(b)) + 2))
                }
            };
            for x in low..=high {
                let px = x * subpixels + HALF - ax;
                let side = dx * py - dy * px;
                if side.abs() <= reach {
                    paint(band, x, y, side, nearest(dx * px + dy * py, length2));
                }
            }
        }
    }
}

/// A stroke along corner 0 to corner 1; corner 2 completes the triangle behind it.
pub(super) fn stroke(corners: &[Vertex; 3], side: usize, pen: &Pen, id: u64, band: &mut Band) {
    let [a, b, c] = corners;
    let segment = Segment::new(a, b, pen.reach(side, corners));
    let ([ax, ay], [dx, dy]) = (segment.from, segment.way);
    let area = dx * (i64::from(c.y) - ay) - dy * (i64::from(c.x) - ax);
    let push = if pen.fold > 0 { 0.0 } else { push(corners, area, pen) };
    segment.draw(band, |band, x, y, side, s| {
        // Only the outer side: inside, the triangle's own fragments say it better.
        if side * area.signum() <= 0 {
            let depth = (a.depth + (b.depth - a.depth) * s - push) * PUSH_FACTOR;
            band.spare(x, y, id | u64::from(depth.max(f32::MIN_POSITIVE).to_bits()) << 32);
        }
    });
}

/// A triangle of which the inside of a solid is seen, so that it is not drawn: the surface over it may fold and be seen
/// from outside all the same.
pub(super) fn turned_away(corners: &[Vertex; 3], id: u64, band: &mut Band) {
    let Some(coverage) = Coverage::new(corners, band) else { return };
    let mut found = Vec::new();
    let width = band.width as u32;
    coverage.each(coverage.pixels, id, band, |_, [x, y], fragment| found.push((y * width + x, fragment)));
    for (pixel, fragment) in found {
        band.spare_fragment(pixel, fragment);
    }
}

/// A stroke along an edge at which the grid folds over, on both sides.
pub(super) fn fold(a: &Vertex, b: &Vertex, pen: &Pen, id: u64, band: &mut Band) {
    Segment::new(a, b, pen.fold).draw(band, |band, x, y, _, s| {
        let depth = (a.depth + (b.depth - a.depth) * s) * PUSH_FACTOR;
        band.spare(x, y, id | u64::from(depth.max(f32::MIN_POSITIVE).to_bits()) << 32);
    });
}

/// Where on a segment the nearest point lies: projection over squared length, clamped.
pub(super) fn nearest(dot: i64, length2: i64) -> f32 {
    if length2 == 0 { 0.0 } else { (dot as f32 / length2 as f32).clamp(0.0, 1.0) }
}

/// Rule 4: a pen's width of the triangle's slope, at most the size of its depth range.
fn push([a, b, c]: &[Vertex; 3], area: i64, pen: &Pen) -> f32 {
    let range = a.depth.max(b.depth).max(c.depth) - a.depth.min(b.depth).min(c.depth);
    if area == 0 {
        return range;
    }
    let (u, v) = (b.depth - a.depth, c.depth - a.depth);
    let (ux, uy) = ((b.x - a.x) as f32, (b.y - a.y) as f32);
    let (vx, vy) = ((c.x - a.x) as f32, (c.y - a.y) as f32);
    let per_pixel = SUBPIXELS as f32 / area.abs() as f32;
    let slope = ((u * vy - v * uy).abs() + (v * ux - u * vx).abs()) * per_pixel;
    let width = 2.0 * pen.radius as f32 / SUBPIXELS as f32 + PUSH_MARGIN;
    (slope * width).min(range)
}

/// ETER section 6.1: fragments of pixels whose square the triangle touches without holding the centre.
///
/// Depth is that of the triangle's nearest point: extrapolating slides along slivers by many pixels.
pub(super) fn conservative(corners: &[Vertex; 3], id: u64, band: &mut Band) {
    let t = Triangle::new(corners);
    let bounds = |v: [i64; 3]| (v[0].min(v[1]).min(v[2]) - HALF, v[0].max(v[1]).max(v[2]) + HALF);
    let [(x0, x1), (y0, y1)] = band.pixels(bounds(t.x), bounds(t.y));
    for y in y0..=y1 {
        for x in x0..=x1 {
            let (px, py) = (x * SUBPIXELS as i64 + HALF, y * SUBPIXELS as i64 + HALF);
            let mut inside = t.area > 0;
            let mut touches = true;
            for k in 0..3 {
                let n = (k + 1) % 3;
                let e = t.edge(k, px, py);
                inside &= e > 0 || (e == 0 && t.owns(k));
                touches &= e >= -HALF * ((t.x[n] - t.x[k]).abs() + (t.y[n] - t.y[k]).abs());
            }
            if touches && !inside {
                let weights = nearest_in_triangle(&t, px, py);
                let depth = (0..3).map(|k| weights[k] * t.depth[k]).sum::<f32>();
                band.spare(x, y, id | u64::from(depth.max(f32::MIN_POSITIVE).to_bits()) << 32);
            }
        }
    }
}

/// Barycentric weights of the triangle's point nearest to (px, py), which is not inside.
pub(super) fn nearest_in_triangle(t: &Triangle, px: i64, py: i64) -> [f32; 3] {
    let mut best = (i64::MAX as f64, [0.0; 3]);
    for k in 0..3 {
        let n = (k + 1) % 3;
        let (dx, dy) = (t.x[n] - t.x[k], t.y[n] - t.y[k]);
        let s = nearest(dx * (px - t.x[k]) + dy * (py - t.y[k]), dx * dx + dy * dy);
        let (qx, qy) = (t.x[k] as f64 + dx as f64 * f64::from(s), t.y[k] as f64 + dy as f64 * f64::from(s));
        let distance = (qx - px as f64).powi(2) + (qy - py as f64).powi(2);
        if distance < best.0 {
            let mut weights = [0.0; 3];
            weights[k] = 1.0 - s;
            weights[n] = s;
            best = (distance, weights);
        }
    }
    best.1
}

/// True where a spare word is strictly nearer than a centre-covered one.
pub(super) fn is_nearer(spare: u64, near: u64) -> bool {
    depth_of(spare) > depth_of(near)
}
