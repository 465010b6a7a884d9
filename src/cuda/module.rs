//! The kernels that build.rs compiled and embedded, and how they come onto a device.

use super::{CudaError, devices};
use cudarc::driver::{CudaContext, CudaFunction, CudaModule};
use cudarc::nvrtc::Ptx;
use std::sync::Arc;

/// Bytes that begin at a multiple of 16, as the driver reads them.
#[repr(C, align(16))]
struct Aligned<T: ?Sized>(T);

/// The nvcc that compiled the kernels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Toolkit {
    /// As in 13.0.88.
    pub version: &'static str,
    /// Where its programs were.
    pub folder: &'static str,
    /// What it said of kernels that keep registers in local memory, a line a kernel and target.
    pub spills: &'static [&'static str],
}

include!(concat!(env!("OUT_DIR"), "/device_kernels.rs"));

impl Toolkit {
    /// The CUDA release it belongs to.
    pub fn major(&self) -> i32 {
        self.version.split('.').next().and_then(|n| n.parse().ok()).unwrap_or(0)
    }
}

/// Machine code of all kernels for all targets, and PTX for devices newer than these.
pub fn fatbin() -> Result<&'static [u8], CudaError> {
    match FATBIN {
        Some(fatbin) => Ok(&fatbin.0),
        None => Err(CudaError::NoKernels { reason: TOOLKIT.err().unwrap_or("build.rs made none").into() }),
    }
}

pub fn toolkit() -> Option<Toolkit> {
    TOOLKIT.ok()
}

/// Compute capabilities with machine code of their own: 80 is 8.0.
pub fn targets() -> &'static [u32] {
    TARGETS
}

/// The kernels on one device.
#[derive(Clone, Debug)]
pub struct Kernels {
    context: Arc<CudaContext>,
    module: Arc<CudaModule>,
}

impl Kernels {
    /// Loads them on the device with this number.
    pub fn load(ordinal: usize) -> Result<Self, CudaError> {
        let fatbin = fatbin()?;
        let devices = devices()?;
        let device = devices.get(ordinal).ok_or(CudaError::NoSuchDevice { ordinal, count: devices.len() })?;
        device.check()?;
        let context = CudaContext::new(ordinal).map_err(CudaError::of_driver("making a CUDA context"))?;
        let module = context.load_module(Ptx::from_binary(fatbin.to_vec()));
        let module = module.map_err(CudaError::of_driver("loading the CUDA kernels"))?;
        Ok(Self { context, module })
    }

    /// A kernel by the name it has in its .cu file.
    pub fn get(&self, name: &str) -> Result<CudaFunction, CudaError> {
        self.module.load_function(name).map_err(|_| CudaError::NoSuchKernel { name: name.into() })
    }

    pub fn context(&self) -> &Arc<CudaContext> {
        &self.context
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_fatbin_is_aligned_and_knows_its_toolkit() {
        match fatbin() {
            Ok(bytes) => {
                assert_eq!(bytes.as_ptr().addr() % 16, 0);
                // NVIDIA's mark of a fatbin.
                assert_eq!(bytes[..4], [0x50, 0xed, 0x55, 0xba]);
                assert!(toolkit().is_some_and(|t| t.major() >= 12));
            }
            Err(error) => {
                assert!(toolkit().is_none());
                assert!(error.to_string().contains("scripts/install_nvcc.sh"), "{error}");
            }
        }
    }
}
