//! Where a model's bytes come from: its name, and the files beside it that it may refer to.

use super::{ImportError, read_file, read_from};
use crate::model::Model;
use std::path::{Path, PathBuf};
use std::sync::Arc;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Files that refer to files may not nest deeper.
const MAX_DEPTH: usize = 16;
/// Files that one file may lead to: a few that refer to each other often grow like powers.
const MAX_FILES: usize = 10_000;

#[derive(Debug)]
pub(super) struct Origin {
    /// What the model is called.
    pub name: String,
    /// The file itself; `None` for bytes that came from nowhere: what they refer to is not opened.
    file: Option<PathBuf>,
    /// The files that led here, by their one true path.
    trail: Vec<PathBuf>,
    opened: Arc<AtomicUsize>,
}

fn name_of(path: &Path) -> String {
    path.file_stem().unwrap_or_default().to_string_lossy().into_owned()
}

impl Origin {
    /// Bytes that only have a name.
    pub fn nowhere(path: &Path) -> Self {
        Self { name: name_of(path), file: None, trail: Vec::new(), opened: Arc::default() }
    }

    pub fn file(path: &Path) -> Self {
        let trail = path.canonicalize().into_iter().collect();
        Self { name: name_of(path), file: Some(path.to_path_buf()), trail, opened: Arc::default() }
    }

    /// Reads a file that is named in this one: of the name only what follows the last folder counts.
    ///
    /// # Errors
    /// Why there is no model, with the file's name.
    pub fn read_beside(&self, named: &str) -> Result<Model, String> {
        let name = named.rsplit(['/', '\\']).next().unwrap_or(named);
        let Some(file) = &self.file else { return Err(format!("{name}, which is not looked for")) };
        let Some(path) = beside(file, name) else { return Err(format!("{name}, which is not beside this one")) };
        let true_path = path.canonicalize().map_err(|error| format!("{name}: {error}"))?;
        if self.trail.contains(&true_path) {
            return Err(format!("{name}, which refers to itself"));
        }
        if self.trail.len() > MAX_DEPTH || self.opened.fetch_add(1, Ordering::Relaxed) >= MAX_FILES {
            return Err(format!("{name}: more than {MAX_FILES} files, or they nest deeper than {MAX_DEPTH}"));
        }
        let trail = self.trail.iter().cloned().chain([true_path]).collect();
        let origin = Self { name: name_of(&path), file: Some(path.clone()), trail, opened: self.opened.clone() };
        let read = read_file(&path).and_then(|bytes| read_from(&bytes, &path, &origin));
        read.map_err(|error: ImportError| error.to_string())
    }
}

/// The file of this name in the folder of `file`; names written on other systems may differ in case.
fn beside(file: &Path, name: &str) -> Option<PathBuf> {
    if name.is_empty() || name == ".." {
        return None;
    }
    let path = file.with_file_name(name);
    if path.is_file() {
        return Some(path);
    }
    let folder = file.parent().filter(|f| !f.as_os_str().is_empty()).unwrap_or(Path::new("."));
    let mut files = std::fs::read_dir(folder).ok()?.filter_map(Result::ok);
    let found = files.find(|entry| entry.file_name().to_string_lossy().eq_ignore_ascii_case(name))?;
    Some(found.path()).filter(|path| path.is_file())
}
