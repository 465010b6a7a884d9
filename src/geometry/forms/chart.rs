//! From points in space to a surface's own parameters.

use super::offset::{Resolved, resolved};
use super::search::{NetSearch, ProfileSearch};
use super::{Pole, SurfaceForm};
use crate::geometry::{PatchPiece, exact::Frame};
use glam::{DVec2, DVec3};
use std::f64::consts::TAU;

/// A surface made ready for inverting points.
#[derive(Clone, Debug)]
pub struct Chart {
    form: SurfaceForm,
    periods: [Option<f64>; 2],
    poles: Vec<Pole>,
    search: Search,
    error: Option<f64>,
}

#[derive(Clone, Debug)]
enum Search {
    /// There is a closed form.
    Closed,
    Profile(ProfileSearch),
    Net(NetSearch),
}

impl Chart {
    /// `tolerance`: the distance within which borders count as one (closed surfaces) or as a point (poles); `fine`: how
    /// near an offset of a free-form surface is fitted.
    pub fn new(form: SurfaceForm, tolerance: f64, fine: f64) -> Self {
        let Resolved { form, error } = resolved(form, fine);
        let periods = form.periods(tolerance);
        let poles = form.poles(tolerance);
        let search = match &form {
            SurfaceForm::Extrusion { profile, direction } => {
                Search::Profile(ProfileSearch::extruded(profile, *direction, periods[0]))
            }
            SurfaceForm::Revolution { profile, frame } => {
                Search::Profile(ProfileSearch::turned(profile, *frame, periods[1]))
            }
            SurfaceForm::Nurbs(surface) => Search::Net(NetSearch::new(surface, periods)),
            _ => Search::Closed,
        };
        Self { form, periods, poles, search, error }
    }

    pub fn form(&self) -> &SurfaceForm {
        &self.form
    }

    /// How far the surface is from what was meant, where that had to be fitted: offsets of free-form surfaces.
    pub fn error(&self) -> Option<f64> {
        self.error
    }

    /// Points of a B-spline surface that were taken for the nearest ones without proof: the search for nearer ones had
    /// looked at enough of it. How far they are off is for the caller to measure.
    pub fn unproved(&self) -> usize {
        match &self.search {
            Search::Net(search) => search.open(),
            Search::Closed | Search::Profile(_) => 0,
        }
    }

    /// The parameters' periods where the surface closes.
    pub fn periods(&self) -> [Option<f64>; 2] {
        self.periods
    }

    pub fn poles(&self) -> &[Pole] {
        &self.poles
    }

    /// The whole surface's Bézier pieces; none where it has a formula.
    pub(super) fn pieces(&self) -> &[PatchPiece] {
        match &self.search {
            Search::Net(search) => search.pieces(),
            _ => &[],
        }
    }

    /// `uv` brought into the surface's domain by whole periods, and clamped to it where it does not close.
    pub fn wrapped(&self, uv: DVec2) -> DVec2 {
        match &self.form {
            SurfaceForm::Nurbs(surface) => wrap(uv, surface.domain(), self.periods),
            _ => uv,
        }
    }

    /// Position at `uv`, which may lie any number of periods outside the domain.
    pub fn position(&self, uv: DVec2) -> DVec3 {
        self.surface_point(uv).position
    }

    /// Position and first derivatives at `uv`, as [`Chart::position`].
    pub fn surface_point(&self, uv: DVec2) -> crate::geometry::SurfacePoint {
        let inside = self.wrapped(uv);
        match (&self.form, &self.search) {
            (SurfaceForm::Extrusion { profile, .. }, Search::Profile(search)) => {
                let t = search.wrapped(inside.x);
                debug_assert!(profile.range[0].is_finite() || t == inside.x);
                self.form.surface_point(t, inside.y)
            }
            (SurfaceForm::Revolution { .. }, Search::Profile(search)) => {
                self.form.surface_point(inside.x, search.wrapped(inside.y))
            }
            _ => self.form.surface_point(inside.x, inside.y),
        }
    }

    /// The parameters of the surface's point next to `point`, of all that fit those next to `near`: periodic parameters
    /// are within half a period of it.
    ///
    /// Closed forms on analytic surfaces. Elsewhere damped Gauss-Newton, from `near` where there is one; where that ends
    /// farther than `accept` from the point, or there is none, branch and bound over the Bézier pieces' boxes finds the nearest point.
    pub fn invert(&self, point: DVec3, near: Option<DVec2>, accept: f64) -> DVec2 {
        let uv = match (&self.form, &self.search) {
            (SurfaceForm::Plane(frame), _) => {
                let p = point - frame.origin;
                return DVec2::new(p.dot(frame.x), p.dot(frame.y));
            }
            (SurfaceForm::Cylinder { frame, .. }, _) => {
                let p = local(frame, point);
                DVec2::new(p.y.atan2(p.x), p.z)
            }
            (SurfaceForm::Cone { frame, radius, half_angle }, _) => invert_cone(frame, *radius, *half_angle, point),
            (SurfaceForm::Sphere { frame, .. }, _) => {
                let p = local(frame, point);
                DVec2::new(p.y.atan2(p.x), p.z.atan2(p.x.hypot(p.y)))
            }
            (SurfaceForm::Torus { frame, major, minor }, _) => invert_torus(frame, *major, *minor, point, near),
            (_, Search::Profile(search)) => search.invert(&self.form, point, near, accept),
            (_, Search::Net(search)) => search.invert(point, near, accept),
            _ => DVec2::ZERO,
        };
        near.map_or(uv, |near| self.shifted(uv, near))
    }

    /// `uv` moved by whole periods next to `near`.
    pub fn shifted(&self, uv: DVec2, near: DVec2) -> DVec2 {
        let shift = |t: f64, near: f64, period: Option<f64>| match period {
            Some(period) => t + ((near - t) / period).round() * period,
            None => t,
        };
        DVec2::new(shift(uv.x, near.x, self.periods[0]), shift(uv.y, near.y, self.periods[1]))
    }
}

/// `t` brought into `[a, b]` by whole periods, or clamped where there is none.
pub(super) fn wrap_axis(t: f64, [a, b]: [f64; 2], period: Option<f64>) -> f64 {
    match period {
        Some(period) if t < a || t > b => (t - ((t - a) / period).floor() * period).clamp(a, b),
        Some(_) => t,
        None => t.clamp(a, b),
    }
}

pub(super) fn wrap(uv: DVec2, domain: [[f64; 2]; 2], periods: [Option<f64>; 2]) -> DVec2 {
    DVec2::new(wrap_axis(uv.x, domain[0], periods[0]), wrap_axis(uv.y, domain[1], periods[1]))
}

/// Coordinates of `point` in the frame.
pub(super) fn local(frame: &Frame, point: DVec3) -> DVec3 {
    let p = point - frame.origin;
    DVec3::new(p.dot(frame.x), p.dot(frame.y), p.dot(frame.z))
}

fn invert_cone(frame: &Frame, radius: f64, half_angle: f64, point: DVec3) -> DVec2 {
    let p = local(frame, point);
    let slope = half_angle.tan();
    let (r, u) = (p.x.hypot(p.y), p.y.atan2(p.x));
    // Beyond the apex the radius is negative: the same ruling comes out on the other side.
    let (r, u) = if radius + p.z * slope >= 0.0 { (r, u) } else { (-r, (-p.y).atan2(-p.x)) };
    // The foot on the ruling through (radius, 0) along (slope, 1).
    DVec2::new(u, ((r - radius) * slope + p.z) / (1.0 + slope * slope))
}

fn invert_torus(frame: &Frame, major: f64, minor: f64, point: DVec3, near: Option<DVec2>) -> DVec2 {
    let p = local(frame, point);
    let r = p.x.hypot(p.y);
    let outer = DVec2::new(p.y.atan2(p.x), p.z.atan2(r - major));
    if minor.abs() < major.abs() {
        return outer;
    }
    // A tube wider than its ring crosses itself: points across the axis belong to the inner sheet.
    let inner = DVec2::new((-p.y).atan2(-p.x), p.z.atan2(-r - major));
    let off = |r: f64| ((r - major).hypot(p.z) - minor.abs()).abs();
    let [outer_off, inner_off] = [off(r), off(-r)];
    if (outer_off - inner_off).abs() > 1e-9 * minor.abs() {
        return if outer_off < inner_off { outer } else { inner };
    }
    let turn = |uv: DVec2| near.map_or(0.0, |near| ((uv.x - near.x) / TAU - ((uv.x - near.x) / TAU).round()).abs());
    if turn(inner) < turn(outer) { inner } else { outer }
}
