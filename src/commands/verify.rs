//! `halfpixel verify`: measures a frame against the exact surface.

use super::args::FrameArgs;
use anyhow::{Result, bail};
use std::{path::PathBuf, process::ExitCode};

/// Draw a frame and measure its error against the exact surface
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub frame: FrameArgs,
    /// Pixels to check, drawn at random; as many again near borders, and all that filling decided
    #[arg(long, value_name = "N", default_value_t = 20_000)]
    pub samples: usize,
    /// Seed of the random choice
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    /// Error image to write (PNG)
    #[arg(short, long, value_name = "FILE.png")]
    pub output: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

pub fn run(_args: Args) -> Result<ExitCode> {
    bail!("verify is not written yet");
}
