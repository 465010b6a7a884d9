//! Builds a face's trim tree: cells are split where that saves most expected tests.

use super::trim_segment::{ParameterBox, Segment};
use super::trim_tree::{Clip, Exit, Node, Tree, Trims};

/// Clips that a cell may hold without being split.
const FEW: usize = 4;
/// A split costs as much as testing this many clips.
const SPLIT_COST: f64 = 1.0;
/// An empty cell answers at once.
const EMPTY_BONUS: f64 = 0.75;
/// Splits on the way to a cell, for n clips: `EXTRA_DEPTH + 2 log2 n`.
const EXTRA_DEPTH: u32 = 6;

/// A segment within the cell that is being built.
#[derive(Clone, Copy, Debug)]
struct Part {
    segment: u32,
    /// Lower and upper end as clipped.
    ends: [[f64; 2]; 2],
    exit: Option<Exit>,
}

/// Parts of the cells on the way down, one list behind the other: no allocation a cell.
pub(super) struct Builder<'a> {
    trims: &'a mut Trims,
    parts: Vec<Part>,
}

/// A cell to be built: its parts are the last ones of the builder's list.
struct Cell {
    node: usize,
    bounds: ParameterBox,
    /// The lower end of the right side is inside.
    inside: bool,
    depth: u32,
}

impl<'a> Builder<'a> {
    /// The tree over the segments from number `first` on.
    pub fn build(trims: &'a mut Trims, first: usize) -> Tree {
        let mut bounds = ParameterBox::EMPTY;
        let mut gap = 0.0f64;
        let mut parts = Vec::with_capacity(2 * (trims.segments.len() - first));
        for (k, segment) in trims.segments.iter().enumerate().skip(first) {
            bounds = bounds.union(&segment.bounds());
            gap = gap.max(segment.gap);
            parts.push(Part { segment: k as u32, ends: segment.ends, exit: None });
        }
        let root = trims.nodes.len();
        trims.nodes.push(Node::Cell { first: 0, count: 0, inside: false });
        let depth = EXTRA_DEPTH + 2 * (parts.len().max(1)).ilog2();
        let mut builder = Builder { trims, parts };
        builder.cell(Cell { node: root, bounds, inside: false, depth }, 0);
        Tree { root: root as u32, bounds, gap }
    }

    /// Builds the cell whose parts start at `first`; removes them.
    fn cell(&mut self, cell: Cell, first: usize) {
        let split = if cell.depth > 0 { self.best_split(&cell.bounds, first) } else { None };
        let Some((axis, at)) = split else {
            return self.leaf(&cell, first);
        };
        let children = self.trims.nodes.len();
        self.trims.nodes[cell.node] = Node::Split { axis: axis as u8, at, children: children as u32 };
        self.trims.nodes.extend([Node::Cell { first: 0, count: 0, inside: false }; 2]);
        let (mut lower, mut upper) = (cell.bounds, cell.bounds);
        lower.high[axis] = at;
        upper.low[axis] = at;
        let middle = self.parts.len();
        // The upper cell's parts first, behind them the lower one's.
        for k in first..middle {
            self.parts[k].upper(axis, at, self.trims).into_iter().for_each(|p| self.parts.push(p));
        }
        let last = self.parts.len();
        for k in first..middle {
            self.parts[k].lower(axis, at, self.trims).into_iter().for_each(|p| self.parts.push(p));
        }
        let inside = if axis == 0 {
            // Left of the upper cell, at its lower end: the ray to its right side passes all of it. What leaves the lower
            // cell there counts again when a point's height is compared with it.
            let v = cell.bounds.low[1];
            let leaves = |p: &Part| p.exit_height().is_some_and(|height| height <= v);
            let crossed = |p: &&Part| (p.ends[0][1] <= v && v < p.ends[1][1]) != leaves(p);
            let upper = self.parts[middle..last].iter().filter(crossed).count();
            let lower = self.parts[last..].iter().filter(|p| leaves(p)).count();
            [cell.inside != ((upper + lower) % 2 == 1), cell.inside]
        } else {
            let below = |p: &&Part| p.exit_height().is_some_and(|height| height < at);
            [cell.inside, cell.inside != (self.parts[last..].iter().filter(below).count() % 2 == 1)]
        };
        let depth = cell.depth - 1;
        self.cell(Cell { node: children, bounds: lower, inside: inside[0], depth }, last);
        self.cell(Cell { node: children + 1, bounds: upper, inside: inside[1], depth }, middle);
        self.parts.truncate(first);
    }

    fn leaf(&mut self, cell: &Cell, first: usize) {
        let start = self.trims.clips.len();
        self.trims.clips.extend(self.parts[first..].iter().map(|p| Clip {
            segment: p.segment,
            heights: [p.ends[0][1], p.ends[1][1]],
            exit: p.exit,
        }));
        let count = (self.parts.len() - first) as u32;
        self.trims.nodes[cell.node] = Node::Cell { first: start as u32, count, inside: cell.inside };
        self.parts.truncate(first);
    }

    /// The split with the least expected cost, where it is worth it.
    fn best_split(&self, bounds: &ParameterBox, first: usize) -> Option<(usize, f64)> {
        let parts = &self.parts[first..];
        if parts.len() <= FEW {
            return None;
        }
        let mut best: Option<(f64, usize, f64)> = None;
        for axis in 0..2 {
            let size = bounds.high[axis] - bounds.low[axis];
            let mean =
                parts.iter().map(|p| p.ends[0][axis] * 0.5 + p.ends[1][axis] * 0.5).sum::<f64>() / parts.len() as f64;
            let low = parts.iter().map(|p| p.ends[0][axis].min(p.ends[1][axis])).fold(f64::INFINITY, f64::min);
            let high = parts.iter().map(|p| p.ends[0][axis].max(p.ends[1][axis])).fold(f64::NEG_INFINITY, f64::max);
            for at in [bounds.low[axis] + 0.5 * size, mean, low, high] {
                if !(bounds.low[axis] < at && at < bounds.high[axis]) {
                    continue;
                }
                let below = parts.iter().filter(|p| p.ends.iter().any(|e| e[axis] < at)).count();
                let above = parts.iter().filter(|p| p.ends.iter().any(|e| e[axis] >= at)).count();
                let share = (at - bounds.low[axis]) / size;
                let bonus = if below == 0 || above == 0 { EMPTY_BONUS } else { 1.0 };
                let cost = bonus * (below as f64 * share + above as f64 * (1.0 - share));
                if best.is_none_or(|b| cost < b.0) {
                    best = Some((cost, axis, at));
                }
            }
        }
        best.filter(|b| b.0 + SPLIT_COST < parts.len() as f64).map(|(_, axis, at)| (axis, at))
    }
}

impl Part {
    fn exit_height(&self) -> Option<f64> {
        self.exit.map(|exit| self.ends[usize::from(exit == Exit::Upper)][1])
    }

    /// Which ends lie at or above the split.
    fn above(&self, axis: usize, at: f64) -> [bool; 2] {
        self.ends.map(|e| e[axis] >= at)
    }

    /// Where the segment passes the split, between the part's ends.
    fn crossing(&self, axis: usize, at: f64, trims: &Trims) -> [f64; 2] {
        let segment: &Segment = &trims.segments[self.segment as usize];
        let other = 1 - axis;
        let [a, b] = self.ends;
        let value = segment.crossing(&trims.points, axis, at, |value| value);
        let value = value.clamp(a[other].min(b[other]), a[other].max(b[other]));
        if axis == 0 { [at, value] } else { [value, at] }
    }

    /// What of it lies in the lower child.
    fn lower(&self, axis: usize, at: f64, trims: &Trims) -> Option<Part> {
        match self.above(axis, at) {
            [true, true] => None,
            [false, false] => Some(Part { exit: self.exit.filter(|_| axis == 1), ..*self }),
            [first, _] => {
                let mut part = *self;
                part.ends[usize::from(!first)] = self.crossing(axis, at, trims);
                if axis == 0 {
                    part.exit = Some(if first { Exit::Lower } else { Exit::Upper });
                } else {
                    // Split in height: the upper end went to the upper child, and with it its exit.
                    part.exit = self.exit.filter(|&exit| exit == Exit::Lower);
                }
                Some(part)
            }
        }
    }

    /// What of it lies in the upper child.
    fn upper(&self, axis: usize, at: f64, trims: &Trims) -> Option<Part> {
        match self.above(axis, at) {
            [false, false] => None,
            [true, true] => Some(*self),
            [first, _] => {
                let mut part = *self;
                part.ends[usize::from(first)] = self.crossing(axis, at, trims);
                if axis == 1 {
                    part.exit = self.exit.filter(|&exit| exit == Exit::Upper);
                }
                Some(part)
            }
        }
    }
}
