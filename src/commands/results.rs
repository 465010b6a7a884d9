//! Files of results: PREFIX.md, PREFIX.csv, PREFIX.json beside each other.

use anyhow::{Context, Result};
use std::ffi::OsString;
use std::path::{Path, PathBuf};

/// `prefix` with a suffix; a dot inside the prefix stays.
pub fn with_suffix(prefix: &Path, suffix: &str) -> PathBuf {
    let mut path = OsString::from(prefix);
    path.push(suffix);
    path.into()
}

/// Writes a file whole or not at all, so that a run that is cut off leaves the last complete one.
pub fn write(prefix: &Path, suffix: &str, text: &str) -> Result<()> {
    let path = with_suffix(prefix, suffix);
    let partial = with_suffix(&path, ".partial");
    if let Some(folder) = path.parent() {
        std::fs::create_dir_all(folder).with_context(|| format!("cannot make the folder {}", folder.display()))?;
    }
    std::fs::write(&partial, text)
        .and_then(|()| std::fs::rename(&partial, &path))
        .with_context(|| format!("cannot write {}", path.display()))
}
