//! (being written)

pub mod builtin;
