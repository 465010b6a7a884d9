//! What a suite found whose rows are no frames: one wide table for machines, short ones for people.

use super::{ResultArgs, output, results};
use crate::report::{Cell, Machine, Table};
use anyhow::Result;
use serde_json::{Value, json};

/// Every row carries where and when it was measured.
pub struct Sheet {
    pub suite: &'static str,
    pub title: &'static str,
    /// What a reader must know to read the tables.
    pub about: String,
    pub machine: Machine,
    pub backend: &'static str,
    /// Heading and table.
    pub tables: Vec<(String, Table)>,
    pub rows: Table,
}

/// Headings of what [`stamp`] adds to a row.
pub const STAMP: [&str; 5] = ["backend", "device", "threads", "commit", "date"];

/// What rows end with; a GPU's name has its driver's version.
pub fn stamp(backend: &str, machine: &Machine) -> [Cell; 5] {
    let Machine { device, threads, commit, date } = machine;
    [backend.into(), device.as_str().into(), (*threads).into(), commit.as_str().into(), date.as_str().into()]
}

/// The line above the tables.
pub fn measured_with(backend: &str, Machine { device, threads, commit, date }: &Machine) -> String {
    format!("Measured with --backend {backend} on {device} with {threads} threads, commit {commit}, {date}.\n")
}

impl Sheet {
    pub fn publish(&self, args: &ResultArgs) -> Result<()> {
        if let Some(prefix) = &args.output {
            results::write(prefix, ".md", &self.markdown())?;
            results::write(prefix, ".csv", &self.rows.csv())?;
            results::write(prefix, ".json", &(serde_json::to_string_pretty(&self.json())? + "\n"))?;
        }
        if args.json { output::print_json(&self.json()) } else { output::print(self.markdown().trim_end()) }
    }

    fn json(&self) -> Value {
        let tables: Value = self.tables.iter().map(|(heading, table)| (heading.clone(), table.json())).collect();
        json!({
            "suite": self.suite,
            "about": self.about,
            "backend": self.backend,
            "machine": self.machine,
            "tables": tables,
            "rows": self.rows.json(),
        })
    }

    fn markdown(&self) -> String {
        let mut text = format!("# {}\n\n{}\n\n", self.title, self.about);
        text += &measured_with(self.backend, &self.machine);
        for (heading, table) in self.tables.iter().filter(|(_, table)| !table.is_empty()) {
            text += &format!("\n## {heading}\n\n{}", table.markdown());
        }
        text
    }
}
