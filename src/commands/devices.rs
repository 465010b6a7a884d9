//! `halfpixel devices`: lists what frames can be drawn on.

use super::{output, used};
use anyhow::Result;
use serde::Serialize;
use std::{process::ExitCode, thread};

/// List what frames can be drawn on
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

#[derive(Serialize)]
struct Devices {
    devices: Vec<Device>,
    /// What this build can't draw on, and why.
    missing: Vec<Missing>,
}

#[derive(Serialize)]
struct Device {
    backend: &'static str,
    name: String,
    /// Hardware threads this process may use.
    threads: usize,
    simd: String,
}

#[derive(Serialize)]
struct Missing {
    backend: &'static str,
    reason: &'static str,
}

pub fn run(args: Args) -> Result<ExitCode> {
    let threads = thread::available_parallelism().map_or(1, Into::into);
    let cpu = Device { backend: "cpu", name: used::cpu_name(), threads, simd: used::simd_level() };
    let no_gpu = "no GPU backend is built into this version";
    let missing = ["cuda", "vulkan"].map(|backend| Missing { backend, reason: no_gpu });
    let devices = Devices { devices: vec![cpu], missing: missing.into() };
    if args.json {
        output::print_json(&devices)?;
        return Ok(ExitCode::SUCCESS);
    }
    for d in &devices.devices {
        output::print(&format!("{:<8}{} ({} threads, {})", d.backend, d.name, d.threads, d.simd))?;
    }
    for m in &devices.missing {
        output::print(&format!("{:<8}not available: {}", m.backend, m.reason))?;
    }
    Ok(ExitCode::SUCCESS)
}
