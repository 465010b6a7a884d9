//! CUDA kernels on the CPU: the sources under `kernels/`, compiled by a C++ compiler against `kernels/host`, where each CUDA
//! thread is a fiber and each collective a rendezvous. For tests, and for frames where there is no GPU.
//!
//! [`Device`] is memory and launches; [`Schedule`] says who runs first, so that a test can try several orders. What is
//! emulated and what is not stands in `kernels/host/README.md`.
//!
//! ```
//! use halfpixel::emulated::{self, Device};
//!
//! if let Some(why) = emulated::missing() {
//!     println!("kernels can't run here: {why}");
//! }
//! let mut device = Device::default();
//! let numbers = device.upload(&[1.0_f32, 2.0]);
//! assert_eq!(device.download(&numbers)?, [1.0, 2.0]);
//! # Ok::<(), halfpixel::emulated::LaunchError>(())
//! ```

#[cfg(not(host_kernels))]
mod absent;
mod device;
mod error;
#[cfg(host_kernels)]
mod ffi;
mod memory;
mod recording;
mod schedule;

#[cfg(not(host_kernels))]
use absent as ffi;

pub use crate::cuda::{Argument, Buffer, Pod, Pointer, Shape};
pub use device::Device;
pub use error::{Fault, FaultKind, LaunchError};
pub use recording::Recording;
pub use schedule::{BlockOrder, LaneOrder, Schedule, TensorCores, WarpOrder};

/// Why this build can't run kernels on the CPU, if it can't.
pub fn missing() -> Option<&'static str> {
    option_env!("HALFPIXEL_NO_HOST_KERNELS")
}

/// Names of all kernels that can be launched, sorted.
pub fn kernels() -> Vec<String> {
    let mut names = ffi::kernels();
    names.sort();
    names
}
