//! `--backend`: what draws the frame. What is asked for by name is used or refused with all reasons; only `auto` falls
//! back.

use crate::{cuda, emulated};
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
    /// The GPU's kernels, run on the CPU: to test them
    Emulated,
}

impl Backend {
    /// Refuses what can't be used here.
    pub fn check(self) -> anyhow::Result<()> {
        match self {
            Backend::Auto | Backend::Cpu => Ok(()),
            Backend::Cuda => bail!("--backend cuda can't be used: {}", cuda_missing().join("; ")),
            Backend::Emulated => bail!("--backend emulated can't be used: {}", emulated_missing().join("; ")),
        }
    }
}

/// Why no frame is drawn with CUDA here; never empty before its stages are there.
pub fn cuda_missing() -> Vec<String> {
    or_unfinished(cuda::missing().iter().map(ToString::to_string).collect())
}

/// The same for kernels on the CPU.
pub fn emulated_missing() -> Vec<String> {
    or_unfinished(emulated::missing().into_iter().map(String::from).collect())
}

fn or_unfinished(missing: Vec<String>) -> Vec<String> {
    let unfinished = "this version has kernels but no whole frame of them: use --backend cpu";
    if missing.is_empty() { vec![unfinished.into()] } else { missing }
}
