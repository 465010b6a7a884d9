//! The oracle: what an image should show, in f64 and without any tessellation (DESIGN section 6).
//!
//! ```text
//! Scene, Camera --Oracle::new--> patches cut into parts, boxes in the image
//!                                        |
//! image point --Oracle::hits--> which patches, (u, v), depth      (piece: certificates, ray: Newton)
//!                                        |
//! Pixel of a frame --check--> errors, crack, covering, depth --report--> Report, ErrorMap
//! ```
//!
//! A ray is a point of the image. In homogeneous pixel coordinates (`view`) a patch is a Bézier net again, and the ray
//! meets it where two linear functions of it are zero. `piece` cuts patches until a Krawczyk test proves that no ray
//! through the part's box meets it twice; one Newton iteration then finds the hit or proves that there is none (`ray`).
//! Parts without proof (silhouettes, edge-on and collapsed patches) are halved for the single ray until they have one
//! or are smaller than `RESOLUTION` pixels: these count as hits. `hierarchy` finds the parts under a ray.
//!
//! Nothing here is shared with the stages but the evaluation of nets, the scene and the camera.

mod check;
mod error_image;
mod hierarchy;
mod hits;
mod piece;
mod ray;
mod report;
mod sample;
mod view;

pub use error_image::{Class, ErrorMap};
pub use hits::{Hit, Oracle};
pub use report::{ErrorStats, Failure, Offender, Report, verify};
pub use sample::Sampling;

/// What lies within this many pixels is not told apart: rays that miss a border by less hit it, and parts of a patch
/// smaller than this are hit where the ray can't be shown to miss them.
pub const RESOLUTION: f64 = 1e-4;
