//! Files to models, one file (or folder) a format, chosen by content and never by suffix.

mod bezierview;
mod bpt;
mod brep;
pub mod builtin;
mod formats;
mod origin;
mod patches;
mod scan;
mod step;

use crate::model::Model;
use formats::Format;
use origin::Origin;
use scan::Stop;
use std::{fs::File, io, io::Read, path::Path, path::PathBuf};
use thiserror::Error;

/// Larger files are refused before they fill the memory.
const MAX_BYTES: u64 = 1 << 32;

/// Why a file could not be read.
#[derive(Debug, Error)]
pub enum ImportError {
    #[error("{}: {error}", path.display())]
    Io { path: PathBuf, error: io::Error },
    #[error("{}: the file is larger than 4 GiB: split it", path.display())]
    TooLarge { path: PathBuf },
    #[error("{}: the file is empty", path.display())]
    Empty { path: PathBuf },
    #[error("{}: the content is of no known format; what can be read: {}", path.display(), formats::readable())]
    Unknown { path: PathBuf },
    #[error("{}: {format} files are not read yet; what can be read: {}", path.display(), formats::readable())]
    NotReadYet { path: PathBuf, format: &'static str },
    #[error("{}: line {line}: {what}", path.display())]
    Format { path: PathBuf, line: usize, what: String },
    #[error(transparent)]
    Builtin(#[from] builtin::BuiltinError),
}

/// What is wrong with a file's text, and where.
#[derive(Debug)]
struct ParseError {
    line: usize,
    what: String,
}

impl From<Stop> for ParseError {
    fn from(stop: Stop) -> Self {
        match stop {
            Stop::End { line } => Self { line, what: "the file ends here, before anything was complete".into() },
            Stop::Bad { line, what } => Self { line, what },
        }
    }
}

/// Reads a model file, or a built-in model by the name `builtin:NAME`.
pub fn load(source: &str) -> Result<Model, ImportError> {
    if let Some(name) = source.strip_prefix("builtin:") {
        return Ok(builtin::builtin(name)?);
    }
    let path = Path::new(source);
    let bytes = read_file(path)?;
    read_from(&bytes, path, &Origin::file(path))
}

/// Reads a model from the bytes of a file; `path` names it in messages and is not opened, nor is what the file refers to.
pub fn read(bytes: &[u8], path: &Path) -> Result<Model, ImportError> {
    read_from(bytes, path, &Origin::nowhere(path))
}

fn read_from(bytes: &[u8], path: &Path, origin: &Origin) -> Result<Model, ImportError> {
    let path_buf = || path.to_path_buf();
    if bytes.trim_ascii().is_empty() {
        return Err(ImportError::Empty { path: path_buf() });
    }
    let Format { name: format, read, .. } =
        formats::recognize(bytes).ok_or(ImportError::Unknown { path: path_buf() })?;
    let read = read.ok_or(ImportError::NotReadYet { path: path_buf(), format })?;
    read(bytes, origin).map_err(|e| ImportError::Format { path: path_buf(), line: e.line, what: e.what })
}

/// Reads only the text of a STEP file: the number of entities in it. `None` for other formats.
pub fn count_entities(path: &Path) -> Result<Option<u64>, ImportError> {
    let bytes = read_file(path)?;
    Ok(step::matches(&bytes).then(|| step::count_entities(&bytes)))
}

fn read_file(path: &Path) -> Result<Vec<u8>, ImportError> {
    let failed = |error| ImportError::Io { path: path.to_path_buf(), error };
    let file = File::open(path).map_err(failed)?;
    let size = file.metadata().map_err(failed)?.len();
    let mut bytes = Vec::with_capacity(usize::try_from(size.min(MAX_BYTES)).unwrap_or(0));
    // A device or a pipe has no size of its own and may never end.
    file.take(MAX_BYTES + 1).read_to_end(&mut bytes).map_err(failed)?;
    if bytes.len() as u64 > MAX_BYTES {
        return Err(ImportError::TooLarge { path: path.to_path_buf() });
    }
    Ok(bytes)
}
