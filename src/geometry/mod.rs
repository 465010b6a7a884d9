//! Bernstein and NURBS mathematics in f64. No files, no pixels.
//!
//! Control points are homogeneous, `(wx, wy, wz, w)` with `w > 0`. Control nets are row major with u outermost:
//! `points[i * (degree_v + 1) + j]` belongs to `B_i(u) B_j(v)`.

mod area;
pub mod bernstein;
mod crossing_area;
mod curve;
mod error;
pub mod exact;
mod forms;
pub mod interpolate;
mod knots;
mod net;
mod root;
mod surface;
mod triangle;
mod trimmed_area;

pub use area::{Estimate, patch_area, rough_patch_area};
pub use curve::{BezierCurve, CurvePiece, NurbsCurve, distance2_from_line};
pub use error::GeometryError;
pub use forms::{Axis, Chart, CurveForm, CurveSpan, Pole, SurfaceForm};
pub use knots::Knots;
pub use net::{BezierPatch, Jet, MAX_DEGREE, Net, SurfacePoint};
pub use root::root;
pub use surface::{NurbsSurface, PatchPiece};
pub use triangle::triangle_to_tensor;
pub use trimmed_area::{Outline, Tile, trimmed_area};
