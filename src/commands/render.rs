//! `halfpixel render`: draws a model into an image file.

use anyhow::{Result, bail};
use std::process::ExitCode;

/// Draw a model
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

pub fn run(_args: Args) -> Result<ExitCode> {
    bail!("render is not written yet");
}
