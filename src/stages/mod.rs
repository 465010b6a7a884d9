//! The frame on the CPU, one file a stage (DESIGN section 1): cull, estimate, evaluate, rasterize, trim, fill, shade.

pub(crate) mod basis;
mod bounds;
mod cone;
pub(crate) mod cull;
mod device;
mod device_geometry;
mod error;
pub(crate) mod estimate;
pub(crate) mod evaluate;
mod fill;
mod fold_step;
mod frame;
mod hardware;
mod interpolate;
pub(crate) mod lens;
mod light;
mod newton;
mod options;
mod rasterize;
mod settle;
mod settle_near;
pub(crate) mod shade;
mod show;
mod slefe;
mod stats;
pub(crate) mod stroke;
mod topology;
mod trim;
pub(crate) mod trim_cut;
mod trim_marks;
mod trim_quad;
mod trim_texture;

#[cfg(test)]
mod tests;

pub use device::Engine;
pub use device_geometry::GeometryCounts;
pub use error::RenderError;
pub use frame::{Frame, Pixel, Renderer};
pub(crate) use newton::CONVERGED;
pub use options::{Bound, Cull, Fill, FrameShape, Grid, Interpolation, Options, Precision, Raster, Route, Show, Trim};
pub use stats::{STAGES, StageTime, Stats};
pub use trim::TrimCounts;
