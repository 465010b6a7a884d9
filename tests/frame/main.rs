//! The frame against closed forms, exact evaluation and the oracle.

mod bounds;
mod closed;
mod combinations;
mod determinism;
mod finite;
mod support;
