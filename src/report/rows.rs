//! Rows as files: a short table to read, a wide one to compute with, and JSON that reads back.

use super::{Cell, Errors, Measured, Outcome, Row, Spread, Summary, Table};
use crate::stages::STAGES;

/// The name the command line uses for an option's value.
pub fn name(value: impl clap::ValueEnum) -> String {
    value.to_possible_value().map_or_else(String::new, |v| v.get_name().to_owned())
}

/// The table for people: what was run, its time, its work, its errors.
pub fn brief(rows: &[Row]) -> Table {
    let mut table = Table::new(&[
        "model",
        "view",
        "zoom",
        "proj",
        "bound",
        "grid",
        "trim",
        "t px",
        "ms",
        "min-max ms",
        "quads",
        "triangles",
        "grid max px",
        "grid p999",
        "param max px",
        "refined max px",
        "violations",
        "cracks",
        "covering",
        "depth",
        "note",
    ]);
    for row in rows {
        let (m, e) = (row.measured(), row.errors());
        let max = |summary: Option<Summary>| summary.map(|s| s.max);
        table.push(vec![
            row.model.as_str().into(),
            row.shot.view.as_str().into(),
            row.shot.zoom.into(),
            row.shot.projection()[..5].into(),
            name(row.setting.bound).into(),
            name(row.setting.grid).into(),
            name(row.setting.trim).into(),
            row.setting.tolerance.into(),
            m.map(|m| m.total.median).into(),
            m.map_or(Cell::Missing, |m| range(m.total).into()),
            m.map(|m| m.counts.quads).into(),
            m.map(|m| m.counts.triangles).into(),
            e.and_then(|e| e.grid_max()).into(),
            e.and_then(|e| e.grid).map(|s| s.p999).into(),
            e.and_then(|e| max(e.parametric)).into(),
            e.and_then(|e| max(e.refined)).into(),
            e.map(|e| e.violations).into(),
            e.map(|e| e.cracks).into(),
            e.map(|e| e.covering_failures).into(),
            e.map(|e| e.depth_failures).into(),
            note(row).into(),
        ]);
    }
    table
}

/// Everything that is known of every row, one column each.
pub fn full(rows: &[Row]) -> Table {
    let columns = columns();
    let headings: Vec<&str> = columns.iter().map(|c| c.0.as_str()).collect();
    let mut table = Table::new(&headings);
    for row in rows {
        table.push(columns.iter().map(|c| (c.1)(row)).collect());
    }
    table
}

/// JSON array of the rows; [`from_json`] reads it back.
pub fn to_json(rows: &[Row]) -> serde_json::Result<String> {
    serde_json::to_string_pretty(rows)
}

/// The rows of a JSON array that [`to_json`] wrote.
pub fn from_json(text: &str) -> serde_json::Result<Vec<Row>> {
    serde_json::from_str(text)
}

fn range(ms: Spread) -> String {
    format!("{}-{}", super::three_figures(ms.min), super::three_figures(ms.max))
}

fn note(row: &Row) -> String {
    match &row.outcome {
        Outcome::Refused(reason) => format!("refused: {reason}"),
        Outcome::Measured(_) => String::new(),
    }
}

type Column = (String, Box<dyn Fn(&Row) -> Cell>);

fn columns() -> Vec<Column> {
    let mut columns = Vec::new();
    setting_columns(&mut columns);
    time_columns(&mut columns);
    count_columns(&mut columns);
    error_columns(&mut columns);
    add(&mut columns, "refused", |r| match &r.outcome {
        Outcome::Refused(reason) => reason.as_str().into(),
        Outcome::Measured(_) => Cell::Missing,
    });
    columns
}

fn add(columns: &mut Vec<Column>, heading: impl Into<String>, cell: impl Fn(&Row) -> Cell + 'static) {
    columns.push((heading.into(), Box::new(cell)));
}

fn setting_columns(c: &mut Vec<Column>) {
    add(c, "model", |r| r.model.as_str().into());
    add(c, "view", |r| r.shot.view.as_str().into());
    add(c, "zoom", |r| r.shot.zoom.into());
    add(c, "projection", |r| r.shot.projection().into());
    add(c, "width", |r| u64::from(r.shot.size[0]).into());
    add(c, "height", |r| u64::from(r.shot.size[1]).into());
    add(c, "bound", |r| name(r.setting.bound).into());
    add(c, "grid", |r| name(r.setting.grid).into());
    add(c, "fill", |r| name(r.setting.fill).into());
    add(c, "trim", |r| name(r.setting.trim).into());
    add(c, "precision", |r| name(r.setting.precision).into());
    add(c, "refine", |r| u64::from(r.setting.refine).into());
    add(c, "tolerance_px", |r| r.setting.tolerance.into());
    add(c, "depth_tolerance", |r| r.setting.depth_tolerance.into());
    add(c, "backend", |r| r.backend.as_str().into());
    add(c, "raster", |r| r.raster.as_str().into());
    add(c, "frame", |r| r.frame.map(name).into());
    add(c, "device", |r| r.machine.device.as_str().into());
    add(c, "threads", |r| r.machine.threads.into());
    add(c, "commit", |r| r.machine.commit.as_str().into());
    add(c, "date", |r| r.machine.date.as_str().into());
}

fn time_columns(c: &mut Vec<Column>) {
    add(c, "frames", |r| r.measured().map(|m| m.frames).into());
    spread_columns(c, "total", |m| Some(m.total));
    for stage in STAGES {
        spread_columns(c, stage, move |m| m.stages.iter().find(|s| s.stage == stage).map(|s| s.ms));
    }
}

fn spread_columns(c: &mut Vec<Column>, what: &str, get: impl Fn(&Measured) -> Option<Spread> + Copy + 'static) {
    add(c, format!("{what}_ms"), move |r| r.measured().and_then(get).map(|s| s.median).into());
    add(c, format!("{what}_min_ms"), move |r| r.measured().and_then(get).map(|s| s.min).into());
    add(c, format!("{what}_max_ms"), move |r| r.measured().and_then(get).map(|s| s.max).into());
}

fn count_columns(c: &mut Vec<Column>) {
    let mut count = |heading: &str, get: fn(&Measured) -> u64| add(c, heading, move |r| r.measured().map(get).into());
    count("patches", |m| m.counts.patches);
    count("patches_visible", |m| m.counts.patches_visible);
    count("leaves", |m| m.counts.leaves);
    count("meshlets", |m| m.counts.meshlets);
    count("quads", |m| m.counts.quads);
    count("triangles", |m| m.counts.triangles);
    count("triangles_hardware", |m| m.counts.triangles_hardware);
    count("bytes_copied", |m| m.counts.bytes_copied);
    count("filled", |m| m.counts.filled);
    count("drawn", |m| m.counts.drawn);
    count("buffer_bytes", |m| m.counts.buffer_bytes);
}

fn summary_columns(c: &mut Vec<Column>, kind: &str, get: fn(&Errors) -> Option<Summary>) {
    add(c, format!("{kind}_max_px"), move |r| r.errors().and_then(get).map(|s| s.max).into());
    add(c, format!("{kind}_p999_px"), move |r| r.errors().and_then(get).map(|s| s.p999).into());
    add(c, format!("{kind}_mean_px"), move |r| r.errors().and_then(get).map(|s| s.mean).into());
}

fn error_columns(c: &mut Vec<Column>) {
    summary_columns(c, "grid", |e| e.grid);
    summary_columns(c, "parametric", |e| e.parametric);
    summary_columns(c, "refined", |e| e.refined);
    add(c, "checked", |r| r.errors().map(|e| e.checked).into());
    add(c, "violations", |r| r.errors().map(|e| e.violations).into());
    add(c, "cracks", |r| r.errors().map(|e| e.cracks).into());
    add(c, "covering_failures", |r| r.errors().map(|e| e.covering_failures).into());
    add(c, "depth_failures", |r| r.errors().map(|e| e.depth_failures).into());
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::report::testing::{refused, row};
    use crate::stages::{Bound, Grid};

    fn rows() -> Vec<Row> {
        vec![
            row(Bound::Screen, Grid::Variable, 0.5, 12.5, 0.4375),
            refused(Bound::Slefe, "rational, with a \"reason\""),
        ]
    }

    #[test]
    fn json_reads_back() {
        let rows = rows();
        assert_eq!(from_json(&to_json(&rows).unwrap()).unwrap(), rows);
    }

    #[test]
    fn csv_reads_back() {
        let csv = full(&rows()).csv();
        let lines: Vec<Vec<String>> = csv.lines().map(split).collect();
        let column = |h: &str| lines[0].iter().position(|x| x == h).unwrap_or_else(|| panic!("no column {h}"));
        assert!(lines.iter().all(|line| line.len() == lines[0].len()));
        assert_eq!(lines[1][column("bound")], "screen");
        assert_eq!(lines[1][column("total_ms")].parse(), Ok(12.5));
        assert_eq!(lines[1][column("grid_max_px")].parse(), Ok(0.4375));
        assert_eq!(lines[1][column("cull_ms")].parse(), Ok(1.25));
        assert_eq!(lines[1][column("trim_ms")], "");
        assert_eq!(lines[2][column("total_ms")], "");
        assert_eq!(lines[2][column("refused")], "rational, with a \"reason\"");
    }

    #[test]
    fn a_refusal_is_a_row_with_its_reason() {
        let text = brief(&rows()).markdown();
        assert_eq!(text.lines().count(), 4);
        assert!(text.lines().last().unwrap().contains("refused: rational"));
    }

    /// The fields of one CSV line.
    fn split(line: &str) -> Vec<String> {
        let (mut fields, mut quoted) = (vec![String::new()], false);
        let mut chars = line.chars().peekable();
        while let Some(c) = chars.next() {
            let field = fields.last_mut().unwrap();
            match c {
                '"' if quoted && chars.peek() == Some(&'"') => field.push(chars.next().unwrap()),
                '"' => quoted = !quoted,
                ',' if !quoted => fields.push(String::new()),
                c => field.push(c),
            }
        }
        fields
    }
}
