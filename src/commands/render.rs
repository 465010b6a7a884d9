//! `halfpixel render`: draws a model into an image file.

use super::args::FrameArgs;
use super::image::{self, ImageFormat};
use super::output;
use super::source::{Loaded, prepare_model};
use super::used::Used;
use crate::stages::{Options, Renderer, StageTime, Stats};
use anyhow::{Context, Result};
use serde::Serialize;
use std::path::{Path, PathBuf};
use std::{process::ExitCode, time::Instant};

/// Draw a model into an image file
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub frame: FrameArgs,
    /// Image to write: .png, or .exr with depth, normals, positions, parameters and numbers
    #[arg(short, long, value_name = "FILE")]
    pub output: PathBuf,
    /// File for times and counts of every stage (JSON)
    #[arg(long, value_name = "FILE")]
    pub stats: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

/// The JSON object, on standard output and in `--stats`.
#[derive(Serialize)]
struct Report<'a> {
    #[serde(flatten)]
    source: Loaded,
    output: &'a Path,
    size: [u32; 2],
    #[serde(flatten)]
    used: Used,
    options: Options,
    #[serde(flatten)]
    stats: Stats,
    /// Faces that could not be converted, and what was mended or approximated: how many.
    lost_faces: usize,
    warnings: usize,
    /// From reading the model to the written image.
    seconds: f64,
}

pub fn run(args: Args) -> Result<ExitCode> {
    let format = ImageFormat::of(&args.output)?;
    for path in [Some(&args.output), args.stats.as_ref()].into_iter().flatten() {
        output::check_folder(path)?;
    }
    let report = args.frame.model.install(|| draw(&args, format))?;
    if let Some(path) = &args.stats {
        output::write_file(path, |file| Ok(serde_json::to_writer_pretty(file, &report)?))?;
    }
    if args.json {
        output::print_json(&report)?;
    }
    Ok(ExitCode::SUCCESS)
}

fn draw(args: &Args, format: ImageFormat) -> Result<Report<'_>> {
    let start = Instant::now();
    let mut source = args.frame.model.load()?;
    let imported = start.elapsed();
    let name = source.name.clone();
    // The scene holds all that is drawn: a model of millions of faces must not stay beside it.
    let model = std::mem::take(&mut source.model);
    let scene = prepare_model(&model).with_context(|| name.clone())?;
    let (lost_faces, warnings) = (model.lost.len(), model.warnings.len());
    drop(model);
    let prepared = start.elapsed();
    let (camera, options) = (args.frame.camera(&scene)?, args.frame.options());
    let mut renderer = Renderer::with(&scene, args.frame.backend.engine()?);
    let frame = renderer.render(&camera, &options).with_context(|| name)?;
    let coarse = frame.stats.trim.textures_too_coarse;
    if coarse > 0 {
        output::warning_line(&format!("{coarse} trim textures have too few texels for the tolerance: use --trim on"));
    }
    image::write_frame(&args.output, format, &scene, &frame)?;
    let ms = |d: std::time::Duration| d.as_secs_f64() * 1e3;
    let mut stats = frame.stats.clone();
    let before = [("import", imported), ("prepare", prepared - imported)];
    stats.stages.splice(0..0, before.map(|(stage, time)| StageTime { stage, ms: ms(time) }));
    Ok(Report {
        source,
        output: &args.output,
        size: camera.size,
        used: Used::by(&options, &renderer),
        options,
        stats,
        lost_faces,
        warnings,
        seconds: start.elapsed().as_secs_f64(),
    })
}
