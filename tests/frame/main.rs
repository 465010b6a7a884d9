//! The frame against closed forms, exact evaluation and the oracle.

mod bounds;
mod closed;
mod combinations;
mod determinism;
mod extremes;
mod finite;
mod support;
