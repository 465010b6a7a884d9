//! The frame on the CPU, one file a stage (DESIGN section 1).

mod frame;
mod options;

pub use frame::{Frame, Pixel, RenderError, Renderer, StageTime, Stats};
pub use options::{Bound, Cull, Fill, Grid, Interpolation, Options, Show};
