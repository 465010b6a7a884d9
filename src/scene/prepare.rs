//! `Model` to `Scene`.

use super::Scene;
use crate::model::Model;
use thiserror::Error;

/// Why a model could not be prepared.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum PrepareError {
    #[error("the model has no surfaces")]
    Empty,
}

/// Prepares a model; `progress(done, all)` is called now and then, from any thread.
pub fn prepare(model: &Model, progress: &(dyn Fn(usize, usize) + Sync)) -> Result<Scene, PrepareError> {
    let _ = (model, progress);
    Err(PrepareError::Empty)
}
