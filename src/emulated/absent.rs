//! What [`super::ffi`] is where no C++ compiler was found.

use super::LaunchError;
use super::memory::Memory;
use super::schedule::Schedule;
use crate::cuda::Shape;

pub(super) fn kernels() -> Vec<String> {
    Vec::new()
}

pub(super) fn launch(
    _kernel: &str,
    _shape: &Shape,
    _schedule: &Schedule,
    _threads: usize,
    _arguments: &[&[u8]],
    _memory: &mut Memory,
) -> Result<(), LaunchError> {
    Err(LaunchError::NotBuilt(super::missing().unwrap_or("it was built without kernels")))
}
