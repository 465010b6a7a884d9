//! Exact rational Bézier forms of the surfaces that CAD files give by formula.
//!
//! Parameters are those of ISO 10303-42 (STEP): `u` is the angle about the frame's z axis in radians, `v` a length or
//! a second angle. Patches come with their rectangle of these parameters. An arc is split into equal pieces of at most
//! a quarter turn; *within* a piece a Bézier parameter is not proportional to the angle, [`arc_parameter`] converts.
//! Closed forms have `S_u x S_v` pointing outward for positive radii and ascending ranges.
//!
//! The functions take any numbers; [`super::PatchPiece::checked`] finds what is not finite in their result.

use super::{BezierCurve, BezierPatch, CurvePiece, PatchPiece};
use glam::{DAffine3, DMat3, DVec3, DVec4};
use std::f64::consts::{FRAC_PI_2, TAU};

/// The whole turn.
pub const FULL: [f64; 2] = [0.0, TAU];

/// A right-handed orthonormal placement.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Frame {
    pub origin: DVec3,
    pub x: DVec3,
    pub y: DVec3,
    pub z: DVec3,
}

impl Frame {
    pub const IDENTITY: Self = Self { origin: DVec3::ZERO, x: DVec3::X, y: DVec3::Y, z: DVec3::Z };

    /// z along `axis`, x as near to `reference` as it can be (any x where `reference` is parallel to the axis).
    /// `None` for an axis without direction.
    pub fn new(origin: DVec3, axis: DVec3, reference: DVec3) -> Option<Self> {
        let z = axis.try_normalize()?;
        let reference = reference.try_normalize().unwrap_or(DVec3::X);
        let x = reference - z * reference.dot(z);
        let x = if x.length() > 1e-9 { x.normalize() } else { z.any_orthonormal_vector() };
        // Twice is enough: after the first time what is left along z is rounding over the length of x.
        let x = (x - z * x.dot(z)).normalize();
        Some(Self { origin, x, y: z.cross(x), z })
    }

    /// The point with these coordinates in the frame.
    pub fn point(&self, x: f64, y: f64, z: f64) -> DVec3 {
        self.origin + self.x * x + self.y * y + self.z * z
    }
}

/// Sine and cosine that are exact at quarter turns, so that poles close and seams meet.
pub(super) fn sin_cos(angle: f64) -> (f64, f64) {
    let quarters = angle / FRAC_PI_2;
    let nearest = quarters.round();
    if (quarters - nearest).abs() > 1e-15 * nearest.abs().max(1.0) {
        return angle.sin_cos();
    }
    [(0.0, 1.0), (1.0, 0.0), (0.0, -1.0), (-1.0, 0.0)][nearest.rem_euclid(4.0) as usize]
}

/// One arc of the unit circle as a rational quadratic: homogeneous `(x, y, w)`.
struct UnitArc {
    domain: [f64; 2],
    points: [[f64; 3]; 3],
}

/// The unit circle from `range[0]` to `range[1]` in equal arcs of at most a quarter turn; a descending range runs
/// clockwise.
fn unit_arcs(range: [f64; 2]) -> Vec<UnitArc> {
    let arc = |k: usize| {
        let domain = [arc_border(range, k), arc_border(range, k + 1)];
        let [(s0, c0), (s1, c1)] = domain.map(sin_cos);
        let (s, c) = sin_cos(0.5 * (domain[0] + domain[1]));
        let weight = (0.5 * (domain[1] - domain[0])).cos();
        // The tangents meet at distance 1 / weight: homogeneous, that is the middle direction itself.
        UnitArc { domain, points: [[c0, s0, 1.0], [c, s, weight], [c1, s1, 1.0]] }
    };
    (0..arc_count(range)).map(arc).collect()
}

/// Number of arcs that a circle over `range` is split into.
pub fn arc_count([start, end]: [f64; 2]) -> usize {
    // A quarter and a rounding error is still a quarter. Senseless ranges (not finite, a thousand turns) give points or
    // weights that `checked` refuses.
    ((end - start).abs() / FRAC_PI_2 - 1e-12).ceil().clamp(1.0, 4096.0) as usize
}

/// The angle where arc `k` of `range` begins, and the one before it ends.
pub fn arc_border([start, end]: [f64; 2], k: usize) -> f64 {
    let count = arc_count([start, end]);
    if k == count { end } else { start + (end - start) * (k as f64 / count as f64) }
}

/// The Bézier parameter in [0, 1] of `angle` on the arc piece over `[a, b]`: `tan(θ/2) = (2t - 1) tan(h/2)`, with θ from
/// the arc's middle and h half its sweep.
pub fn arc_parameter(angle: f64, [a, b]: [f64; 2]) -> f64 {
    let quarter = 0.25 * (b - a);
    0.5 + 0.5 * (0.5 * (angle - 0.5 * (a + b))).tan() / quarter.tan()
}

/// The inverse of [`arc_parameter`]: the angle at Bézier parameter `t`.
pub fn arc_angle(t: f64, [a, b]: [f64; 2]) -> f64 {
    0.5 * (a + b) + 2.0 * ((2.0 * t - 1.0) * (0.25 * (b - a)).tan()).atan()
}

/// The ellipse `origin + x rx cos t + y ry sin t` over `range`, as quadratics.
pub fn ellipse(frame: &Frame, [rx, ry]: [f64; 2], range: [f64; 2]) -> Vec<CurvePiece> {
    let point = |[c, s, w]: [f64; 3]| (frame.origin * w + frame.x * (rx * c) + frame.y * (ry * s)).extend(w);
    let piece = |arc: UnitArc| CurvePiece {
        curve: BezierCurve::from_points(arc.points.map(point).to_vec()),
        domain: arc.domain,
    };
    unit_arcs(range).into_iter().map(piece).collect()
}

/// The circle of `radius` in the frame's xy plane over the angles `range`.
pub fn circle(frame: &Frame, radius: f64, range: [f64; 2]) -> Vec<CurvePiece> {
    ellipse(frame, [radius, radius], range)
}

/// The parabola `origin + focal (t² x + 2 t y)` over `range`.
pub fn parabola(frame: &Frame, focal: f64, [a, b]: [f64; 2]) -> CurvePiece {
    let point = |s: f64, t: f64| frame.point(focal * s * t, focal * (s + t), 0.0).extend(1.0);
    CurvePiece { curve: BezierCurve::from_points(vec![point(a, a), point(a, b), point(b, b)]), domain: [a, b] }
}

/// The branch `origin + x rx cosh t + y ry sinh t` over `range`.
pub fn hyperbola(frame: &Frame, [rx, ry]: [f64; 2], [a, b]: [f64; 2]) -> CurvePiece {
    let point = |t: f64, w: f64| (frame.origin * w + frame.x * (rx * t.cosh()) + frame.y * (ry * t.sinh())).extend(w);
    // As for a circle: the tangents meet on the middle direction, here at weight cosh of half the range.
    let points = vec![point(a, 1.0), point(0.5 * (a + b), (0.5 * (b - a)).cosh()), point(b, 1.0)];
    CurvePiece { curve: BezierCurve::from_points(points), domain: [a, b] }
}

/// The rectangle `origin + u x + v y`.
pub fn plane(frame: &Frame, [u, v]: [[f64; 2]; 2]) -> PatchPiece {
    let points = u.iter().flat_map(|&u| v.iter().map(move |&v| frame.point(u, v, 0.0).extend(1.0)));
    PatchPiece { patch: BezierPatch::from_points([1, 1], points.collect()), domain: [u, v] }
}

/// The profile turned about the frame's z axis: u is the angle, v the profile's parameter.
///
/// A profile that runs up the axis in the half plane x > 0 gives outward normals.
pub fn revolution(frame: &Frame, profile: &[CurvePiece], range: [f64; 2]) -> Vec<PatchPiece> {
    let mut pieces = Vec::new();
    for arc in unit_arcs(range) {
        for piece in profile {
            let patch = revolve(frame, &arc, &piece.curve);
            pieces.push(PatchPiece { patch, domain: [arc.domain, piece.domain] });
        }
    }
    pieces
}

/// One arc times one Bézier curve: each control point goes round its own circle about the axis.
fn revolve(frame: &Frame, arc: &UnitArc, profile: &BezierCurve) -> BezierPatch {
    let turn = |[c, s, k]: [f64; 3], p: DVec4| {
        let offset = p.truncate() - frame.origin * p.w;
        let along = frame.z * offset.dot(frame.z);
        let radial = offset - along;
        ((frame.origin * p.w + along) * k + radial * c + frame.z.cross(radial) * s).extend(p.w * k)
    };
    let points = arc.points.iter().flat_map(|&a| profile.points().iter().map(move |&p| turn(a, p)));
    BezierPatch::from_points([2, profile.degree()], points.collect())
}

/// The profile moved along `direction`: u is the profile's parameter, `profile(u) + v direction`.
pub fn extrusion(profile: &[CurvePiece], direction: DVec3, v: [f64; 2]) -> Vec<PatchPiece> {
    let moved = |p: DVec4, v: f64| p + (direction * (v * p.w)).extend(0.0);
    let patch = |curve: &BezierCurve| {
        let points = curve.points().iter().flat_map(|&p| v.map(|v| moved(p, v)));
        BezierPatch::from_points([curve.degree(), 1], points.collect())
    };
    profile.iter().map(|piece| PatchPiece { patch: patch(&piece.curve), domain: [piece.domain, v] }).collect()
}

/// `origin + radius (cos u x + sin u y) + v z`.
pub fn cylinder(frame: &Frame, radius: f64, ranges: [[f64; 2]; 2]) -> Vec<PatchPiece> {
    cone(frame, radius, 0.0, ranges)
}

/// `origin + (radius + v tan(half_angle)) (cos u x + sin u y) + v z`; radians. Normals point inward beyond the apex.
pub fn cone(frame: &Frame, radius: f64, half_angle: f64, [u, v]: [[f64; 2]; 2]) -> Vec<PatchPiece> {
    let [a, b] = v.map(|v| DVec3::new(radius + v * half_angle.tan(), 0.0, v));
    placed(frame, &[CurvePiece { curve: BezierCurve::line(a, b), domain: v }], u)
}

/// `origin + radius (cos v (cos u x + sin u y) + sin v z)`, v from -π/2 to π/2; the poles are collapsed edges.
pub fn sphere(frame: &Frame, radius: f64, [u, v]: [[f64; 2]; 2]) -> Vec<PatchPiece> {
    placed(frame, &circle(&meridian(0.0), radius, v), u)
}

/// `origin + (major + minor cos v) (cos u x + sin u y) + minor sin v z`.
pub fn torus(frame: &Frame, major: f64, minor: f64, [u, v]: [[f64; 2]; 2]) -> Vec<PatchPiece> {
    placed(frame, &circle(&meridian(major), minor, v), u)
}

/// The half plane y = 0, x > 0 as a frame: its x leads away from the z axis, its y along it, `radius` from the axis.
fn meridian(radius: f64) -> Frame {
    Frame { origin: DVec3::X * radius, x: DVec3::X, y: DVec3::Z, z: DVec3::NEG_Y }
}

/// A profile given in the frame, turned and then placed: poles and seams close bit for bit.
fn placed(frame: &Frame, profile: &[CurvePiece], range: [f64; 2]) -> Vec<PatchPiece> {
    let map = DAffine3::from_mat3_translation(DMat3::from_cols(frame.x, frame.y, frame.z), frame.origin);
    let mut pieces = revolution(&Frame::IDENTITY, profile, range);
    pieces.iter_mut().for_each(|piece| piece.patch = piece.patch.transformed(&map));
    pieces
}
