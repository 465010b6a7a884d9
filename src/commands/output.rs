//! What the program says: results on standard output, everything else on standard error.

use serde::Serialize;
use std::io::{self, Write};

/// Prints a result and a line break. A closed pipe is not an error: the reader has seen enough.
pub fn print(text: &str) -> anyhow::Result<()> {
    let mut out = io::stdout().lock();
    let written = writeln!(out, "{text}").and_then(|()| out.flush());
    match written {
        Err(e) if e.kind() != io::ErrorKind::BrokenPipe => Err(anyhow::Error::new(e).context("standard output")),
        _ => Ok(()),
    }
}

/// Prints one JSON object.
pub fn print_json(value: &impl Serialize) -> anyhow::Result<()> {
    print(&serde_json::to_string_pretty(value)?)
}

/// One error line. Nothing can be done where standard error itself is closed.
pub fn error_line(text: &str) {
    let _ = writeln!(io::stderr(), "halfpixel: {}", one_line(text));
}

/// One warning line.
pub fn warning_line(text: &str) {
    error_line(&format!("warning: {text}"));
}

/// Line breaks and other control characters (file names may hold them) as spaces.
fn one_line(text: &str) -> String {
    text.trim_end().chars().map(|c| if c.is_control() { ' ' } else { c }).collect()
}
