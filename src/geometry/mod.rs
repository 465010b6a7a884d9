//! Bernstein and NURBS mathematics in f64. No files, no pixels.
//!
//! Control points are homogeneous, `(wx, wy, wz, w)` with `w > 0`. Control nets are row major with u outermost:
//! `points[i * (degree_v + 1) + j]` belongs to `B_i(u) B_j(v)`.

pub mod bernstein;
mod error;
mod net;

pub use error::GeometryError;
pub use net::{BezierPatch, Jet, Net, SurfacePoint};
