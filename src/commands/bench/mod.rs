//! `halfpixel bench`: the suites behind every committed figure; bench/README.md holds what they found.

mod backends;
mod contract;
mod evaluate;
mod fit;
mod floor;
mod frame;
mod kernels;
mod matrix;
mod pairs;
mod precision;
mod quads;
mod raster;
mod reading;
mod sheet;
mod speed;
mod stability;
mod targets;
mod tessellation;

use super::args::FrameArgs;
use super::measure::Effort;
use super::source::{ModelArgs, progress_bar};
use super::sweep::SweepArgs;
use super::{output, results};
use crate::report::{self, Row, Table};
use anyhow::Result;
use serde_json::{Value, json};
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Run a suite of measurements
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(subcommand)]
    pub suite: Suite,
}

#[derive(Clone, Debug, clap::Subcommand)]
pub enum Suite {
    /// Frames of a backend against the CPU's, pixel by pixel
    Backends(backends::Args),
    /// Every view before the oracle: is the accuracy contract kept?
    ///
    /// By default 7 views x zooms 1, 8, 64 x both projections x all bounds.
    Contract(contract::Args),
    /// The kernels that evaluate patches, each one's time beside its error: ETER's table 1
    Evaluate(evaluate::Args),
    /// Whole frames of a model and of many copies of it, with ETER's configuration beside: its tables 4 and 6
    Frame(frame::Args),
    /// Models x bounds x precisions x frames: does a backend keep what the CPU keeps?
    Matrix(matrix::Args),
    /// Error against time of every arithmetic over the hard cases
    Precision(precision::Args),
    /// Quads and triangles of every bound against ETER's
    Quads(SuiteArgs),
    /// Software, hybrid and hardware rasterising of the same frames: ETER's figure 8, and what hybrid leaves to hardware
    Raster(raster::Args),
    /// How fast files are read: their text, their models, their scenes
    Reading(reading::Args),
    /// Stage times, their floors, and the geometry's against ETER's in the same run
    Speed(speed::Args),
    /// The hard cases: what the frame makes of each, what is refused and why
    Stability(stability::Args),
    /// Patches evaluated by the hardware's tessellation pipeline, and mesh shaders beside: ETER's table 3
    Tessellation(tessellation::Args),
}

impl Suite {
    /// What its frames are to be, where the command line says so.
    pub(super) fn frame(&self) -> Option<&FrameArgs> {
        match self {
            Suite::Backends(args) => Some(&args.frame),
            Suite::Contract(args) => Some(&args.suite.frame),
            Suite::Frame(args) => Some(&args.frame),
            Suite::Matrix(args) => Some(&args.frame),
            Suite::Quads(args) => Some(&args.frame),
            Suite::Raster(args) => Some(&args.frame),
            Suite::Speed(args) => Some(&args.frame),
            Suite::Evaluate(_)
            | Suite::Precision(_)
            | Suite::Reading(_)
            | Suite::Stability(_)
            | Suite::Tessellation(_) => None,
        }
    }
}

/// What suites over models have in common.
#[derive(Clone, Debug, clap::Args)]
pub struct SuiteArgs {
    #[command(flatten)]
    pub frame: FrameArgs,
    #[command(flatten)]
    pub sweep: SweepArgs,
    #[command(flatten)]
    pub results: ResultArgs,
}

/// Where results go.
#[derive(Clone, Debug, clap::Args)]
pub struct ResultArgs {
    /// Where results go: PREFIX.md, PREFIX.csv, PREFIX.json
    #[arg(short, long, value_name = "DIR/PREFIX")]
    pub output: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// What a suite found.
struct Findings {
    title: &'static str,
    /// What a reader must know to read the tables.
    about: String,
    /// Heading and table.
    tables: Vec<(String, Table)>,
    rows: Vec<Row>,
}

pub fn run(args: Args) -> Result<ExitCode> {
    match args.suite {
        Suite::Backends(args) => return backends::run(&args),
        Suite::Contract(args) => contract::run(&args)?,
        Suite::Evaluate(args) => evaluate::run(&args)?,
        Suite::Frame(args) => frame::run(&args)?,
        Suite::Matrix(args) => return matrix::run(&args),
        Suite::Precision(args) => precision::run(&args)?,
        Suite::Quads(args) => quads::run(&args)?,
        Suite::Raster(args) => raster::run(&args)?,
        Suite::Reading(args) => reading::run(&args)?,
        Suite::Speed(args) => speed::run(&args)?,
        Suite::Stability(args) => stability::run(&args)?,
        Suite::Tessellation(args) => tessellation::run(&args)?,
    }
    Ok(ExitCode::SUCCESS)
}

impl SuiteArgs {
    /// All models asked for, each with the other arguments.
    fn models(&self) -> impl Iterator<Item = ModelArgs> {
        self.frame.model.each()
    }
}

impl Findings {
    /// Prints the findings and writes them where that was asked for.
    fn publish(&self, args: &ResultArgs) -> Result<()> {
        if let Some(prefix) = &args.output {
            results::write(prefix, ".md", &self.markdown())?;
            results::write(prefix, ".csv", &report::full(&self.rows).csv())?;
            self.write_json(prefix)?;
        }
        if args.json {
            return output::print_json(&self.json());
        }
        output::print(self.markdown().trim_end())
    }

    fn write_json(&self, prefix: &Path) -> Result<()> {
        results::write(prefix, ".json", &(serde_json::to_string_pretty(&self.json())? + "\n"))
    }

    fn json(&self) -> Value {
        let tables: Value = self.tables.iter().map(|(heading, table)| (heading.clone(), table.json())).collect();
        json!({ "suite": self.title, "about": self.about, "tables": tables, "rows": self.rows })
    }

    fn markdown(&self) -> String {
        let mut text = format!("# {}\n\n{}\n", self.title, self.about);
        if let Some(Row { backend, machine, .. }) = self.rows.first() {
            text += "\n";
            text += &sheet::measured_with(backend, machine);
        }
        for (heading, table) in self.tables.iter().filter(|(_, table)| !table.is_empty()) {
            text += &format!("\n## {heading}\n\n{}", table.markdown());
        }
        text
    }
}
