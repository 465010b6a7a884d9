//! The oracle: what an image should show, in f64 and without any tessellation (DESIGN section 6).
mod hierarchy;
mod hits;
mod piece;
mod ray;
mod view;

pub use hits::{Hit, Oracle};

/// What is below this many pixels is not told apart.
pub const RESOLUTION: f64 = 1e-4;
