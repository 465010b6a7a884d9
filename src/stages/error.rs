//! Why a frame could not be made.

use crate::cuda::GpuError;
use crate::vulkan::VulkanError;
use thiserror::Error;

/// Why a frame could not be made.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RenderError {
    #[error("face {face}, patch {patch} would be split into more than {limit} pieces at this view")]
    TooManyLeaves { face: u32, patch: u32, limit: usize },
    #[error("face {face}, patch {patch} can't be split finely enough in f64 for this view: give a smaller --zoom")]
    TooClose { face: u32, patch: u32 },
    #[error("face {face}, patch {patch} needs a grid of more than {limit} quads however it is split")]
    GridTooLarge { face: u32, patch: u32, limit: u64 },
    #[error("this view needs {needed} meshlets; a frame holds {limit}")]
    TooManyMeshlets { needed: u64, limit: u64 },
    #[error(
        "this view needs more than {limit} grid vertices: give a larger --tolerance or --depth-tolerance, or a smaller \
         --zoom or --size"
    )]
    TooManyVertices { limit: u64 },
    #[error("a tolerance of {tolerance} px is below what snapping and rounding take ({floor:.4} px)")]
    ToleranceTooSmall { tolerance: f64, floor: f64 },
    #[error("the model is {size:e} units large; what is drawn in f32 measures 1e-30 to 1e30: scale it")]
    ModelSize { size: f64 },
    #[error("the CPU evaluates in f32 alone: use --backend cuda or --backend emulated")]
    NoTensorCores,
    #[error("pictures that explain a frame are painted of grids in f32: use --precision f32, or --show shaded")]
    NotExplained,
    #[error(transparent)]
    Gpu(#[from] GpuError),
    #[error("--raster: {0}")]
    Vulkan(#[from] VulkanError),
    #[error("the slefe bound covers polynomial patches up to degree 7; face {face} is {what}")]
    SlefeUnsupported { face: u32, what: String },
}
