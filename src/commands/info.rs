//! `halfpixel info`: what is in a model.

use anyhow::{Result, bail};
use std::process::ExitCode;

/// Describe a model
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

pub fn run(_args: Args) -> Result<ExitCode> {
    bail!("info is not written yet");
}
