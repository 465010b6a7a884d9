//! Evaluation of surfaces by formula; where they close, end and collapse.

use super::{CurveForm, CurveSpan, SurfaceForm};
use crate::geometry::{NurbsSurface, SurfacePoint, exact::Frame, exact::sin_cos};
use glam::DVec3;
use std::f64::consts::{FRAC_PI_2, TAU};

/// A line of the parameter plane that is one point in space: a sphere's pole, a cone's apex.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pole {
    /// The parameter that is constant on the line: 0 is u, 1 is v.
    pub axis: usize,
    pub value: f64,
    pub point: DVec3,
}

/// A point of a surface of revolution and its derivatives, from those of the profile in the half plane of angle 0:
/// distance from the axis and height.
fn turned(frame: &Frame, u: f64, [r, z]: [f64; 2], [dr, dz]: [f64; 2]) -> SurfacePoint {
    let (s, c) = sin_cos(u);
    let out = frame.x * c + frame.y * s;
    SurfacePoint {
        position: frame.origin + out * r + frame.z * z,
        du: (frame.y * c - frame.x * s) * r,
        dv: out * dr + frame.z * dz,
    }
}

/// `p` turned about the direction `frame.z` by the angle whose sine and cosine are given.
fn rotated(frame: &Frame, p: DVec3, (s, c): (f64, f64)) -> DVec3 {
    let along = frame.z * p.dot(frame.z);
    let radial = p - along;
    along + radial * c + frame.z.cross(radial) * s
}

impl SurfaceForm {
    /// Position and first derivatives in space at the surface's own parameters. An offset's derivatives are those of
    /// its base plus central differences of its normal.
    pub fn surface_point(&self, u: f64, v: f64) -> SurfacePoint {
        match self {
            Self::Plane(frame) => SurfacePoint { position: frame.point(u, v, 0.0), du: frame.x, dv: frame.y },
            Self::Cylinder { frame, radius } => turned(frame, u, [*radius, v], [0.0, 1.0]),
            Self::Cone { frame, radius, half_angle } => {
                let slope = half_angle.tan();
                turned(frame, u, [radius + v * slope, v], [slope, 1.0])
            }
            Self::Sphere { frame, radius } => {
                let (s, c) = sin_cos(v);
                turned(frame, u, [radius * c, radius * s], [-radius * s, radius * c])
            }
            Self::Torus { frame, major, minor } => {
                let (s, c) = sin_cos(v);
                turned(frame, u, [major + minor * c, minor * s], [-minor * s, minor * c])
            }
            Self::Extrusion { profile, direction } => {
                let (p, du) = profile.tangent(u);
                SurfacePoint { position: p + *direction * v, du, dv: *direction }
            }
            Self::Revolution { profile, frame } => {
                let (p, d) = profile.tangent(v);
                let turn = sin_cos(u);
                let arm = rotated(frame, p - frame.origin, turn);
                SurfacePoint { position: frame.origin + arm, du: frame.z.cross(arm), dv: rotated(frame, d, turn) }
            }
            Self::Offset { base, distance } => offset_point(base, *distance, u, v),
            Self::Nurbs(surface) => surface.surface_point(u, v),
        }
    }

    /// Position at the surface's own parameters.
    pub fn position(&self, u: f64, v: f64) -> DVec3 {
        self.surface_point(u, v).position
    }

    /// The parameters' periods where the surface closes: turns, and NURBS (or profiles) whose borders are within
    /// `tolerance`.
    pub fn periods(&self, tolerance: f64) -> [Option<f64>; 2] {
        match self {
            Self::Plane(_) => [None, None],
            Self::Cylinder { .. } | Self::Cone { .. } | Self::Sphere { .. } => [Some(TAU), None],
            Self::Torus { .. } => [Some(TAU), Some(TAU)],
            Self::Extrusion { profile, .. } => [profile_period(profile, tolerance), None],
            Self::Revolution { profile, .. } => [Some(TAU), profile_period(profile, tolerance)],
            Self::Offset { base, .. } => base.periods(tolerance),
            Self::Nurbs(surface) => [0, 1].map(|axis| nurbs_period(surface, axis, tolerance)),
        }
    }

    /// Where the parameters end by the surface's nature; infinite where they don't or where it closes.
    pub fn limits(&self) -> [[f64; 2]; 2] {
        const NONE: [f64; 2] = [f64::NEG_INFINITY, f64::INFINITY];
        match self {
            Self::Plane(_) | Self::Cylinder { .. } | Self::Cone { .. } | Self::Torus { .. } => [NONE, NONE],
            Self::Sphere { .. } => [NONE, [-FRAC_PI_2, FRAC_PI_2]],
            Self::Extrusion { profile, .. } => [profile_limits(profile), NONE],
            Self::Revolution { profile, .. } => [NONE, profile_limits(profile)],
            Self::Offset { base, .. } => base.limits(),
            Self::Nurbs(surface) => surface.domain(),
        }
    }

    /// The lines that collapse into a point, to within `tolerance`.
    pub fn poles(&self, tolerance: f64) -> Vec<Pole> {
        let on_axis = |frame: &Frame, value: f64, z: f64| Pole { axis: 1, value, point: frame.point(0.0, 0.0, z) };
        match self {
            Self::Cone { frame, radius, half_angle } if half_angle.tan().abs() > 1e-9 => {
                let v = -radius / half_angle.tan();
                vec![on_axis(frame, v, v)]
            }
            Self::Sphere { frame, radius } => {
                vec![on_axis(frame, -FRAC_PI_2, -radius), on_axis(frame, FRAC_PI_2, *radius)]
            }
            Self::Torus { frame, major, minor } if major.abs() <= minor.abs() => {
                let v = (-major / minor).acos();
                [-v, v].map(|v| on_axis(frame, v, minor * v.sin())).to_vec()
            }
            Self::Revolution { profile, frame } => {
                let mut ends: Vec<f64> = profile_limits(profile).into_iter().filter(|t| t.is_finite()).collect();
                ends.dedup();
                let poles = ends.into_iter().map(|value| Pole { axis: 1, value, point: profile.curve.position(value) });
                let off_axis = |p: DVec3| (p - frame.origin).reject_from_normalized(frame.z).length();
                poles.filter(|pole| off_axis(pole.point) <= tolerance).collect()
            }
            Self::Offset { base, .. } => base.poles(tolerance),
            Self::Nurbs(surface) => nurbs_poles(surface, tolerance),
            _ => Vec::new(),
        }
    }
}

fn offset_point(base: &SurfaceForm, distance: f64, u: f64, v: f64) -> SurfacePoint {
    let normal = |u: f64, v: f64| {
        let point = base.surface_point(u, v);
        point.du.cross(point.dv).normalize_or_zero()
    };
    let [h, k] = base.limits().map(|[a, b]| if (b - a).is_finite() { 1e-6 * (b - a) } else { 1e-6 });
    let point = base.surface_point(u, v);
    SurfacePoint {
        position: point.position + normal(u, v) * distance,
        du: point.du + (normal(u + h, v) - normal(u - h, v)) * (0.5 * distance / h),
        dv: point.dv + (normal(u, v + k) - normal(u, v - k)) * (0.5 * distance / k),
    }
}

fn ascending([a, b]: [f64; 2]) -> [f64; 2] {
    [a.min(b), a.max(b)]
}

fn profile_limits(profile: &CurveSpan) -> [f64; 2] {
    match (&profile.curve, ascending(profile.range)) {
        (CurveForm::Nurbs(curve), range) => {
            let [a, b] = curve.domain();
            let cut = [range[0].max(a), range[1].min(b)];
            if cut[0] < cut[1] { cut } else { [a, b] }
        }
        (CurveForm::Ellipse { .. }, [a, b]) if b - a >= TAU * (1.0 - 1e-9) || a == b => {
            [f64::NEG_INFINITY, f64::INFINITY]
        }
        (_, range) if range[0] == range[1] => [f64::NEG_INFINITY, f64::INFINITY],
        (_, range) => range,
    }
}

fn profile_period(profile: &CurveSpan, tolerance: f64) -> Option<f64> {
    let [a, b] = profile_limits(profile);
    let whole = match &profile.curve {
        CurveForm::Nurbs(curve) => [a, b] == curve.domain(),
        _ => !(b - a).is_finite(),
    };
    profile.curve.period(tolerance).filter(|_| whole)
}

/// Positions along the border where the parameter `axis` has its first (`end` 0) or last value, with more samples than
/// the border has control points.
fn border(surface: &NurbsSurface, axis: usize, end: usize) -> impl Iterator<Item = DVec3> {
    let domain = surface.domain();
    let spans = 2 * surface.counts()[1 - axis];
    (0..=spans).map(move |k| {
        let [a, b] = domain[1 - axis];
        let along = a + (b - a) * (k as f64 / spans as f64);
        let across = domain[axis][end];
        if axis == 0 { surface.position(across, along) } else { surface.position(along, across) }
    })
}

fn nurbs_period(surface: &NurbsSurface, axis: usize, tolerance: f64) -> Option<f64> {
    let near = |(p, q): (DVec3, DVec3)| p.distance_squared(q) <= tolerance * tolerance;
    if !border(surface, axis, 0).zip(border(surface, axis, 1)).all(near) {
        return None;
    }
    let [a, b] = surface.domain()[axis];
    Some(b - a)
}

fn nurbs_poles(surface: &NurbsSurface, tolerance: f64) -> Vec<Pole> {
    let mut poles = Vec::new();
    for (axis, end) in [(0, 0), (0, 1), (1, 0), (1, 1)] {
        let mut points = border(surface, axis, end);
        let Some(point) = points.next() else { continue };
        if points.all(|p| p.distance_squared(point) <= tolerance * tolerance) {
            poles.push(Pole { axis, value: surface.domain()[axis][end], point });
        }
    }
    poles
}
