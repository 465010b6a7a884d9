use std::fmt;
use thiserror::Error;

/// Why a launch failed.
#[derive(Clone, Debug, PartialEq, Eq, Error)]
pub enum LaunchError {
    #[error("kernels can't run on this CPU: {0}")]
    NotBuilt(&'static str),
    #[error("there is no kernel `{0}`; is KERNEL(name) written after it?")]
    UnknownKernel(String),
    #[error("kernel {kernel} has {expected} parameters, not {given}")]
    ArgumentCount { kernel: String, expected: usize, given: usize },
    #[error("parameter {index} of kernel {kernel} has {expected} bytes, not {given}")]
    ArgumentSize { kernel: String, index: usize, expected: usize, given: usize },
    #[error("parameter {index} of kernel {kernel} is a plain pointer, which can't be checked; make it a Buffer")]
    PlainPointer { kernel: String, index: usize },
    #[error("the buffer of {bytes} bytes is not one of this device, or was freed")]
    NoSuchBuffer { bytes: usize },
    #[error("{device} keeps shared memory where kernels on the CPU can't see it")]
    Unmapped { device: String },
    #[error("{given} elements do not fit a buffer of {length}")]
    Length { length: usize, given: usize },
    #[error("{0}")]
    Fault(Box<Fault>),
}

/// A mistake of a kernel: what it is and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Fault {
    pub kind: FaultKind,
    pub kernel: String,
    /// As it stands in the repository; empty where the launch itself was refused.
    pub file: String,
    pub line: u32,
    pub block: [u32; 3],
    pub thread: [u32; 3],
    pub message: String,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FaultKind {
    /// No thread of the block can run.
    Deadlock,
    /// Threads that should meet are at different collectives.
    Mismatch,
    /// A lane passes a mask that does not name it.
    NotInMask,
    /// A shuffle reads a lane that takes no part, has returned, or does not exist.
    SourceLane,
    /// A matrix product without all 32 lanes.
    IncompleteWarp,
    /// An index outside a buffer or shared memory.
    OutOfBounds,
    /// An address that a GPU would refuse for this type.
    Misaligned,
    /// More shared memory than there is.
    SharedMemory,
    /// Sizes that CUDA refuses.
    BadLaunch,
}

impl FaultKind {
    /// From `hp::FaultKind` in kernels/host/runtime.h.
    #[cfg(host_kernels)]
    pub(super) fn from_number(kind: i32) -> Self {
        match kind {
            1 => Self::Deadlock,
            2 => Self::Mismatch,
            3 => Self::NotInMask,
            4 => Self::SourceLane,
            5 => Self::IncompleteWarp,
            6 => Self::OutOfBounds,
            7 => Self::Misaligned,
            8 => Self::SharedMemory,
            _ => Self::BadLaunch,
        }
    }
}

impl fmt::Display for Fault {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        let Self { kernel, file, line, block, thread, message, .. } = self;
        if file.is_empty() {
            return write!(f, "kernel {kernel}: {message}");
        }
        let [[bx, by, bz], [tx, ty, tz]] = [*block, *thread];
        write!(f, "{file}:{line}: {message} (kernel {kernel}, block {bx},{by},{bz}, thread {tx},{ty},{tz})")
    }
}
