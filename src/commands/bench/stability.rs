//! The hard cases: numbers that cancel, surfaces that collapse, cameras that stand in the way.

use super::{Effort, Findings, ResultArgs, progress_bar};
use crate::commands::args::FrameArgs;
use crate::commands::measure::{Subject, Timed, judge};
use crate::commands::{UsageError, output};
use crate::report::{Cell, Errors, Outcome, Row, Summary, Table};
use crate::stages::Frame;
use anyhow::Result;
use clap::Parser;
use std::panic::{AssertUnwindSafe, catch_unwind};

mod cases;

#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    /// Only the cases whose title or arguments hold one of these words
    #[arg(long, value_delimiter = ',', value_name = "WORD,...")]
    pub only: Vec<String>,
    /// Pixels the oracle checks a case, drawn at random; as many again near borders; 0 for none
    #[arg(long, value_name = "N", default_value_t = 5_000)]
    pub samples: usize,
    /// Seed of the random choice
    #[arg(long, value_name = "N", default_value_t = 0)]
    pub seed: u64,
    #[command(flatten)]
    pub results: ResultArgs,
    /// Options of `render` for every case, after `--`
    #[arg(last = true, value_name = "OPTION")]
    pub options: Vec<String>,
}

/// A case as the command line has it.
#[derive(Debug, Parser)]
#[command(no_binary_name = true)]
struct Line {
    #[command(flatten)]
    frame: FrameArgs,
}

/// What came of a case.
struct Finding {
    title: &'static str,
    arguments: &'static str,
    row: Option<Row>,
    /// Drawn pixels that hold a number that is not finite, and drawn pixels.
    not_finite: Option<[u64; 2]>,
    /// Why there is nothing to measure.
    note: String,
}

pub fn run(args: &Args) -> Result<()> {
    let asked = |title: &str, line: &str| {
        args.only.is_empty()
            || args.only.iter().any(|word| title.contains(word.as_str()) || line.contains(word.as_str()))
    };
    let cases: Vec<_> = cases::CASES.iter().filter(|(title, line)| asked(title, line)).collect();
    if cases.is_empty() {
        return Err(UsageError("--only leaves no case".into()).into());
    }
    let bar = progress_bar("hard cases");
    bar.set_length(cases.len() as u64);
    let mut found = Vec::new();
    for (title, arguments) in cases {
        found.push(examine(title, arguments, args)?);
        bar.inc(1);
    }
    bar.finish_and_clear();
    let table = table(&found);
    let findings = Findings {
        title: "Numerical stability on hard cases",
        about:
            "One frame a case, before the oracle. `halfpixel verify ARGUMENTS` repeats one. A refusal is a clear line \
                instead of a picture; pixels that are not finite must be 0."
                .into(),
        tables: vec![("Cases".into(), table)],
        rows: found.into_iter().filter_map(|f| f.row).collect(),
    };
    findings.publish(&args.results)
}

fn examine(title: &'static str, arguments: &'static str, args: &Args) -> Result<Finding> {
    let words = arguments.split_whitespace().chain(args.options.iter().map(String::as_str));
    let line = Line::try_parse_from(words).map_err(|e| UsageError(format!("{title}: {e}")))?;
    let mut finding = Finding { title, arguments, row: None, not_finite: None, note: String::new() };
    // A panic is a finding too, and must not hide the cases after it.
    match catch_unwind(AssertUnwindSafe(|| draw(&line.frame, args))) {
        Ok(Ok((row, not_finite))) => {
            finding.note = match &row.outcome {
                Outcome::Refused(reason) => format!("refused: {reason}"),
                Outcome::Measured(m) if m.counts.drawn == 0 => "nothing in sight".into(),
                Outcome::Measured(_) => String::new(),
            };
            finding.row = Some(row);
            finding.not_finite = not_finite;
        }
        Ok(Err(error)) => finding.note = format!("refused: {error:#}"),
        Err(_) => {
            output::warning_line(&format!("{title}: panicked"));
            finding.note = "PANIC".into();
        }
    }
    Ok(finding)
}

type Drawn = (Row, Option<[u64; 2]>);

fn draw(frame: &FrameArgs, args: &Args) -> Result<Drawn> {
    frame.backend.check()?;
    frame.model.install(|| {
        let effort = Effort { frames: 1, samples: args.samples, seed: args.seed };
        let (loaded, scene) = frame.model.load_scene()?;
        let mut subject = Subject::new(&loaded.name, &scene, effort, frame.backend.engine()?);
        let (view, options) = (frame.view_spec(), frame.options());
        let timed: Timed = match subject.time(&view, &options)? {
            Ok(timed) => timed,
            Err(refused) => {
                return Ok((subject.labelled(&view, &options, Outcome::Refused(refused.to_string())), None));
            }
        };
        let errors = judge(&scene, &timed.frame, effort);
        let outcome = Outcome::Measured(Box::new(timed.measured(errors)));
        Ok((subject.labelled(&view, &options, outcome), Some(not_finite(&timed.frame))))
    })
}

/// Drawn pixels that hold a number that is not finite, and drawn pixels.
fn not_finite(frame: &Frame) -> [u64; 2] {
    let [width, height] = frame.camera.size;
    let mut counts = [0, 0];
    for (x, y) in (0..height).flat_map(|y| (0..width).map(move |x| (x, y))) {
        let Some(pixel) = frame.pixel(x, y) else { continue };
        let parameters = pixel.interpolated.iter().chain(&pixel.stored).all(|p| p.is_finite());
        let color = frame.color(x, y).iter().all(|c| c.is_finite());
        counts[0] += u64::from(!(parameters && color && pixel.depth.is_finite()));
        counts[1] += 1;
    }
    counts
}

fn table(found: &[Finding]) -> Table {
    let mut table = Table::new(&[
        "case",
        "arguments",
        "drawn",
        "not finite",
        "quads",
        "MB",
        "ms",
        "grid max px",
        "param max px",
        "refined max px",
        "violations",
        "cracks",
        "covering",
        "depth",
        "note",
    ]);
    for finding in found {
        let measured = finding.row.as_ref().and_then(Row::measured);
        let errors = measured.and_then(|m| m.errors.as_ref());
        let max = |get: fn(&Errors) -> Option<Summary>| -> Cell { errors.and_then(get).map(|s| s.max).into() };
        let count = |get: fn(&Errors) -> u64| -> Cell { errors.map(get).into() };
        table.push(vec![
            finding.title.into(),
            format!("`{}`", finding.arguments).into(),
            finding.not_finite.map(|n| n[1]).into(),
            finding.not_finite.map(|n| n[0]).into(),
            measured.map(|m| m.counts.quads).into(),
            measured.map(|m| m.counts.buffer_bytes as f64 / 1e6).into(),
            measured.map(|m| m.total.median).into(),
            max(|e| e.grid),
            max(|e| e.parametric),
            max(|e| e.refined),
            count(|e| e.violations),
            count(|e| e.cracks),
            count(|e| e.covering_failures),
            count(|e| e.depth_failures),
            finding.note.as_str().into(),
        ]);
    }
    table
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_case_is_a_command_line() {
        for (title, arguments) in cases::CASES {
            let line = Line::try_parse_from(arguments.split_whitespace());
            assert!(line.is_ok(), "{title}: {}", line.unwrap_err());
        }
    }
}
