//! How long a frame takes: stage times beside their floors, and the geometry's against ETER's.

use super::{Effort, Findings, ResultArgs, floor, progress_bar};
use crate::commands::args::FrameArgs;
use crate::commands::measure::{Run, Subject};
use crate::report::{Counts, Measured, Outcome, Row, Spread, Table, name, peak_memory, stage_spreads};
use crate::scene::Scene;
use crate::stages::{Bound, Grid, Options, Renderer};
use anyhow::{Context, Result};
use std::time::Instant;

#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub frame: FrameArgs,
    /// Timed frames of each configuration, after one that warms up
    #[arg(long, value_name = "N", default_value_t = 15, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub frames: u32,
    #[command(flatten)]
    pub results: ResultArgs,
}

/// From the choice of grids to the visibility buffer.
const GEOMETRY: [&str; 4] = ["estimate", "evaluate", "rasterize", "fill"];

pub fn run(args: &Args) -> Result<()> {
    args.frame.model.install(|| {
        let start = Instant::now();
        let loaded = args.frame.model.load()?;
        let load = start.elapsed();
        let start = Instant::now();
        let scene = crate::commands::source::prepare_model(&loaded.model)?;
        let prepare = start.elapsed();
        let ours = args.frame.options();
        let eter = Options { bound: Bound::Eter, grid: Grid::Eter, ..ours };
        // One frame alone: ETER's buffers and the bandwidth probe's are not part of what a frame needs.
        let engine = args.frame.backend.engine()?;
        Renderer::with(&scene, engine).render(&args.frame.camera(&scene)?, &ours)?;
        let memory = peak_memory();
        let (a, b) = alternate(args, &scene, &ours, &eter)?;
        let effort = Effort { frames: args.frames, samples: 0, seed: 0 };
        let subject = Subject::new(&loaded.name, &scene, effort, args.frame.backend.engine()?);
        let row = |options, m: &Measured| {
            subject.labelled(&args.frame.view_spec(), options, Outcome::Measured(Box::new(m.clone())))
        };
        let rows = vec![row(&ours, &a), row(&eter, &b)];
        let peak = floor::Peak::measure();
        let pixels = args.frame.size.iter().map(|&s| f64::from(s)).product();
        let work = floor::work(&scene, pixels, &a.counts, ours.refine);
        let facts = facts(&[load.as_secs_f64(), prepare.as_secs_f64()], memory, &peak, &rows);
        let findings = Findings {
            title: "Speed",
            about: about(&args.frame),
            tables: vec![
                ("Facts".into(), facts),
                (label("Stages", &ours), floor::table(&a, &work, &peak)),
                (label("Stages", &eter), floor::table(&b, &floor::work(&scene, pixels, &b.counts, ours.refine), &peak)),
                ("Against ETER's bound and grid, same run, same code".into(), against(&a, &b)),
            ],
            rows,
        };
        findings.publish(&args.results)
    })
}

/// Frames of both by turns, so that what else the machine does meets both alike.
fn alternate(args: &Args, scene: &Scene, ours: &Options, eter: &Options) -> Result<(Measured, Measured)> {
    let camera = args.frame.camera(scene)?;
    // Each keeps its own buffers, as it would alone.
    let engine = || args.frame.backend.engine();
    let mut sides = [(engine()?, ours), (engine()?, eter)]
        .map(|(engine, options)| (Renderer::with(scene, engine), options, Run::default()));
    let bar = progress_bar("timing");
    bar.set_length(u64::from(args.frames) + 1);
    for turn in 0..=args.frames {
        for (renderer, options, run) in &mut sides {
            run.draw(renderer, &camera, options, turn == 0);
        }
        bar.inc(1);
    }
    bar.finish_and_clear();
    let [a, b] = sides.map(|(_, _, run)| run);
    Ok((measured(a)?, measured(b)?))
}

fn measured(run: Run) -> Result<Measured> {
    if let Some(refused) = run.refused {
        return Err(refused.into());
    }
    let last = run.stats.last().context("no frame was timed")?;
    Ok(Measured {
        frames: run.total.len(),
        total: Spread::of(run.total.clone()),
        stages: stage_spreads(&run.stats),
        counts: Counts::from(last),
        errors: None,
    })
}

fn about(frame: &FrameArgs) -> String {
    format!(
        "{}, {}x{}, view {}, zoom {}. Times in milliseconds: median, least and largest. A floor is the longer of bytes \
         that must move at the measured copy bandwidth, and arithmetic at two 8-wide multiply-adds a cycle and core at \
         3 GHz; src/commands/bench/floor.rs says what is counted.",
        frame.model.label(),
        frame.size[0],
        frame.size[1],
        name(frame.view),
        frame.zoom
    )
}

fn label(what: &str, options: &Options) -> String {
    format!("{what}: --bound {} --grid {}", name(options.bound), name(options.grid))
}

fn facts(seconds: &[f64; 2], memory: Option<u64>, peak: &floor::Peak, rows: &[Row]) -> Table {
    let mut table = Table::new(&["what", "value", "unit"]);
    let mut fact =
        |what: &str, value: Option<f64>, unit: &str| table.push(vec![what.into(), value.into(), unit.into()]);
    fact("read the model", Some(seconds[0] * 1e3), "ms");
    fact("prepare", Some(seconds[1] * 1e3), "ms");
    for row in rows {
        let label =
            label("whole frame", &Options { bound: row.setting.bound, grid: row.setting.grid, ..Options::default() });
        let total = row.measured().map_or(Spread::default(), |m| m.total);
        fact(&format!("{label}, median"), Some(total.median), "ms");
        fact(&format!("{label}, least"), Some(total.min), "ms");
        fact(&format!("{label}, largest"), Some(total.max), "ms");
        fact(&format!("{label}, frame buffers"), row.measured().map(|m| m.counts.buffer_bytes as f64 / 1e6), "MB");
    }
    fact("peak memory: model, scene, one frame", memory.map(|bytes| bytes as f64 / 1e6), "MB");
    fact("copy bandwidth, all threads", Some(peak.bandwidth / 1e9), "GB/s");
    fact("arithmetic peak assumed", Some(peak.arithmetic / 1e9), "Gflop/s");
    table
}

/// Ratios of medians, ETER's over ours.
fn against(ours: &Measured, eter: &Measured) -> Table {
    let mut table = Table::new(&["what", "ms", "ETER's ms", "times faster"]);
    let mut line = |what: &str, a: f64, b: f64| {
        table.push(vec![what.into(), a.into(), b.into(), (a > 0.0).then(|| b / a).into()]);
    };
    for stage in &ours.stages {
        line(&stage.stage, stage.ms.median, eter.stage(&stage.stage));
    }
    let geometry = |m: &Measured| GEOMETRY.iter().map(|s| m.stage(s)).sum::<f64>();
    line("geometry (estimate to fill)", geometry(ours), geometry(eter));
    line("whole frame", ours.total.median, eter.total.median);
    table
}
