//! `halfpixel compare`: the same model with different bounds, tolerances, grids and views, side by side.

use super::args::FrameArgs;
use crate::scene::View;
use crate::stages::{Bound, Grid};
use anyhow::{Result, bail};
use std::{path::PathBuf, process::ExitCode};

/// Measure several bounds, tolerances, grids and views side by side
///
/// A list that is left out holds what the option of the same name says.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub frame: FrameArgs,
    /// Bounds to compare
    #[arg(long, value_enum, value_delimiter = ',', value_name = "BOUND,...")]
    pub bounds: Vec<Bound>,
    /// Tolerances to compare, in pixels
    #[arg(long, value_delimiter = ',', value_name = "PIXELS,...", value_parser = super::args::parse_tolerance)]
    pub tolerances: Vec<f64>,
    /// Grids to compare
    #[arg(long, value_enum, value_delimiter = ',', value_name = "GRID,...")]
    pub grids: Vec<Grid>,
    /// Views to compare
    #[arg(long, value_enum, value_delimiter = ',', value_name = "VIEW,...")]
    pub views: Vec<View>,
    /// Magnifications to compare
    #[arg(long, value_delimiter = ',', value_name = "FACTOR,...", value_parser = super::args::parse_zoom)]
    pub zooms: Vec<f64>,
    /// Where tables and plots go: DIR/PREFIX
    #[arg(short, long, value_name = "DIR/PREFIX")]
    pub output: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

pub fn run(_args: Args) -> Result<ExitCode> {
    bail!("compare is not written yet");
}
