//! Exact patches of a surface over a box of its own parameters.

use super::{Axis, Chart, CurveForm, CurveSpan, SurfaceForm};
use crate::geometry::{GeometryError, PatchPiece, exact};

/// A rectangle of parameters: `[[u0, u1], [v0, v1]]`.
type Rectangle = [[f64; 2]; 2];

impl CurveSpan {
    fn axis(&self, range: [f64; 2]) -> Axis {
        match self.curve {
            CurveForm::Ellipse { .. } => Axis::arcs(range),
            CurveForm::Hyperbola { .. } => Axis::Hyperbola { range },
            _ => Axis::Same,
        }
    }
}

impl Chart {
    /// How the parameter plane of the patches over `area` stands to the surface's own parameters.
    pub fn axes(&self, area: Rectangle) -> [Axis; 2] {
        let [u, v] = area;
        match self.form() {
            SurfaceForm::Plane(_) | SurfaceForm::Nurbs(_) | SurfaceForm::Offset { .. } => [Axis::Same, Axis::Same],
            SurfaceForm::Cylinder { .. } | SurfaceForm::Cone { .. } => [Axis::arcs(u), Axis::Same],
            SurfaceForm::Sphere { .. } | SurfaceForm::Torus { .. } => [Axis::arcs(u), Axis::arcs(v)],
            SurfaceForm::Extrusion { profile, .. } => [profile.axis(u), Axis::Same],
            SurfaceForm::Revolution { profile, .. } => [Axis::arcs(u), profile.axis(v)],
        }
    }

    /// The patches that cover `area`, a rectangle of the surface's own parameters, and no more; on NURBS those that
    /// meet it, cut to it, with shifted copies where the surface closes.
    ///
    /// # Errors
    /// Where the surface has points that are not finite over `area`.
    pub fn patches(&self, area: Rectangle) -> Result<Vec<PatchPiece>, GeometryError> {
        let [u, v] = area;
        let pieces = match self.form() {
            SurfaceForm::Plane(frame) => vec![exact::plane(frame, area)],
            SurfaceForm::Cylinder { frame, radius } => exact::cylinder(frame, *radius, area),
            SurfaceForm::Cone { frame, radius, half_angle } => exact::cone(frame, *radius, *half_angle, area),
            SurfaceForm::Sphere { frame, radius } => exact::sphere(frame, *radius, area),
            SurfaceForm::Torus { frame, major, minor } => exact::torus(frame, *major, *minor, area),
            SurfaceForm::Extrusion { profile, direction } => {
                exact::extrusion(&profile.curve.pieces(u, self.periods()[0].is_some()), *direction, v)
            }
            SurfaceForm::Revolution { profile, frame } => {
                exact::revolution(frame, &profile.curve.pieces(v, self.periods()[1].is_some()), u)
            }
            SurfaceForm::Nurbs(_) | SurfaceForm::Offset { .. } => self.cut_pieces(area),
        };
        PatchPiece::checked("surface", pieces)
    }

    fn cut_pieces(&self, area: Rectangle) -> Vec<PatchPiece> {
        let domain = self.form().limits();
        let turns = [0, 1].map(|axis| match self.periods()[axis] {
            Some(period) => {
                let turn = |t: f64| (t - domain[axis][0]) / period;
                let eps = 1e-9;
                [(turn(area[axis][0]) + eps).floor(), (turn(area[axis][1]) - eps).ceil()]
            }
            None => [0.0, 1.0],
        });
        // A loop winds a few times at most; more is senseless and would fill the memory.
        let turns = turns.map(|[a, b]| (a.clamp(-100.0, 100.0) as i32)..(b.clamp(-100.0, 100.0) as i32));
        let mut pieces = Vec::new();
        for i in turns[0].clone() {
            for j in turns[1].clone() {
                let shift = [i, j].map(f64::from);
                let shift = [0, 1].map(|axis| shift[axis] * self.periods()[axis].unwrap_or(0.0));
                pieces.extend(self.pieces().iter().filter_map(|piece| cut(piece, shift, area)));
            }
        }
        pieces
    }
}

/// The part of a shifted piece inside `area`; `None` where they only touch.
fn cut(piece: &PatchPiece, shift: [f64; 2], area: Rectangle) -> Option<PatchPiece> {
    let whole = [0, 1].map(|axis| piece.domain[axis].map(|t| t + shift[axis]));
    let mut domain = whole;
    for axis in 0..2 {
        let [a, b] = whole[axis];
        let least = 1e-9 * (b - a).min(area[axis][1] - area[axis][0]);
        let common = [a.max(area[axis][0]), b.min(area[axis][1])];
        if common[1] - common[0] <= least {
            return None;
        }
        // Slivers at the border are not worth a cut.
        domain[axis] =
            [if common[0] - a > least { common[0] } else { a }, if b - common[1] > least { common[1] } else { b }];
    }
    if domain == whole {
        return Some(PatchPiece { patch: piece.patch.clone(), domain });
    }
    let local = [0, 1].map(|axis| {
        let [a, b] = whole[axis];
        domain[axis].map(|t| {
            if t == a {
                0.0
            } else if t == b {
                1.0
            } else {
                (t - a) / (b - a)
            }
        })
    });
    Some(PatchPiece { patch: piece.patch.net().restrict(local), domain })
}
