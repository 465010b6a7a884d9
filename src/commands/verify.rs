//! `halfpixel verify`: measures a frame against the exact surface.

use super::args::FrameArgs;
use super::output;
use super::source::{Loaded, prepare_model, progress_bar};
use super::used::Used;
use crate::stages::{Interpolation, Renderer, Stats};
use crate::verify::{ErrorStats, Report, Sampling, verify};
use anyhow::{Context, Result};
use serde::Serialize;
use std::fmt::Write;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Draw a frame and measure its error against the exact surface
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub frame: FrameArgs,
    /// Check N random pixels, N more near borders, and all that filling decided with their neighbours [default: check
    /// every pixel]
    #[arg(long, value_name = "N")]
    pub samples: Option<usize>,
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

/// The JSON object.
#[derive(Serialize)]
struct Verification {
    #[serde(flatten)]
    source: Loaded,
    size: [u32; 2],
    #[serde(flatten)]
    used: Used,
    interpolation: Interpolation,
    tolerance: f64,
    refine: u32,
    #[serde(flatten)]
    report: Report,
    patches_visible: u64,
    quads: u64,
    triangles: u64,
}

pub fn run(args: Args) -> Result<ExitCode> {
    if let Some(path) = &args.output {
        output::check_folder(path)?;
    }
    let verification = args.frame.model.install(|| check(&args))?;
    if let Some(path) = &args.output {
        output::write_file(path, |file| Ok(verification.report.map.write_png(file)?))?;
    }
    if args.json {
        output::print_json(&verification)?;
    } else {
        output::print(table(&verification, args.output.as_deref()).trim_end())?;
    }
    Ok(if verification.report.passed() { ExitCode::SUCCESS } else { ExitCode::FAILURE })
}

fn check(args: &Args) -> Result<Verification> {
    let mut source = args.frame.model.load()?;
    let name = source.name.clone();
    let model = std::mem::take(&mut source.model);
    let scene = prepare_model(&model).with_context(|| name.clone())?;
    drop(model);
    let (camera, options) = (args.frame.camera(&scene)?, args.frame.options());
    let mut renderer = Renderer::with(&scene, args.frame.backend.engine()?);
    let frame = renderer.render(&camera, &options).with_context(|| name)?;
    let bar = progress_bar("checking");
    let sampling = Sampling { samples: args.samples, seed: args.seed };
    let report = verify(&scene, &camera, &options, &|x, y| frame.pixel(x, y), &sampling, &|done, all| {
        bar.set_length(all as u64);
        bar.set_position(done as u64);
    });
    bar.finish_and_clear();
    let Stats { patches_visible, quads, triangles, .. } = frame.stats;
    Ok(Verification {
        source,
        size: camera.size,
        used: Used::by(&options, &renderer),
        interpolation: options.bound.interpolation(),
        tolerance: options.tolerance,
        refine: options.refine,
        report,
        patches_visible,
        quads,
        triangles,
    })
}

/// Offenders that the table lists; the JSON object has more.
const LISTED: usize = 8;

fn table(v: &Verification, image: Option<&Path>) -> String {
    let r = &v.report;
    let stats = |e: &Option<ErrorStats>| match e {
        Some(e) => format!("max {:.4}, 99.9 % {:.4}, mean {:.4} px", e.max, e.p999, e.mean),
        None => "-".to_owned(),
    };
    let [width, height] = v.size;
    let mut rows = vec![
        ("model", v.source.name.clone()),
        ("checked", format!("{} of {width}x{height} pixels, {} drawn, in {:.2} s", r.pixels, r.drawn, r.seconds)),
        ("tessellation", format!("{} patches visible, {} quads", v.patches_visible, v.quads)),
        ("grid error", stats(&r.grid_error_px)),
        ("parametric error", stats(&r.parametric_error_px)),
        ("refined error", stats(&r.refined_error_px)),
        ("violations", r.violations.to_string()),
        ("cracks", r.cracks.to_string()),
        ("covering failures", r.covering_failures.to_string()),
        ("depth failures", r.depth_failures.to_string()),
        ("filled", r.filled.to_string()),
    ];
    if let Some(path) = image {
        rows.push(("error image", path.display().to_string()));
    }
    rows.push(("contract", if r.passed() { "kept" } else { "BROKEN" }.to_owned()));
    let mut text = String::new();
    for (what, value) in rows {
        // A `String` takes all that is written to it.
        let _ = writeln!(text, "{what:<18}{value}");
    }
    for o in r.worst.iter().take(LISTED) {
        let patch = o.patch.map_or("background".to_owned(), |p| format!("patch {p}"));
        let face =
            o.face.map_or(String::new(), |f| format!(" of #{f} in {}", o.name.as_deref().unwrap_or("the model")));
        let error = o.error_px.map_or(String::new(), |e| format!(", {e:.4} px"));
        let _ = writeln!(text, "  pixel ({}, {}): {}, {patch}{face}{error}", o.x, o.y, o.kind.name());
    }
    text
}
