use thiserror::Error;

/// What is wrong with curve or surface data; every variant names what and where.
#[derive(Debug, Clone, PartialEq, Error)]
pub enum GeometryError {
    #[error("{what}: expected {expected} control points, found {found}")]
    PointCount { what: String, expected: usize, found: usize },
    #[error("{what}: expected {expected} knots, found {found}")]
    KnotCount { what: String, expected: usize, found: usize },
    #[error("{what}: knot {index} ({value}) is smaller than the one before it ({before})")]
    DecreasingKnots { what: String, index: usize, before: f64, value: f64 },
    #[error("{what}: knot {index} is not finite")]
    KnotNotFinite { what: String, index: usize },
    #[error("{what}: the knot vector spans no interval (all knots inside the domain are {value})")]
    EmptyDomain { what: String, value: f64 },
    #[error("{what}: weight of control point {index} is {value}; weights must be positive and finite")]
    BadWeight { what: String, index: usize, value: f64 },
    #[error("{what}: control point {index} is not finite")]
    PointNotFinite { what: String, index: usize },
    #[error("{what}: degree {degree} is outside 1 to {max}")]
    BadDegree { what: String, degree: usize, max: usize },
    #[error("{what}: {reason}")]
    BadShape { what: String, reason: String },
}
