//! The oracle: what an image should show, in f64 and without any tessellation (DESIGN section 6).
//!
//! ```text
//! Scene, Camera --Oracle::new--> boxes of the patches in the image   (cut: into parts where a ray comes near)
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
//! or are smaller than `RESOLUTION` pixels: these count as hits. `hierarchy` finds the patches and parts under a ray.
//! Parts and trims are made when a ray first needs them, and dropped between pixels when they have grown large, so that
//! millions of patches can be judged in little more memory than their scene takes.
//!
//! How DESIGN section 6 is read (`check`):
//! - The 5x5 sub-samples span the closed pixel, corners included; the middle one is the centre. They are shot when a
//!   verdict needs them, so most pixels cost one ray.
//! - Delta at camera depth z is `depth_tolerance` pixel sizes there plus sixteen half-ulps of the stored f32 depth. Hits
//!   within delta of the nearest are visible, so coincident patches count as one.
//! - A crack compares with the depth of the exact point at the stored parameter. A depth failure compares with that or
//!   the stored depth, whichever is farther; only with the exact point where a stroke decided the pixel, since strokes
//!   are pushed back on purpose. Both may hold of one pixel: a hidden sheet of a face that is visible.
//! - A face is a `SceneFace` of an instance. It covers a pixel where it is visible at a sub-sample, at the stored or
//!   the interpolated point, or on one of 17x17 rays. A sliver thinner than all these that the frame does not show
//!   itself would be missed, and reported as a failure. A stored point that refinement left outside its trims by at most
//!   1/128 px stands for the trim's point beside it: a face of which only an edge is in sight is visible there.
//! - The refined error counts where the centre ray meets the shown patch on the sheet that is shown: a ray may meet the
//!   patch again elsewhere, beyond a silhouette, and refinement must not go there.
//! - Trims: a hit counts inside the loops (`region`: odd-even on the exact curves) or within `RESOLUTION` of them. A
//!   *sight* is a hit, or a ray that passes a trim curve within its `TrimCurve::gap` (in space, half a pixel at most: two
//!   faces close a gap of a pixel, a wider one may be shown). The curve itself is the measure (`rim`), so that a face
//!   also reaches beyond a trim along its surface's border; along an edge that only one face has it does not reach.
//!   What a ray sees is limited by its nearest hit, so a neighbour that lies in a face's reach is seen as well as the
//!   face: a pixel may show either. A reach hides what lies behind it, except faces that have the same edge.
//! - Beyond trim: a pixel whose stored point lies outside its face's loops by more than the gap and half a pixel (its
//!   diagonal) is a covering failure, whatever else of that face may be seen in it.
//! - The errors are the larger of |x| and |y|; parameters that are no point of the instance's patches count as
//!   `f64::MAX`.
//!
//! Nothing here is shared with the stages but the evaluation of nets, the scene and the camera.

mod check;
mod cut;
mod error_image;
mod hierarchy;
mod hits;
mod piece;
mod ray;
mod region;
mod report;
mod rim;
mod sample;
mod trims;
mod view;

pub use error_image::{Class, ErrorMap};
pub use hits::{Hit, Oracle};
pub use report::{ErrorStats, Failure, Offender, Report, verify};
pub use sample::Sampling;

/// What lies within this many pixels is not told apart: rays that miss a border by less hit it, and parts of a patch
/// smaller than this are hit where the ray can't be shown to miss them.
pub const RESOLUTION: f64 = 1e-4;
