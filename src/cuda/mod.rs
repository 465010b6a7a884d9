//! The host side of the CUDA backend.
//!
//! | file | what it does |
//! |---|---|
//! | `abi.rs` | the structs of `kernels/abi.h`, made by bindgen |
//! | `bands.rs` | triangles of many pixels |
//! | `basis.rs` | Bernstein values of a frame's grids |
//! | `clocks.rs` | what evaluation costs by arithmetic and device; computed, made by tests/kernel_resources |
//! | `count.rs` | how long lists are, without waiting for the device |
//! | `counters.rs` | what kernels count, and the room that lists get by it |
//! | `cull.rs` | which patches can be seen |
//! | `device.rs` | which devices there are, and what is missing where there is none |
//! | `estimate.rs` | the leaves of all visible patches, with their grids |
//! | `evaluate.rs` | the vertices of all meshlets, by the kernels for their patches |
//! | `external.rs` | memory and semaphores of Vulkan on a CUDA device |
//! | `fill.rs` | the pixels that the spare buffer takes |
//! | `frame.rs` | the frame after estimate: its buffers and the order of its stages |
//! | `gpu.rs` | memory and launches: what a frame needs of a device |
//! | `graph.rs` | a frame's launches as one CUDA graph |
//! | `hardware.rs` | what mesh shaders draw of a frame |
//! | `leaves.rs` | what the stages that draw a patch know of it |
//! | `measured.rs` | what evaluation takes on a GPU as it was measured there |
//! | `meshlets.rs` | the list of meshlets |
//! | `module.rs` | the kernels that build.rs embedded, loaded on a device |
//! | `precision.rs` | the arithmetics of evaluation, and a bound of each one's error |
//! | `ranges.rs` | names of stages and groups of launches, for profilers |
//! | `rasterize.rs` | triangles and strokes |
//! | `recorded.rs` | a device that tests look at |
//! | `scan.rs` | prefix sums |
//! | `scene.rs` | a scene in a device's memory |
//! | `selection.rs` | which arithmetic a patch is evaluated in |
//! | `session.rs` | a frame's buffers and launches |
//! | `settle.rs` | the nearest surface under pixels that are not settled |
//! | `shared.rs` | memory that mesh shaders see too |
//! | `shade.rs` | the exact surface under every pixel |
//! | `stream.rs` | a GPU as a frame uses it |
//! | `surfaces.rs` | patches for the kernels that evaluate points with normals |
//! | `trim.rs` | the meshlets that trim curves cross |
//! | `trim_texture.rs` | the same by a texture for each leaf |
//! | `trims.rs` | trim trees in a device's memory |
//!
//! libcuda is opened when it is first asked for: the program starts where there is no driver.

// Generated: kernels/abi.h says what everything is.
#[allow(missing_docs, non_snake_case)]
#[rustfmt::skip]
pub mod abi;
mod bands;
mod basis;
#[rustfmt::skip]
mod clocks;
pub(crate) mod count;
mod counters;
pub(crate) mod cull;
// Calls of the driver are the library's only unsafe code.
#[allow(unsafe_code)]
mod device;
pub(crate) mod estimate;
pub mod evaluate;
// Imports are calls of the driver.
#[allow(unsafe_code)]
mod external;
mod fill;
pub(crate) mod frame;
mod gpu;
// Graphs are the driver's.
#[allow(unsafe_code)]
mod graph;
pub(crate) mod hardware;
pub(crate) mod leaves;
pub mod measured;
pub(crate) mod meshlets;
mod module;
pub mod precision;
mod ranges;
mod rasterize;
#[cfg(test)]
pub(crate) mod recorded;
mod scan;
pub mod scene;
pub mod selection;
pub(crate) mod session;
mod settle;
mod shade;
pub(crate) mod shared;
// Launches and copies are calls of the driver.
#[allow(unsafe_code)]
mod stream;
pub mod surfaces;
mod trim;
mod trim_texture;
pub mod trims;

pub use count::Count;
pub use device::{Device, Driver, devices, driver};
pub use gpu::{Argument, Buffer, Gpu, GpuError, Pod, Pointer, Shape};
pub(crate) use gpu::{bytes_of, pods};
pub use module::{Kernels, Toolkit, fatbin, targets, toolkit};
pub use stream::Stream;
pub use trims::TrimLists;

use cudarc::driver::DriverError;
use thiserror::Error;

/// Compute capability that the kernels need.
pub const OLDEST_DEVICE: [i32; 2] = [8, 0];

/// What keeps a frame from being drawn on a CUDA device, and how to mend it.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum CudaError {
    #[error("this program was built without CUDA kernels ({reason}): run scripts/install_nvcc.sh and build it again")]
    NoKernels { reason: String },
    #[error("there is no NVIDIA driver here (libcuda can't be loaded): install the driver of the GPU")]
    NoDriver,
    #[error("the NVIDIA driver finds no device: look at nvidia-smi, and at CUDA_VISIBLE_DEVICES")]
    NoDevice,
    #[error(
        "{name} has compute capability {}.{}; {}.{} or newer is needed",
        found[0], found[1], OLDEST_DEVICE[0], OLDEST_DEVICE[1]
    )]
    TooOld { name: String, found: [i32; 2] },
    #[error(
        "the NVIDIA driver knows CUDA {}.{}, the kernels were built with nvcc {nvcc}: update the driver, or build with an \
         nvcc of the driver's release",
        driver[0], driver[1]
    )]
    OldDriver { driver: [i32; 2], nvcc: String },
    #[error("there is no CUDA device {ordinal}; there are {count}")]
    NoSuchDevice { ordinal: usize, count: usize },
    #[error("the kernels hold no {name}")]
    NoSuchKernel { name: String },
    #[error("a buffer of {bytes} bytes is not one of this device, or was freed")]
    NoSuchBuffer { bytes: usize },
    #[error("kernel {kernel} could not be launched: {reason}")]
    Launch { kernel: String, reason: String },
    #[error("{what} failed: {reason}")]
    Driver { what: &'static str, reason: String },
}

impl CudaError {
    /// A failed call of the driver, with the driver's own words.
    fn of_driver(what: &'static str) -> impl Fn(DriverError) -> Self {
        move |error| Self::Driver { what, reason: reason(error) }
    }

    fn of_kernel(kernel: &str) -> impl Fn(DriverError) -> Self {
        move |error| Self::Launch { kernel: kernel.into(), reason: reason(error) }
    }
}

/// The driver's own words.
fn reason(error: DriverError) -> String {
    let text = error.error_string().map(|t| t.to_string_lossy().into_owned());
    let name = error.error_name().map(|t| t.to_string_lossy().into_owned());
    match (name, text) {
        (Ok(name), Ok(text)) => format!("{text} ({name})"),
        _ => format!("{:?}", error.0),
    }
}

/// Everything that keeps kernels from running here, all at once: nothing, if one device will do.
pub fn missing() -> Vec<CudaError> {
    let mut missing: Vec<CudaError> = fatbin().err().into_iter().collect();
    match devices() {
        Ok(devices) => {
            let unfit: Vec<CudaError> = devices.iter().filter_map(|d| d.check().err()).collect();
            if unfit.len() == devices.len() {
                missing.extend(unfit);
            }
        }
        Err(error) => missing.push(error),
    }
    missing
}
