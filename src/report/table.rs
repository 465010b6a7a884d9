//! A table of figures, as Markdown that lines up in a terminal and as CSV that keeps every digit.

use serde_json::Value;
use std::fmt::Write;

/// What one cell holds.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Not measured; never shown as zero.
    Missing,
    Text(String),
    Count(u64),
    Number(f64),
}

/// Headings and rows of equal length.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Table {
    headings: Vec<String>,
    rows: Vec<Vec<Cell>>,
}

impl Table {
    pub fn new(headings: &[&str]) -> Self {
        Self { headings: headings.iter().map(|&h| h.into()).collect(), rows: Vec::new() }
    }

    /// Adds a row; one cell a heading.
    pub fn push(&mut self, row: Vec<Cell>) {
        debug_assert_eq!(row.len(), self.headings.len(), "one cell a heading");
        self.rows.push(row);
    }

    pub fn is_empty(&self) -> bool {
        self.rows.is_empty()
    }

    /// Pipe table, padded so that it reads well unrendered; numbers to three figures, flushed right.
    pub fn markdown(&self) -> String {
        let shown: Vec<Vec<String>> = self.rows.iter().map(|r| r.iter().map(Cell::brief).collect()).collect();
        let columns = 0..self.headings.len();
        let right: Vec<bool> = columns.clone().map(|c| self.is_numeric(c)).collect();
        let length = |s: &String| s.chars().count();
        let widths: Vec<usize> = columns
            .map(|c| shown.iter().map(|r| length(&r[c])).chain([length(&self.headings[c]), 2]).max().unwrap_or(2))
            .collect();
        let line = |cells: &[String]| {
            let mut out = String::from("|");
            for ((cell, &width), &right) in cells.iter().zip(&widths).zip(&right) {
                let pad = " ".repeat(width.saturating_sub(length(cell)));
                let _ = if right { write!(out, " {pad}{cell} |") } else { write!(out, " {cell}{pad} |") };
            }
            out + "\n"
        };
        let rule = widths.iter().zip(&right).map(|(&w, &r)| if r { "-".repeat(w - 1) + ":" } else { "-".repeat(w) });
        line(&self.headings) + &line(&rule.collect::<Vec<_>>()) + &shown.iter().map(|row| line(row)).collect::<String>()
    }

    /// Comma separated with a heading line (RFC 4180 quoting); numbers in the shortest form that reads back the same.
    pub fn csv(&self) -> String {
        let headings = csv_line(self.headings.iter().map(|h| csv_field(h)));
        let rows = self.rows.iter().map(|row| csv_line(row.iter().map(Cell::exact)));
        headings + &rows.collect::<String>()
    }

    /// One object a row, keyed by the headings.
    pub fn json(&self) -> Value {
        let object = |row: &Vec<Cell>| self.headings.iter().cloned().zip(row.iter().map(Cell::json)).collect::<Value>();
        self.rows.iter().map(object).collect()
    }

    /// Holds numbers only, so that it is flushed right.
    fn is_numeric(&self, column: usize) -> bool {
        let cells = || self.rows.iter().map(|row| &row[column]);
        !cells().any(|c| matches!(c, Cell::Text(_))) && cells().any(|c| *c != Cell::Missing)
    }
}

impl Cell {
    /// For reading.
    fn brief(&self) -> String {
        match self {
            Cell::Missing => "-".into(),
            Cell::Text(text) => text.replace('|', "\\|").replace('\n', " "),
            Cell::Count(n) => n.to_string(),
            Cell::Number(x) => three_figures(*x),
        }
    }

    fn json(&self) -> Value {
        match self {
            Cell::Missing => Value::Null,
            Cell::Text(text) => text.as_str().into(),
            Cell::Count(n) => (*n).into(),
            Cell::Number(x) => (*x).into(),
        }
    }

    /// For machines.
    fn exact(&self) -> String {
        match self {
            Cell::Missing => String::new(),
            Cell::Text(text) => csv_field(text),
            Cell::Count(n) => n.to_string(),
            Cell::Number(x) => x.to_string(),
        }
    }
}

impl From<&str> for Cell {
    fn from(text: &str) -> Self {
        Cell::Text(text.into())
    }
}

impl From<String> for Cell {
    fn from(text: String) -> Self {
        Cell::Text(text)
    }
}

impl From<u64> for Cell {
    fn from(n: u64) -> Self {
        Cell::Count(n)
    }
}

impl From<usize> for Cell {
    fn from(n: usize) -> Self {
        Cell::Count(n as u64)
    }
}

impl From<f64> for Cell {
    fn from(x: f64) -> Self {
        Cell::Number(x)
    }
}

impl<T: Into<Cell>> From<Option<T>> for Cell {
    fn from(value: Option<T>) -> Self {
        value.map_or(Cell::Missing, Into::into)
    }
}

/// Three significant figures; all digits before the point are kept.
pub fn three_figures(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let exponent = x.abs().log10().floor();
    match exponent as i32 {
        e if e < -4 => format!("{x:.1e}"),
        e => format!("{x:.*}", usize::try_from(2 - e).unwrap_or(0)),
    }
}

fn csv_line(fields: impl Iterator<Item = String>) -> String {
    fields.collect::<Vec<_>>().join(",") + "\n"
}

fn csv_field(text: &str) -> String {
    if text.contains([',', '"', '\n', '\r']) { format!("\"{}\"", text.replace('"', "\"\"")) } else { text.into() }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sample() -> Table {
        let mut table = Table::new(&["name", "ms", "why"]);
        table.push(vec!["a,\"b\"".into(), 1234.56.into(), Cell::Missing]);
        table.push(vec!["c".into(), 0.012345.into(), "x|y".into()]);
        table
    }

    #[test]
    fn markdown_lines_up() {
        let expected = "\
| name  |     ms | why  |
| ----- | -----: | ---- |
| a,\"b\" |   1235 | -    |
| c     | 0.0123 | x\\|y |
";
        assert_eq!(sample().markdown(), expected);
    }

    #[test]
    fn csv_quotes_and_keeps_digits() {
        assert_eq!(sample().csv(), "name,ms,why\n\"a,\"\"b\"\"\",1234.56,\nc,0.012345,x|y\n");
    }

    #[test]
    fn json_is_keyed_by_headings() {
        let json = sample().json();
        assert_eq!(json[1]["ms"], 0.012345);
        assert!(json[0]["why"].is_null());
    }

    #[test]
    fn figures() {
        let shown = [0.0, 0.5, 12.345, 99.95, 1e-7, -3.21987, 250_000.0].map(three_figures);
        assert_eq!(shown, ["0", "0.500", "12.3", "100.0", "1.0e-7", "-3.22", "250000"]);
    }
}
