//! `halfpixel compare`: the same model with different bounds, tolerances, grids and views, side by side.

use super::args::{FrameArgs, ProjectionKind};
use super::measure::{Effort, Subject};
use super::source::progress_bar;
use super::sweep::{Sweep, SweepArgs, Usual};
use super::{output, results};
use crate::report::{self, Machine, Point, Row};
use crate::scene::View;
use crate::stages::{Bound, Grid};
use anyhow::Result;
use serde_json::json;
use std::path::{Path, PathBuf};
use std::process::ExitCode;

/// Measure several bounds, tolerances, grids and views side by side
///
/// A list that is left out holds what the option of the same name says, else a usual choice: all bounds, both grids,
/// tolerances 0.5, 0.25 and 1, views iso and front, zooms 1 and 8.
#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub frame: FrameArgs,
    #[command(flatten)]
    pub sweep: SweepArgs,
    #[command(flatten)]
    pub effort: Effort,
    /// Where tables and plots go: DIR/PREFIX becomes PREFIX.md, .csv, .json, .svg and .png
    #[arg(short, long, value_name = "DIR/PREFIX")]
    pub output: Option<PathBuf>,
    /// Print one JSON object
    #[arg(long)]
    pub json: bool,
}

const USUAL: Usual = Usual {
    bounds: &Bound::ALL,
    grids: &[Grid::Adaptive, Grid::Eter],
    tolerances: &[0.5, 0.25, 1.0],
    views: &[View::Iso, View::Front],
    zooms: &[1.0, 8.0],
    projections: &[ProjectionKind::Perspective],
};

pub fn run(args: Args) -> Result<ExitCode> {
    let sweep = args.sweep.resolve(&args.frame, &USUAL)?;
    args.frame.model.install(|| {
        let (loaded, scene) = args.frame.model.load_scene()?;
        let mut subject = Subject::new(&loaded.name, &scene, args.effort, args.frame.backend.engine()?);
        let rows = measure(&mut subject, &sweep)?;
        if let Some(prefix) = &args.output {
            write(prefix, &rows)?;
        }
        say(&rows, args.json)
    })?;
    Ok(ExitCode::SUCCESS)
}

fn measure(subject: &mut Subject<'_>, sweep: &Sweep) -> Result<Vec<Row>> {
    let bar = progress_bar("measuring");
    bar.set_length(sweep.shots.len() as u64);
    let mut rows = Vec::new();
    for shot in &sweep.shots {
        rows.extend(subject.rows(shot, &sweep.options)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    Ok(rows)
}

fn write(prefix: &Path, rows: &[Row]) -> Result<()> {
    let points = report::points(rows);
    results::write(prefix, ".md", &markdown(rows))?;
    results::write(prefix, ".csv", &report::full(rows).csv())?;
    results::write(prefix, ".json", &(report::to_json(rows)? + "\n"))?;
    if points.is_empty() {
        output::warning_line("no configuration drew every view and was checked, so there is no plot");
        return Ok(());
    }
    report::plot_svg(&results::with_suffix(prefix, ".svg"), &title(rows), &points)?;
    report::plot_png(&results::with_suffix(prefix, ".png"), &title(rows), &points)?;
    Ok(())
}

fn say(rows: &[Row], json: bool) -> Result<()> {
    if !json {
        return output::print(report::summary(rows).markdown().trim_end());
    }
    let points = report::points(rows);
    let front: Vec<Point> = report::pareto(&points);
    output::print_json(&json!({ "rows": rows, "points": points, "front": front }))
}

fn title(rows: &[Row]) -> String {
    let Some(Row { model, shot, machine, .. }) = rows.first() else { return String::new() };
    let file = Path::new(model).file_name().map_or(model.clone(), |f| f.to_string_lossy().into_owned());
    format!("{file}, {}x{}, {} with {} threads", shot.size[0], shot.size[1], machine.device, machine.threads)
}

fn markdown(rows: &[Row]) -> String {
    let Machine { commit, date, .. } = rows.first().map(|r| r.machine.clone()).unwrap_or_default();
    format!(
        "# Speed against error: {}\n\nCommit {commit}, {date}. Time: mean over the views of the median frame. Error: the \
         largest over the views.\n\n{}\n## Every run\n\n{}",
        title(rows),
        report::summary(rows).markdown(),
        report::brief(rows).markdown()
    )
}
