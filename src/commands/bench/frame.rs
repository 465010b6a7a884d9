//! Whole frames: ETER's tables 4 and 6 and figures 8 and 9, with its own configuration beside ours in the same run.

use super::fit::{self, Fit};
use super::{Effort, Findings, ResultArgs, progress_bar, targets};
use crate::commands::args::FrameArgs;
use crate::commands::backend::Backend;
use crate::commands::measure::Subject;
use crate::commands::source::prepare_model;
use crate::model::repeated;
use crate::report::{Cell, Errors, Measured, Outcome, Row, Summary, Table, name};
use crate::scene::{Scene, ViewSpec};
use crate::stages::{Bound, Engine, FrameShape, Grid, Options, Precision, Trim};
use anyhow::{Context, Result};

#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub frame: FrameArgs,
    /// Copies of the model are put side by side until there are so many patches [default: 3700000 on a GPU, 20000 on the
    /// CPU, 2000 emulated]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u64).range(1..=1 << 32))]
    pub patches: Option<u64>,
    #[command(flatten)]
    pub effort: Effort,
    #[command(flatten)]
    pub results: ResultArgs,
}

/// ETER's largest scene: 35 cars of 105,939 patches.
const PATCHES: u64 = 3_700_000;
/// Stages as ETER's tables put them together.
const GROUPS: [(&str, &[&str]); 4] = [
    ("TFE ms", &["cull", "estimate"]),
    ("EVAL ms", &["evaluate"]),
    ("RAS_TRI ms", &["rasterize", "trim"]),
    ("CRK_SHD ms", &["fill", "shade"]),
];

/// Rows to show, and frames that the fit alone is made of.
#[derive(Default)]
struct Found {
    rows: Vec<Row>,
    fitted: Vec<Row>,
    /// All patches are bicubic polynomials without trims.
    plain: bool,
}

pub fn run(args: &Args) -> Result<()> {
    args.frame.model.install(|| {
        let mut loaded = args.frame.model.load()?;
        let engine = args.frame.backend.engine()?;
        let target = args.patches.unwrap_or(match engine {
            Engine::Cuda(_) => PATCHES,
            Engine::Cpu => 20_000,
            Engine::Emulated(_) => 2_000,
        });
        let bounds = loaded.model.bounds().context("there is nothing to draw")?;
        let first = loaded.model.instances.clone();
        let scene = prepare_model(&loaded.model)?;
        let patches = patches(&scene);
        let copies = steps(target.div_ceil(patches.max(1)));
        let bar = progress_bar("frames");
        bar.set_length(copies.len() as u64);
        let mut found = Found { plain: plain(&scene), ..Found::default() };
        found.measure(args, &loaded.name, &scene, 1, engine)?;
        drop(scene);
        for &copies in copies.iter().filter(|&&copies| copies > 1) {
            bar.inc(1);
            loaded.model.instances = repeated(&first, bounds, copies as usize);
            let scene = prepare_model(&loaded.model)?;
            found.measure(args, &loaded.name, &scene, copies, args.frame.backend.engine()?)?;
        }
        bar.finish_and_clear();
        found.findings(args, target).publish(&args.results)
    })
}

fn patches(scene: &Scene) -> u64 {
    scene.instances.iter().map(|i| i.patches.len() as u64).sum()
}

fn plain(scene: &Scene) -> bool {
    let untrimmed = scene.faces.iter().all(|face| face.loops.is_empty());
    untrimmed && scene.patches.iter().all(|patch| patch.degree == [3, 3] && !patch.rational)
}

/// One, a quarter of the last, half of it, the last.
fn steps(last: u64) -> Vec<u64> {
    let mut steps = vec![1, last / 4, last / 2, last];
    steps.retain(|&n| n > 0);
    steps.dedup();
    steps
}

/// Ours, the same in whatever precision is enough, in ETER's shape of a frame, and what ETER draws, on a device with its precision recovery: as asked for, and of
/// one model without trims too.
fn configurations(args: &Args, on_device: bool, copies: u64) -> Vec<Options> {
    let ours = args.frame.options();
    let staged = Options { frame: FrameShape::Staged, ..ours };
    let precision = if on_device { Precision::F16Recovered } else { ours.precision };
    let eter = Options { bound: Bound::Eter, grid: Grid::Eter, precision, ..staged };
    let auto = Options { precision: Precision::Auto, ..ours };
    let others = if on_device { vec![auto, staged, eter] } else { vec![eter] };
    let mut all = vec![ours];
    all.extend(others.into_iter().filter(|other| *other != ours));
    if copies == 1 {
        all.extend(all.clone().into_iter().map(|options| Options { trim: Trim::Off, ..options }));
    }
    all
}

impl Found {
    fn measure(&mut self, args: &Args, model: &str, scene: &Scene, copies: u64, engine: Engine) -> Result<()> {
        let view = args.frame.view_spec();
        let on_device = !matches!(engine, Engine::Cpu);
        let mut subject = Subject::new(&format!("{model} x{copies}"), scene, args.effort, engine);
        self.rows.extend(subject.rows(&view, &configurations(args, on_device, copies))?);
        // Other images of the same patches, with fewer pixels and with more triangles, tell the terms of the fit apart.
        let half = ViewSpec { size: view.size.map(|side| side.div_ceil(2)), ..view };
        for options in &configurations(args, on_device, 0) {
            let finer = Options { tolerance: options.tolerance / 4.0, ..*options };
            for (view, options) in [(half, *options), (view, finer)] {
                if let Ok(timed) = subject.time(&view, &options)? {
                    let outcome = Outcome::Measured(Box::new(timed.measured(None)));
                    self.fitted.push(subject.labelled(&view, &options, outcome));
                }
            }
        }
        Ok(())
    }

    fn findings(self, args: &Args, target: u64) -> Findings {
        let all = || self.rows.iter().chain(&self.fitted);
        let options = args.frame.options();
        // Frames without trims cost less a triangle.
        let mut labels: Vec<String> = self.rows.iter().filter(|r| r.setting.trim == options.trim).map(label).collect();
        labels.sort();
        labels.dedup();
        let fit = |wanted: String| {
            let same = all().filter(|row| label(row) == wanted);
            let frames: Vec<_> = same.filter_map(Row::measured).map(fit::sample).collect();
            (wanted, Fit::of(&frames))
        };
        let fits: Vec<(String, Option<Fit>)> = labels.into_iter().map(fit).collect();
        let verdicts = targets::frame(&self.rows, options.trim, self.plain);
        let (breakdown, against) = (breakdown(&self.rows), against(&self.rows, &options));
        let [width, height] = args.frame.size;
        Findings {
            title: "Frames (ETER, tables 4 and 6, figures 8 and 9)",
            about: about(args, target),
            tables: vec![
                ("What a GPU must reach".into(), targets::table(&verdicts)),
                (format!("Breakdown at {width}x{height}"), breakdown),
                ("Ours against ETER's bound, grid and shape of a frame in the same run".into(), against),
                ("Yeo's equation 11: ms = k + c0 patches + c1 triangles + c2 pixels".into(), fit::table(&fits)),
            ],
            rows: [self.rows, self.fitted].concat(),
        }
    }
}

fn about(args: &Args, target: u64) -> String {
    let times = match args.frame.backend {
        Backend::Cuda => "Times of stages are the device's own (CUDA events), those of frames are wall clock.",
        Backend::Emulated => {
            "Drawn by the GPU's kernels on the CPU, and smaller: TIMES ARE THE EMULATOR'S AND MEAN NOTHING."
        }
        _ => "Drawn by the CPU, and smaller than on a GPU.",
    };
    format!(
        "{}, copies in a grid until {target} patches (the papers' scale: {PATCHES}). TFE, EVAL, RAS_TRI and CRK_SHD are the \
         stages as ETER's tables join them; the rest of a frame is transfers and the host. Errors by the oracle on {} random \
         pixels a frame and as many near borders, all filled ones among them. The fit is over all frames of a configuration, \
         with more at half the image's size and at a quarter of the tolerance. {times}",
        args.frame.model.label(),
        args.effort.samples
    )
}

fn label(row: &Row) -> String {
    let shape = row.frame.map_or(String::new(), |shape| format!(", {}", name(shape)));
    let trim = if row.setting.trim == Trim::Off { ", no trims" } else { "" };
    let precision = row.frame.map_or(String::new(), |_| format!(", {}", name(row.setting.precision)));
    format!("{}, {}{shape}{precision}{trim}", name(row.setting.bound), name(row.setting.grid))
}

fn breakdown(rows: &[Row]) -> Table {
    let mut headings = vec!["model", "configuration", "ms", "min-max ms"];
    headings.extend(GROUPS.iter().map(|g| g.0));
    headings.extend([
        "RAS_TRI share",
        "visible patches",
        "Mtriangles",
        "grid max px",
        "refined max px",
        "broken",
        "note",
    ]);
    let mut table = Table::new(&headings);
    for row in rows {
        let (m, e) = (row.measured(), row.errors());
        let stages = |m: &Measured, stages: &[&str]| stages.iter().map(|s| m.stage(s)).sum::<f64>();
        let max = |get: fn(&Errors) -> Option<Summary>| -> Cell { e.and_then(get).map(|s| s.max).into() };
        let mut cells = vec![
            row.model.as_str().into(),
            label(row).into(),
            m.map(|m| m.total.median).into(),
            m.map(|m| format!("{:.3}-{:.3}", m.total.min, m.total.max)).into(),
        ];
        cells.extend(GROUPS.iter().map(|(_, group)| Cell::from(m.map(|m| stages(m, group)))));
        let share = |m: &Measured| format!("{:.0} %", 100.0 * stages(m, GROUPS[2].1) / m.total.median);
        cells.extend([
            m.map(share).into(),
            m.map(|m| m.counts.patches_visible).into(),
            m.map(|m| m.counts.triangles as f64 * 1e-6).into(),
            max(|e| e.grid),
            max(|e| e.refined),
            e.map(Errors::broken).into(),
            match &row.outcome {
                Outcome::Refused(reason) => format!("refused: {reason}"),
                Outcome::Measured(_) => String::new(),
            }
            .into(),
        ]);
        table.push(cells);
    }
    table
}

/// Ratios of what was measured by turns on the same scene.
fn against(rows: &[Row], ours: &Options) -> Table {
    let mut table = Table::new(&[
        "model",
        "configuration",
        "ms",
        "ETER's ms",
        "times faster",
        "triangles / ETER's",
        "refined max px",
        "ETER's",
    ]);
    let is_eter = |row: &Row| row.setting.bound == Bound::Eter && row.setting.grid == Grid::Eter;
    let is_ours = |row: &&Row| row.setting.bound == ours.bound && row.setting.grid == ours.grid;
    for row in rows.iter().filter(is_ours) {
        let pair = |other: &&Row| is_eter(other) && other.model == row.model && other.setting.trim == row.setting.trim;
        let Some(other) = rows.iter().find(pair) else { continue };
        let (Some(a), Some(b)) = (row.measured(), other.measured()) else { continue };
        let refined = |row: &Row| row.errors().and_then(|e| e.refined).map(|s| s.max);
        table.push(vec![
            row.model.as_str().into(),
            label(row).into(),
            a.total.median.into(),
            b.total.median.into(),
            (b.total.median / a.total.median).into(),
            (a.counts.triangles as f64 / b.counts.triangles as f64).into(),
            refined(row).into(),
            refined(other).into(),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    #[test]
    fn copies_grow_to_the_last() {
        assert_eq!(steps(321), [1, 80, 160, 321]);
        assert_eq!(steps(2), [1, 2]);
        assert_eq!(steps(1), [1]);
        let boxed = [DVec3::ZERO, DVec3::new(2.0, 1.0, 1.0)];
        assert_eq!(repeated(&[Default::default()], boxed, 5).len(), 5);
    }
}
