//! The frame: its buffers, its statistics, and the order of the stages.

use super::Options;
use crate::scene::{Camera, Scene};
use serde::Serialize;
use thiserror::Error;

/// What the frame stores for one drawn pixel.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pixel {
    /// Index into `Scene::instances`.
    pub instance: u32,
    /// Index into `Scene::patches`.
    pub patch: u32,
    /// (u, v) in the Bézier patch's unit square as interpolated on the triangle (before refinement).
    pub interpolated: [f64; 2],
    /// (u, v) in the Bézier patch's unit square as stored (after refinement).
    pub stored: [f64; 2],
    /// Stored depth (larger is nearer).
    pub depth: f32,
    /// The stroke buffer decided this pixel.
    pub filled: bool,
}

/// Wall-clock time of one stage.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct StageTime {
    pub stage: &'static str,
    pub ms: f64,
}

/// Counts and times of one frame; one type for every backend.
#[derive(Clone, Debug, Default, PartialEq, Serialize)]
pub struct Stats {
    pub stages: Vec<StageTime>,
    pub patches: u64,
    pub patches_visible: u64,
    /// Pieces that were drawn: visible patches, or parts of them where they were split.
    pub leaves: u64,
    pub meshlets: u64,
    pub quads: u64,
    pub triangles: u64,
    pub filled: u64,
    pub drawn: u64,
    pub buffer_bytes: u64,
}

/// Why a frame could not be made.
#[derive(Clone, Debug, PartialEq, Error)]
pub enum RenderError {
    #[error("{0}")]
    Todo(String),
}

/// A finished frame.
#[derive(Debug)]
pub struct Frame {
    pub camera: Camera,
    pub options: Options,
    pub stats: Stats,
}

/// Draws a scene; keeps its buffers from frame to frame.
#[derive(Debug)]
pub struct Renderer<'a> {
    scene: &'a Scene,
}

impl<'a> Renderer<'a> {
    pub fn new(scene: &'a Scene) -> Self {
        Self { scene }
    }

    /// Draws one frame.
    pub fn render(&mut self, camera: &Camera, options: &Options) -> Result<Frame, RenderError> {
        let _ = (self.scene, camera, options);
        Err(RenderError::Todo("not written yet".into()))
    }
}

impl Frame {
    /// What pixel (x, y) shows; `None` where it is background.
    pub fn pixel(&self, _x: u32, _y: u32) -> Option<Pixel> {
        None
    }

    /// Linear RGBA of pixel (x, y).
    pub fn color(&self, _x: u32, _y: u32) -> [f32; 4] {
        [0.0; 4]
    }
}
