//! `halfpixel devices`: lists what frames can be drawn on.

use anyhow::{Result, bail};
use std::process::ExitCode;

/// List what frames can be drawn on
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

pub fn run(_args: Args) -> Result<ExitCode> {
    bail!("devices is not written yet");
}
