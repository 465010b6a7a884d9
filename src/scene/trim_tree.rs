//! A face's trim loops as a kd-tree over monotone segments (DESIGN section 5): which points and boxes of the parameter
//! plane are inside, by the odd-even rule.
//!
//! A cell holds the *clips* of the segments that cross it, and whether the lower end of its right side is inside. A
//! point's ray runs to the right only as far as its cell's side; from there on it is known how many curves lie between it
//! and the side's lower end. Where a segment leaves a cell is one number, shared by both cells: so that counting is
//! exact whatever rounding did to that number, and a point on a curve gets one answer, always the same.
//!
//! Cells, segments and their ends are half open: the lower end belongs to them, the upper one doesn't.

use super::trim_build::Builder;
use super::trim_lines::Window;
use super::trim_segment::{ParameterBox, Segment, plane_point, split};
use crate::model::Loop;
use glam::{DVec2, DVec3};

/// Where a box of parameters lies.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Region {
    Inside,
    Outside,
    /// A trim curve meets the box.
    Boundary,
}

/// The trim trees of many faces in common lists.
#[derive(Clone, Debug, Default)]
pub struct Trims {
    pub(crate) trees: Vec<Tree>,
    pub(crate) nodes: Vec<Node>,
    pub(crate) clips: Vec<Clip>,
    pub(crate) segments: Vec<Segment>,
    pub(crate) points: Vec<DVec3>,
}

/// One face's tree in the lists.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Tree {
    pub root: u32,
    pub bounds: ParameterBox,
    /// Largest gap of its curves.
    pub gap: f64,
}

#[derive(Clone, Copy, Debug)]
pub(crate) enum Node {
    /// Lower child, then the upper one, at `children` and `children + 1`.
    Split {
        axis: u8,
        at: f64,
        children: u32,
    },
    Cell {
        first: u32,
        count: u32,
        inside: bool,
    },
}

/// A segment within one cell.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Clip {
    pub segment: u32,
    /// Heights between which it crosses the cell: the lower one is its, the upper one isn't.
    pub heights: [f64; 2],
    /// It leaves through the cell's right side, at one of these heights.
    pub exit: Option<Exit>,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Exit {
    Lower,
    Upper,
}

impl Clip {
    /// The curve that leaves through the right side does so no higher than `v`.
    fn leaves_below(&self, v: f64) -> bool {
        match self.exit {
            None => false,
            Some(Exit::Lower) => self.heights[0] <= v,
            Some(Exit::Upper) => self.heights[1] <= v,
        }
    }

    fn spans(&self, v: f64) -> bool {
        self.heights[0] <= v && v < self.heights[1]
    }
}

/// One face's trims.
#[derive(Clone, Copy, Debug)]
pub struct TrimTree<'a> {
    trims: &'a Trims,
    tree: &'a Tree,
}

impl Trims {
    /// Adds a face's loops; returns the number of its tree.
    pub fn add(&mut self, loops: &[Loop]) -> u32 {
        let first = self.segments.len();
        for curves in loops.iter().map(|l| &l.curves) {
            for (k, piece) in curves.iter().enumerate() {
                let points = piece.curve.points();
                let end = |p: Option<&glam::DVec4>| p.map_or([0.0; 2], |&p| plane_point(p));
                let (start, stop) = (end(points.first()), end(points.last()));
                split(&piece.curve, [start, stop], piece.gap, &mut self.segments, &mut self.points);
                // Whatever the next curve starts with: a loop closes.
                let next = end(curves[(k + 1) % curves.len()].curve.points().first());
                if next != stop {
                    self.segments.push(Segment::line(stop, next, piece.gap));
                }
            }
        }
        let tree = Builder::build(self, first);
        self.trees.push(tree);
        self.trees.len() as u32 - 1
    }

    /// Moves another list behind this one; its trees' numbers grow by the number returned.
    pub fn append(&mut self, other: Trims) -> u32 {
        let offset = self.trees.len() as u32;
        let [nodes, clips] = [self.nodes.len() as u32, self.clips.len() as u32];
        let [segments, points] = [self.segments.len() as u32, self.points.len() as u32];
        self.trees.extend(other.trees.into_iter().map(|t| Tree { root: t.root + nodes, ..t }));
        self.nodes.extend(other.nodes.into_iter().map(|n| match n {
            Node::Split { axis, at, children } => Node::Split { axis, at, children: children + nodes },
            Node::Cell { first, count, inside } => Node::Cell { first: first + clips, count, inside },
        }));
        self.clips.extend(other.clips.into_iter().map(|c| Clip { segment: c.segment + segments, ..c }));
        self.segments.extend(other.segments.into_iter().map(|s| s.moved(points)));
        self.points.extend(other.points);
        offset
    }

    pub fn tree(&self, number: u32) -> TrimTree<'_> {
        TrimTree { trims: self, tree: &self.trees[number as usize] }
    }

    /// Memory of all trees, in bytes.
    pub fn bytes(&self) -> usize {
        size_of_val(&self.trees[..])
            + size_of_val(&self.nodes[..])
            + size_of_val(&self.clips[..])
            + size_of_val(&self.segments[..])
            + size_of_val(&self.points[..])
    }

    /// Monotone segments of all trees.
    pub fn segments(&self) -> usize {
        self.segments.len()
    }

    /// How much there is, for `truncate`.
    pub(super) fn mark(&self) -> [usize; 5] {
        [self.trees.len(), self.nodes.len(), self.clips.len(), self.segments.len(), self.points.len()]
    }

    /// Forgets what was added since `mark`.
    pub(super) fn truncate(&mut self, [trees, nodes, clips, segments, points]: [usize; 5]) {
        self.trees.truncate(trees);
        self.nodes.truncate(nodes);
        self.clips.truncate(clips);
        self.segments.truncate(segments);
        self.points.truncate(points);
    }

    /// Forgets spare capacity.
    pub fn shrink(&mut self) {
        self.trees.shrink_to_fit();
        self.nodes.shrink_to_fit();
        self.clips.shrink_to_fit();
        self.segments.shrink_to_fit();
        self.points.shrink_to_fit();
    }
}

impl<'a> TrimTree<'a> {
    /// Largest distance in space between a trim curve and its edge, in the part's units.
    pub fn gap(&self) -> f64 {
        self.tree.gap
    }

    /// The point `[u, v]` lies inside the loops. One on a curve counts as if it lay a little to the right and above.
    pub fn contains(&self, p: [f64; 2]) -> bool {
        let ParameterBox { low, high } = self.tree.bounds;
        // Also refuses what is not a number.
        if !(0..2).all(|k| low[k] <= p[k] && p[k] < high[k]) {
            return false;
        }
        let mut node = self.tree.root;
        loop {
            match self.trims.nodes[node as usize] {
                Node::Split { axis, at, children } => node = children + u32::from(p[usize::from(axis)] >= at),
                Node::Cell { first, count, inside } => {
                    let crossed = |clip: &Clip| {
                        let right = clip.spans(p[1]) && self.segment(clip).is_right_of(&self.trims.points, p);
                        right != clip.leaves_below(p[1])
                    };
                    return self.clips(first, count).filter(|c| crossed(c)).count() % 2 == usize::from(!inside);
                }
            }
        }
    }

    /// Whether a closed box is wholly inside or outside.
    pub fn classify(&self, within: &ParameterBox) -> Region {
        let meets = |s: &Segment| s.meets(&self.trims.points, within);
        if self.any(within, &mut |s| meets(s)) {
            Region::Boundary
        } else if self.contains(within.center()) {
            Region::Inside
        } else {
            Region::Outside
        }
    }

    /// Appends the numbers of the segments that meet a closed box, each once. A box without any is wholly inside or outside.
    pub fn collect(&self, within: &ParameterBox, found: &mut Vec<u32>) {
        let start = found.len();
        self.visit(within, &mut |clips: &[Clip], _: &ParameterBox| {
            found.extend(clips.iter().map(|c| c.segment).filter(|&s| self.meets(s, within)));
            false
        });
        found[start..].sort_unstable();
        let mut kept = start;
        for k in start..found.len() {
            if k == start || found[k] != found[kept - 1] {
                found[kept] = found[k];
                kept += 1;
            }
        }
        found.truncate(kept);
    }

    /// A segment, by its number, meets a closed box.
    pub fn meets(&self, segment: u32, within: &ParameterBox) -> bool {
        self.trims.segments[segment as usize].meets(&self.trims.points, within)
    }

    /// The lines of a segment, by its number, on the screen: `Segment::lines`.
    pub fn lines(
        &self,
        segment: u32,
        window: &Window,
        image: impl Fn(DVec3) -> DVec3,
        line: &mut impl FnMut([DVec2; 2]),
    ) -> bool {
        self.trims.segments[segment as usize].lines(&self.trims.points, window, image, line)
    }

    /// Largest distance in space between a segment, by its number, and its edge, in the part's units.
    pub fn gap_of(&self, segment: u32) -> f64 {
        self.trims.segments[segment as usize].gap
    }

    /// Largest gap of the curves that meet a closed box; `None` where none does.
    pub fn gap_in(&self, within: &ParameterBox) -> Option<f64> {
        let mut largest: Option<f64> = None;
        self.any(within, &mut |s| {
            if s.meets(&self.trims.points, within) {
                largest = Some(largest.unwrap_or(0.0).max(s.gap));
            }
            false
        });
        largest
    }

    /// Some curve comes within the box of half sizes `half(gap)` about the origin, under the map `image`; only curves
    /// that meet `within` are looked at.
    pub fn comes_near(
        &self,
        within: &ParameterBox,
        image: &impl Fn([f64; 2]) -> [f64; 3],
        half: impl Fn(f64) -> [f64; 3],
    ) -> bool {
        self.any(within, &mut |s| s.bounds().touches(within) && s.comes_near(&self.trims.points, image, half(s.gap)))
    }

    /// Calls `crossed` with the place of every crossing of the curves with height `v`, an even number of times in no order.
    /// `place` is a monotone function of u.
    pub fn crossings<T: PartialEq>(&self, v: f64, place: impl Fn(f64) -> T, crossed: &mut impl FnMut(T)) {
        let bounds = self.tree.bounds;
        let row = ParameterBox { low: [bounds.low[0], v], high: [bounds.high[0], v] };
        self.visit(&row, &mut |clips: &[Clip], _: &ParameterBox| {
            for clip in clips.iter().filter(|c| c.spans(v)) {
                crossed(self.segment(clip).crossing(&self.trims.points, 1, v, &place));
            }
            false
        });
    }

    /// Calls `strip` with the places between which each curve runs, from its lower end, between two heights; a curve may come
    /// several times. `place` is a monotone function of u.
    pub fn strips<T: PartialEq>(
        &self,
        [low, high]: [f64; 2],
        place: impl Fn(f64) -> T,
        strip: &mut impl FnMut([T; 2]),
    ) {
        let (low, high) = (low.min(high), low.max(high));
        let bounds = self.tree.bounds;
        let row = ParameterBox { low: [bounds.low[0], low], high: [bounds.high[0], high] };
        self.any(&row, &mut |s| {
            if s.bounds().touches(&row) {
                strip([low, high].map(|v| s.crossing(&self.trims.points, 1, v, &place)));
            }
            false
        });
    }

    fn segment(&self, clip: &Clip) -> &'a Segment {
        &self.trims.segments[clip.segment as usize]
    }

    fn clips(&self, first: u32, count: u32) -> impl Iterator<Item = &'a Clip> + use<'a> {
        self.trims.clips[first as usize..(first + count) as usize].iter()
    }

    /// `test` holds for a segment in one of the cells that the box meets; a segment may come several times.
    fn any(&self, within: &ParameterBox, test: &mut impl FnMut(&Segment) -> bool) -> bool {
        self.visit(within, &mut |clips: &[Clip], _: &ParameterBox| clips.iter().any(|c| test(self.segment(c))))
    }

    /// Calls `visit` with the cells that the closed box meets until it says true.
    fn visit(&self, within: &ParameterBox, visit: &mut impl FnMut(&[Clip], &ParameterBox) -> bool) -> bool {
        if !self.tree.bounds.touches(within) {
            return false;
        }
        self.visit_node(self.tree.root, self.tree.bounds, within, visit)
    }

    /// As deep as the tree: `Builder` keeps that low.
    fn visit_node(
        &self,
        node: u32,
        cell: ParameterBox,
        within: &ParameterBox,
        visit: &mut impl FnMut(&[Clip], &ParameterBox) -> bool,
    ) -> bool {
        match self.trims.nodes[node as usize] {
            Node::Split { axis, at, children } => {
                let k = usize::from(axis);
                let (mut lower, mut upper) = (cell, cell);
                lower.high[k] = at;
                upper.low[k] = at;
                (within.low[k] <= at && self.visit_node(children, lower, within, visit))
                    || (within.high[k] >= at && self.visit_node(children + 1, upper, within, visit))
            }
            Node::Cell { first, count, .. } => {
                visit(&self.trims.clips[first as usize..(first + count) as usize], &cell)
            }
        }
    }
}
