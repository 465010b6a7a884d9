//! # halfpixel: pixel-accurate rendering of NURBS models
//!
//! Every pixel shows the exact surface: triangles within half a pixel of it, no cracks, the error measured.
//!
//! ```text
//! file --import--> Model --prepare--> Scene --[ per view ]--> Frame --> PNG / EXR
//!                                               |
//!   cull -> estimate -> evaluate -> rasterize -> trim -> fill -> shade
//! ```
//!
//! | step | what it does | where |
//! |---|---|---|
//! | import | a file to a [`model::Model`]: surfaces, faces, parts, instances | [`import`] |
//! | prepare | rational Bézier patches about local origins, enclosures of their second derivatives, normal cones, trim trees | [`scene::prepare`], `scene/trim_tree.rs` |
//! | cull | the patches that can be seen, split until f32 about their own screen position can be trusted | `stages/cull.rs` |
//! | estimate | a grid for each piece, from the bound asked for | `stages/estimate.rs`, `bounds.rs`, `slefe.rs` |
//! | evaluate | the grids' vertices, snapped to 1/256 pixel, in meshlets of at most 7 x 7 quads | `stages/evaluate.rs` |
//! | rasterize | triangles into buffer N; strokes along borders and folds into buffer S | `stages/rasterize.rs`, `stroke.rs` |
//! | trim | fragments near a trim curve, tested on the exact surface under their pixel's centre | `stages/trim.rs` |
//! | fill | where S is nearer than N, a pixel may be a crack | `stages/fill.rs` |
//! | shade | Newton steps to the exact surface under each pixel centre; what S proposed is decided there | `stages/shade.rs`, `newton.rs`, `settle.rs` |
//!
//! [`stages::Renderer`] runs a frame; [`verify`] judges it in f64 without any tessellation; [`report`] turns measured
//! runs into tables and plots; [`cuda`] is the host side of the kernels in `kernels/`, [`emulated`] runs them on the CPU;
//! [`commands`] is the command line.
//!
//! ```
//! use halfpixel::{import, scene, stages};
//!
//! let model = import::load("builtin:sphere")?;
//! let scene = scene::prepare(&model, &|_done, _all| {})?;
//! let camera = scene::ViewSpec { size: [64, 48], ..Default::default() }.camera(&scene.bounds)?;
//! let frame = stages::Renderer::new(&scene).render(&camera, &stages::Options::default())?;
//! assert!(frame.pixel(32, 24).is_some());
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```
// Only `cuda` and `emulated` have some, where they call foreign code; each block says why it is sound.
#![deny(unsafe_code)]

mod cache;
pub mod commands;
pub mod cuda;
pub mod emulated;
pub mod geometry;
pub mod import;
pub mod model;
pub mod report;
pub mod scene;
pub mod stages;
pub mod verify;
pub mod vulkan;
