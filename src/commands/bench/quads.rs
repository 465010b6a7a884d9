//! How many quads each bound asks for, against ETER's, and how many triangles are drawn, against ETER's grids.

use super::{Findings, SuiteArgs, progress_bar};
use crate::commands::args::ProjectionKind;
use crate::commands::measure::Subject;
use crate::commands::sweep::{COUNT_ONLY, Usual};
use crate::report::{Measured, Outcome, Row, Shot, Table, name};
use crate::scene::View;
use crate::stages::{Bound, Grid};
use anyhow::Result;

const USUAL: Usual = Usual {
    bounds: &Bound::ALL,
    // Variable grids compare the bounds alone; triangles under ETER's grids are what the papers' way draws.
    grids: &[Grid::Adaptive, Grid::Variable, Grid::Eter],
    tolerances: &[0.5],
    views: &View::ALL,
    zooms: &[1.0, 8.0, 64.0],
    projections: &[ProjectionKind::Perspective, ProjectionKind::Orthographic],
};

pub fn run(args: &SuiteArgs) -> Result<()> {
    args.frame.model.install(|| {
        let mut rows = Vec::new();
        for model in args.models() {
            let (loaded, scene) = model.load_scene()?;
            let mut subject = Subject::new(&loaded.name, &scene, COUNT_ONLY, args.frame.backend.engine()?);
            let sweep = args.sweep.resolve(&args.frame, &USUAL)?;
            // Of ETER's grids only those under ETER's bound are a reference.
            let options = || sweep.options.iter().filter(|o| o.grid != Grid::Eter || o.bound == Bound::Eter);
            let bar = progress_bar("counting");
            bar.set_length((sweep.shots.len() * options().count()) as u64);
            for view in &sweep.shots {
                for options in options() {
                    rows.push(subject.row(view, options)?);
                    bar.inc(1);
                }
            }
            bar.finish_and_clear();
        }
        findings(rows).publish(&args.results)
    })
}

fn findings(rows: Vec<Row>) -> Findings {
    Findings {
        title: "Quads and triangles",
        about:
            "Sums over the shots that the bound draws; ratios are over those same shots. Quads are compared with what \
                `--bound eter --grid variable` asks for (rows of that grid compare the bounds alone), triangles with \
                `--bound eter --grid eter`."
                .into(),
        tables: vec![("By model and bound".into(), ratios(&rows))],
        rows,
    }
}

fn ratios(rows: &[Row]) -> Table {
    let mut table = Table::new(&[
        "model",
        "bound",
        "grid",
        "shots",
        "quads",
        "quads / ETER's",
        "triangles",
        "triangles / ETER's",
        "note",
    ]);
    let mut keys: Vec<(&str, Bound, Grid)> = Vec::new();
    for row in rows {
        let key = (row.model.as_str(), row.setting.bound, row.setting.grid);
        if !keys.contains(&key) {
            keys.push(key);
        }
    }
    for (model, bound, grid) in keys {
        let own = |r: &&Row| r.model == model && r.setting.bound == bound && r.setting.grid == grid;
        let drawn: Vec<&Row> = rows.iter().filter(own).filter(|r| r.measured().is_some()).collect();
        let reason = rows.iter().filter(own).find_map(|r| match &r.outcome {
            Outcome::Refused(reason) => Some(format!("refused: {reason}")),
            Outcome::Measured(_) => None,
        });
        let shots: Vec<&Shot> = drawn.iter().map(|r| &r.shot).collect();
        let quads: u64 = drawn.iter().filter_map(|r| r.measured()).map(|m| m.counts.quads).sum();
        let triangles: u64 = drawn.iter().filter_map(|r| r.measured()).map(|m| m.counts.triangles).sum();
        let quads_of_eter = reference(rows, model, Grid::Variable, &shots, |m| m.counts.quads);
        let triangles_of_eter = reference(rows, model, Grid::Eter, &shots, |m| m.counts.triangles);
        table.push(vec![
            model.into(),
            name(bound).into(),
            name(grid).into(),
            drawn.len().into(),
            quads.into(),
            quads_of_eter.map(|eter| quads as f64 / eter).into(),
            triangles.into(),
            triangles_of_eter.map(|eter| triangles as f64 / eter).into(),
            reason.unwrap_or_default().into(),
        ]);
    }
    table
}

/// Sum of a count under ETER's bound over the shots; `None` where one of them is missing or there is nothing.
fn reference(rows: &[Row], model: &str, grid: Grid, shots: &[&Shot], count: fn(&Measured) -> u64) -> Option<f64> {
    let of = |shot: &Shot| {
        let fits =
            |r: &&Row| r.model == model && r.setting.bound == Bound::Eter && r.setting.grid == grid && r.shot == *shot;
        rows.iter().find(fits)?.measured().map(count)
    };
    let sum: u64 = shots.iter().map(|shot| of(shot)).sum::<Option<u64>>()?;
    (sum > 0).then_some(sum as f64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::testing::{refused, row};

    /// A row in a view of its own, with 100 quads and 200 triangles times `scale`.
    fn in_view(view: &str, bound: Bound, grid: Grid, scale: u64) -> Row {
        let mut row = row(bound, grid, 0.5, 1.0, 0.1);
        row.shot.view = view.into();
        if let Outcome::Measured(m) = &mut row.outcome {
            m.counts.quads *= scale;
            m.counts.triangles *= scale;
        }
        row
    }

    #[test]
    fn ratios_are_over_the_shots_that_were_drawn() {
        let mut late = refused(Bound::Screen, "too large");
        late.shot.view = "front".into();
        let rows = [
            in_view("iso", Bound::Screen, Grid::Variable, 1),
            late,
            in_view("iso", Bound::Eter, Grid::Variable, 4),
            in_view("front", Bound::Eter, Grid::Variable, 90),
            in_view("iso", Bound::Eter, Grid::Eter, 10),
        ];
        let json = ratios(&rows).json();
        assert_eq!((&json[0]["quads / ETER's"], &json[0]["triangles / ETER's"]), (&0.25.into(), &0.1.into()));
        assert_eq!(json[0]["note"], "refused: too large");
        // ETER's own grids were not drawn in front.
        assert_eq!(json[1]["quads / ETER's"], 1.0);
        assert!(json[1]["triangles / ETER's"].is_null());
    }
}
