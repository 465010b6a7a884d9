//! Part of trim: the pixels of a block that trim curves come near to on the screen.

use super::trim_quad::ToScreen;
use crate::scene::{ParameterBox, TrimTree, Window};
use glam::{DVec2, DVec3};

/// Pixels a side of a block at most.
pub(super) const BLOCK: usize = 16;
/// Pixels that the lines of a curve may be off by.
const FLAT: f64 = 1.0 / 32.0;
/// A curve between the centres of two neighbouring pixels is so near to one of them.
const BETWEEN: f64 = 0.5 + 1.0 / 64.0;

/// A set of a block's pixels: a bit for each, a word a row.
pub(super) type Rows = [u16; BLOCK];

/// Calls `found` with the columns of a row's pixels.
pub(super) fn each_bit(mut row: u16, mut found: impl FnMut(u32)) {
    while row != 0 {
        found(row.trailing_zeros());
        row &= row - 1;
    }
}

/// The first pixels of a row that lie side by side.
pub(super) fn lowest_run(row: u16) -> u16 {
    let first = row & row.wrapping_neg();
    row & !row.wrapping_add(first)
}

/// A straight piece of a trim curve on the screen, in pixels from the first pixel's centre.
#[derive(Clone, Copy, Debug)]
pub(super) struct Line {
    ends: [DVec2; 2],
    /// Pixels within which what a fragment shows may lie on its other side.
    near: f64,
    /// Pixels within which a neighbour's centre may.
    beside: f64,
}

impl Line {
    /// It comes beside some pixel of a block.
    pub fn meets(&self, [(x0, x1), (y0, y1)]: [(i64, i64); 2]) -> bool {
        let [a, b] = self.ends;
        let (low, high) =
            (DVec2::new(x0 as f64, y0 as f64) - self.beside, DVec2::new(x1 as f64, y1 as f64) + self.beside);
        if !(a.min(b).cmple(high).all() && a.max(b).cmpge(low).all()) {
            return false;
        }
        // The box's corners on both sides of the line, or on it.
        let way = b - a;
        let (middle, half) = ((low + high) * 0.5, (high - low) * 0.5);
        (way.perp_dot(middle - a)).abs() <= way.x.abs() * half.y + way.y.abs() * half.x
    }
}

/// Appends the lines of some curves on the screen, as far as they come beside `pixels`; false where a curve can't be followed.
/// `within` holds the parameters of the pixels' fragments, their errors included. `reach` gives the pixels that a fragment
/// may be off by at a curve with a gap.
pub(super) fn lines(
    tree: &TrimTree,
    curves: &[u32],
    [(x0, x1), (y0, y1)]: [(i64, i64); 2],
    to_screen: &ToScreen,
    within: &ParameterBox,
    reach: impl Fn(f64) -> f64,
    found: &mut Vec<Line>,
) -> bool {
    let weight = [[0, 0], [0, 1], [1, 0], [1, 1]].map(|[i, j]| {
        let ends = [within.low, within.high];
        to_screen.image(DVec3::new(ends[i][0], ends[j][1], 1.0)).z
    });
    let weight = weight.into_iter().fold(f64::INFINITY, f64::min);
    // Also refuses what is not a number.
    weight > 0.0
        && curves.iter().all(|&curve| {
            let near = reach(tree.gap_of(curve)) + FLAT;
            let beside = near.max(BETWEEN + FLAT);
            let (low, high) = (DVec2::new(x0 as f64, y0 as f64) - beside, DVec2::new(x1 as f64, y1 as f64) + beside);
            let window = Window { low, high, weight, flat: FLAT };
            let mut line = |ends: [DVec2; 2]| found.push(Line { ends, near, beside });
            tree.lines(curve, &window, |p| to_screen.image(p), &mut line)
        })
}

/// Which pixels of a block have a curve near their centres.
pub(super) struct Marks {
    /// So near that what a fragment shows may lie on its other side.
    pub near: Rows,
    /// So near that a neighbour's centre may.
    pub beside: Rows,
}

impl Marks {
    /// `first` is the block's first pixel.
    pub fn new<'a>(lines: impl Iterator<Item = &'a Line>, first: [i64; 2]) -> Self {
        let mut marks = Self { near: [0; BLOCK], beside: [0; BLOCK] };
        let origin = DVec2::new(first[0] as f64, first[1] as f64);
        for line in lines {
            let ends = line.ends.map(|p| p - origin);
            mark(&mut marks.near, ends, line.near);
            mark(&mut marks.beside, ends, line.beside);
        }
        marks
    }
}

/// Adds the pixels within `reach`, in x and in y, of a straight line; pixels count from the first one's centre.
fn mark(rows: &mut Rows, [a, b]: [DVec2; 2], reach: f64) {
    let last = BLOCK as f64 - 1.0;
    let ends = |low: f64, high: f64| ((low - reach).ceil().max(0.0), (high + reach).floor().min(last));
    let (from, to) = ends(a.y.min(b.y), a.y.max(b.y));
    if from > to {
        return;
    }
    let way = b - a;
    let (inverse, level) = (1.0 / way.y, way.y == 0.0);
    for (y, row) in rows.iter_mut().enumerate().take(to as usize + 1).skip(from as usize) {
        // The part of the line that is high enough.
        let at = |y: f64| a.x + way.x * ((y - a.y) * inverse).clamp(0.0, 1.0);
        let [p, q] = if level { [a.x, b.x] } else { [at(y as f64 - reach), at(y as f64 + reach)] };
        let (low, high) = ends(p.min(q), p.max(q));
        if low <= high {
            *row |= (u16::MAX >> (15 - (high - low) as u32)) << low as u32;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        /// Marked are all pixels that a point of the line is near to, and no others.
        #[test]
        fn marks_are_the_pixels_near_a_line(
            ends in prop::array::uniform4(-30.0f64..40.0),
            level in prop::bool::ANY,
            reach in 0.01f64..3.0,
        ) {
            let [ax, ay, bx, by] = ends;
            let (a, b) = (DVec2::new(ax, ay), DVec2::new(bx, if level { ay } else { by }));
            let mut rows = [0; BLOCK];
            mark(&mut rows, [a, b], reach);
            for (y, row) in rows.into_iter().enumerate() {
                for x in 0..BLOCK {
                    let c = DVec2::new(x as f64, y as f64);
                    // The L-infinity distance to a point on the way is convex: thirds close in on the least.
                    let distance = |t: f64| (a + (b - a) * t - c).abs().max_element();
                    let (mut low, mut high) = (0.0, 1.0);
                    for _ in 0..200 {
                        let (s, t) = (low + (high - low) / 3.0, high - (high - low) / 3.0);
                        if distance(s) < distance(t) { high = t } else { low = s }
                    }
                    let least = distance(0.5 * (low + high));
                    if (least - reach).abs() > 1e-9 {
                        prop_assert_eq!(row >> x & 1 == 1, least < reach, "({}, {}): {}", x, y, least);
                    }
                }
            }
        }
    }
}
