//! `--backend`: what draws the frame. What is asked for by name is used or refused with all reasons; only `auto` falls
//! back.

use crate::stages::Engine;
use crate::{cuda, emulated, vulkan};
use anyhow::bail;
use serde::Serialize;

#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, clap::ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Backend {
    /// The fastest that is there
    #[default]
    Auto,
    /// The reference, in Rust
    Cpu,
    /// An NVIDIA GPU
    Cuda,
    /// The GPU's kernels, run on the CPU: to test them; slow
    Emulated,
}

impl Backend {
    /// Refuses what can't be used here, before a model is read.
    pub fn check(self) -> anyhow::Result<()> {
        let (name, missing) = match self {
            Backend::Auto | Backend::Cpu => return Ok(()),
            Backend::Cuda => ("cuda", cuda_missing()),
            Backend::Emulated => ("emulated", emulated_missing()),
        };
        if missing.is_empty() { Ok(()) } else { bail!("--backend {name} can't be used: {}", missing.join("; ")) }
    }

    /// What draws frames. `auto` is the CPU as long as no GPU has been measured to be faster.
    pub fn engine(self) -> anyhow::Result<Engine> {
        self.check()?;
        Ok(match self {
            Backend::Auto | Backend::Cpu => Engine::Cpu,
            Backend::Cuda => Engine::Cuda(Box::new(cuda::Stream::new(0)?)),
            Backend::Emulated => {
                let threads = rayon::current_num_threads();
                Engine::Emulated(Box::new(emulated::Device::new(emulated::Schedule::default(), threads)))
            }
        })
    }
}

/// Why no frame is drawn with CUDA here.
pub fn cuda_missing() -> Vec<String> {
    cuda::missing().iter().map(ToString::to_string).collect()
}

/// The same for Vulkan's mesh shaders.
pub fn vulkan_missing() -> Vec<String> {
    vulkan::missing().iter().map(ToString::to_string).collect()
}

/// The same for kernels on the CPU.
pub fn emulated_missing() -> Vec<String> {
    emulated::missing().into_iter().map(String::from).collect()
}
