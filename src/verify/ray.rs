//! One ray against one piece of a patch.

use super::piece::{Certificate, Piece, subdivide};
use super::view::{Drawn, View};
use super::{RESOLUTION, cut::Leaf};
use crate::geometry::{BezierPatch, Jet};
use crate::scene::Scene;
use glam::{DMat2, DVec2, DVec4};

/// Where a ray meets a patch.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Meeting {
    pub parameter: [f64; 2],
    /// Half the size of the parameter rectangle in which this is the only meeting, or of the piece that stands for it.
    pub extent: [f64; 2],
    pub depth: f64,
    pub certified: bool,
}

#[derive(Clone, Copy, Debug, PartialEq)]
enum Solution {
    At(Meeting),
    Nowhere,
    Unknown,
}

/// A ray, as a point of the image relative to its centre, and the patch it is shot at.
pub(super) struct Ray<'a> {
    pub scene: &'a Scene,
    pub view: &'a View,
    pub drawn: &'a Drawn,
    pub pixel: DVec2,
}

const MAX_STEPS: usize = 12;

/// Steps this small (of the piece) end Newton's iteration: quadratic convergence has then reached rounding.
const SMALLEST_STEP: f64 = 1e-10;

/// Control points that one ray may have in work on one patch (8 MiB).
const MAX_POINTS: usize = 1 << 18;

impl Ray<'_> {
    /// Adds the meetings with one leaf of the patch.
    pub fn meet(&self, leaf: &Leaf, found: &mut Vec<Meeting>) {
        if let Some((certificate, center)) = &leaf.certificate {
            match self.solve(certificate, &leaf.domain, *center) {
                Solution::At(meeting) => return found.push(meeting),
                Solution::Nowhere => return,
                Solution::Unknown => {}
            }
        }
        self.search(Piece::restricted(view_net(self.scene, self.drawn), leaf.domain), found);
    }

    /// Halves the piece until every part is excluded, solved or below the resolution.
    fn search(&self, root: Piece, found: &mut Vec<Meeting>) {
        let cap = (MAX_POINTS / root.net.points().len()).clamp(16, 2048);
        subdivide(root, self.view, cap, |piece, last| {
            if self.excludes(piece) {
                return false;
            }
            let smallest = self.smallest(piece);
            let Some(image) = piece.image_box(self.view).filter(|b| b.contains(self.pixel, smallest)) else {
                return false;
            };
            if last || image.size().max_element() < smallest {
                found.push(standing_for(piece, image.depth));
                return false;
            }
            let net = piece.net.net();
            let Some(certificate) = Certificate::of(net, self.view, self.pixel, DVec2::ZERO) else { return true };
            let [u, v] = Piece::parameter(&piece.domain, DVec2::ZERO);
            let center = self.drawn.jet(self.scene, u, v).point;
            match self.solve(&certificate, &piece.domain, center) {
                Solution::At(meeting) => found.push(meeting),
                Solution::Nowhere => {}
                Solution::Unknown => return true,
            }
            false
        });
    }

    /// What (F, G) of a view point may be where the ray meets it.
    fn slack(&self, q: DVec4) -> f64 {
        RESOLUTION * self.view.divisor(q) + self.drawn.noise
    }

    /// Pieces below this many pixels are not cut further.
    fn smallest(&self, piece: &Piece) -> f64 {
        let divisor = self.view.divisor_no_nearer(piece.net.points()[0]);
        RESOLUTION + 4.0 * self.drawn.noise / divisor
    }

    /// The hull lies on one side of the ray, by more than the resolution, or nearer than near.
    fn excludes(&self, piece: &Piece) -> bool {
        // Bits: F above, F below, G above, G below, nearer; each must hold for every point.
        let mut all = 0b11111_u32;
        for &q in piece.net.points() {
            let f = self.view.off_ray(q, self.pixel);
            let slack = self.slack(q);
            all &= u32::from(f.x > slack)
                | u32::from(f.x < -slack) << 1
                | u32::from(f.y > slack) << 2
                | u32::from(f.y < -slack) << 3
                | u32::from(self.view.clearance(q) < 0.0) << 4;
            if all == 0 {
                return false;
            }
        }
        true
    }

    /// The one meeting a certified piece can have, by Newton's method; `center` is the view point at its middle.
    ///
    /// Closed: a piece that the ray misses by less than the resolution is met at its border.
    fn solve(&self, certificate: &Certificate, domain: &[[f64; 2]; 2], center: DVec4) -> Solution {
        let Certificate { inverse, contraction: k } = *certificate;
        let row_sum = inverse.x_axis.abs() + inverse.y_axis.abs();
        // The resolution in units of s; the divisor may vary over the piece, hence 4.
        let slack = 4.0 * row_sum.max_element() * self.slack(center).abs();
        let mut s = -(inverse * self.view.off_ray(center, self.pixel));
        if s.abs().max_element() > 1.0 + k + slack {
            return Solution::Nowhere;
        }
        s = s.clamp(DVec2::NEG_ONE, DVec2::ONE);
        let half = DVec2::new(domain[0][1] - domain[0][0], domain[1][1] - domain[1][0]) * 0.5;
        for _ in 0..MAX_STEPS {
            let parameter = Piece::parameter(domain, s);
            let jet = self.drawn.jet(self.scene, parameter[0], parameter[1]);
            let f = self.view.off_ray(jet.point, self.pixel);
            let reach = self.slack(jet.point);
            let close = f.abs().max_element() <= reach;
            let h = inverse * f;
            let uncertainty = k / (1.0 - k) * h.abs().max_element();
            if !close && (s - h).abs().max_element() > 1.0 + uncertainty + slack {
                return Solution::Nowhere;
            }
            let next = (s - self.step(&jet, half, f).unwrap_or(h)).clamp(DVec2::NEG_ONE, DVec2::ONE);
            if (next - s).abs().max_element() > SMALLEST_STEP {
                s = next;
            } else if close {
                return self.meeting(parameter, &jet, row_sum * half * reach);
            } else {
                return Solution::Unknown;
            }
        }
        Solution::Unknown
    }

    /// Newton's step in s; `None` where the Jacobian is singular.
    fn step(&self, jet: &Jet, half: DVec2, f: DVec2) -> Option<DVec2> {
        let column = |d| self.view.off_ray(d, self.pixel);
        let jacobian = DMat2::from_cols(column(jet.du) * half.x, column(jet.dv) * half.y);
        let step = jacobian.inverse() * f;
        step.is_finite().then_some(step)
    }

    fn meeting(&self, parameter: [f64; 2], jet: &Jet, extent: DVec2) -> Solution {
        if self.view.clearance(jet.point) < 0.0 {
            return Solution::Nowhere;
        }
        let depth = self.view.depth(jet.point);
        Solution::At(Meeting { parameter, extent: extent.to_array(), depth, certified: true })
    }
}

/// The control net of a drawn patch in the view.
pub(super) fn view_net(scene: &Scene, drawn: &Drawn) -> BezierPatch {
    let mut net = drawn.net(scene).to_patch();
    for q in net.points_mut() {
        *q = drawn.to_view(*q);
    }
    net
}

/// A piece below the resolution that the ray could not be shown to miss.
fn standing_for(piece: &Piece, depth: f64) -> Meeting {
    let [[u0, u1], [v0, v1]] = piece.domain;
    Meeting {
        parameter: [(u0 + u1) * 0.5, (v0 + v1) * 0.5],
        extent: [(u1 - u0) * 0.5, (v1 - v0) * 0.5],
        depth,
        certified: false,
    }
}

impl Meeting {
    /// One meeting for two that touch.
    pub fn joined(&self, other: &Self) -> Self {
        let mut joined = *self;
        for axis in 0..2 {
            let bound = |sign: f64, pick: fn(f64, f64) -> f64| {
                let end = |m: &Self| m.parameter[axis] + sign * m.extent[axis];
                pick(end(self), end(other))
            };
            let (low, high) = (bound(-1.0, f64::min), bound(1.0, f64::max));
            joined.parameter[axis] = (low + high) * 0.5;
            joined.extent[axis] = (high - low) * 0.5;
        }
        joined.depth = self.depth.min(other.depth);
        joined
    }
}
