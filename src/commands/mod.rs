//! The command line, one file a subcommand: `Args` says what can be asked, `run` does it.
//!
//! Exit status 0: done, 1: it failed (or `verify` found the contract broken), 2: wrong usage. An error is one line on
//! standard error. With `--json`, standard output is one JSON object and nothing else.

pub mod args;
pub mod attributes;
pub mod backend;
pub mod bench;
pub mod compare;
pub mod devices;
pub mod image;
pub mod info;
pub mod measure;
pub mod output;
pub mod render;
pub mod results;
pub mod source;
pub mod sweep;
pub mod used;
pub mod verify;

use clap::{CommandFactory, FromArgMatches, Parser, Subcommand, error::ErrorKind};
use std::{ffi::OsString, process::ExitCode};

/// Pixel-accurate pictures of NURBS models, with the error measured.
#[derive(Debug, Parser)]
#[command(name = "halfpixel", version, disable_help_subcommand = true, arg_required_else_help = false)]
pub struct Cli {
    #[command(subcommand)]
    pub command: Command,
}

#[derive(Debug, Subcommand)]
pub enum Command {
    Render(render::Args),
    Verify(verify::Args),
    Info(info::Args),
    Compare(compare::Args),
    Bench(bench::Args),
    Devices(devices::Args),
}

impl Command {
    /// What its frames are to be, where it draws any.
    fn frame(&self) -> Option<&args::FrameArgs> {
        match self {
            Command::Render(args) => Some(&args.frame),
            Command::Verify(args) => Some(&args.frame),
            Command::Compare(args) => Some(&args.frame),
            Command::Bench(args) => args.suite.frame(),
            Command::Info(_) | Command::Devices(_) => None,
        }
    }
}

/// Wrong usage that the parser alone can't see; the program ends with status 2.
#[derive(Debug, thiserror::Error)]
#[error("{0}")]
pub struct UsageError(pub String);

/// The whole program, from its arguments (the first is its name) to its exit status.
pub fn main(arguments: impl IntoIterator<Item = OsString>) -> ExitCode {
    let cli = match Cli::command().try_get_matches_from(arguments).and_then(|m| Cli::from_arg_matches(&m)) {
        Ok(cli) => cli,
        Err(error) => return parse_error(&error),
    };
    match run(cli.command) {
        Ok(code) => code,
        Err(error) => {
            // The chain of causes on one line, whatever line breaks they hold.
            output::error_line(&format!("{error:#}"));
            ExitCode::from(if error.is::<UsageError>() { 2 } else { 1 })
        }
    }
}

fn run(command: Command) -> anyhow::Result<ExitCode> {
    if let Some(frame) = command.frame() {
        frame.backend.check()?;
        frame.check_kernels()?;
        frame.check_raster()?;
    }
    match command {
        Command::Render(args) => render::run(args),
        Command::Verify(args) => verify::run(args),
        Command::Info(args) => info::run(args),
        Command::Compare(args) => compare::run(args),
        Command::Bench(args) => bench::run(args),
        Command::Devices(args) => devices::run(args),
    }
}

/// Help and version go to standard output; anything else becomes one line.
fn parse_error(error: &clap::Error) -> ExitCode {
    if matches!(error.kind(), ErrorKind::DisplayHelp | ErrorKind::DisplayVersion) {
        // A closed pipe is the reader's choice.
        let _ = error.print();
        return ExitCode::SUCCESS;
    }
    let text = error.render().to_string();
    let lines = text.lines().map(str::trim).take_while(|l| !l.starts_with("Usage:") && !l.starts_with("For more"));
    let line = lines.filter(|l| !l.is_empty()).collect::<Vec<_>>().join(" ");
    let line = line.strip_prefix("error: ").unwrap_or(&line);
    output::error_line(&format!("{line}: see --help"));
    ExitCode::from(2)
}
