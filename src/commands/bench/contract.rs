//! Is the accuracy contract kept? Every model, view, zoom, projection and bound before the oracle.

use super::{Effort, Findings, SuiteArgs, progress_bar, report, results};
use crate::commands::args::ProjectionKind;
use crate::commands::measure::{Subject, shot};
use crate::commands::sweep::Usual;
use crate::report::{Cell, Errors, Machine, Outcome, Row, Setting, Summary, Table, name};
use crate::scene::View;
use crate::stages::{Bound, Grid};
use anyhow::{Context, Result};

#[derive(Clone, Debug, clap::Args)]
pub struct Args {
    #[command(flatten)]
    pub suite: SuiteArgs,
    #[command(flatten)]
    pub effort: Effort,
    /// Keep the rows that PREFIX.json holds from the same commit, and measure only what it lacks
    #[arg(long, requires = "output")]
    pub resume: bool,
}

const USUAL: Usual = Usual {
    bounds: &Bound::ALL,
    grids: &[Grid::Adaptive],
    tolerances: &[0.5],
    views: &View::ALL,
    zooms: &[1.0, 8.0, 64.0],
    projections: &[ProjectionKind::Perspective, ProjectionKind::Orthographic],
};

pub fn run(args: &Args) -> Result<()> {
    args.suite.frame.model.install(|| {
        let mut rows = if args.resume { earlier(args)? } else { Vec::new() };
        for model in args.suite.models() {
            let (loaded, scene) = model.load_scene()?;
            let subject = Subject::new(&loaded.name, &scene, args.effort, args.suite.frame.backend.engine()?);
            measure(args, subject, &mut rows)?;
        }
        findings(rows).publish(&args.suite.results)
    })
}

/// What resuming needs of a results file.
#[derive(serde::Deserialize)]
struct Saved {
    rows: Vec<Row>,
}

/// Rows of the same commit; those of another one are measured anew.
fn earlier(args: &Args) -> Result<Vec<Row>> {
    let Some(prefix) = &args.suite.results.output else { return Ok(Vec::new()) };
    let path = results::with_suffix(prefix, ".json");
    if !path.exists() {
        return Ok(Vec::new());
    }
    let text = std::fs::read_to_string(&path).with_context(|| format!("cannot read {}", path.display()))?;
    let saved: Saved =
        serde_json::from_str(&text).with_context(|| format!("{}: start without --resume", path.display()))?;
    let mut rows = saved.rows;
    let commit = Machine::here(0).commit;
    rows.retain(|row| row.machine.commit == commit);
    Ok(rows)
}

fn measure(args: &Args, mut subject: Subject<'_>, rows: &mut Vec<Row>) -> Result<()> {
    let sweep = args.suite.sweep.resolve(&args.suite.frame, &USUAL)?;
    let bar = progress_bar("verifying");
    bar.set_length(sweep.len() as u64);
    for view in &sweep.shots {
        for options in &sweep.options {
            let key = (shot(view), Setting::from(options));
            if !rows.iter().any(|r| r.model == subject.model && r.shot == key.0 && r.setting == key.1) {
                rows.push(subject.row(view, options)?);
            }
            bar.inc(1);
        }
        if let Some(prefix) = &args.suite.results.output {
            // A long run that may be cut off: keep what there is.
            findings(rows.clone()).write_json(prefix)?;
        }
    }
    bar.finish_and_clear();
    Ok(())
}

fn findings(rows: Vec<Row>) -> Findings {
    let broken: Vec<Row> = rows.iter().filter(|r| r.errors().is_some_and(|e| e.broken() > 0)).cloned().collect();
    Findings {
        title: "The accuracy contract",
        about: "Sums over all shots of a model; errors are the largest of all shots, in pixels. Rates are over the checked \
                pixels: half of them are drawn near borders and all filled ones are among them, where failures are, so \
                the rate over a picture is lower. What a bound refuses is not counted as kept."
            .into(),
        tables: vec![
            ("By model and bound".into(), summary(&rows)),
            ("Shots that break the contract".into(), report::brief(&broken)),
        ],
        rows,
    }
}

/// One line a model and bound (grid and tolerance too, where they vary).
fn summary(rows: &[Row]) -> Table {
    let mut table = Table::new(&[
        "model",
        "bound",
        "grid",
        "t px",
        "shots",
        "refused",
        "checked",
        "violations",
        "violations per 1e5",
        "cracks",
        "covering",
        "covering per 1e5",
        "depth",
        "depth per 1e5",
        "grid max px",
        "param max px",
        "refined max px",
        "note",
    ]);
    let key = |r: &Row| (r.model.clone(), name(r.setting.bound), name(r.setting.grid), r.setting.tolerance.to_bits());
    let mut keys = Vec::new();
    for row in rows {
        if !keys.contains(&key(row)) {
            keys.push(key(row));
        }
    }
    for k in keys {
        table.push(summary_line(&rows.iter().filter(|r| key(r) == k).collect::<Vec<_>>()));
    }
    table
}

fn summary_line(rows: &[&Row]) -> Vec<Cell> {
    let Setting { bound, grid, tolerance, .. } = rows[0].setting;
    let errors: Vec<&Errors> = rows.iter().filter_map(|r| r.errors()).collect();
    let sum = |get: fn(&Errors) -> u64| (!errors.is_empty()).then(|| errors.iter().map(|e| get(e)).sum::<u64>());
    let checked = sum(|e| e.checked);
    let rate = |n: Option<u64>| Some(n? as f64 * 1e5 / checked.filter(|&c| c > 0)? as f64);
    let worst =
        |get: fn(&Errors) -> Option<Summary>| errors.iter().filter_map(|e| get(e)).map(|s| s.max).reduce(f64::max);
    let violations = sum(|e| e.violations);
    let (covering, depth) = (sum(|e| e.covering_failures), sum(|e| e.depth_failures));
    let reasons: Vec<&str> = rows
        .iter()
        .filter_map(|r| match &r.outcome {
            Outcome::Refused(reason) => Some(reason.as_str()),
            Outcome::Measured(_) => None,
        })
        .collect();
    vec![
        rows[0].model.as_str().into(),
        name(bound).into(),
        name(grid).into(),
        tolerance.into(),
        rows.len().into(),
        reasons.len().into(),
        checked.into(),
        violations.into(),
        rate(violations).into(),
        sum(|e| e.cracks).into(),
        covering.into(),
        rate(covering).into(),
        depth.into(),
        rate(depth).into(),
        worst(|e| e.grid).into(),
        worst(|e| e.parametric).into(),
        worst(|e| e.refined).into(),
        reasons.first().map_or(String::new(), |r| format!("refused: {r}")).into(),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::testing::{refused, row};

    #[test]
    fn failures_are_summed_and_errors_are_the_worst() {
        let mut rows = vec![
            row(Bound::Screen, Grid::Variable, 0.5, 1.0, 0.25),
            row(Bound::Screen, Grid::Variable, 0.5, 1.0, 0.75),
            refused(Bound::Screen, "no reason"),
        ];
        for (row, violations) in rows.iter_mut().zip([0, 2]) {
            if let Outcome::Measured(m) = &mut row.outcome {
                m.errors = m.errors.take().map(|e| Errors { checked: 500, violations, ..e });
            }
        }
        let json = summary(&rows).json();
        assert_eq!((&json[0]["shots"], &json[0]["refused"], &json[0]["checked"]), (&3.into(), &1.into(), &1000.into()));
        assert_eq!((&json[0]["violations"], &json[0]["violations per 1e5"]), (&2.into(), &200.0.into()));
        assert_eq!(json[0]["grid max px"], 0.75);
        assert_eq!(findings(rows).tables[1].1.json().as_array().map(Vec::len), Some(1));
    }
}
