//! Tables and plots from measured runs. A row has both, time and error; a mean alone proves nothing.

mod front;
mod machine;
mod plot;
mod row;
mod rows;
mod table;

pub use front::{Point, pareto, points, summary};
pub use machine::{Machine, cpu_name, peak_memory};
pub use plot::{PlotError, plot_png, plot_svg};
pub use row::{Counts, Errors, Measured, Outcome, Row, Setting, Shot, Spread, StageSpread, Summary, stage_spreads};
pub use rows::{brief, from_json, full, name, to_json};
pub use table::{Cell, Table, three_figures};

/// Made-up rows.
#[cfg(test)]
pub(crate) mod testing {
    use super::*;
    use crate::stages::{Bound, Grid, Options};

    /// A row with the given time and largest grid error.
    pub fn row(bound: Bound, grid: Grid, tolerance: f64, ms: f64, error: f64) -> Row {
        let spread = |ms: f64| Spread { median: ms, min: ms * 0.9, max: ms * 1.2 };
        let summary = Summary { max: error, p999: error * 0.9, mean: error / 3.0 };
        let options = Options { bound, grid, tolerance, ..Options::default() };
        Row {
            model: "test".into(),
            shot: Shot { view: "iso".into(), zoom: 1.0, orthographic: false, size: [640, 480] },
            setting: Setting::from(&options),
            outcome: Outcome::Measured(Box::new(Measured {
                frames: 5,
                total: spread(ms),
                stages: vec![StageSpread { stage: "cull".into(), ms: spread(ms / 10.0) }],
                counts: Counts { quads: 100, triangles: 200, ..Counts::default() },
                errors: Some(Errors { checked: 10, grid: Some(summary), ..Errors::default() }),
            })),
            backend: "cpu".into(),
            raster: "software".into(),
            frame: None,
            machine: Machine {
                device: "a processor".into(),
                threads: 2,
                commit: "unknown".into(),
                date: "2026-01-01".into(),
            },
        }
    }

    pub fn refused(bound: Bound, reason: &str) -> Row {
        Row { outcome: Outcome::Refused(reason.into()), ..row(bound, Grid::Variable, 0.5, 0.0, 0.0) }
    }
}
