use crate::geometry::GeometryError;
use thiserror::Error;

/// Why an entity could not be used; every variant names it.
#[derive(Clone, Debug, Error)]
pub(super) enum StepError {
    #[error("#{0} is not in the file")]
    Missing(u32),
    #[error("#{entity} is {found}, not {expected}")]
    Kind { entity: u32, found: String, expected: &'static str },
    #[error("#{entity}: parameter {index} is not {expected}")]
    Parameter { entity: u32, index: usize, expected: &'static str },
    #[error("#{entity}: {what}")]
    Bad { entity: u32, what: String },
    #[error("#{0}: entities refer to each other in a circle, or too deep")]
    Depth(u32),
    #[error(transparent)]
    Geometry(#[from] GeometryError),
}

pub(super) fn bad<T>(entity: u32, what: impl Into<String>) -> Result<T, StepError> {
    Err(StepError::Bad { entity, what: what.into() })
}
