//! Curves and surfaces as CAD files give them: by formula or by control points, with the parameters of ISO 10303-42.

mod axis;
mod chart;
mod curve;
mod offset;
mod patches;
mod search;
mod surface;

pub use axis::Axis;
pub use chart::Chart;
pub use surface::Pole;

use super::{NurbsCurve, NurbsSurface, exact::Frame};
use glam::DVec3;

/// A curve in space; plane curves leave z at 0. Angles are in radians.
#[derive(Clone, Debug, PartialEq)]
pub enum CurveForm {
    /// `origin + t direction`
    Line {
        origin: DVec3,
        direction: DVec3,
    },
    /// `origin + x rx cos t + y ry sin t`; a circle has equal radii.
    Ellipse {
        frame: Frame,
        radii: [f64; 2],
    },
    /// `origin + focal (t² x + 2 t y)`
    Parabola {
        frame: Frame,
        focal: f64,
    },
    /// `origin + x rx cosh t + y ry sinh t`
    Hyperbola {
        frame: Frame,
        radii: [f64; 2],
    },
    Nurbs(NurbsCurve),
}

/// A curve from parameter `range[0]` to `range[1]`, which may be the smaller.
#[derive(Clone, Debug, PartialEq)]
pub struct CurveSpan {
    pub curve: CurveForm,
    pub range: [f64; 2],
}

/// A surface without bounds of its own, or those of its control points.
#[derive(Clone, Debug, PartialEq)]
pub enum SurfaceForm {
    /// `origin + u x + v y`
    Plane(Frame),
    /// u is the angle about z, v the height.
    Cylinder {
        frame: Frame,
        radius: f64,
    },
    /// Radius `radius + v tan half_angle` at height v.
    Cone {
        frame: Frame,
        radius: f64,
        half_angle: f64,
    },
    /// u is the longitude, v the latitude in [-π/2, π/2].
    Sphere {
        frame: Frame,
        radius: f64,
    },
    /// u is the angle about z, v the one about the tube; `minor > major` crosses itself (degenerate).
    Torus {
        frame: Frame,
        major: f64,
        minor: f64,
    },
    /// `profile(u) + v direction`
    Extrusion {
        profile: CurveSpan,
        direction: DVec3,
    },
    /// `profile(v)` turned by the angle u about the frame's z axis.
    Revolution {
        profile: CurveSpan,
        frame: Frame,
    },
    /// `base + distance n`, n along `S_u x S_v`.
    Offset {
        base: Box<SurfaceForm>,
        distance: f64,
    },
    Nurbs(NurbsSurface),
}
