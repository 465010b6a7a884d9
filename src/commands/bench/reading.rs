//! How fast files are read: the text alone, then all the way to a model and a scene.

use super::{ResultArgs, output, progress_bar, results};
use crate::commands::source::{ModelArgs, prepare_model};
use crate::import;
use crate::report::{Machine, Spread, Table};
use anyhow::{Context, Result};
use rayon::prelude::*;
use serde_json::json;
use std::path::Path;
use std::time::Instant;

#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub model: ModelArgs,
    /// Times each file is read
    #[arg(long, value_name = "N", default_value_t = 5, value_parser = clap::value_parser!(u32).range(1..=10_000))]
    pub repeats: u32,
    /// Read only the text
    #[arg(long)]
    pub text_only: bool,
    #[command(flatten)]
    pub results: ResultArgs,
}

/// One file or a list of them: medians over the repeats, ms.
struct Reading {
    name: String,
    bytes: u64,
    entities: Option<u64>,
    text: Option<f64>,
    model: Option<f64>,
    scene: Option<f64>,
}

pub fn run(args: &Args) -> Result<()> {
    args.model.install(|| {
        let bar = progress_bar("reading");
        let readings: Vec<Reading> = (args.model.each())
            .map(|one| {
                let files = one.files()?;
                let name = Path::new(&one.label()).file_name().map_or(one.label(), |n| n.to_string_lossy().into());
                measure(name, &files, args).inspect(|_| bar.inc(1))
            })
            .collect::<Result<_>>()?;
        bar.finish_and_clear();
        publish(&table(&readings), &args.results)
    })
}

/// The files of a list are read in parallel, each dropped before the next: the memory is that of the largest.
fn measure(name: String, files: &[String], args: &Args) -> Result<Reading> {
    let timed = |work: &(dyn Fn(&String) -> Result<u64> + Sync)| -> Result<(f64, u64)> {
        let mut sum = 0;
        let mut times = Vec::new();
        for _ in 0..args.repeats {
            let start = Instant::now();
            // One file a task: their sizes differ by thousands.
            sum = files.par_iter().with_max_len(1).map(work).sum::<Result<u64>>()?;
            times.push(start.elapsed().as_secs_f64() * 1e3);
        }
        Ok((Spread::of(times).median, sum))
    };
    let bytes = |file: &String| std::fs::metadata(file).map(|m| m.len()).with_context(|| file.clone());
    let bytes = files.iter().map(bytes).sum::<Result<u64>>()?;
    // None where some file is of another format.
    let text = timed(&|file| import::count_entities(Path::new(file))?.context("no STEP file")).ok();
    let whole = |work: &(dyn Fn(&String) -> Result<u64> + Sync)| match args.text_only {
        true => Ok(None),
        false => timed(work).map(|(ms, _)| Some(ms)),
    };
    let model = whole(&|file| Ok(import::load(file).map(|_| 0)?))?;
    let scene = whole(&|file| prepare_model(&import::load(file)?).map(|_| 0))?;
    Ok(Reading { name, bytes, entities: text.map(|t| t.1), text: text.map(|t| t.0), model, scene })
}

fn table(readings: &[Reading]) -> Table {
    let mut table = Table::new(&[
        "file",
        "MB",
        "entities",
        "text ms",
        "text MB/s",
        "model ms",
        "model MB/s",
        "scene ms",
        "scene MB/s",
    ]);
    for r in readings {
        let megabytes = r.bytes as f64 / 1e6;
        let rate = |ms: f64| megabytes / (ms * 1e-3);
        table.push(vec![
            r.name.clone().into(),
            megabytes.into(),
            r.entities.into(),
            r.text.into(),
            r.text.map(rate).into(),
            r.model.into(),
            r.model.map(rate).into(),
            r.scene.into(),
            r.scene.map(rate).into(),
        ]);
    }
    table
}

fn publish(table: &Table, args: &ResultArgs) -> Result<()> {
    let machine = Machine::here(rayon::current_num_threads());
    let Machine { device, threads, commit, date } = &machine;
    let text = format!(
        "# Reading files\n\nFrom the file on: its text alone (every entity found and numbered), all the way to a model, \
         all the way to a prepared scene; medians.\n\nMeasured on {device} with {threads} threads, commit {commit}, \
         {date}.\n\n{}",
        table.markdown()
    );
    let json = json!({ "suite": "reading", "machine": machine, "rows": table.json() });
    if let Some(prefix) = &args.output {
        results::write(prefix, ".md", &text)?;
        results::write(prefix, ".csv", &table.csv())?;
        results::write(prefix, ".json", &(serde_json::to_string_pretty(&json)? + "\n"))?;
    }
    if args.json { output::print_json(&json) } else { output::print(text.trim_end()) }
}
