//! STEP files: small ones made here for what is hard, and the real ones.

#[path = "../support/mod.rs"]
mod support;

mod real;
