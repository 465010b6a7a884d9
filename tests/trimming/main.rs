//! Trimming: the trees over trim loops against a second method, and trimmed frames against pictures known exactly.

mod frames;
mod heaps;
#[path = "../support/mod.rs"]
mod support;
mod tree;
