//! `--backend`: what draws the frame. What is asked for by name is used or refused with all reasons; only `auto` falls
//! back.

use crate::cuda;
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
}

impl Backend {
    /// Refuses what can't be used here.
    pub fn check(self) -> anyhow::Result<()> {
        match self {
            Backend::Auto | Backend::Cpu => Ok(()),
            Backend::Cuda => bail!("--backend cuda can't be used: {}", cuda_missing().join("; ")),
        }
    }
}

/// Why no frame is drawn with CUDA here; never empty before its stages are there.
pub fn cuda_missing() -> Vec<String> {
    let missing: Vec<String> = cuda::missing().iter().map(ToString::to_string).collect();
    if missing.is_empty() {
        vec!["this version has kernels but no whole frame of them: use --backend cpu".into()]
    } else {
        missing
    }
}
