//! Files to models, one file (or folder) a format, chosen by content and never by suffix.

use crate::model::Model;
use std::path::PathBuf;
use thiserror::Error;

/// Why a file could not be read.
#[derive(Debug, Error)]
pub enum ImportError {
    #[error("{}: not written yet", path.display())]
    Todo { path: PathBuf },
}

/// Reads a model file, or a built-in model by the name `builtin:NAME`.
pub fn load(source: &str) -> Result<Model, ImportError> {
    Err(ImportError::Todo { path: source.into() })
}
