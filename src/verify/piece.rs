//! Pieces of projected patches: where they lie in the image, and when a ray can meet them only once.

use super::view::View;
use crate::geometry::{BezierPatch, Net};
use glam::{DMat2, DVec2, DVec4};

/// A view net (see `view`) over a rectangle of its patch's unit square.
#[derive(Clone, Debug)]
pub(super) struct Piece {
    pub net: BezierPatch,
    /// `[[u0, u1], [v0, v1]]`
    pub domain: [[f64; 2]; 2],
}

/// Box in pixels relative to the image centre, and the nearest camera depth in it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct ImageBox {
    pub low: DVec2,
    pub high: DVec2,
    pub depth: f64,
}

/// Certifies that no ray through a given box meets a piece twice.
///
/// With s in [-1, 1]² over the piece and `H(s) = inverse * (F, G)(s)`, the largest row sum of `|I - DH|` is at most
/// `contraction` on all of the piece, for all rays through the box. So `s - H(s)` contracts towards the only zero s*
/// there can be, and `|s* - (s - H(s))| <= contraction |s* - s|` (Krawczyk. Newton-Algorithmen zur Bestimmung von
/// Nullstellen mit Fehlerschranken. 1969).
#[derive(Clone, Copy, Debug)]
pub(super) struct Certificate {
    pub inverse: DMat2,
    pub contraction: f64,
}

/// Contractions up to this certify; below 1/2 the enclosures of `solve` shrink from any point.
const LARGEST_CONTRACTION: f64 = 0.4;

/// How often a patch may be halved.
const MAX_DEPTH: usize = 100;

impl ImageBox {
    pub const EMPTY: Self = Self { low: DVec2::INFINITY, high: DVec2::NEG_INFINITY, depth: f64::INFINITY };

    pub fn union(self, other: Self) -> Self {
        Self { low: self.low.min(other.low), high: self.high.max(other.high), depth: self.depth.min(other.depth) }
    }

    pub fn size(&self) -> DVec2 {
        self.high - self.low
    }

    pub fn center(&self) -> DVec2 {
        (self.low + self.high) * 0.5
    }

    /// Closed, `slack` pixels wider all around.
    pub fn contains(&self, p: DVec2, slack: f64) -> bool {
        p.x >= self.low.x - slack
            && p.x <= self.high.x + slack
            && p.y >= self.low.y - slack
            && p.y <= self.high.y + slack
    }

    pub fn meets(&self, other: &Self) -> bool {
        self.low.cmple(other.high).all() && other.low.cmple(self.high).all()
    }

    /// The part inside `other`.
    pub fn clip(self, other: &Self) -> Self {
        Self { low: self.low.max(other.low), high: self.high.min(other.high), depth: self.depth }
    }

    fn add(&mut self, pixel: DVec2, depth: f64) {
        self.low = self.low.min(pixel);
        self.high = self.high.max(pixel);
        self.depth = self.depth.min(depth);
    }
}

impl Piece {
    pub fn whole(net: BezierPatch) -> Self {
        Self { net, domain: [[0.0, 1.0]; 2] }
    }

    /// The part of a whole patch over `domain`.
    pub fn restricted(net: BezierPatch, domain: [[f64; 2]; 2]) -> Self {
        let mut part = net;
        for (axis, [low, high]) in domain.into_iter().enumerate() {
            if low > 0.0 {
                let [_, upper] = part.net().split(axis, low);
                part = upper;
            }
            if high < 1.0 {
                let [lower, _] = part.net().split(axis, (high - low) / (1.0 - low));
                part = lower;
            }
        }
        Self { net: part, domain }
    }

    fn halves(&self, axis: usize) -> [Piece; 2] {
        let [low, high] = self.net.net().split(axis, 0.5);
        let middle = (self.domain[axis][0] + self.domain[axis][1]) * 0.5;
        let part = |net, end: usize| {
            let mut domain = self.domain;
            domain[axis][1 - end] = middle;
            Piece { net, domain }
        };
        [part(low, 0), part(high, 1)]
    }

    /// The box that holds the image of all of the piece that is not nearer than near; `None` where all of it is.
    ///
    /// What is in front is the hull cut by the near plane: its corners are control points in front, and points on the
    /// plane between one in front and one behind.
    pub fn image_box(&self, view: &View) -> Option<ImageBox> {
        let points = self.net.points();
        let mut image = ImageBox::EMPTY;
        let mut behind = false;
        for &q in points {
            if view.clearance(q) >= 0.0 {
                image.add(view.pixel(q), view.depth(q));
            } else {
                behind = true;
            }
        }
        if behind {
            self.add_near_corners(view, &mut image);
        }
        (image.low.x <= image.high.x).then_some(image)
    }

    fn add_near_corners(&self, view: &View, image: &mut ImageBox) {
        let points = self.net.points();
        for &a in points.iter().filter(|&&q| view.clearance(q) >= 0.0) {
            for &b in points.iter().filter(|&&q| view.clearance(q) < 0.0) {
                let (ca, cb) = (view.clearance(a), view.clearance(b));
                image.add(view.pixel(b * (ca / (ca - cb)) - a * (cb / (ca - cb))), view.camera().near);
            }
        }
    }

    /// The direction in which the net is longer in the image.
    fn longer_axis(&self, view: &View) -> usize {
        let [m, n] = self.net.degree();
        let point = |i: usize, j: usize| view.pixel_no_nearer(self.net.net().point(i, j));
        let length = |a: DVec2, b: DVec2| (a - b).abs().element_sum();
        let (mut along_u, mut along_v) = (0.0_f64, 0.0_f64);
        for j in 0..=n {
            along_u = along_u.max((0..m).map(|i| length(point(i, j), point(i + 1, j))).sum());
        }
        for i in 0..=m {
            along_v = along_v.max((0..n).map(|j| length(point(i, j), point(i, j + 1))).sum());
        }
        usize::from(along_v > along_u)
    }

    /// (u, v) of s in [-1, 1]².
    pub fn parameter(domain: &[[f64; 2]; 2], s: DVec2) -> [f64; 2] {
        let at = |[low, high]: [f64; 2], s: f64| low + (high - low) * (0.5 + 0.5 * s);
        [at(domain[0], s.x), at(domain[1], s.y)]
    }
}

impl Certificate {
    /// For all rays through the box of half size `half` about pixel `center` (both relative to the image centre).
    pub fn of(net: Net<'_>, view: &View, center: DVec2, half: DVec2) -> Option<Self> {
        let [m, n] = net.degree();
        let mut mean = DMat2::ZERO;
        for j in 0..=n {
            mean.x_axis += view.off_ray(net.point(m, j) - net.point(0, j), center) / (2 * (n + 1)) as f64;
        }
        for i in 0..=m {
            mean.y_axis += view.off_ray(net.point(i, n) - net.point(i, 0), center) / (2 * (m + 1)) as f64;
        }
        let inverse = mean.inverse();
        if !inverse.is_finite() {
            return None;
        }
        let spread = DMat2::from_cols(inverse.x_axis.abs(), inverse.y_axis.abs()) * half;
        // Largest |I - DH| of one column over the derivative's control points: the hull holds the rest.
        let column = |identity: DVec2, degree: usize, difference: DVec4| {
            let d = difference * (0.5 * degree as f64);
            (identity - inverse * view.off_ray(d, center)).abs() + spread * view.divisor(d).abs()
        };
        let (mut of_u, mut of_v) = (DVec2::ZERO, DVec2::ZERO);
        for i in 0..=m {
            for j in 0..=n {
                let q = net.point(i, j);
                if i < m {
                    of_u = of_u.max(column(DVec2::X, m, net.point(i + 1, j) - q));
                }
                if j < n {
                    of_v = of_v.max(column(DVec2::Y, n, net.point(i, j + 1) - q));
                }
            }
        }
        let contraction = (of_u + of_v).max_element();
        (contraction <= LARGEST_CONTRACTION).then_some(Self { inverse, contraction })
    }
}

/// Halves a piece level by level. `judge(piece, last)` says whether to go on with it; it is told when it is the last to
/// be asked because the level holds `cap` pieces or the depth is used up.
pub(super) fn subdivide(root: Piece, view: &View, cap: usize, mut judge: impl FnMut(&Piece, bool) -> bool) {
    let mut level = vec![root];
    let mut next = Vec::new();
    for depth in 0..=MAX_DEPTH {
        let last = depth == MAX_DEPTH || level.len() > cap / 2;
        for piece in level.drain(..) {
            if judge(&piece, last) && !last {
                next.extend(piece.halves(piece.longer_axis(view)));
            }
        }
        if next.is_empty() {
            return;
        }
        std::mem::swap(&mut level, &mut next);
    }
}
