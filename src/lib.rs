//! # halfpixel: pixel-accurate rendering of NURBS models
//!
//! ```text
//! file --import--> Model --prepare--> Scene --[ per view ]--> Frame --> PNG / EXR
//!                                               |
//!   cull -> estimate -> evaluate -> rasterize -> fill -> shade
//! ```
#![forbid(unsafe_code)]

pub mod commands;
pub mod geometry;
pub mod import;
pub mod model;
pub mod report;
pub mod scene;
pub mod stages;
pub mod verify;
