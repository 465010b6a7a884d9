//! What the program says and writes: results on standard output, everything else on standard error, files whole.

use anyhow::bail;
use serde::Serialize;
use std::fs::{self, File};
use std::io::{self, BufWriter, Write};
use std::path::Path;

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

/// An error where the folder that a file goes to is missing, before any work is done for it.
pub fn check_folder(path: &Path) -> anyhow::Result<()> {
    let folder = path.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    if !folder.is_dir() {
        bail!("{}: there is no folder {}: create it first", path.display(), folder.display());
    }
    if path.is_dir() {
        bail!("{}: this is a folder: give a file's name", path.display());
    }
    Ok(())
}

/// Writes a file under another name and renames it, so that it appears whole or not at all.
pub fn write_file(path: &Path, write: impl FnOnce(&mut BufWriter<File>) -> anyhow::Result<()>) -> anyhow::Result<()> {
    check_folder(path)?;
    // A device or a pipe must not be replaced by a file.
    let special = path.metadata().is_ok_and(|m| !m.is_file());
    let name = path.file_name().unwrap_or_default().to_string_lossy();
    let temporary = path.with_file_name(format!(".{name}.{}.tmp", std::process::id()));
    let target = if special { path } else { &temporary };
    let attempt = || {
        let mut file = BufWriter::new(File::create(target)?);
        write(&mut file)?;
        file.flush()?;
        drop(file);
        if !special {
            fs::rename(&temporary, path)?;
        }
        anyhow::Ok(())
    };
    attempt().map_err(|error| {
        if !special {
            // What is half written is of no use; if it can't be removed either, the first error says more.
            let _ = fs::remove_file(&temporary);
        }
        error.context(format!("{}: could not be written", path.display()))
    })
}
