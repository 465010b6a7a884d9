//! The frame on the CPU, one file a stage (DESIGN section 1): cull, estimate, evaluate, rasterize, fill, shade.

mod basis;
mod bounds;
mod cull;
mod estimate;
mod evaluate;
mod fill;
mod fold_step;
mod frame;
mod interpolate;
mod lens;
mod newton;
mod options;
mod rasterize;
mod settle;
mod shade;
mod show;
mod slefe;
mod stats;
mod stroke;
mod topology;

#[cfg(test)]
mod tests;

pub use frame::{Frame, Pixel, RenderError, Renderer};
pub use options::{Bound, Cull, Fill, Grid, Interpolation, Options, Show};
pub use stats::{StageTime, Stats};
